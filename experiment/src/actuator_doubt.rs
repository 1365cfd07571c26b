//! What speaks against the four numbers that were fitted to an actuator's record.

use crate::numbers::{percent, three};
use diagnosis::{Identified, Recording, USUAL_GAINS};

/// A model of an actuator leaves less than this share of a displacement that follows its command.
const GOOD_NRMSE: f64 = 0.25;
/// Delay and lag of an actuator, ms: beyond it no test can be run.
const LONGEST_MS: f64 = 1000.0;

/// Why a fit to this record may not be believed, in one sentence: a wrong sign, exchanged channels, a displacement before its command,
/// a unit that cannot be meant, a fit that leaves too much. `None`: nothing speaks against it.
pub fn doubt(recording: &Recording, found: &Identified) -> Option<String> {
    let file = &recording.name;
    if found.gain < 0.0 {
        return Some(format!(
            "{file}: the polarity is reversed: the displacement moves against its command (gain {}); exchange the wires \
             of one of them, or its sign, before anything else",
            three(found.gain)
        ));
    }
    if recording.command_mm.is_some() && recording.command_mm == recording.displacement_mm {
        return Some(format!(
            "{file}: the displacement is the command to the last bit: no transducer reads that; was the command recorded \
             twice?"
        ));
    }
    if let Some(question) = recording.odd_rate() {
        return Some(question);
    }
    let late_ms = found.delay_ms + found.lag_ms;
    if late_ms > LONGEST_MS {
        return Some(format!(
            "{file}: delay and lag are {} ms together, and actuators have up to {LONGEST_MS} ms: is the time in \
             milliseconds under a name that says seconds?",
            three(late_ms)
        ));
    }
    if let Some(lead_ms) = lead_ms(recording) {
        return Some(format!(
            "{file}: the displacement comes {} ms before its command: are the two columns exchanged, or their clocks \
             apart?",
            three(lead_ms)
        ));
    }
    if found.nrmse > GOOD_NRMSE {
        return Some(format!(
            "{file}: gain, delay and lag leave {} of the displacement: this actuator does something else as well, or \
             the record is not of one motion; `outerloop diagnose` looks for what",
            percent(found.nrmse)
        ));
    }
    (!USUAL_GAINS.contains(&found.gain)).then(|| {
        format!(
            "{file}: the displacement is {} times its command: is the unit of one of them another one?",
            three(found.gain)
        )
    })
}

/// By how much the displacement fits its command better when it is taken as the earlier of the two.
fn lead_ms(recording: &Recording) -> Option<f64> {
    let (command, moved) = (
        recording.command_mm.as_ref()?,
        recording.displacement_mm.as_ref()?,
    );
    let n = command.len().min(moved.len());
    let most = (n / 4).min((LONGEST_LEAD_S / recording.interval_s()) as usize);
    // Least squares needs no full resolution: the mean square difference over some hundred shifts.
    let stride = (most / 200).max(1);
    let apart = |shift: usize, first: &[f64], second: &[f64]| {
        let pairs = first[..n - shift].iter().zip(&second[shift..n]);
        pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / (n - shift) as f64
    };
    let (mut best, mut lead) = (f64::INFINITY, 0);
    let mut late = f64::INFINITY;
    for shift in (0..most).step_by(stride) {
        let early = apart(shift, moved, command);
        if early < best {
            (best, lead) = (early, shift);
        }
        late = late.min(apart(shift, command, moved));
    }
    (lead > 0 && best < 0.5 * late).then(|| lead as f64 * recording.interval_s() * 1e3)
}

/// Longest lead that is looked for, s.
const LONGEST_LEAD_S: f64 = 0.5;

#[cfg(test)]
mod tests {
    use super::*;

    fn of(delay_ms: f64, copied: bool) -> Option<String> {
        let moved = |at: usize| (at as f64 * 0.01).sin();
        let command: Vec<f64> = (0..2000).map(|i| moved(i + 4)).collect();
        let recording = Recording {
            name: "r.csv".into(),
            time_s: (0..2000).map(|i| f64::from(i) * 1e-3).collect(),
            displacement_mm: Some(if copied {
                command.clone()
            } else {
                (0..2000).map(moved).collect()
            }),
            command_mm: Some(command),
            ..Recording::default()
        };
        let found = Identified {
            delay_ms,
            ..diagnosis::identify(&recording).unwrap()
        };
        doubt(&recording, &found)
    }

    #[test]
    fn what_no_actuator_does_is_asked_about() {
        assert_eq!(of(4.0, false), None);
        assert!(
            of(5068.0, false)
                .unwrap()
                .contains("is the time in milliseconds")
        );
        assert!(of(0.0, true).unwrap().contains("to the last bit"));
    }
}
