//! Obstacles to a verdict: signals that are missing, constant, or at their rails.

use super::channel::ChannelDiagnosis;
use crate::numbers::signals::mean;
use crate::prepare::plausible;
use crate::record::converter_step;
use crate::record::recording::{Recording, range};
use plant::Channel;
use std::ops::Range;

/// True if converter steps are so large that a signal stays on each for a while.
fn coarse(x: &[f64]) -> bool {
    converter_step::step(x).is_some_and(|step| step > 2e-3 * range(x))
}

impl ChannelDiagnosis<'_> {
    /// The obstacle to a verdict before anything is fitted.
    pub(super) fn obstacle(&self) -> Option<String> {
        let name = self.base.channel.name();
        for r in self.train.iter().chain(self.test) {
            let (Some(input), Some(target)) = (self.input_of(r), self.target_of(r)) else {
                return Some(format!(
                    "{}: the {name} needs its input and its output; one of them is missing",
                    r.name
                ));
            };
            for (what, x) in [("input", input), ("output", target)] {
                if range(x) == 0.0 {
                    return Some(format!(
                        "{}: the {what} of the {name} stands still at {}",
                        r.name, x[0]
                    ));
                }
            }
            // A command held at its end is intended; a sensor there is at its rail: the force goes on.
            let driven_by = r.command_mm.as_deref().unwrap_or(target);
            if self.base.channel == Channel::Specimen
                && !coarse(input)
                && let Some(stop) = plausible::clipped(input, Some(driven_by))
            {
                return Some(self.clips(r, "displacement", "mm", input, &stop, ""));
            }
        }
        None
    }

    /// An output that is at its ends again and again: what is cut off there passes for an effect other than a limit.
    pub(super) fn rail(&self, unit: &str) -> Option<String> {
        let (what, unit) = match self.base.channel {
            Channel::Actuator => ("displacement", "mm"),
            Channel::Specimen => ("force", unit),
        };
        let stands = |r: &Recording| {
            let input = self.input_of(r).map(Vec::as_slice);
            let x = self.target_of(r).filter(|x| !coarse(x))?;
            let stop = plausible::clipped(x, input)?;
            let passes = ", and what is cut off there passes for another effect";
            Some(self.clips(r, what, unit, x, &stop, passes))
        };
        self.train.iter().find_map(stands)
    }

    /// Where a signal is at its rail, and what to do about it.
    fn clips(
        &self,
        r: &Recording,
        what: &str,
        unit: &str,
        x: &[f64],
        stop: &Range<usize>,
        so: &str,
    ) -> String {
        let at = x[stop.start];
        let end = if at > mean(x) { "largest" } else { "smallest" };
        format!(
            "{}: the {what} of the {} is clipped: it stays at its {end} value, {at:.4} {unit}, again and again, the longest \
             from {:.3} s to {:.3} s{so}. Record with a wider range of the amplifier and the converter, or keep the \
             file and give spans without these times (FILE@T0..T1)",
            r.name,
            self.base.channel.name(),
            r.time_s[stop.start],
            r.time_s[stop.end - 1]
        )
    }
}
