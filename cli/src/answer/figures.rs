//! The figures of a test, with captions.

use super::section::TestSection;
use crate::document::Document;
use crate::document::plot::{
    Colour, Curve, GROUND, HALF, IDEAL, PlotShape, RAW, TALL, TESTED, THIRD, WIDE, WRONG, history,
    path, plot,
};
use experiment::summary::{TestVerdict, Validity};
use experiment::trace::FloorTrace;
use outerloop_core::{Method, config::Filter, flag};
use std::ops::Range;

/// For a test that tripped or ran away, this multiple of the largest ideal displacement is shown.
const SHOWN_BEYOND: f64 = 3.0;
/// Half the width of a close-up, in periods of the fundamental mode.
const LOOK_PERIODS: f64 = 3.0;

/// The name of a coordinate of two coupled actuators, and the unit in which its displacement is drawn.
pub(super) fn coordinate(name: &str) -> (String, &'static str) {
    let rotation = name.strip_suffix("_rad");
    let plain = rotation.unwrap_or_else(|| name.trim_end_matches("_m"));
    let unit = if rotation.is_some() { "mrad" } else { "mm" };
    (plain.replace('_', " "), unit)
}

/// The data of the figures: the control steps in which an integration step was solved.
pub struct Figures<'a> {
    pub(super) section: &'a TestSection<'a>,
    /// Their indices in the trace; the k-th belongs to integration step k.
    pub(super) solved: Vec<usize>,
    /// Integration step, s of model time.
    pub(super) step_s: f64,
    /// The integration steps around the largest ideal displacement.
    look: Range<usize>,
    colour: Colour,
}

impl<'a> Figures<'a> {
    /// Figures of this test.
    pub fn of(section: &'a TestSection<'a>) -> Self {
        let trace = section.trace;
        let solved: Vec<usize> = (0..trace.len())
            .filter(|i| trace.flags[*i] & flag::SOLVED != 0)
            .take(section.ideal.steps())
            .collect();
        let config = &section.experiment.test.config;
        let step_s = config.model_step_s();
        let peak = section
            .ideal
            .floor(0)
            .take(solved.len())
            .enumerate()
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
            .map_or(0, |(i, _)| i);
        // `per_critical` is 1 / (2 M omega); the period follows.
        let omega = 0.5 / (section.experiment.per_critical() * config.structure.mass_kg[0]);
        let half = (LOOK_PERIODS * std::f64::consts::TAU / omega / step_s) as usize;
        Self {
            section,
            look: peak.saturating_sub(half)..(peak + half).min(solved.len()),
            colour: match section.summary.validity() {
                Validity::Bad => WRONG,
                Validity::Fair | Validity::Good => TESTED,
            },
            solved,
            step_s,
        }
    }

    pub(super) fn floors(&self) -> impl Iterator<Item = (usize, &'a FloorTrace)> {
        self.section.trace.floors.iter().enumerate()
    }

    /// The name of a floor, or of a coordinate of two coupled actuators, and the unit in which its displacement is drawn.
    fn axis(&self, j: usize) -> (String, &'static str) {
        match &self.section.trace.interface {
            None => (format!("Floor {}", j + 1), "mm"),
            Some(interface) => coordinate(&interface.coordinates[j]),
        }
    }

    pub(super) fn physical(&self) -> usize {
        self.section.experiment.test.config.physical_storeys()
    }

    /// A quantity of the trace over the integration steps `range`.
    pub(super) fn over(
        &self,
        range: Range<usize>,
        value: impl Fn(usize) -> f64,
    ) -> Vec<(f64, f64)> {
        let start = range.start;
        history(range.len(), |k| {
            let k = start + k;
            (k as f64 * self.step_s, value(self.solved[k]))
        })
    }

    /// The ideal displacement of a floor over `range`, mm.
    fn ideal(&self, floor: usize, range: Range<usize>) -> Vec<(f64, f64)> {
        let start = range.start;
        history(range.len(), |k| {
            let k = start + k;
            let u = self
                .section
                .ideal
                .at(k)
                .map_or(f64::NAN, |u| f64::from(u[floor]));
            (k as f64 * self.step_s, u * 1e3)
        })
    }

