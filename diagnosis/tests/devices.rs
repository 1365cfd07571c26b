//! Hysteresis of real devices, by equations that the diagnosis does not have: their names, or their plain family.
#![allow(missing_docs)]

mod forces;
mod spring;

use diagnosis::{ChannelAnswer, Declared, FoundEffect, Model, Verdict, diagnose};
use forces::{FINE, Moved};
use plant::{Effect, Family};
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use spring::{DAMPING_N_S_PER_MM, STIFFNESS_N_PER_MM, declared, in_two};

/// Samples of the fine grid to one of a record.
const EVERY: usize = 8;
/// Half of the motion's range, mm.
const PEAK: f64 = 20.0;

/// The answer for a force along a motion, with a noise of this share of its peak.
fn asked(m: &Moved, force: &[f64], model: &Model, noise: f64) -> ChannelAnswer {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    let top = force.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
    let mut read = |signal: &[f64], rms: f64| -> Vec<f64> {
        let mut white = || rms * Distribution::<f64>::sample(&StandardNormal, &mut random);
        signal.iter().step_by(EVERY).map(|s| s + white()).collect()
    };
    let x = read(&m.x, 3e-4 * PEAK);
    let y = read(force, noise * top);
    let [train, test] = in_two(&x, &y, FINE * EVERY as f64);
    let found = diagnose(model, &[train], &[test], &[]).expect("an answer");
    found.channels.into_iter().next().expect("the specimen")
}

fn beside_a_spring(m: &Moved, device: &[f64], noise: f64) -> ChannelAnswer {
    let kelvin = |(x, v): (&f64, &f64)| STIFFNESS_N_PER_MM * x + DAMPING_N_S_PER_MM * v;
    let both = m.x.iter().zip(&m.v).map(kelvin).zip(device);
    let force: Vec<f64> = both.map(|(k, f)| k + f).collect();
    asked(m, &force, &declared(), noise)
}

/// A device by itself, declared by these: N/mm and N s/mm, each with its tolerance.
fn alone(m: &Moved, device: &[f64], believed: [[f64; 2]; 2], noise: f64) -> ChannelAnswer {
    let mut model = declared();
    let specimen = model.specimen.as_mut().expect("a specimen");
    let [k, c] = believed.map(|[value, tolerance]| Some(Declared { value, tolerance }));
    specimen.stiffness_n_per_mm = k;
    specimen.damping_n_s_per_mm = c;
    specimen.mass_kg = None;
    asked(m, device, &model, noise)
}

/// All of an answer that a failed test should print.
fn said(a: &ChannelAnswer) -> String {
    let (members, nearest) = (&a.members, &a.nearest);
    format!("{:?} {:?} {members:?} {nearest:?}", a.verdict, a.effects)
}

fn names(a: &ChannelAnswer) -> Vec<Effect> {
    a.effects.iter().map(|e| e.name).collect()
}

/// A parameter of the effect of a name, within a share.
fn assert_has(a: &ChannelAnswer, name: Effect, key: &str, value: f64, within: f64) {
    let own = a.effects.iter().find(|e| e.name == name);
    let own = own.and_then(|e| e.parameters.iter().find(|p| p.name == key));
    let right = own.is_some_and(|p| (p.value / value - 1.0).abs() < within);
    assert!(right, "{key} {value}: {}", said(a));
}

#[test]
fn a_bumper_that_pushes_and_does_not_pull_is_told_with_its_dashpot() {
    let m = Moved::cycles(PEAK, 0.7);
    let a = beside_a_spring(&m, &forces::bumper(&m, 1500.0, 40.0, 8.3), 4e-3);
    let name = Effect::AsymmetricStiffness;
    assert_eq!(names(&a), [name], "{}", said(&a));
    assert_eq!(a.verdict, Verdict::Effect, "{}", said(&a));
    assert_has(&a, name, "above_mm", 8.3, 0.02);
    assert_has(&a, name, "stiffness_beyond_n_per_mm", 1500.0, 0.02);
    assert_has(&a, name, "damping_beyond_n_s_per_mm", 40.0, 0.05);
}

#[test]
fn a_contact_stands_where_it_stands_and_is_no_offset() {
    let m = Moved::shaken(PEAK, 0.7);
    let a = beside_a_spring(&m, &forces::bumper(&m, 1500.0, 0.0, 4.6), 2e-3);
    let name = Effect::AsymmetricStiffness;
    assert_eq!(names(&a), [name], "{}", said(&a));
    assert_has(&a, name, "above_mm", 4.6, 0.02);
}

