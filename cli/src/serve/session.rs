//! One client from its first message to its last.

use super::element::DeclaredElement;
use super::ledger::{CoordinateFigures, Followed, Ledger, SessionSummary, SessionVerdict};
use super::mover::{Mover, Stop, TargetMeasurement};
use super::waiting_room::Arrival;
use super::wire::{Action, ClientConnection, ClientGone, TrialResponse};
use crate::terminal::interrupt;
use outerloop_core::Pace;
use std::fmt;
use std::time::Instant;

/// Share of the largest target within which two displacements of a step are the same.
const SAME: f64 = 1e-9;
/// Relative difference accepted between the model's time step and the loop's.
const SAME_STEP: f64 = 1e-6;

/// Why a session ended before its last message.
#[derive(Clone, Debug, PartialEq)]
enum End {
    Client(ClientGone),
    Nonsense(String),
    Refused(String),
    Rig(Stop),
    Completed,
}

impl From<ClientGone> for End {
    fn from(gone: ClientGone) -> Self {
        match gone {
            ClientGone::Nonsense(what) => Self::Nonsense(what),
            gone => Self::Client(gone),
        }
    }
}

impl From<Stop> for End {
    fn from(stop: Stop) -> Self {
        Self::Rig(stop)
    }
}

impl fmt::Display for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tripped(trip) => write!(
                f,
                "the rig tripped on {} at {} against a limit of {}",
                trip.fault.name(),
                trip.value,
                trip.limit
            ),
            Self::Operator => f.write_str("the operator stopped the rig"),
            Self::Lost(why) => write!(f, "the rig is lost: {why}"),
        }
    }
}

/// The state of a session.
struct Session<'a> {
    element: &'a DeclaredElement,
    rig: &'a mut dyn Mover,
    /// The trial last sent by the model.
    trial: Option<TrialResponse>,
    /// Where the rig was last sent, and what was measured there; `None` before the first target.
    last: Option<(TrialResponse, TargetMeasurement)>,
    /// The step of the last target has been accepted.
    committed: bool,
    commits: usize,
    first: Option<Instant>,
    answered: Option<Instant>,
}

/// A client that has been served: its figures, and its connection if it may still be listening.
pub struct Served {
    /// The figures.
    pub summary: SessionSummary,
    /// Its first message was received and is valid.
    pub spoke: bool,
    wire: Option<ClientConnection>,
}

/// How long a client that is no longer served may be silent before the connection is closed.
const FAREWELL_S: f64 = 3.0;

impl Served {
    /// Answers NaN to every further request of the client until it leaves. OpenSees 3.7 never notices a closed
    /// connection: it would wait forever at full load. By now the rig's PERMIT is low, or the rig does not respond.
    pub fn answer_nan_until_gone(self) {
        let Some(mut wire) = self.wire else { return };
        wire.set_timeout(FAREWELL_S);
        loop {
            if wire.owes_an_answer() && wire.answer_nan().is_err() {
                return;
            }
            match wire.next_message() {
                Ok(Some(message)) if message.action == Action::End => return,
                Ok(_) => {}
                Err(_) => return,
            }
        }
    }
}

/// Serves one client with `rig`, and drops PERMIT whatever happens.
pub fn serve_client(arrival: Arrival, element: &DeclaredElement, rig: &mut dyn Mover) -> Served {
    let mut session = Session {
        element,
        rig,
        trial: None,
        last: None,
        committed: true,
        commits: 0,
        first: None,
        answered: None,
    };
    let client = arrival.client.to_string();
    let (end, wire) = session.talk(arrival);
    let ended = session.rig.end();
    let listens = !matches!(end, End::Completed | End::Client(_) | End::Nonsense(_));
    // A failure to end the rig overrides any earlier reason.
    let end = match ended {
        Err(why) => Stop::Lost(why.to_string()).into(),
        Ok(()) => end,
    };
    Served {
        summary: session.summary(&client, end),
        spoke: wire.is_some(),
        wire: wire.filter(|_| listens),
    }
}

