//! The results of a session.

use experiment::bench::OnBoard;
use experiment::numbers::three;
use experiment::trace::{AnyRecord, TestObserver};
use outerloop_core::{EnergyWords, flag};
use schemars::JsonSchema;
use serde::Serialize;

/// Figures accumulated while the rig moves.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    /// Targets reached.
    pub targets: usize,
    /// Control steps.
    pub control_steps: usize,
    /// How each coordinate was followed.
    pub followed: Vec<Followed>,
    /// Cumulative energy errors, J.
    pub energy: EnergyWords,
    /// Energy error relative to the energy in the test.
    pub energy_ratio: f64,
    /// Sum of the added damping of the first storey over the targets, N s/m.
    pub damping_sum: f64,
    /// How many times the model was late.
    pub late_targets: usize,
    /// Control steps in which it was late, and the longest run of them.
    pub late_steps: (usize, usize),
    late_now: usize,
}

impl Ledger {
    /// Adds a reached target, m or rad: `apart` is measured less target.
    pub fn reached(&mut self, target: &[f64], apart: &[f64]) {
        self.targets += 1;
        self.followed.resize(target.len(), Followed::default());
        for (followed, (u, e)) in self.followed.iter_mut().zip(target.iter().zip(apart)) {
            followed.targets += 1;
            followed.peak = followed.peak.max(u.abs());
            followed.squares += e * e;
            followed.most = followed.most.max(e.abs());
        }
    }
}

/// How a coordinate was followed, in m or rad.
#[derive(Clone, Copy, Debug, Default)]
pub struct Followed {
    targets: usize,
    /// Largest target.
    pub peak: f64,
    /// Sum of squares of measured less target, at the targets.
    squares: f64,
    /// The largest absolute value of it.
    pub most: f64,
}

impl Followed {
    /// Combines coordinates of one unit.
    pub fn together(all: &[Self]) -> Self {
        all.iter().fold(Self::default(), |sum, c| Self {
            targets: sum.targets + c.targets,
            peak: sum.peak.max(c.peak),
            squares: sum.squares + c.squares,
            most: sum.most.max(c.most),
        })
    }

    /// Root mean square of measured less target.
    pub fn rms(&self) -> f64 {
        (self.squares / self.targets.max(1) as f64).sqrt()
    }
}

/// How a coordinate of two actuators on one coupler was followed, in the unit with which its name ends.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct CoordinateFigures {
    /// Its name, as in `coupled.structure.coordinates`.
    pub name: String,
    /// Largest target.
    pub peak: f64,
    /// Measured minus target value at the targets: root mean square.
    pub tracking_rms: f64,
    /// The largest of these differences.
    pub tracking_max: f64,
}

impl CoordinateFigures {
    /// Figures of the coordinate `name`.
    pub fn of(name: String, followed: &Followed) -> Self {
        Self {
            name,
            peak: followed.peak,
            tracking_rms: followed.rms(),
            tracking_max: followed.most,
        }
    }

    /// In one sentence.
    pub fn sentence(&self) -> String {
        format!(
            "{}: largest target {}, off it by {} rms and {} at most.",
            self.name,
            three(self.peak),
            three(self.tracking_rms),
            three(self.tracking_max)
        )
    }
}

impl TestObserver for Ledger {
    fn on_step(&mut self, r: &AnyRecord<'_>) {
        self.control_steps += 1;
        self.energy = r.energy_sum;
        self.energy_ratio = f64::from(r.energy_ratio);
        if r.has(flag::SOLVED) {
            self.damping_sum += f64::from(r.added_damping_n_s_per_m[0]);
        }
        if r.has(flag::LATE) {
            self.late_targets += usize::from(self.late_now == 0);
            self.late_now += 1;
            self.late_steps = (self.late_steps.0 + 1, self.late_steps.1.max(self.late_now));
        } else {
            self.late_now = 0;
        }
    }
}

