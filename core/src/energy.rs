//! Energy errors of a step, three ways, and the HSEM monitor.
//!
//! Signs: all three are negative if the actuator puts energy *in*, as Eq 14 requires. Eq 7 as printed has the
//! opposite sign and is reversed here: the energy that the integration perceives minus what the specimen really took.
//! Per step, modified - HSEM = the increment of `R (u_m - u_c)`, exactly, for any specimen.

use crate::float::{larger, unlikely};
use crate::structure::actuated;
use crate::sum::CompensatedSum;

/// The longest window, in integration steps, over which Eq 12 can be formed for the compensation.
pub const MAX_WINDOW: usize = 64;

/// The inputs to the energies at an integration step.
#[derive(Clone, Copy, Debug)]
pub struct Observation<const N: usize> {
    /// Command that has been reached, u_c, m.
    pub command_m: [f32; N],
    /// `u_c,i - u_c,i-1` as the integrator knows it, m.
    pub increment_m: [f32; N],
    /// Estimated displacement of the specimen, u_m, m.
    pub displacement_m: [f32; N],
    /// Estimated restoring force, R_m, N.
    pub force_n: [f32; N],
}

/// Errors of one step and their sums, J.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors {
    /// Thewalt and Roman, Eq 6, with the declared stiffness; the paper's sign.
    pub stiffness_j: f32,
    /// HSEM, Eqs 7 to 9 with the sign turned: perceived minus real work.
    pub hsem_j: f32,
    /// Modified, Eqs 10 to 12.
    pub modified_j: f32,
}

/// Eq 12 over the window, axis by axis, with the increment of the command over the same window.
#[derive(Clone, Copy, Debug)]
pub struct Windowed<const N: usize> {
    /// Energy error, J, the paper's sign.
    pub energy_j: [f32; N],
    /// Increment of the command, m.
    pub increment_m: [f32; N],
    /// Increment of the specimen, m.
    pub moved_m: [f32; N],
}

/// The part of an axis's past step that later steps need.
#[derive(Clone, Copy, Debug)]
struct StepBefore {
    command_m: f32,
    displacement_m: f32,
    error_m: f32,
    force_n: f32,
}

impl Errors {
    /// Start value of a sum: adding to -0 changes no number, adding to 0 costs an instruction.
    const NOTHING: Self = Self {
        stiffness_j: -0.0,
        hsem_j: -0.0,
        modified_j: -0.0,
    };
}

impl StepBefore {
    const AT_REST: Self = Self {
        command_m: 0.0,
        displacement_m: 0.0,
        error_m: 0.0,
        force_n: 0.0,
    };
}

/// The three energy errors of a test; the long array comes last.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct EnergyErrors<const N: usize> {
    window: usize,
    newest: usize,
    stiffness_force_n: [f32; N],
    step: Errors,
    cumulative: [CompensatedSum; 3],
    stiffness_n_per_m: [[f32; N]; N],
    /// Unused for axes without an actuator.
    past: [[StepBefore; N]; MAX_WINDOW],
}

impl<const N: usize> EnergyErrors<N> {
    /// `stiffness_n_per_m` is the declared stiffness of the specimen; `window` is in integration steps and
    /// the design has checked it.
    pub fn new(stiffness_n_per_m: [[f32; N]; N], window: usize) -> Self {
        Self {
            stiffness_n_per_m,
            window,
            past: [[StepBefore::AT_REST; N]; MAX_WINDOW],
            newest: 0,
            stiffness_force_n: [0.0; N],
            step: Errors::default(),
            cumulative: [CompensatedSum::default(); 3],
        }
    }

