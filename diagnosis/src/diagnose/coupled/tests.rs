use super::*;
use crate::model::coordinates::MATRICES;
use crate::model::declared::Declared;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

const STIFFNESS: [[f64; 2]; 2] = [[2.0e6, 0.6e6], [0.6e6, 1.1e6]];
const DAMPING: [[f64; 2]; 2] = [[800.0, 0.0], [0.0, 500.0]];
const MASS: [[f64; 2]; 2] = [[40.0, 0.0], [0.0, 6.0]];
const INTERVAL_S: f64 = 1e-3;

fn declared() -> CoupledSpecimen {
    let matrix = |m: [[f64; 2]; 2], tolerance: f64| {
        m.map(|row| row.map(|value| Declared { value, tolerance }).to_vec())
            .to_vec()
    };
    CoupledSpecimen {
        coordinates: vec!["x_m".into(), "rotation_rad".into()],
        stiffness: matrix(STIFFNESS, 2e4),
        damping: matrix(DAMPING, 50.0),
        mass: matrix(MASS, 0.5),
    }
}

/// Twenty seconds in which each coordinate moves by frequencies of its own, with noise on every reading.
fn record(seed: u64, hz: [&[f64]; 2], with_target: bool) -> CoupledRecord {
    let mut rng = <rand_xoshiro::Xoshiro256PlusPlus as rand_core::SeedableRng>::seed_from_u64(seed);
    let mut noise =
        move |size: f64| -> f64 { size * Distribution::<f64>::sample(&StandardNormal, &mut rng) };
    let mut r = CoupledRecord {
        name: "drawn".into(),
        interval_s: INTERVAL_S,
        displacement: vec![Vec::new(); 2],
        force: vec![Vec::new(); 2],
        target: with_target.then(|| vec![Vec::new(); 2]),
    };
    for k in 0..20_000 {
        let t = k as f64 * INTERVAL_S;
        let motion = [0, 1].map(|i| {
            hz[i].iter().enumerate().fold([0.0; 3], |m, (n, hz)| {
                let (w, phase) = (TAU * hz, TAU * hz * t + (n + 3 * i) as f64 + seed as f64);
                let x = 2e-3 / hz;
                [
                    m[0] + x * phase.sin(),
                    m[1] + x * w * phase.cos(),
                    m[2] - x * w * w * phase.sin(),
                ]
            })
        });
        for i in 0..2 {
            let force: f64 = (0..2)
                .map(|j| {
                    STIFFNESS[i][j] * motion[j][0]
                        + DAMPING[i][j] * motion[j][1]
                        + MASS[i][j] * motion[j][2]
                })
                .sum();
            r.displacement[i].push(motion[i][0] + noise(2e-6));
            r.force[i].push(30.0 + force + noise(10.0));
            if let Some(target) = &mut r.target {
                target[i].push(motion[i][0]);
            }
        }
    }
    r
}

const WIDE: [&[f64]; 2] = [&[0.7, 1.9, 4.3, 7.1], &[0.9, 2.6, 5.2, 8.3]];

fn ask(declared: &CoupledSpecimen, hz: [&[f64]; 2], with_target: bool) -> CoupledDiagnosis {
    let of = |seed| record(seed, hz, with_target);
    diagnose_coupled(declared, &[of(1)], &[of(2)]).unwrap()
}

#[test]
fn what_is_declared_rightly_is_left_alone() {
    let d = ask(&declared(), WIDE, true);
    for c in &d.coordinates {
        assert_eq!(c.verdict, CoupledVerdict::None, "{c:?}");
        assert!(
            c.wrong.is_empty() && c.error_after.test_nrmse < 0.02,
            "{c:?}"
        );
    }
    assert_eq!(d.improved, declared());
}

