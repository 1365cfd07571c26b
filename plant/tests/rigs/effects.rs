//! Every effect of the catalogue: it can be added to any rig by name, and does in its channel what its name says.

use crate::common::{RATE_HZ, Row, STIFFNESS, gain_and_delay, run, spec, work};
use plant::{Channel, Effect, EffectSpec, RigSpec, catalogue};

const TAU: f64 = std::f64::consts::TAU;

fn with(effect: Effect, parameters: &[(&str, f64)]) -> RigSpec {
    RigSpec::default()
        .with_effect(effect, parameters)
        .unwrap_or_else(|e| panic!("{e}"))
}

fn sine(t: f64) -> f64 {
    0.03 * (TAU * 2.0 * t).sin()
}

/// A value that shows for each parameter that has to be given.
fn telling(name: &str) -> f64 {
    match name {
        "delay_ms" | "lag_ms" => 5.0,
        "frequency_hz" => 20.0,
        "skew_ms" | "width_mm" | "gap_mm" => 3.0,
        "error" | "difference" => 0.1,
        "change" => 0.5,
        "offset_mm" | "rate_mm_per_s" | "error_mm" | "step_mm" | "amplitude_mm" => 0.5,
        "offset_n" | "rate_n_per_s" | "force_n" | "step_n" | "amplitude_n" | "slip_n" => 300.0,
        "stiffness_n_per_mm" => 1000.0,
        "yield_mm" | "reference_mm" => 15.0,
        "limit_mm" => 20.0,
        "limit_n" => 3000.0,
        "mass_kg" => 50.0,
        "rms_mm" => 0.5,
        "rms_n" => 300.0,
        "damping_n_s_per_mm" => 1.0,
        "damping_n_s2_per_mm2" => 0.01,
        "relaxation_ms" => 30.0,
        other => panic!("no value for {other}"),
    }
}

fn telling_spec(effect: Effect, channel: Channel) -> EffectSpec {
    let parameters: Vec<(&str, f64)> = effect
        .entry()
        .parameters
        .iter()
        // Of two sizes of a degradation one has to be given.
        .filter(|p| p.default.is_none() || p.name == "reference_mm")
        .filter(|p| p.channel.is_none_or(|own| own == channel))
        .map(|p| {
            (
                p.name,
                if effect == Effect::RateLimit {
                    200.0
                } else {
                    telling(p.name)
                },
            )
        })
        .collect();
    EffectSpec::new(effect, &parameters).in_channel(channel)
}

fn rms(rows: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = rows.fold((0.0, 0.0), |(s, n), x| (s + x * x, n + 1.0));
    f64::sqrt(sum / n)
}

#[test]
fn each_effect_shows_in_its_channel_and_in_no_other() {
    for base in [
        "",
        "actuator = { kind = 'lag_delay', delay_ms = 8, lag_ms = 10 }\nspecimen = { kind = 'bouc_wen', yield_mm = 20 }",
    ] {
        let plain = run(&spec(base), 2.0, sine);
        for entry in catalogue() {
            for channel in entry.channels {
                let mut spec = spec(base);
                spec.effects.push(telling_spec(entry.effect, *channel));
                let rows = run(&spec, 2.0, sine);
                let name = format!("{} in the {channel} channel", entry.effect);
                let moved = rms(rows
                    .iter()
                    .zip(&plain)
                    .map(|(a, b)| a.displacement - b.displacement));
                let pulled = rms(rows.iter().zip(&plain).map(|(a, b)| a.force - b.force));
                assert!(
                    rows.iter()
                        .all(|r| r.force.is_finite() && r.displacement.is_finite())
                );
                match channel {
                    Channel::Actuator => assert!(moved > 1e-4, "{name}: {moved} m"),
                    Channel::Specimen => {
                        assert!(pulled > 5.0, "{name}: {pulled} N");
                        assert!(moved < 1e-12, "{name} moves the actuator by {moved} m");
                    }
                }
            }
        }
    }
}

