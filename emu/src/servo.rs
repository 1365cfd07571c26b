//! A faulty servo's response to its command.

use crate::log::InjectedFault;
use std::collections::VecDeque;

/// Periods over which a gain changes: hydraulics do not jump.
const GAIN_PERIODS: u32 = 100;

/// Number of commands kept: half a second at 2 kHz.
const KEPT: usize = 1000;

/// A servo between the command and the rig.
#[derive(Clone, Debug, Default)]
pub struct Servo {
    /// Its commands, latest first, m.
    told_m: VecDeque<f64>,
    /// Periods since its gain began to change.
    since: u32,
}

impl Servo {
    /// The command that the rig follows, given this command and this `fault`.
    pub fn follow(&mut self, told_m: f64, fault: Option<InjectedFault>) -> f64 {
        self.told_m.push_front(told_m);
        self.told_m.truncate(KEPT);
        match fault {
            Some(InjectedFault::LateBy(periods)) => {
                let first_m = self.told_m.back().copied();
                let before_m = self.told_m.get(periods).copied();
                before_m.or(first_m).unwrap_or(told_m)
            }
            Some(InjectedFault::Gain { percent }) => {
                self.since = (self.since + 1).min(GAIN_PERIODS);
                let share = f64::from(self.since) / f64::from(GAIN_PERIODS);
                told_m * (1.0 + share * (f64::from(percent) / 100.0 - 1.0))
            }
            Some(InjectedFault::CommandOpen) => 0.0,
            _ => {
                self.since = 0;
                told_m
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gain_comes_by_and_by_and_a_late_servo_goes_where_it_was_sent_before() {
        let mut servo = Servo::default();
        assert_eq!(servo.follow(1.0, None), 1.0);
        let gain = Some(InjectedFault::Gain { percent: 150 });
        let first = servo.follow(1.0, gain);
        assert!((first - 1.005).abs() < 1e-12, "{first}");
        for _ in 0..200 {
            servo.follow(1.0, gain);
        }
        assert_eq!(servo.follow(1.0, gain), 1.5);
        let mut servo = Servo::default();
        for i in 0..10 {
            servo.follow(f64::from(i), None);
        }
        assert_eq!(servo.follow(10.0, Some(InjectedFault::LateBy(3))), 7.0);
    }
}
