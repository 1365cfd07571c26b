//! The `[plant.specimen]` table.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::bilinear::Bilinear;
use super::bouc_wen::BoucWen;
use super::storey::{Restoring, Storey};
use crate::effect::additions::Additions;
use crate::error::{Accept, RigError, refuse_stray};
use crate::per_axis::PerAxis;

/// The restoring force of a storey.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum SpecimenKind {
    /// `R = K x`.
    #[default]
    Linear,
    /// Bilinear with kinematic hardening: `yield_mm`, `hardening_ratio`.
    Bilinear,
    /// Bouc-Wen: `yield_mm`, `hardening_ratio`, `sharpness`, `loop_shape`.
    BoucWen,
    /// A dashpot, `R = c v`: `damping_n_s_per_mm`; with a spring beside it only where `stiffness_n_per_m` is given here.
    Viscous,
}

/// The `[plant.specimen]` table. Every number is one for all storeys or a list from the ground up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SpecimenSpec {
    /// Which restoring force.
    pub kind: SpecimenKind,
    /// Initial stiffness of a storey, N/m, 0 to 1e12; the structure's where it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness_n_per_m: Option<PerAxis>,
    /// Yield drift, mm, 1e-6 to 1e6; needed by `bilinear` and `bouc_wen`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yield_mm: Option<PerAxis>,
    /// Stiffness after yield over initial stiffness, 0 to 1; 0.05 where it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hardening_ratio: Option<PerAxis>,
    /// Exponent n of Bouc-Wen's knee, 0.5 to 50; 2 where it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sharpness: Option<f64>,
    /// Bouc-Wen's beta, 0.5 to 1, gamma being the rest to 1; 0.5 (straight unloading) where it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loop_shape: Option<f64>,
    /// Viscous damping beside the restoring force of any kind, N s/mm, 0 to 1e6.
    pub damping_n_s_per_mm: PerAxis,
    /// Mass that hangs on the load cell of each axis, kg, 0 to 1e9: it reads `m a` of the lab's motion as well.
    pub physical_mass_kg: PerAxis,
}

impl Default for SpecimenSpec {
    fn default() -> Self {
        Self {
            kind: SpecimenKind::Linear,
            stiffness_n_per_m: None,
            yield_mm: None,
            hardening_ratio: None,
            sharpness: None,
            loop_shape: None,
            damping_n_s_per_mm: 0.0.into(),
            physical_mass_kg: 0.0.into(),
        }
    }
}

const STIFFNESS: Accept = Accept::new(0.0, 1e12, "N/m");
const YIELD: Accept = Accept::new(1e-6, 1e6, "mm");
const RATIO: Accept = Accept::new(0.0, 1.0, "");
const SHARPNESS: Accept = Accept::new(0.5, 50.0, "");
const LOOP_SHAPE: Accept = Accept::new(0.5, 1.0, "");
const DAMPING: Accept = Accept::new(0.0, 1e6, "N s/mm");
const MASS: Accept = Accept::new(0.0, 1e9, "kg");

impl SpecimenSpec {
    /// The same without yielding; a dashpot remains.
    pub fn elastic(&self) -> Self {
        if self.kind == SpecimenKind::Viscous {
            return self.clone();
        }
        Self {
            stiffness_n_per_m: self.stiffness_n_per_m.clone(),
            damping_n_s_per_mm: self.damping_n_s_per_mm.clone(),
            physical_mass_kg: self.physical_mass_kg.clone(),
            ..Self::default()
        }
    }

    /// Initial stiffness of every storey, N/m, for the structure's `structure_n_per_m`.
    ///
    /// # Errors
    /// A stiffness out of range, by its path.
    pub fn stiffness(&self, structure_n_per_m: &[f64]) -> Result<Vec<f64>, RigError> {
        match &self.stiffness_n_per_m {
            Some(own) => own.resolve(
                "plant.specimen.stiffness_n_per_m",
                structure_n_per_m.len(),
                STIFFNESS,
            ),
            None if self.kind == SpecimenKind::Viscous => Ok(vec![0.0; structure_n_per_m.len()]),
            None => Ok(structure_n_per_m.to_vec()),
        }
    }

    /// Mass on every load cell, kg.
    pub(crate) fn mass(&self, axes: usize) -> Result<Vec<f64>, RigError> {
        self.physical_mass_kg
            .resolve("plant.specimen.physical_mass_kg", axes, MASS)
    }

