//! The monitor on the flashed image: sound tests run to their end, and tests in which something breaks are stopped before the
//! motion reaches 1.2 times the planned peak. The limits are those of the monitor survey.

use crate::desk::{Bench, Desk};
use emu::{InjectedFault, PlannedFault};
use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::summary::{Summary, TestVerdict};
use experiment::trace::Trace;
use host_tests::surveys::monitor::{DISPLACEMENT, ENERGY_TRIP, TOO_FAR, TRACKING};
use link::Calibration;
use outerloop_cli::board::limits::PlannedMotion;
use outerloop_cli::board::{BoardBench, Operator, calibrate};
use std::path::Path;

/// The built-in ground motion (whose pulse comes after 5 s) sped up by a factor, and its duration in s.
struct Shaking {
    faster: f64,
    seconds: f64,
}

const SHORT: Shaking = Shaking {
    faster: 3.0,
    seconds: 4.0,
};

/// Unchanged: its pulse is slower than the structure, so that a softer structure moves more.
const SLOW: Shaking = Shaking {
    faster: 1.0,
    seconds: 7.0,
};

/// A test of Table 1 with a declared delay of 3 ms.
const TEST: &str = "
[structure]
mass_kg = 1000
stiffness_n_per_m = 158e3
damping_ratio = 0.02
[loop]
rate_hz = 2000
[compensation]
window_steps = 10
delay_ms = 3
[excitation]
peak_response_mm = 20
[plant.actuator]
kind = 'delay'
";

/// The result of a test.
struct Ran {
    summary: Summary,
    /// Largest displacement as a multiple of the planned peak.
    motion: f64,
}

fn run(rig: &str, shaken: &Shaking, fault: Option<PlannedFault>) -> Ran {
    let text = format!("{TEST}{rig}");
    let test = TestFile::parse(&text, "monitor", Path::new(""), &[]).unwrap();
    let spec = test.plant.clone();
    let mut shaking = near_fault();
    shaking.interval_s /= shaken.faster;
    let mut experiment = Experiment::new(test, &shaking, Some(shaken.seconds)).unwrap();
    let ideal = experiment.ideal().unwrap();
    let (plan, peak_m) = (PlannedMotion::of(&experiment, &ideal), ideal.peaks_m()[0]);
    let limits = &mut experiment.test.config.limits;
    limits.displacement_m = Some(DISPLACEMENT * peak_m);
    limits.tracking_m = Some(TRACKING * (plan.velocity_m_per_s * plan.delay_s + 0.05 * peak_m));
    limits.energy_trip = Some(ENERGY_TRIP);
    let desk = Desk::with(Bench {
        plan: fault,
        rig: Some(spec),
        ..Bench::default()
    });
    let mut connection = desk.connection();
    calibrate(&mut connection, Calibration::nominal(&crate::desk::codes())).unwrap();
    let bench = BoardBench::new(connection, plan, Operator::not_asked());
    let method = experiment.test.config.compensation.kind;
    let run = experiment
        .run_on(&bench, method, &ideal, true, None::<Trace>)
        .unwrap();
    drop(bench);
    let farthest_m = desk
        .log()
        .position_m
        .iter()
        .fold(0.0_f64, |a, x| a.max(x.abs()));
    let ran = Ran {
        summary: run.summary,
        motion: farthest_m / peak_m,
    };
    println!(
        "{} {fault:?}: {:?} {:?}, {:.3} of the planned peak, eps_rms {:.4}",
        rig.replace('\n', " "),
        ran.summary.verdict,
        ran.summary.trip,
        ran.motion,
        ran.summary.eps_rms
    );
    let board = ran.summary.board.as_ref().unwrap();
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));
    ran
}

#[test]
fn sound_tests_run_to_their_end() {
    for rig in [
        "delay_ms = 2.4\n[plant.sensors]\ndisplacement_noise_mm = 0.02\nforce_noise_n = 5\n",
        "delay_ms = 3.6\n[plant.sensors]\ndisplacement_noise_mm = 0.02\nforce_noise_n = 5\n",
        "delay_ms = 3\n[plant.specimen]\nkind = 'bilinear'\nyield_mm = 15\nhardening_ratio = 0.5\n",
    ] {
        let ran = run(rig, &SHORT, None);
        assert_eq!(ran.summary.trip, None, "{rig}");
        assert_eq!(ran.summary.verdict, TestVerdict::Completed, "{rig}");
        assert!(ran.motion > 0.8, "{rig}: {}", ran.motion);
    }
}

#[test]
fn what_breaks_is_stopped_in_time() {
    let told = "delay_ms = 3\n[plant.sensors]\ndisplacement_noise_mm = 0.02\nforce_noise_n = 5\n";
    // The actuator is at 0: the approach takes no time, and after 1.5 s the pulse is on its way.
    let late = |fault| PlannedFault {
        after_steps: 3000,
        fault,
    };
    let soft = PlannedFault {
        after_steps: 0,
        fault: InjectedFault::Stiffness { percent: 40 },
    };
    for (shaken, fault) in [
        (SHORT, late(InjectedFault::LateBy(100))),
        (SHORT, late(InjectedFault::Gain { percent: 150 })),
        (SHORT, late(InjectedFault::FrozenSensor)),
        (SLOW, soft),
    ] {
        let ran = run(told, &shaken, Some(fault));
        assert_eq!(ran.summary.verdict, TestVerdict::Tripped, "{fault:?}");
        assert!(ran.motion < TOO_FAR, "{fault:?}: {}", ran.motion);
    }
}
