//! The rules of the problem, and the ways in which published codes deviate from them.

use crate::Refused;

/// The rules by which a trial is run and judged. The problem's own rules have no deviation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rules {
    deviations: Vec<Deviation>,
}

/// A way in which published codes, including ours, deviate from the problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Deviation {
    /// The force of the same sample goes into the numerical part; officially it is the force of the previous sample.
    NoUnitDelay,
    /// The numerical part is the reference minus the nominal specimen; officially minus the drawn one, so that the whole
    /// stays the reference.
    NominalNumericalPart,
    /// Criteria are root mean squares; officially standard deviations.
    RootMeanSquare,
    /// Ground motions are scaled by .5; officially by .4.
    HalfScale,
    /// A controller that estimates the displacement is judged by its estimate; officially by the reading.
    JudgedByEstimate,
    /// Plants are drawn uniformly within three standard deviations to either side; officially they are normal.
    UniformPlants,
    /// Core's loop integrates the equation of motion itself, with the force of the same sample.
    CoreIntegrates,
}

impl Deviation {
    /// All deviations.
    pub const ALL: [Self; 7] = [
        Self::NoUnitDelay,
        Self::NominalNumericalPart,
        Self::RootMeanSquare,
        Self::HalfScale,
        Self::JudgedByEstimate,
        Self::UniformPlants,
        Self::CoreIntegrates,
    ];

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoUnitDelay => "no-unit-delay",
            Self::NominalNumericalPart => "nominal-numerical-part",
            Self::RootMeanSquare => "root-mean-square",
            Self::HalfScale => "half-scale",
            Self::JudgedByEstimate => "judged-by-estimate",
            Self::UniformPlants => "uniform-plants",
            Self::CoreIntegrates => "core-integrates",
        }
    }
}

impl Rules {
    /// The problem's own rules.
    pub const fn official() -> Self {
        Self {
            deviations: Vec::new(),
        }
    }

    /// A simpler set: core integrates, with the force of the same sample; the numerical part is nominal; and the criteria are
    /// root mean squares.
    pub fn own() -> Self {
        Self {
            deviations: vec![
                Deviation::CoreIntegrates,
                Deviation::NominalNumericalPart,
                Deviation::RootMeanSquare,
            ],
        }
    }

    /// The rules with one more deviation, by its name.
    ///
    /// # Errors
    /// A name that no deviation has.
    pub fn with(mut self, name: &str) -> Result<Self, Refused> {
        let found = Deviation::ALL.into_iter().find(|d| d.name() == name);
        let deviation = found.ok_or_else(|| {
            let names = Deviation::ALL.map(Deviation::name).join(", ");
            Refused::new(format!(
                "the deviation `{name}` is unknown: accepted are {names}"
            ))
        })?;
        if !self.deviates(deviation) {
            self.deviations.push(deviation);
        }
        Ok(self)
    }

    /// True if they contain this deviation.
    pub fn deviates(&self, deviation: Deviation) -> bool {
        self.deviations.contains(&deviation)
    }

    /// The factor on a ground motion.
    pub fn ground_scale(&self) -> f64 {
        if self.deviates(Deviation::HalfScale) {
            0.5
        } else {
            0.4
        }
    }

    /// Their name: `official`, `own`, or `official` with its deviations.
    pub fn name(&self) -> String {
        if *self == Self::own() {
            return "own".into();
        }
        let mut name = String::from("official");
        for deviation in &self.deviations {
            name += " + ";
            name += deviation.name();
        }
        name
    }
}
