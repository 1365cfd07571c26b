//! Signal generation: from integration steps to control steps.
//!
//! An integration step may last many control steps. While its target is not yet known the command is extrapolated;
//! from then on it is interpolated to the target (Nakashima and Masaoka 1999). Their Lagrange polynomials through past
//! targets jump where one takes over from the other; here the first is the Taylor polynomial of the known motion and
//! the second the cubic that starts with the displacement and velocity that have been reached and ends with the
//! target's, so the command and its velocity are continuous at the switch and from interval to interval.
//!
//! If a target is late, the command slows down and holds; the test trips after a set time.
//!
//! The core's own integration knows the next target at once ([`SignalGenerator::aim`]). With an external numerical part
//! the interval begins with [`SignalGenerator::depart`] and the target comes during it ([`SignalGenerator::arrive`]).
//! Until then the interval's clock stops at the end of the extrapolation.

/// Constants of the generator, in control steps.
#[derive(Clone, Copy, Debug)]
pub struct SignalConstants {
    /// Control steps in an integration step.
    pub substeps: u16,
    /// Control steps of extrapolation before the target is used.
    pub solve_substeps: u16,
    /// Factor on the velocity in each step while slowing down.
    pub slow_down: f32,
    /// 1 / substeps.
    pub per_substep: f32,
}

/// The end of an integration step, by axis.
#[derive(Clone, Copy, Debug)]
pub struct Target<const N: usize> {
    /// Displacement at the end of the step, m.
    pub displacement_m: [f32; N],
    /// Predictor velocity there, m per integration step.
    pub velocity_dt_m: [f32; N],
    /// Acceleration of the last solved step, m per integration step squared.
    pub acceleration_dt2_m: [f32; N],
}

/// Generates the commands between targets.
#[derive(Clone, Debug)]
pub struct SignalGenerator<const N: usize> {
    command_m: [f32; N],
    /// Velocity of the command, m per control step.
    velocity_m: [f32; N],
    /// Start of the present segment.
    from_m: [f32; N],
    from_velocity_m: [f32; N],
    target: Target<N>,
    /// Acceleration to extrapolate with, m per control step squared.
    acceleration_m: [f32; N],
    /// Control steps since the interval began; at `length` or more the target has been reached.
    tick: u16,
    length: u16,
    late: u16,
    /// True if the interval has begun but its target is not known yet.
    awaited: bool,
}

impl<const N: usize> SignalGenerator<N> {
    /// Standing at `position_m`, ready for a first target.
    pub const fn standing_at(position_m: [f32; N]) -> Self {
        Self {
            command_m: position_m,
            velocity_m: [0.0; N],
            from_m: position_m,
            from_velocity_m: [0.0; N],
            target: Target {
                displacement_m: position_m,
                velocity_dt_m: [0.0; N],
                acceleration_dt2_m: [0.0; N],
            },
            acceleration_m: [0.0; N],
            tick: 0,
            length: 0,
            late: 0,
            awaited: false,
        }
    }

    /// The command that was last generated, m.
    #[inline]
    pub fn command_m(&self) -> &[f32; N] {
        &self.command_m
    }

    /// Velocity of the command, m per control step.
    #[inline]
    pub fn velocity_m(&self) -> &[f32; N] {
        &self.velocity_m
    }

    /// Acceleration of the command, m per control step squared.
    #[inline]
    pub fn acceleration_m(&self, k: &SignalConstants) -> [f32; N] {
        if self.tick >= self.length {
            let per = k.per_substep * k.per_substep;
            return self.target.acceleration_dt2_m.map(|a| a * per);
        }
        if self.tick <= k.solve_substeps {
            return self.acceleration_m;
        }
        // The second derivative of the cubic of `interpolate`.
        let span = f32::from(self.length.saturating_sub(k.solve_substeps));
        let t = f32::from(self.tick.saturating_sub(k.solve_substeps)) / span;
        core::array::from_fn(|j| {
            let rise = self.target.displacement_m[j] - self.from_m[j];
            let start = self.from_velocity_m[j] * span;
            let end = self.target.velocity_dt_m[j] * k.per_substep * span;
            let square = 3.0 * rise - 2.0 * start - end;
            let cube = start + end - 2.0 * rise;
            (2.0 * square + 6.0 * t * cube) / (span * span)
        })
    }

    /// Continues from `position_m` at the present velocity, e.g. to slow down from the command really sent.
    pub fn start_from(&mut self, position_m: [f32; N]) {
        self.command_m = position_m;
    }

    /// True if the last target has been reached: the sample belongs to it and the next step can be solved.
    #[inline]
    pub fn at_target(&self) -> bool {
        self.tick >= self.length
    }

    /// Control steps by which the present target is late.
    #[inline]
    pub fn late_steps(&self) -> u16 {
        self.late
    }

