//! The three regressions over four windows: command to displacement, displacement to force, and force in unloading.

use super::declared::{Declared, HalfTolerances};
use super::normal::{Noise, Normal, Solved, ratio};
use super::signals::Row;

/// Number of windows: three that forget, and one that begins at the first doubt.
pub(super) const WINDOWS: usize = 4;
pub(super) const LONGEST: usize = 2;
pub(super) const FRESH: usize = 3;
/// Memory of each window, natural periods.
const PERIODS: [f64; 3] = [0.75, 2.5, 10.0];
/// Speeds and displacements below this have no sign, peaks.
const NO_SIGN: f32 = 0.02;

/// The regressions by number.
pub(super) const ACTUATOR: usize = 0;
pub(super) const FORCE: usize = 1;
pub(super) const UNLOADING: usize = 2;

/// Model errors of each regression, peaks, and as a fraction of the motion.
const FLOORS: [f32; 3] = [0.0015, 0.003, 0.0007];
const OF_MOTION: f32 = 0.002;

/// Constants of the regressions.
#[derive(Clone, Debug)]
pub(super) struct Constants {
    keeps: [f32; WINDOWS],
    /// Damping and mass of the declared specimen, relative to its stiffness.
    damping: f32,
    mass: f32,
    /// Samples in a quarter period.
    quarter: f32,
    /// Least number of samples in a window.
    least: f32,
}

impl Constants {
    pub(super) fn new(d: &Declared, rows_hz: f64) -> Self {
        let w = d.omega_rad_per_s;
        let period_rows = core::f64::consts::TAU / w * rows_hz;
        let mut keeps = [1.0; WINDOWS];
        for (keeps, periods) in keeps.iter_mut().zip(PERIODS) {
            *keeps = libm::exp(-1.0 / (periods * period_rows)) as f32;
        }
        Self {
            keeps,
            damping: (d.damping_n_s_per_m * w / d.stiffness_n_per_m) as f32,
            mass: (d.mass_kg * w * w / d.stiffness_n_per_m) as f32,
            quarter: (0.25 * period_rows) as f32,
            least: (0.1 * period_rows) as f32,
        }
    }

    fn noise(&self, regression: usize, sigma: [f32; 2]) -> Noise {
        let [x, r] = sigma.map(|s| s * s);
        let white = if regression == ACTUATOR { x } else { x + r };
        let floor = FLOORS[regression];
        Noise {
            white: 0.25 * white,
            floor: floor * floor,
            of_motion: OF_MOTION * OF_MOTION,
            coloured: self.quarter,
        }
    }
}

/// The sums of one window.
#[derive(Clone, Debug)]
struct Window {
    actuator: Normal<8, 36>,
    force: Normal<7, 28>,
    unloading: Normal<5, 15>,
}

impl Window {
    const EMPTY: Self = Self {
        actuator: Normal::new(),
        force: Normal::new(),
        unloading: Normal::new(),
    };
}

/// A window's answer for a regression; columns that the regression lacks are 0.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Answer {
    /// Coefficients of each column freed alone, in half tolerances, with their variances.
    pub(super) theta: [f32; 8],
    pub(super) variance: [f32; 8],
    pub(super) explained: f32,
    /// Kept for the longest window only, 0 for the others.
    pub(super) left: f32,
    /// Samples, in natural periods.
    pub(super) periods: f32,
}

impl Answer {
    fn of<const M: usize>(solved: &Solved<M>, periods: f32) -> Self {
        let mut own = Self {
            explained: solved.explained,
            left: solved.left,
            periods,
            ..Self::default()
        };
        own.theta[..M].copy_from_slice(&solved.theta);
        own.variance[..M].copy_from_slice(&solved.variance);
        own
    }

    /// The standard deviation of a column's coefficient, half tolerances.
    pub(super) fn sd(&self, column: usize) -> f32 {
        libm::sqrtf(self.variance[column])
    }

