//! The next test, designed and played on rigs that are simulated here: what one speed cannot tell apart comes apart.
#![allow(missing_docs)]
#![cfg(not(debug_assertions))] // Minutes without optimisation.

use diagnosis::{
    Declared, Diagnosis, Model, Origin, Recording, RigLimits, SpecimenModel, Verdict, diagnose,
    next,
};
use plant::Effect;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

const H: f64 = 2e-3;

/// What is in the specimen beside its spring of 50 N/mm.
#[derive(Clone, Copy, Debug)]
enum Cause {
    /// 60 N, by LuGre's bristles.
    Friction,
    /// 3 N s/mm: as much at 20 mm/s.
    Viscous,
}

fn specimen(cause: Cause, x: &[f64], seed: u64) -> Recording {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut noise = |size: f64| size * Distribution::<f64>::sample(&StandardNormal, &mut rng);
    let mut bristle = 0.0_f64;
    let force: Vec<f64> = (0..x.len())
        .map(|i| {
            let v = (x[(i + 1).min(x.len() - 1)] - x[i.saturating_sub(1)]) / (2.0 * H);
            let beside = match cause {
                Cause::Friction => {
                    let stiffness = 600.0;
                    // An exact step of z' = v - |v| z / d.
                    let give = 60.0 / stiffness;
                    let decay = (-v.abs() * H / give).exp();
                    bristle = give * v.signum() * (1.0 - decay) + bristle * decay;
                    stiffness * bristle
                }
                Cause::Viscous => 3.0 * v,
            };
            50.0 * x[i] + beside + noise(2.0)
        })
        .collect();
    Recording {
        name: format!("{cause:?} {seed}"),
        time_s: (0..x.len()).map(|i| i as f64 * H).collect(),
        displacement_mm: Some(x.iter().map(|x| x + noise(0.002)).collect()),
        force_n: Some(force),
        ..Recording::default()
    }
}

/// To and fro at 20 mm/s, the corners rounded.
fn one_speed(seconds: f64, way_mm: f64) -> Vec<f64> {
    let period_s = 4.0 * way_mm / 20.0;
    let sharp = |t: f64| {
        let p = (t / period_s).rem_euclid(1.0);
        way_mm * (4.0 * (p - (p + 0.5).floor()).abs() - 1.0)
    };
    let rounded = |t: f64| {
        let near = (-10..=10).map(|k| sharp(t + 0.004 * f64::from(k)));
        near.sum::<f64>() / 21.0
    };
    (0..(seconds / H) as usize)
        .map(|i| rounded(i as f64 * H))
        .collect()
}

fn model() -> Model {
    let known = |value, tolerance| Some(Declared { value, tolerance });
    Model {
        specimen: Some(SpecimenModel {
            stiffness_n_per_mm: known(50.0, 0.5),
            offset_n: known(0.0, 1.0),
            ..SpecimenModel::default()
        }),
        limits: RigLimits {
            displacement_mm: Some(15.0),
            velocity_mm_per_s: Some(80.0),
            force_n: Some(1500.0),
        },
        ..Model::default()
    }
}

/// Cause among what is named or in the set.
fn holds(d: &Diagnosis, wanted: Effect) -> bool {
    let a = &d.channels[0];
    a.effects.iter().any(|e| e.name == wanted) || a.alternatives.contains(&wanted)
}

#[test]
fn one_speed_leaves_friction_and_viscosity_open_and_the_designed_test_settles_them() {
    for (cause, name) in [
        (Cause::Friction, Effect::CoulombFriction),
        (Cause::Viscous, Effect::ViscousDamping),
    ] {
        let train = specimen(cause, &one_speed(16.0, 10.0), 1);
        let held_out = specimen(cause, &one_speed(12.0, 8.0), 2);
        let ask = |train: &[Recording]| {
            diagnose(&model(), train, std::slice::from_ref(&held_out), &[]).unwrap()
        };
        let first = ask(std::slice::from_ref(&train));
        println!(
            "{cause:?}: {:?} {:?}",
            first.channels[0].verdict, first.channels[0].members
        );
        assert!(
            holds(&first, name),
            "{cause:?}: {:?}",
            first.channels[0].effects
        );
        let one = std::slice::from_ref(&train);
        let plan = next(&model(), &first, one, std::slice::from_ref(&held_out)).unwrap();
        let x = &plan.command_mm;
        let far = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let steps = x.windows(2).map(|w| (w[1] - w[0]).abs() / plan.interval_s);
        assert!(far <= 15.0 && steps.fold(0.0, f64::max) <= 80.0);
        assert_eq!(plan.limits.force_from, Origin::Declared);
        assert!(x[0] == 0.0 && x[x.len() - 1] == 0.0);
        let outlook = &plan.channels[0];
        assert!(outlook.candidates.iter().all(|c| c.peak.abs() <= 1500.0));
        println!("{:?} {:?}", plan.phases, outlook.squares_times);
        // As the rig plays it, at its own rate.
        let at = |t: f64| {
            let i = ((t / plan.interval_s) as usize).min(x.len() - 2);
            let part = (t / plan.interval_s - i as f64).min(1.0);
            x[i] + part * (x[i + 1] - x[i])
        };
        let played: Vec<f64> = (0..(plan.seconds / H) as usize)
            .map(|i| at(i as f64 * H))
            .collect();
        let second = specimen(cause, &played, 3);
        let both = ask(&[train, second]);
        let a = &both.channels[0];
        println!("{:?} {:?} {:?}", a.verdict, a.effects, a.members);
        assert!(
            matches!(a.verdict, Verdict::Effect | Verdict::Partial),
            "{cause:?}: {:?}",
            a.verdict
        );
        assert_eq!(a.effects[0].name, name, "{cause:?}");
    }
}

#[test]
fn without_limits_the_records_own_span_is_kept_and_that_is_said() {
    let mut free = model();
    free.limits = RigLimits::default();
    let train = [specimen(Cause::Friction, &one_speed(16.0, 10.0), 1)];
    let held_out = [specimen(Cause::Friction, &one_speed(12.0, 8.0), 2)];
    let found = diagnose(&free, &train, &held_out, &[]).unwrap();
    let plan = next(&free, &found, &train, &held_out).unwrap();
    assert_eq!(plan.limits.displacement_from, Origin::Record);
    let far = plan.command_mm.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    assert!(far <= 10.1, "{far}");
    let still = Recording {
        displacement_mm: Some(vec![0.0; train[0].time_s.len()]),
        ..train[0].clone()
    };
    let refused = next(&free, &found, std::slice::from_ref(&still), &held_out[..0]).unwrap_err();
    assert!(refused.to_string().contains("[limits]"), "{refused}");
}
