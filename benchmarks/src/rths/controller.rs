//! Who is on trial.

use super::case::Case;
use super::transfer::Parameters;
use crate::Refused;
use outerloop_core::config::{Adaptation, Compensation, Tangent};
use outerloop_core::{Method, Prediction};

/// A numerical part with a controller.
#[derive(Clone, Debug, PartialEq)]
pub enum Controller {
    /// The published one: PI with phase lead.
    Baseline,
    /// The tangent force behind the fixed inverse of the plant's model.
    TangentInverse,
    /// The tangent force behind the adaptive time series, which begins with the inverse of the plant's model.
    Best,
    /// One of core's methods on its own.
    Method(Method),
}

/// The name of [`Controller::Best`].
pub const BEST: &str = "tangent+ats";
/// The name of [`Controller::Baseline`].
pub const BASELINE: &str = "pi-phase-lead";

impl Controller {
    /// The baseline, the tangent force behind two predictors, and every method of core.
    pub fn all() -> Vec<Self> {
        [Self::Baseline, Self::Best, Self::TangentInverse]
            .into_iter()
            .chain(Method::ALL.map(Self::Method))
            .collect()
    }

    /// Its name in tables and on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Baseline => BASELINE,
            Self::Best => BEST,
            Self::TangentInverse => "tangent+inverse-model",
            Self::Method(method) => method.name(),
        }
    }

    /// By its name.
    ///
    /// # Errors
    /// A name that nobody has.
    pub fn named(name: &str) -> Result<Self, Refused> {
        let all = Self::all();
        let names: Vec<_> = all.iter().map(Self::name).collect();
        all.iter()
            .find(|c| c.name() == name)
            .cloned()
            .ok_or_else(|| {
                Refused::new(format!(
                    "the controller `{name}` is unknown: accepted are {}",
                    names.join(", ")
                ))
            })
    }
}

/// Delay of the nominal plant at the first natural frequency, ms: what methods that are told a delay are told.
fn delay_ms(case: &Case) -> f64 {
    let stiffness = case.reference().stiffness / case.mass_kg;
    let omega = nalgebra::SymmetricEigen::new(stiffness)
        .eigenvalues
        .min()
        .sqrt();
    -Parameters::NOMINAL.response(omega).arg() / omega * 1e3
}

/// What core is told for `method` alone: the same for all. Adaptive ones may learn in motions of a fifth of a
/// millimetre, and the time series from what moves below 8 Hz, twice the first natural frequency: above is noise.
pub fn compensation(case: &Case, method: Method) -> Compensation {
    let [_, a1, a2, a3, ..] = Parameters::NOMINAL.inverse();
    // The static part is in the calibration of the command.
    let gain = Parameters::NOMINAL.response(0.0).re;
    Compensation {
        kind: method,
        delay_ms: delay_ms(case),
        inverse: Some([a1, a2, a3].map(|a| a * gain)),
        adaptation: Adaptation {
            floor_m: 2e-4,
            longest_delay_ms: 60.0,
            smoothing_hz: 8.0,
            ..Adaptation::default()
        },
        tangent: Tangent {
            // The noise of both sensors is a per cent of the motion: a secant needs a good part of it.
            share: 0.3,
            smoothing_ms: 2.0,
            ..Tangent::default()
        },
        ..Compensation::default()
    }
}

/// The tangent force behind `predictor`.
pub fn tangent_behind(case: &Case, predictor: Prediction) -> Compensation {
    compensation(case, Method::Tangent.behind(predictor))
}
