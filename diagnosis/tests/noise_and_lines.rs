//! What is noise and what is not: lines of the model alone, rests that move, a noise that is most of what is read, records of
//! unlike length.
#![allow(missing_docs)]

#[allow(dead_code, reason = "each file of tests uses a part of it")]
mod rig;

use diagnosis::{ChannelAnswer, Declared, Model, Recording, Verdict, diagnose, next, why_no_test};
use plant::{Effect, EffectSpec};
use rig::{RATE_HZ, model, record};
use std::f64::consts::TAU;

const TRUTH: [f64; 3] = [1000.0, 5.0, 22.0];

fn specimen_only() -> Model {
    Model {
        actuator: None,
        ..model()
    }
}

/// A line in a signal, at rest and in motion.
fn hums(signal: &mut Option<Vec<f64>>, hz: f64, amplitude: f64) {
    let samples = signal.iter_mut().flatten().enumerate();
    samples.for_each(|(i, x)| *x += amplitude * (TAU * hz * i as f64 / RATE_HZ).sin());
}

#[test]
fn a_held_out_record_longer_than_the_training_record_is_judged_with_its_lines() {
    let mut train = record(&[], TRUTH, 1).span(0.0, 14.0);
    let mut test = record(&[], TRUTH, 2);
    for r in [&mut train, &mut test] {
        hums(&mut r.force_n, 23.0, 60.0);
    }
    let d = diagnose(&specimen_only(), &[train], &[test], &[]).unwrap();
    let a = &d.channels[0];
    assert_eq!(a.verdict, Verdict::Unknown, "{:?}", a.notes);
    let lines = &a.remainder.as_ref().unwrap().lines;
    assert!(
        lines.iter().any(|l| (l.frequency_hz - 23.0).abs() < 0.5),
        "{lines:?}"
    );
}

#[test]
fn of_a_disturbance_in_the_rest_no_test_is_designed_and_that_is_said() {
    let [train, test] = [1, 2].map(|seed| {
        let mut r = record(&[], TRUTH, seed);
        hums(&mut r.force_n, 23.0, 60.0);
        [r]
    });
    // Beside an actuator that leaves nothing open, too.
    for declared in [specimen_only(), model()] {
        let d = diagnose(&declared, &train, &test, &[]).unwrap();
        let a = d.channels.last().unwrap();
        assert_eq!(a.verdict, Verdict::Unknown, "{:?}", a.notes);
        assert!(a.disturbed, "{:?}", a.notes);
        let refused = next(&declared, &d, &train, &test).unwrap_err().to_string();
        assert!(refused.contains("no test is proposed"), "{refused}");
        assert_eq!(why_no_test(&d), Some(refused));
    }
    // It is the disturbance that keeps the test back, and not the verdict.
    let d = diagnose(&specimen_only(), &train, &test, &[]).unwrap();
    let mut open = d.clone();
    open.channels[0].disturbed = false;
    assert_eq!(why_no_test(&open), None);
    assert!(next(&specimen_only(), &open, &train, &test).is_ok());
}

#[test]
fn what_a_mass_makes_of_the_displacements_noise_is_no_line_of_the_force() {
    let mass = Some(Declared {
        value: 85.0,
        tolerance: 3.0,
    });
    let mut declared = specimen_only();
    declared.specimen.as_mut().unwrap().mass_kg = mass;
    let inertia = EffectSpec::new(Effect::InertiaForce, &[("mass_kg", 85.0)]);
    let [train, test] = [3, 4].map(|seed| {
        let mut r = record(std::slice::from_ref(&inertia), TRUTH, seed);
        // 85 kg make 42 N of it, and the load cell has none.
        hums(&mut r.displacement_mm, 112.0, 1e-3);
        [r]
    });
    let d = diagnose(&declared, &train, &test, &[]).unwrap();
    let a = &d.channels[0];
    let lines: Vec<f64> = a
        .remainder
        .iter()
        .flat_map(|r| &r.lines)
        .map(|l| l.frequency_hz)
        .collect();
    assert!(lines.iter().all(|hz| (hz - 112.0).abs() > 2.0), "{lines:?}");
    assert!(a.notes.iter().all(|n| !n.contains("112")), "{:?}", a.notes);
    assert_eq!(a.verdict, Verdict::None, "{:?}", a.notes);
    // It stays where it is, and does not walk to the end of its tolerance.
    let saved = d.improved.specimen.as_ref().unwrap().mass_kg.unwrap();
    assert!((saved.value - 85.0).abs() < 0.6, "{saved:?}");
}

