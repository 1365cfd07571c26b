//! The limits that a board requires, computed from the planned test where the test file omits them.
//!
//! | limit | is |
//! |---|---|
//! | `displacement_m` | 1.5 times the largest displacement of the ideal test, of any actuator, plus 7 standard deviations of the reading's noise |
//! | `velocity_m_per_s` | 3 times the test's largest velocity in the laboratory, at least twice that of the approach |
//! | `force_n` | 1.5 times the largest force of the elastic storeys on an actuator, plus 7 standard deviations of the noise |
//! | `tracking_m` | twice the distance travelled at the largest velocity in the declared delay, plus a tenth of the largest displacement and 7 standard deviations; at most what a board accepts |
//! | `stale_steps` | the declared delay plus 20 ms |
//! | `frozen_m` | 8 codes of the board's displacement, or 16 standard deviations of its noise, whichever is larger |
//! | `energy_trip` | 3: no sound test of `check-surveys monitor` (in `host-tests`) reaches it |
//! | `force_stands_m` | a quarter of the largest displacement; only for a test on a ground motion |
//!
//! Seven standard deviations: of 400 000 tests of a million steps one exceeds them by chance.

use super::trajectory::Trajectory;
use experiment::Experiment;
use experiment::files::test::TestFile;
use experiment::rig;
use experiment::trace::Response;
use link::limits::{CalibratedRange, FROZEN_DEVIATIONS};
use outerloop_core::config::Limits;

/// Factor over the ideal test's largest displacement and force.
const MARGIN: f64 = 1.5;
/// Factor over its largest velocity: a compensation may move faster.
const VELOCITY_MARGIN: f64 = 3.0;
/// Standard deviations of noise that are no fault.
const DEVIATIONS: f64 = 7.0;
/// Share of the planned motion: a force that stays near zero over more than this means a dead load cell.
const FORCE_STANDS: f64 = 0.25;
/// Energy error over the energy in the test: the threshold of `check-surveys monitor`.
const ENERGY_TRIP: f64 = 3.0;
/// Time added to the declared delay, s.
const STALE_S: f64 = 0.02;

/// What the planned test will do at the actuators, if all goes well; of several actuators, the largest value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedMotion {
    /// Largest displacement, m.
    pub displacement_m: f64,
    /// Largest velocity of the command, m/s of laboratory time.
    pub velocity_m_per_s: f64,
    /// Largest force of the elastic storeys, N.
    pub force_n: f64,
    /// Noise of the displacement, m, one standard deviation.
    pub noise_m: f64,
    /// Noise of the force, N.
    pub noise_n: f64,
    /// Declared delay of the actuator, s.
    pub delay_s: f64,
    /// Speed of the approach, m/s.
    pub approach_m_per_s: f64,
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// Motion over which a force near zero means a dead load cell, m; none where no force is known beforehand.
    pub force_stands_m: Option<f64>,
}

impl PlannedMotion {
    /// Of `experiment`, whose ideal response is known.
    pub fn of(experiment: &Experiment, ideal: &Response) -> Self {
        let config = &experiment.test.config;
        let timing = &config.timing;
        let step_s = config.model_step_s() * timing.time_scale;
        let (mut peak_m, mut fastest, mut force_n) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut last_m: Option<Vec<f64>> = None;
        for floors_m in (0..ideal.steps()).filter_map(|step| ideal.at(step)) {
            let (at_m, pulled_n) = at_actuators(&experiment.test, floors_m);
            for (actuator, now_m) in at_m.iter().enumerate() {
                let moved_m = last_m
                    .as_ref()
                    .map_or(0.0, |last_m| now_m - last_m[actuator]);
                fastest = fastest.max(moved_m.abs() / step_s);
                peak_m = peak_m.max(now_m.abs());
            }
            force_n = pulled_n.into_iter().fold(force_n, f64::max);
            last_m = Some(at_m);
        }
        Self {
            force_stands_m: (peak_m > 0.0).then_some(FORCE_STANDS * peak_m),
            ..Self::with(&experiment.test, peak_m, fastest, force_n)
        }
    }

    fn with(test: &TestFile, displacement_m: f64, velocity_m_per_s: f64, force_n: f64) -> Self {
        let TestFile { config, plant, .. } = test;
        let [noise_m, noise_n] = rig::noise_rms(config, plant);
        Self {
            displacement_m,
            velocity_m_per_s,
            force_n,
            noise_m,
            noise_n,
            delay_s: config.compensation.delay_ms.longest() * 1e-3,
            approach_m_per_s: config.timing.approach_m_per_s,
            rate_hz: config.timing.rate_hz,
            force_stands_m: None,
        }
    }

    /// Of a test whose motion an external model decides: as far and as fast as its limits allow.
    pub fn of_served(test: &TestFile) -> Self {
        let limits = &test.config.limits;
        let approach_m_per_s = test.config.timing.approach_m_per_s;
        let fastest = limits.velocity_m_per_s.map(|v| v / VELOCITY_MARGIN);
        let displacement_m = limits.displacement_m.unwrap_or(0.0) / MARGIN;
        Self::with(
            test,
            displacement_m,
            fastest.unwrap_or(approach_m_per_s),
            alone_n(test, 0, displacement_m),
        )
    }