    fn whole_test(&self) -> Range<usize> {
        0..self.solved.len()
    }

    /// A plot over the whole test, or over a part of it.
    pub(super) fn in_time(
        d: &mut Document,
        shape: PlotShape,
        label: &str,
        curves: &[Curve],
        caption: impl Into<String>,
    ) {
        d.figure(caption, || {
            plot(shape, "time of the model [s]", label, curves)
        });
    }

    /// The ground motion (Fig 7).
    pub fn ground_motion(&self, d: &mut Document) {
        let acc = &self.section.trace.ground_m_per_s2;
        let curve = Curve::new(GROUND, self.over(self.whole_test(), |i| f64::from(acc[i])));
        d.heading("Ground motion");
        let caption = "As the integration saw it.";
        Self::in_time(d, WIDE, "acceleration [m/s²]", &[curve], caption);
    }

    /// The displacement and the ideal, floor by floor (Figs 8, 10, 15).
    pub fn response(&self, d: &mut Document, caption: &str) {
        for (j, floor) in self.floors() {
            let caption = self.on_floor(j, caption);
            self.displacement_of(d, TALL, (j, floor), self.whole_test(), caption);
        }
    }

    /// The same with a close-up and the error.
    pub fn displacement(&self, d: &mut Document) {
        d.heading("Displacement");
        for (j, floor) in self.floors() {
            if self.section.trace.floors.len() > 1 {
                d.subheading(self.axis(j).0);
            }
            let caption = "The test, over the response with an ideal actuator.";
            self.displacement_of(d, TALL, (j, floor), self.whole_test(), caption);
            let caption = "A closer look at the strongest part.";
            self.displacement_of(d, WIDE, (j, floor), self.look.clone(), caption);
            let ideal = self.section.ideal;
            let error = history(self.solved.len(), |k| {
                let exact = ideal.at(k).map_or(f64::NAN, |u| f64::from(u[j]));
                let error = f64::from(floor.command_m[self.solved[k]]) - exact;
                (k as f64 * self.step_s, error * 1e3)
            });
            let (shape, label) = (self.cut(WIDE, j), format!("error [{}]", self.axis(j).1));
            let curve = [Curve::new(WRONG, error)];
            Self::in_time(d, shape, &label, &curve, "What is left: test less ideal.");
        }
    }

    /// Limits the vertical axis for a test that tripped or ran away.
    pub(super) fn cut(&self, shape: PlotShape, j: usize) -> PlotShape {
        let ideal_mm = self.section.ideal.peaks_m()[j] * 1e3;
        match self.section.summary.verdict {
            TestVerdict::Completed | TestVerdict::Stopped => shape,
            TestVerdict::Tripped | TestVerdict::Diverged => shape.within(SHOWN_BEYOND * ideal_mm),
        }
    }

    fn displacement_of(
        &self,
        d: &mut Document,
        shape: PlotShape,
        (j, floor): (usize, &FloorTrace),
        range: Range<usize>,
        caption: impl Into<String>,
    ) {
        let ideal = Curve::new(IDEAL, self.ideal(j, range.clone())).named("ideal actuator");
        let points = self.over(range, |i| f64::from(floor.command_m[i]) * 1e3);
        let test = Curve::new(self.colour, points).named("test");
        // A curve that has run away is drawn below the ideal, which it would hide otherwise.
        let curves = match self.section.summary.verdict {
            TestVerdict::Diverged => [
                test,
                Curve {
                    colour: GROUND,
                    ..ideal
                },
            ],
            TestVerdict::Completed | TestVerdict::Tripped | TestVerdict::Stopped => {
                [ideal.thick(), test]
            }
        };
        let label = format!("displacement [{}]", self.axis(j).1);
        Self::in_time(d, self.cut(shape, j), &label, &curves, caption);
    }