/// A soft spring beside friction that holds most of the force, in a loop that never rests.
fn hunting(seed: u64) -> Recording {
    let mut r = record(&[], [100.0, 5.0, 22.0], seed);
    let swing = |i: usize| 0.15 * (TAU * 6.0 * i as f64 / RATE_HZ).sin();
    let x = r.displacement_mm.as_mut().unwrap();
    let mut slides = 0.0_f64;
    let forces = r.force_n.as_mut().unwrap();
    let mut before = x[0];
    for (i, (x, f)) in x.iter_mut().zip(forces).enumerate() {
        let smooth = swing(i);
        *x += smooth;
        *f += 100.0 * smooth;
        let step = r.command_mm.as_ref().unwrap()[i] + smooth - before;
        before += step;
        slides = (slides + step / 0.05).clamp(-1.0, 1.0);
        *f += 300.0 * slides;
    }
    r
}

#[test]
fn a_rest_in_which_the_rig_moves_tells_no_noise() {
    let mut declared = specimen_only();
    let specimen = declared.specimen.as_mut().unwrap();
    specimen.stiffness_n_per_mm = Some(Declared {
        value: 100.0,
        tolerance: 1.0,
    });
    let d = diagnose(&declared, &[hunting(21)], &[hunting(22)], &[]).unwrap();
    let a = &d.channels[0];
    assert_ne!(a.verdict, Verdict::None, "{:?}", a.notes);
    assert!(a.noise_floor_rms < 40.0, "{}", a.noise_floor_rms);
    assert!(
        a.notes.iter().any(|n| n.contains("does not rest")),
        "{:?}",
        a.notes
    );
}

#[test]
fn a_noise_that_is_most_of_what_is_read_is_no_reason_to_say_that_nothing_is_missing() {
    let mut declared = specimen_only();
    let specimen = declared.specimen.as_mut().unwrap();
    specimen.stiffness_n_per_mm = Some(Declared {
        value: 1.0,
        tolerance: 0.1,
    });
    let friction = [("force_n", 4.0), ("presliding_mm", 0.05)];
    let friction = EffectSpec::new(Effect::CoulombFriction, &friction);
    let [train, test] = [31, 32].map(|seed| {
        [record(
            std::slice::from_ref(&friction),
            [1.0, 5.0, 22.0],
            seed,
        )]
    });
    let d = diagnose(&declared, &train, &test, &[]).unwrap();
    let a = &d.channels[0];
    assert!(a.error_before.test_nrmse > 0.5);
    assert_ne!(a.verdict, Verdict::None, "{:?}", a.notes);
}

#[test]
fn the_mains_in_an_actuators_reading_are_named() {
    let mut declared = model();
    declared.specimen = None;
    // Beside it something that no effect of the library explains alone.
    let overlap = EffectSpec::new(Effect::DeadBand, &[("width_mm", 0.15)]);
    let read = |seed, hum_mm| {
        let mut r = record(std::slice::from_ref(&overlap), TRUTH, seed);
        hums(&mut r.displacement_mm, 49.98, hum_mm);
        r.force_n = None;
        [r]
    };
    let (train, test) = (read(41, 0.2), read(42, 0.2));
    let d = diagnose(&declared, &train, &test, &[]).unwrap();
    let a = &d.channels[0];
    let hum = a.effects.iter().find(|e| e.name == Effect::MainsHum);
    let hum = hum.unwrap_or_else(|| panic!("{:?} {:?}", a.verdict, a.notes));
    assert!((hum.parameters[0].value - 0.2).abs() < 0.02, "{hum:?}");
    assert!(a.error_after.test_rms < 0.5 * a.error_before.test_rms);
    // Held-out data choose no name: these have no hum.
    let quiet = diagnose(&declared, &train, &read(42, 0.0), &[]).unwrap();
    let names = |a: &ChannelAnswer| a.effects.iter().map(|e| e.name).collect::<Vec<_>>();
    assert_eq!(names(&quiet.channels[0]), names(a));
}