    /// Largest displacement and force that the sensors may have to show: 1.5 times those planned, plus the noise.
    pub fn noisy_peaks(&self) -> (f64, f64) {
        (
            MARGIN * self.displacement_m + DEVIATIONS * self.noise_m,
            MARGIN * self.force_n + DEVIATIONS * self.noise_n,
        )
    }

    /// Of a commissioning signal under a test's limits, on an actuator numbered from 0.
    pub fn of_trajectory(test: &TestFile, trajectory: &Trajectory, actuator: usize) -> Self {
        let force_n = alone_n(test, actuator, trajectory.peak_m());
        Self::with(
            test,
            trajectory.peak_m(),
            trajectory.speed_m_per_s(),
            force_n,
        )
    }

    /// All limits; those `stated` are kept. `shown` is the board's calibrated range.
    pub fn limits(&self, stated: &Limits, shown: &CalibratedRange) -> Limits {
        let mut limits = self.without_board(stated);
        let noisy_m = FROZEN_DEVIATIONS * self.noise_m;
        limits.frozen_m = stated.frozen_m.or(Some(shown.frozen_m.max(noisy_m)));
        if stated.tracking_m.is_none() {
            let most_m = shown.most_tracking_m(&limits);
            limits.tracking_m = limits.tracking_m.map(|m| m.min(most_m));
        }
        limits
    }

    /// The limits that follow from the test alone; those `stated` are kept.
    pub fn without_board(&self, stated: &Limits) -> Limits {
        let speed = (VELOCITY_MARGIN * self.velocity_m_per_s).max(2.0 * self.approach_m_per_s);
        let has_speed = stated.increment_m.is_some() || stated.velocity_m_per_s.is_some();
        let (peak_m, peak_n) = self.noisy_peaks();
        let noise_m = DEVIATIONS * self.noise_m;
        let late_m = 2.0 * self.velocity_m_per_s * self.delay_s;
        let stale = (self.delay_s + STALE_S) * self.rate_hz;
        Limits {
            displacement_m: stated.displacement_m.or(Some(peak_m)),
            velocity_m_per_s: stated.velocity_m_per_s.or((!has_speed).then_some(speed)),
            force_n: stated.force_n.or(Some(peak_n)),
            tracking_m: stated
                .tracking_m
                .or(Some(late_m + 0.1 * self.displacement_m + noise_m)),
            stale_steps: stated
                .stale_steps
                .or(Some(stale.ceil().min(f64::from(u16::MAX)) as u16)),
            force_stands_m: stated.force_stands_m.or(self.force_stands_m),
            energy_trip: stated.energy_trip.or(Some(ENERGY_TRIP)),
            ..stated.clone()
        }
    }
}

/// Stiffnesses of the storeys in the laboratory, from the ground up, N/m.
fn laboratory_storeys(test: &TestFile) -> &[f64] {
    let storeys = &test.config.structure.stiffness_n_per_m;
    let physical = test.config.physical_storeys().min(storeys.len());
    &storeys[..physical]
}

/// Position of each actuator, m, and its force from an elastic specimen, N, with the floors at `floors_m`.
fn at_actuators(test: &TestFile, floors_m: &[f32]) -> (Vec<f64>, Vec<f64>) {
    let Some(part) = &test.coupled else {
        let storeys = laboratory_storeys(test);
        let own = floors_m.iter().take(storeys.len()).copied();
        return (
            own.map(f64::from).collect(),
            forces_n(storeys, floors_m).collect(),
        );
    };
    let at = [0, 1].map(|i| f64::from(floors_m[i]));
    let declared = &part.declared;
    let resultant = declared
        .specimen
        .stiffness
        .map(|row| row[0] * at[0] + row[1] * at[1]);
    let forces_n = declared.coupler.forces_n(resultant, at[1]);
    (
        declared.coupler.strokes_m(at).to_vec(),
        forces_n.map(f64::abs).to_vec(),
    )
}

/// Forces on the actuators, N, of elastic storeys with these floor displacements, m: each floor is held by the storeys
/// below and above it.
fn forces_n<'a>(storeys: &'a [f64], floors_m: &'a [f32]) -> impl Iterator<Item = f64> + 'a {
    let at = |floor: usize| f64::from(floors_m[floor]);
    let storey_n = move |floor: usize| {
        let below_m = if floor == 0 { 0.0 } else { at(floor - 1) };
        storeys
            .get(floor)
            .map_or(0.0, |k| k * (at(floor) - below_m))
    };
    (0..storeys.len()).map(move |floor| (storey_n(floor) - storey_n(floor + 1)).abs())
}

/// Force on an actuator, from 0, N, that moves alone by this displacement; of two on one coupler, if both move by it.
fn alone_n(test: &TestFile, actuator: usize, displacement_m: f64) -> f64 {
    if test.coupled.is_some() {
        let (_, forces_n) = at_actuators(test, &[displacement_m as f32, 0.0]);
        return forces_n.into_iter().fold(0.0, f64::max);
    }
    let around = laboratory_storeys(test).iter().skip(actuator).take(2);
    let around = around.sum::<f64>();
    around * displacement_m
}

