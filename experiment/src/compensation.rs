//! What a test is run under: a method of core, or, of two coupled actuators, how their commands are made.

use crate::coupled::table::CoupledCompensation;
use crate::failure::Failure;
use crate::method::method;
use outerloop_core::Method;

/// A compensation, of either kind of test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compensation {
    /// Of a test whose actuators each move a floor of their own.
    Method(Method),
    /// Of two coupled actuators.
    Coupled(CoupledCompensation),
}

impl Compensation {
    /// Its name in files and on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Method(method) => method.name(),
            Self::Coupled(kind) => kind.name(),
        }
    }

    /// Every compensation of a test; `coupled`: of two coupled actuators.
    pub fn all(coupled: bool) -> Vec<Self> {
        if coupled {
            CoupledCompensation::ALL.map(Self::Coupled).to_vec()
        } else {
            Method::ALL.iter().copied().map(Self::Method).collect()
        }
    }

    /// By its name; `coupled`: of two coupled actuators.
    ///
    /// # Errors
    /// A name that no compensation of such a test has.
    pub fn named(name: &str, coupled: bool) -> Result<Self, Failure> {
        if !coupled {
            return method(name).map(Self::Method);
        }
        CoupledCompensation::named(name)
            .map(Self::Coupled)
            .ok_or_else(|| {
                let names: Vec<&str> = CoupledCompensation::ALL.iter().map(|c| c.name()).collect();
                Failure::input(format!(
                    "the compensation `{name}` is unknown to coupled actuators: accepted are {}",
                    names.join(", ")
                ))
            })
    }
}

impl From<Method> for Compensation {
    fn from(method: Method) -> Self {
        Self::Method(method)
    }
}

impl From<CoupledCompensation> for Compensation {
    fn from(kind: CoupledCompensation) -> Self {
        Self::Coupled(kind)
    }
}
