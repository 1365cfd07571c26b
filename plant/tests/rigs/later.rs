//! Effects that begin in mid-test, and errors of a single sensor.

use crate::common::{RATE_HZ, STIFFNESS, run, spec};
use plant::{RigError, RigSpec};

const TAU: f64 = std::f64::consts::TAU;

fn sine(t: f64) -> f64 {
    0.03 * (TAU * t).sin()
}

/// `effect` on a rig with 8 ms and 10 ms, and the same from the start, beside the rig without it.
fn three(effect: &str, from_s: f64) -> [Vec<crate::common::Row>; 3] {
    let base = "actuator = { kind = 'lag_delay', delay_ms = 8, lag_ms = 10 }\n";
    let with = |more: &str| run(&spec(&format!("{base}{more}")), 3.0, sine);
    [
        with(&format!("effects = [{{ {effect}, from_s = {from_s} }}]")),
        with(&format!("effects = [{{ {effect} }}]")),
        with(""),
    ]
}

#[test]
fn until_it_begins_nothing_is_there_and_in_the_end_it_is_the_same_as_from_the_start() {
    for (effect, same_m) in [
        ("name = 'delay_error', delay_ms = 6", 1e-12),
        ("name = 'delay_error', delay_ms = -3.5", 1e-12),
        ("name = 'lag_error', lag_ms = 6", 1e-12),
        ("name = 'second_lag', lag_ms = 6", 1e-12),
        (
            "name = 'gain_error', error = 0.1, channel = 'actuator'",
            1e-12,
        ),
        (
            "name = 'gain_error', error = 0.1, sensor = 'displacement'",
            1e-12,
        ),
        ("name = 'gain_error', error = 0.1, sensor = 'force'", 1e-12),
        ("name = 'offset', offset_mm = 2", 1e-12),
        ("name = 'channel_skew', skew_ms = 4", 1e-12),
        ("name = 'channel_skew', skew_ms = -4", 1e-12),
        (
            "name = 'backlash', width_mm = 4, channel = 'specimen'",
            1e-12,
        ),
        (
            "name = 'backlash', width_mm = 4, channel = 'actuator'",
            1e-12,
        ),
        ("name = 'coulomb_friction', force_n = 500", 1e-12),
        ("name = 'rate_limit', rate_mm_per_s = 100", 1e-5),
        ("name = 'inertia_force', mass_kg = 200", 1e-12),
        ("name = 'rig_compliance', stiffness_n_per_mm = 1000", 1e-12),
        ("name = 'bouc_wen_hysteresis', yield_mm = 10", 1e-3),
        (
            "name = 'degradation', travel_mm = 1e-3, lost_share = 0.3",
            1e-4,
        ),
    ] {
        let [later, always, never] = three(effect, 0.83);
        let begins = (0.83 * RATE_HZ) as usize;
        let mut apart: f64 = 0.0;
        for (i, ((l, a), n)) in later.iter().zip(&always).zip(&never).enumerate() {
            // The clock begins with the first period in which the command has moved.
            if i <= begins {
                assert_eq!(
                    (l.displacement, l.force),
                    (n.displacement, n.force),
                    "{effect}, {i}"
                );
            } else if i > begins + 2000 {
                let x_m = (l.displacement - a.displacement).abs();
                let n_m = (l.force - a.force).abs() / STIFFNESS;
                assert!(
                    x_m.max(n_m) < same_m,
                    "{effect}: {x_m} m, {n_m} m at {}",
                    l.t
                );
                apart = apart.max((l.displacement - n.displacement).abs());
                apart = apart.max((l.force - n.force).abs() / STIFFNESS);
            }
        }
        assert!(apart > 5e-4, "{effect}: {apart} m is all that it does");
    }
}

#[test]
fn a_frozen_transducer_reads_on_what_it_read_with_its_noise_and_the_motion_goes_on() {
    let sensors = "sensors = { displacement_noise_mm = 0.01, force_noise_n = 5 }\n";
    for (sensor, own) in [("displacement", 0), ("force", 1)] {
        let frozen =
            format!("{sensors}effects = [{{ sensor = '{sensor}', frozen = true, from_s = 0.6 }}]");
        let rows = run(&spec(&frozen), 1.5, sine);
        let plain = run(&spec(sensors), 1.5, sine);
        let after = &rows[1210..];
        let read = |i: usize| {
            if own == 0 {
                after[i].displacement / 1e-5
            } else {
                after[i].force / 5.0
            }
        };
        let n = after.len();
        let mean = (0..n).map(read).sum::<f64>() / n as f64;
        let rms = ((0..n).map(|i| (read(i) - mean).powi(2)).sum::<f64>() / n as f64).sqrt();
        assert!((0.93..1.07).contains(&rms), "{sensor}: {rms} of its noise");
        // The other channel and the motion are what they were.
        for (a, b) in rows.iter().zip(&plain) {
            assert_eq!(
                (a.true_displacement, a.true_force),
                (b.true_displacement, b.true_force)
            );
            let other = if own == 0 {
                (a.force, b.force)
            } else {
                (a.displacement, b.displacement)
            };
            assert_eq!(other.0, other.1);
        }
    }
}

#[test]
fn a_sensor_of_its_own_leaves_the_motion_and_what_cannot_be_meant_is_refused() {
    let rows = run(
        &spec("effects = [{ name = 'gain_error', error = 0.1, sensor = 'displacement' }]"),
        1.0,
        sine,
    );
    for r in &rows {
        assert!((r.displacement - 1.1 * r.true_displacement).abs() < 1e-15);
        assert!((r.true_displacement - r.command).abs() < 1e-15);
    }
    let refused = |effect: &str| -> RigError {
        let spec: RigSpec = spec(&format!("effects = [{{ {effect} }}]"));
        plant::Rig::new(&spec, &[STIFFNESS], RATE_HZ, 1)
            .map(drop)
            .unwrap_err()
    };
    for (effect, said) in [
        ("name = 'offset', offset_mm = 1, from_s = -1", "from_s"),
        ("from_s = 1", "sensor"),
        ("frozen = true", "sensor"),
        ("name = 'offset', offset_mm = 1, frozen = true", "frozen"),
        (
            "name = 'backlash', width_mm = 1, sensor = 'force'",
            "sensor",
        ),
        ("name = 'delay_error', delay_ms = -3, from_s = 1", "delay"),
    ] {
        let e = refused(effect).to_string();
        assert!(e.contains(said), "{effect}: {e}");
    }
}

#[test]
fn the_clock_of_a_test_is_the_models_and_begins_where_it_is_told() {
    let text = "effects = [{ name = 'offset', offset_mm = 1, from_s = 0.5 }]";
    let mut rig = crate::common::rig(&spec(text));
    for _ in 0..300 {
        rig.step(&[0.0]);
    }
    rig.begin_test(2.0);
    for i in 0..3000 {
        let read = rig.step(&[0.0]).displacement_m[0];
        assert_eq!(read, if i < 2000 { 0.0 } else { 1e-3 }, "{i}");
    }
}
