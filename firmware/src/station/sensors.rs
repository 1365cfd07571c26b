//! Contradictory sensors: two transducers of one displacement, and a constant force while the specimen moves.

use crate::hardware::Hardware;
use link::command::BoardTest;
use link::telemetry::MAX_INPUTS;
use link::{Input, MAX_ACTUATORS};
use outerloop_core::Fault;
use outerloop_core::coupled::CoupledSettings;

/// Tolerated faulty steps, each sound step taking one off: a spike on a wire is no fault.
const TIMEOUT_STEPS: u8 = 4;

/// A force within this fraction of declared stiffness times motion is none: a dead cell's amplifier may produce it.
const NO_FORCE_SHARE: f64 = 0.02;

/// Standard deviations of the declared noise by which a dead load cell may exceed that, up to a fraction of the same
/// force: a yielded specimen has a force for most of its motion.
const DEVIATIONS: f64 = 6.0;
const NOISE_SHARE: f64 = 1.0 / 32.0;

/// With noise above this fraction of the same force, a sound specimen's force passes zero at places far apart.
const LOUD_SHARE: f64 = 0.25;

/// A test starts at rest: a force at its start is too large if, by the declared stiffness, it would move the structure
/// by more than this fraction of the allowed motion, and so make it swing as far again.
const START_SHARE: f64 = 0.5;

/// The mean force is taken over some steps: noise and hum are no force at the start.
const MEAN_SHARE: f32 = 1.0 / 64.0;

/// Fraction of noise left in such a mean: the square root of `MEAN_SHARE / (2 - MEAN_SHARE)`.
const MEAN_OF_NOISE: f64 = 0.0887;

/// A force whose codes stay within this part of its converter's range is constant but for the converter's noise: two
/// codes either way at 16 bits; at 12 bits the one code. A live load cell has more noise, even if a specimen yields.
/// Declared noise does not widen it: a force constant within more noise is a yielding specimen's (docs/hazards.md).
const STANDS_PART: u16 = 16_000;

/// The limits of a test; the largest number if unchecked.
#[derive(Clone, Copy, Debug)]
pub struct SensorLimits {
    /// Largest difference of the two displacements, m.
    disagree_m: f32,
    /// Motion over which the force must exceed `no_force_n`, or must not be constant, m.
    force_stands_m: f32,
    /// Force around zero that counts as none, N, for each actuator.
    no_force_n: [f32; MAX_ACTUATORS],
    /// Force-free places are joined if the piston moves by less than this between them with a force, m.
    apart_m: f32,
    /// Largest force with which a test may start, N, for each actuator, as corrected by the loop.
    start_n: [f32; MAX_ACTUATORS],
    /// The test's declaration for each load cell: force read at zero force, N, and true force per force read.
    force_offset_n: [f32; MAX_ACTUATORS],
    force_scale: [f32; MAX_ACTUATORS],
}

impl SensorLimits {
    /// Checks nothing.
    pub const NONE: Self = Self {
        disagree_m: f32::MAX,
        force_stands_m: f32::MAX,
        no_force_n: [0.0; MAX_ACTUATORS],
        apart_m: f32::MAX,
        start_n: [f32::MAX; MAX_ACTUATORS],
        force_offset_n: [0.0; MAX_ACTUATORS],
        force_scale: [1.0; MAX_ACTUATORS],
    };

    /// The limits of a test.
    pub fn of(test: &BoardTest) -> Self {
        let (config, limits) = (&test.config, &test.config.limits);
        let or_never = |limit: Option<f64>| limit.map_or(f32::MAX, |m| m as f32);
        let stiffness = &config.structure.stiffness_n_per_m;
        let stands_m = limits.force_stands_m.unwrap_or(0.0);
        // A storey's force at the allowed motion, N. On a coupler no actuator has a storey's stiffness: there a
        // constant force is recognised by its code.
        let moves_n: [f64; MAX_ACTUATORS] = core::array::from_fn(|storey| {
            let own = stiffness.get(storey).filter(|_| test.coupled.is_none());
            own.map_or(0.0, |n_per_m| n_per_m * stands_m)
        });
        // The two forces on a coupler when the interface rests that far from zero, N.
        let rests_n = test.coupled.as_ref().map_or(moves_n, |coupled| {
            let each_n = largest_of_each_n(coupled, stands_m);
            core::array::from_fn(|actuator| if actuator < 2 { each_n } else { 0.0 })
        });
        // Between two storeys the force passes zero wherever their motions are equal.
        let is_alone = test.actuators() == 1 && test.coupled.is_none();
        let noise_n = DEVIATIONS * config.estimation.force_noise_n;
        Self {
            disagree_m: or_never(limits.disagree_m),
            force_stands_m: or_never(limits.force_stands_m),
            no_force_n: moves_n.map(|n| {
                let noise_n = if is_alone {
                    noise_n.min(NOISE_SHARE * n)
                } else {
                    0.0
                };
                (NO_FORCE_SHARE * n + noise_n) as f32
            }),
            apart_m: match is_alone && noise_n <= LOUD_SHARE * moves_n[0] {
                true => or_never(limits.force_stands_m),
                false => 0.0,
            },
            start_n: rests_n.map(|n| match n > 0.0 {
                true => (START_SHARE * n + MEAN_OF_NOISE * noise_n) as f32,
                false => f32::MAX,
            }),
            force_offset_n: core::array::from_fn(|actuator| {
                let offset_n = config.rig.force_offset_n.get(actuator);
                offset_n.map_or(0.0, |n| *n as f32)
            }),
            force_scale: core::array::from_fn(|actuator| {
                let gain = config.rig.force_gain.get(actuator);
                gain.map_or(1.0, |gain| (1.0 / gain) as f32)
            }),
        }
    }
}

