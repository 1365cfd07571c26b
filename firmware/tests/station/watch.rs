//! What the rig watch of a board is told, and what it says.

use crate::common::{Bench, Spring, bench, config, pulse, started};
use firmware::sim::{self, CODES};
use firmware::step_time::CORRECTION_CYCLES;
use link::Calibration;
use link::command::Command;
use link::reply::{Obstacle, Reply};
use link::status::WatchStatus;
use link::telemetry::digest;
use outerloop_core::watch::{
    Actions, Cause, Corrections, Declared, DeclaredActuator, Instructions, State,
};
use outerloop_core::watch::{Watch, judge};
use outerloop_core::{Design, Event, GroundMotion, InPlace, Mode, OuterLoop, Sample, flag};

/// The spring behind its actuator, as declared.
fn instructions() -> Instructions {
    Instructions {
        declared: Declared {
            rate_hz: 2000.0,
            omega_rad_per_s: 12.6,
            peak_m: 0.01,
            stiffness_n_per_m: 158e3,
            stiffness_tolerance: 0.02,
            actuator: DeclaredActuator {
                gain: 1.0,
                delay_s: 0.0,
                lag_s: 4e-3,
                offset_m: 0.0,
                tolerances: [5e-3, 5e-4, 1e-4],
            },
            alone: true,
            has_actuator: true,
            has_specimen: true,
            elastic: true,
            damping_n_s_per_m: 0.0,
            mass_kg: 0.0,
            specimen_tolerances: [0.0; 3],
            force_gain: 1.0,
            force_offset_n: 0.0,
            noise: [0.0; 2],
        },
        actions: Actions {
            hold: true,
            trip: true,
            correct: Corrections {
                lateness: true,
                ..Corrections::default()
            },
            error_limit: None,
        },
    }
}

fn status(b: &mut Bench) -> Option<WatchStatus> {
    match b.ask(Command::Status) {
        Reply::Status(status) => status.watch,
        other => panic!("{other:?}"),
    }
}

fn done(reply: &Reply) -> u32 {
    match reply {
        Reply::Done { tick, .. } => *tick,
        other => panic!("{other:?}"),
    }
}

// proves: command.watch
#[test]
fn the_watch_is_told_in_turn_of_the_test_in_force_while_idle() {
    let mut b = bench();
    let good = || Command::Watch(0, instructions());
    let Reply::Rejected { obstacle, .. } = b.ask(good()) else {
        panic!("without a test");
    };
    assert_eq!(obstacle, Some(Obstacle::NotConfigured));
    done(&b.ask(Command::Configure(config().into())));
    assert_eq!(status(&mut b), None);
    let with = |change: fn(&mut Declared)| {
        let mut told = instructions();
        change(&mut told.declared);
        Command::Watch(0, told)
    };
    for (wrong, name) in [
        (Command::Watch(1, instructions()), "actuator"),
        (with(|d| d.rate_hz = 1000.0), "watch: rate_hz"),
        (with(|d| d.peak_m = 0.0), "peak_m"),
        (with(|d| d.noise[1] = f64::NAN), "tolerance or noise"),
    ] {
        let Reply::Refused(refused) = b.ask(wrong) else {
            panic!("{name} is accepted");
        };
        assert_eq!(refused.name, name);
        assert_eq!(status(&mut b), None);
    }
    done(&b.ask(good()));
    let said = status(&mut b).expect("it is watched");
    assert_eq!((said.state, said.blocks), (State::Sound, 0));
    // One watch an actuator.
    assert!(matches!(b.ask(good()), Reply::Refused(r) if r.name == "watch: actuator"));
    // Another test is watched by nobody, until somebody says so.
    b.ready(config(), &pulse());
    assert_eq!(status(&mut b), None);
    done(&b.event(Event::Start));
    assert!(matches!(b.ask(good()), Reply::Rejected { .. }), "not idle");
}