#[test]
fn effects_compose_in_any_number() {
    let mut all = spec("");
    for entry in catalogue() {
        for channel in entry.channels {
            all.effects.push(telling_spec(entry.effect, *channel));
        }
    }
    assert!(
        run(&all, 2.0, sine)
            .iter()
            .all(|r| r.force.is_finite() && r.true_displacement.is_finite())
    );
    let twice = RigSpec::default()
        .with_effect(Effect::CoulombFriction, &[("force_n", 20.0)])
        .and_then(|s| s.with_effect(Effect::CoulombFriction, &[("force_n", 30.0)]))
        .unwrap();
    let once = with(Effect::CoulombFriction, &[("force_n", 50.0)]);
    for (a, b) in run(&twice, 1.0, sine).iter().zip(run(&once, 1.0, sine)) {
        assert!((a.force - b.force).abs() < 1e-9);
    }
}

#[test]
fn timing_errors_go_into_the_element_that_they_are_errors_of() {
    let declared = spec(
        "actuator = { kind = 'lag_delay', delay_ms = 4, lag_ms = 20 }
         effects = [{ name = 'delay_error', delay_ms = -1.5 }, { name = 'lag_error', lag_ms = 7 }]",
    );
    let true_one = spec("actuator = { kind = 'lag_delay', delay_ms = 2.5, lag_ms = 27 }");
    let chirp = |t: f64| 0.01 * (30.0 * t * t).sin();
    for (a, b) in run(&declared, 2.0, chirp)
        .iter()
        .zip(run(&true_one, 2.0, chirp))
    {
        assert!((a.displacement - b.displacement).abs() < 1e-15);
    }
    // On a rig that has neither they are elements of their own.
    let both = spec(
        "effects = [{ name = 'lag_error', lag_ms = 7 }, { name = 'delay_error', delay_ms = 2.5 }]",
    );
    let elements = spec("actuator = { kind = 'lag_delay', delay_ms = 2.5, lag_ms = 7 }");
    for (a, b) in run(&both, 2.0, chirp)
        .iter()
        .zip(run(&elements, 2.0, chirp))
    {
        assert!((a.displacement - b.displacement).abs() < 1e-6 * 0.01);
    }
}

#[test]
fn a_second_lag_has_the_response_of_two_in_series() {
    let spec = spec(
        "actuator = { kind = 'lag_delay', lag_ms = 20 }
         effects = [{ name = 'second_lag', lag_ms = 5 }]",
    );
    let omega = TAU * 4.0;
    let (gain, _) = gain_and_delay(&run(&spec, 4.0, |t| (omega * t).sin()), omega, 1.0, |r| {
        r.displacement
    });
    let exact = 1.0 / ((1.0 + (omega * 0.02).powi(2)) * (1.0 + (omega * 0.005).powi(2))).sqrt();
    assert!((gain / exact - 1.0).abs() < 1e-3, "{gain} {exact}");
}

#[test]
fn an_oil_column_resonates() {
    let omega = TAU * 20.0;
    let rig = with(
        Effect::OilColumn,
        &[("frequency_hz", 20.0), ("damping_ratio", 0.08)],
    );
    let (gain, _) = gain_and_delay(&run(&rig, 4.0, |t| (omega * t).sin()), omega, 1.0, |r| {
        r.displacement
    });
    assert!((gain * 2.0 * 0.08 - 1.0).abs() < 5e-3, "{gain}");
}

