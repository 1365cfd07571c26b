//! A session: a rig as an element of an external model.

use super::figures::coordinate;
use crate::document::plot::{
    Colour, Curve, GROUND, HALF, IDEAL, PlotShape, TALL, TESTED, WIDE, WRONG, history, path, plot,
};
use crate::document::{Document, Grade};
use crate::serve::{SessionSummary, SessionVerdict};
use experiment::files::test::TestFile;
use experiment::numbers::{joule, length, percent, si};
use experiment::trace::Trace;
use outerloop_core::Pace;

/// The data of a session for its page.
#[derive(Clone, Copy, Debug)]
pub struct SessionSection<'a> {
    /// The test file.
    pub test: &'a TestFile,
    /// Its figures.
    pub summary: &'a SessionSummary,
    /// Every step; `None` if there is no page.
    pub trace: Option<&'a Trace>,
}

/// A session.
pub fn of_served(s: &SessionSection<'_>) -> Document {
    let mut d = Document::new(
        "A rig as an element of a model outside",
        lead(s),
        s.trace.is_some(),
    );
    d.tell(s.summary.sentences());
    d.on_page(|d| verdict(d, s.summary));
    if let Some(trace) = s.trace.filter(|t| !t.is_empty()) {
        tiles(&mut d, s.summary);
        for floor in ShownFloor::all(trace) {
            floor.draw(&mut d, |i| trace.time_s(i));
        }
        energy(&mut d, trace);
        if s.test.serve.pace == Pace::Continuous {
            damping(&mut d, trace);
        }
    }
    if let Some(board) = &s.summary.board {
        d.heading("The board");
        d.explain(board.sentence());
    }
    d.test_file(&s.test.text);
    d
}

fn lead(s: &SessionSection<'_>) -> String {
    let timing = &s.test.config.timing;
    let pace = match s.test.serve.pace {
        Pace::StopAndGo => "stop and go".to_owned(),
        Pace::Continuous => format!(
            "continuously, a target every {}",
            si(f64::from(timing.substeps) / timing.rate_hz, "s")
        ),
    };
    format!(
        "{} targets to {:.2} s of the model, {pace}; the rig at {} Hz. The integration was the client's: what its \
         structure did, and how far that is from its own analysis, only the client knows. The rig watch does not look at sessions.",
        s.summary.targets, s.summary.model_s, timing.rate_hz
    )
}

fn verdict(d: &mut Document, s: &SessionSummary) {
    let grade = match s.verdict {
        SessionVerdict::Completed => Grade::Good,
        SessionVerdict::Stopped => Grade::Fair,
        SessionVerdict::Refused
        | SessionVerdict::Lost
        | SessionVerdict::Tripped
        | SessionVerdict::RigLost => Grade::Bad,
    };
    let followed = match s.targets {
        0 => String::new(),
        targets => format!(
            " At its {targets} targets the rig was {} rms from them and {} at most; the largest is {}.",
            length(s.tracking_rms_m),
            length(s.tracking_max_m),
            length(s.peak_displacement_m)
        ),
    };
    let further = s.coordinates.iter().skip(1);
    let further: String = further.map(|c| format!(" {}", c.sentence())).collect();
    d.verdict(grade, format!("{}{followed}{further}", s.ending()));
}

fn tiles(d: &mut Document, s: &SessionSummary) {
    let mut tiles = vec![
        (length(s.peak_displacement_m), "largest target"),
        (
            length(s.tracking_rms_m),
            "measured less target at the targets, rms",
        ),
        (length(s.tracking_max_m), "the largest of it"),
        (
            joule(s.energy_error_j),
            "energy error of the actuator (Eq 12); negative: put in",
        ),
        (
            percent(s.energy_ratio),
            "of the largest strain energy: energy error",
        ),
    ];
    if s.late_targets > 0 {
        let late = si(s.late_s, "s");
        tiles.push((late, "for which the rig waited for a late model"));
    }
    let tiles = tiles
        .into_iter()
        .map(|(value, meaning)| (value, meaning.to_owned()));
    d.tiles(tiles.collect());
}

/// A quantity over laboratory time.
fn curve_over_time(t: &Trace, colour: Colour, value: impl Fn(usize) -> f64) -> Curve {
    Curve::new(colour, history(t.len(), |i| (t.time_s(i), value(i))))
}

/// A plot over laboratory time.
fn in_time(d: &mut Document, shape: PlotShape, label: &str, curves: &[Curve], caption: &str) {
    d.figure(caption, || {
        plot(shape, "time in the laboratory [s]", label, curves)
    });
}

