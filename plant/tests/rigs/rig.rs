//! Whole rigs against exact solutions.

use crate::common::{RATE_HZ, STIFFNESS, gain_and_delay, moments, rig, run, spec, work};
use plant::{Rig, RigSpec};

const TAU: f64 = std::f64::consts::TAU;

#[test]
fn the_ideal_rig_is_where_it_was_told_to_be_and_pulls_back_like_a_spring() {
    for row in run(&RigSpec::default(), 0.5, |t| 0.05 * (13.0 * t).sin()) {
        assert_eq!(row.true_displacement, row.command);
        assert_eq!(row.displacement, row.command);
        assert_eq!(row.force, STIFFNESS * row.command);
    }
}

#[test]
fn four_milliseconds_at_two_kilohertz_are_exactly_eight_steps() {
    let rows = run(
        &spec("actuator = { kind = 'delay', delay_ms = 4 }"),
        0.5,
        |t| (40.0 * t).sin(),
    );
    for (i, row) in rows.iter().enumerate().skip(8) {
        assert_eq!(row.displacement, rows[i - 8].command);
    }
}

#[test]
fn every_lag_has_its_effective_delay_at_low_frequency() {
    let half_a_period = 0.5 / RATE_HZ;
    for (table, delay) in [
        ("kind = 'delay', delay_ms = 33.5", 0.0335),
        ("kind = 'delay', delay_ms = 4.13", 0.00413),
        ("kind = 'first_order', delay_ms = 12", 0.012 - half_a_period),
        (
            "kind = 'second_order', delay_ms = 12",
            0.012 - half_a_period,
        ),
        (
            "kind = 'second_order', delay_ms = 12, zeta = 1.1",
            0.012 - half_a_period,
        ),
        (
            "kind = 'lag_delay', delay_ms = 4.62, lag_ms = 22.2",
            0.02682 - half_a_period,
        ),
        (
            "kind = 'random_multiplier', delay_ms = 12, multiplier_sd = 0",
            0.012,
        ),
        (
            "kind = 'servo_hydraulic', delay_ms = 12",
            0.012 - half_a_period,
        ),
    ] {
        let omega = TAU * 0.1;
        let rows = run(&spec(&format!("actuator = {{ {table} }}")), 30.0, |t| {
            0.05 * (omega * t).sin()
        });
        let (gain, measured) = gain_and_delay(&rows, omega, 0.05, |r| r.displacement);
        assert!(
            (measured - delay).abs() < 2e-5,
            "{table}: {measured} s, expected {delay} s"
        );
        assert!((gain - 1.0).abs() < 1e-3, "{table}: gain {gain}");
    }
}

#[test]
fn the_measured_hydraulic_rig_of_the_audit_is_a_lag_and_a_delay() {
    // UTFSM: 22.2 ms and 4.62 ms give a gain of .43 and a delay of 16.5 ms at 15 Hz.
    let table = "actuator = { kind = 'lag_delay', delay_ms = 4.62, lag_ms = 22.2 }";
    let omega = TAU * 15.0;
    let rows = run(&spec(table), 4.0, |t| 0.01 * (omega * t).sin());
    let (gain, delay) = gain_and_delay(&rows, omega, 0.01, |r| r.displacement);
    assert!((gain - 0.43).abs() < 0.005, "{gain}");
    assert!((delay - 0.0165).abs() < 0.0005, "{delay}");
}

#[test]
fn a_gain_of_the_actuator_under_or_overshoots() {
    for row in run(&spec("actuator = { gain = 0.95 }"), 0.1, |t| t) {
        assert!((row.displacement - 0.95 * row.command).abs() < 1e-15);
    }
}

#[test]
fn the_delay_jumps_when_it_is_told_to() {
    let table =
        "actuator = { kind = 'delay', delay_ms = 4, delay_jump = { at_s = 0.25, delay_ms = 12 } }";
    let rows = run(&spec(table), 0.5, |t| t);
    assert_eq!(rows[499].displacement, rows[491].command);
    assert_eq!(rows[500].displacement, rows[476].command);
    for kind in [
        "first_order",
        "second_order",
        "random_multiplier",
        "servo_hydraulic",
    ] {
        let jump = "delay_jump = { at_s = 3.0, delay_ms = 20 }";
        let rows = run(
            &spec(&format!(
                "actuator = {{ kind = '{kind}', delay_ms = 10, {jump} }}"
            )),
            6.0,
            |t| 0.02 * t,
        );
        let behind = |from: usize| {
            let part = &rows[from..from + 1000];
            part.iter()
                .map(|r| (r.command - r.displacement) / 0.02)
                .sum::<f64>()
                / 1000.0
        };
        assert!(
            (behind(4800) - 0.010).abs() < 6e-4,
            "{kind}: {} s",
            behind(4800)
        );
        assert!(
            (behind(10_000) - 0.020).abs() < 9e-4,
            "{kind}: {} s",
            behind(10_000)
        );
    }
}

