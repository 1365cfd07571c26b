//! The limits that a board requires before it arms a test, and their largest permitted values.
//!
//! A limit beyond the range of the converters would never act. So each must lie inside the calibrated range, some codes
//! from its ends ([`CodeRange::sensor_spare`]). The PC makes the same check before it sends a test and reports the
//! figures of [`CalibratedRange`].

use crate::channel::{Calibration, CodeRange};
use outerloop_core::{Config, Refusal, accept, config::Limits};

/// Codes of the displacement that a motion has to pass before a standing reading counts as frozen, at least: coarser
/// than the converter's own steps and their noise.
pub const FROZEN_CODES: u16 = 8;

/// The longest time for which samples may be stale, s.
pub const STALE_S: f64 = 0.25;

/// The longest time in which a command that waits for its target or sample slows down to a third, s: at 0.3 m/s it goes 3 mm in it.
pub const SLOW_DOWN_S: f64 = 0.01;

/// The largest change of the command in a control step, as a fraction of the measurable stroke. More is no limit.
pub const STEP_SHARE: f64 = 0.25;

/// Two transducers of one displacement are compared to this share of the calibrated range, end to end, at most: linearity and drift of
/// both leave less, and the jump of a piston at arming may be as large.
pub const DISAGREE_SHARE: f64 = 0.02;

/// A standing reading may hide this share of the stroke, at most, or so many standard deviations of its declared noise: a dead transducer's
/// noise then stays within three eighths of that, six deviations.
pub const FROZEN_SHARE: f64 = 0.05;
/// See [`FROZEN_SHARE`].
pub const FROZEN_DEVIATIONS: f64 = 16.0;

/// `limits.tracking_m` may be this fraction of the stroke even if a test moves by less: a late actuator can be further
/// from a signal of some millimetres than the signal is large.
pub const TRACKING_SHARE: f64 = 0.25;

/// The largest energy error, relative to the energy in the test: 3 is sound, and more than 10 is no limit.
pub const ENERGY_TRIP: f64 = 10.0;

/// The fastest approach, m/s: the speed of a robot that a person may stand beside (ISO 10218-1, reduced speed).
pub const APPROACH_M_PER_S: f64 = 0.25;

/// The hardest ramp to a standstill, m/s^2: from 0.5 m/s it takes 10 ms, about the time of an actuator's own. A harder one is no ramp.
pub const HOLD_DECELERATION_M_PER_S2: f64 = 50.0;

/// The largest offset of a command or of a displacement that a test may declare beside the calibration, m. A wrong one makes the piston
/// jump by as much when the contact behind PERMIT closes. `outerloop improve` removes what a calibration leaves: it is
/// held to 2 mm, including the scatter of what it finds.
pub const ZERO_OFF_M: f64 = 2.5e-3;

/// The largest gain that a test may declare, its inverse the smallest: a wrong one makes the piston jump by that
/// fraction of its position.
pub const GAIN: f64 = 1.25;

/// The range of a calibrated board on both sides of zero, with the spare codes left free; with several actuators, the
/// range common to all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibratedRange {
    /// Largest displacement that both the sensor and the command show, m.
    pub displacement_m: f64,
    /// Largest force, N.
    pub force_n: f64,
    /// Motion that a standing reading hides, m: [`FROZEN_CODES`].
    pub frozen_m: f64,
}

impl CalibratedRange {
    /// The range of one calibration.
    pub fn by(calibration: &Calibration, codes: &CodeRange) -> Self {
        let sensor = |line: crate::channel::ChannelCalibration| {
            line.shows(codes.sensor_top, codes.sensor_spare)
        };
        let command = calibration
            .command
            .shows(codes.command_top, codes.command_spare);
        let displacement = calibration.displacement;
        Self {
            displacement_m: f64::from(sensor(displacement).min(command)),
            force_n: f64::from(sensor(calibration.force)),
            frozen_m: f64::from(displacement.per_code.abs() * f32::from(FROZEN_CODES)),
        }
    }

