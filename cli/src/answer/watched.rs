//! The reports of the rig watch, drawn over the motion.

use super::figures::Figures;
use crate::document::Document;
use crate::document::plot::{Colour, Curve, GROUND, TALL, TESTED, THIRD, WIDE, WRONG};
use experiment::watch::WatchEvent;
use std::ops::Range;

/// Its states, and the colour of the motion in each.
const STATES: [(&str, Colour); 4] = [
    ("sound", TESTED),
    ("doubtful", THIRD),
    ("named", WRONG),
    ("trip", GROUND),
];

impl Figures<'_> {
    /// The position and the tracking error of each actuator, in the colour of the watch's state, and a line for each
    /// change; nothing if the watch had nothing to report.
    pub fn watched(&self, d: &mut Document) {
        let watch = self.section.summary.watch.as_ref();
        let Some(watch) = watch.filter(|w| !w.events.is_empty()) else {
            return;
        };
        let spans = self.states(&watch.events);
        d.heading("What the watch saw");
        for (j, floor) in self.floors().take(self.physical()) {
            let place = |i: usize| f64::from(floor.displacement_m[i]) * 1e3;
            let off = |i: usize| place(i) - f64::from(floor.command_m[i]) * 1e3;
            let caption = "Where the actuator was, and what the watch said of the rig then.";
            let (shape, label) = (self.cut(TALL, j), "measured displacement [mm]");
            let curves = self.coloured(&spans, place);
            Self::in_time(d, shape, label, &curves, self.on_floor(j, caption));
            let caption = "How far that is from where the integration wanted it.";
            let (shape, label) = (self.cut(WIDE, j), "measured less target [mm]");
            let curves = self.coloured(&spans, off);
            Self::in_time(d, shape, label, &curves, self.on_floor(j, caption));
        }
        d.on_page(|d| d.items(watch.lines()));
    }

    /// The ranges of integration steps with one state each, as an index in [`STATES`].
    fn states(&self, events: &[WatchEvent]) -> Vec<(usize, Range<usize>)> {
        let steps = self.solved.len();
        let step = |t_s: f64| ((t_s / self.step_s) as usize).min(steps);
        let place = |e: &WatchEvent| STATES.iter().position(|(s, _)| *s == e.state).unwrap_or(0);
        let first = (0, 0..step(events[0].t_s));
        let ends = events.iter().skip(1).map(|e| step(e.t_s)).chain([steps]);
        let later = events
            .iter()
            .zip(ends)
            .map(|(e, end)| (place(e), step(e.t_s)..end));
        let all = [first].into_iter().chain(later);
        all.filter(|(_, range)| !range.is_empty()).collect()
    }

    /// A quantity of the trace in the colours of the states; each state has one entry in the legend.
    fn coloured(
        &self,
        spans: &[(usize, Range<usize>)],
        value: impl Fn(usize) -> f64,
    ) -> Vec<Curve> {
        let mut shown = [false; STATES.len()];
        spans
            .iter()
            .map(|(state, range)| {
                let (name, colour) = STATES[*state];
                let joined = range.start..(range.end + 1).min(self.solved.len());
                let curve = Curve::new(colour, self.over(joined, &value));
                match std::mem::replace(&mut shown[*state], true) {
                    true => curve,
                    false => curve.named(name),
                }
            })
            .collect()
    }
}