/// The larger actuator force on a coupler whose interface the specimen holds at `x_m`, without rotation, N.
fn largest_of_each_n(coupled: &CoupledSettings<2>, x_m: f64) -> f64 {
    let (all, numerical) = (
        &coupled.structure.stiffness,
        &coupled.structure.numerical_stiffness,
    );
    let along = |row: usize| (all[row][0] - numerical[row][0]) * x_m;
    let (force_n, moment_n_m) = (along(0), along(1));
    let [first_m, second_m] = coupled.tracker.coupler.pin_y_m.map(f64::from);
    let first_n = (moment_n_m + second_m * force_n) / (second_m - first_m);
    first_n.abs().max((force_n - first_n).abs())
}

/// The state of a load cell's watch.
#[derive(Clone, Copy, Debug)]
struct ForceWatch {
    /// Its force, N, averaged over some steps.
    mean_n: f32,
    /// The last displacement, m.
    last_m: f32,
    /// Least and largest displacement of joined force-free places, m.
    without_m: [f32; 2],
    /// Steps since the last one without a force, and the piston's travel in them, m.
    with_steps: u8,
    with_m: f32,
    /// Least and largest displacement since its codes last changed by more than noise, m, and these codes.
    standing_m: [f32; 2],
    codes: [u16; 2],
}

/// An empty range.
const NOWHERE_M: [f32; 2] = [f32::MAX, f32::MIN];

impl ForceWatch {
    const NEW: Self = Self {
        mean_n: 0.0,
        last_m: 0.0,
        without_m: NOWHERE_M,
        with_steps: u8::MAX,
        with_m: 0.0,
        standing_m: NOWHERE_M,
        codes: [0; 2],
    };

    /// Adds a displacement, a force and its code; returns the motion, m, over which the force was none, or constant.
    /// `tests` as in [`SensorWatch::fault`].
    #[inline]
    fn motion_m(
        &mut self,
        [m, n]: [f32; 2],
        (none_n, apart_m): (f32, f32),
        (code, top): (u16, u16),
        tests: bool,
    ) -> f32 {
        self.mean_n += (n - self.mean_n) * MEAN_SHARE;
        let [low, high] = [self.codes[0].min(code), self.codes[1].max(code)];
        let stands = low.abs_diff(high) <= top / STANDS_PART;
        self.codes = if stands { [low, high] } else { [code; 2] };
        if !tests {
            let (mean_n, codes) = (self.mean_n, self.codes);
            *self = Self {
                mean_n,
                codes,
                last_m: m,
                ..Self::NEW
            };
            return 0.0;
        }
        self.look(m, n.abs() <= none_n, apart_m);
        if stands {
            extend(&mut self.standing_m, m);
        } else {
            self.standing_m = NOWHERE_M;
        }
        let [without_m, standing_m] =
            [self.without_m, self.standing_m].map(|[least, most]| most - least);
        without_m.max(standing_m)
    }

    /// Adds a displacement with or without a force. A single step without is a spike, and a force passes zero at places
    /// that are close together, or with much motion between them. An intermittent contact does neither.
    #[inline]
    fn look(&mut self, m: f32, is_none: bool, apart_m: f32) {
        self.with_m += (m - self.last_m).abs();
        self.last_m = m;
        if is_none {
            if self.with_steps <= TIMEOUT_STEPS {
                extend(&mut self.without_m, m);
                self.with_m = 0.0;
            }
            self.with_steps = 0;
        } else {
            self.with_steps = self.with_steps.saturating_add(1);
            if self.with_steps > TIMEOUT_STEPS && self.with_m > apart_m {
                self.without_m = NOWHERE_M;
            }
        }
    }
}

