//! Core's predictors as linear systems.
//!
//! A fixed predictor is linear as it is. An adaptive one is not: what stands for it is the predictor with its law at rest,
//! either with what it was told ([`Law::Told`]: how it starts, and how it stays while the motion is below its floor) or
//! with what it has come to ([`Law::Learnt`]): the parameters that bring this very rig to the target at the
//! frequency of the first mode in the loop, within the law's bounds. While it learns it is neither.
//!
//! | predictor | learnt at the first mode's frequency |
//! |---|---|
//! | `darby`, `adaptive-inverse` | the delay |
//! | `afp` | delay and gain |
//! | `ats` | its three coefficients, the two that a single frequency cannot tell apart moved alike |
//! | `amb` | its four coefficients, shared as its gains do |
//! | `hydraulic` | its parameters, as displacement and velocity |
//! | `mcs` | nothing: its gains stay, its proportional part is a feedback of the error, as its mean over a cycle |

mod inverses;

use super::blocks::{Block, Delay, Signal, nothing};
use super::closed_loop::Frame;
use super::rig::LinearRig;
use nalgebra::{Complex, DMatrix};
use outerloop_core::config::{Compensation, Hydraulic};
use outerloop_core::{Config, Prediction};

/// What adaptive predictors know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// What they were told.
    Told,
    /// What they come to on the rig.
    Learnt,
}

/// Whether a predictor learns.
pub fn adaptive(kind: Prediction) -> bool {
    matches!(
        kind,
        Prediction::Darby
            | Prediction::Mcs
            | Prediction::Afp
            | Prediction::AdaptiveInverse
            | Prediction::Ats
            | Prediction::Amb
            | Prediction::Hydraulic
    )
}

/// A sum of the motion ahead and of what came of the last command, in powers of a control step.
#[derive(Clone, Debug, Default)]
struct Sum {
    displacement: f64,
    velocity: f64,
    acceleration: f64,
    /// Of the change of the acceleration.
    jerk: f64,
    /// Of the target less the one in force.
    rise: f64,
    /// Of the tracking error.
    error: f64,
    /// Of the low-passed tracking error, and what the low-pass takes.
    feedback: [f64; 2],
}

#[derive(Clone, Debug)]
enum Kind {
    None,
    Sum {
        sum: Sum,
        last_acceleration: Signal,
        error: Signal,
    },
    /// Weights of the target now, and one, two and three delays ago.
    Extrapolation {
        weights: [f64; 4],
        past: Vec<Delay>,
    },
    /// `new x + last x_1 + memory y_1`.
    Lead {
        weights: [f64; 3],
        target: Signal,
        command: Signal,
    },
    /// Row of this axis on velocities and accelerations of all.
    Model {
        velocity: Vec<f64>,
        acceleration: Vec<f64>,
    },
}

/// The predictors of all axes in the laboratory.
#[derive(Clone, Debug)]
pub struct Predictor {
    axes: Vec<Kind>,
    /// Control steps by which the target is led.
    lead: f64,
    /// By how much the last target of each axis was led.
    led: Vec<Signal>,
    /// Some axis would have to learn more than the bounds of its law allow.
    pub at_bounds: bool,
}

/// A parameter within the bounds of its law; `reached` is set where they are in its way.
fn bounded(value: f64, low: f64, high: f64, reached: &mut bool) -> f64 {
    *reached |= !(low..=high).contains(&value);
    value.clamp(low, high)
}

/// The motion of all floors ahead, in control steps.
#[derive(Clone, Copy, Debug)]
pub struct Ahead<'a> {
    /// Next targets.
    pub displacement: &'a [Signal],
    /// Their velocities.
    pub velocity: &'a [Signal],
    /// Their accelerations.
    pub acceleration: &'a [Signal],
}

impl Predictor {
    /// As configured, on `rig`; what learns has learnt at `at` rad/s of model time.
    pub fn new(config: &Config, frame: &Frame, rig: &LinearRig, law: Law, at: f64) -> Self {
        let omega = at / (config.timing.time_scale * config.timing.rate_hz);
        let mut at_bounds = false;
        let axes: Vec<Kind> = (0..config.physical_storeys())
            .map(|j| match config.compensation.kind.predictor {
                Prediction::ModelPrediction => model(config, frame, j),
                _ => {
                    let wanted = (law == Law::Learnt).then(|| rig.response(j, omega).inv());
                    axis(config, wanted, omega, &mut at_bounds)
                }
            })
            .collect();
        Self {
            lead: config.compensation.lead_steps,
            led: vec![nothing(); axes.len()],
            axes,
            at_bounds,
        }
    }