#[test]
fn a_correction_is_refused_where_a_step_leaves_no_time_for_it() {
    // A step takes no time: all of the deadline is left.
    let most = CORRECTION_CYCLES;
    for (deadline_ticks, refused_with) in [(most - 1, Some(f64::from(most - 1))), (most, None)] {
        let mut found = sim::Bench::<Spring>::well("sim");
        (found.clock.deadline_ticks, found.clock.correction_ticks) = (deadline_ticks, most);
        let mut b = started(found);
        done(&b.ask(Command::Calibrate(0, Calibration::nominal(&CODES))));
        done(&b.ask(Command::Configure(config().into())));
        let said = match b.ask(Command::Watch(0, instructions())) {
            Reply::Refused(refused) => {
                assert_eq!(refused.name, "watch.correct");
                assert!(refused.accepted.contains(&most.to_string()), "{refused:?}");
                Some(refused.value)
            }
            _ => None,
        };
        assert_eq!(said, refused_with);
        let mut looks_on = instructions();
        looks_on.actions.correct = Corrections::default();
        done(&b.ask(Command::Configure(config().into())));
        done(&b.ask(Command::Watch(0, looks_on)));
    }
}

/// The loop on the PC with a watch of its own, fed with the board's codes, in steps from the test's `since` on; the board was `told` to
/// watch it. Every step has the same bits. How many blocks were judged, and how many steps corrected.
fn worked_out_again(
    b: &Bench,
    instructions: &Instructions,
    points: &[f32],
    [since, told]: [u32; 2],
    events: &[(u32, Event)],
) -> [u32; 2] {
    let calibration = Calibration::nominal(&CODES);
    let ground = GroundMotion::new(points, 0.01, config().model_step_s()).unwrap();
    let mut outer = OuterLoop::<1>::new(Design::new(&config()).unwrap());
    let mut in_place = InPlace::beside(&outer);
    let mut watch = [Watch::new(instructions).unwrap()];
    let [mut judged, mut adjusted] = [0; 2];
    for report in b.log.iter().filter(|r| r.tick >= since) {
        if report.tick == told {
            outer.watch(true);
        }
        for (_, event) in events.iter().filter(|(tick, _)| *tick == report.tick) {
            outer.handle(*event).unwrap();
            if *event == Event::Arm {
                watch = [Watch::new(instructions).unwrap()];
            }
        }
        let displacement_m = calibration.displacement.quantity(report.step.displacement);
        let force_n = calibration.force.quantity(report.step.force);
        let mut sample = Sample::new([displacement_m], [force_n]);
        sample.chain_open = report.step.flags & flag::CHAIN_OPEN != 0;
        let record = outer.step(&sample, &ground).record;
        assert_eq!(digest(record), report.step.digest, "step {}", report.tick);
        adjusted += u32::from(record.flags & flag::ADJUSTED != 0);
        judged += u32::from(in_place.judge(&mut outer, |blocks, orders| {
            judge(watch.iter_mut(), blocks, orders)
        }));
    }
    [judged, adjusted]
}

#[test]
fn a_watched_test_is_worked_out_again_bit_for_bit_and_once_more_after_it() {
    let mut b = bench();
    let since = done(&b.ask(Command::Configure(config().into())));
    let told = done(&b.ask(Command::Watch(0, instructions())));
    b.upload(&pulse(), 0.01);
    let mut events = Vec::new();
    for _ in 0..2 {
        for _ in 0..300 {
            b.step();
        }
        events.push((done(&b.event(Event::Arm)), Event::Arm));
        b.until(Mode::Armed);
        events.push((done(&b.event(Event::Start)), Event::Start));
        // Not a whole number of blocks.
        for _ in 0..403 {
            b.step();
        }
        events.push((done(&b.event(Event::Hold)), Event::Hold));
        b.until(Mode::Holding);
        events.push((done(&b.event(Event::Start)), Event::Start));
        b.until(Mode::Finished);
        let said = status(&mut b).expect("it is watched");
        assert_eq!(said.state, State::Sound, "{said:?}");
        events.push((done(&b.event(Event::Clear)), Event::Clear));
    }
    let said = status(&mut b).expect("it is watched");
    assert!(said.blocks > 900, "{said:?}");

    let [judged, _] = worked_out_again(&b, &instructions(), &pulse(), [since, told], &events);
    assert_eq!(judged, said.blocks);
}