#[test]
fn a_compliant_rig_is_a_spring_in_series() {
    let series = 1.0 / (1.0 / STIFFNESS + 1.0 / 1e6);
    let rows = run(
        &with(Effect::RigCompliance, &[("stiffness_n_per_mm", 1000.0)]),
        1.0,
        sine,
    );
    for r in &rows {
        assert!((r.displacement - r.command).abs() < 1e-15);
        assert!((r.force - series * r.command).abs() < 1e-6, "{} s", r.t);
    }
    let mut droop = RigSpec::default();
    droop.effects.push(
        EffectSpec::new(Effect::RigCompliance, &[("stiffness_n_per_mm", 1000.0)])
            .in_channel(Channel::Actuator),
    );
    for r in run(&droop, 1.0, sine) {
        assert!((r.force - STIFFNESS * r.displacement).abs() < 1e-6);
        assert!((r.force - series * r.command).abs() < 1e-6);
    }
    // Behind a yielding specimen the force is carried on from the last step: right to the change of stiffness in a step.
    let yielding = spec(
        "specimen = { kind = 'bilinear', yield_mm = 10, hardening_ratio = 0.1 }
         effects = [{ name = 'rig_compliance', stiffness_n_per_mm = 1000 }]",
    );
    let last = run(&yielding, 1.0, |t| 0.03 * t.min(0.5) / 0.5)[1999];
    let at = last.displacement - last.force / 1e6;
    let exact = STIFFNESS * (0.01 + 0.1 * (at - 0.01));
    assert!(
        (last.force - exact).abs() < 1e-3,
        "{} N, {exact} N",
        last.force
    );
}

#[test]
fn a_mass_behind_a_compliant_rig_is_a_mass_on_a_spring() {
    let spec = spec(
        "specimen = { physical_mass_kg = 60 }
         effects = [{ name = 'rig_compliance', stiffness_n_per_mm = 500 }, { name = 'viscous_damping', damping_n_s_per_mm = 3 }]",
    );
    for hz in [2.0, 8.0] {
        let omega = TAU * hz;
        let rows = run(&spec, 4.0, |t| 0.01 * (omega * t).sin());
        let (force, lag) = gain_and_delay(&rows, omega, 0.01, |r| r.true_force);
        // F = Z u k / (Z + k) with the specimen's Z = K - m w^2 + i w c.
        let (re, im) = (STIFFNESS - 60.0 * omega * omega, 3000.0 * omega);
        let k = 500e3;
        let exact = k * re.hypot(im) / (re + k).hypot(im);
        let lead = im.atan2(re) - im.atan2(re + k);
        assert!(
            (force / exact - 1.0).abs() < 2e-3,
            "{hz} Hz: {force} N/m, {exact} N/m"
        );
        assert!(
            (lag * omega + lead).abs() < 2e-3,
            "{hz} Hz: {} rad, {lead} rad",
            -lag * omega
        );
    }
}

#[test]
fn floors_that_give_way_together_stand_in_equilibrium() {
    let spec = spec("effects = [{ name = 'rig_compliance', stiffness_n_per_mm = 300 }]");
    let (k, g) = (1e6, 1.0 / 300e3);
    let mut rig = plant::Rig::new(&spec, &[k, k, k], RATE_HZ, 0).unwrap();
    let mut reading = plant::Reading::default();
    for i in 1..=20 {
        reading = rig.step(&[0.01 * f64::from(i) / 20.0, 0.0, -0.005]).clone();
    }
    let x: Vec<f64> = (0..3)
        .map(|j| reading.displacement_m[j] - g * reading.force_n[j])
        .collect();
    for j in 0..3 {
        let above = x.get(j + 1).map_or(0.0, |up| k * (up - x[j]));
        let below = if j == 0 { 0.0 } else { x[j - 1] };
        assert!((reading.force_n[j] - (k * (x[j] - below) - above)).abs() < 1e-5);
        assert!(
            (reading.displacement_m[j] - [0.01, 0.0, -0.005][j]).abs() < 1e-11,
            "floor {j}"
        );
    }
}

#[test]
fn yielding_as_an_effect_is_that_of_a_yielding_specimen() {
    for (effect, kind) in [
        (Effect::BilinearHysteresis, "bilinear"),
        (Effect::BoucWenHysteresis, "bouc_wen"),
    ] {
        let specimen = spec(&format!(
            "specimen = {{ kind = '{kind}', yield_mm = 12, hardening_ratio = 0.1 }}"
        ));
        let added = with(effect, &[("yield_mm", 12.0), ("hardening_ratio", 0.1)]);
        for (a, b) in run(&specimen, 1.0, sine).iter().zip(run(&added, 1.0, sine)) {
            assert!((a.force - b.force).abs() < 1e-8, "{kind}");
        }
    }
}

