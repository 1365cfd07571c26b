//! Every number of a test file's compensation, estimation and pace reaches the loop: a test in which one of them is
//! another sends other commands. What each does is tested where it is done.
#![allow(missing_docs, clippy::type_complexity)]

mod common;

use common::{Rig, STIFFNESS_N_PER_M, table1};
use outerloop_core::config::{Compensation, Estimation, Filter, Hydraulic, Limits, Secant, Timing};
use outerloop_core::{Config, Design, Event, Fault, GroundMotion, Method, OuterLoop, Sample};

/// Gives one of the numbers another value.
type Change<T> = fn(&mut T);

/// Commands of four seconds on a rig that is 4 ms late and whose load cell and transducer are noisy, m.
fn commands(config: &Config) -> Vec<u32> {
    let ground = common::shaking(4.0);
    let ground = GroundMotion::new(&ground, 0.01, config.model_step_s()).unwrap();
    let mut outer = OuterLoop::<1>::new(Design::new(config).unwrap());
    let mut rig = Rig::new(8);
    (0..8000)
        .map(|k| {
            let exact = rig.sample();
            // Two numbers without a common period stand for noise.
            let (a, b) = ((k as f32 * 12.9898).sin(), (k as f32 * 78.233).sin());
            let displacement_m = exact.displacement_m[0] + 2e-5 * a;
            let sample = Sample::new(
                [displacement_m],
                [STIFFNESS_N_PER_M as f32 * exact.displacement_m[0] + 50.0 * b],
            );
            let command_m = outer.step(&sample, &ground).command_m[0];
            rig.sent = command_m;
            match k {
                0 => drop(outer.handle(Event::Arm)),
                1 => drop(outer.handle(Event::Start)),
                _ => {}
            }
            command_m.to_bits()
        })
        .collect()
}

/// A test of Table 1 with this method.
fn test(kind: Method) -> Config {
    let mut config = table1();
    config.compensation.kind = kind;
    config
}

/// Refuses a change after which the loop sends what it sent before.
fn acts(name: &str, before: &Config, change: impl Fn(&mut Config)) {
    let mut after = before.clone();
    change(&mut after);
    assert_ne!(*before, after, "{name} is the same as before");
    assert!(
        commands(before) != commands(&after),
        "{name} of `{}` changes no command",
        before.compensation.kind
    );
}

#[test]
fn every_number_of_the_paper_s_damping_acts() {
    let paper = test(Method::Paper);
    let each: [(&str, Change<Compensation>); 8] = [
        ("secant", |c| c.secant = Secant::Measured),
        ("gamma", |c| c.gamma = 0.3),
        ("window_steps", |c| c.window_steps = 8),
        ("delay_ms", |c| c.delay_ms = 2.0.into()),
        ("clamp", |c| c.clamp = 0.5),
        ("clamp_below", |c| c.clamp_below = Some(-0.5)),
        ("hold_share", |c| c.hold_share = 0.2),
        ("lead_steps", |c| c.lead_steps = 1.0),
    ];
    for (name, change) in each {
        acts(name, &paper, |config| change(&mut config.compensation));
    }
    // The guard of the mass acts where the damping would take more of it away than it allows.
    let mut light = paper;
    light.compensation.clamp_below = Some(-100.0);
    acts("least_mass", &light, |c| c.compensation.least_mass = 0.99);
}