/// Tasks that are longer away than an answer may take end the watch of the test, and the records say so; the next test has its own.
#[test]
fn tasks_that_come_too_late_end_the_watch_of_the_test_and_of_no_other() {
    let late = |b: &Bench| b.log.last().unwrap().step.flags & flag::WATCH_LATE != 0;
    for (away, is_late) in [(24, false), (60, true)] {
        let mut b = bench();
        done(&b.ask(Command::Configure(config().into())));
        done(&b.ask(Command::Watch(0, instructions())));
        b.upload(&pulse(), 0.01);
        for expected in [is_late, false] {
            for _ in 0..300 {
                b.step();
            }
            done(&b.event(Event::Arm));
            b.until(Mode::Armed);
            done(&b.event(Event::Start));
            for _ in 0..200 {
                b.step();
            }
            if expected == is_late {
                b.step_without_tasks(if expected { away } else { 24 });
            }
            b.until(Mode::Finished);
            assert_eq!(late(&b), expected, "{away} steps");
            done(&b.event(Event::Clear));
        }
    }
}

/// The loop on the PC that is told what the board was told has the same bits while the board corrects.
#[test]
fn a_test_that_is_corrected_is_worked_out_again_bit_for_bit() {
    let mut b = bench();
    let since = done(&b.ask(Command::Configure(config().into())));
    let mut instructions = instructions();
    // The actuator goes 8 % further than that, and the command is divided by it.
    instructions.declared.actuator.gain = 1.0 / 1.08;
    instructions.actions.correct.gain = true;
    let told = done(&b.ask(Command::Watch(0, instructions.clone())));
    let sways: Vec<f32> = (0..600).map(|i| 0.06 * (0.126 * i as f32).sin()).collect();
    b.upload(&sways, 0.01);
    for _ in 0..300 {
        b.step();
    }
    let mut events = vec![(done(&b.event(Event::Arm)), Event::Arm)];
    b.until(Mode::Armed);
    events.push((done(&b.event(Event::Start)), Event::Start));
    b.until(Mode::Finished);
    let [_, adjusted] = worked_out_again(&b, &instructions, &sways, [since, told], &events);
    assert!(adjusted > 1000, "{adjusted} steps were corrected");
}

#[test]
fn what_is_named_can_be_told_with_its_value() {
    let mut b = bench();
    done(&b.ask(Command::Configure(config().into())));
    let mut told = instructions();
    // The actuator goes 8 % further than that.
    told.declared.actuator.gain = 1.0 / 1.08;
    done(&b.ask(Command::Watch(0, told)));
    // At the structure's frequency: some millimetres.
    let sways: Vec<f32> = (0..600).map(|i| 0.06 * (0.126 * i as f32).sin()).collect();
    b.upload(&sways, 0.01);
    for _ in 0..300 {
        b.step();
    }
    done(&b.event(Event::Arm));
    b.until(Mode::Armed);
    done(&b.event(Event::Start));
    assert_eq!(
        (b.service.watch_state(), b.service.named().count()),
        (State::Sound, 0)
    );
    b.until(Mode::Finished);
    assert_eq!(b.service.watch_state(), State::Named);
    let gain = b
        .service
        .named()
        .find(|named| named.cause == Cause::ActuatorGain);
    let gain = gain.expect("the actuator's gain");
    assert_eq!(gain.actuator, 1);
    assert!((gain.value - 0.08).abs() < 0.01, "{gain:?}");
}