    /// The range common to all actuators of a board: the narrowest range and the coarsest code count.
    pub fn by_all<'a>(
        calibrations: impl IntoIterator<Item = &'a Calibration>,
        codes: &CodeRange,
    ) -> Self {
        let nothing = Self {
            displacement_m: f64::INFINITY,
            force_n: f64::INFINITY,
            frozen_m: 0.0,
        };
        let each = calibrations.into_iter().map(|c| Self::by(c, codes));
        each.fold(nothing, |a, b| Self {
            displacement_m: a.displacement_m.min(b.displacement_m),
            force_n: a.force_n.min(b.force_n),
            frozen_m: a.frozen_m.max(b.frozen_m),
        })
    }

    /// Checks that the test has all limits required for arming, and that each can act.
    ///
    /// # Errors
    /// The first limit that is left out (its value is NaN then) or cannot act.
    pub fn check(&self, config: &Config) -> Result<(), Refusal> {
        let limits = &config.limits;
        let rate_hz = config.timing.rate_hz;
        let stroke_m = self.displacement_m;
        let step_m = STEP_SHARE * stroke_m;
        at_most(
            "limits.displacement_m",
            limits.displacement_m,
            stroke_m,
            "a limit inside what the calibrated sensor and command show, less the spare codes at the ends",
        )?;
        at_most(
            "limits.force_n",
            limits.force_n,
            self.force_n,
            "a limit inside what the calibrated sensor shows, less the spare codes at the ends",
        )?;
        at_most(
            "limits.tracking_m",
            limits.tracking_m,
            self.most_tracking_m(limits),
            "at most limits.displacement_m, or a quarter of the calibrated stroke, whichever is more",
        )?;
        if limits.increment_m.is_none() || limits.velocity_m_per_s.is_some() {
            at_most(
                "limits.velocity_m_per_s",
                limits.velocity_m_per_s,
                step_m * rate_hz,
                "a limit (or limits.increment_m) of at most a quarter of the stroke in a control step",
            )?;
        }
        if limits.increment_m.is_some() {
            at_most(
                "limits.increment_m",
                limits.increment_m,
                step_m,
                "a limit of at most a quarter of the stroke in a control step",
            )?;
        }
        at_most(
            "limits.stale_steps",
            limits.stale_steps.map(f64::from),
            STALE_S * rate_hz,
            "a limit of at most a quarter of a second",
        )?;
        let hidden_m = limits.hidden_motion_m();
        // The calibration is in single precision, and a PC sends its own figure back.
        let noisy_m = FROZEN_DEVIATIONS * config.estimation.displacement_noise_m * (1.0 + 1e-6);
        let most_m = noisy_m.max(FROZEN_SHARE * stroke_m).min(stroke_m);
        if !(hidden_m >= self.frozen_m * (1.0 - 1e-6) && hidden_m <= most_m) {
            return Err(Refusal {
                name: "limits.frozen_m",
                value: hidden_m,
                accepted: "8 codes of the displacement at least (left out: 0.1 mm), 1/20 of the stroke or 16 deviations of its noise at most",
            });
        }
        self.check_optional(config)?;
        check_speed(config)?;
        check_rig(config)
    }

    /// The largest `limits.tracking_m`, m, beside the other limits.
    pub fn most_tracking_m(&self, limits: &Limits) -> f64 {
        let moves_m = limits.displacement_m.unwrap_or(0.0);
        moves_m.max(TRACKING_SHARE * self.displacement_m)
    }

    /// Optional limits must be able to act if they are given.
    fn check_optional(&self, config: &Config) -> Result<(), Refusal> {
        let limits = &config.limits;
        let moves_m = limits.displacement_m.unwrap_or(0.0);
        let stiffness = config.structure.stiffness_n_per_m.iter();
        let stiffest = stiffness.fold(0.0_f64, |most, k| most.max(*k));
        let optional = [
            (
                "limits.disagree_m",
                limits.disagree_m,
                DISAGREE_SHARE * 2.0 * self.displacement_m,
                "at most 2 % of the displacement's calibrated range, from end to end",
            ),
            (
                "limits.force_stands_m",
                limits.force_stands_m,
                moves_m,
                "at most limits.displacement_m: a longer motion never comes",
            ),
            (
                "limits.energy_trip",
                limits.energy_trip,
                ENERGY_TRIP,
                "at most 10: 3 is sound",
            ),
            (
                "limits.energy_floor_j",
                limits.energy_floor_j,
                0.5 * stiffest * moves_m * moves_m,
                "at most the strain energy of the stiffest storey at limits.displacement_m",
            ),
        ];
        optional
            .into_iter()
            .filter(|(_, limit, _, _)| limit.is_some())
            .try_for_each(|(name, limit, most, accepted)| at_most(name, limit, most, accepted))
    }
}

