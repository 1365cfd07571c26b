//! An outside controller as a table: its commands for a given table of strokes.
//!
//! The targets are the strokes of the reference structure, where a perfect test would have the actuators. The commands are
//! played on the nominal plant and judged by the resulting strokes. The loop is not closed: no force goes back into the
//! structure, so J8, which is about the storeys above, has no figure.

use super::bench::MarthsRecord;
use super::criteria::Criteria;
use super::rig::{ActuatorParameters, Channels, at_rest};
use super::trial::{MarthsTrace, interface};
use crate::Refused;

/// The targets of actuators 1 and 2 under `record`, m, one for each sample at 1024 Hz.
pub fn targets_m(record: &MarthsRecord) -> [Vec<f64>; 2] {
    let strokes = &record.reference().target_m;
    [0, 1].map(|i| strokes.iter().map(|s| s[i]).collect())
}

/// Judges the commands of actuators 1 and 2, m, one for each sample and held until the next. J8 is NaN.
///
/// # Errors
/// Numbers of commands and samples that differ.
pub fn judge(
    record: &MarthsRecord,
    commands_m: [&[f64]; 2],
    seed: u64,
) -> Result<Criteria, Refused> {
    let reference = record.reference();
    let samples = reference.target_m.len();
    if commands_m.iter().any(|c| c.len() != samples) {
        return Err(Refused::new(format!(
            "{} commands for the {samples} samples of {}: one a sample is accepted",
            commands_m[0].len(),
            record.name
        )));
    }
    let (mut rig, mut channels) = (
        at_rest(&ActuatorParameters::nominal()),
        Channels::new(seed, 1.0),
    );
    let mut trace = MarthsTrace {
        target_m: reference.target_m.clone(),
        numerical: reference.numerical.clone(),
        ..MarthsTrace::default()
    };
    for k in 0..samples {
        let stroke_m = rig.strokes_m();
        let read_m = channels.read(stroke_m);
        trace.read_m.push(read_m);
        trace.stroke_m.push(stroke_m);
        trace.interface.push(interface(read_m));
        let (sent_m, _) = channels.send(commands_m.map(|c| c[k]));
        rig.step(sent_m);
    }
    let mut criteria = Criteria::of(&trace, reference);
    criteria.j8 = [f64::NAN; 2];
    Ok(criteria)
}