    /// Takes in one integration step; returns Eq 12 over the window for the compensation. A storey without an actuator is
    /// where it was sent and carries no measured force: only the axes `0..physical` have errors.
    #[inline]
    pub fn update(&mut self, now: &Observation<N>, physical: usize) -> Windowed<N> {
        let physical = actuated::<N>(physical);
        let error_m = |j: usize| now.displacement_m[j] - now.command_m[j];
        let last = self.newest % MAX_WINDOW;
        let then = (last + MAX_WINDOW + 1 - self.window) % MAX_WINDOW;
        let newest = (last + 1) % MAX_WINDOW;
        let mut windowed = Windowed {
            energy_j: [0.0; N],
            increment_m: now.increment_m,
            moved_m: [0.0; N],
        };
        let mut step = Errors::NOTHING;
        for j in 0..physical {
            let stiffness_force_n: f32 = (0..physical)
                .map(|k| self.stiffness_n_per_m[j][k] * error_m(k))
                .sum();
            let (last, then) = (self.past[last][j], self.past[then][j]);
            let here = StepBefore {
                command_m: now.command_m[j],
                displacement_m: now.displacement_m[j],
                error_m: error_m(j),
                force_n: now.force_n[j],
            };
            let moved_m = here.displacement_m - last.displacement_m;
            step.stiffness_j +=
                (self.stiffness_force_n[j] + stiffness_force_n) * now.increment_m[j];
            step.hsem_j += (last.force_n + here.force_n) * (now.increment_m[j] - moved_m);
            step.modified_j += (last.error_m + here.error_m) * (here.force_n - last.force_n);
            windowed.energy_j[j] =
                0.5 * (then.error_m + here.error_m) * (here.force_n - then.force_n);
            windowed.moved_m[j] = here.displacement_m - then.displacement_m;
            if self.window > 1 {
                windowed.increment_m[j] = here.command_m - then.command_m;
            }
            self.stiffness_force_n[j] = stiffness_force_n;
            self.past[newest][j] = here;
        }
        // Of each product with a mean, twice has been added up.
        for twice in [
            &mut step.stiffness_j,
            &mut step.hsem_j,
            &mut step.modified_j,
        ] {
            *twice *= 0.5;
        }
        self.cumulative[0].add(step.stiffness_j);
        self.cumulative[1].add(step.hsem_j);
        self.cumulative[2].add(step.modified_j);
        self.step = step;
        self.newest = newest;
        windowed
    }

    /// The errors of the last step.
    #[inline]
    pub fn step(&self) -> Errors {
        self.step
    }

    /// The errors added up since the start.
    #[inline]
    pub fn cumulative(&self) -> Errors {
        Errors {
            stiffness_j: self.cumulative[0].value(),
            hsem_j: self.cumulative[1].value(),
            modified_j: self.cumulative[2].value(),
        }
    }
}

/// The fraction of the test's energy that is error: Mosqueda's indicator.
///
/// `|HSEM error + work of the correction| / (input energy + largest strain energy)`. Error energy that the compensation
/// has removed no longer counts; without compensation the numerator is plain HSEM.
#[derive(Clone, Debug)]
pub struct Monitor<const N: usize> {
    half_stiffness_n_per_m: [f32; N],
    floor_j: f32,
    input: CompensatedSum,
    correction: CompensatedSum,
    largest_strain_j: f32,
    load_n: [f32; N],
    correction_n: [f32; N],
    ratio: f32,
}

impl<const N: usize> Monitor<N> {
    /// `stiffness_n_per_m` is the diagonal of the declared stiffness; below `floor_j` the ratio is not formed.
    pub fn new(stiffness_n_per_m: [f32; N], floor_j: f32) -> Self {
        Self {
            half_stiffness_n_per_m: stiffness_n_per_m.map(|k| 0.5 * k),
            floor_j,
            input: CompensatedSum::default(),
            correction: CompensatedSum::default(),
            largest_strain_j: 0.0,
            load_n: [0.0; N],
            correction_n: [0.0; N],
            ratio: 0.0,
        }
    }