#[test]
fn a_flag_is_a_part_by_its_family() {
    let m = Moved::shaken(PEAK, 0.4);
    let a = beside_a_spring(&m, &forces::flag(&m, 2000.0, [6000.0, 2000.0], 0.04), 8e-3);
    // The list has no name for a loop that comes back.
    assert_eq!(a.verdict, Verdict::Partial, "{}", said(&a));
    let name = Effect::BoucWenHysteresis;
    assert_eq!(names(&a), [name], "{}", said(&a));
    assert_has(&a, name, "yield_mm", 3.0, 0.05);
    assert_has(&a, name, "back_at_mm", 1.0, 0.05);
}

#[test]
fn a_device_that_yields_at_two_levels_is_bilinear_twice_and_no_friction() {
    let m = Moved::cycles(PEAK, 0.5);
    let force = forces::yields_twice(&m, [2000.0, 3000.0], [700.0, 5500.0]);
    let a = beside_a_spring(&m, &force, 4e-3);
    let name = Effect::BilinearHysteresis;
    assert_eq!(names(&a), [name], "{}", said(&a));
    assert_has(&a, name, "yield_mm", 5500.0 / 700.0, 0.05);
    assert_has(&a, name, "yield_beside_mm", 1.5, 0.05);
    assert_has(&a, name, "force_beside_n", 3000.0, 0.05);
}

#[test]
fn a_dashpot_that_is_not_there_is_said_to_be_so_beside_what_is() {
    let m = Moved::cycles(PEAK, 0.7);
    let force = forces::smooth_loop(&m, 3.0, 6000.0, |_, _| 1.0);
    let a = alone(&m, &force, [[0.0, 10.0], [100.0, 15.0]], 2e-3);
    let families: Vec<Family> = a.effects.iter().map(|e| e.family).collect();
    let both = [Family::Hysteresis, Family::Damping];
    assert_eq!(families, both, "{}", said(&a));
    assert_has(
        &a,
        Effect::ViscousDamping,
        "damping_n_s_per_mm",
        -100.0,
        0.02,
    );
}

/// Names of other families are not sure, and one of these is possible.
fn assert_is_of(a: &ChannelAnswer, families: &[Family], device: &str) {
    let of = |name: Effect| families.contains(&name.entry().family);
    let strange = |e: &&FoundEffect| !of(e.name) && e.q.is_some_and(|q| q < 0.2);
    assert!(
        !a.effects.iter().any(|e| strange(&e)),
        "{device}: {}",
        said(a)
    );
    let mut all = a
        .effects
        .iter()
        .map(|e| e.name)
        .chain(a.members.iter().map(|m| m.name));
    assert!(all.any(of), "{device}: {}", said(a));
}

#[test]
fn devices_without_a_name_of_their_own_have_their_plain_family() {
    use Family::{Damping, Friction, Gap, Hysteresis};
    let slow = Moved::cycles(PEAK, 0.5);
    let loops = [
        (
            "worn by the peak",
            forces::smooth_loop(&slow, 2.0, 8000.0, |x, _| 1.0 / (1.0 + (x / 15.0).powi(2))),
        ),
        (
            "worn by work",
            forces::smooth_loop(&slow, 2.0, 8000.0, |_, w| 1.0 / (1.0 + w / 3e6)),
        ),
        (
            "lead that heats",
            forces::smooth_loop(&slow, 1.0, 9000.0, |_, w| (-w / 3e6).exp()),
        ),
        (
            "slips and locks",
            forces::slip_lock(&slow, 3.0, 8000.0, 4.0),
        ),
        ("pinched", forces::pinched(&slow, 1000.0, 4000.0, 0.15)),
        ("rubber", forces::rubber(&slow, 1500.0, PEAK, 0.25)),
    ];
    for (device, force) in loops {
        let a = beside_a_spring(&slow, &force, 4e-3);
        assert_is_of(&a, &[Hysteresis, Friction, Gap], device);
    }
    let [k, yields] = [6000.0, 30_000.0];
    let force = forces::buckles(&slow, k, yields, 0.6 * yields);
    let a = alone(&slow, &force, [[k, 0.05 * k], [0.0, 10.0]], 4e-3);
    assert_is_of(&a, &[Hysteresis, Family::Stiffness], "buckles");
    let fast = Moved::cycles(PEAK, 0.9);
    let force = forces::magnetic(&fast, 1.5);
    let a = alone(&fast, &force, [[0.5, 0.5], [2.6, 0.5]], 4e-3);
    assert_is_of(&a, &[Hysteresis, Friction, Damping], "magnetorheological");
}
