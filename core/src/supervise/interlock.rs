//! The interlocks: conditions that must hold after all computation, before a command is sent.

use super::fault::Fault;
use crate::float::unlikely;
use crate::structure::actuated;

/// Limits; the largest number if a limit is off, so that infinities and NaN fail every one.
#[derive(Clone, Copy, Debug)]
pub struct InterlockLimits {
    /// Largest command, m.
    pub displacement_m: f32,
    /// Largest measured displacement, m.
    pub reading_m: f32,
    /// Largest change of the command in a control step, m.
    pub increment_m: f32,
    /// Largest speed of the command as a change in a control step, m.
    pub velocity_step_m: f32,
    /// The smaller of these two: one comparison a step.
    pub least_step_m: f32,
    /// Control rate, Hz, to report a velocity.
    pub rate_hz: f32,
    /// Largest measured force, N.
    pub force_n: f32,
    /// Largest difference between measured displacement and the position commanded, m.
    pub tracking_m: f32,
    /// Energy ratio: warning.
    pub energy_warning: f32,
    /// Energy ratio: trip.
    pub energy_trip: f32,
    /// Control steps for which samples may be stale.
    pub stale_steps: u16,
    /// Control steps that a target may be late.
    pub late_steps: u16,
    /// Averaged added damping ratio above which the structure counts as locked.
    pub locked_damping_ratio: f32,
}

/// The finding of an interlock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    /// The fault.
    pub fault: Fault,
    /// The axis.
    pub axis: u8,
    /// The value that was reached.
    pub value: f32,
    /// The limit.
    pub limit: f32,
}

impl Finding {
    /// The first of two in the order of [`Fault::rank`].
    #[inline]
    pub fn first(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        match (one, other) {
            (Some(a), Some(b)) if b.fault.rank() < a.fault.rank() => Some(b),
            (None, other) => other,
            (one, _) => one,
        }
    }

    /// A fault without value or limit.
    pub const fn fact(fault: Fault) -> Self {
        Self {
            fault,
            axis: 0,
            value: 1.0,
            limit: 0.0,
        }
    }
}

/// The values that the interlocks check.
#[derive(Clone, Copy, Debug)]
pub struct Checked<'a, const N: usize> {
    /// The command that is about to be sent, m.
    pub next_m: &'a [f32; N],
    /// The command in force, m.
    pub sent_m: &'a [f32; N],
    /// True displacement that the command in force asks for, m.
    pub aimed_m: &'a [f32; N],
    /// Measured displacement, m, corrected for its known errors.
    pub displacement_m: &'a [f32; N],
    /// Measured force, N.
    pub force_n: &'a [f32; N],
    /// Energy ratio of the monitor.
    pub energy_ratio: f32,
    /// Control steps for which samples have been stale.
    pub stale_steps: u16,
    /// Control steps that the target is late.
    pub late_steps: u16,
    /// Number of axes that have an actuator.
    pub physical: usize,
}

/// True if no limit is exceeded.
#[inline]
pub fn within<const N: usize>(limits: &InterlockLimits, c: &Checked<'_, N>) -> bool {
    // The sign bit of the remaining margin shows an exceeded limit: five limits, one branch.
    let mut passed = 0;
    for j in 0..actuated::<N>(c.physical) {
        passed |= room(limits.displacement_m, c.next_m[j])
            | room(limits.least_step_m, c.next_m[j] - c.sent_m[j])
            | room(limits.force_n, c.force_n[j])
            | room(limits.tracking_m, c.aimed_m[j] - c.displacement_m[j])
            | room(limits.reading_m, c.displacement_m[j]);
    }
    if passed < 0 {
        return unlikely(false);
    }
    c.energy_ratio <= limits.energy_trip
        && c.stale_steps <= limits.stale_steps
        && c.late_steps <= limits.late_steps
}

/// Negative where `|value|` is above `limit`, which is not negative itself. Without their sign numbers are in the order of
/// their bits; a NaN stands behind infinity there and passes every limit.
#[inline]
fn room(limit: f32, value: f32) -> i32 {
    (limit.to_bits() as i32).wrapping_sub(value.abs().to_bits() as i32)
}