#[test]
fn static_storey_forces_are_those_of_the_shear_frame() {
    let k = [3e6, 2e6, 1.5e6, 1e6];
    let matrix = |i: usize, j: usize| {
        let above = |i: usize| k.get(i + 1).copied().unwrap_or(0.0);
        match i.abs_diff(j) {
            0 => k[i] + above(i),
            1 => -k[i.max(j)],
            _ => 0.0,
        }
    };
    for j in 0..k.len() {
        let mut rig = Rig::new(&RigSpec::default(), &k, RATE_HZ, 0).unwrap();
        let mut command = [0.0; 4];
        command[j] = 0.01;
        let force = rig.step(&command).force_n.clone();
        for i in 0..k.len() {
            assert!(
                (force[i] - 0.01 * matrix(i, j)).abs() < 1e-9,
                "row {i}, column {j}"
            );
        }
    }
}

#[test]
fn each_storey_yields_by_its_own_drift() {
    let spec = spec("specimen = { kind = 'bilinear', yield_mm = [10, 20], hardening_ratio = 0 }");
    let mut rig = Rig::new(&spec, &[1e6, 1e6], RATE_HZ, 0).unwrap();
    let force = &rig.step(&[0.015, 0.045]).force_n;
    // Shears 10 kN (yielded at 10 mm) and 20 kN (at 20 mm of a drift of 30).
    assert!((force[0] - (10e3 - 20e3)).abs() < 1e-6 && (force[1] - 20e3).abs() < 1e-6);
}

#[test]
fn a_physical_mass_is_read_as_inertia() {
    let omega = 15.0;
    let with = spec("specimen = { physical_mass_kg = 40 }");
    for row in &run(&with, 1.0, |t| 0.02 * (omega * t).sin())[4..] {
        let exact = (STIFFNESS - 40.0 * omega * omega) * row.command;
        assert!(
            (row.true_force - exact).abs() < 40.0 * omega.powi(2) * 0.02 * 1e-4,
            "{} s",
            row.t
        );
    }
}

#[test]
fn a_viscous_specimen_is_in_phase_with_velocity_and_dissipates_pi_c_omega_a2_a_cycle() {
    let damper = spec("specimen = { kind = 'viscous', damping_n_s_per_mm = 2 }");
    let (omega, a) = (TAU * 2.0, 0.03);
    let rows = run(&damper, 2.0, |t| a * (omega * t).sin());
    for row in &rows[4..] {
        let exact = 2000.0 * a * omega * (omega * row.t).cos();
        assert!((row.force - exact).abs() < 2000.0 * a * omega * 2e-5);
    }
    let cycle = &rows[2000..=3000];
    let exact = std::f64::consts::PI * 2000.0 * omega * a * a;
    assert!(
        (work(cycle) / exact - 1.0).abs() < 1e-4,
        "{} J, {exact} J",
        work(cycle)
    );
}

#[test]
fn no_specimen_gives_energy_over_closed_cycles() {
    for table in [
        "kind = 'linear'",
        "kind = 'bilinear', yield_mm = 10",
        "kind = 'bilinear', yield_mm = 10, hardening_ratio = 1",
        "kind = 'bouc_wen', yield_mm = 10, sharpness = 1.3, loop_shape = 0.9",
        "kind = 'viscous', damping_n_s_per_mm = 1",
        "kind = 'linear', physical_mass_kg = 100",
    ] {
        let specimen = spec(&format!("specimen = {{ {table} }}"));
        let rows = run(&specimen, 10.0, |t| {
            0.03 * t.min(5.0) / 5.0 * (TAU * 2.0 * t).sin()
        });
        for cycles in 11..20 {
            let sum = work(&rows[..=1000 * cycles]);
            // The trapezoidal rule on an elastic loop closes to rounding.
            assert!(sum > -2e-3, "{table}: {sum} J after {cycles} cycles");
        }
    }
}

#[test]
fn noise_offset_gain_and_hum_are_measured_as_specified() {
    let table = "sensors = { displacement_noise_mm = 0.2, force_noise_n = 50, displacement_offset_mm = 1.5, force_offset_n = -30 }";
    let rows = run(&spec(table), 60.0, |_| 0.0);
    let (mean, rms) = moments(rows.iter().map(|r| r.displacement * 1e3));
    assert!(
        (mean - 1.5).abs() < 0.005 && (rms / 0.2 - 1.0).abs() < 0.01,
        "{mean} {rms}"
    );
    let (mean, rms) = moments(rows.iter().map(|r| r.force));
    assert!(
        (mean + 30.0).abs() < 1.0 && (rms / 50.0 - 1.0).abs() < 0.01,
        "{mean} {rms}"
    );
    assert!(
        rows.iter()
            .all(|r| r.true_force == 0.0 && r.true_displacement == 0.0)
    );

    let table = "sensors = { displacement_hum_mm = 0.1, force_hum_n = 200, displacement_gain = 1.01, force_gain = 0.98 }";
    let rows = run(&spec(table), 2.0, |_| 0.1);
    let (mean, rms) = moments(rows.iter().map(|r| r.displacement * 1e3));
    assert!(
        (mean - 101.0).abs() < 1e-6 && (rms - 0.1 / 2f64.sqrt()).abs() < 1e-6,
        "{mean} {rms}"
    );
    let (mean, rms) = moments(rows.iter().map(|r| r.force));
    assert!(
        (mean - 0.98 * 15_800.0).abs() < 1e-5 && (rms - 200.0 / 2f64.sqrt()).abs() < 1e-5,
        "{mean} {rms}"
    );
}

