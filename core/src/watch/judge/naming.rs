//! What a clear hypothesis is called: which cause, on which side.

use super::super::hypothesis::Hypothesis;
use super::super::name::Cause;
use super::super::regression::{ACTUATOR, FORCE, FRESH, LONGEST as REFERENCE, UNLOADING};
use super::{
    Constants, GAIN, Judge, LATE, LATE_OFF, LEARNED, OFFSET, OFFSET_OFF, OFFSETS, POSSIBLE,
    SLOPE_OFF, WORSE, bend_of, slope_of,
};
use libm::sqrtf;

impl Judge {
    /// Names the fault between command and displacement. True if it is the actuator and not a sensor.
    pub(super) fn name_actuator(&mut self, k: &Constants, best: &Hypothesis) -> bool {
        let mut only_actuator = true;
        for column in best.set() {
            let answer = &best.answer;
            let theta = answer.theta[column];
            match column {
                5 => {
                    let speed = self.limits[0] * k.omega * k.peak_m;
                    self.note(Cause::RateLimit, speed, 0.05 * speed);
                    continue;
                }
                6 => {
                    let way = self.limits[1] * k.peak_m;
                    self.note(Cause::StrokeLimit, way, 0.02 * way);
                    continue;
                }
                _ => {}
            }
            let Some((cause, unit)) = k.meaning(ACTUATOR, column, theta) else {
                continue;
            };
            let (value, sd) = (theta * unit, answer.sd(column) * unit);
            let Some(twin) = cause.twin() else {
                self.note(cause, value, sd);
                continue;
            };
            let [actuator, sensor] = self.sides(k, column, theta * k.half.actuator[column]);
            only_actuator &= !sensor;
            let possible = [(actuator, cause, 0), (sensor, twin, 1)];
            for (_, cause, side) in possible.into_iter().filter(|(possible, ..)| *possible) {
                if column == OFFSET {
                    let theta = [theta, answer.sd(column)];
                    self.note_offset(k, 0, OFFSETS[0].1[side], unit, theta);
                } else {
                    self.note(cause, value, sd);
                }
            }
        }
        only_actuator
    }

    /// The possible sides of a column between command and displacement: actuator, displacement transducer. A wrong
    /// transducer makes the force look wrong by the same amount; a wrong actuator does not.
    fn sides(&self, k: &Constants, column: usize, value: f32) -> [bool; 2] {
        let slope = 1.0 / (1.0 + value) - 1.0;
        let (regression, column, half, implied, off) = match (column, self.elastic) {
            (GAIN, true) => (FORCE, 1, k.half.force[1], slope, SLOPE_OFF),
            (GAIN, false) => (UNLOADING, 0, k.half.unloading[0], slope, SLOPE_OFF),
            (LATE, true) => {
                let half = k.half.force[2];
                (FORCE, 2, half, value, LATE_OFF * half)
            }
            (LATE, false) => {
                let half = k.half.unloading[1];
                (UNLOADING, 1, half, value, LATE_OFF * half)
            }
            (OFFSET, true) => (FORCE, 0, k.half.force[0], -value, OFFSET_OFF),
            _ => return [true; 2],
        };
        let mut shortest = [FRESH, 0, 1].into_iter();
        let Some(now) = shortest.find_map(|window| self.answers.of(window, regression)) else {
            return [true; 2];
        };
        let [before, before_sd] = self.reference[regression - FORCE][column];
        let change = (now.theta[column] - before) * half;
        let sd = sqrtf(now.sd(column) * now.sd(column) + before_sd * before_sd) * half;
        let sd = sqrtf(sd * sd + off * off);
        let (if_actuator, if_sensor) = ((change / sd).abs(), ((change - implied) / sd).abs());
        if if_sensor < POSSIBLE && if_actuator > if_sensor + WORSE {
            [false, true]
        } else if if_actuator < POSSIBLE && if_sensor > if_actuator + WORSE {
            [true, false]
        } else {
            [true; 2]
        }
    }