#[inline]
fn extend([least, most]: &mut [f32; 2], m: f32) {
    (*least, *most) = (least.min(m), most.max(m));
}

/// The watch on the sensors of `A` actuators.
#[derive(Clone, Copy, Debug)]
pub struct SensorWatch<const A: usize> {
    force: [ForceWatch; A],
    apart_steps: u8,
}

impl<const A: usize> SensorWatch<A> {
    /// Nothing seen yet.
    pub const fn new() -> Self {
        Self {
            force: [ForceWatch::NEW; A],
            apart_steps: 0,
        }
    }

    /// Adds a sample: the further inputs, displacements and forces in codes, in m and in N, and the size of a code of
    /// the first displacement. `tests`: an equation of motion, here or outside, uses the forces.
    #[inline]
    pub fn fault<H: Hardware<A>>(
        &mut self,
        limits: &SensorLimits,
        inputs: &[u16; MAX_INPUTS],
        (codes, m_per_code): (&[[u16; 2]; A], f32),
        read: &[[f32; 2]; A],
        tests: bool,
    ) -> Option<Fault> {
        let mut apart = false;
        let first = codes.first().map_or(0, |[displacement, _]| *displacement);
        for (second, input) in inputs.iter().zip(H::INPUTS) {
            if *input == Input::SecondDisplacement {
                let off = f32::from(second.abs_diff(first)) * m_per_code.abs();
                apart |= off > limits.disagree_m;
            }
        }
        self.apart_steps = if apart {
            self.apart_steps.saturating_add(1)
        } else {
            self.apart_steps.saturating_sub(1)
        };
        if self.apart_steps > TIMEOUT_STEPS {
            return Some(Fault::Disagree);
        }
        self.force_stands(limits, (codes, H::CODES.sensor_top), read, tests)
            .then_some(Fault::ForceStands)
    }

    /// The force, N, of the first actuator loaded beyond the limit for a start, as corrected by the loop: without the
    /// load cell errors of `[rig]`. The bearings' friction stays in it: at rest its direction is unknown.
    pub fn strained(&self, limits: &SensorLimits) -> Option<f32> {
        let cells = limits.force_offset_n.iter().zip(&limits.force_scale);
        let mut each = self.force.iter().zip(cells).zip(limits.start_n);
        each.find_map(|((seen, (offset_n, scale)), most_n)| {
            let taken_n = (seen.mean_n - offset_n) * scale;
            (taken_n.abs() > most_n).then_some(taken_n)
        })
    }

