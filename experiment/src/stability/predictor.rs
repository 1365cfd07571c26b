//! Core's predictors in the closed loop, by the linear form that each has in its own file ([`outerloop_core::linear`]).

use super::blocks::{Block, Delay, StateRow, nothing};
use super::rig::LinearRig;
use super::structure_matrices::StructureMatrices;
use nalgebra::{Complex, DMatrix};
use outerloop_core::Config;
use outerloop_core::linear::{FrequencyResponse, Linear, Setting, Sum};

/// What adaptive predictors know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knowledge {
    /// What was declared to them.
    Declared,
    /// What they come to on the rig.
    Learnt,
}

#[derive(Clone, Debug)]
enum Kind {
    Sum {
        sum: Sum,
        last_acceleration: StateRow,
        error: StateRow,
    },
    /// Weights of the target now, and one, two and three delays ago.
    Extrapolation { weights: [f64; 4], past: Vec<Delay> },
    /// `new x + last x_1 + memory y_1`.
    Lead {
        weights: [f64; 3],
        target: StateRow,
        command: StateRow,
    },
    /// Row of this axis on velocities and accelerations of all.
    Model {
        velocity: Vec<f64>,
        acceleration: Vec<f64>,
    },
}

/// The predictors of all axes in the laboratory.
#[derive(Clone, Debug)]
pub struct LinearPredictor {
    axes: Vec<Kind>,
    /// Control steps by which the target is led.
    lead: f64,
    /// By how much the last target of each axis was led.
    led: Vec<StateRow>,
    /// Some axis would have to learn more than the bounds of its law allow.
    pub at_bounds: bool,
}

/// The motion of all floors ahead, in control steps.
#[derive(Clone, Copy, Debug)]
pub struct Ahead<'a> {
    /// Next targets.
    pub displacement: &'a [StateRow],
    /// Their velocities.
    pub velocity: &'a [StateRow],
    /// Their accelerations.
    pub acceleration: &'a [StateRow],
}

impl LinearPredictor {
    /// As configured, on `rig`; what learns has learnt at `at` rad/s of model time.
    pub fn new(
        config: &Config,
        frame: &StructureMatrices,
        rig: &LinearRig,
        law: Knowledge,
        at: f64,
    ) -> Self {
        let omega = at / (config.timing.time_scale * config.timing.rate_hz);
        let mut at_bounds = false;
        let axes: Vec<Kind> = (0..config.physical_storeys())
            .map(|j| {
                let mut setting = match law {
                    Knowledge::Declared => Setting::declared(config, j),
                    Knowledge::Learnt => {
                        let wanted = rig.response(j, omega).inv();
                        let (real, imaginary) = (wanted.re, wanted.im);
                        let wanted = FrequencyResponse { real, imaginary };
                        Setting::learnt(config, j, wanted, omega)
                    }
                };
                let linear = config.compensation.kind.predictor.linear(&mut setting);
                at_bounds |= setting.at_bounds();
                Kind::new(&linear, config, frame, j)
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
        target: &[StateRow],
        measured: &[StateRow],
        ahead: &Ahead<'_>,
    ) -> Vec<StateRow> {
        if self.lead == 0.0 {
            return self.send(target, measured, ahead);
        }
        let (lead, floors) = (self.lead, 0..ahead.displacement.len());
        let rise =
            |j: usize| &ahead.velocity[j] * lead + &ahead.acceleration[j] * (0.5 * lead * lead);
        let displacement: Vec<StateRow> = floors
            .clone()
            .map(|j| &ahead.displacement[j] + rise(j))
            .collect();
        let velocity: Vec<StateRow> = floors
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

    fn send(
        &mut self,
        target: &[StateRow],
        measured: &[StateRow],
        ahead: &Ahead<'_>,
    ) -> Vec<StateRow> {
        let mut send = ahead.displacement.to_vec();
        for (j, axis) in self.axes.iter_mut().enumerate() {
            send[j] = axis.step(&target[j], &measured[j], ahead, j);
        }
        send
    }

    /// Sent command per target of an axis at `omega` (rad per control period), in front of a rig that answers
    /// with `rig` there.
    pub fn response(&self, axis: usize, omega: f64, rig: Complex<f64>) -> Complex<f64> {
        let one = Complex::new(1.0, 0.0);
        self.axes
            .get(axis)
            .map_or(one, |a| a.response(axis, omega, rig))
    }
}

impl Kind {
    /// The linear form of axis `j`.
    fn new(linear: &Linear, config: &Config, frame: &StructureMatrices, j: usize) -> Self {
        match *linear {
            Linear::Sum(sum) => Self::Sum {
                sum,
                last_acceleration: nothing(),
                error: nothing(),
            },
            Linear::Extrapolation { weights, delay } => Self::Extrapolation {
                weights,
                past: (1..=3)
                    .filter(|&k| weights[k] != 0.0)
                    .map(|k| Delay::new(delay * k as f64))
                    .collect(),
            },
            Linear::Lead { weights } => Self::Lead {
                weights,
                target: nothing(),
                command: nothing(),
            },
            Linear::FreeVibration { delay_s } => free_vibration(config, frame, delay_s, j),
        }
    }

    fn step(
        &mut self,
        target: &StateRow,
        measured: &StateRow,
        ahead: &Ahead<'_>,
        j: usize,
    ) -> StateRow {
        let (u, v, a) = (
            &ahead.displacement[j],
            &ahead.velocity[j],
            &ahead.acceleration[j],
        );
        match self {
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

    fn response(&self, axis: usize, omega: f64, rig: Complex<f64>) -> Complex<f64> {
        let z = Complex::from_polar(1.0, omega);
        let one = Complex::new(1.0, 0.0);
        let d = Complex::new(0.0, omega);
        match self {
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
            // Of the axis alone: at the first frequency the others move with it.
            Self::Model {
                velocity,
                acceleration,
            } => one + d * velocity[axis] + d * d * acceleration[axis],
        }
    }
}

impl Block for LinearPredictor {
    fn states<'a>(&'a mut self, all: &mut Vec<&'a mut StateRow>) {
        if self.lead != 0.0 {
            all.extend(&mut self.led);
        }
        for axis in &mut self.axes {
            match axis {
                Kind::Model { .. } => {}
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

/// `u + A v + B a` with what `M a' + C a + K v = 0` makes of v and a within `delay_s` of model time.
fn free_vibration(config: &Config, frame: &StructureMatrices, delay_s: f64, j: usize) -> Kind {
    let n = frame.mass.nrows();
    let step_s = 1.0 / (config.timing.rate_hz * config.timing.time_scale);
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