/// The limits in force, one per line; those that were computed are marked.
pub fn describe(stated: &Limits, limits: &Limits) -> String {
    type Row = (&'static str, f64, &'static str, fn(&Limits) -> Option<f64>);
    let rows: [Row; 10] = [
        ("displacement_m", 1e3, "mm", |l| l.displacement_m),
        ("velocity_m_per_s", 1e3, "mm/s", |l| l.velocity_m_per_s),
        ("increment_m", 1e3, "mm", |l| l.increment_m),
        ("force_n", 1e-3, "kN", |l| l.force_n),
        ("tracking_m", 1e3, "mm", |l| l.tracking_m),
        ("stale_steps", 1.0, "steps", |l| {
            l.stale_steps.map(f64::from)
        }),
        ("frozen_m", 1e3, "mm", |l| l.frozen_m),
        ("energy_trip", 1.0, "", |l| l.energy_trip),
        ("disagree_m", 1e3, "mm", |l| l.disagree_m),
        ("force_stands_m", 1e3, "mm", |l| l.force_stands_m),
    ];
    let line = |(name, per_unit, unit, of): Row| {
        let value = of(limits)? * per_unit;
        let origin = if of(stated).is_some() {
            ""
        } else {
            "  worked out"
        };
        Some(format!("  {name:<17}{value:>10.4} {unit:<5}{origin}"))
    };
    let lines: Vec<String> = rows.into_iter().filter_map(line).collect();
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAN: PlannedMotion = PlannedMotion {
        displacement_m: 0.02,
        velocity_m_per_s: 0.1,
        force_n: 3000.0,
        noise_m: 1e-5,
        noise_n: 5.0,
        delay_s: 0.004,
        approach_m_per_s: 0.01,
        rate_hz: 2000.0,
        force_stands_m: None,
    };

    const SHOWN: CalibratedRange = CalibratedRange {
        displacement_m: 0.0426,
        force_n: 8500.0,
        frozen_m: 1e-4,
    };

    #[test]
    fn coloured_noise_and_hum_are_noise() {
        let text = "[structure]\nmass_kg = 1000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.02\n[plant.sensors]\n\
                    displacement_noise_mm = 0.3\ndisplacement_coloured_noise_mm = 0.4\nforce_hum_n = 20\n";
        let test = TestFile::parse(text, "t.toml", std::path::Path::new(""), &[]).unwrap();
        let plan = PlannedMotion::with(&test, 0.02, 0.1, 3000.0);
        assert!((plan.noise_m - 5e-4).abs() < 1e-12, "{plan:?}");
        assert!((plan.noise_n - 200.0_f64.sqrt()).abs() < 1e-9, "{plan:?}");
    }

    #[test]
    fn what_the_test_says_stands_and_the_rest_is_worked_out() {
        let stated = Limits {
            force_n: Some(4000.0),
            ..Limits::default()
        };
        let limits = PLAN.limits(&stated, &SHOWN);
        assert_eq!(limits.force_n, Some(4000.0));
        assert!((limits.displacement_m.unwrap() - 0.03007).abs() < 1e-12);
        assert!((limits.velocity_m_per_s.unwrap() - 0.3).abs() < 1e-12);
        assert!((limits.tracking_m.unwrap() - 0.00287).abs() < 1e-12);
        assert_eq!(limits.stale_steps, Some(48));
        // 16 standard deviations of 10 um.
        assert!((limits.frozen_m.unwrap() - 1.6e-4).abs() < 1e-12);
        assert_eq!(limits.energy_trip, Some(3.0));
        let shown = describe(&stated, &limits);
        assert!(
            shown.contains("displacement_m      30.0700 mm     worked out"),
            "{shown}"
        );
        assert!(shown.contains("force_n              4.0000 kN"), "{shown}");
    }

    #[test]
    fn a_floor_is_held_by_the_storeys_below_and_above_it() {
        let of =
            |storeys: &[f64], floors: &[f32]| -> Vec<f64> { forces_n(storeys, floors).collect() };
        // One storey in the laboratory, two computed: only the one has a force.
        assert_eq!(of(&[100.0], &[0.5, 9.0, 9.0]), [50.0]);
        // Only the second floor is moved: the storeys on both sides respond and load its neighbours.
        assert_eq!(
            of(&[100.0, 200.0, 400.0], &[0.0, 0.5, 0.0]),
            [100.0, 300.0, 200.0]
        );
    }

    #[test]
    fn an_increment_stands_for_a_velocity() {
        let stated = Limits {
            increment_m: Some(1e-4),
            ..Limits::default()
        };
        assert_eq!(PLAN.limits(&stated, &SHOWN).velocity_m_per_s, None);
    }

    #[test]
    fn a_board_takes_what_is_worked_out_for_a_test_that_fits_it() {
        let mut config = outerloop_core::Config::shear_frame([1000.0], [158e3], [0.02]);
        config.limits = PLAN.limits(&Limits::default(), &SHOWN);
        assert_eq!(SHOWN.check(&config), Ok(()));
    }
}
