//! The rig watch of a test: what is declared to it, and what it had to say.

use crate::failure::Failure;
use crate::files::test::TestFile;
use crate::numbers::three;
use crate::rig::{Departures, Quantity, noise_rms};
use crate::trace::{AnyRecord, Response, TestObserver};
use diagnosis::Model;
use outerloop_core::watch::{
    Actions, AxisOrders, Block, Cause, Declared, DeclaredActuator, ErrorLimit, Instructions, State,
    Verdict, Watch, judge, steps_in_block,
};
use serde::Serialize;
use std::f64::consts::TAU;

/// A cause that was named. The keys are a contract.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NamedCause {
    /// The effect's name in the catalogue.
    pub name: &'static str,
    /// Where it is: `actuator`, `displacement`, `force` (the sensors) or `specimen`.
    pub side: &'static str,
    /// Of which actuator, from 1, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actuator: Option<usize>,
    /// How much, in `unit`: what is more than declared.
    pub value: f64,
    /// Its unit; empty for a share.
    pub unit: &'static str,
    /// Interval of 90 %.
    pub ci90: [f64; 2],
    /// How much of it the loop corrects for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corrected: Option<f64>,
}

/// A change of state or set. The keys are a contract.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WatchEvent {
    /// When, s of the model from the first control step of the running test.
    pub t_s: f64,
    /// The state from then on.
    pub state: &'static str,
    /// The causes that the motion does not tell apart.
    pub set: Vec<NamedCause>,
    /// True if the loop corrects for one of them.
    pub corrected: bool,
    /// True if what the adaptive compensation has learnt is held at what was declared.
    pub held: bool,
}

/// A correction as it was changed: 50 ms or more after the last one. The keys are a contract.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CorrectionStep {
    /// When it was asked for, s of the model from the first control step of the running test.
    pub t_s: f64,
    /// The effect's name in the catalogue.
    pub name: &'static str,
    /// Where it is.
    pub side: &'static str,
    /// Of which actuator, from 1, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actuator: Option<usize>,
    /// How much is corrected for from then on, in `unit`.
    pub corrected: f64,
    /// Its unit; empty for a share.
    pub unit: &'static str,
}

/// What the watch had to say of a test. The keys are a contract.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WatchReport {
    /// The state at the end.
    pub state: &'static str,
    /// Every change; the last holds what had settled at the end.
    pub events: Vec<WatchEvent>,
    /// Every correction, 20 a second while it moves.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub corrections: Vec<CorrectionStep>,
    /// What could not be watched, and why, in sentences.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_watched: Vec<String>,
}

/// What 90 % of a normal distribution lie within, standard deviations.
const NINETY: f64 = 1.645;

impl WatchReport {
    /// What happened and when, in a sentence.
    pub fn sentence(&self) -> String {
        let first = self.events.iter().find(|e| !e.set.is_empty());
        let (Some(first), Some(last)) = (first, self.events.last()) else {
            let found = match self.state {
                "sound" => "The watch named nothing.",
                _ => "The watch had a doubt that got no name.",
            };
            return format!("{found} {}", self.not_watched.join(" "))
                .trim_end()
                .to_owned();
        };
        let names: Vec<String> = last.set.iter().map(NamedCause::in_words).collect();
        let what = match &names[..] {
            [one] => one.clone(),
            several => format!("one of {}", several.join(", ")),
        };
        let stopped = if self.state == "trip" {
            " The test cannot be trusted from there on."
        } else {
            ""
        };
        let held = self
            .events
            .iter()
            .find(|e| e.held)
            .map_or(String::new(), |e| {
                format!(
                    " From {:.2} s on the compensation was held at what was declared.",
                    e.t_s
                )
            });
        format!(
            "The watch named, first at {:.2} s: {what}.{}{held}{stopped}",
            first.t_s,
            self.corrected_in_words()
        )
    }

    /// What was corrected for: from when, and by how much in the end.
    fn corrected_in_words(&self) -> String {
        let (Some(first), Some(last)) = (self.corrections.first(), self.corrections.last()) else {
            return String::new();
        };
        let unit = if last.unit.is_empty() { "" } else { " " };
        format!(
            " From {:.2} s on it was corrected for, in the end by {}{unit}{}.",
            first.t_s,
            three(last.corrected),
            last.unit
        )
    }
}