    /// Names the fault between displacement and force.
    pub(super) fn name_force(&mut self, k: &Constants, regression: usize, best: &Hypothesis) {
        let recent = self.is_recent(k);
        // If it looks like an offset and like friction at once, the specimen has yielded.
        let looks_like = |column: usize| best.set().any(|c| c == column);
        let yields = looks_like(0) && looks_like(4);
        let yielded = || self.is_of_yielding(k, best);
        if regression == FORCE && (recent || yields || yielded()) {
            // The same just after a new largest motion: the specimen may then do things that nobody declared.
            self.elastic = false;
            self.streaks[FORCE] = 0;
            self.answers.forget(FORCE);
            return;
        }
        if self.is_the_specimens_own(regression, best, recent) {
            return;
        }
        for column in best.set() {
            let (theta, sd) = (best.answer.theta[column], best.answer.sd(column));
            match k.meaning(regression, column, theta) {
                Some((Cause::ForceGain, _)) => self.name_slope(k, regression, best, recent),
                Some((Cause::ForceOffset, unit)) => {
                    self.note_offset(k, 1, OFFSETS[1].1[0], unit, [theta, sd]);
                }
                Some((cause, unit)) => self.note(cause, theta * unit, sd * unit.abs()),
                None => {}
            }
        }
    }

    /// True if an offset, a friction or a mass is among the causes and no larger than the trace left by a specimen that
    /// has yielded by its shortfall of force at the largest motion: a set towards the yielded side, a loop as wide as
    /// both, a force lower by as much at the turns.
    fn is_of_yielding(&self, k: &Constants, best: &Hypothesis) -> bool {
        let [up, down] = self.short;
        best.set().any(|column| {
            let theta = best.answer.theta[column];
            let left = match column {
                0 if theta < 0.0 => up,
                0 => down,
                3 | 4 => 0.5 * (up + down),
                _ => return false,
            };
            let half = k.half.force[column];
            theta.abs() * half < left + 2.0 * half
        })
    }

    /// True if the best explanation is normal for a sound specimen: a stiffness that depends on the displacement, or
    /// falls slowly or with the largest motion. Soon after a new largest motion, explaining it about as well suffices.
    fn is_the_specimens_own(&self, regression: usize, best: &Hypothesis, recent: bool) -> bool {
        let own = |column: usize| {
            let softens = column == slope_of(regression)
                && best.answer.theta[column] < 0.0
                && !self.has_fallen(regression, best, recent);
            softens || column == bend_of(regression)
        };
        own(best.column) || recent && best.set().any(own)
    }

    /// True if the slope has fallen suddenly, and not with a new largest motion.
    fn has_fallen(&self, regression: usize, best: &Hypothesis, recent: bool) -> bool {
        let column = slope_of(regression);
        let (theta, sd) = (best.answer.theta[column], best.answer.sd(column));
        let long = self.answers.of(REFERENCE, regression);
        let long = long.filter(|a| a.periods > LEARNED);
        let fallen = long.is_some_and(|long| theta - long.theta[column] < -2.0 - 2.0 * sd)
            || best.column == column && self.is_change(best, regression);
        fallen && !recent
    }

    /// A slope that has risen is the load cell's: a specimen does not stiffen during unloading. One that has fallen
    /// *suddenly* may be either; one that falls slowly, or with the largest motion, means a degrading specimen.
    fn name_slope(&mut self, k: &Constants, regression: usize, best: &Hypothesis, recent: bool) {
        let column = slope_of(regression);
        let half = match regression {
            FORCE => k.half.force[1],
            _ => k.half.unloading[0],
        };
        let (theta, sd) = (best.answer.theta[column], best.answer.sd(column));
        if theta > 0.0 {
            self.note(Cause::ForceGain, theta * half, sd * half);
        } else if self.has_fallen(regression, best, recent) {
            self.note(Cause::ForceGain, theta * half, sd * half);
            self.note(Cause::StiffnessLoss, theta * half, sd * half);
        }
    }
}
