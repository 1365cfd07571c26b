//! What a test is judged by, in figures and in words.

use crate::bench::{Ending, OnBoard};
use crate::compensation::Compensation;
use crate::coupled::figures::CoupledFigures;
use crate::coupled::interface::InterfaceScore;
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::numbers::{percent, si, three};
use crate::score::Score;
use crate::watch::WatchReport;
use outerloop_core::{Fault, Mode, Trip};
use schemars::JsonSchema;
use serde::Serialize;

/// From this eps_rms on, a result is not the structure's, however stable the test was.
pub const POOR_EPS_RMS: f64 = 0.1;
/// Up to this eps_rms a result is as good as other uncertainties of a test.
pub const GOOD_EPS_RMS: f64 = 0.02;
/// From this share of locked steps on, the added damping holds the structure in place, if the motion is wrong, too.
const LOCKED_SHARE: f64 = 0.2;

/// How a test ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TestVerdict {
    /// It ran to its end.
    Completed,
    /// An interlock or the rig watch ended it.
    Tripped,
    /// It ran away: in the last fifth of the test the error was above the largest ideal displacement, or the motion became so
    /// large that the simulation was stopped.
    Diverged,
    /// Stopped before its end: by the operator, or by the PC because a board computed a step differently.
    Stopped,
}

impl TestVerdict {
    /// The word in JSON and tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Completed => "completed",
            Self::Tripped => "tripped",
            Self::Diverged => "diverged",
            Self::Stopped => "stopped",
        }
    }
}

/// What the figures of a test are worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Validity {
    /// The structure's own response, as far as the actuator goes.
    Good,
    /// Usable if its error is said beside it.
    Fair,
    /// Not the structure's response.
    Bad,
}

impl Validity {
    /// Its class in the style sheet of reports.
    pub const fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Fair => "fair",
            Self::Bad => "bad",
        }
    }
}

/// The figures of one test. The keys are a contract.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Summary {
    /// Name of the ground motion.
    pub record: String,
    /// Name of the compensation.
    pub compensation: &'static str,
    /// Control steps of the running test.
    pub steps: usize,
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// How it ended.
    pub verdict: TestVerdict,
    /// Name of the fault.
    pub trip: Option<&'static str>,
    /// Eq 17, worst floor.
    pub eps_max: f64,
    /// Eq 18, worst floor.
    pub eps_rms: f64,
    /// Eq 17, floor by floor.
    pub eps_max_by_floor: Vec<f64>,
    /// Eq 18, floor by floor.
    pub eps_rms_by_floor: Vec<f64>,
    /// Largest displacement of any floor, m.
    pub peak_displacement_m: f64,
    /// Mean of C_cor over twice mass times natural frequency, first floor.
    pub mean_added_damping_ratio: f64,
    /// Largest of the same.
    pub peak_added_damping_ratio: f64,
    /// Cumulative Eq 12, J.
    pub energy_error_j: f64,
    /// Cumulative HSEM, J.
    pub energy_error_hsem_j: f64,
    /// Cumulative Eq 6, J.
    pub energy_error_stiffness_j: f64,
    /// Remaining energy error, relative to the energy in the test.
    pub energy_ratio: f64,
    /// Share of the steps in which the structure counted as locked by its own added damping.
    pub locked_share: f64,
    /// Share of the steps in which the innovation did not fit the estimator's model of the rig.
    pub model_doubt_share: f64,
    /// When a simulated test that ran away was stopped, s of laboratory time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped_s: Option<f64>,
    /// Natural frequencies of the structure, Hz.
    pub natural_frequencies_hz: Vec<f64>,
    /// Factor on the ground motion.
    pub record_scale: f64,
    /// The report of the rig watch; null if it was off.
    pub watch: Option<WatchReport>,
    /// Seconds on the wall clock.
    pub wall_s: f64,
    /// What a board reports; only of a test on a board.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub board: Option<OnBoard>,
    /// The fault with its value and limit.
    #[serde(skip)]
    pub trip_detail: Option<Trip>,
    /// What only a test of two coupled actuators has; its keys stand among the others.
    #[serde(flatten)]
    pub coupled: Option<CoupledFigures>,
}

/// A fault that has no value: it is there or it is not.
const fn is_fact(fault: Fault) -> bool {
    matches!(
        fault,
        Fault::AdcRail
            | Fault::DeadlineMissed
            | Fault::LinkLost
            | Fault::EmergencyStop
            | Fault::PermitChain
            | Fault::Output
            | Fault::Disagree
            | Fault::ForceStands
            | Fault::Starved
            | Fault::Memory
    )
}

