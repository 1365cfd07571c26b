//! Rigs drawn around the one of a test: what differs, by which factors, and the test on each.

use crate::coupled::drawn::{numbers, of_declared, rig};
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::stability::perturbed::Spread;
use crate::stability::variation::Variation;

/// What of a rig is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnQuantity {
    /// Its name for people.
    pub name: String,
    /// The column of its factor in a table.
    pub column: String,
    /// Standard deviation of the factor.
    pub deviation: f64,
}

/// Rigs around the one of a test. Of two coupled actuators each number varies by itself, all times with the largest spread
/// that the test file declares for one; of others all times of the actuator together.
#[derive(Clone, Debug)]
pub struct DrawnRigs<'a> {
    around: &'a Experiment,
    spread: Spread,
    quantities: Vec<DrawnQuantity>,
    /// Empty for two coupled actuators.
    variations: Vec<Variation>,
}

impl<'a> DrawnRigs<'a> {
    /// Draws those of `spread`.
    pub fn around(around: &'a Experiment, spread: &Spread) -> Self {
        let Some(part) = &around.test.coupled else {
            let quantities = [
                ("times of the actuator", "actuator_times_1", spread.delay),
                ("gain of the actuator", "actuator_gain_1", spread.gain),
                (
                    "stiffness of the specimen",
                    "specimen_stiffness_1",
                    spread.stiffness,
                ),
            ];
            let quantities = quantities.map(|(name, column, deviation)| DrawnQuantity {
                name: name.into(),
                column: column.into(),
                deviation,
            });
            return Self {
                around,
                spread: *spread,
                quantities: quantities.into(),
                variations: spread.draw(),
            };
        };
        let spread = of_declared(&part.declared.spread, spread);
        let mut own = part.rig.clone();
        let varying = numbers(&mut own, &spread);
        let varying = varying.into_iter().filter(|n| n.varies());
        let quantities = varying.map(|n| DrawnQuantity {
            column: format!("{}_factor_1", n.key),
            name: n.key,
            deviation: n.deviation,
        });
        Self {
            around,
            spread,
            quantities: quantities.collect(),
            variations: Vec::new(),
        }
    }

    /// By how much they differ.
    pub fn spread(&self) -> &Spread {
        &self.spread
    }

    /// What differs.
    pub fn quantities(&self) -> &[DrawnQuantity] {
        &self.quantities
    }

    /// The factor of each quantity on rig `index`.
    pub fn factors(&self, index: usize) -> Vec<f64> {
        match &self.around.test.coupled {
            None => {
                let vary = &self.variations[index];
                vec![vary.delay, vary.gain, vary.stiffness]
            }
            Some(part) => rig(&part.rig, &self.spread, index as u64).1,
        }
    }

    /// The test on it.
    ///
    /// # Errors
    /// A test that cannot be laid out.
    pub fn test(&self, index: usize) -> Result<Experiment, Failure> {
        match &self.around.test.coupled {
            None => Ok(self.around.on_rig(&self.variations[index])),
            Some(part) => {
                let (rig, _) = rig(&part.rig, &self.spread, index as u64);
                self.around.on_coupled_rig(rig)
            }
        }
    }
}
