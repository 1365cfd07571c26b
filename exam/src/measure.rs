//! From the true signals to the codes of the converters.

use crate::draws::Draws;
use crate::effect::{Acts, Channel, Physics};
use crate::fine::{FINE_HZ, rms};
use crate::noise::{coloured, convert};
use crate::record::Record;
use crate::rig::Truth;

/// Sensors and converters. The first of two numbers is the displacement's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Readings {
    pub(crate) rate_hz: f64,
    /// One side of the range, mm and N.
    pub(crate) full_scale: [f64; 2],
    /// Rms of the noise, mm and N.
    pub(crate) sigma: [f64; 2],
    pub(crate) bits: [u32; 2],
}

/// An effect with its strength.
#[derive(Debug)]
pub(crate) struct Placed {
    pub(crate) physics: Physics,
    pub(crate) strength: f64,
    /// Its size, in units of the channel's floor.
    pub(crate) size: f64,
}

/// The record of a command, and the rms that a perfect model would leave of it, mm and N.
pub(crate) fn measure(
    truth: &Truth,
    placed: &[Placed],
    command: &[f64],
    samples: usize,
    readings: &Readings,
    rng: &mut Draws,
) -> (Record, [f64; 2]) {
    let every = (FINE_HZ / readings.rate_hz) as usize;
    let (drive, mut x) = truth.displacement(command);
    let of = |channel, acts| {
        placed
            .iter()
            .filter(move |p| p.physics.channel == channel && p.physics.acts == acts)
    };
    for p in of(Channel::Actuator, Acts::Motion) {
        x = (p.physics.apply)(p.strength, &drive, &x);
    }
    let (motion, mut force) = truth.force(&x);
    for p in of(Channel::Specimen, Acts::Motion) {
        force = (p.physics.apply)(p.strength, &motion, &force);
    }
    let mut read = |channel: Channel, signal: Vec<f64>| {
        let i = channel as usize;
        let scene = [&drive, &motion][i];
        let mut signal = signal;
        for p in of(channel, Acts::Signal) {
            signal = (p.physics.apply)(p.strength, scene, &signal);
        }
        let exact: Vec<f64> = signal.into_iter().step_by(every).take(samples).collect();
        let noise = coloured(samples, readings.sigma[i], readings.rate_hz, rng);
        let mut reading: Vec<f64> = exact.iter().zip(noise).map(|(y, n)| y + n).collect();
        for p in of(channel, Acts::Reading) {
            reading = (p.physics.apply)(p.strength, scene, &reading);
        }
        for y in &mut reading {
            *y = convert(*y, readings.full_scale[i], readings.bits[i]);
        }
        let error: Vec<f64> = reading.iter().zip(&exact).map(|(y, e)| y - e).collect();
        (reading, error)
    };
    let (displacement_mm, x_error) = read(Channel::Actuator, x);
    let (force_n, f_error) = read(Channel::Specimen, force);
    // The specimen's model uses the measured displacement.
    let k = truth.stiffness_n_per_mm;
    let through: Vec<f64> = f_error
        .iter()
        .zip(&x_error)
        .map(|(f, x)| f - k * x)
        .collect();
    let record = Record {
        rate_hz: readings.rate_hz,
        time_s: (0..samples).map(|i| i as f64 / readings.rate_hz).collect(),
        command_mm: command
            .iter()
            .copied()
            .step_by(every)
            .take(samples)
            .collect(),
        displacement_mm,
        force_n,
    };
    (record, [rms(&x_error), rms(&through)])
}
