//! Targets of the tangent force with adaptive prediction: eps_rms on every motion, 40 s, at 2 kHz.

use host_tests::{Scenario, Shaking, data, eps, table1};
use outerloop_core::Config;
use outerloop_core::Method;

const BILINEAR: &str = "kind = 'bilinear'\nhardening_ratio = 0.05\nyield_mm = ";

/// A yielding specimen with a second-order actuator; half of the delay is declared to the predictor.
fn bilinear(delay_ms: f64) -> Scenario {
    let mut s = Scenario::delayed(table1(), delay_ms).with(Method::Tangent);
    s.actuator = format!("kind = 'second_order'\ndelay_ms = {delay_ms:?}");
    s.specimen = format!("{BILINEAR}30.0");
    s.config.compensation.delay_ms = (0.5 * delay_ms).into();
    s
}

/// eps_rms of the worst floor on each motion.
fn errors<const N: usize>(s: &Scenario, seed: u64) -> Vec<f64> {
    let error = |(_, shaking): (_, Shaking)| {
        let (ideal, trace) = (
            s.ideal::<N>(&shaking, 40.0),
            s.run::<N>(&shaking, 40.0, seed),
        );
        (0..N)
            .map(|floor| eps(&trace, &ideal, floor).1)
            .fold(0.0, f64::max)
    };
    data::motions().into_iter().map(error).collect()
}

#[track_caller]
fn within<const N: usize>(what: &str, s: &Scenario, target: f64) {
    let errors = errors::<N>(s, 1);
    println!("{what}: {errors:.5?}, target {target}");
    assert!(errors.iter().all(|&e| e <= target), "{what}: {errors:?}");
}

#[test]
fn a_yielding_specimen_behind_a_second_order_actuator() {
    for (delay_ms, target) in [
        (4.0, 0.0005),
        (8.0, 0.001),
        (16.0, 0.004),
        (33.5, 0.008),
        (60.0, 0.015),
    ] {
        for told in [0.5, 1.0, 1.5] {
            let mut s = bilinear(delay_ms);
            s.config.compensation.delay_ms = (told * delay_ms).into();
            within::<1>(&format!("{delay_ms} ms, told {told} of it"), &s, target);
        }
    }
}

#[test]
fn a_linear_specimen_whatever_the_delay() {
    for kind in ["delay", "first_order", "second_order"] {
        for delay_ms in [4.0, 16.0, 33.5, 60.0] {
            let mut s = bilinear(delay_ms);
            s.specimen = "kind = 'linear'".into();
            s.actuator = format!("kind = '{kind}'\ndelay_ms = {delay_ms:?}");
            within::<1>(&format!("linear, {kind} {delay_ms} ms"), &s, 1e-4);
        }
    }
}

#[test]
fn a_delay_that_jumps_and_a_gain_that_is_wrong() {
    for kind in ["delay", "second_order"] {
        let mut s = bilinear(4.0);
        s.config.compensation.delay_ms = 4.0.into();
        s.actuator = format!(
            "kind = '{kind}'\ndelay_ms = 4.0\ndelay_jump = {{ at_s = 8.0, delay_ms = 12.0 }}"
        );
        within::<1>(&format!("{kind} 4 ms, 12 ms from 8 s on"), &s, 0.001);
    }
    for gain in [0.95, 1.05] {
        let mut s = bilinear(8.0);
        s.actuator += &format!("\ngain = {gain:?}");
        within::<1>(&format!("gain {gain}"), &s, 0.001);
    }
}

/// A tenth of the noise of the paper's sensors, 5 mm and 16 kN peak to peak, taken as six standard deviations.
#[test]
fn noise_costs_no_more_than_with_an_ideal_actuator() {
    let noise = "displacement_noise_mm = 0.0833\nforce_noise_n = 266.7";
    for delay_ms in [8.0, 33.5] {
        let mut real = bilinear(delay_ms);
        real.sensors = noise.into();
        let mut ideal = real.with(Method::None);
        ideal.actuator = "kind = 'ideal'".into();
        let mean = |s: &Scenario| {
            let runs: Vec<_> = (1..=6).map(|seed| errors::<1>(s, seed)).collect();
            let mean_on = |motion| runs.iter().map(|e| e[motion]).sum::<f64>() / 6.0;
            (0..runs[0].len()).map(mean_on).collect::<Vec<_>>()
        };
        let (with, floor) = (mean(&real), mean(&ideal));
        println!("{delay_ms} ms with noise: {with:.5?}, ideal actuator {floor:.5?}");
        for (with, floor) in with.into_iter().zip(floor) {
            assert!(with <= 1.10 * floor, "{with} of {floor}");
        }
    }
}

#[test]
fn three_storeys_that_yield() {
    for kind in ["delay", "second_order"] {
        let mut s = bilinear(4.0);
        s.config.structure = Config::shear_frame([1000.0; 3], [797.3e3; 3], [0.02; 3]).structure;
        s.actuator = format!("kind = '{kind}'\ndelay_ms = 4.0");
        s.specimen = format!("{BILINEAR}15.0");
        within::<3>(&format!("three storeys, {kind} 4 ms"), &s, 0.002);
    }
}
