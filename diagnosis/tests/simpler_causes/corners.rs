//! Corners of the motion, where a mass responds to what the samples do not show.

use super::spring::declared;
use super::{H, friction, recorded, said};
use diagnosis::{ChannelAnswer, Declared, Verdict, diagnose};

const MASS_KG: f64 = 400.0;

/// Back and forth at one speed, 10 mm either way, by an actuator that rounds its corners within 8 ms.
fn triangle(seconds: f64) -> Vec<f64> {
    let mut at = 0.0;
    let to = |i: usize| {
        let phase = (0.35 * i as f64 * H + 0.25).fract();
        at += H / 8e-3 * (10.0 * (1.0 - 4.0 * (phase - 0.5).abs()) - at);
        at
    };
    (0..(seconds / H) as usize).map(to).collect()
}

/// The force of the mass on the samples of a motion, N.
fn inertia(x: &[f64]) -> Vec<f64> {
    let acceleration = |i: usize| {
        let [a, b] = [i.saturating_sub(1), (i + 1).min(x.len() - 1)];
        (x[a] + x[b] - 2.0 * x[i]) / (H * H)
    };
    let force = |i: usize| 1e-3 * MASS_KG * acceleration(i);
    (0..x.len()).map(force).collect()
}

#[test]
fn what_a_mass_feels_at_corners_of_the_motion_is_no_unknown_and_friction_beside_it_is_not_lost() {
    let x = triangle(40.0);
    let inertia = inertia(&x);
    let mut model = declared();
    model.specimen.as_mut().expect("a specimen").mass_kg = Some(Declared {
        value: MASS_KG,
        tolerance: 20.0,
    });
    let asked = |more: &[f64]| {
        let [train, test] = recorded(&x, more);
        let found = diagnose(&model, &[train], &[test], &[]).expect("an answer");
        found.channels.into_iter().next().expect("the specimen")
    };
    let clean = asked(&inertia);
    assert_eq!(clean.verdict, Verdict::None, "{}", said(&clean));
    let told = clean
        .notes
        .iter()
        .any(|n| n.contains("corners of the motion"));
    assert!(told, "{:?}", clean.notes);
    let both: Vec<f64> = friction(&x, 300.0)
        .iter()
        .zip(&inertia)
        .map(|(f, i)| f + i)
        .collect();
    let rubs = asked(&both);
    assert_ne!(rubs.verdict, Verdict::None, "{}", said(&rubs));
    // Nor is it lost where the load cell is off within its tolerance, so that a rest is not at zero.
    model.specimen.as_mut().expect("a specimen").offset_n = Some(Declared {
        value: 0.0,
        tolerance: 200.0,
    });
    let rest = vec![0.0; (3.0 / H) as usize];
    let x = [&rest[..], &x, &rest].concat();
    let off: Vec<f64> = [&rest[..], &both, &rest].concat();
    let off: Vec<f64> = off.iter().map(|f| f + 300.0).collect();
    let [train, test] = recorded(&x, &off);
    let found = diagnose(&model, &[train], &[test], &[]).expect("an answer");
    let rubs = &found.channels[0];
    assert_ne!(rubs.verdict, Verdict::None, "{}", said(rubs));
}

/// A sweep from 0.5 Hz to 3 Hz, seen behind a play of 1.2 mm, with rests of 2 s.
fn behind_play(seconds: f64) -> Vec<f64> {
    let rest = (2.0 / H) as usize;
    let mut at = 0.0_f64;
    let sweep = |i: usize| {
        let t = i as f64 * H;
        let drive = 9.0 * (std::f64::consts::TAU * (0.5 + 1.25 * t / seconds) * t).sin();
        at = at.clamp(drive - 0.6, drive + 0.6);
        at
    };
    let mut x = vec![0.0; rest];
    x.extend((0..(seconds / H) as usize).map(sweep));
    let last = x[x.len() - 1];
    x.extend(vec![last; rest]);
    x
}

/// Two corners a cycle, up to six a second: in most of the motion they are near, and the rests tell the noise.
#[test]
fn a_mass_behind_a_play_is_no_unknown_although_corners_are_everywhere() {
    let x = behind_play(30.0);
    let mut model = declared();
    model.specimen.as_mut().expect("a specimen").mass_kg = Some(Declared {
        value: MASS_KG,
        tolerance: 20.0,
    });
    let [train, _] = recorded(&x, &inertia(&x));
    let y = behind_play(20.0);
    let [_, test] = recorded(&y, &inertia(&y));
    let found = diagnose(&model, &[train], &[test], &[]).expect("an answer");
    let a: &ChannelAnswer = &found.channels[0];
    assert_eq!(a.verdict, Verdict::None, "{} {:?}", said(a), a.notes);
}
