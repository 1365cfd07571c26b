//! The filter of the loop: none, the low-pass, or the two-stage Kalman filter at its steady gain.

use super::blocks::{Block, Delay, Lag, StateRow, nothing};
use nalgebra::{Matrix2, Vector2};
use outerloop_core::Config;
use outerloop_core::config::{Estimation, Filter};

/// The filter of all axes.
#[derive(Clone, Debug)]
pub enum LinearFilter {
    /// Samples as they are.
    Off,
    /// Both channels of each axis.
    LowPass(Vec<[Biquad; 2]>),
    /// The first stage, and the stiffness of each storey that the second has found.
    Kalman(Vec<Tracker>, Vec<f64>),
}

impl LinearFilter {
    /// As configured; `storeys` is what the second stage converges to, N/m.
    pub fn new(config: &Config, storeys: &[f64]) -> Self {
        let (e, rate_hz) = (&config.estimation, config.timing.rate_hz);
        let axes = storeys.len();
        match e.kind {
            Filter::Off => Self::Off,
            Filter::LowPass => {
                let biquad = Biquad::butterworth(e.cutoff_hz, rate_hz);
                Self::LowPass(vec![[biquad.clone(), biquad]; axes])
            }
            Filter::Kalman => {
                let trackers = (0..axes).map(|j| Tracker::new(e, j, rate_hz));
                Self::Kalman(trackers.collect(), storeys.to_vec())
            }
        }
    }

    /// One control period.
    pub fn step(
        &mut self,
        sent: &[StateRow],
        displacement: Vec<StateRow>,
        force: Vec<StateRow>,
    ) -> (Vec<StateRow>, Vec<StateRow>) {
        match self {
            Self::Off => (displacement, force),
            Self::LowPass(channels) => {
                let mut filtered = (Vec::new(), Vec::new());
                for ((pair, x), f) in channels.iter_mut().zip(displacement).zip(force) {
                    filtered.0.push(pair[0].step(x));
                    filtered.1.push(pair[1].step(f));
                }
                filtered
            }
            Self::Kalman(trackers, storeys) => {
                let x: Vec<StateRow> = trackers
                    .iter_mut()
                    .zip(sent)
                    .zip(displacement)
                    .map(|((t, sent), x)| t.step(sent, &x))
                    .collect();
                let shear = |j: usize| match j.checked_sub(1) {
                    Some(below) => (&x[j] - &x[below]) * storeys[j],
                    None => &x[j] * storeys[j],
                };
                let force = (0..x.len())
                    .map(|j| match j + 1 < x.len() {
                        true => shear(j) - shear(j + 1),
                        false => shear(j),
                    })
                    .collect();
                (x, force)
            }
        }
    }
}

impl Block for LinearFilter {
    fn states<'a>(&'a mut self, all: &mut Vec<&'a mut StateRow>) {
        match self {
            Self::Off => {}
            Self::LowPass(channels) => {
                for channel in channels.iter_mut().flatten() {
                    all.extend(channel.x.iter_mut().chain(&mut channel.y));
                }
            }
            Self::Kalman(trackers, _) => {
                for t in trackers {
                    t.line.states(all);
                    all.extend(&mut t.state);
                }
            }
        }
    }
}

/// A second-order Butterworth low-pass by the bilinear transform.
#[derive(Clone, Debug)]
pub struct Biquad {
    b: [f64; 3],
    a: [f64; 2],
    x: [StateRow; 2],
    y: [StateRow; 2],
}

impl Biquad {
    fn butterworth(cutoff_hz: f64, rate_hz: f64) -> Self {
        let w = (std::f64::consts::PI * cutoff_hz / rate_hz).tan();
        let norm = 1.0 / (1.0 + std::f64::consts::SQRT_2 * w + w * w);
        let b0 = w * w * norm;
        Self {
            b: [b0, 2.0 * b0, b0],
            a: [
                2.0 * (w * w - 1.0) * norm,
                (1.0 - std::f64::consts::SQRT_2 * w + w * w) * norm,
            ],
            x: [nothing(), nothing()],
            y: [nothing(), nothing()],
        }
    }

    fn step(&mut self, x: StateRow) -> StateRow {
        let y = &x * self.b[0] + &self.x[0] * self.b[1] + &self.x[1] * self.b[2]
            - &self.y[0] * self.a[0]
            - &self.y[1] * self.a[1];
        self.x.rotate_right(1);
        self.y.rotate_right(1);
        (self.x[0], self.y[0]) = (x, y.clone());
        y
    }
}

/// The first stage of the Kalman filter: displacement and velocity behind a model of the actuator.
#[derive(Clone, Debug)]
pub struct Tracker {
    line: Delay,
    transition: Matrix2<f64>,
    input: Vector2<f64>,
    gain: Vector2<f64>,
    state: [StateRow; 2],
}

impl Tracker {
    fn new(e: &Estimation, axis: usize, rate_hz: f64) -> Self {
        let period_s = 1.0 / rate_hz;
        // Velocity in metres per control step.
        let scale = Matrix2::new(1.0, 0.0, 0.0, period_s);
        let lag = Lag::second_order(e.lag_ms.at(axis) * 1e-3, e.lag_damping_ratio, period_s);
        let (f, g) = lag.matrices();
        let f = Matrix2::from_fn(|i, j| f[(i, j)]);
        let transition = scale * f * Matrix2::new(1.0, 0.0, 0.0, rate_hz);
        let input = scale * Vector2::new(g[0], g[1]);
        let q = (e.process_m_per_s2 * period_s * period_s).powi(2);
        let process = Matrix2::new(q / 4.0, q / 2.0, q / 2.0, q);
        let noise = e.displacement_noise_m.powi(2);
        // The steady state of the filter, by going there.
        let mut p = process;
        let mut gain = Vector2::zeros();
        for _ in 0..STEPS_TO_STEADY {
            let k = p.column(0) / (p[(0, 0)] + noise);
            let done = (k - gain).norm() <= 1e-13 * k.norm();
            gain = k;
            p = transition * (p - k * p.row(0)) * transition.transpose() + process;
            if done {
                break;
            }
        }
        Self {
            line: Delay::straight(e.delay_ms.at(axis) * 1e-3 * rate_hz),
            transition,
            input,
            gain,
            state: [nothing(), nothing()],
        }
    }

    fn step(&mut self, sent: &StateRow, measured: &StateRow) -> StateRow {
        let u = self.line.step(sent.clone());
        let [x, v] = &self.state;
        let predicted = |i: usize| {
            x * self.transition[(i, 0)] + v * self.transition[(i, 1)] + &u * self.input[i]
        };
        let (position, velocity) = (predicted(0), predicted(1));
        let innovation = measured - &position;
        self.state = [
            position + &innovation * self.gain[0],
            velocity + innovation * self.gain[1],
        ];
        self.state[0].clone()
    }
}

/// A filter that learns slower than in ten million steps does not learn within a test.
const STEPS_TO_STEADY: usize = 10_000_000;
