//! The complete tracking of a pair of coupled actuators, one call per sample.

use super::coupler::Coupler;
use super::estimate::{EstimatorSettings, PlantEstimator};
use super::inverse::{Jet, PlantInverse};
use super::observer::{Observer, ObserverConstants, SteadyObserver};
use super::pair::Pair;
use super::plant::Plant;
use crate::refusal::{Refusal, accept};

/// Settings of the tracker.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TrackerSettings {
    /// Geometry between the structure's coordinates and the strokes.
    pub coupler: Coupler,
    /// The plant and what of it is to be estimated.
    pub estimate: EstimatorSettings,
    /// True if commands are those of the inverse. Where not, the strokes of the target itself are sent: for actuators that
    /// follow by themselves, and to see what the inverse is worth.
    pub inverse: bool,
    /// How the target moves, x and theta.
    pub target: [SteadyObserver; 2],
    /// The target is given so many seconds ahead of its time, 0 to 0.1; it is held back by them.
    pub ahead_s: f32,
    /// Below this frequency, Hz, the estimated strokes follow the readings, above it the model.
    pub trust_reading_hz: f32,
}

/// Constants of a tracker, computed once.
#[derive(Clone, Debug)]
pub struct TrackerConstants {
    settings: TrackerSettings,
    observers: [ObserverConstants; 2],
    /// Fraction of the difference between reading and model that is corrected per sample.
    follow: f32,
}

impl TrackerConstants {
    /// Checks `settings` and computes the gains.
    ///
    /// # Errors
    /// The first setting that cannot be used.
    pub fn new(settings: &TrackerSettings) -> Result<Self, Refusal> {
        settings.estimate.check()?;
        let pins_m = settings.coupler.pin_y_m;
        let arm = f64::from(pins_m[1] - pins_m[0]);
        let is_regular = settings.coupler.is_regular();
        accept("coupler.pin_y_m", arm, is_regular, "pins that are apart")?;
        let trusted = f64::from(settings.trust_reading_hz);
        let fine = trusted > 0.0 && trusted.is_finite();
        accept(
            "coupled.trust_reading_hz",
            trusted,
            fine,
            "a number above 0",
        )?;
        let ahead = (0.0..=0.1).contains(&settings.ahead_s);
        let ahead_s = f64::from(settings.ahead_s);
        accept("coupled.ahead_s", ahead_s, ahead, "0 to 0.1 s")?;
        let period_s = settings.estimate.period_s;
        let observers = [
            ObserverConstants::new(&settings.target[0], f64::from(period_s))?,
            ObserverConstants::new(&settings.target[1], f64::from(period_s))?,
        ];
        let turn = core::f32::consts::TAU * settings.trust_reading_hz * period_s;
        Ok(Self {
            settings: settings.clone(),
            observers,
            follow: 1.0 - libm::expf(-turn),
        })
    }
}

/// The tracker of a pair of coupled actuators.
#[derive(Clone, Debug)]
pub struct Tracker {
    constants: TrackerConstants,
    observers: [Observer; 2],
    estimator: PlantEstimator,
    inverse: PlantInverse,
    correction_m: Pair,
}

impl Tracker {
    /// At rest at zero.
    pub fn at_rest(constants: TrackerConstants) -> Self {
        Self {
            observers: [Observer::at_rest(), Observer::at_rest()],
            estimator: PlantEstimator::at_rest(&constants.settings.estimate),
            inverse: PlantInverse::at_rest(),
            correction_m: [0.0; 2],
            constants,
        }
    }

    /// Back to rest at zero, with the plant as declared, in place.
    pub(super) fn restart(&mut self) {
        self.observers = [Observer::at_rest(), Observer::at_rest()];
        self.estimator = PlantEstimator::at_rest(&self.constants.settings.estimate);
        self.inverse = PlantInverse::at_rest();
        self.correction_m = [0.0; 2];
    }

    /// Geometry between the structure's coordinates and the strokes.
    pub(super) fn coupler(&self) -> &Coupler {
        &self.constants.settings.coupler
    }

    /// The plant as presently known.
    pub fn plant(&self) -> &Plant {
        self.estimator.plant()
    }

    /// Takes the command sent since the last sample and the measured strokes, before the target of the same sample.
    /// Returns estimated strokes and position of the interface. The plant is identified (`learns`) only while the
    /// actuators are known to follow and to move: with shut valves, or at rest with an offset, every gain looks wrong.
    pub fn observe(&mut self, sent_m: &Pair, measured_m: &Pair, learns: bool) -> (Pair, Pair) {
        let k = &self.constants;
        let settings = &k.settings.estimate;
        let modelled_m = self.estimator.update(settings, sent_m, measured_m, learns);
        let stroke_m = core::array::from_fn(|i| {
            let error_m = measured_m[i] - modelled_m[i];
            if error_m.is_finite() {
                self.correction_m[i] += k.follow * (error_m - self.correction_m[i]);
            }
            modelled_m[i] + self.correction_m[i]
        });
        (stroke_m, k.settings.coupler.interface(&stroke_m))
    }

