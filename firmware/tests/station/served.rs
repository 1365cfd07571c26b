//! A board that goes where the PC sends it.

use crate::common::{Bench, bench, config, pulse};
use firmware::sim::CODES;
use link::Calibration;
use link::command::Command;
use link::reply::{Obstacle, Reply};
use link::telemetry::digest;
use outerloop_core::{Config, Design, Event, GroundMotion, Mode, OuterLoop, Pace, Sample, flag};

fn done(reply: &Reply) -> u32 {
    match reply {
        Reply::Done { tick, .. } => *tick,
        other => panic!("{other:?}"),
    }
}

fn target(target_m: f32) -> Command {
    Command::Target([target_m].into_iter().collect())
}

/// A target every 20 control steps, 12 of them for the model.
fn continuous() -> Config {
    let mut config = config();
    (config.timing.substeps, config.timing.solve_substeps) = (20, 12);
    config
}

/// Configured for targets from the PC, and armed.
fn armed(config: Config, pace: Pace) -> (Bench, u32, u32) {
    let mut b = bench();
    let since = done(&b.ask(Command::Configure(config.into())));
    done(&b.ask(Command::Pace(Some(pace))));
    for _ in 0..300 {
        b.step();
    }
    let at = done(&b.event(Event::Arm));
    while b.log.last().unwrap().step.command_m != 0.0 {
        b.step();
    }
    (b, since, at)
}

/// Every step again, fed with the board's codes and the events at the steps at which it took them; the targets of the
/// observations and the forces that they are answered with.
fn again(
    b: &Bench,
    config: &Config,
    pace: Pace,
    since: u32,
    told: &[(u32, Result<Event, f32>)],
) -> Vec<(f32, f32)> {
    let mut outer = OuterLoop::<1>::new(Design::new(config).unwrap());
    outer.set_pace(Some(pace));
    let calibration = Calibration::nominal(&CODES);
    let mut answers = Vec::new();
    for report in b.log.iter().filter(|r| r.tick >= since) {
        for (_, told) in told.iter().filter(|(tick, _)| *tick == report.tick) {
            match told {
                Ok(event) => drop(outer.handle(*event).unwrap()),
                Err(target_m) => outer.set_next_target([*target_m]),
            }
        }
        let mut sample = Sample::new(
            [calibration.displacement.quantity(report.step.displacement)],
            [calibration.force.quantity(report.step.force)],
        );
        sample.chain_open = report.step.flags & flag::CHAIN_OPEN != 0;
        let record = *outer.step(&sample, &GroundMotion::none()).record;
        assert_eq!(digest(&record), report.step.digest, "tick {}", report.tick);
        if record.has(flag::SOLVED) {
            answers.push((record.command_m[0], outer.answer_n()[0]));
        }
    }
    answers
}

// proves: command.target
#[test]
fn continuous_targets_are_passed_and_answered_and_every_step_is_worked_out_again_bit_for_bit() {
    let config = continuous();
    let (mut b, since, at) = armed(config.clone(), Pace::Continuous);
    let mut told = vec![(at, Ok(Event::Arm))];
    let targets: Vec<f32> = (1..=40).map(|i| 0.005 * (i as f32 * 0.15).sin()).collect();
    for (place, target_m) in targets.iter().enumerate() {
        let tick = done(&b.ask(target(*target_m)));
        told.push((tick, Err(*target_m)));
        if place == 0 {
            told.push((done(&b.event(Event::Start)), Ok(Event::Start)));
        }
        let until = b.log.len() + 400;
        while b.log.len() < until {
            b.step();
            if b.log.last().unwrap().step.flags & flag::SOLVED != 0 && place > 0 {
                break;
            }
            if place == 0 && b.mode() == Mode::Running {
                break;
            }
        }
    }
    told.push((done(&b.event(Event::Stop)), Ok(Event::Stop)));
    b.until(Mode::Finished);
    told.push((done(&b.event(Event::Clear)), Ok(Event::Clear)));
    b.step();
    assert!(!b.permit());
    let answers = again(&b, &config, Pace::Continuous, since, &told);
    assert!(answers.len() > 30, "{} targets were passed", answers.len());
    // The rest is answered with rest; then the specimen's force at the target, within the lag of its actuator and its codes.
    let largest = answers.iter().fold(0.0_f32, |m, a| m.max(a.1.abs()));
    assert!((600.0..1000.0).contains(&largest), "{largest} N");
}

#[test]
fn a_target_of_stop_and_go_is_gone_to_at_the_speed_of_the_approach_and_stood_at() {
    let config = config();
    let (mut b, since, at) = armed(config.clone(), Pace::StopAndGo);
    let target = done(&b.ask(target(0.004)));
    let start = done(&b.event(Event::Start));
    let mut steps = 0;
    while b.log.last().unwrap().step.command_m != 0.004 {
        b.step();
        steps += 1;
        assert!(steps < 10_000, "it never comes there");
    }
    // 4 mm at 2 mm/s and 2 kHz.
    assert!((3900..4100).contains(&steps), "{steps}");
    for _ in 0..100 {
        b.step();
    }
    assert_eq!(b.mode(), Mode::Running, "it stands, and waits");
    let told = [
        (at, Ok(Event::Arm)),
        (target, Err(0.004)),
        (start, Ok(Event::Start)),
    ];
    again(&b, &config, Pace::StopAndGo, since, &told);
}

// proves: command.pace, command.target, obstacle.nothing_to_run
#[test]
fn what_the_pc_sends_in_vain_is_refused_and_moves_nothing() {
    let (mut b, ..) = armed(config(), Pace::StopAndGo);
    for target_m in [f32::NAN, f32::INFINITY] {
        let reply = b.ask(target(target_m));
        assert!(matches!(reply, Reply::Refused(_)), "{reply:?}");
    }
    // One for each actuator, and the board has one.
    for targets in [&[][..], &[0.001, 0.002]] {
        let reply = b.ask(Command::Target(targets.iter().copied().collect()));
        let Reply::Refused(refused) = &reply else {
            panic!("{reply:?}");
        };
        assert_eq!(refused.name, "targets");
    }
    // The pace is changed only while idle.
    let reply = b.ask(Command::Pace(None));
    assert!(matches!(reply, Reply::Rejected { .. }), "{reply:?}");
    // A target beyond the limit trips on its way, and PERMIT is low.
    done(&b.ask(target(0.5)));
    done(&b.event(Event::Start));
    b.until(Mode::Tripped);
    assert!(!b.permit());
    // Another test integrates by itself again: it needs something to run.
    let mut b = bench();
    done(&b.ask(Command::Configure(config().into())));
    done(&b.ask(Command::Pace(Some(Pace::StopAndGo))));
    done(&b.ask(Command::Configure(config().into())));
    match b.event(Event::Arm) {
        Reply::Rejected { obstacle, .. } => assert_eq!(obstacle, Some(Obstacle::NothingToRun)),
        other => panic!("{other:?}"),
    }
    // And a test on a ground motion is not disturbed by a stray target.
    b.hardware.board.plant.position_m = 0.003;
    b.ready(config(), &pulse());
    done(&b.ask(target(0.5)));
    done(&b.event(Event::Start));
    for _ in 0..200 {
        b.step();
    }
    assert_eq!(b.mode(), Mode::Running);
}