#[test]
fn a_skew_makes_one_channel_later_than_the_other() {
    for (skew_ms, displacement_late, force_late) in [(0.5, 0, 1), (-1.5, 3, 0)] {
        let rows = run(
            &spec(&format!("sensors = {{ skew_ms = {skew_ms} }}")),
            0.2,
            |t| (30.0 * t).sin(),
        );
        for i in 3..rows.len() {
            assert_eq!(rows[i].displacement, rows[i - displacement_late].command);
            assert_eq!(rows[i].force, rows[i - force_late].true_force);
        }
    }
}

#[test]
fn bits_quantise_over_the_range_and_rails_are_reported() {
    let table = "sensors = { bits = 12, displacement_range_mm = 100, force_range_n = 10e3 }";
    let mut rig = rig(&spec(table));
    let (lsb_m, lsb_n) = (0.2 / 4096.0, 20e3 / 4096.0);
    for i in 0..500 {
        let reading = rig.step(&[0.05 * f64::from(i) / 500.0]);
        let (m, n) = (
            reading.displacement_m[0] / lsb_m,
            reading.force_n[0] / lsb_n,
        );
        assert!((m - m.round()).abs() < 1e-9 && (n - n.round()).abs() < 1e-9);
        assert!(
            (reading.displacement_m[0] - reading.true_displacement_m[0]).abs()
                <= 0.5 * lsb_m + 1e-12
        );
        assert!(!reading.at_rail);
    }
    assert!(rig.step(&[0.0999]).at_rail, "force: 15.8 kN of 10");
    assert!(rig.step(&[-0.2]).at_rail);
    assert!(!rig.step(&[0.0]).at_rail);
}

#[test]
fn a_seed_repeats_a_test_and_another_does_not() {
    let table = "actuator = { kind = 'random_multiplier', delay_ms = 4 }
                 sensors = { displacement_noise_mm = 0.1, force_noise_n = 9, force_coloured_noise_n = 5 }";
    let spec = spec(table);
    let trace = |seed| {
        let mut rig = Rig::new(&spec, &[1e6, 1e6], RATE_HZ, seed).unwrap();
        (0..500)
            .map(|i| rig.step(&[f64::from(i) * 1e-5, 0.001]).clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(trace(5), trace(5));
    assert_ne!(trace(5), trace(6));
    let first = &trace(5)[100];
    assert_ne!(
        first.displacement_m[0] - first.true_displacement_m[0],
        first.displacement_m[1] - first.true_displacement_m[1],
        "axes share their noise"
    );
}

#[test]
fn adding_a_source_leaves_the_noise_of_the_others_as_it_was() {
    let a = run(&spec("sensors = { force_noise_n = 9 }"), 0.1, |_| 0.0);
    let b = run(
        &spec("sensors = { force_noise_n = 9, displacement_noise_mm = 1 }"),
        0.1,
        |_| 0.0,
    );
    assert!(a.iter().zip(&b).all(|(a, b)| a.force == b.force));
}

#[test]
fn a_command_that_is_not_a_number_is_not_followed() {
    for effects in [
        "",
        "effects = [{ name = 'backlash', width_mm = 1 }, { name = 'coulomb_friction', force_n = 9 }]",
    ] {
        let mut rig = rig(&spec(effects));
        let held = rig.step(&[0.01]).true_displacement_m[0];
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(rig.step(&[bad]).true_displacement_m[0], held);
        }
    }
}

#[test]
fn a_rig_can_be_as_slow_as_a_conventional_test() {
    let rig = Rig::new(&RigSpec::default(), &[STIFFNESS], 1.0, 0);
    assert!(rig.is_ok());
}

#[test]
fn the_ideal_of_a_rig_keeps_its_specimen_and_nothing_else() {
    let table = "actuator = { kind = 'delay', delay_ms = 4 }
                 specimen = { kind = 'bilinear', yield_mm = 12, physical_mass_kg = 9 }
                 sensors = { force_noise_n = 5, bits = 12 }
                 effects = [{ name = 'coulomb_friction', force_n = 20 }]";
    let motion = |t: f64| 0.03 * (9.0 * t).sin();
    let specimen = spec("specimen = { kind = 'bilinear', yield_mm = 12 }");
    let ideal = run(&spec(table).ideal(), 1.0, motion);
    for (a, b) in ideal.iter().zip(run(&specimen, 1.0, motion)) {
        assert_eq!((a.displacement, a.force), (b.displacement, b.force));
    }
}
