//! The controllers under test, by name.

use super::core_method::CoreLoops;
use super::core_method::CoreSetup;
use super::interface::{Controller, DeclaredPlant};
use super::outside::{OUTSIDE, Outside};
use crate::Refused;
use crate::rths::case::Case;
use crate::rths::parameters::Parameters;
use crate::rths::shaking::Shaking;
use outerloop_core::{Accepted, Method, Prediction};

/// A controller by its name, with its settings.
///
/// The name of a method of core may carry settings: `amb/lead=1` leads the target by a sample to compensate the known delay of
/// the force, `hydraulic/mu=1.5` corrects that delay in a copy of the numerical part instead, and `/stiffness=0.7` declares 0.7
/// times the specimen's stiffness.
#[derive(Clone)]
pub struct Contestant {
    /// Its name.
    pub name: String,
    who: Who,
    /// Samples by which the target is led.
    lead_steps: f64,
    /// Delay of the force that is corrected, samples.
    late_steps: f64,
    /// Declared over true stiffness of the nominal specimen.
    stiffness: f64,
}

#[derive(Clone, Copy)]
enum Who {
    Outside(&'static Outside),
    Core(Method),
}

/// Rows of the table in addition to the published controllers and core's methods without settings.
const WITH_SETTINGS: [&str; 9] = [
    "tangent+ats",
    "tangent+feedforward-feedback",
    "amb/lead=1",
    "hydraulic/lead=1",
    "amb/mu=1.5",
    "hydraulic/mu=0.78/lead=0.5",
    "hydraulic/mu=1.5",
    "hydraulic/mu=1.5/stiffness=0.7",
    "hydraulic/mu=1.5/stiffness=1.3",
];

impl Contestant {
    /// The published controllers, every method of core, and core's best methods with settings.
    pub fn all() -> Vec<Self> {
        let core = Method::ALL.into_iter().map(Method::name);
        OUTSIDE
            .iter()
            .map(|o| o.name)
            .chain(core)
            .chain(WITH_SETTINGS)
            .filter_map(|name| Self::named(name).ok())
            .collect()
    }

    /// A controller of another crate for [`crate::rths::Benchmark`], as in `benchmarks/examples/your_controller.rs`.
    pub fn from_outside(outside: &'static Outside) -> Self {
        Self {
            name: outside.name.to_owned(),
            who: Who::Outside(outside),
            lead_steps: 0.0,
            late_steps: 0.0,
            stiffness: 1.0,
        }
    }

    /// The controller of a name.
    ///
    /// # Errors
    /// An unknown name or setting.
    pub fn named(name: &str) -> Result<Self, Refused> {
        let mut parts = name.split('/');
        let own = parts.next().unwrap_or_default();
        let outside = OUTSIDE.iter().find(|o| o.name == own).map(Who::Outside);
        let who = outside.or_else(|| Method::from_name(own).map(Who::Core));
        let mut found = Self {
            name: name.to_owned(),
            who: who.ok_or_else(|| {
                let outside = OUTSIDE.map(|o| o.name).join(", ");
                Refused::new(format!(
                    "the controller `{own}` is unknown: accepted are {outside}, {Accepted}"
                ))
            })?,
            lead_steps: 0.0,
            late_steps: 0.0,
            stiffness: 1.0,
        };
        for part in parts {
            found.set(part)?;
        }
        Ok(found)
    }

    fn set(&mut self, setting: &str) -> Result<(), Refused> {
        let refused =
            |why: &str| Refused::new(format!("the controller `{}`: `{setting}` {why}", self.name));
        let value = setting
            .split_once('=')
            .and_then(|(key, text)| text.parse::<f64>().ok().map(|value| (key, value)));
        let (place, value, limits) = match value {
            Some(("lead", value)) => (&mut self.lead_steps, value, 0.0..=8.0),
            Some(("mu", value)) => (&mut self.late_steps, value, 0.0..=8.0),
            Some(("stiffness", value)) => (&mut self.stiffness, value, 0.1..=3.0),
            _ => {
                return Err(refused(
                    "is no setting: accepted are lead=STEPS, mu=STEPS and stiffness=FACTOR",
                ));
            }
        };
        if !limits.contains(&value) {
            return Err(refused(
                "is beyond what is accepted: 0 to 8 steps, a factor of 0.1 to 3",
            ));
        }
        *place = value;
        match self.who {
            Who::Core(_) => Ok(()),
            Who::Outside(_) => Err(refused("is a setting of core's methods")),
        }
    }

    /// What it knows besides the target and its readings.
    pub fn prior_knowledge(&self) -> &'static str {
        match self.who {
            Who::Outside(outside) => outside.prior_knowledge,
            Who::Core(method) => match (method.predictor, self.late_steps > 0.0) {
                (Prediction::Hydraulic, true) => "structure of plant, its spread, numerical part",
                (Prediction::Hydraulic, false) => "structure of plant, its spread",
                (Prediction::None, _) => "stiffness",
                (Prediction::Amb, true) => "actuator to begin with, numerical part",
                (Prediction::Amb, false) => "actuator to begin with",
                (Prediction::Ats, _) => "plant to begin with",
                (Prediction::FeedforwardFeedback, _) => "plant",
                (Prediction::ModelPrediction, _) => "delay, structure",
                _ => "delay",
            },
        }
    }

    /// True if core can do its own integration with it.
    pub fn integrates(&self) -> bool {
        matches!(self.who, Who::Core(_)) && self.late_steps == 0.0
    }

    /// An instance at rest, for one rig.
    ///
    /// # Errors
    /// What core refuses.
    pub fn make(&self, case: &Case) -> Result<Box<dyn Controller>, Refused> {
        let declared = self.declared(case);
        match self.who {
            Who::Outside(outside) => Ok((outside.make)(&declared)),
            Who::Core(method) => self.setup(&declared, method).behind(&declared),
        }
    }

    /// `L` instances that do their own integration; `None` if it cannot.
    ///
    /// # Errors
    /// What core refuses.
    pub fn loops<'a, const L: usize>(
        &self,
        case: &Case,
        shaking: &'a Shaking,
    ) -> Result<Option<CoreLoops<'a, L>>, Refused> {
        let declared = self.declared(case);
        match self.who {
            Who::Core(method) if self.integrates() => {
                let setup = self.setup(&declared, method);
                CoreLoops::new(&declared, &setup, shaking).map(Some)
            }
            _ => Ok(None),
        }
    }

    fn setup(&self, declared: &DeclaredPlant, method: Method) -> CoreSetup {
        CoreSetup::new(declared, method, self.lead_steps, self.late_steps)
    }

    fn declared(&self, case: &Case) -> DeclaredPlant {
        let mut plant = Parameters::NOMINAL;
        plant.specimen.stiffness_n_per_m *= self.stiffness;
        DeclaredPlant { case: *case, plant }
    }
}
