//! The rig's limits for the next test.

use crate::model::Model;
use crate::record::recording::Recording;
use crate::record::refusal::Refusal;
use crate::record::spectrum;
use schemars::JsonSchema;
use serde::Serialize;

/// Where a limit comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// The model's table `[limits]`.
    Declared,
    /// The records' own span.
    #[default]
    Record,
}

/// The range, speed and force of a test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct TestLimits {
    /// Middle of the range of displacement, mm.
    pub middle_mm: f64,
    /// Half of that range, mm.
    pub half_mm: f64,
    /// Top speed, mm/s.
    pub velocity_mm_per_s: f64,
    /// Largest force of either sign, N; null if unknown.
    pub force_n: Option<f64>,
    /// Where the range of displacement comes from.
    pub displacement_from: Origin,
    /// Where the top speed comes from.
    pub velocity_from: Origin,
    /// Where the force comes from.
    pub force_from: Origin,
}

/// Allowed ratio of the largest predicted force to that of the records: it is a prediction.
const FORCE_ROOM: f64 = 1.05;

impl TestLimits {
    /// The declared limits, or what the records show that the rig can do.
    ///
    /// # Errors
    /// Records in which nothing moves.
    pub fn of(model: &Model, records: &[&Recording]) -> Result<Self, Refusal> {
        let limits = &model.limits;
        let (mut low, mut high, mut top, mut force) = (f64::MAX, f64::MIN, 0.0_f64, 0.0_f64);
        for r in records {
            let Some(x) = r.displacement_mm.as_ref().or(r.command_mm.as_ref()) else {
                continue;
            };
            let h = r.interval_s();
            let band = spectrum::motion_band_hz(x, h).unwrap_or(0.1 / h);
            let motion = spectrum::smooth(x, h, (3.0 * band).min(0.3 / h));
            low = motion.x.iter().copied().fold(low, f64::min);
            high = motion.x.iter().copied().fold(high, f64::max);
            let mut speeds: Vec<f64> = motion.v.iter().map(|v| v.abs()).collect();
            let at = speeds.len() - 1 - speeds.len() / 200;
            top = top.max(*speeds.select_nth_unstable_by(at, f64::total_cmp).1);
            let forces = r.force_n.iter().flatten();
            force = forces.fold(force, |m, f| m.max(f.abs()));
        }
        let own = 0.5 * (high - low);
        let half_mm = limits.displacement_mm.unwrap_or(own);
        let velocity_mm_per_s = limits.velocity_mm_per_s.unwrap_or(top);
        if !(half_mm > 0.0 && half_mm.is_finite() && velocity_mm_per_s > 0.0) {
            return Err(Refusal::new(
                "nothing moves in the records, so that a next test has no limits: accepted is a table [limits] in the \
                 model, with displacement_mm and velocity_mm_per_s",
            ));
        }
        let from = |declared: Option<f64>| match declared {
            Some(_) => Origin::Declared,
            None => Origin::Record,
        };
        // Treat a motion that is nearly centred on zero as centred.
        let middle = 0.5 * (high + low);
        let centred = limits.displacement_mm.is_some() || middle.abs() < 0.2 * own;
        let far = if centred { middle.abs() } else { 0.0 };
        Ok(Self {
            middle_mm: if centred { 0.0 } else { middle },
            half_mm: match limits.displacement_mm {
                Some(_) => half_mm,
                None => half_mm - far,
            },
            velocity_mm_per_s,
            force_n: limits
                .force_n
                .or((force > 0.0).then_some(FORCE_ROOM * force)),
            displacement_from: from(limits.displacement_mm),
            velocity_from: from(limits.velocity_mm_per_s),
            force_from: from(limits.force_n),
        })
    }

    /// True if a force, N, is within the limits.
    pub fn holds(&self, force: &[f64]) -> bool {
        let most = self.force_n.unwrap_or(f64::INFINITY);
        force.iter().all(|f| f.abs() <= most)
    }
}
