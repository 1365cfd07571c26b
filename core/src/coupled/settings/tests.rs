use super::super::coupler::Coupler;
use super::super::estimate::EstimatorSettings;
use super::super::forward::Forward;
use super::super::pair::Pair;
use super::super::plant::tests::FRAME;
use super::super::plant::{MAX_PARAMETERS, Parameter, Plant, Spreads};
use super::super::response::observed;
use super::super::rig::INTERFACE_AXIS as X;
use super::*;
use crate::config::Limits;
use crate::matrix::Matrix;
use crate::{Coefficients, Event, Fault, GroundMotion, Method, Mode, Newmark, OuterLoop, Sample};
extern crate std;
use std::println;

const PERIOD_S: f32 = 1.0 / 1024.0;
const POINTS: usize = 400;
const COUPLER: Coupler = Coupler {
    pin_x_m: [0.2667; 2],
    pin_y_m: [-0.127, 0.127],
};
/// Half of the structure's stiffness is in the laboratory.
const SPECIMEN: Matrix<2> = [[104e3, 30e3], [30e3, 96e3]];

fn structure() -> Structure<2> {
    Structure {
        mass: [[1000.0, 0.0], [0.0, 60.0]],
        damping: SPECIMEN.map(|row| row.map(|k| 0.008 * k)),
        stiffness: SPECIMEN.map(|row| row.map(|k| 2.0 * k)),
        numerical_stiffness: SPECIMEN,
        influence: [1.0, 0.0],
        physical: 2,
        physical_mass_kg: [0.0; 2],
    }
}

/// The settings of a complete test.
struct Settings {
    config: Config,
    coupled: CoupledSettings<2>,
}

fn settings() -> Settings {
    let spreads = [
        (Parameter::SlowPole(0), 0.06),
        (Parameter::SlowPole(1), 0.06),
        (Parameter::FastPole(0), 0.06),
        (Parameter::FastPole(1), 0.06),
    ];
    let structure = structure();
    let free = |position| Bounds {
        position,
        speed_per_s: 2.0,
        force: 1e5,
        tracking: 0.05,
    };
    let mut config = Config::shear_frame([1.0; 2], [1.0; 2], [0.0; 2]);
    config.compensation.kind = Method::None;
    config.timing.rate_hz = f64::from(1.0 / PERIOD_S);
    config.timing.approach_m_per_s = 0.01;
    config.timing.hold_deceleration_m_per_s2 = 1.0;
    config.limits = Limits {
        displacement_m: Some(0.05),
        velocity_m_per_s: Some(2.0),
        force_n: Some(1e5),
        tracking_m: Some(0.05),
        stale_steps: Some(5),
        ..Limits::default()
    };
    let target = |axis, noise| {
        let observer = observed(&structure, axis, noise, 0.2).unwrap();
        observer.steady(f64::from(PERIOD_S)).unwrap()
    };
    let coupled = CoupledSettings {
        tracker: TrackerSettings {
            coupler: COUPLER,
            estimate: EstimatorSettings {
                plant: FRAME,
                spreads: spreads.into_iter().collect(),
                noise_m: 1e-5,
                period_s: PERIOD_S,
            },
            inverse: true,
            target: [target(0, 1e-6), target(1, 1e-5)],
            ahead_s: 0.0,
            trust_reading_hz: 5.0,
        },
        structure,
        interface: [free(0.05), free(0.2)],
    };
    Settings { config, coupled }
}

fn shaking() -> [f32; POINTS] {
    core::array::from_fn(|i| {
        let t = i as f32 * 0.01;
        0.6 * libm::sinf(11.0 * t) * libm::sinf(0.785 * t) + 0.3 * libm::sinf(31.0 * t)
    })
}

/// The laboratory: actuators whose slow poles are 5 % off the declared ones, and a linear specimen.
struct Laboratory {
    actuators: Forward,
    plant: Plant,
    noise: u32,
}

impl Laboratory {
    fn new() -> Self {
        let mut plant = FRAME;
        plant.slow_pole_rad_per_s = plant.slow_pole_rad_per_s.map(|p| 1.05 * p);
        Self {
            actuators: Forward::at_rest(),
            plant,
            noise: 1,
        }
    }