    /// One control step: what is sent for the motion `ahead`, after `target` was in force and `measured` was read.
    pub fn step(
        &mut self,
        target: &[Signal],
        measured: &[Signal],
        ahead: &Ahead<'_>,
    ) -> Vec<Signal> {
        if self.lead == 0.0 {
            return self.send(target, measured, ahead);
        }
        let (lead, floors) = (self.lead, 0..ahead.displacement.len());
        let rise =
            |j: usize| &ahead.velocity[j] * lead + &ahead.acceleration[j] * (0.5 * lead * lead);
        let displacement: Vec<Signal> = floors
            .clone()
            .map(|j| &ahead.displacement[j] + rise(j))
            .collect();
        let velocity: Vec<Signal> = floors
            .map(|j| &ahead.velocity[j] + &ahead.acceleration[j] * lead)
            .collect();
        let mut led_target = target.to_vec();
        for (j, led) in self.led.iter_mut().enumerate() {
            led_target[j] += &*led;
            *led = rise(j);
        }
        let led_ahead = Ahead {
            displacement: &displacement,
            velocity: &velocity,
            acceleration: ahead.acceleration,
        };
        self.send(&led_target, measured, &led_ahead)
    }

    fn send(&mut self, target: &[Signal], measured: &[Signal], ahead: &Ahead<'_>) -> Vec<Signal> {
        let mut send = ahead.displacement.to_vec();
        for (j, axis) in self.axes.iter_mut().enumerate() {
            send[j] = axis.step(&target[j], &measured[j], ahead, j);
        }
        send
    }

    /// Sent command per target of the first axis at `omega` (rad per control period), in front of a rig that answers
    /// with `rig` there.
    pub fn response(&self, omega: f64, rig: Complex<f64>) -> Complex<f64> {
        let one = Complex::new(1.0, 0.0);
        self.axes.first().map_or(one, |a| a.response(omega, rig))
    }
}

impl Kind {
    fn step(&mut self, target: &Signal, measured: &Signal, ahead: &Ahead<'_>, j: usize) -> Signal {
        let (u, v, a) = (
            &ahead.displacement[j],
            &ahead.velocity[j],
            &ahead.acceleration[j],
        );
        match self {
            Self::None => u.clone(),
            Self::Sum {
                sum: k,
                last_acceleration,
                error,
            } => {
                let off = target - measured;
                let mut send = u * k.displacement
                    + v * k.velocity
                    + a * k.acceleration
                    + (u - target) * k.rise
                    + &off * k.error;
                // What is multiplied by 0 is no state of the loop.
                if k.jerk != 0.0 {
                    send += (a - &*last_acceleration) * k.jerk;
                    *last_acceleration = a.clone();
                }
                if k.feedback[0] != 0.0 {
                    *error += (off - &*error) * k.feedback[1];
                    send += &*error * k.feedback[0];
                }
                send
            }
            Self::Extrapolation { weights, past } => {
                let mut send = u * weights[0];
                for (weight, line) in weights[1..].iter().zip(past) {
                    send.axpy(*weight, &line.step(u.clone()), 1.0);
                }
                send
            }
            Self::Lead {
                weights: [new, last, memory],
                target,
                command,
            } => {
                *command = u * *new + &*target * *last + &*command * *memory;
                *target = u.clone();
                command.clone()
            }
            Self::Model {
                velocity,
                acceleration,
            } => {
                let mut send = u.clone();
                for i in 0..velocity.len() {
                    send.axpy(velocity[i], &ahead.velocity[i], 1.0);
                    send.axpy(acceleration[i], &ahead.acceleration[i], 1.0);
                }
                send
            }
        }
    }

