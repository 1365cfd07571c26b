//! Parts between command and displacement, up to four together, searched jointly on the simulated displacement, and a
//! certificate for each name.
//!
//! The steps of a record: [`signal_path`] (the simulation) of [`part`]s, [`fit`] (least squares, and the data left out block by
//! block), [`search`], [`verdict`] (which of the names can be vouched for).

mod fit;
pub(crate) mod part;
mod save;
mod search;
pub(crate) mod signal_path;
mod verdict;

pub use fit::{ActuatorData, ActuatorFit};
pub use verdict::ActuatorOutcome;

use crate::base::Base;
use crate::criteria::actuator::{A_CYCLE, MOST_SETTLING, SEARCHED, TOO_MANY};
use crate::recording::Recording;
use crate::rest;
use crate::spectrum::{self, motion_band_hz};
use search::PartSearch;
use signal_path::Run;

/// What the search came to.
#[derive(Debug)]
pub struct ActuatorResult {
    /// The declared model, its parameters within their tolerances.
    pub declared: ActuatorFit,
    /// What can be said.
    pub outcome: ActuatorOutcome,
    /// How far each single part got: its name and the squares that it leaves, of the declared model's.
    pub tried: Vec<(plant::Effect, f64)>,
}

/// Searches; `None` where a signal is missing or the equations have no solution.
pub fn find(base: &Base, train: &[Recording]) -> Option<ActuatorResult> {
    let whole = data(base, train, 1)?;
    let band = train
        .iter()
        .filter_map(|r| motion_band_hz(r.displacement_mm.as_ref()?, r.interval_s()))
        .fold(0.0, f64::max);
    let samples = whole.target.len();
    let [fine, coarse] = A_CYCLE.map(|c| (1.0 / (c * band * whole.interval_s)).floor() as usize);
    let every = samples
        .div_ceil(SEARCHED)
        .min(fine)
        .max(samples.div_ceil(TOO_MANY).min(coarse))
        .max(1);
    let thin = data(base, train, every)?;
    // What depends on time alone must predict the rest after the motion, too: without one it is not asked about.
    let rests = |r: &Recording| rest::spans(r).len() == 2;
    let (search, declared) = PartSearch::new(&thin, train.iter().all(rests))?;
    // Best first: of several forms under one name the first.
    let mut tried: Vec<(plant::Effect, f64)> = Vec::new();
    for screened_part in search.screened(&declared, &[]) {
        let name = screened_part.part.kind.effect();
        if tried.iter().all(|t| t.0 != name) {
            tried.push((name, screened_part.left(declared.fit.cost)));
        }
    }
    let outcome = verdict::conclude(&search, &declared);
    let full = |fit: &ActuatorFit| whole.fit(&fit.model, fit.declared);
    Some(ActuatorResult {
        declared: full(&declared.fit)?,
        outcome: outcome.with(full)?,
        tried,
    })
}

/// Records as the search sees them, averaged over `every` samples.
pub fn data<'a>(base: &'a Base, records: &[Recording], every: usize) -> Option<ActuatorData<'a>> {
    let interval_s = records.first()?.interval_s();
    let settling_s = base.settling_s();
    let runs: Option<Vec<Run>> = records.iter().map(|r| run(r, every, settling_s)).collect();
    Some(ActuatorData::new(runs?, interval_s * every as f64, base))
}

fn run(record: &Recording, every: usize, settling_s: f64) -> Option<Run> {
    let h = record.interval_s();
    let (joined, lead) = record.with_run_up(|r| r.command_mm.as_ref());
    // No more of a run-up than the record is long. One that was made up is not quite what happened: it serves what has a
    // memory until the motion turns, and the record's first moments, which settle the rest, are not judged.
    let kept = lead.min(record.time_s.len());
    let from = lead - kept;
    let settling = (settling_s / h).min(MOST_SETTLING * record.time_s.len() as f64) as usize;
    let short = match &record.before {
        Some(_) => settling.saturating_sub(kept),
        None => settling,
    };
    // Whole averages.
    let skipped = (kept + short).next_multiple_of(every) - kept;
    let mean = |x: &[f64]| crate::signals::averaged(x, every);
    let cutoff_hz = 4.0 * motion_band_hz(record.displacement_mm.as_ref()?, h).unwrap_or(10.0);
    let force = joined.force_n.as_ref().map(|f| {
        let smooth = spectrum::smooth(&f[from..], h, cutoff_hz.min(0.3 / h)).x;
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
        skipped: skipped / every,
        unmeasured: judged.filter(|i| *i < target.len()).collect(),
        target,
        force: force.unwrap_or_default(),
        from_s: record.time_s[skipped] - first.unwrap_or(&record.time_s[0]),
    })
}