impl Session<'_> {
    fn talk(&mut self, arrival: Arrival) -> (End, Option<ClientConnection>) {
        let timeout_s = self.element.settings.timeout_s;
        let rig = &mut *self.rig;
        let watch = || operator().and_then(|()| Ok(rig.meanwhile()?));
        match ClientConnection::open(
            (arrival.stream, arrival.at),
            self.element.coordinates.len(),
            timeout_s,
            watch,
        ) {
            Ok(mut wire) => {
                let end = self
                    .answer_client(&mut wire)
                    .err()
                    .unwrap_or(End::Completed);
                (end, Some(wire))
            }
            Err(end) => (end, None),
        }
    }

    fn answer_client(&mut self, wire: &mut ClientConnection) -> Result<(), End> {
        loop {
            operator()?;
            let Some(message) = wire.next_message()? else {
                self.rig.meanwhile()?;
                continue;
            };
            if let Some(trial) = message.trial {
                self.trial = Some(self.checked(trial)?);
            }
            let coordinates = &self.element.coordinates;
            let n = coordinates.len();
            match message.action {
                Action::Trial => {}
                Action::Commit => {
                    self.committed = true;
                    self.commits += 1;
                }
                Action::Force => {
                    let reached = self.move_to_trial(wire)?;
                    let forces = reached.force_n.iter().zip(coordinates);
                    let forces = forces.map(|(force, c)| force / c.force_per_wire);
                    wire.answer(&forces.collect::<Vec<_>>())?;
                    self.answered = Some(Instant::now());
                }
                Action::Displacement => {
                    let reached = self.last.as_ref().map(|(_, r)| &r.displacement_m);
                    let zeros = vec![0.0; n];
                    let shown = reached.unwrap_or(&zeros).iter().zip(coordinates);
                    let shown = shown.map(|(u, c)| u / c.displacement_per_wire);
                    wire.answer(&shown.collect::<Vec<_>>())?;
                }
                Action::Time => {
                    wire.answer(&[self.trial.as_ref().map_or(0.0, |t| t.time_s)])?;
                }
                Action::InitialStiffness | Action::TangentStiffness => {
                    wire.answer(&self.element.stiffness_on_wire())?;
                }
                // They are part of the measured force.
                Action::Damping | Action::Mass => wire.answer(&vec![0.0; n * n])?,
                Action::End => return Ok(()),
            }
        }
    }

    /// Checks a trial displacement and gives it in m or rad.
    fn checked(&self, mut trial: TrialResponse) -> Result<TrialResponse, End> {
        let time_s = trial.time_s;
        let places = trial.displacement.iter_mut().zip(&self.element.coordinates);
        for ((u, c), j) in places.zip(1..) {
            let sent = *u;
            *u *= c.displacement_per_wire;
            if !(-c.limit..=c.limit).contains(u) {
                return Err(End::Refused(format!(
                    "the client sends displacement {j} = {sent} at {time_s} s, which the rig is not moved to: accepted are \
                     {} {} ({}) to both sides",
                    c.limit, c.unit, c.limit_key
                )));
            }
        }
        if !time_s.is_finite() {
            return Err(End::Refused(format!(
                "the client sends the time {time_s}: accepted are seconds"
            )));
        }
        Ok(trial)
    }

    /// The force at the trial: by moving there, or as measured before if the rig is already there.
    fn move_to_trial(&mut self, wire: &mut ClientConnection) -> Result<&TargetMeasurement, End> {
        let Some(trial) = self.trial.clone() else {
            return Err(End::Refused(
                "the client asks for a force before it has sent a displacement: accepted is a trial response first".into(),
            ));
        };
        if let Some((before, _)) = &self.last {
            let apart = before.displacement.iter().zip(&trial.displacement);
            let same_place = apart
                .zip(&self.element.coordinates)
                .all(|((a, b), c)| (a - b).abs() <= SAME * c.limit);
            let same_step = !self.committed && before.time_s == trial.time_s;
            if same_step && !same_place {
                return Err(End::Refused(format!(
                    "the model asks for the force at a second displacement at {} s, in the same step: an integrator that \
                     iterates would make the specimen hunt; accepted are those with one displacement a step, such as \
                     NewmarkExplicit, AlphaOS and AlphaOSGeneralized, with the algorithm Linear",
                    trial.time_s
                )));
            }
            if !(same_place && before.time_s == trial.time_s) {
                self.check_time(before.time_s, trial.time_s)?;
                self.go_to(trial)?;
            }
        } else {
            self.first = Some(Instant::now());
            self.rig.begin().map_err(|e| End::Refused(e.to_string()))?;
            wire.set_poll_interval(self.rig.needs_care())?;
            self.go_to(trial)?;
        }
        self.last
            .as_ref()
            .map(|(_, reached)| reached)
            .ok_or_else(|| End::Refused("no force was measured".into()))
    }

    fn go_to(&mut self, trial: TrialResponse) -> Result<(), End> {
        self.committed = false;
        let reached = self.rig.go_to(&trial.displacement)?;
        self.last = Some((trial, reached));
        Ok(())
    }

    /// Checks that the model's time does not run backwards, and that its steps are the loop's if the rig moves
    /// continuously.
    fn check_time(&self, before_s: f64, now_s: f64) -> Result<(), End> {
        if now_s < before_s {
            return Err(End::Refused(format!(
                "the model goes back from {before_s} s to {now_s} s: accepted is time that does not decrease, since a \
                 specimen cannot be moved back in its history"
            )));
        }
        let (step_s, model_s) = (now_s - before_s, self.element.model_step_s);
        let continuous = self.element.settings.pace == Pace::Continuous;
        if continuous && !(-SAME_STEP..=SAME_STEP).contains(&(step_s / model_s - 1.0)) {
            return Err(End::Refused(format!(
                "the model goes from {before_s} s to {now_s} s, and the loop's integration step is {model_s} s: accepted is \
                 that step (loop.substeps / loop.rate_hz / loop.time_scale)"
            )));
        }
        Ok(())
    }

    /// The figures of each coordinate that has a name.
    fn coordinate_figures(&self, ledger: &Ledger) -> Vec<CoordinateFigures> {
        let all = self.element.coordinates.iter().enumerate();
        let named = all.filter_map(|(j, c)| {
            let followed = ledger.followed.get(j).copied().unwrap_or_default();
            Some(CoordinateFigures::of(c.name.clone()?, &followed))
        });
        named.collect()
    }

    fn summary(&mut self, client: &str, end: End) -> SessionSummary {
        let (verdict, reason, trip) = match &end {
            End::Completed => (SessionVerdict::Completed, None, None),
            End::Client(gone) => (SessionVerdict::Lost, Some(gone.to_string()), None),
            End::Refused(why) | End::Nonsense(why) => {
                (SessionVerdict::Refused, Some(why.clone()), None)
            }
            End::Rig(stop) => {
                let (verdict, trip) = match stop {
                    Stop::Tripped(trip) => (SessionVerdict::Tripped, Some(trip.fault.name())),
                    Stop::Operator => (SessionVerdict::Stopped, None),
                    Stop::Lost(_) => (SessionVerdict::RigLost, None),
                };
                (verdict, Some(stop.to_string()), trip)
            }
        };
        // For a rig that was not moved for this client, the ledger still has the figures of the last one.
        let ledger = match self.first {
            Some(_) => self.rig.ledger().clone(),
            None => Ledger::default(),
        };
        let wall_s = match (self.first, self.answered) {
            (Some(first), Some(last)) => last.duration_since(first).as_secs_f64(),
            _ => 0.0,
        };
        let targets = ledger.targets;
        // m and rad are not mixed: of x and a rotation only x.
        let coordinates = self.coordinate_figures(&ledger);
        let alike = if coordinates.is_empty() {
            &ledger.followed[..]
        } else {
            ledger.followed.get(..1).unwrap_or_default()
        };
        let displacement = Followed::together(alike);
        let rate_hz = self.element.rate_hz;
        SessionSummary {
            client: client.to_owned(),
            verdict,
            reason,
            trip,
            permit: self.rig.permit(),
            targets,
            commits: self.commits,
            model_s: self.last.as_ref().map_or(0.0, |(t, _)| t.time_s),
            steps: ledger.control_steps,
            rate_hz,
            wall_s,
            targets_per_s: if wall_s > 0.0 {
                targets as f64 / wall_s
            } else {
                0.0
            },
            peak_displacement_m: displacement.peak,
            tracking_rms_m: displacement.rms(),
            tracking_max_m: displacement.most,
            coordinates,
            energy_error_j: f64::from(ledger.energy.modified_j),
            energy_error_hsem_j: f64::from(ledger.energy.hsem_j),
            energy_error_stiffness_j: f64::from(ledger.energy.stiffness_j),
            energy_ratio: ledger.energy_ratio,
            mean_added_damping_n_s_per_m: ledger.damping_sum / targets.max(1) as f64,
            late_targets: ledger.late_targets,
            late_s: ledger.late_steps.0 as f64 / rate_hz,
            longest_late_ms: ledger.late_steps.1 as f64 / rate_hz * 1e3,
            board: self.rig.on_board(),
        }
    }
}

/// Fails if the operator has stopped the session.
fn operator() -> Result<(), End> {
    if interrupt::asked() {
        return Err(Stop::Operator.into());
    }
    Ok(())
}