#[test]
fn one_wrong_entry_is_named_with_an_interval_that_holds() {
    for (which, k, factor) in [(0, 0, 2.0), (1, 1, 3.0), (2, 0, 5.0)] {
        let mut wrong = declared();
        let matrix = [&mut wrong.stiffness, &mut wrong.damping, &mut wrong.mass];
        let entry = &mut matrix.into_iter().nth(which).unwrap()[k][k];
        let truth = entry.value;
        entry.value *= factor;
        let d = ask(&wrong, WIDE, true);
        let [found] = &d.coordinates[k].wrong[..] else {
            panic!("{:?}", d.coordinates[k].wrong)
        };
        assert_eq!(
            (found.matrix, &found.by),
            (MATRICES[which], &wrong.coordinates[k])
        );
        assert!(found.alternatives.is_empty(), "{found:?}");
        let half = 0.5 * (found.ci90[1] - found.ci90[0]);
        // Two of the 90 % intervals: 99.9 %.
        assert!(
            (found.value - truth).abs() < 2.0 * half,
            "{found:?}, true {truth}"
        );
        assert!(half < 0.2 * truth, "{found:?}");
        let c = &d.coordinates[k];
        assert_eq!(c.verdict, CoupledVerdict::Effect);
        assert!(
            c.error_after.test_nrmse < 0.3 * c.error_before.test_nrmse,
            "{c:?}"
        );
        assert!(d.coordinates[1 - k].wrong.is_empty());
    }
}

#[test]
fn several_wrong_entries_are_all_named_each_with_its_probability() {
    let mut wrong = declared();
    wrong.stiffness[0][0].value *= 1.5;
    wrong.damping[1][1].value *= 3.0;
    wrong.mass[0][0].value *= 4.0;
    let d = ask(&wrong, WIDE, true);
    let named = |i: usize| -> Vec<&str> {
        let wrong = d.coordinates[i].wrong.iter();
        let mut names: Vec<&str> = wrong.map(|w| w.matrix).collect();
        names.sort_unstable();
        names
    };
    assert_eq!(named(0), ["mass", "stiffness"]);
    assert_eq!(named(1), ["damping"]);
    for c in &d.coordinates {
        assert_eq!(c.verdict, CoupledVerdict::Effect, "{c:?}");
        assert!(c.wrong.iter().all(|w| w.probability > 0.9), "{c:?}");
    }
}

#[test]
fn a_target_keeps_noise_from_making_a_mass_too_small() {
    let mut wrong = declared();
    wrong.mass[0][0].value = 400.0;
    let found = |with_target| {
        let d = ask(&wrong, WIDE, with_target);
        d.improved.mass[0][0].value
    };
    let (with, without) = (found(true), found(false));
    assert!(
        (with - 40.0).abs() < 0.5 && (with - 40.0).abs() <= (without - 40.0).abs() + 0.1,
        "{with} {without}"
    );
}

#[test]
fn stiffness_and_mass_at_one_frequency_cannot_be_told_apart() {
    let mut wrong = declared();
    wrong.mass[0][0].value = 400.0;
    let one: [&[f64]; 2] = [&[6.0], &[7.1]];
    let d = ask(&wrong, one, true);
    let c = &d.coordinates[0];
    assert_eq!(c.verdict, CoupledVerdict::Ambiguous, "{:?}", c.wrong);
    let [entry] = &c.wrong[..] else {
        panic!("{:?}", c.wrong)
    };
    let mut both = entry.alternatives.clone();
    both.push(format!("{} of x_m by {}", entry.matrix, entry.by));
    for name in ["stiffness of x_m by x_m", "mass of x_m by x_m"] {
        assert!(both.iter().any(|b| b == name), "{both:?}");
    }
}

#[test]
fn what_cannot_be_judged_is_refused_in_a_sentence() {
    let ok = record(1, WIDE, true);
    let refused = |model: &CoupledSpecimen, record: &CoupledRecord| {
        diagnose_coupled(
            model,
            std::slice::from_ref(record),
            std::slice::from_ref(&ok),
        )
        .unwrap_err()
        .to_string()
    };
    let mut model = declared();
    model.coordinates[1] = "rotation".into();
    assert!(refused(&model, &ok).contains("`rotation` says no unit"));
    let mut model = declared();
    model.mass[1].pop();
    assert!(refused(&model, &ok).contains("coupled.mass has rows of [2, 1] entries"));
    let mut still = ok.clone();
    still.displacement[1].fill(0.0);
    assert!(refused(&declared(), &still).contains("rotation_rad does not move"));
    let mut one = ok.clone();
    one.force.pop();
    assert!(refused(&declared(), &one).contains("force of 1 coordinates: accepted are 2"));
}