/// The approach is slow enough for a person to get away, and a command without its target or sample slows down at once.
fn check_speed(config: &Config) -> Result<(), Refusal> {
    let timing = &config.timing;
    accept(
        "loop.approach_m_per_s",
        timing.approach_m_per_s,
        timing.approach_m_per_s <= APPROACH_M_PER_S,
        "at most 0.25 m/s",
    )?;
    // The client decides how long a target may be late: a command that has slowed down stands still.
    let slows_down_steps = f64::from(timing.slow_down_steps);
    accept(
        "loop.slow_down_steps",
        slows_down_steps,
        slows_down_steps <= (SLOW_DOWN_S * timing.rate_hz).max(1.0),
        "at most 10 ms, loop.rate_hz / 100 or 1",
    )?;
    accept(
        "loop.hold_deceleration_m_per_s2",
        timing.hold_deceleration_m_per_s2,
        timing.hold_deceleration_m_per_s2 <= HOLD_DECELERATION_M_PER_S2,
        "at most 50 m/s^2: a harder stop is a blow",
    )
}

/// A test's corrections to the calibration must be small: a wrong one is not detected before it has moved the piston.
fn check_rig(config: &Config) -> Result<(), Refusal> {
    let (rig, limits) = (&config.rig, &config.limits);
    let off_m = ZERO_OFF_M.min(limits.tracking_m.unwrap_or(0.0));
    let force_n = limits.force_n.unwrap_or(0.0);
    let off = "at most 2.5 mm either way, and limits.tracking_m; a larger one belongs in the calibration (board calibrate)";
    let rows = [
        ("rig.command_offset_m", &rig.command_offset_m, off_m, off),
        (
            "rig.displacement_offset_m",
            &rig.displacement_offset_m,
            off_m,
            off,
        ),
        (
            "rig.force_offset_n",
            &rig.force_offset_n,
            force_n,
            "at most limits.force_n either way; a larger one belongs in the calibration (board calibrate)",
        ),
        (
            "rig.bearing_friction_n",
            &rig.bearing_friction_n,
            force_n,
            "at most limits.force_n",
        ),
    ];
    for (name, list, most, accepted) in rows {
        for &value in list {
            accept(name, value, value.abs() <= most, accepted)?;
        }
    }
    for (name, list) in [
        ("rig.command_gain", &rig.command_gain),
        ("rig.displacement_gain", &rig.displacement_gain),
        ("rig.force_gain", &rig.force_gain),
    ] {
        for &gain in list {
            let accepted = "0.8 to 1.25; a larger one belongs in the calibration (board calibrate)";
            accept(name, gain, (1.0 / GAIN..=GAIN).contains(&gain), accepted)?;
        }
    }
    Ok(())
}