    /// Commands, m, that bring the interface to `target` (x in m, theta in rad) of a structure with this ground motion.
    pub fn command(&mut self, target: &Pair, ground_m_per_s2: f32) -> Pair {
        self.command_driven(target, ground_m_per_s2, 1.0)
    }

    /// The same if the structure moves the target only to the fraction `driven`, see [`Observer::update`].
    pub(super) fn command_driven(
        &mut self,
        target: &Pair,
        ground_m_per_s2: f32,
        driven: f32,
    ) -> Pair {
        if !self.constants.settings.inverse {
            let [x, theta] = *target;
            return self.constants.settings.coupler.strokes_m(x, theta);
        }
        let k = &self.constants;
        let [x, theta] = core::array::from_fn(|i| {
            self.observers[i].update(&k.observers[i], target[i], ground_m_per_s2, driven)
        });
        let ahead_s = k.settings.ahead_s;
        let (x, theta) = (held_back(x, ahead_s), held_back(theta, ahead_s));
        let coupler = &k.settings.coupler;
        let exact = coupler.strokes_m(x[0], theta[0]);
        let rates: [Pair; 4] = core::array::from_fn(|n| coupler.linear_m(x[n], theta[n]));
        let strokes: [Jet<4>; 2] =
            core::array::from_fn(|i| [exact[i], rates[1][i], rates[2][i], rates[3][i]]);
        let period_s = k.settings.estimate.period_s;
        self.inverse
            .commands(self.estimator.plant(), period_s, &strokes)
    }
}

/// The target and its derivatives `by_s` earlier, by Taylor expansion.
#[inline]
fn held_back([x, v, a, j]: Jet<4>, by_s: f32) -> Jet<4> {
    [
        x - by_s * (v - by_s * (0.5 * a - by_s * j * (1.0 / 6.0))),
        v - by_s * (a - 0.5 * by_s * j),
        a - by_s * j,
        j,
    ]
}

#[cfg(test)]
mod tests {
    use super::super::forward::Forward;
    use super::super::observer::{ObserverSettings, VibrationMode};
    use super::super::plant::{MAX_PARAMETERS, Spreads, tests::FRAME};
    use super::*;

    const PERIOD_S: f32 = 1.0 / 1024.0;

    fn tracker() -> Tracker {
        let observer = |hz: f64, participation| {
            let mode = VibrationMode {
                omega_rad_per_s: core::f64::consts::TAU * hz,
                damping_ratio: 0.04,
                participation,
            };
            let of_one = ObserverSettings {
                modes: [mode].into_iter().collect(),
                noise: 8e-7,
                process_per_s2: 0.2,
            };
            of_one.steady(f64::from(PERIOD_S)).unwrap()
        };
        let settings = TrackerSettings {
            coupler: Coupler {
                pin_x_m: [0.267; 2],
                pin_y_m: [-0.127, 0.127],
            },
            estimate: EstimatorSettings {
                plant: FRAME,
                spreads: Spreads::new(),
                noise_m: 2e-5,
                period_s: PERIOD_S,
            },
            inverse: true,
            target: [observer(2.2, -1.0), observer(9.0, 0.0)],
            ahead_s: PERIOD_S,
            trust_reading_hz: 5.0,
        };
        Tracker::at_rest(TrackerConstants::new(&settings).unwrap())
    }

    /// Error of the interface at 20 mm and 20 mrad, after a two-second ramp and a second at rest.
    fn off(driven: f32) -> Pair {
        let (mut tracker, mut rig) = (tracker(), Forward::at_rest());
        let (mut sent_m, mut slopes) = ([0.0; 2], [[0.0; MAX_PARAMETERS]; 2]);
        let mut at = [0.0; 2];
        for step in 0..3 * 1024 {
            let strokes_m = rig.step(&FRAME, &Spreads::new(), PERIOD_S, &sent_m, &mut slopes);
            at = tracker.observe(&sent_m, &strokes_m, true).1;
            let target = 0.02 * (step as f32 / 2048.0).min(1.0);
            sent_m = tracker.command_driven(&[target; 2], 0.0, driven);
        }
        at.map(|at| at - 0.02)
    }

    #[test]
    fn a_target_from_outside_is_where_the_interface_comes_to_stand() {
        let [free, modal] = [off(0.0), off(1.0)];
        for i in 0..2 {
            assert!(free[i].abs() < 1e-7, "{free:?}");
            assert!(modal[i].abs() > 1e-3, "the modes pull: {modal:?}");
        }
    }
}
