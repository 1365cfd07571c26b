//! RoDeAC: for each actuator a four-tap inverse by recursive least squares.
//!
//! Quiroz, Galmez and Fermandois, "Robust decentralized adaptive compensation for the multi-axial real-time hybrid
//! simulation benchmark", Frontiers in Built Environment 10 (2024). The command is `theta . (r_k, r_k-1, r_k-2, r_k-3)`;
//! `theta` is fitted with the measured strokes in place of the targets, both sides filtered by a fourth-order Butterworth
//! low-pass of 20 Hz, without forgetting.
//!
//! The published start of the covariance was calibrated in metres. With strokes in millimetres in the loop we get the figures
//! of others (J2 3.4 and 1.8 %); in metres the least squares hardly move from their start (J2 27 and 7 %).

use super::RATE_HZ;
use super::controller::{PairController, TargetSample};
use crate::Refused;
use nalgebra::{Matrix4, Vector4};

/// The published start values for one actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    theta: Vector4<f64>,
    covariance: Matrix4<f64>,
}

/// Reads the published table: lines `theta0_1,x` and `P0_1,x,x,x,x`, four of each for each actuator.
///
/// # Errors
/// A line that is missing or is not a number.
pub fn parse(csv: &str) -> Result<[Start; 2], Refused> {
    let rows = |key: String, width: usize| -> Result<Vec<f64>, Refused> {
        let all: Vec<f64> = csv
            .lines()
            .filter_map(|l| l.split_once(','))
            .filter(|(name, _)| name.trim() == key)
            .flat_map(|(_, rest)| rest.split(','))
            .filter_map(|x| x.trim().parse().ok())
            .collect();
        if all.len() == 4 * width {
            return Ok(all);
        }
        Err(Refused::new(format!(
            "the start values of the least squares have {} numbers under {key}: accepted are {}",
            all.len(),
            4 * width
        )))
    };
    let start = |i: usize| {
        Ok(Start {
            theta: Vector4::from_column_slice(&rows(format!("theta0_{i}"), 1)?),
            covariance: Matrix4::from_row_slice(&rows(format!("P0_{i}"), 4)?),
        })
    };
    Ok([start(1)?, start(2)?])
}

/// A fourth-order Butterworth low-pass: two sections by the bilinear transform.
#[derive(Clone, Copy, Debug)]
struct Butterworth {
    sections: [Biquad; 2],
}

#[derive(Clone, Copy, Debug)]
struct Biquad {
    b: f64,
    a: [f64; 2],
    input: [f64; 2],
    output: [f64; 2],
}

impl Biquad {
    fn step(&mut self, x: f64) -> f64 {
        let y = self.b * (x + 2.0 * self.input[0] + self.input[1])
            - self.a[0] * self.output[0]
            - self.a[1] * self.output[1];
        self.input = [x, self.input[0]];
        self.output = [y, self.output[0]];
        y
    }
}

impl Butterworth {
    fn new(corner_hz: f64) -> Self {
        let w = (std::f64::consts::PI * corner_hz / RATE_HZ).tan();
        let section = |angle: f64| {
            let twice = 2.0 * angle.cos();
            let a0 = 1.0 + twice * w + w * w;
            Biquad {
                b: w * w / a0,
                a: [2.0 * (w * w - 1.0) / a0, (1.0 - twice * w + w * w) / a0],
                input: [0.0; 2],
                output: [0.0; 2],
            }
        };
        let eighth = std::f64::consts::PI / 8.0;
        Self {
            sections: [section(eighth), section(3.0 * eighth)],
        }
    }

    fn step(&mut self, x: f64) -> f64 {
        self.sections.iter_mut().fold(x, |x, s| s.step(x))
    }
}

/// One actuator.
#[derive(Clone, Debug)]
struct Axis {
    theta: Vector4<f64>,
    covariance: Matrix4<f64>,
    targets: Vector4<f64>,
    measured: Vector4<f64>,
    read: Butterworth,
    sent: Butterworth,
}

impl Axis {
    /// The command for a target, both in mm.
    fn command(&mut self, target_mm: f64, adapts: bool) -> f64 {
        self.targets = shifted(&self.targets, target_mm);
        let command = self.theta.dot(&self.targets);
        let sent = self.sent.step(command);
        if adapts {
            let phi = &self.measured;
            let seen = self.covariance * phi;
            let gain = seen / (1.0 + phi.dot(&seen));
            self.theta += gain * (sent - self.theta.dot(phi));
            self.covariance -= gain * seen.transpose();
        }
        command
    }
}

fn shifted(past: &Vector4<f64>, new: f64) -> Vector4<f64> {
    Vector4::new(new, past[0], past[1], past[2])
}

/// Both actuators, independently of each other.
#[derive(Clone, Debug)]
pub struct FourTaps {
    axes: [Axis; 2],
    adapts: bool,
}

impl FourTaps {
    /// Taps at rest. With `adapts` the least squares run, otherwise the start values stay.
    pub fn new(start: &[Start; 2], adapts: bool) -> Self {
        Self {
            axes: start.map(|s| Axis {
                theta: s.theta,
                covariance: s.covariance,
                targets: Vector4::zeros(),
                measured: Vector4::zeros(),
                read: Butterworth::new(20.0),
                sent: Butterworth::new(20.0),
            }),
            adapts,
        }
    }
}

impl PairController for FourTaps {
    fn observe(&mut self, read_m: [f64; 2]) -> [f64; 2] {
        for (axis, read) in self.axes.iter_mut().zip(read_m) {
            let smooth = axis.read.step(1e3 * read);
            axis.measured = shifted(&axis.measured, smooth);
        }
        read_m
    }

    fn command(&mut self, target: &TargetSample) -> [f64; 2] {
        let adapts = self.adapts;
        let [a, b] = &mut self.axes;
        [
            1e-3 * a.command(1e3 * target.stroke_m[0], adapts),
            1e-3 * b.command(1e3 * target.stroke_m[1], adapts),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_low_pass_halves_the_power_at_its_corner() {
        let mut filter = Butterworth::new(20.0);
        let w = std::f64::consts::TAU * 20.0 / RATE_HZ;
        let (mut re, mut im) = (0.0, 0.0);
        for k in 0..8192 {
            let phase = w * f64::from(k);
            let y = filter.step(phase.sin());
            if k >= 4096 {
                re += y * phase.sin() / 2048.0;
                im += y * phase.cos() / 2048.0;
            }
        }
        assert!((re.hypot(im) - 0.5_f64.sqrt()).abs() < 1e-4);
    }

    #[test]
    fn a_table_without_a_row_is_refused_by_its_name() {
        let error = parse("theta0_1,1.0\n").unwrap_err().to_string();
        assert!(error.contains("1 numbers under theta0_1"), "{error}");
    }
}