impl NamedCause {
    /// As `delay_error of the actuator (6.1 ms, 5.2 to 7.0)`.
    pub fn in_words(&self) -> String {
        let side = match self.side {
            "displacement" => "the displacement transducer",
            "force" => "the load cell",
            "actuator" => "the actuator",
            _ => "the specimen",
        };
        let number = self.actuator.map_or(String::new(), |n| format!(" {n}"));
        if self.value == 0.0 {
            return format!("{} of {side}{number}", self.name);
        }
        let unit = if self.unit.is_empty() { "" } else { " " };
        let [low, high] = self.ci90.map(three);
        let value = three(self.value);
        format!(
            "{} of {side}{number} ({value}{unit}{}, {low} to {high})",
            self.name, self.unit
        )
    }
}

/// Where a test is watched.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    /// What the motion is planned to be.
    pub ideal: &'a Response,
    /// First natural frequency, Hz of the model.
    pub first_hz: f64,
    /// Length of the test, s of the model.
    pub seconds: f64,
}

/// Watches a running test, in its loop.
#[derive(Clone, Debug)]
pub struct TestWatch {
    told: Vec<Instructions>,
    actuators: Vec<Watch>,
    events: Vec<WatchEvent>,
    corrections: Vec<CorrectionStep>,
    not_watched: Vec<String>,
    steps: u64,
    /// Blocks that were judged; fewer than were full where steps of a board were lost.
    blocks: u64,
    steps_per_s: f64,
    rate_hz: f64,
    learns: bool,
}

/// Blocks at the end of a test that nobody has to judge.
const UNSEEN_BLOCKS: u64 = 8;
/// A correction is noted when it has changed by more than this, in its unit, and so long after the last one, s of the model.
const CHANGED: f64 = 1e-3;
const LEAST_S: f64 = 0.05;

impl TestWatch {
    /// For `test`. `None` where the watch is off or nothing moves.
    ///
    /// # Errors
    /// A declared value that cannot be watched; something to do where it cannot be done.
    pub fn of(test: &TestFile, place: &Place<'_>) -> Result<Option<Self>, Failure> {
        let (settings, hz) = (&test.watch, place.first_hz);
        // Of two actuators on one coupler the coordinates are not the actuators'.
        if !settings.on || test.coupled.is_some() || hz <= 0.0 || hz.is_nan() {
            return Ok(None);
        }
        let timing = &test.config.timing;
        let mut not_watched = Vec::new();
        let (mut told, mut actuators) = (Vec::new(), Vec::new());
        let peaks_m = place.ideal.peaks_m();
        let floors = test.config.physical_storeys();
        for (j, &peak_m) in peaks_m.iter().enumerate().take(floors) {
            let actions = actions(test, place, (j, peak_m))?;
            let declared = declared(test, j, peak_m, TAU * hz / timing.time_scale);
            for sentence in gaps(test, &declared) {
                if !not_watched.contains(&sentence) {
                    not_watched.push(sentence);
                }
            }
            let own = Instructions { declared, actions };
            match Watch::new(&own) {
                Ok(watch) => {
                    actuators.push(watch);
                    told.push(own);
                }
                Err(refusal) => not_watched.push(format!("Actuator {}: {refusal}", j + 1)),
            }
        }
        // A block has all of them, in turn.
        if told.len() < floors.min(peaks_m.len()) {
            told.clear();
            actuators.clear();
        }
        Ok(Some(Self {
            told,
            actuators,
            events: Vec::new(),
            corrections: Vec::new(),
            not_watched,
            steps: 0,
            blocks: 0,
            steps_per_s: timing.rate_hz * timing.time_scale,
            rate_hz: timing.rate_hz,
            learns: test.config.compensation.kind.predictor.learns(),
        }))
    }

    fn state(&self) -> State {
        let states = self.actuators.iter().map(Watch::state);
        states.max().unwrap_or_default()
    }

    fn number(&self, j: usize) -> Option<usize> {
        (self.actuators.len() > 1).then_some(j + 1)
    }