    /// Takes in one step: external load, force of the correction, increment and restoring force. The specimen is on the
    /// axes `0..physical`.
    #[inline]
    pub fn update(
        &mut self,
        now: &Observation<N>,
        physical: usize,
        load_n: [f32; N],
        correction_n: [f32; N],
        hsem_j: f32,
    ) {
        let (mut strain_j, mut input_j) = (-0.0, -0.0);
        let half_m = now.increment_m.map(|du| 0.5 * du);
        for j in 0..N {
            input_j += (self.load_n[j] + load_n[j]) * half_m[j];
        }
        self.input.add(input_j);
        for j in 0..actuated::<N>(physical) {
            let work_j = (self.correction_n[j] + correction_n[j]) * half_m[j];
            self.correction.add(work_j);
            let of_m = now.displacement_m[j];
            strain_j += self.half_stiffness_n_per_m[j] * of_m * of_m;
        }
        self.load_n = load_n;
        self.correction_n = correction_n;
        self.largest_strain_j = larger(self.largest_strain_j, strain_j);
        let (input_j, mut scale_j) = (self.input.value(), self.largest_strain_j);
        if input_j > 0.0 {
            scale_j += input_j;
        }
        // 0/0 at the start is not an error.
        self.ratio = if scale_j > self.floor_j {
            (hsem_j + self.correction.value()).abs() / scale_j
        } else {
            unlikely(0.0)
        };
    }

    /// Energy error relative to the energy in the test.
    #[inline]
    pub fn ratio(&self) -> f32 {
        self.ratio
    }

    /// Work done by the external load since the start, J.
    #[inline]
    pub fn input_j(&self) -> f32 {
        self.input.value()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A linear specimen that follows a sine with a phase lag.
    fn lagging(steps: usize, lag: f32) -> (EnergyErrors<1>, f32, f32) {
        let mut errors = EnergyErrors::new([[158e3]], 1);
        let (mut previous, mut identity, mut worst) = (0.0, 0.0_f32, 0.0_f32);
        for i in 0..steps {
            let t = i as f32 * 0.004;
            let command = 0.1 * libm::sinf(t);
            let moved = 0.1 * libm::sinf(t - lag) * f32::from(u8::from(t > lag));
            let force = 158e3 * moved;
            let now = Observation {
                command_m: [command],
                increment_m: [command - previous],
                displacement_m: [moved],
                force_n: [force],
            };
            errors.update(&now, 1);
            let product = force * (moved - command);
            let step = errors.step();
            worst = worst.max((step.modified_j - step.hsem_j - (product - identity)).abs());
            identity = product;
            previous = command;
        }
        (errors, worst, identity)
    }

    #[test]
    fn eq_7_and_eq_12_add_up_to_the_change_of_force_times_error() {
        let (_, worst, _) = lagging(10_000, 0.05);
        assert!(worst < 1e-3, "identity off by {worst} J");
    }

    #[test]
    fn the_three_cumulative_errors_agree_over_whole_cycles_and_have_their_signs() {
        // 2 pi / 0.004 is not whole: the end term R (u_m - u_c) is taken out by the identity.
        let (errors, _, rest) = lagging(15_708, 0.05);
        let e = errors.cumulative();
        assert!(e.hsem_j < 0.0, "a lagging actuator puts energy in");
        assert!((e.modified_j - e.stiffness_j).abs() < 2e-3 * e.hsem_j.abs());
        assert!((e.modified_j - rest - e.hsem_j).abs() < 2e-3 * e.hsem_j.abs());
        // Ten cycles of pi K A^2 sin(lag).
        let exact = -10.0 * core::f32::consts::PI * 158e3 * 0.01 * libm::sinf(0.05);
        assert!((e.hsem_j / exact - 1.0).abs() < 0.01);
    }

    #[test]
    fn a_lead_has_the_opposite_sign() {
        let (lag, ..) = lagging(3_142, 0.05);
        let (lead, ..) = lagging(3_142, -0.05);
        assert!(lag.cumulative().hsem_j < 0.0 && lead.cumulative().hsem_j > 0.0);
    }
}