    /// One element per storey, with the initial stiffness from [`SpecimenSpec::stiffness`].
    pub(crate) fn build(
        &self,
        stiffness_n_per_m: &[f64],
        additions: &[Additions],
    ) -> Result<Vec<Storey>, RigError> {
        self.refuse_what_the_kind_has_not()?;
        let axes = stiffness_n_per_m.len();
        let yields = matches!(self.kind, SpecimenKind::Bilinear | SpecimenKind::BoucWen);
        let yield_mm = match &self.yield_mm {
            Some(mm) => mm.resolve("plant.specimen.yield_mm", axes, YIELD)?,
            None if yields => {
                let accepted = format!("{YIELD} beside this plant.specimen.kind");
                return Err(RigError::new(
                    "plant.specimen.yield_mm",
                    "missing",
                    accepted,
                ));
            }
            None => Vec::new(),
        };
        let ratio = self.hardening_ratio.clone().unwrap_or(0.05.into());
        let ratio = ratio.resolve("plant.specimen.hardening_ratio", axes, RATIO)?;
        let sharpness = self.sharpness.unwrap_or(2.0);
        let sharpness = SHARPNESS.check("plant.specimen.sharpness", sharpness)?;
        let loop_shape = self.loop_shape.unwrap_or(0.5);
        let loop_shape = LOOP_SHAPE.check("plant.specimen.loop_shape", loop_shape)?;
        let path = "plant.specimen.damping_n_s_per_mm";
        let damping = self.damping_n_s_per_mm.resolve(path, axes, DAMPING)?;
        if self.kind == SpecimenKind::Viscous && damping.contains(&0.0) {
            return Err(RigError::new(
                path,
                0,
                "more than 0 beside plant.specimen.kind = \"viscous\"",
            ));
        }
        let storey = |j: usize| {
            let k = stiffness_n_per_m[j];
            let restoring = match self.kind {
                SpecimenKind::Linear | SpecimenKind::Viscous => Restoring::Linear {
                    stiffness_n_per_m: k,
                },
                SpecimenKind::Bilinear => {
                    Restoring::Bilinear(Bilinear::new(k, yield_mm[j] * 1e-3, ratio[j]))
                }
                SpecimenKind::BoucWen => Restoring::BoucWen(BoucWen::new(
                    k,
                    yield_mm[j] * 1e-3,
                    ratio[j],
                    sharpness,
                    loop_shape,
                )),
            };
            Storey {
                restoring,
                damping_n_s_per_m: damping[j] * 1e3,
                deformation: additions[j].deformation.clone(),
                added: additions[j].forces.clone(),
            }
        };
        Ok((0..axes).map(storey).collect())
    }

    fn refuse_what_the_kind_has_not(&self) -> Result<(), RigError> {
        use SpecimenKind::{Bilinear, BoucWen};
        let yields = [Bilinear, BoucWen].contains(&self.kind);
        let is_smooth = self.kind == BoucWen;
        let (both, smooth) = ("\"bilinear\" or \"bouc_wen\"", "\"bouc_wen\"");
        refuse_stray(
            "specimen",
            &[
                ("yield_mm", self.yield_mm.is_some() && !yields, both),
                (
                    "hardening_ratio",
                    self.hardening_ratio.is_some() && !yields,
                    both,
                ),
                ("sharpness", self.sharpness.is_some() && !is_smooth, smooth),
                (
                    "loop_shape",
                    self.loop_shape.is_some() && !is_smooth,
                    smooth,
                ),
            ],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_yielding_a_spring_is_left_and_a_dashpot_gets_none() {
        let yields = SpecimenSpec {
            kind: SpecimenKind::BoucWen,
            yield_mm: Some(3.0.into()),
            sharpness: Some(1.0),
            physical_mass_kg: 60.0.into(),
            ..SpecimenSpec::default()
        };
        let spring = SpecimenSpec {
            physical_mass_kg: 60.0.into(),
            ..SpecimenSpec::default()
        };
        assert_eq!(yields.elastic(), spring);
        let dashpot = SpecimenSpec {
            kind: SpecimenKind::Viscous,
            damping_n_s_per_mm: 2.0.into(),
            ..SpecimenSpec::default()
        };
        assert_eq!(dashpot.elastic().stiffness(&[158e3]), Ok(vec![0.0]));
    }
}
