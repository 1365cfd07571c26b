//! Past targets in a short ring: every `stride`-th is kept, those between are interpolated.
//!
//! Three delays of 60 ms at 2 kHz are 360 control steps, more memory than a loop has. A structure moves at some hertz,
//! so points 3 ms apart with a cubic between them lose less than 1e-6 of it.

/// Points that are kept.
pub const POINTS: usize = 64;

/// Points that a tap may reach back.
pub const REACH: usize = POINTS - 3;

/// Past targets of one axis.
#[derive(Clone, Debug)]
pub(crate) struct PastTargets {
    values: [f32; POINTS],
    newest: u16,
    /// Control steps since the newest point.
    phase: u16,
}

impl PastTargets {
    /// At rest at zero.
    pub const fn at_rest() -> Self {
        Self {
            values: [0.0; POINTS],
            newest: 0,
            phase: 0,
        }
    }

    /// Takes in the target of a control step; every `stride`-th is kept.
    #[inline]
    pub fn push(&mut self, stride: u16, value: f32) {
        self.phase += 1;
        if self.phase >= stride {
            self.phase = 0;
            self.newest = (self.newest + 1) % POINTS as u16;
            self.values[usize::from(self.newest) % POINTS] = value;
        }
    }

    /// The target `steps` control steps before the last that was taken in.
    #[inline]
    pub fn tap(&self, per_stride: f32, steps: f32) -> f32 {
        let place = (steps - f32::from(self.phase)) * per_stride;
        // The four points around the place; in front of the newest the cubic is extrapolated by less than a stride.
        let first = (place as i32 - 1).clamp(0, REACH as i32 - 1);
        let t = place - first as f32;
        let at = |i: usize| {
            self.values[(usize::from(self.newest) + 2 * POINTS - first as usize - i) % POINTS]
        };
        // Lagrange's cubic through 0, 1, 2, 3.
        let (a, b, c) = (t - 1.0, t - 2.0, t - 3.0);
        let (ab, tc) = (a * b, t * c);
        -ab * c * (1.0 / 6.0) * at(0) + 0.5 * tc * b * at(1) - 0.5 * tc * a * at(2)
            + t * ab * (1.0 / 6.0) * at(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_exact_at_kept_points_and_close_between_them() {
        for stride in [1, 3, 6] {
            let u = |i: f32| libm::sinf(0.0063 * i);
            let mut past = PastTargets::at_rest();
            let mut worst = 0.0_f32;
            for i in 0..3000 {
                past.push(stride, u(i as f32));
                for steps in [1.0, 7.25, 20.0, 55.5, 60.0 * f32::from(stride) - 6.0] {
                    if steps < 1000.0 && i > 1000 {
                        let tapped = past.tap(1.0 / f32::from(stride), steps);
                        worst = worst.max((tapped - u(i as f32 - steps)).abs());
                    }
                }
            }
            assert!(worst < 5e-6, "stride {stride}: {worst}");
        }
    }
}