/// A motion to be drawn: of a storey, of a coordinate of two coupled actuators, or of the actuator that a signal moved.
pub(super) struct ShownFloor<'a> {
    pub heading: String,
    /// Units for a thousandth of the target's unit, and a thousand of the force's.
    pub units: [&'static str; 2],
    pub target: &'a [f32],
    pub displacement: &'a [f32],
    pub force: &'a [f32],
}

impl<'a> ShownFloor<'a> {
    fn all(t: &'a Trace) -> Vec<Self> {
        let floors = t.floors.iter().enumerate();
        floors
            .map(|(j, floor)| match &t.interface {
                None => Self {
                    heading: match t.floors.len() {
                        1 => "Displacement".to_owned(),
                        _ => format!("Displacement of storey {}", j + 1),
                    },
                    units: ["mm", "kN"],
                    target: &floor.command_m,
                    displacement: &floor.displacement_m,
                    force: &floor.force_n,
                },
                Some(interface) => {
                    let (name, unit) = coordinate(&interface.coordinates[j]);
                    Self {
                        heading: format!("Displacement of {name}"),
                        units: [unit, if unit == "mm" { "kN" } else { "kN m" }],
                        target: &floor.command_m,
                        displacement: &interface.displacement[j],
                        force: &floor.estimated_force_n,
                    }
                }
            })
            .collect()
    }

    /// Draws the motion; `time_s`: laboratory time of a control step.
    pub(super) fn draw(&self, d: &mut Document, time_s: impl Fn(usize) -> f64) {
        let n = self.target.len();
        let thousandths = |column: &[f32], i: usize| f64::from(column[i]) * 1e3;
        let thousands = |i: usize| f64::from(self.force[i]) * 1e-3;
        let over_time = |colour: Colour, value: &dyn Fn(usize) -> f64| {
            Curve::new(colour, history(n, |i| (time_s(i), value(i))))
        };
        let (displacement, force) = (self.displacement, format!("force [{}]", self.units[1]));
        let label = format!("displacement [{}]", self.units[0]);
        d.heading(self.heading.clone());
        let curves = [
            over_time(IDEAL, &|i| thousandths(self.target, i))
                .named("target")
                .thick(),
            over_time(TESTED, &|i| thousandths(displacement, i)).named("measured"),
        ];
        let caption = "Where the specimen was to be, and where it was.";
        in_time(d, TALL, &label, &curves, caption);
        let apart = over_time(WRONG, &|i| {
            thousandths(displacement, i) - thousandths(self.target, i)
        });
        let caption = "Measured less target at every control step, on the way, too: an actuator that is late is behind its target.";
        let error = format!("error [{}]", self.units[0]);
        in_time(d, WIDE, &error, &[apart], caption);
        d.pair(|d| {
            d.figure("What the specimen did: force against displacement.", || {
                let points = path(n, |i| (thousandths(displacement, i), thousands(i)));
                let curve = [Curve::new(TESTED, points)];
                plot(HALF, &label, &force, &curve)
            });
            in_time(
                d,
                HALF,
                &force,
                &[over_time(GROUND, &thousands)],
                "Its force.",
            );
        });
    }
}

fn energy(d: &mut Document, t: &Trace) {
    let sum = |colour, column: &[f32]| curve_over_time(t, colour, |i| f64::from(column[i]));
    let exact = sum(IDEAL, &t.energy_stiffness_j);
    let curves = [
        exact.named("stiffness known, Eq 6").thick(),
        sum(WRONG, &t.energy_hsem_j).named("HSEM, Eqs 7 to 9"),
        sum(TESTED, &t.energy_modified_j).named("modified, Eqs 10 to 12"),
    ];
    d.heading("Energy error");
    let caption = "What the actuator's error has put into the structure (negative) or taken out since the start. Eq 6 takes the \
                   declared stiffness: it holds while the specimen is elastic.";
    in_time(d, WIDE, "cumulative energy error [J]", &curves, caption);
}

fn damping(d: &mut Document, t: &Trace) {
    let Some(first) = t.floors.first() else {
        return;
    };
    let curve = curve_over_time(t, TESTED, |i| {
        f64::from(first.added_damping_n_s_per_m[i]) * 1e-3
    });
    d.heading("Added damping");
    let caption = "What the compensation adds; its force is a part of the one that the model is answered with.";
    in_time(d, WIDE, "added damping [kN s/m]", &[curve], caption);
}