    /// Takes the next target.
    #[inline]
    pub fn aim(&mut self, k: &SignalConstants, target: Target<N>) {
        let per = k.per_substep;
        // Extrapolate the motion known before the solution: use the previous target's acceleration.
        self.acceleration_m = self.target.acceleration_dt2_m.map(|a| a * per * per);
        self.from_m = self.command_m;
        self.from_velocity_m = self.velocity_m;
        self.target = target;
        self.tick = 0;
        self.length = k.substeps;
        self.late = 0;
    }

    /// Begins an interval whose target is not known yet, from the known motion.
    pub fn depart(&mut self, k: &SignalConstants) {
        self.aim(k, self.target);
        self.awaited = true;
    }

    /// True if the interval has begun and waits for its target.
    pub fn awaits_target(&self) -> bool {
        self.awaited
    }

    /// Takes the target of the interval that has begun.
    pub fn arrive(&mut self, target: Target<N>) {
        self.target = target;
        self.awaited = false;
        self.late = 0;
    }

    /// The next command of the interval; past its end, slows down and holds. True if the target is late.
    #[inline(always)] // An interval of one control step is the common one: two copies.
    pub fn advance(&mut self, k: &SignalConstants) -> bool {
        if self.at_target() {
            self.wait(k);
            return true;
        }
        self.tick += 1;
        if self.tick >= self.length {
            self.command_m = self.target.displacement_m;
            self.velocity_m = self.target.velocity_dt_m.map(|v| v * k.per_substep);
        } else {
            self.move_inside_interval(k);
        }
        false
    }

    /// Like [`Self::advance`], but the target may still be awaited: it is late once the extrapolation has ended, and
    /// the interval's clock stops until it comes.
    pub fn advance_or_wait(&mut self, k: &SignalConstants) -> bool {
        if self.awaited && self.tick >= k.solve_substeps {
            self.wait(k);
            return true;
        }
        self.advance(k)
    }

    /// The target is late: slows down and holds.
    #[inline(never)]
    fn wait(&mut self, k: &SignalConstants) {
        self.late = self.late.saturating_add(1);
        for j in 0..N {
            self.velocity_m[j] *= k.slow_down;
            self.command_m[j] += self.velocity_m[j];
        }
    }

    /// A command within the interval.
    #[inline(never)]
    fn move_inside_interval(&mut self, k: &SignalConstants) {
        if self.tick <= k.solve_substeps {
            let t = f32::from(self.tick);
            for j in 0..N {
                let a = self.acceleration_m[j];
                self.velocity_m[j] = self.from_velocity_m[j] + a * t;
                self.command_m[j] = self.from_m[j] + t * (self.from_velocity_m[j] + 0.5 * a * t);
            }
        } else {
            if self.tick == k.solve_substeps + 1 {
                self.from_m = self.command_m;
                self.from_velocity_m = self.velocity_m;
            }
            self.interpolate(k);
        }
    }

    /// Adopts an externally given command, so that a ramp to hold can begin from its velocity.
    pub fn follow(&mut self, command_m: [f32; N]) {
        for j in 0..N {
            self.velocity_m[j] = command_m[j] - self.command_m[j];
        }
        self.command_m = command_m;
    }

    /// A step of the ramp to hold: the speed of each axis falls by `by_m` per control step until the command stops.
    pub fn decelerate(&mut self, by_m: [f32; N]) {
        for j in 0..N {
            let (v, by) = (self.velocity_m[j], by_m[j]);
            self.velocity_m[j] = if v.abs() <= by {
                0.0
            } else {
                v - by.copysign(v)
            };
            self.command_m[j] += self.velocity_m[j];
        }
    }