/// The first exceeded limit, in the order of [`Fault::rank`]; only searched for when there is one.
#[cold]
#[inline(never)]
pub fn first_fault<const N: usize>(
    limits: &InterlockLimits,
    c: &Checked<'_, N>,
) -> Option<Finding> {
    // Compared as `!(x <= limit)`, so that a NaN fails every limit.
    let mut worst: Option<Finding> = None;
    let mut found = |fault: Fault, axis: usize, value: f32, limit: f32| {
        let first = match worst {
            Some(w) => fault.rank() < w.fault.rank(),
            None => true,
        };
        if first {
            worst = Some(Finding {
                fault,
                axis: axis as u8,
                value,
                limit,
            });
        }
    };
    for j in 0..N.min(c.physical) {
        let next = c.next_m[j];
        let step = (next - c.sent_m[j]).abs();
        let force = c.force_n[j].abs();
        let error = (c.aimed_m[j] - c.displacement_m[j]).abs();
        if !(next.is_finite() && force.is_finite() && error.is_finite()) {
            let culprit = if next.is_finite() {
                force + error
            } else {
                next
            };
            found(Fault::NonFinite, j, culprit, f32::MAX);
        }
        if !(next.abs() <= limits.displacement_m) {
            found(Fault::Displacement, j, next, limits.displacement_m);
        }
        if !(step <= limits.increment_m) {
            found(Fault::Increment, j, step, limits.increment_m);
        }
        if !(step <= limits.velocity_step_m) {
            let rate = limits.rate_hz;
            found(
                Fault::Velocity,
                j,
                step * rate,
                limits.velocity_step_m * rate,
            );
        }
        if !(force <= limits.force_n) {
            found(Fault::Force, j, c.force_n[j], limits.force_n);
        }
        if !(error <= limits.tracking_m) {
            found(Fault::Tracking, j, error, limits.tracking_m);
        }
        let reading = c.displacement_m[j];
        if !(reading.abs() <= limits.reading_m) {
            found(Fault::Reading, j, reading, limits.reading_m);
        }
    }
    if !(c.energy_ratio <= limits.energy_trip) {
        found(Fault::EnergyRatio, 0, c.energy_ratio, limits.energy_trip);
    }
    if c.stale_steps > limits.stale_steps {
        found(
            Fault::StaleSample,
            0,
            f32::from(c.stale_steps),
            f32::from(limits.stale_steps),
        );
    }
    if c.late_steps > limits.late_steps {
        found(
            Fault::TargetLate,
            0,
            f32::from(c.late_steps),
            f32::from(limits.late_steps),
        );
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: InterlockLimits = InterlockLimits {
        displacement_m: 0.1,
        reading_m: 0.103,
        increment_m: 2e-3,
        velocity_step_m: 1e-3,
        least_step_m: 1e-3,
        rate_hz: 2000.0,
        force_n: 1e4,
        tracking_m: 0.02,
        energy_warning: 0.05,
        energy_trip: 0.2,
        stale_steps: 3,
        late_steps: 10,
        locked_damping_ratio: 0.3,
    };

    fn found(change: impl FnOnce(&mut [f32; 5], &mut [u16; 2])) -> Option<Finding> {
        let (mut v, mut n) = ([0.0, 0.0, 0.0, 0.0, 0.0], [0, 0]);
        change(&mut v, &mut n);
        let c = Checked {
            next_m: &[v[0]],
            sent_m: &[v[1]],
            aimed_m: &[v[1]],
            displacement_m: &[v[2]],
            force_n: &[v[3]],
            energy_ratio: v[4],
            stale_steps: n[0],
            late_steps: n[1],
            physical: 1,
        };
        let first = first_fault::<1>(&LIMITS, &c);
        assert_eq!(within::<1>(&LIMITS, &c), first.is_none(), "{c:?}");
        first
    }

    // proves: fault.displacement, fault.velocity, fault.increment, fault.force, fault.tracking, fault.reading
    // proves: fault.energy_ratio, fault.stale_sample, fault.target_late
    #[test]
    fn each_limit_acts_above_and_not_at_its_value() {
        assert_eq!(found(|_, _| ()), None);
        assert_eq!(found(|v, _| (v[0], v[1], v[2]) = (0.1, 0.1, 0.1)), None);
        let fault = |f: Option<Finding>| f.map(|f| f.fault);
        assert_eq!(
            fault(found(|v, _| (v[0], v[1], v[2]) = (0.1001, 0.1, 0.1))),
            Some(Fault::Displacement)
        );
        assert_eq!(fault(found(|v, _| v[0] = 1.5e-3)), Some(Fault::Velocity));
        assert_eq!(fault(found(|v, _| v[0] = 2.5e-3)), Some(Fault::Increment));
        assert_eq!(fault(found(|v, _| v[3] = -1.01e4)), Some(Fault::Force));
        assert_eq!(fault(found(|v, _| v[2] = 0.021)), Some(Fault::Tracking));
        assert_eq!(
            found(|v, _| (v[0], v[1], v[2]) = (-0.1, -0.1, -0.103)),
            None
        );
        assert_eq!(
            found(|v, _| (v[0], v[1], v[2]) = (-0.1, -0.1, -0.1031)),
            Some(Finding {
                fault: Fault::Reading,
                axis: 0,
                value: -0.1031,
                limit: 0.103
            })
        );
        assert_eq!(fault(found(|v, _| v[4] = 0.21)), Some(Fault::EnergyRatio));
        assert_eq!(fault(found(|_, n| n[0] = 4)), Some(Fault::StaleSample));
        assert_eq!(fault(found(|_, n| n[1] = 11)), Some(Fault::TargetLate));
        let velocity = found(|v, _| v[0] = 1.5e-3).unwrap();
        assert!((velocity.value - 3.0).abs() < 1e-5 && (velocity.limit - 2.0).abs() < 1e-5);
    }

    // proves: fault.non_finite
    #[test]
    fn a_nan_or_an_infinity_is_the_first_fault() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for place in 0..4 {
                let f = found(|v, _| v[place] = bad).unwrap();
                assert_eq!(f.fault, Fault::NonFinite, "{bad} in place {place}");
            }
        }
    }
}