    fn response(&self, omega: f64, rig: Complex<f64>) -> Complex<f64> {
        let z = Complex::from_polar(1.0, omega);
        let one = Complex::new(1.0, 0.0);
        let d = Complex::new(0.0, omega);
        match self {
            Self::None => one,
            Self::Sum { sum: k, .. } => {
                let ahead = k.displacement
                    + d * k.velocity
                    + d * d * k.acceleration
                    + d * d * (one - z.inv()) * k.jerk
                    + (one - z.inv()) * k.rise;
                let [share, takes] = k.feedback;
                let low_pass = takes * (one - z.inv() * (1.0 - takes)).inv();
                // The error is that of the sample before: one period old.
                let back = (k.error + low_pass * share) * z.inv();
                (ahead + back) * (one + back * rig).inv()
            }
            Self::Extrapolation { weights, past } => past
                .iter()
                .zip(&weights[1..])
                .fold(one * weights[0], |sum, (line, w)| {
                    sum + line.response(z) * *w
                }),
            Self::Lead {
                weights: [new, last, memory],
                ..
            } => (z.inv() * *last + *new) * (one - z.inv() * *memory).inv(),
            // Of the first axis alone: at the first frequency the others move with it.
            Self::Model {
                velocity,
                acceleration,
            } => one + d * velocity[0] + d * d * acceleration[0],
        }
    }
}

impl Block for Predictor {
    fn states<'a>(&'a mut self, all: &mut Vec<&'a mut Signal>) {
        if self.lead != 0.0 {
            all.extend(&mut self.led);
        }
        for axis in &mut self.axes {
            match axis {
                Kind::None | Kind::Model { .. } => {}
                Kind::Sum {
                    sum,
                    last_acceleration,
                    error,
                } => {
                    if sum.jerk != 0.0 {
                        all.push(last_acceleration);
                    }
                    if sum.feedback[0] != 0.0 {
                        all.push(error);
                    }
                }
                Kind::Extrapolation { past, .. } => {
                    for line in past {
                        line.states(all);
                    }
                }
                Kind::Lead {
                    target, command, ..
                } => all.extend([target, command]),
            }
        }
    }
}

/// One axis; what learns has learnt to answer with `wanted` at `omega`.
fn axis(config: &Config, wanted: Option<Complex<f64>>, omega: f64, reached: &mut bool) -> Kind {
    let c = &config.compensation;
    let rate_hz = config.timing.rate_hz;
    let told = c.delay_ms * 1e-3 * rate_hz;
    let most = c.adaptation.longest_delay_ms.max(c.delay_ms) * 1e-3 * rate_hz;
    let tolerance = c.adaptation.gain_tolerance;
    let mut within = |value: f64, low: f64, high: f64| bounded(value, low, high, reached);
    match (c.kind.predictor, wanted) {
        (Prediction::None | Prediction::ModelPrediction, _) => Kind::None,
        (Prediction::Darby, Some(wanted)) => {
            extrapolation(c, within(wanted.arg() / omega, 0.0, most))
        }
        (Prediction::Lagrange | Prediction::Darby, _) => extrapolation(c, told),
        (Prediction::PhaseLead, _) => lead(told),
        (Prediction::Mcs, wanted) => sum(Sum {
            displacement: 1.0,
            velocity: told,
            error: wanted.map_or(0.0, |_| 0.25 * SQUARES),
            ..Sum::default()
        }),
        (Prediction::FeedforwardFeedback, _) => sum(inverses::inverse_and_feedback(c, rate_hz)),
        (Prediction::Afp, wanted) => {
            let [gain, delay] = wanted.map_or([1.0, told], |wanted| {
                // gain (1 + i x - x^2/2) is what is wanted, x the delay in radians: its phase alone gives x.
                let ratio = wanted.re / wanted.im;
                let x = 2.0 / ((ratio * ratio + 2.0).sqrt() + ratio);
                let x = if x.is_finite() { x } else { 0.0 };
                let gain = wanted.norm() / (1.0 + 0.25 * x.powi(4)).sqrt();
                [
                    within(gain, 1.0 - tolerance, 1.0 + tolerance),
                    within(x / omega, 0.0, most),
                ]
            });
            sum(Sum {
                displacement: gain,
                velocity: gain * delay,
                acceleration: 0.5 * gain * delay * delay,
                ..Sum::default()
            })
        }
        (Prediction::AdaptiveInverse, Some(wanted)) => {
            // Phase of 1 + d (1 - 1/z).
            let (sin, cos) = omega.sin_cos();
            let tan = wanted.arg().tan();
            rise(within(tan / (sin - tan * (1.0 - cos)), 0.0, most))
        }
        (Prediction::Inverse | Prediction::AdaptiveInverse, _) => rise(told),
        (Prediction::Amb, wanted) => sum(inverses::model_based(c, rate_hz, wanted, omega)),
        (Prediction::Hydraulic, wanted) => {
            let stiffness = config.structure.stiffness_n_per_m[0];
            let guessed = || Hydraulic::of_delay(c.delay_ms * 1e-3, stiffness);
            let plant = c.hydraulic.clone().unwrap_or_else(guessed);
            sum(inverses::hydraulic(&plant, rate_hz, wanted, omega))
        }
        (Prediction::Ats, wanted) => {
            let [first, second, _] = c.inverse();
            let start = [
                1.0,
                omega * first * rate_hz,
                second * (omega * rate_hz).powi(2),
            ];
            let [displacement, velocity, acceleration] = wanted.map_or(start, |wanted| {
                let left = wanted.re - (start[0] - start[2]);
                let far = omega * most;
                [
                    within(start[0] + 0.5 * left, 1.0 - tolerance, 1.0 + tolerance),
                    within(wanted.im, 0.0, far),
                    within(start[2] - 0.5 * left, 0.0, 0.5 * far * far),
                ]
            });
            sum(Sum {
                displacement,
                velocity: velocity / omega,
                acceleration: acceleration / (omega * omega),
                ..Sum::default()
            })
        }
    }
}