    /// The true position of the interface, and the sample.
    fn step(&mut self, sent_m: &Pair) -> (Pair, Sample<2>) {
        let mut slopes = [[0.0; MAX_PARAMETERS]; 2];
        let (none, plant) = (Spreads::new(), &self.plant);
        let strokes_m = self
            .actuators
            .step(plant, &none, PERIOD_S, sent_m, &mut slopes);
        let at = COUPLER.interface(&strokes_m);
        let force = answers(&at);
        // Actuator forces with this resultant.
        let arm = force[1] / COUPLER.pin_y_m[1];
        let force_n = [0.5 * (force[0] + arm), 0.5 * (force[0] - arm)];
        // White, 5 um rms.
        let read_m = strokes_m.map(|x| {
            self.noise = self
                .noise
                .wrapping_mul(1_664_525)
                .wrapping_add(1_013_904_223);
            x + 8.7e-6 * ((self.noise >> 8) as f32 / 8_388_608.0 - 1.0)
        });
        (at, Sample::new(read_m, force_n))
    }
}

/// The response of the specimen.
fn answers(at: &Pair) -> Pair {
    core::array::from_fn(|i| SPECIMEN[i][0] as f32 * at[0] + SPECIMEN[i][1] as f32 * at[1])
}

/// The response with ideal actuators.
fn ideal(ground: &GroundMotion<'_>, steps: usize, mut see: impl FnMut(usize, Pair)) {
    let k = Coefficients::new(&structure(), f64::from(PERIOD_S), 1.0).unwrap();
    let mut newmark = Newmark::at_rest();
    for i in 0..steps {
        let load_n = k.load_n(ground.at(i as u32));
        let force_n = answers(&newmark.displacement_m());
        see(i, newmark.displacement_m());
        newmark.advance(&k, &load_n, &force_n, &[0.0; 2]);
    }
}

const STEPS: usize = 4000;

/// Largest ideal displacement, and largest difference of `targets` from it from sample `from` on, of x and rotation.
fn differences(ground: &GroundMotion<'_>, targets: &[Pair; STEPS], from: usize) -> (Pair, Pair) {
    let (mut peak, mut error) = ([0.0_f32; 2], [0.0_f32; 2]);
    ideal(ground, STEPS, |i, u| {
        for j in 0..2 {
            peak[j] = peak[j].max(u[j].abs());
            if i >= from {
                error[j] = error[j].max((u[j] - targets[i][j]).abs());
            }
        }
    });
    (peak, error)
}

/// A running test, with its laboratory.
fn running(settings: &Settings) -> (OuterLoop<2, CoupledRig>, Laboratory, Pair) {
    let mut outer = OuterLoop::new(Design::coupled(&settings.config, &settings.coupled).unwrap());
    let mut laboratory = Laboratory::new();
    let mut sent_m = [0.0; 2];
    for tick in 0..20_000 {
        let (_, sample) = laboratory.step(&sent_m);
        sent_m = outer.step(&sample, &GroundMotion::none()).command_m;
        match outer.mode() {
            Mode::Idle if tick > 200 => drop(outer.handle(Event::Arm)),
            Mode::Armed => {
                outer.handle(Event::Start).unwrap();
                return (outer, laboratory, sent_m);
            }
            _ => {}
        }
    }
    panic!("the loop was not armed: {:?}", outer.trip());
}

#[test]
fn the_structure_moves_as_with_ideal_actuators_where_without_the_tracker_it_runs_away() {
    let points = shaking();
    let ground = GroundMotion::new(&points, 0.01, f64::from(PERIOD_S)).unwrap();
    let (mut outer, mut laboratory, mut sent_m) = running(&settings());
    let mut targets = [[0.0; 2]; STEPS];
    for target in &mut targets {
        let (_, sample) = laboratory.step(&sent_m);
        let step = outer.step(&sample, &ground);
        (sent_m, *target) = (step.command_m, step.record.command_m);
        assert_eq!(outer.mode(), Mode::Running, "{:?}", outer.trip());
    }
    let (peak, error) = differences(&ground, &targets, 0);
    println!("tracked: largest difference {error:?} of {peak:?} (m, rad)");
    for j in 0..2 {
        assert!(error[j] < 0.01 * peak[j], "{error:?} of {peak:?}");
    }

    // The same without the tracker: commands are the strokes of the target.
    let k = Coefficients::new(&structure(), f64::from(PERIOD_S), 1.0).unwrap();
    let (mut newmark, mut laboratory) = (Newmark::at_rest(), Laboratory::new());
    for (i, target) in targets.iter_mut().enumerate() {
        *target = newmark.displacement_m();
        let [x, theta] = *target;
        let (_, sample) = laboratory.step(&COUPLER.strokes_m(x, theta));
        let force_n = COUPLER.resultant(&sample.force_n, theta);
        newmark.advance(&k, &k.load_n(ground.at(i as u32)), &force_n, &[0.0; 2]);
    }
    let (peak, error) = differences(&ground, &targets, 0);
    println!("strokes as commands: {error:?}");
    assert!(error[0] > peak[0], "{error:?} of {peak:?}");
}