    /// Constant at zero, intermittently or always, or at any value.
    fn force_stands(
        &mut self,
        limits: &SensorLimits,
        (codes, top): (&[[u16; 2]; A], u16),
        read: &[[f32; 2]; A],
        tests: bool,
    ) -> bool {
        let mut stands = false;
        let each = self
            .force
            .iter_mut()
            .zip(read)
            .zip(codes)
            .zip(&limits.no_force_n);
        for (((seen, &read), &[_, code]), &none_n) in each {
            let none = (none_n, limits.apart_m);
            stands |= seen.motion_m(read, none, (code, top), tests) > limits.force_stands_m;
        }
        stands
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_that_moves_by_its_converters_noise_alone_stands_and_one_that_lives_does_not() {
        let limits = SensorLimits {
            force_stands_m: 2e-3,
            ..SensorLimits::NONE
        };
        for (top, off, expected) in [
            (65_535, 2, true),
            (65_535, 3, false),
            (4095, 0, true),
            (4095, 1, false),
        ] {
            let mut watch = SensorWatch::<1>::new();
            let stands = (0..30_u16).any(|step| {
                let code = top / 4 * 3 + off * (2 * (step % 2));
                let read = [[f32::from(step) * 1e-4, 5e3]];
                watch.force_stands(&limits, (&[[0, code]], top), &read, true)
            });
            assert_eq!(stands, expected, "{off} of {top} codes to either side");
        }
    }

    #[test]
    fn a_force_that_comes_and_goes_is_none_and_one_that_passes_zero_on_its_way_is_there() {
        let limits = SensorLimits {
            force_stands_m: 2e-3,
            apart_m: 2e-3,
            no_force_n: [10.0; MAX_ACTUATORS],
            ..SensorLimits::NONE
        };
        // Whether the watch trips; `force_n` gives the force, N, at each step of a motion of 10 mm to either side.
        let seen = |force_n: fn(i32) -> f32| {
            let mut watch = SensorWatch::<1>::new();
            (0..400_i32).any(|step| {
                let m = 1e-4 * (100 - (step % 400 - 200).abs()) as f32;
                let n = force_n(step);
                let code = (32_768.0 + n) as u16;
                watch.force_stands(&limits, (&[[0, code]], 65_535), &[[m, n]], true)
            })
        };
        let lives = |step: i32| 50.0 * (100 - (step % 400 - 200).abs()) as f32;
        assert_eq!(lives(0), -5000.0);
        assert!(!seen(|step| 50.0 * (100 - (step % 400 - 200).abs()) as f32));
        assert!(seen(|_| 0.0));
        assert!(seen(|step| if step % 3 == 0 {
            3000.0 + step as f32 * 9.0
        } else {
            0.0
        }));
        assert!(seen(|step| if step % 5 == 0 {
            0.0
        } else {
            3000.0 + step as f32 * 9.0
        }));
        // A contact open for 5 ms of 7.5, and for 20 of 30.
        fn open(step: i32, open: i32, of: i32) -> f32 {
            let lives_n = 3000.0 + step as f32 * 9.0;
            if step % of < open { 0.0 } else { lives_n }
        }
        assert!(seen(|step| open(step, 10, 15)));
        assert!(seen(|step| open(step, 40, 60)));
        // A contact open for 1.4 mm, and closed for longer, is a slack specimen.
        assert!(!seen(|step| open(step, 15, 60)));
        // A spike does not make a load cell dead.
        assert!(!seen(|step| if step % 8 == 0 {
            0.0
        } else {
            3000.0 + step as f32 * 9.0
        }));
    }
    /// Steps until the watch declares a cell dead, in `seconds` at 2 kHz; its force, N, depends on place, m, and step.
    fn watched(
        limits: &SensorLimits,
        seconds: u32,
        place_m: impl Fn(f32) -> f32,
        force_n: impl Fn(f32, u32) -> f32,
    ) -> Option<u32> {
        let mut watch = SensorWatch::<1>::new();
        let mut rng = 1_u32;
        // Uniform from -1 to 1: its standard deviation is 0.58.
        let mut noise = || {
            rng = rng.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (rng >> 8) as f32 / 8_388_608.0 - 1.0
        };
        (0..2000 * seconds).find(|&step| {
            let m = place_m(step as f32 / 2000.0);
            let n = force_n(m, step) + 17.0 * noise();
            let m = m + 1.7e-5 * noise();
            let code = (32_768.0 + n) as u16;
            watch.force_stands(limits, (&[[0, code]], 65_535), &[[m, n]], true)
        })
    }

    /// Rest, and motions of all sizes, with noise of 10 um and 10 N; limit 2 mm; declared stiffness, and a third of it.
    #[test]
    fn a_sound_specimen_in_a_long_weak_motion_is_never_dead() {
        let mut config = outerloop_core::Config::shear_frame([1000.0], [158e3], [0.02]);
        config.limits.force_stands_m = Some(2e-3);
        let limits = SensorLimits::of(&config.into());
        // Half of 316 N, and six deviations of the mean of 10 N of noise.
        assert!((limits.start_n[0] - 163.3).abs() < 0.1, "{limits:?}");
        // 2 % of 316 N, and a thirty-second of it for noise.
        assert!((limits.no_force_n[0] - 16.2).abs() < 0.01);
        for share in [1.0, 0.33] {
            for amplitude_m in [0.0, 5e-5, 1e-4, 1.6e-4, 2e-4, 3e-4, 5e-4, 1e-3, 5e-3_f32] {
                for middle_m in [0.0, 1.6e-4_f32] {
                    let place_m = |s: f32| middle_m + amplitude_m * (12.6 * s).sin();
                    let dead = watched(&limits, 60, place_m, |m, _| share * 158e3 * m);
                    assert_eq!(dead, None, "{share}, {amplitude_m} m around {middle_m}");
                }
            }
        }
        let moves_m = |s: f32| 5e-3 * (12.6 * s).sin();
        // Dead, with its amplifier's noise, which exceeds 2 % of the motion's force, and with 9 N of hum as well.
        let dead = watched(&limits, 1, moves_m, |_, _| 0.0).expect("it is seen");
        let hums = |_, step: u32| 9.0 * (0.157 * (step % 40) as f32).sin();
        let hum = watched(&limits, 1, moves_m, hums).expect("it is seen");
        assert!(dead < 100 && hum < 100, "{dead}, {hum} steps");
    }
}