/// What is said where a simulated test did not run to its end although nothing tripped.
const STOPPED: &str =
    " The simulation was stopped there: no limit was declared, and no rig could follow.";

/// What tripped, beside its limit, in the unit of the fault.
fn against_limit(t: Trip) -> String {
    against_limit_in(t, t.fault.unit())
}

fn against_limit_in(t: Trip, unit: &str) -> String {
    let value = si(f64::from(t.value), unit);
    // What core takes for a limit that was not declared: only a number that overflows is beyond it.
    if t.limit >= f32::MAX {
        format!("{value}; no limit was declared, and the number left what can be computed")
    } else {
        format!(
            "{value} against a limit of {}",
            si(f64::from(t.limit), unit)
        )
    }
}

impl Summary {
    /// Judges a test that ended with `ending`.
    pub fn of(
        e: &Experiment,
        compensation: Compensation,
        (score, interface): (&Score<'_>, Option<&InterfaceScore>),
        ending: &Ending,
    ) -> Self {
        let worst = |floors: &[f64]| floors.iter().copied().fold(0.0, f64::max);
        let (eps_max_by_floor, eps_rms_by_floor) = (score.eps_max(), score.eps_rms());
        let share = |n: usize, of: usize| n as f64 / of.max(1) as f64;
        let per_critical = e.per_critical();
        let energy = &score.energy;
        let [
            energy_error_j,
            energy_error_hsem_j,
            energy_error_stiffness_j,
        ] = interface.map_or_else(
            || [energy.modified_j, energy.hsem_j, energy.stiffness_j].map(f64::from),
            |interface| interface.energy_j,
        );
        let coupled = interface
            .zip(e.test.coupled.as_deref())
            .map(|(score, part)| {
                let eps = (&eps_max_by_floor[..], &eps_rms_by_floor[..]);
                CoupledFigures::of(part, score, eps, ending.trip, ending.actuators)
            });
        Self {
            record: e.record.clone(),
            compensation: compensation.name(),
            steps: score.control_steps,
            rate_hz: e.test.config.timing.rate_hz,
            verdict: match ending.mode {
                Mode::Tripped => TestVerdict::Tripped,
                _ if score.ran_away() => TestVerdict::Diverged,
                _ if ending.by_hand => TestVerdict::Stopped,
                _ => TestVerdict::Completed,
            },
            trip: ending.trip.map(|t| t.fault.name()),
            eps_max: worst(&eps_max_by_floor),
            eps_rms: worst(&eps_rms_by_floor),
            eps_max_by_floor,
            eps_rms_by_floor,
            peak_displacement_m: score.peak_m(e.floors_in_m()),
            mean_added_damping_ratio: score.mean_damping() * per_critical,
            peak_added_damping_ratio: score.largest_damping * per_critical,
            energy_error_j,
            energy_error_hsem_j,
            energy_error_stiffness_j,
            energy_ratio: score.energy_ratio,
            locked_share: share(score.locked, score.compared),
            model_doubt_share: share(score.doubtful, score.control_steps),
            stopped_s: (ending.mode.integrates()
                && score.ran_away()
                && score.control_steps < e.control_steps())
            .then(|| score.control_steps as f64 / e.test.config.timing.rate_hz),
            natural_frequencies_hz: e.natural_frequencies_hz(),
            record_scale: e.scale,
            watch: None,
            wall_s: ending.wall_s,
            board: ending.board.clone(),
            trip_detail: ending.trip,
            coupled,
        }
    }

    /// True if the added damping held the structure in place.
    pub fn locked(&self) -> bool {
        self.locked_share > LOCKED_SHARE && self.eps_rms > GOOD_EPS_RMS
    }

    /// eps_rms, or infinite of a test that did not run to its end: what tests are ranked by.
    pub fn error(&self) -> f64 {
        match self.verdict {
            TestVerdict::Completed => self.eps_rms,
            TestVerdict::Tripped | TestVerdict::Diverged | TestVerdict::Stopped => f64::INFINITY,
        }
    }

    /// What the figures are worth.
    pub fn validity(&self) -> Validity {
        match self.verdict {
            TestVerdict::Completed if self.locked() => Validity::Bad,
            TestVerdict::Completed if self.eps_rms <= GOOD_EPS_RMS => Validity::Good,
            TestVerdict::Completed if self.eps_rms <= POOR_EPS_RMS => Validity::Fair,
            // What is not a number is not the structure's response either.
            TestVerdict::Completed => Validity::Bad,
            TestVerdict::Tripped | TestVerdict::Diverged | TestVerdict::Stopped => Validity::Bad,
        }
    }

    /// What the exit status says of the test.
    ///
    /// # Errors
    /// A test that tripped, ran away, or is not the structure's response.
    pub fn outcome(&self) -> Result<(), Failure> {
        match self.validity() {
            Validity::Good | Validity::Fair => Ok(()),
            Validity::Bad => Err(Failure::test(self.sentence())),
        }
    }

    /// How a test ended that tripped.
    fn of_trip(&self, t: Trip) -> String {
        let name = t.fault.name();
        let after = format!(
            "after {:.2} s of the laboratory",
            self.steps as f64 / self.rate_hz
        );
        match t.fault {
            fault if is_fact(fault) => format!("Tripped on {name} {after}."),
            // A limit is above zero; this is what a board reports of its own converter.
            Fault::Displacement if t.limit == 0.0 => format!(
                "Tripped on {name} {after}: the command left the range of the board's converter; `outerloop board calibrate` \
                 shows it."
            ),
            Fault::Watch if t.limit == 0.0 => format!(
                "Stopped by the rig watch {after}: a sensor stands still while the rest moves."
            ),
            Fault::Watch => format!(
                "Stopped by the rig watch {after}: what it named would bring the error to {} rms of the largest displacement, \
                 against watch.trip_eps = {}.",
                percent(f64::from(t.value)),
                three(f64::from(t.limit))
            ),
            Fault::Reading => format!(
                "Tripped on {name} {after}: the actuator was read further out than it was sent, {}.",
                against_limit(t)
            ),
            _ => {
                let (what, against) = self.trip_in_words(t);
                format!("Tripped on {what} {after}: {against}.")
            }
        }
    }

    /// What `t` tripped on, and its value against its limit.
    pub(crate) fn trip_in_words(&self, t: Trip) -> (String, String) {
        let name = t.fault.name();
        match &self.coupled {
            None => (name.to_owned(), against_limit(t)),
            Some(coupled) => (
                format!("{name} of {}", coupled.trip_axis.unwrap_or("the rig")),
                against_limit_in(t, CoupledFigures::unit_of(t)),
            ),
        }
    }

    /// What happened, in a plain sentence.
    pub fn sentence(&self) -> String {
        let (rms, max) = (percent(self.eps_rms), percent(self.eps_max));
        let (actuator, whole) = match self.coupled {
            None => ("the actuator puts", "the largest ideal displacement"),
            Some(_) => (
                "the actuators put",
                "the largest ideal motion of the worst coordinate",
            ),
        };
        let error = format!("{rms} rms and {max} at most, of {whole}");
        match (self.verdict, self.trip_detail) {
            (TestVerdict::Tripped, Some(t)) => self.of_trip(t),
            (TestVerdict::Diverged, _) => format!(
                "Ran away: the error grew to {max} of {whole}, because {actuator} in more energy than the structure \
                 dissipates.{}",
                if self.stopped_s.is_some() {
                    STOPPED
                } else {
                    ""
                }
            ),
            (TestVerdict::Stopped, _) => format!(
                "{} after {:.2} s of the laboratory, before its end. What was recorded until then is kept; up to there the \
                 error is {error}.",
                self.stopped_by(),
                self.steps as f64 / self.rate_hz,
            ),
            _ if self.locked() => format!(
                "Locked: the added damping held the structure in place for {:.0} % of the test. It looks stable, but \
                 this is not how the structure moves (eps_rms {rms}).",
                self.locked_share * 100.0
            ),
            _ => match self.validity() {
                Validity::Good => {
                    format!(
                        "Ran to its end and moved as the structure would: the error is {error}."
                    )
                }
                Validity::Fair => format!(
                    "Ran to its end with a visible error: {error}. Say so beside the result."
                ),
                Validity::Bad => format!(
                    "Stable but wrong: the error is {error}. This is not the structure's response."
                ),
            },
        }
    }

    /// Who stopped it.
    fn stopped_by(&self) -> &'static str {
        let board = self.board.as_ref();
        match board.is_some_and(|board| board.steps_different > 0) {
            true => "Stopped by the PC, since the board worked a step out otherwise,",
            false => "Stopped by hand",
        }
    }
}