/// No emergency stop: the target slows down, and the test ends.
#[test]
fn the_energy_error_ends_a_test_on_the_ramp() {
    let points = shaking();
    let ground = GroundMotion::new(&points, 0.01, f64::from(PERIOD_S)).unwrap();
    let mut settings = settings();
    settings.config.limits.energy_trip = Some(1e-3);
    let (mut outer, mut laboratory, mut sent_m) = running(&settings);
    let mut on_the_ramp = 0;
    for _ in 0..STEPS {
        let (_, sample) = laboratory.step(&sent_m);
        sent_m = outer.step(&sample, &ground).command_m;
        on_the_ramp += u32::from(outer.mode() == Mode::Stopping);
    }
    assert_eq!(outer.mode(), Mode::Tripped);
    assert_eq!(outer.trip().map(|t| t.fault), Some(Fault::EnergyRatio));
    assert!(on_the_ramp > 10, "{on_the_ramp}");
}

#[test]
fn every_interlock_acts_and_names_its_axis() {
    let points = shaking();
    let ground = GroundMotion::new(&points, 0.01, f64::from(PERIOD_S)).unwrap();
    let trip = |change: &dyn Fn(&mut Settings), spoil: &dyn Fn(&mut Sample<2>)| {
        let mut settings = settings();
        change(&mut settings);
        let (mut outer, mut laboratory, mut sent_m) = running(&settings);
        for tick in 0..STEPS {
            let (_, mut sample) = laboratory.step(&sent_m);
            if tick > 1000 {
                spoil(&mut sample);
            }
            let before_m = sent_m;
            let step = outer.step(&sample, &ground);
            let permit = step.permit;
            sent_m = step.command_m;
            assert!(sent_m.iter().all(|u| u.is_finite()));
            if let Some(trip) = outer.trip() {
                assert_eq!(sent_m, before_m, "the last command stands");
                assert!(!permit && outer.mode() == Mode::Tripped);
                return Some((trip.fault, trip.axis));
            }
        }
        None
    };
    let good = |_: &mut Sample<2>| ();
    let as_is = |_: &mut Settings| ();
    assert_eq!(trip(&as_is, &good), None);
    type Change = fn(&mut Settings);
    let limits: [(Change, Fault, u8); 6] = [
        (
            |s| s.coupled.interface[0].position = 1e-4,
            Fault::Displacement,
            X,
        ),
        (
            |s| s.coupled.interface[1].position = 1e-5,
            Fault::Displacement,
            X + 1,
        ),
        (
            |s| s.coupled.interface[0].speed_per_s = 2e-2,
            Fault::Velocity,
            X,
        ),
        (
            |s| s.coupled.interface[1].speed_per_s = 1e-2,
            Fault::Velocity,
            X + 1,
        ),
        (|s| s.coupled.interface[0].force = 20.0, Fault::Force, X),
        (|s| s.coupled.interface[1].force = 5.0, Fault::Force, X + 1),
    ];
    for (change, fault, axis) in limits {
        assert_eq!(trip(&change, &good), Some((fault, axis)));
    }
    // The reading of one actuator jumps: whichever limit is stricter acts.
    let jump = |s: &mut Sample<2>| s.displacement_m[1] += 0.1;
    let loose: Change = |s| s.config.limits.tracking_m = Some(1.0);
    assert_eq!(trip(&as_is, &jump), Some((Fault::Tracking, 1)));
    assert_eq!(trip(&loose, &jump), Some((Fault::Reading, 1)));
    let looser: Change = |s| {
        s.config.limits.tracking_m = Some(1.0);
        s.config.limits.displacement_m = Some(1.0);
    };
    assert_eq!(trip(&looser, &jump), Some((Fault::Tracking, X + 1)));
    let spoilt = |spoil: fn(&mut Sample<2>)| trip(&as_is, &spoil).map(|t| t.0);
    assert_eq!(spoilt(|s| s.force_n[1] = f32::NAN), Some(Fault::NonFinite));
    assert_eq!(
        spoilt(|s| s.displacement_m = [0.0; 2]),
        Some(Fault::StaleSample)
    );
    assert_eq!(spoilt(|s| s.fresh = false), Some(Fault::StaleSample));
    assert_eq!(
        spoilt(|s| s.fault = Some(Fault::EmergencyStop)),
        Some(Fault::EmergencyStop)
    );
}

