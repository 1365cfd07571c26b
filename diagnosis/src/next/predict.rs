//! A model's response to a planned motion.

use crate::model::Model;
use crate::model::base::Base;
use crate::prepare::problem::Problem;
use crate::record::recording::Recording;
use plant::Channel;

/// A planned motion, or a recorded one.
#[derive(Clone, Copy, Debug)]
pub struct Planned<'a> {
    /// Sampling interval, s.
    pub interval_s: f64,
    /// Command or displacement, mm.
    pub input: &'a [f64],
    /// Force on the actuator, N, if known.
    pub force: Option<&'a [f64]>,
    /// Largest force over largest displacement of the records, N/mm: for a specimen without a stiffness of its own.
    pub n_per_mm: f64,
}

/// Response of one channel, mm or N; `None` if the model has no such channel.
pub fn answer(model: &Model, channel: Channel, planned: &Planned<'_>) -> Option<Vec<f64>> {
    let mut base = Base::of(model, channel)?;
    // A planned motion has no noise to be cut off.
    let elements = base.elements.iter_mut();
    elements.for_each(|e| e.cutoff_hz = None);
    let h = planned.interval_s;
    let input = planned.input;
    let force = match planned.force {
        Some(force) => force.to_vec(),
        None => input.iter().map(|x| planned.n_per_mm * x).collect(),
    };
    let record = Recording {
        time_s: (0..input.len()).map(|i| i as f64 * h).collect(),
        command_mm: Some(input.to_vec()),
        displacement_mm: Some(input.to_vec()),
        force_n: Some(force),
        ..Recording::default()
    };
    let motion = [Some(input.to_vec())];
    // Nothing is planned above a tenth of the rate.
    let problem = Problem::new(&base, &[record], 0.2 / h, &motion)?;
    problem.segments.into_iter().next().map(|s| s.signals.base)
}