/// Mean over a cycle of the squares of demand and displacement together, relative to that of their running peak: 1 for a
/// peak that stays, this for one that fades by a factor e in a natural period, as that of the gate does.
const SQUARES: f64 = 1.245;

fn sum(sum: Sum) -> Kind {
    Kind::Sum {
        sum,
        last_acceleration: nothing(),
        error: nothing(),
    }
}

fn rise(delay: f64) -> Kind {
    sum(Sum {
        displacement: 1.0,
        rise: delay,
        ..Sum::default()
    })
}

fn extrapolation(c: &Compensation, delay: f64) -> Kind {
    let weights = match c.order {
        1 => [2.0, -1.0, 0.0, 0.0],
        2 => [3.0, -3.0, 1.0, 0.0],
        _ => [4.0, -6.0, 4.0, -1.0],
    };
    let order = usize::from(c.order.min(3));
    Kind::Extrapolation {
        weights,
        past: (1..=order).map(|k| Delay::new(delay * k as f64)).collect(),
    }
}

/// T_2 over the delay of the phase lead.
const LAG_SHARE: f64 = 0.1;

fn lead(steps: f64) -> Kind {
    // The trapezoidal rule on (1 + T_1 s) / (1 + T_2 s).
    let (lead, lag) = (2.0 * steps * (1.0 + LAG_SHARE), 2.0 * steps * LAG_SHARE);
    Kind::Lead {
        weights: [1.0 + lead, 1.0 - lead, lag - 1.0].map(|x| x / (1.0 + lag)),
        target: nothing(),
        command: nothing(),
    }
}

/// `u + A v + B a` with what `M a' + C a + K v = 0` makes of v and a within the delay.
fn model(config: &Config, frame: &Frame, j: usize) -> Kind {
    let n = frame.mass.nrows();
    let scale = config.timing.time_scale;
    let delay_s = config.compensation.delay_ms * 1e-3 / scale;
    let step_s = 1.0 / (config.timing.rate_hz * scale);
    let solve = |m: &DMatrix<f64>| {
        let lu = frame.mass.clone().lu();
        lu.solve(m).unwrap_or_else(|| DMatrix::zeros(n, n))
    };
    let mut motion = DMatrix::zeros(3 * n, 3 * n);
    motion.view_mut((0, n), (n, n)).fill_with_identity();
    motion.view_mut((n, 2 * n), (n, n)).fill_with_identity();
    motion
        .view_mut((2 * n, n), (n, n))
        .copy_from(&-solve(&frame.stiffness));
    motion
        .view_mut((2 * n, 2 * n), (n, n))
        .copy_from(&-solve(&frame.damping));
    let after = (motion * delay_s).exp();
    let row = |from: usize, per: f64| (0..n).map(|i| after[(j, from + i)] / per).collect();
    Kind::Model {
        velocity: row(n, step_s),
        acceleration: row(2 * n, step_s * step_s),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn the_mean_squares_over_a_peak_that_fades() {
        let n = 10_000;
        let (mut peak, mut sum) = (1.0_f64, 0.0);
        // The second cycle counts; in the first the peak comes to its own.
        for i in 0..2 * n {
            let u = (TAU * i as f64 / n as f64).sin();
            peak = u.abs().max(peak * (-1.0 / n as f64).exp());
            if i >= n {
                sum += 2.0 * (u / peak).powi(2) / n as f64;
            }
        }
        assert!((sum / SQUARES - 1.0).abs() < 1e-3, "{sum}");
    }
}
