//! An actuator for checking predictors: a pure delay and a gain, outside any loop.

use super::adaptation::Learning;
use super::interface::{LastCommand, PredictAxis, TargetMotion};
use crate::config::Config;
use crate::design::Design;
use crate::method::{Method, Prediction};

/// Angular frequency of the motion, 1 per control step: 2 Hz at 2 kHz.
pub(crate) const OMEGA: f32 = 0.006_283;

/// Nothing has been followed.
pub(crate) const AT_REST: LastCommand = LastCommand {
    target_m: 0.0,
    sent_m: 0.0,
    measured_m: 0.0,
    learn: false,
};

/// The actuator.
#[derive(Clone, Copy)]
pub(crate) struct Axis {
    /// Control steps, at most 31.
    pub delay: usize,
    /// Displacement per command.
    pub gain: f32,
}

/// As the defaults of a test at 2 kHz.
pub(crate) fn learning() -> Learning {
    Learning {
        floor_m: 1e-3,
        memory: 0.999,
        rate: 0.005,
        longest: 40.0,
        limit: 0.1,
        gain_tolerance: 0.2,
        gain_limit: 1e-3,
    }
}

/// Twenty seconds of a swelling sine of two frequencies; the largest tracking error of the last five, relative.
pub(crate) fn tracking_error<P: PredictAxis>(k: &P::Constants, actuator: Axis) -> f32 {
    run::<P>(k, actuator).1
}

/// The same, with the final predictor.
pub(crate) fn run<P: PredictAxis>(k: &P::Constants, actuator: Axis) -> (P, f32) {
    let mut axis = P::at_rest(k);
    let mut line = [0.0_f32; 32];
    let (mut followed, mut worst, mut peak) = (AT_REST, 0.0_f32, 0.0_f32);
    for i in 0..40_000_usize {
        // Two frequencies: with one, gain and delay could be traded for each other.
        let grown = (i as f32 / 4000.0).min(1.0) * 0.02;
        let motion = |omega: f32| {
            let phase = f64::from(omega) * i as f64;
            let (sin, cos) = (libm::sin(phase) as f32, libm::cos(phase) as f32);
            [
                grown * sin,
                grown * omega * cos,
                -grown * omega * omega * sin,
            ]
        };
        let (slow, fast) = (motion(OMEGA), motion(2.3 * OMEGA).map(|x| 0.3 * x));
        let ahead = TargetMotion {
            displacement_m: slow[0] + fast[0],
            velocity_m: slow[1] + fast[1],
            acceleration_m: slow[2] + fast[2],
        };
        let sent_m = axis.command(k, &followed, &ahead);
        line[i % 32] = sent_m;
        let measured_m = actuator.gain * line[(i + 32 - actuator.delay) % 32];
        followed = LastCommand {
            target_m: ahead.displacement_m,
            sent_m,
            measured_m,
            learn: true,
        };
        if i > 30_000 {
            worst = worst.max((followed.target_m - measured_m).abs());
            peak = peak.max(followed.target_m.abs());
        }
    }
    (axis, worst / peak)
}

#[test]
fn every_predictor_that_learns_goes_back_to_what_was_declared_when_it_has_to() {
    for &prediction in Prediction::ALL {
        if !prediction.learns() {
            continue;
        }
        let mut config = Config::shear_frame([4000.0], [632e3], [0.02]);
        config.compensation.kind = Method::None.behind(prediction);
        config.compensation.delay_ms = 2.0.into();
        config.compensation.amb.gains = [1e8, 1e6, 1e3, 0.0];
        let mut taught = Design::<1>::new(&config).unwrap().predictor;
        let mut fresh = taught.clone();
        let mut line = [0.0_f32; 32];
        let mut apart = [0.0_f32; 2];
        let mut followed = AT_REST;
        for i in 0..80_000_usize {
            let (sin, cos) = libm::sincosf(OMEGA * i as f32);
            let ahead = [TargetMotion {
                displacement_m: 0.02 * sin,
                velocity_m: 0.02 * OMEGA * cos,
                acceleration_m: -0.02 * OMEGA * OMEGA * sin,
            }];
            let learn = i < 40_000;
            if !learn {
                taught.unlearn(0);
            }
            let mut commands = [[ahead[0].displacement_m]; 2];
            taught.command(
                &[LastCommand { learn, ..followed }],
                &ahead,
                1,
                &mut commands[0],
            );
            let plain = LastCommand {
                learn: false,
                ..followed
            };
            fresh.command(&[plain], &ahead, 1, &mut commands[1]);
            let [[sent_m], [declared_m]] = commands;
            let end = usize::from(!learn);
            if i % 40_000 > 38_000 {
                apart[end] = apart[end].max((sent_m - declared_m).abs() / 0.02);
            }
            line[i % 32] = sent_m;
            followed = LastCommand {
                target_m: ahead[0].displacement_m,
                sent_m,
                measured_m: 0.95 * line[(i + 32 - 10) % 32],
                learn,
            };
        }
        let [learnt, left] = apart;
        assert!(learnt > 0.005, "{prediction:?} learnt {learnt}");
        assert!(left < 1e-4, "{prediction:?} keeps {left} of {learnt}");
    }
}
