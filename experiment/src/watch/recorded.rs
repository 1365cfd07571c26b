//! The watch over a record that is there already: every sample counts as a control step.

use super::report::WatchReport;
use super::running::TestWatch;
use super::told::{Scales, gaps, of_model};
use crate::failure::Failure;
use crate::trace::TestObserver;
use diagnosis::{Model, Recording};
use outerloop_core::watch::{Actions, AxisOrders, Instructions, Tap, steps_in_block};

/// What the watch would have said while `record` was measured, on a rig as `model` declares it.
///
/// # Errors
/// A record without displacement or motion; a model that cannot be watched.
pub fn of_record(model: &Model, record: &Recording) -> Result<WatchReport, Failure> {
    let (name, none) = (&record.name, vec![0.0; record.time_s.len()]);
    let Some(displacement_mm) = &record.displacement_mm else {
        return Err(Failure::input(format!(
            "{name}: has no displacement: accepted is a record with one, and with a command or a force"
        )));
    };
    let command_mm = record.command_mm.as_ref();
    // A force of which nothing is declared may be anything: a pressure, a torque, a share.
    let declared_force = record.force_n.as_ref().filter(|_| model.specimen.is_some());
    // What is not there stands at rest and is not watched.
    let force_n = declared_force.unwrap_or(&none);
    let moves = command_mm.unwrap_or(displacement_mm);
    let rate_hz = 1.0 / record.interval_s();
    let scales = Scales {
        rate_hz,
        omega_rad_per_s: mean_frequency(moves) * rate_hz,
        peak_m: 0.5e-3 * range(displacement_mm),
        // Without a declared stiffness: what turns the motion into the force.
        stiffness_n_per_m: 1e3 * (range(force_n) / range(displacement_mm)).max(f64::MIN_POSITIVE),
        alone: true,
        expected_ms: 0.0,
        noise: [0.0; 2],
    };
    let mut declared = of_model(model, &scales);
    declared.has_actuator &= command_mm.is_some();
    declared.has_specimen &= declared_force.is_some();
    let not_watched = gaps(&declared);
    let actions = Actions::default();
    let mut watch = TestWatch::over(Instructions { declared, actions }, not_watched)?;
    let mut tap = Tap::of(steps_in_block(rate_hz));
    let m = |mm: f64| (1e-3 * mm) as f32;
    for (i, &x) in displacement_mm.iter().enumerate() {
        watch.pass_step();
        if tap.add(m(moves[i]), m(x), force_n[i] as f32) {
            watch.judge(&[tap.close()], &mut [AxisOrders::NONE]);
        }
    }
    Ok(watch.report())
}

fn range(x: &[f64]) -> f64 {
    let largest = x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    largest - x.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Of a motion, rad a sample: its rms velocity over its rms way.
fn mean_frequency(x: &[f64]) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    let way: f64 = x.iter().map(|x| (x - mean).powi(2)).sum();
    let velocity: f64 = x.windows(3).map(|w| (0.5 * (w[2] - w[0])).powi(2)).sum();
    (velocity / way.max(f64::MIN_POSITIVE)).sqrt()
}
