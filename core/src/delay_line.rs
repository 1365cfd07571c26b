//! Values in transit, with a delay that need not be a whole number of control steps.

/// The longest transport delay, in control steps.
pub(crate) const MAX_DELAY_STEPS: usize = 128;

/// Values in transit, for example commands to the actuator: a delay line with a fractional tap.
#[derive(Clone, Debug)]
pub(crate) struct DelayLine<const LENGTH: usize = MAX_DELAY_STEPS> {
    sent_m: [f32; LENGTH],
    newest: usize,
}

/// A delay of `whole + fraction` control steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Delay {
    whole: usize,
    fraction: f32,
}

impl Delay {
    /// A delay in control steps, at most the line's length minus 2, as checked by the design.
    pub fn new(steps: f64) -> Self {
        let steps = steps.clamp(0.0, (MAX_DELAY_STEPS - 2) as f64);
        Self {
            whole: steps as usize,
            fraction: (steps - libm::floor(steps)) as f32,
        }
    }

    /// The same in single precision, for a step.
    #[inline]
    pub fn of_steps(steps: f32) -> Self {
        let whole = steps as usize;
        Self {
            whole,
            fraction: steps - whole as f32,
        }
    }
}

impl<const LENGTH: usize> DelayLine<LENGTH> {
    /// Full of `position_m`.
    pub const fn filled(position_m: f32) -> Self {
        Self {
            sent_m: [position_m; LENGTH],
            newest: 0,
        }
    }

    /// Takes a command and returns the one that arrives now.
    #[inline]
    pub fn pass(&mut self, delay: Delay, command_m: f32) -> f32 {
        self.newest = (self.newest + 1) % LENGTH;
        self.sent_m[self.newest] = command_m;
        let tap = |steps: usize| self.sent_m[(self.newest + LENGTH - steps % LENGTH) % LENGTH];
        let (near, far) = (tap(delay.whole), tap(delay.whole + 1));
        near + delay.fraction * (far - near)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_delay_line_is_exact_for_a_ramp() {
        let delay = Delay::new(7.25);
        let mut line = DelayLine::<16>::filled(0.0);
        for i in 0..500 {
            let out = line.pass(delay, i as f32);
            if i > 10 {
                assert_eq!(out, i as f32 - 7.25);
            }
        }
    }
}