/// Energy that a steady cycle of the effect takes, J, on the linear specimen.
fn cycle_loss(effect: Effect, parameters: &[(&str, f64)]) -> f64 {
    let rows: Vec<Row> = run(&with(effect, parameters), 1.5, sine);
    work(&rows[1250..=2250])
}

#[test]
fn what_dissipates_takes_the_energy_that_its_equation_says() {
    let (a, omega) = (0.03, TAU * 2.0);
    for (name, measured, exact) in [
        (
            "coulomb",
            cycle_loss(
                Effect::CoulombFriction,
                &[("force_n", 100.0), ("presliding_mm", 0.1)],
            ),
            4.0 * 100.0 * (a - 1e-4),
        ),
        (
            "viscous",
            cycle_loss(Effect::ViscousDamping, &[("damping_n_s_per_mm", 0.5)]),
            std::f64::consts::PI * 500.0 * omega * a * a,
        ),
        (
            "quadratic",
            cycle_loss(Effect::QuadraticDamping, &[("damping_n_s2_per_mm2", 0.01)]),
            8.0 / 3.0 * 1e4 * omega * omega * a * a * a,
        ),
        (
            "slip",
            cycle_loss(Effect::SlipGap, &[("gap_mm", 4.0), ("slip_n", 500.0)]),
            2.0 * 500.0 * 0.004,
        ),
        (
            "maxwell",
            cycle_loss(
                Effect::MaxwellDamper,
                &[("stiffness_n_per_mm", 20.0), ("relaxation_ms", 50.0)],
            ),
            {
                let wt = omega * 0.05;
                std::f64::consts::PI * a * a * 20e3 * wt / (1.0 + wt * wt)
            },
        ),
    ] {
        assert!(
            (measured / exact - 1.0).abs() < 2e-3,
            "{name}: {measured} J, {exact} J"
        );
    }
    for (name, loss) in [
        (
            "hardening",
            cycle_loss(Effect::Hardening, &[("reference_mm", 20.0)]),
        ),
        (
            "softening",
            cycle_loss(Effect::Softening, &[("reference_mm", 20.0)]),
        ),
        (
            "damage, behind the first cycle,",
            cycle_loss(Effect::Degradation, &[("reference_mm", 20.0)]),
        ),
        (
            "asymmetric stiffness",
            cycle_loss(Effect::AsymmetricStiffness, &[("difference", 0.3)]),
        ),
        (
            "rig compliance",
            cycle_loss(Effect::RigCompliance, &[("stiffness_n_per_mm", 500.0)]),
        ),
    ] {
        assert!(loss.abs() < 2e-3, "{name} is elastic, but takes {loss} J");
    }
}

#[test]
fn inertia_is_the_same_as_a_physical_mass() {
    let added = with(Effect::InertiaForce, &[("mass_kg", 30.0)]);
    let hung = spec("specimen = { physical_mass_kg = 30 }");
    for (a, b) in run(&added, 1.0, sine).iter().zip(run(&hung, 1.0, sine)) {
        assert_eq!(a.force, b.force);
    }
}

#[test]
fn limits_clip_position_velocity_and_force() {
    let rows = run(&with(Effect::Saturation, &[("limit_mm", 20.0)]), 1.0, sine);
    let top = rows.iter().map(|r| r.displacement).fold(0.0, f64::max);
    assert_eq!(top, 0.02);
    let rows = run(&with(Effect::Saturation, &[("limit_n", 3000.0)]), 1.0, sine);
    assert!(
        rows.iter().all(|r| r.force.abs() <= 3000.0) && rows.iter().any(|r| r.true_force > 4000.0)
    );
    let rows = run(
        &with(Effect::RateLimit, &[("rate_mm_per_s", 100.0)]),
        1.0,
        sine,
    );
    let fastest = rows
        .windows(2)
        .map(|w| (w[1].displacement - w[0].displacement).abs() * RATE_HZ)
        .fold(0.0, f64::max);
    assert!((fastest - 0.1).abs() < 1e-9, "{fastest} m/s");
}