#[test]
fn a_hold_stands_still_and_the_test_goes_on_where_it_stood() {
    let points = shaking();
    let ground = GroundMotion::new(&points, 0.01, f64::from(PERIOD_S)).unwrap();
    let (mut outer, mut laboratory, mut sent_m) = running(&settings());
    let mut targets = [[0.0; 2]; STEPS];
    let (mut solved, mut ticks, mut last) = (0, 0, [0.0; 2]);
    while solved < STEPS {
        ticks += 1;
        assert!(ticks < 3 * STEPS, "{:?}", outer.mode());
        let (_, sample) = laboratory.step(&sent_m);
        let ran = outer.mode().integrates();
        let step = outer.step(&sample, &ground);
        let target = step.record.command_m;
        sent_m = step.command_m;
        assert_eq!(outer.trip(), None);
        if ran {
            targets[solved] = target;
            solved += 1;
        }
        let stood = std::mem::replace(&mut last, target);
        match ticks {
            1500 => drop(outer.handle(Event::Hold).unwrap()),
            2500 => {
                assert_eq!(target, stood, "it stands");
                outer.handle(Event::Start).unwrap();
            }
            _ => {}
        }
    }
    // The actuators start from rest into a motion: the resulting error dies out with the structure's damping.
    let (peak, error) = differences(&ground, &targets, 3000);
    for j in 0..2 {
        assert!(error[j] < 0.01 * peak[j], "{error:?} of {peak:?}");
    }
}

/// Gains are identified, too.
fn with_gains() -> Settings {
    let mut settings = settings();
    let gains = [(0, 0), (0, 1), (1, 0), (1, 1)];
    let gains = gains.map(|(i, j)| (Parameter::Gain(i, j), 0.03));
    settings.coupled.tracker.estimate.spreads.extend(gains);
    settings
}

/// A rig at rest with its valves shut: a model that learnt from it would overestimate every gain.
#[test]
fn nothing_is_learnt_of_actuators_whose_valves_are_shut() {
    const STANDS_M: Pair = [0.01, 0.01];
    let settings = with_gains();
    let mut outer = OuterLoop::new(Design::coupled(&settings.config, &settings.coupled).unwrap());
    let mut laboratory = Laboratory::new();
    laboratory.plant = FRAME;
    let (mut sent_m, mut permit) = ([0.0; 2], false);
    let (mut at_m, mut fastest_m) = (STANDS_M, Pair::default());
    for tick in 0..3000 {
        let (_, mut sample) = laboratory.step(&sent_m);
        if !permit {
            sample = Sample::new(STANDS_M, [0.0; 2]);
        }
        let moved_m = |i: usize| (sample.displacement_m[i] - at_m[i]).abs();
        fastest_m = core::array::from_fn(|i| fastest_m[i].max(moved_m(i)));
        at_m = sample.displacement_m;
        let step = outer.step(&sample, &GroundMotion::none());
        (sent_m, permit) = (step.command_m, step.permit);
        if tick == 1500 {
            assert_eq!(outer.rig().plant(), &FRAME);
            outer.handle(Event::Arm).unwrap();
        }
    }
    assert_eq!(outer.mode(), Mode::Armed);
    println!("{fastest_m:?} m a step");
    assert!(fastest_m.iter().all(|&m| m < 1e-4), "{fastest_m:?}");
}

/// Transducers 0.1 mm off, and an external model that takes five seconds: a tenth of 1 mm would end up in the gains.
#[test]
fn nothing_is_learnt_of_a_rig_that_stands_at_its_target() {
    let settings = with_gains();
    let (mut outer, mut laboratory, mut sent_m) = running(&settings);
    laboratory.plant = FRAME;
    outer.set_pace(Some(crate::Pace::StopAndGo));
    outer.set_next_target([1e-3, 0.0]);
    let mut came = None;
    for tick in 0..6000 {
        let (_, mut sample) = laboratory.step(&sent_m);
        sample.displacement_m = sample.displacement_m.map(|m| m + 1e-4);
        sent_m = outer.step(&sample, &GroundMotion::none()).command_m;
        match tick {
            1000 => came = Some(*outer.rig().plant()),
            1001.. => assert_eq!(Some(*outer.rig().plant()), came),
            _ => {}
        }
    }
    assert_eq!(outer.mode(), Mode::Running);
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let refused = |change: fn(&mut Settings)| {
        let mut settings = settings();
        change(&mut settings);
        Design::coupled(&settings.config, &settings.coupled)
            .map(drop)
            .unwrap_err()
            .name
    };
    assert_eq!(
        refused(|s| s.coupled.structure.physical = 1),
        "structure.physical"
    );
    assert_eq!(
        refused(|s| s.config.limits.force_n = None),
        "coupled.limits"
    );
    assert_eq!(
        refused(|s| s.coupled.interface[1].position = 0.6),
        "coupled.limits.rotation_rad"
    );
    assert!(observed(&structure(), 2, 1e-6, 0.2).is_err());
}
