//! A path from command to displacement in the engine: its [`fit`] (least squares, and cross-validation by block), and
//! how it is [`save`]d.

mod fit;
mod save;

pub use fit::{ActuatorData, ActuatorFit, DECLARED, PartSet};

use crate::criteria::actuator::{A_CYCLE, MOST_SETTLING, SEARCHED, TOO_MANY};
use crate::laws::drivetrain::signal_path::Run;
use crate::model::base::Base;
use crate::numbers::signals::difference;
use crate::prepare::problem::Problem;
use crate::record::recording::Recording;
use crate::record::spectrum;
use crate::record::spectrum::motion_band_hz;

/// Number of samples averaged into one for a search.
pub fn thinning(whole: &ActuatorData, train: &[Recording]) -> usize {
    let band = train
        .iter()
        .filter_map(|r| motion_band_hz(r.displacement_mm.as_ref()?, r.interval_s()))
        .fold(0.0, f64::max);
    let samples = whole.target.len();
    let [fine, coarse] = A_CYCLE.map(|c| (1.0 / (c * band * whole.interval_s)).floor() as usize);
    samples
        .div_ceil(SEARCHED)
        .min(fine)
        .max(samples.div_ceil(TOO_MANY).min(coarse))
        .max(1)
}

/// Records without the contribution of effects that the model already has to the declared path's response.
pub fn without_known(base: &Base, records: &[Recording]) -> Option<Vec<Recording>> {
    if base.known.is_empty() {
        return Some(records.to_vec());
    }
    let bare = Base {
        known: Vec::new(),
        ..base.clone()
    };
    let without = |r: &Recording| {
        let answer = |base| {
            let problem = Problem::new(base, std::slice::from_ref(r), 0.3 / r.interval_s(), &[])?;
            let segment = problem.segments.into_iter().next()?;
            Some(segment.signals.base[segment.lead..].to_vec())
        };
        let known = difference(&answer(base)?, &answer(&bare)?);
        let displacement_mm = Some(difference(r.displacement_mm.as_ref()?, &known));
        Some(Recording {
            displacement_mm,
            ..r.clone()
        })
    };
    records.iter().map(without).collect()
}

/// Records as used by the search, averaged over `every` samples.
pub fn data<'a>(base: &'a Base, records: &[Recording], every: usize) -> Option<ActuatorData<'a>> {
    let interval_s = records.first()?.interval_s();
    let settling_s = base.settling_s();
    let runs: Option<Vec<Run>> = records.iter().map(|r| run(r, every, settling_s)).collect();
    Some(ActuatorData::new(runs?, interval_s * every as f64, base))
}

fn run(record: &Recording, every: usize, settling_s: f64) -> Option<Run> {
    let h = record.interval_s();
    let (joined, lead) = record.with_run_up(|r| r.command_mm.as_ref());
    // A run-up is no longer than the record. If it was made up it is only approximate: it serves parts with memory
    // until the motion turns, and the record's first moments, which settle the rest, are not judged.
    let kept = lead.min(record.time_s.len());
    let from = lead - kept;
    let settling = (settling_s / h).min(MOST_SETTLING * record.time_s.len() as f64) as usize;
    let short = match &record.before {
        Some(_) => settling.saturating_sub(kept),
        None => settling,
    };
    // Whole averages only.
    let skipped = (kept + short).next_multiple_of(every) - kept;
    let mean = |x: &[f64]| crate::numbers::signals::averaged(x, every);
    let cutoff_hz = 4.0 * motion_band_hz(record.displacement_mm.as_ref()?, h).unwrap_or(10.0);
    let force = joined.force_n.as_ref().map(|f| {
        let smooth = spectrum::low_passed(&f[from..], h, cutoff_hz.min(0.3 / h));
        mean(&smooth)
    });
    let target = mean(&record.displacement_mm.as_ref()?[skipped..]);
    let judged = record
        .unmeasured()
        .into_iter()
        .map(|i| i.checked_sub(skipped));
    let judged = judged.flatten().map(|i| i / every);
    let first = record.before.as_ref().and_then(|b| b.time_s.first());
    Some(Run {
        command: mean(&joined.command_mm?[from..]),
        lead: (kept + skipped) / every,
        unmeasured: judged.filter(|i| *i < target.len()).collect(),
        target,
        force: force.unwrap_or_default(),
        from_s: record.time_s[skipped] - first.unwrap_or(&record.time_s[0]),
    })
}