/// How a session ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SessionVerdict {
    /// The client ended the session with its last message.
    Completed,
    /// A message of the client was refused.
    Refused,
    /// The client disconnected, or was silent for too long.
    Lost,
    /// An interlock ended it.
    Tripped,
    /// The operator ended it.
    Stopped,
    /// The rig or the board was lost.
    RigLost,
}

/// The figures of a session. The keys are a contract.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct SessionSummary {
    /// Address of the client.
    pub client: String,
    /// How it ended.
    pub verdict: SessionVerdict,
    /// Why, if it was not completed.
    pub reason: Option<String>,
    /// Name of the fault.
    pub trip: Option<&'static str>,
    /// State of the PERMIT line at the end; also true if a board is silent, so that the state is unknown.
    pub permit: bool,
    /// Targets that were reached and answered.
    pub targets: usize,
    /// Steps that the client committed.
    pub commits: usize,
    /// Model time of the last target, s.
    pub model_s: f64,
    /// Control steps of the rig.
    pub steps: usize,
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// Seconds on the wall clock, from the first target to the last answer.
    pub wall_s: f64,
    /// Targets per second of this time.
    pub targets_per_s: f64,
    /// Largest target, m; of two actuators on one coupler, here and below, that of x.
    pub peak_displacement_m: f64,
    /// Measured minus target displacement at the targets: root mean square, m.
    pub tracking_rms_m: f64,
    /// The largest of these differences, m.
    pub tracking_max_m: f64,
    /// With two actuators on one coupler: the same for x and for the rotation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub coordinates: Vec<CoordinateFigures>,
    /// Cumulative Eq 12, J.
    pub energy_error_j: f64,
    /// Cumulative HSEM, J.
    pub energy_error_hsem_j: f64,
    /// Cumulative Eq 6, J.
    pub energy_error_stiffness_j: f64,
    /// Energy error relative to the largest strain energy.
    pub energy_ratio: f64,
    /// Mean of C_cor, N s/m, first storey.
    pub mean_added_damping_n_s_per_m: f64,
    /// How often the model was late.
    pub late_targets: usize,
    /// Time for which the rig waited for it, s of the laboratory.
    pub late_s: f64,
    /// The longest of these waits, ms.
    pub longest_late_ms: f64,
    /// What only a board reports.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub board: Option<OnBoard>,
}

impl SessionSummary {
    /// How it ended, in one sentence.
    pub fn ending(&self) -> String {
        match (&self.verdict, &self.reason) {
            (SessionVerdict::Completed, _) => format!("{}: completed.", self.client),
            (_, Some(why)) => format!("{}: {why}.", self.client),
            (verdict, None) => format!("{}: {verdict:?}.", self.client),
        }
    }

    /// In a few plain sentences.
    pub fn sentences(&self) -> String {
        let mut text = self.ending();
        if self.targets == 0 {
            return text + " The rig has not moved.";
        }
        text += &format!(
            " {} targets to {:.3} s of the model, {:.0} a second; largest displacement {:.3} mm. \
             The rig was off its target by {:.4} mm rms, {:.4} mm at most; energy error {:.3} J, {:.2} % of the largest \
             strain energy.",
            self.targets,
            self.model_s,
            self.targets_per_s,
            self.peak_displacement_m * 1e3,
            self.tracking_rms_m * 1e3,
            self.tracking_max_m * 1e3,
            self.energy_error_j,
            self.energy_ratio * 100.0,
        );
        for further in self.coordinates.iter().skip(1) {
            text += " ";
            text += &further.sentence();
        }
        if self.late_targets > 0 {
            text += &format!(
                " The model was late {} times, {:.2} s together, {:.0} ms at most.",
                self.late_targets, self.late_s, self.longest_late_ms
            );
        }
        text += match self.permit {
            false => " The permission to move is given back.",
            true => " THE RIG MAY STILL MOVE.",
        };
        if let Some(board) = &self.board {
            text += "\n";
            text += &board.sentence();
        }
        text
    }
}
