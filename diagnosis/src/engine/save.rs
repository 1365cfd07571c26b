//! Writes a fit into a model.

use crate::laws::specimen::SpecimenFit;
use crate::model::saved_element::SavedElement;
use crate::model::{Declared, Model};
use plant::Channel;

impl SpecimenFit {
    /// Writes the fit into the specimen's model: parameters that it declares or that have moved, and the elements
    /// beside them, each named by its entry in `owners`.
    pub fn save(&self, owners: &[plant::Effect], model: &mut Model) {
        let Some((places, _)) = model.channel_mut(Channel::Specimen) else {
            return;
        };
        for (i, place) in places.into_iter().enumerate() {
            if place.is_some() || self.moved[i] {
                let tolerance = place.map_or(0.0, |d: Declared| d.tolerance);
                *place = Some(Declared {
                    value: self.parameters[i],
                    tolerance,
                });
            }
        }
        let Some(specimen) = &mut model.specimen else {
            return;
        };
        for (&name, &(element, strength)) in owners.iter().zip(&self.elements) {
            specimen.elements.push(SavedElement {
                name,
                law: element.law,
                strength,
                shape: element.shape,
                reference_mm: self.sizes.x,
                reference_mm_per_s: self.sizes.v,
                cutoff_hz: Some(self.cutoff_hz).filter(|hz| hz.is_finite()),
                enabled: true,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::specimen::element::{Element, Law};
    use crate::laws::specimen::track::MotionScales;
    use crate::model::SpecimenModel;
    use plant::Effect::{CoulombFriction, MaxwellDamper};

    #[test]
    fn each_element_is_saved_under_its_own_name() {
        let element = |law, shape| Element { law, shape };
        let fit = SpecimenFit {
            parameters: [100.0, 0.0, 0.0, 0.0],
            moved: [false; 4],
            elements: vec![
                (element(Law::Slider, [0.2, 1.0, 0.0, 0.0]), 300.0),
                (element(Law::Relaxing, [0.1, 0.0, 0.0, 0.0]), 20.0),
            ],
            sizes: MotionScales::default(),
            cutoff_hz: 10.0,
        };
        let mut model = Model {
            specimen: Some(SpecimenModel::default()),
            ..Model::default()
        };
        fit.save(&[CoulombFriction, MaxwellDamper], &mut model);
        let saved = model.specimen.unwrap().elements;
        let names: Vec<_> = saved.iter().map(|e| (e.name, e.law)).collect();
        let both = [
            (CoulombFriction, Law::Slider),
            (MaxwellDamper, Law::Relaxing),
        ];
        assert_eq!(names, both);
    }
}