fn at_most(
    name: &'static str,
    limit: Option<f64>,
    most: f64,
    accepted: &'static str,
) -> Result<(), Refusal> {
    match limit {
        Some(value) if value > 0.0 && value <= most => Ok(()),
        other => Err(Refusal {
            name,
            value: other.unwrap_or(f64::NAN),
            accepted,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channel::TWELVE_BITS;

    fn limited() -> Config {
        let mut config = Config::shear_frame([1000.0], [158e3], [0.02]);
        config.limits = Limits {
            displacement_m: Some(0.04),
            velocity_m_per_s: Some(0.5),
            force_n: Some(8000.0),
            tracking_m: Some(0.01),
            stale_steps: Some(20),
            ..Limits::default()
        };
        config
    }

    fn refused(change: impl FnOnce(&mut Limits)) -> Option<&'static str> {
        let mut config = limited();
        change(&mut config.limits);
        let shown = CalibratedRange::by(&Calibration::nominal(&TWELVE_BITS), &TWELVE_BITS);
        shown.check(&config).err().map(|r| r.name)
    }

    #[test]
    fn each_limit_that_is_left_out_or_cannot_act_is_refused_by_its_name() {
        assert_eq!(refused(|_| ()), None);
        assert_eq!(
            refused(|l| l.displacement_m = None),
            Some("limits.displacement_m")
        );
        // 300 of 4095 codes at each end of +-50 mm: 42.7 mm.
        assert_eq!(refused(|l| l.displacement_m = Some(0.0426)), None);
        assert_eq!(
            refused(|l| l.displacement_m = Some(0.0428)),
            Some("limits.displacement_m")
        );
        assert_eq!(
            refused(|l| l.displacement_m = Some(f64::NAN)),
            Some("limits.displacement_m")
        );
        assert_eq!(refused(|l| l.force_n = None), Some("limits.force_n"));
        assert_eq!(
            refused(|l| l.force_n = Some(8600.0)),
            Some("limits.force_n")
        );
        assert_eq!(refused(|l| l.tracking_m = None), Some("limits.tracking_m"));
        assert_eq!(
            refused(|l| l.tracking_m = Some(0.05)),
            Some("limits.tracking_m")
        );
        assert_eq!(
            refused(|l| l.velocity_m_per_s = None),
            Some("limits.velocity_m_per_s")
        );
        assert_eq!(
            refused(|l| l.velocity_m_per_s = Some(30.0)),
            Some("limits.velocity_m_per_s")
        );
        let increment =
            |m| move |l: &mut Limits| (l.velocity_m_per_s, l.increment_m) = (None, Some(m));
        assert_eq!(refused(increment(0.001)), None);
        assert_eq!(refused(increment(0.02)), Some("limits.increment_m"));
        assert_eq!(
            refused(|l| l.stale_steps = None),
            Some("limits.stale_steps")
        );
        assert_eq!(
            refused(|l| l.stale_steps = Some(501)),
            Some("limits.stale_steps")
        );
        assert_eq!(
            refused(|l| l.frozen_m = Some(5e-5)),
            Some("limits.frozen_m")
        );
        assert_eq!(
            refused(|l| l.frozen_m = Some(0.05)),
            Some("limits.frozen_m")
        );
    }

    type Change = fn(&mut Config);

    /// Rows: a name, the most that is accepted of it, and what is more.
    #[test]
    fn what_could_never_act_or_lets_the_piston_jump_is_refused_by_its_name() {
        let rows: [(&str, Change, Change); 22] = [
            // 2 % of the 85.35 mm that 3495 codes to either side show.
            (
                "limits.disagree_m",
                |c| c.limits.disagree_m = Some(1.7e-3),
                |c| c.limits.disagree_m = Some(1.72e-3),
            ),
            (
                "limits.force_stands_m",
                |c| c.limits.force_stands_m = Some(0.04),
                |c| c.limits.force_stands_m = Some(0.041),
            ),
            (
                "limits.energy_trip",
                |c| c.limits.energy_trip = Some(10.0),
                |c| c.limits.energy_trip = Some(10.1),
            ),
            // 126.4 J of 158 kN/m at 40 mm.
            (
                "limits.energy_floor_j",
                |c| c.limits.energy_floor_j = Some(126.0),
                |c| c.limits.energy_floor_j = Some(127.0),
            ),
            (
                "limits.tracking_m",
                |c| c.limits.tracking_m = Some(0.04),
                |c| c.limits.tracking_m = Some(0.041),
            ),
            // Of a motion of 1 mm a quarter of the stroke: an actuator that is late is apart from its command by more than that.
            (
                "limits.tracking_m",
                |c| (c.limits.displacement_m, c.limits.tracking_m) = (Some(1e-3), Some(0.0106)),
                |c| (c.limits.displacement_m, c.limits.tracking_m) = (Some(1e-3), Some(0.0107)),
            ),
            (
                "limits.frozen_m",
                |c| c.limits.frozen_m = Some(2.1e-3),
                |c| c.limits.frozen_m = Some(2.2e-3),
            ),
            // The noise of the paper's steel frame.
            (
                "limits.frozen_m",
                |c| {
                    c.limits.frozen_m = Some(0.0133);
                    c.estimation.displacement_noise_m = 0.833e-3;
                },
                |c| {
                    c.limits.frozen_m = Some(0.0134);
                    c.estimation.displacement_noise_m = 0.833e-3;
                },
            ),
            (
                "loop.approach_m_per_s",
                |c| c.timing.approach_m_per_s = 0.25,
                |c| c.timing.approach_m_per_s = 0.26,
            ),
            (
                "loop.hold_deceleration_m_per_s2",
                |c| c.timing.hold_deceleration_m_per_s2 = 50.0,
                |c| c.timing.hold_deceleration_m_per_s2 = 51.0,
            ),
            // At 2 kHz.
            (
                "loop.slow_down_steps",
                |c| c.timing.slow_down_steps = 20,
                |c| c.timing.slow_down_steps = 21,
            ),
            (
                "loop.slow_down_steps",
                |c| (c.timing.rate_hz, c.timing.slow_down_steps) = (500.0, 5),
                |c| (c.timing.rate_hz, c.timing.slow_down_steps) = (500.0, 6),
            ),
            (
                "loop.slow_down_steps",
                |c| (c.timing.rate_hz, c.timing.slow_down_steps) = (90.0, 1),
                |c| (c.timing.rate_hz, c.timing.slow_down_steps) = (100.0, 2),
            ),
            (
                "rig.force_gain",
                |c| c.rig.force_gain = only(0.8),
                |c| c.rig.force_gain = only(0.79),
            ),
            (
                "rig.command_offset_m",
                |c| c.rig.command_offset_m = only(-2.5e-3),
                |c| c.rig.command_offset_m = only(-2.6e-3),
            ),
            (
                "rig.displacement_offset_m",
                |c| c.rig.displacement_offset_m = only(2.5e-3),
                |c| c.rig.displacement_offset_m = only(3e-3),
            ),
            (
                "rig.displacement_offset_m",
                |c| {
                    (c.limits.tracking_m, c.rig.displacement_offset_m) = (Some(1e-3), only(1e-3));
                },
                |c| {
                    (c.limits.tracking_m, c.rig.displacement_offset_m) = (Some(1e-3), only(1.1e-3));
                },
            ),
            (
                "rig.command_gain",
                |c| c.rig.command_gain = only(1.25),
                |c| c.rig.command_gain = only(1.3),
            ),
            (
                "rig.displacement_gain",
                |c| c.rig.displacement_gain = only(0.8),
                |c| c.rig.displacement_gain = only(0.7),
            ),
            (
                "rig.force_offset_n",
                |c| c.rig.force_offset_n = only(-8000.0),
                |c| c.rig.force_offset_n = only(-8001.0),
            ),
            (
                "rig.bearing_friction_n",
                |c| c.rig.bearing_friction_n = only(8000.0),
                |c| c.rig.bearing_friction_n = only(8001.0),
            ),
            (
                "rig.command_offset_m",
                |_| (),
                |c| c.rig.command_offset_m = only(f64::NAN),
            ),
        ];
        let shown = CalibratedRange::by(&Calibration::nominal(&TWELVE_BITS), &TWELVE_BITS);
        let judged = |change: Change| {
            let mut config = limited();
            change(&mut config);
            shown.check(&config)
        };
        for (name, most, more) in rows {
            assert_eq!(judged(most), Ok(()), "{name}");
            let refusal = judged(more).expect_err(name);
            assert_eq!(refusal.name, name);
            // A board says no more than so many characters.
            assert!(refusal.accepted.len() <= 120, "{}", refusal.accepted);
        }
        let refusal = judged(|c| c.rig.displacement_offset_m = only(3e-3)).unwrap_err();
        assert_eq!(refusal.value, 3e-3);
        assert!(refusal.accepted.contains("2.5 mm"), "{refusal}");
        assert!(refusal.accepted.contains("calibration"), "{refusal}");
    }

    fn only(value: f64) -> outerloop_core::config::PerActuator {
        core::iter::once(value).collect()
    }

    #[test]
    fn what_is_frozen_follows_the_calibration() {
        let coarse = Calibration::over(0.25, 1e4, &TWELVE_BITS);
        let shown = CalibratedRange::by(&coarse, &TWELVE_BITS);
        let refusal = shown.check(&limited()).unwrap_err();
        assert_eq!(refusal.name, "limits.frozen_m");
        let mut config = limited();
        config.limits.frozen_m = Some(shown.frozen_m);
        assert_eq!(shown.check(&config), Ok(()));
        // 8 of 8190 codes of half a metre.
        assert!((shown.frozen_m / 0.488e-3 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn several_actuators_show_what_the_narrowest_and_the_coarsest_of_them_do() {
        let over = |m, n| Calibration::over(m, n, &TWELVE_BITS);
        let [wide, narrow, weak] = [over(0.25, 1e4), over(0.05, 1e4), over(0.05, 5e3)];
        let all = CalibratedRange::by_all([&wide, &narrow, &weak], &TWELVE_BITS);
        let [wide, narrow, weak] =
            [wide, narrow, weak].map(|c| CalibratedRange::by(&c, &TWELVE_BITS));
        assert_eq!(all.displacement_m, narrow.displacement_m);
        assert_eq!(all.force_n, weak.force_n);
        assert_eq!(all.frozen_m, wide.frozen_m);
        let one = Calibration::nominal(&TWELVE_BITS);
        assert_eq!(
            CalibratedRange::by_all([&one], &TWELVE_BITS),
            CalibratedRange::by(&one, &TWELVE_BITS)
        );
    }

    #[test]
    fn a_zero_at_the_end_of_the_range_shows_nothing() {
        let mut skewed = Calibration::nominal(&TWELVE_BITS);
        skewed.force.zero_code = 8100.0;
        let shown = CalibratedRange::by(&skewed, &TWELVE_BITS);
        assert_eq!(
            shown.check(&limited()).map_err(|r| r.name),
            Err("limits.force_n")
        );
    }
}