    /// One point of the cubic from where the interpolation began to the target.
    fn interpolate(&mut self, k: &SignalConstants) {
        let span = f32::from(self.length - k.solve_substeps);
        let t = f32::from(self.tick - k.solve_substeps) / span;
        for j in 0..N {
            let rise = self.target.displacement_m[j] - self.from_m[j];
            let start = self.from_velocity_m[j] * span;
            let end = self.target.velocity_dt_m[j] * k.per_substep * span;
            // Cubic Hermite: from + start t + (3 rise - 2 start - end) t^2 + (start + end - 2 rise) t^3.
            let square = 3.0 * rise - 2.0 * start - end;
            let cube = start + end - 2.0 * rise;
            self.command_m[j] = self.from_m[j] + t * (start + t * (square + t * cube));
            self.velocity_m[j] = (start + t * (2.0 * square + t * 3.0 * cube)) / span;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn constants(substeps: u16, solve_substeps: u16) -> SignalConstants {
        SignalConstants {
            substeps,
            solve_substeps,
            slow_down: 0.8,
            per_substep: 1.0 / f32::from(substeps),
        }
    }

    /// u = sin(t), 0.1 rad an interval, with exact velocities and accelerations.
    fn sine_target(i: u16) -> Target<1> {
        let (h, t) = (0.1, f64::from(i) * 0.1);
        Target {
            displacement_m: [libm::sin(t) as f32],
            velocity_dt_m: [(h * libm::cos(t)) as f32],
            acceleration_dt2_m: [(-h * h * libm::sin(t)) as f32],
        }
    }

    #[test]
    fn is_continuous_in_displacement_and_velocity_and_meets_every_target() {
        for solve in [0, 3, 9] {
            let k = constants(10, solve);
            let mut g = SignalGenerator::<1>::standing_at([0.0]);
            g.velocity_m = [0.01];
            let (mut last, mut last_step) = (0.0_f32, 0.01_f32);
            for i in 1..200 {
                g.aim(&k, sine_target(i));
                for tick in 1..=10 {
                    g.advance(&k);
                    let step = g.command_m[0] - last;
                    // Bound: the largest acceleration of the smooth motion, 1e-4 a step^2, and the correction at a
                    // late switch, which has only one control step left at solve = 9.
                    let bound = if solve == 9 { 9e-4 } else { 3.0e-4 };
                    assert!(
                        (step - last_step).abs() < bound,
                        "solve {solve}, {i}.{tick}: {step} {last_step}"
                    );
                    (last, last_step) = (g.command_m[0], step);
                }
                assert_eq!(g.command_m, sine_target(i).displacement_m);
                assert!(g.at_target());
            }
        }
    }

    #[test]
    fn one_substep_passes_the_target_through() {
        let k = constants(1, 0);
        let mut g = SignalGenerator::<1>::standing_at([0.0]);
        g.aim(&k, sine_target(1));
        g.advance(&k);
        assert_eq!(g.command_m, sine_target(1).displacement_m);
    }

    #[test]
    fn a_target_from_outside_gives_the_same_command_if_it_comes_while_the_command_is_extrapolated()
    {
        let k = constants(10, 4);
        for comes_at in [0, 2, 4] {
            let mut known = SignalGenerator::<1>::standing_at([0.0]);
            let mut awaited = known.clone();
            for i in 1..50 {
                known.aim(&k, sine_target(i));
                awaited.depart(&k);
                for tick in 0..10 {
                    if tick == comes_at {
                        awaited.arrive(sine_target(i));
                    }
                    known.advance(&k);
                    awaited.advance_or_wait(&k);
                    assert_eq!(known.command_m, awaited.command_m, "{i}.{tick}");
                    assert_eq!(awaited.late_steps(), 0);
                }
                assert!(awaited.at_target());
            }
        }
    }

    #[test]
    fn a_target_from_outside_that_is_late_holds_the_command_and_then_goes_on_without_a_jump() {
        let k = constants(20, 12);
        let mut g = SignalGenerator::<1>::standing_at([0.0]);
        let (mut last, mut last_step, mut largest, mut latest) = (0.0_f32, 0.0_f32, 0.0_f32, 0);
        for i in 1..120 {
            g.depart(&k);
            // Every tenth target comes 200 control steps late.
            let comes_after = if i % 10 == 0 { 212 } else { 6 };
            let mut ticks = 0;
            while !g.at_target() {
                if ticks == comes_after {
                    g.arrive(sine_target(i));
                }
                g.advance_or_wait(&k);
                ticks += 1;
                let step = g.command_m[0] - last;
                largest = largest.max((step - last_step).abs());
                latest = latest.max(g.late_steps());
                (last, last_step) = (g.command_m[0], step);
            }
            assert_eq!(
                g.command_m,
                sine_target(i).displacement_m,
                "every target is met"
            );
        }
        // From rest to the target in 8 steps: 6 * 0.1 / 8^2 a step squared at most; slowing down begins with a fifth of
        // the speed of 5e-3.
        assert!(largest < 0.0094, "{largest}");
        assert_eq!(latest, 200);
    }

    #[test]
    fn a_late_target_slows_the_command_down_to_a_hold() {
        let k = constants(1, 0);
        let mut g = SignalGenerator::<1>::standing_at([0.0]);
        g.aim(
            &k,
            Target {
                velocity_dt_m: [1e-3],
                displacement_m: [1e-3],
                acceleration_dt2_m: [0.0],
            },
        );
        g.advance(&k);
        let mut steps = [0.0_f32; 60];
        for step in &mut steps {
            let before = g.command_m[0];
            g.advance(&k);
            *step = g.command_m[0] - before;
        }
        assert!(
            steps.windows(2).all(|w| w[1] <= w[0]),
            "it only ever slows down"
        );
        assert!(steps[0] < 1e-3 && steps[59] < 1e-8);
        assert_eq!(g.late_steps(), 60);
    }
}