#[test]
fn every_number_of_a_predictor_acts() {
    let each: [(&str, Method, Change<Compensation>); 16] = [
        ("delay_ms", Method::Lagrange, |c| c.delay_ms = 3.0.into()),
        ("order", Method::Lagrange, |c| c.order = 2),
        ("inverse", Method::FeedforwardFeedback, |c| {
            c.inverse = Some([0.003, 4e-6, 0.0]);
        }),
        ("feedback", Method::FeedforwardFeedback, |c| {
            c.feedback = 0.1
        }),
        ("time_s", Method::Afp, |c| c.adaptation.time_s = 0.5),
        ("floor_m", Method::Afp, |c| c.adaptation.floor_m = 0.02),
        ("longest_delay_ms", Method::Afp, |c| {
            c.adaptation.longest_delay_ms = 4.0;
        }),
        ("delay_rate_ms_per_s", Method::Afp, |c| {
            c.adaptation.delay_rate_ms_per_s = 0.1;
        }),
        ("gain_tolerance", Method::Afp, |c| {
            c.adaptation.gain_tolerance = 0.0
        }),
        ("smoothing_hz", Method::Ats, |c| {
            c.adaptation.smoothing_hz = 10.0
        }),
        ("tangent.motion_m", Method::Tangent, |c| {
            c.tangent.motion_m = 2e-3
        }),
        ("tangent.share", Method::Tangent, |c| c.tangent.share = 0.2),
        ("tangent.smoothing_ms", Method::Tangent, |c| {
            c.tangent.smoothing_ms = 2.0
        }),
        ("amb.gains", Method::Amb, |c| {
            c.amb.gains = [2e6, 2e4, 10.0, 0.1]
        }),
        ("amb.smoothing_hz", Method::Amb, |c| {
            c.amb.smoothing_hz = 10.0
        }),
        ("hydraulic", Method::Hydraulic, |c| {
            c.hydraulic = Some(Hydraulic::of_delay(0.003, STIFFNESS_N_PER_M));
        }),
    ];
    for (name, method, change) in each {
        acts(name, &test(method), |config| {
            change(&mut config.compensation)
        });
    }
}

#[test]
fn every_number_of_a_servo_hydraulic_actuator_acts() {
    let mut known = test(Method::Hydraulic);
    known.compensation.hydraulic = Some(Hydraulic::of_delay(0.004, STIFFNESS_N_PER_M));
    let each: [(&str, Change<Hydraulic>); 13] = [
        ("a1_b0", |h| h.a1_b0 *= 1.1),
        ("a2", |h| h.a2 *= 1.1),
        ("a3", |h| h.a3 = 1.0),
        ("b1", |h| h.b1 *= 1.1),
        ("b2", |h| h.b2 *= 1.1),
        ("mass_kg", |h| h.mass_kg *= 10.0),
        ("damping_n_s_per_m", |h| h.damping_n_s_per_m = 1000.0),
        ("stiffness_n_per_m", |h| h.stiffness_n_per_m *= 1.1),
        ("spread of stiffness", |h| h.spread[0] *= 2.0),
        ("spread of a3", |h| h.spread[1] *= 2.0),
        ("spread of b1", |h| h.spread[2] *= 2.0),
        ("spread of b2", |h| h.spread[3] *= 2.0),
        ("noise_m", |h| h.noise_m *= 2.0),
    ];
    for (name, change) in each {
        acts(name, &known, |config| {
            change(config.compensation.hydraulic.as_mut().unwrap());
        });
    }
}

#[test]
fn every_number_of_the_estimation_acts() {
    let mut low_pass = test(Method::Paper);
    low_pass.estimation.kind = Filter::LowPass;
    acts("cutoff_hz", &low_pass, |c| c.estimation.cutoff_hz = 50.0);

    let mut kalman = test(Method::Paper);
    kalman.estimation.kind = Filter::Kalman;
    let each: [(&str, Change<Estimation>); 8] = [
        ("delay_ms", |e| e.delay_ms = 2.0.into()),
        ("lag_ms", |e| e.lag_ms = 2.0.into()),
        ("lag_damping_ratio", |e| e.lag_damping_ratio = 0.5),
        ("displacement_noise_m", |e| e.displacement_noise_m = 1e-4),
        ("force_noise_n", |e| e.force_noise_n = 100.0),
        ("process_m_per_s2", |e| e.process_m_per_s2 = 1.0),
        ("stiffness_tolerance", |e| e.stiffness_tolerance = 0.01),
        ("stiffness_walk_per_s", |e| e.stiffness_walk_per_s = 0.5),
    ];
    for (name, change) in each {
        acts(name, &kalman, |config| change(&mut config.estimation));
    }
}

