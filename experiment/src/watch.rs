//! The rig watch of a test: what is declared to it, and what it had to say.

use crate::failure::Failure;
use crate::files::test::TestFile;
use crate::numbers::three;
use crate::rig::{Departures, Quantity, noise_rms};
use crate::trace::{AnyRecord, TestObserver};
use diagnosis::Model;
use outerloop_core::watch::{Declared, DeclaredActuator, State, Tap, Watch};
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
    /// True if the loop corrects for it.
    pub corrected: bool,
}

/// What the watch had to say of a test. The keys are a contract.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WatchReport {
    /// The state at the end.
    pub state: &'static str,
    /// Every change; the last holds what had settled at the end.
    pub events: Vec<WatchEvent>,
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
        format!(
            "The watch named, first at {:.2} s: {what}.{stopped}",
            first.t_s
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

/// Watches a running test.
#[derive(Clone, Debug)]
pub struct TestWatch {
    actuators: Vec<(Tap, Watch)>,
    events: Vec<WatchEvent>,
    not_watched: Vec<String>,
    steps: u64,
    steps_per_s: f64,
}

impl TestWatch {
    /// For `test`, which is planned to move by `peaks_m`, floor by floor, of a structure with this first natural frequency.
    /// `None` where the watch is off or nothing moves.
    ///
    /// # Errors
    /// A declared value that cannot be watched.
    pub fn of(test: &TestFile, peaks_m: &[f64], first_hz: f64) -> Result<Option<Self>, Failure> {
        // Of two actuators on one coupler the coordinates are not the actuators'.
        if !test.watch.on || test.coupled.is_some() || first_hz <= 0.0 || first_hz.is_nan() {
            return Ok(None);
        }
        let timing = &test.config.timing;
        let mut not_watched = Vec::new();
        let mut actuators = Vec::new();
        let floors = test.config.physical_storeys().min(peaks_m.len());
        for (j, &peak_m) in peaks_m.iter().enumerate().take(floors) {
            let declared = declared(test, j, peak_m, TAU * first_hz / timing.time_scale);
            for sentence in gaps(test, &declared) {
                if !not_watched.contains(&sentence) {
                    not_watched.push(sentence);
                }
            }
            match Watch::new(&declared) {
                Ok(watch) => actuators.push((Tap::new(timing.rate_hz), watch)),
                Err(refusal) => not_watched.push(format!("Actuator {}: {refusal}", j + 1)),
            }
        }
        Ok(Some(Self {
            actuators,
            events: Vec::new(),
            not_watched,
            steps: 0,
            steps_per_s: timing.rate_hz * timing.time_scale,
        }))
    }

    fn state(&self) -> State {
        let states = self.actuators.iter().map(|(_, watch)| watch.state());
        states.max_by_key(|state| *state as u8).unwrap_or_default()
    }

    fn set(&self) -> Vec<NamedCause> {
        let several = self.actuators.len() > 1;
        let mut set = Vec::new();
        for (j, (_, watch)) in self.actuators.iter().enumerate() {
            set.extend(watch.findings().map(|f| {
                let (value, sd) = (f64::from(f.value), f64::from(f.sd));
                NamedCause {
                    name: f.cause.name(),
                    side: f.cause.side().name(),
                    actuator: several.then_some(j + 1),
                    value,
                    unit: f.cause.unit(),
                    ci90: [value - NINETY * sd, value + NINETY * sd],
                }
            }));
        }
        set
    }

    fn note(&mut self) {
        let event = WatchEvent {
            t_s: self.steps as f64 / self.steps_per_s,
            state: self.state().name(),
            set: self.set(),
            corrected: false,
        };
        self.events.push(event);
    }

    /// What it had to say. The last event is what had settled at the end.
    pub fn report(mut self) -> WatchReport {
        if self.events.last().is_some_and(|last| !last.set.is_empty()) {
            self.note();
        }
        WatchReport {
            state: self.state().name(),
            events: self.events,
            not_watched: self.not_watched,
        }
    }
}

impl TestObserver for TestWatch {
    fn on_step(&mut self, record: &AnyRecord<'_>) {
        self.steps += 1;
        let mut changed = false;
        for (j, (tap, watch)) in self.actuators.iter_mut().enumerate() {
            let (command, x) = (record.sent_m[j], record.displacement_m[j]);
            if let Some(block) = tap.add(command, x, record.force_n[j]) {
                changed |= watch.add(&block);
            }
        }
        if changed {
            self.note();
        }
    }
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