    /// Twice the log-likelihood ratio of each column.
    pub(super) fn ratios(&self) -> [f32; 8] {
        core::array::from_fn(|j| ratio(self.theta[j], self.variance[j]))
    }

    /// The column with the largest likelihood ratio.
    pub(super) fn best(&self) -> (usize, f32) {
        let mut best = (0, 0.0);
        for (j, d) in self.ratios().into_iter().enumerate() {
            if d > best.1 {
                best = (j, d);
            }
        }
        best
    }
}

/// All windows.
#[derive(Clone, Debug)]
pub(super) struct Regressions {
    windows: [Window; WINDOWS],
}

fn sign(x: f32) -> f32 {
    (x / NO_SIGN).clamp(-1.0, 1.0)
}

fn scaled<const M: usize>(mut columns: [f32; M], half: &[f32; M]) -> [f32; M] {
    for (column, half) in columns.iter_mut().zip(half) {
        *column *= half;
    }
    columns
}

impl Regressions {
    pub(super) const fn new() -> Self {
        Self {
            windows: [Window::EMPTY; WINDOWS],
        }
    }

    /// Resets in place.
    pub(super) fn rest(&mut self) {
        self.windows
            .iter_mut()
            .for_each(|window| *window = Window::EMPTY);
    }

    /// Starts the window that begins at a doubt.
    pub(super) fn begin_fresh(&mut self) {
        self.windows[FRESH] = Window::EMPTY;
    }

    /// Adds a row. `fresh`: there is a doubt; `unloading`: columns and residual of a specimen during unloading.
    pub(super) fn add(
        &mut self,
        (k, half): (&Constants, &HalfTolerances),
        row: &Row,
        fresh: bool,
        [actuator, elastic]: [bool; 2],
        unloading: Option<([f32; 5], f32)>,
    ) {
        let [y, v, a] = row.y;
        let [x, v_x] = row.x;
        let columns = [1.0, y, -v, a, -row.held, row.rate, row.stop, -sign(y)];
        let actuator_row = scaled(columns, &half.actuator);
        let beside = k.damping * v_x + k.mass * a;
        let columns = [1.0, x, v_x, a, sign(v_x), -sign(x), x * x * x];
        let force_row = scaled(columns, &half.force);
        let unloads = unloading.map(|(columns, residual)| {
            let [_, v_x, a, ..] = columns;
            let residual = residual - k.damping * v_x - k.mass * a;
            (scaled(columns, &half.unloading), residual)
        });
        for (i, (window, keeps)) in self.windows.iter_mut().zip(k.keeps).enumerate() {
            if i == FRESH && !fresh {
                continue;
            }
            if actuator {
                window.actuator.add(keeps, &actuator_row, x - y, y);
            }
            if elastic {
                window.force.add(keeps, &force_row, row.r - x - beside, x);
            }
            if let Some((columns, residual)) = &unloads {
                window.unloading.add(keeps, columns, *residual, x);
            }
        }
    }

    /// One piece of the work: the answer of window `window` for a regression.
    pub(super) fn solve(
        &self,
        k: &Constants,
        window: usize,
        regression: usize,
        sigma: [f32; 2],
        left_before: f32,
    ) -> Option<Answer> {
        let noise = k.noise(regression, sigma);
        let own = self.windows.get(window)?;
        let periods = |weight: f32| weight / (4.0 * k.quarter);
        let weight = match regression {
            ACTUATOR => own.actuator.weight,
            FORCE => own.force.weight,
            _ => own.unloading.weight,
        };
        if weight < k.least {
            return None;
        }
        let periods = periods(weight);
        Some(match regression {
            ACTUATOR => Answer::of(&own.actuator.solve(&noise, left_before)?, periods),
            FORCE => Answer::of(&own.force.solve(&noise, left_before)?, periods),
            _ => Answer::of(&own.unloading.solve(&noise, left_before)?, periods),
        })
    }
}