#[test]
fn every_number_of_the_pace_acts() {
    let mut paced = test(Method::Paper);
    paced.timing.substeps = 4;
    let each: [(&str, Change<Timing>); 3] = [
        ("time_scale", |t| t.time_scale = 2.0),
        ("substeps", |t| t.substeps = 2),
        ("solve_substeps", |t| t.solve_substeps = 2),
    ];
    for (name, change) in each {
        acts(name, &paced, |config| change(&mut config.timing));
    }
}

/// The flags of every step of eight seconds in which the transducer stands for a while, and how it ended.
fn told(config: &Config) -> (Vec<u32>, Option<Fault>) {
    let ground = common::shaking(8.0);
    let ground = GroundMotion::new(&ground, 0.01, config.model_step_s()).unwrap();
    let mut rig = Rig::new(8);
    let mut outer = common::started(config, &mut rig, &ground);
    let mut stands = Sample::new([0.0], [0.0]);
    let flags = (0..16_000).map(|k| {
        let sample = rig.sample();
        if !(4000..4060).contains(&k) {
            stands = sample;
        }
        let step = outer.step(&stands, &ground);
        rig.sent = step.command_m[0];
        step.record.flags
    });
    (flags.collect(), outer.trip().map(|t| t.fault))
}

/// Those of the board's own, `disagree_m` and `force_stands_m`, are held where they act, in the station.
// proves: limit.displacement_m, limit.increment_m, limit.velocity_m_per_s, limit.force_n, limit.tracking_m
// proves: limit.energy_warning, limit.energy_trip, limit.energy_floor_j, limit.stale_steps, limit.frozen_m
// proves: limit.locked_damping_ratio
#[test]
fn every_limit_acts() {
    let mut before = test(Method::None);
    before.limits.energy_warning = Some(0.05);
    let each: [(&str, Change<Limits>, Option<Fault>); 10] = [
        (
            "displacement_m",
            |l| l.displacement_m = Some(0.01),
            Some(Fault::Displacement),
        ),
        (
            "increment_m",
            |l| l.increment_m = Some(5e-5),
            Some(Fault::Increment),
        ),
        (
            "velocity_m_per_s",
            |l| l.velocity_m_per_s = Some(0.1),
            Some(Fault::Velocity),
        ),
        ("force_n", |l| l.force_n = Some(2000.0), Some(Fault::Force)),
        (
            "tracking_m",
            |l| l.tracking_m = Some(5e-4),
            Some(Fault::Tracking),
        ),
        ("energy_warning", |l| l.energy_warning = Some(0.2), None),
        (
            "energy_trip",
            |l| l.energy_trip = Some(0.1),
            Some(Fault::EnergyRatio),
        ),
        ("energy_floor_j", |l| l.energy_floor_j = Some(1e6), None),
        (
            "stale_steps",
            |l| l.stale_steps = Some(5),
            Some(Fault::StaleSample),
        ),
        ("frozen_m", |l| l.frozen_m = Some(5e-3), None),
    ];
    let (flags, ended) = told(&before);
    assert_eq!(ended, None);
    for (name, change, trips) in each {
        let mut after = before.clone();
        change(&mut after.limits);
        let (other, ended) = told(&after);
        assert_eq!(ended, trips, "{name}");
        assert!(flags != other, "{name} changes nothing");
    }
    let mut damped = test(Method::Paper);
    let (free, _) = told(&damped);
    damped.limits.locked_damping_ratio = Some(0.01);
    assert!(
        free != told(&damped).0,
        "locked_damping_ratio changes nothing"
    );
}
