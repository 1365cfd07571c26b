//! A spring with a little damping: what is declared of it, and a record of it in two parts.

use diagnosis::{Declared, Model, Recording, SpecimenModel};

pub const STIFFNESS_N_PER_MM: f64 = 1000.0;
pub const DAMPING_N_S_PER_MM: f64 = 0.5;

pub fn declared() -> Model {
    let declared = |value, tolerance| Some(Declared { value, tolerance });
    Model {
        specimen: Some(SpecimenModel {
            stiffness_n_per_mm: declared(STIFFNESS_N_PER_MM, 20.0),
            damping_n_s_per_mm: declared(DAMPING_N_S_PER_MM, 0.2),
            mass_kg: declared(0.0, 0.5),
            offset_n: declared(0.0, 20.0),
            ..SpecimenModel::default()
        }),
        ..Model::default()
    }
}

/// The first three fifths of a record, to learn from, and the rest of it, to be judged on.
pub fn in_two(x_mm: &[f64], force_n: &[f64], interval_s: f64) -> [Recording; 2] {
    let split = 3 * x_mm.len() / 5;
    let part = |name: &str, from: usize, end: usize| Recording {
        name: name.into(),
        time_s: (from..end).map(|i| i as f64 * interval_s).collect(),
        displacement_mm: Some(x_mm[from..end].to_vec()),
        force_n: Some(force_n[from..end].to_vec()),
        ..Recording::default()
    };
    let train = part("train", 0, split);
    let mut test = part("test", split, x_mm.len());
    test.before = Some(Box::new(train.clone()));
    [train, test]
}