#[test]
fn gaps_lose_motion() {
    let rows = run(&with(Effect::Backlash, &[("width_mm", 2.0)]), 1.0, sine);
    let top = rows.iter().map(|r| r.displacement).fold(0.0, f64::max);
    assert!((top - 0.029).abs() < 1e-12);
    let mut joint = RigSpec::default();
    joint.effects.push(
        EffectSpec::new(Effect::DeadBand, &[("width_mm", 4.0)]).in_channel(Channel::Specimen),
    );
    for r in run(&joint, 1.0, sine) {
        let deformed = (r.command.abs() - 0.002).max(0.0) * r.command.signum();
        assert!((r.force - STIFFNESS * deformed).abs() < 1e-9);
    }
}

#[test]
fn what_is_slow_needs_no_motion() {
    let drift = run(
        &with(Effect::Drift, &[("rate_n_per_s", 12.0)]),
        10.0,
        |_| 0.0,
    );
    assert!((drift[19_999].force - 120.0).abs() < 1e-9);
    let warm = run(
        &with(
            Effect::TemperatureGain,
            &[("change", -0.04), ("time_constant_s", 2.0)],
        ),
        20.0,
        |_| 0.01,
    );
    assert!(
        (warm[3999].force / (STIFFNESS * 0.01) - (1.0 - 0.04 * (1.0 - (-1.0_f64).exp()))).abs()
            < 1e-9
    );
}

#[test]
fn hum_has_its_harmonic_and_quantisation_its_lattice() {
    let rows = run(
        &with(
            Effect::MainsHum,
            &[
                ("amplitude_n", 10.0),
                ("frequency_hz", 60.0),
                ("third_harmonic", 0.3),
            ],
        ),
        2.0,
        |_| 0.0,
    );
    for (omega, amplitude) in [(TAU * 60.0, 10.0), (TAU * 180.0, 3.0), (TAU * 120.0, 0.0)] {
        let (found, _) = gain_and_delay(&rows, omega, 1.0, |r| r.force);
        assert!((found - amplitude).abs() < 1e-6, "{found} N, {amplitude} N");
    }
    for r in run(&with(Effect::Quantisation, &[("step_n", 50.0)]), 1.0, sine) {
        assert!(
            (r.force / 50.0).fract().abs() < 1e-9 && (r.force - r.true_force).abs() <= 25.0 + 1e-9
        );
    }
}

#[test]
fn one_axis_alone_can_have_an_effect() {
    let spec = spec("effects = [{ name = 'viscous_damping', damping_n_s_per_mm = 5, axis = 2 }]");
    let mut rig = plant::Rig::new(&spec, &[1e6, 1e6], RATE_HZ, 0).unwrap();
    let mut plain = plant::Rig::new(&RigSpec::default(), &[1e6, 1e6], RATE_HZ, 0).unwrap();
    // Both floors move as one: the second storey has no drift and no force; then it alone drifts.
    for i in 0..50 {
        let u = f64::from(i) * 1e-4;
        assert_eq!(rig.step(&[u, u]).force_n, plain.step(&[u, u]).force_n);
    }
    let force = rig.step(&[0.0049, 0.0050]).force_n[1] - plain.step(&[0.0049, 0.0050]).force_n[1];
    // First step of a drift of 0.1 mm: by backward differences 3/2 of its chord's velocity.
    assert!(
        (force - 5000.0 * 1.5 * 1e-4 * RATE_HZ).abs() < 1e-6,
        "{force} N"
    );
}