    fn set(&self) -> Vec<NamedCause> {
        let mut set = Vec::new();
        for (j, watch) in self.actuators.iter().enumerate() {
            set.extend(watch.findings().map(|f| {
                let (value, sd) = (f64::from(f.value), f64::from(f.sd));
                let corrected = f64::from(watch.corrected(f.cause));
                NamedCause {
                    name: f.cause.name(),
                    side: f.cause.side().name(),
                    actuator: self.number(j),
                    value,
                    unit: f.cause.unit(),
                    ci90: [value - NINETY * sd, value + NINETY * sd],
                    corrected: (corrected != 0.0).then_some(corrected),
                }
            }));
        }
        set
    }

    fn now_s(&self) -> f64 {
        self.steps as f64 / self.steps_per_s
    }

    fn note(&mut self) {
        let set = self.set();
        let holds = |watch: &Watch| watch.axis_orders().hold;
        let event = WatchEvent {
            t_s: self.now_s(),
            state: self.state().name(),
            corrected: set.iter().any(|cause| cause.corrected.is_some()),
            held: self.learns && self.actuators.iter().any(holds),
            set,
        };
        self.events.push(event);
    }

    /// Notes the corrections that have changed, at most 20 times a second.
    fn note_corrections(&mut self) {
        let now_s = self.now_s();
        for (j, watch) in self.actuators.iter().enumerate() {
            for &cause in Cause::ALL {
                let corrected = f64::from(watch.corrected(cause));
                let actuator = self.number(j);
                let own = |c: &&CorrectionStep| {
                    (c.name, c.side, c.actuator) == (cause.name(), cause.side().name(), actuator)
                };
                let last = self.corrections.iter().rev().find(own);
                let (last_s, before) = last.map_or((-1.0, 0.0), |c| (c.t_s, c.corrected));
                if now_s - last_s < LEAST_S || (corrected - before).abs() <= CHANGED {
                    continue;
                }
                self.corrections.push(CorrectionStep {
                    t_s: now_s,
                    name: cause.name(),
                    side: cause.side().name(),
                    actuator,
                    corrected,
                    unit: cause.unit(),
                });
            }
        }
    }

    /// What it had to say. The last event is what had settled at the end.
    pub fn report(mut self) -> WatchReport {
        let blocks = self.steps / u64::from(steps_in_block(self.rate_hz));
        let seen_s =
            self.blocks as f64 * f64::from(steps_in_block(self.rate_hz)) / self.steps_per_s;
        if !self.told.is_empty() && self.blocks + UNSEEN_BLOCKS < blocks {
            self.not_watched.push(format!(
                "Names and values end at {seen_s:.2} s, where steps were lost on their way from the board: its own watch went on, and \
                 `outerloop board status` has what it named."
            ));
        }
        if self.events.last().is_some_and(|last| !last.set.is_empty()) {
            self.note();
        }
        WatchReport {
            state: self.state().name(),
            events: self.events,
            corrections: self.corrections,
            not_watched: self.not_watched,
        }
    }
}

impl TestObserver for TestWatch {
    fn on_step(&mut self, _: &AnyRecord<'_>) {
        self.steps += 1;
    }

    fn watches_the_loop(&mut self) -> Option<Vec<Instructions>> {
        (!self.told.is_empty()).then(|| self.told.clone())
    }

    fn judge(&mut self, blocks: &[Block], orders: &mut [AxisOrders]) -> Verdict {
        self.blocks += 1;
        let verdict = judge(self.actuators.iter_mut(), blocks, orders);
        if verdict.changed {
            self.note();
        }
        self.note_corrections();
        verdict
    }
}

/// What the watch of `test` may do about the actuator of a floor that is planned to move by so much.
fn actions(
    test: &TestFile,
    place: &Place<'_>,
    (floor, peak_m): (usize, f64),
) -> Result<Actions, Failure> {
    let (settings, config) = (&test.watch, &test.config);
    let correct = settings.corrections().map_err(Failure::input)?;
    let method = config.compensation.kind;
    if (correct.lateness || correct.gain) && method.predictor.learns() {
        return Err(Failure::input(format!(
            "watch.correct = {:?} is refused with the compensation {method}, which learns lateness and gain itself: accepted with \
             it is [\"late_sensor\"]",
            settings.correct
        )));
    }
    let ratio = config.structure.damping_ratio.first().copied();
    Ok(Actions {
        hold: settings.guard,
        trip: true,
        correct,
        error_limit: settings.trip_eps.map(|largest| ErrorLimit {
            largest,
            damping_ratio: ratio.unwrap_or(0.0),
            duration_s: place.seconds * config.timing.time_scale,
            planned_rms: place.ideal.rms_m(floor).map(|rms| rms / peak_m),
        }),
    })
}