    /// The strongest part of this test with several compensations: the lowest floor, or x and rotation.
    pub fn overlay(&self, d: &mut Document, sections: &[&TestSection<'a>], colours: &[Colour]) {
        if self.section.trace.interface.is_none() {
            let label = "displacement of the lowest floor [mm]";
            return self.overlay_of(d, 0, label, sections, colours);
        }
        for j in 0..2 {
            let (name, unit) = self.axis(j);
            self.overlay_of(d, j, &format!("{name} [{unit}]"), sections, colours);
        }
    }

    fn overlay_of(
        &self,
        d: &mut Document,
        j: usize,
        label: &str,
        sections: &[&TestSection<'a>],
        colours: &[Colour],
    ) {
        let range = self.look.clone();
        let ideal = Curve::new(IDEAL, self.ideal(j, range.clone()));
        let mut curves = vec![ideal.named("ideal actuator").thick()];
        for (section, colour) in sections.iter().zip(colours) {
            let other = Figures::of(section);
            let end = range.end.min(other.solved.len());
            let command = &section.trace.floors[j].command_m;
            let points = other.over(range.start.min(end)..end, |i| f64::from(command[i]) * 1e3);
            curves.push(Curve::new(*colour, points).named(section.summary.compensation));
        }
        let shape = TALL.within(SHOWN_BEYOND * self.section.ideal.peaks_m()[j] * 1e3);
        Self::in_time(d, shape, label, &curves, "The strongest part of the test.");
    }

    pub(super) fn on_floor(&self, j: usize, caption: &str) -> String {
        match self.section.trace.floors.len() {
            1 => caption.to_owned(),
            _ => format!("{}. {caption}", self.axis(j).0),
        }
    }

    /// Force against displacement: as the integration perceives it, and as the specimen does (Fig 2).
    pub fn loops(&self, d: &mut Document) {
        let filtered = self.section.experiment.test.config.estimation.kind != Filter::Off;
        d.heading("Force against displacement");
        d.explain(format!(
            "Left, what the integration believes: the {} force against its own command. Right, what the specimen did. An area \
             that is on the left only is energy that the actuator's error puts in (or, run through the other way, takes out). \
             The strongest part of the test.",
            if filtered { "estimated" } else { "measured" }
        ));
        d.pair(|d| {
            for (j, floor) in self.floors().take(self.physical()) {
                self.loops_of(d, filtered, j, floor);
            }
        });
    }

    fn loops_of(&self, d: &mut Document, filtered: bool, j: usize, floor: &FloorTrace) {
        let part = &self.solved[self.look.clone()];
        let (displacement, force) = match &self.section.trace.interface {
            // Both are computed from the readings of both actuators.
            Some(interface) => (&interface.displacement[j], &floor.estimated_force_n),
            None if filtered => (&floor.estimated_displacement_m, &floor.estimated_force_n),
            None => (&floor.displacement_m, &floor.force_n),
        };
        let unit = self.axis(j).1;
        let answer = match unit {
            "mrad" => "moment [kN m]",
            _ => "force [kN]",
        };
        for (colour, x, what, caption) in [
            (
                WRONG,
                &floor.command_m,
                "command",
                "Perceived: force against command.",
            ),
            (
                TESTED,
                displacement,
                "displacement",
                "Measured: force against displacement.",
            ),
        ] {
            d.figure(self.on_floor(j, caption), || {
                let points = path(part.len(), |k| {
                    let i = part[k];
                    (f64::from(x[i]) * 1e3, f64::from(force[i]) * 1e-3)
                });
                let curve = [Curve::new(colour, points)];
                plot(HALF, &format!("{what} [{unit}]"), answer, &curve)
            });
        }
    }

    /// Each of two coupled actuators in the strongest part: target, command and stroke.
    pub fn actuators(&self, d: &mut Document) {
        let Some(interface) = &self.section.trace.interface else {
            return;
        };
        d.heading("What the actuators did");
        for (i, floor) in self.floors().take(2) {
            let of = |x: &[f32]| self.over(self.look.clone(), |k| 1e3 * f64::from(x[k]));
            let target = Curve::new(IDEAL, of(&interface.wanted_m[i]));
            let curves = [
                target.named("target").thick(),
                Curve::new(WRONG, of(&floor.sent_m)).named("command"),
                Curve::new(TESTED, of(&interface.true_stroke_m[i])).named("true stroke"),
            ];
            let caption = format!(
                "Actuator {}: the command leads, so that the stroke is on its target. The strongest part of the test.",
                i + 1
            );
            Self::in_time(d, self.cut(WIDE, 0), "stroke [mm]", &curves, caption);
        }
    }

    /// The three energy errors (Fig 9).
    pub fn energy(&self, d: &mut Document) {
        let trace = self.section.trace;
        let (exact, whole) = (&trace.energy_stiffness_j, self.whole_test());
        let sum = |colour, column: &[f32]| {
            Curve::new(colour, self.over(whole.clone(), |i| f64::from(column[i])))
        };
        let off = |colour, column: &[f32]| {
            let points = self.over(whole.clone(), |i| {
                f64::from(column[i]) - f64::from(exact[i])
            });
            Curve::new(colour, points)
        };
        let (hsem, modified) = (&trace.energy_hsem_j, &trace.energy_modified_j);
        let sums = [
            sum(IDEAL, exact).named("stiffness known, Eq 6").thick(),
            sum(WRONG, hsem).named("HSEM, Eqs 7 to 9"),
            sum(TESTED, modified).named("modified, Eqs 10 to 12"),
        ];
        let differences = [
            off(WRONG, hsem).named("HSEM less Eq 6"),
            off(TESTED, modified).named("modified less Eq 6"),
        ];
        d.heading("Energy error");
        let caption = "What the actuator's error has put into the structure (negative) or taken out since the start (Fig 9 of the \
                       paper). Eq 6 needs to know the stiffness, the other two do not.";
        Self::in_time(d, TALL, "cumulative energy error [J]", &sums, caption);
        let caption = "They agree so closely that only their differences can be told apart.";
        Self::in_time(d, WIDE, "difference [J]", &differences, caption);
    }

    /// The added damping (Fig 11) and the gain (Fig 16).
    pub fn damping(&self, d: &mut Document) {
        let method = self.section.summary.compensation;
        d.heading("Added damping");
        if method == Method::None.name() {
            return d.explain("None: this test is not compensated.");
        }
        let percent = 100.0 * self.section.experiment.per_critical();
        for (j, floor) in self.floors().take(self.physical()) {
            let c = &floor.added_damping_n_s_per_m;
            for (range, caption) in [
                (
                    self.whole_test(),
                    "What the compensation adds, in per cent of the critical damping of the first mode (Fig 11).",
                ),
                (self.look.clone(), "The same over the strongest part."),
            ] {
                let points = self.over(range, |i| percent * f64::from(c[i]));
                let curve = [Curve::new(TESTED, points)];
                let caption = self.on_floor(j, caption);
                Self::in_time(d, WIDE, "added damping [%]", &curve, caption);
            }
            if method == Method::Paper.name() {
                let points = self.over(self.look.clone(), |i| f64::from(floor.gain[i]));
                let caption = self.on_floor(
                    j,
                    "The switch of Eq 19 over the strongest part: near 1 in motion, towards 0 where the structure turns round \
                     (Fig 16).",
                );
                let curve = [Curve::new(THIRD, points)];
                Self::in_time(d, WIDE, "gain G_v [1]", &curve, caption);
            }
        }
    }

    /// The sensors and the filter's estimate, if there is a filter.
    pub fn estimate(&self, d: &mut Document) {
        if self.section.experiment.test.config.estimation.kind == Filter::Off {
            return;
        }
        d.heading("Sensors and estimate");
        for (j, floor) in self.floors().take(self.physical()) {
            for (raw, estimate, factor, label) in [
                (
                    &floor.displacement_m,
                    &floor.estimated_displacement_m,
                    1e3,
                    "displacement [mm]",
                ),
                (&floor.force_n, &floor.estimated_force_n, 1e-3, "force [kN]"),
            ] {
                let curve = |name, colour, column: &[f32]| {
                    let points = self.over(self.look.clone(), |i| f64::from(column[i]) * factor);
                    Curve::new(colour, points).named(name)
                };
                let curves = [
                    curve("as measured", RAW, raw),
                    curve("as estimated", TESTED, estimate),
                ];
                let caption =
                    self.on_floor(j, "What the sensors said and what the loop made of it.");
                Self::in_time(d, WIDE, label, &curves, caption);
            }
        }
    }
}