/// What the watch of actuator `j` is told.
fn declared(test: &TestFile, j: usize, peak_m: f64, omega_rad_per_s: f64) -> Declared {
    let config = &test.config;
    let structure = &config.structure;
    let stiffness = &structure.stiffness_n_per_m;
    let holds = stiffness[j] + stiffness.get(j + 1).copied().unwrap_or(0.0);
    let model = test.declared.clone().unwrap_or_default();
    let actuator = model.actuator.clone().unwrap_or_default();
    let specimen = model.specimen.clone().unwrap_or_default();
    let known = Departures::of_model(&model, config.compensation.delay_ms.at(0));
    let tolerance = |d: Option<diagnosis::Declared>| d.map_or(0.0, |d| d.tolerance);
    let late_ms = tolerance(actuator.delay_ms).hypot(tolerance(actuator.lag_ms));
    let [delay_ms, lag_ms] = known.late_ms();
    let single = config.physical_storeys() == 1 && config.degrees_of_freedom() == 1;
    let stiffness_n_per_m = match specimen.stiffness_n_per_mm {
        Some(k) if single && k.value > 0.0 => 1e3 * k.value,
        _ => holds,
    };
    let value = |d: Option<diagnosis::Declared>| d.map_or(0.0, |d| d.value);
    let mut noise = noise_rms(config, &test.plant);
    if config.estimation.kind == outerloop_core::config::Filter::Off {
        // Nobody has declared a noise: it is learned.
        noise = [0.0; 2];
    }
    Declared {
        rate_hz: config.timing.rate_hz,
        omega_rad_per_s,
        peak_m,
        stiffness_n_per_m,
        stiffness_tolerance: 1e3 * tolerance(specimen.stiffness_n_per_mm) / stiffness_n_per_m,
        actuator: DeclaredActuator {
            gain: known[Quantity::CommandGain],
            delay_s: 1e-3 * delay_ms,
            lag_s: 1e-3 * lag_ms,
            offset_m: 1e-3 * known[Quantity::CommandOffset],
            tolerances: [
                tolerance(actuator.gain),
                1e-3 * late_ms,
                1e-3 * tolerance(actuator.offset_mm),
            ],
        },
        alone: single,
        has_actuator: model.actuator.is_some() && can_be_told(&model, true),
        has_specimen: single && specimen.stiffness_n_per_mm.is_some() && can_be_told(&model, false),
        elastic: specimen.effects.is_empty() && specimen.elements.is_empty(),
        damping_n_s_per_m: 1e3 * value(specimen.damping_n_s_per_mm),
        mass_kg: value(specimen.mass_kg),
        force_gain: known[Quantity::ForceGain],
        force_offset_n: value(specimen.offset_n),
        noise,
    }
}

/// True if all that is declared of actuator or specimen is what the watch knows.
fn can_be_told(model: &Model, actuator: bool) -> bool {
    use plant::Effect;
    if actuator {
        let own = model.actuator.iter();
        own.flat_map(|a| &a.effects)
            .all(|e| matches!(e.name, Effect::SecondLag))
            && model.actuator.iter().all(|a| a.remainder.is_none())
    } else {
        let own = model.specimen.iter();
        own.flat_map(|s| &s.effects).all(|e| {
            matches!(
                e.name,
                Effect::GainError | Effect::BilinearHysteresis | Effect::BoucWenHysteresis
            )
        }) && model.specimen.iter().all(|s| s.remainder.is_none())
    }
}

/// What is not watched, and what would do.
fn gaps(test: &TestFile, d: &Declared) -> Vec<String> {
    let mut said = Vec::new();
    if !d.has_actuator {
        said.push(
            "Command to displacement is not watched: it takes a table [declared.actuator] with gain, delay, lag and offset alone."
                .to_owned(),
        );
    }
    if !d.has_specimen {
        said.push(if test.config.degrees_of_freedom() > 1 {
            "Displacement to force is not watched: the force of a floor depends on its neighbours.".to_owned()
        } else {
            "Displacement to force is not watched: it takes declared.specimen.stiffness_n_per_mm, without effects beside it."
                .to_owned()
        });
    }
    said
}
