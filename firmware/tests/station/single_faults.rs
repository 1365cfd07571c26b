//! Single faults of what is outside the board: each stands against arming, or trips a running test, before much has moved.

use crate::common::{Bench, bench, config, fresh, pulse};
use crate::{done, obstacle, trips};
use firmware::sim::CODES;
use link::Calibration;
use link::command::{Channel, Command, CommissioningSignal, SignalShape};
use link::reply::{NotReady, Obstacle, Reply};
use outerloop_core::{Config, Event, Fault, Mode};

/// Loaded, idle for a while, with something broken.
fn loaded(config: Config, harm: impl FnOnce(&mut Bench)) -> Bench {
    let mut b = bench();
    done(&b.ask(Command::Configure(config.into())));
    b.upload(&pulse(), 0.01);
    harm(&mut b);
    for _ in 0..300 {
        b.step();
    }
    b
}

// proves: fault.output, obstacle.fault by output_lost
#[test]
fn a_converter_that_lost_its_set_up_stands_against_arming_even_a_step_before() {
    let output = Some(Obstacle::Fault(Fault::Output));
    let mut b = loaded(config(), |b| b.hardware.broken.output_lost = true);
    assert_eq!(obstacle(b.event(Event::Arm)), output);
    let mut b = loaded(config(), |_| {});
    b.hardware.broken.output_lost = true;
    assert_eq!(obstacle(b.event(Event::Arm)), output, "asked inside Arm");
}

// proves: fault.output by dead_output
#[test]
fn a_command_that_reads_back_differently_stands_against_arming_and_trips() {
    let dead = |b: &mut Bench| {
        b.hardware.board.code = [2300];
        b.hardware.board.dead_output = Some(0);
    };
    let mut b = loaded(config(), dead);
    let output = Some(Obstacle::Fault(Fault::Output));
    assert_eq!(obstacle(b.event(Event::Arm)), output);
    trips(Fault::Output, 400, |b| {
        b.hardware.board.dead_output = Some(0)
    });
}

// proves: fault.deadline_missed by period_ticks
#[test]
fn a_sampling_timer_with_another_period_trips_in_the_first_one() {
    for (percent, is_seen) in [
        (250, true),
        (113, true),
        (110, false),
        (90, false),
        (80, true),
    ] {
        let other = |b: &mut Bench| {
            let ticks = &mut b.hardware.board.period_ticks;
            *ticks = *ticks / 100 * percent;
        };
        if is_seen {
            trips(Fault::DeadlineMissed, 1, other);
        } else {
            let mut b = bench();
            b.ready(config(), &pulse());
            other(&mut b);
            done(&b.event(Event::Start));
            for _ in 0..200 {
                b.step();
            }
            assert!(b.permit(), "{percent} %");
        }
    }
}

// proves: fault.disagree, limit.disagree_m by second_displacement_off
#[test]
fn two_displacements_that_disagree_stand_against_arming_and_trip() {
    let mut limited = config();
    limited.limits.disagree_m = Some(1e-3);
    let off = |b: &mut Bench| b.hardware.broken.second_displacement_off = 200;
    let mut b = loaded(limited.clone(), off);
    let disagree = Some(Obstacle::Fault(Fault::Disagree));
    assert_eq!(obstacle(b.event(Event::Arm)), disagree);
    let mut b = bench();
    b.ready(limited, &pulse());
    done(&b.event(Event::Start));
    off(&mut b);
    let steps = (0..100).position(|_| {
        b.step();
        !b.permit()
    });
    assert!(steps.is_some_and(|s| s < 10), "{steps:?}");
    b.step();
    assert_eq!(b.fault(), Some(Fault::Disagree));
    let mut b = loaded(config(), off);
    done(&b.event(Event::Arm));
}

// proves: fault.force_stands, limit.force_stands_m by dead_force
#[test]
fn a_dead_load_cell_trips_after_the_motion_that_the_test_allows_it() {
    // Without that limit the motion goes on to the end of its stroke.
    for (stands_m, fault) in [
        (Some(2e-3), Fault::ForceStands),
        (None, Fault::Displacement),
    ] {
        let mut limited = config();
        limited.limits.force_stands_m = stands_m;
        let mut b = bench();
        b.ready(limited, &pulse());
        b.hardware.broken.dead_force = Some(CODES.sensor_top / 2);
        done(&b.event(Event::Start));
        let mut most_m = 0.0_f32;
        for _ in 0..1500 {
            b.step();
            let line = Calibration::nominal(&CODES).displacement;
            let at_m = line.quantity(b.log.last().unwrap().step.displacement);
            most_m = most_m.max(at_m.abs());
            if b.mode() == Mode::Tripped {
                break;
            }
        }
        assert_eq!(b.fault(), Some(fault));
        assert_eq!(most_m < 3e-3, stands_m.is_some(), "{most_m}");
    }
}

#[test]
fn a_load_cell_that_stays_at_one_code_is_dead_wherever_it_stands() {
    // One that lives has noise, also where a specimen yields.
    for (noise, trips) in [(0_u16, true), (1, false)] {
        let mut limited = config();
        limited.limits.force_stands_m = Some(1e-3);
        let mut b = bench();
        b.ready(limited, &pulse());
        done(&b.event(Event::Start));
        for _ in 0..300 {
            b.step();
        }
        let stands = b.log.last().unwrap().step.force;
        assert!(
            stands.abs_diff(CODES.sensor_top / 2) > 40,
            "{stands}: it stands at zero"
        );
        for step in 0..1000_u16 {
            b.hardware.broken.dead_force = Some(stands + noise * (step % 2));
            b.step();
            if b.mode() == Mode::Tripped {
                break;
            }
        }
        assert_eq!(
            b.fault() == Some(Fault::ForceStands),
            trips,
            "{noise}: {:?}",
            b.fault()
        );
    }
}

// proves: fault.stale_sample
#[test]
fn a_dead_transducer_with_the_noise_of_its_converter_trips() {
    let mut b = bench();
    b.ready(config(), &pulse());
    done(&b.event(Event::Start));
    for _ in 0..200 {
        b.step();
    }
    let stands = b.log.last().unwrap().step;
    for step in 0.. {
        let noise = [0, 2, 0, 2, 2][step % 5];
        b.hardware.broken.codes = Some([stands.displacement + noise, stands.force + noise]);
        b.step();
        if !b.permit() {
            break;
        }
        assert!(step < 200, "nothing trips");
    }
    b.step();
    assert_eq!(b.fault(), Some(Fault::StaleSample));
}

// proves: obstacle.no_energy_trip
#[test]
fn a_test_that_integrates_is_not_armed_without_a_limit_of_its_energy_error() {
    let mut open = config();
    open.limits.energy_trip = None;
    let mut b = loaded(open, |_| {});
    let reply = b.event(Event::Arm);
    assert!(
        matches!(&reply, Reply::Refused(r) if r.is(NotReady::NoEnergyTrip)),
        "{reply:?}"
    );
}

#[test]
fn nothing_approaches_before_the_contact_behind_permit_has_closed() {
    let mut b = loaded(config(), |_| {});
    b.hardware.broken.chain = Some(false);
    done(&b.event(Event::Arm));
    let stood = b.code();
    for _ in 0..100 {
        b.step();
        assert!(b.permit() && b.mode() == Mode::Approaching);
        assert!(b.code().abs_diff(stood) <= 1, "it approaches");
    }
    b.hardware.broken.chain = None;
    for _ in 0..300 {
        b.step();
    }
    assert!(b.code().abs_diff(stood) > 10, "it does not approach");
}

/// What the load cell's converter shows of a force.
fn force_code(n: f32) -> u16 {
    let line = Calibration::nominal(&CODES).force;
    (n / line.per_code + line.zero_code) as u16
}

/// The reply to a start under a force that is read and stands.
fn started_under(b: &mut Bench, config: &Config, read_n: f32) -> Reply {
    b.ready(config.clone(), &pulse());
    b.hardware.broken.dead_force = Some(force_code(read_n));
    for _ in 0..300 {
        b.step();
    }
    b.event(Event::Start)
}

// proves: obstacle.strained by dead_force
#[test]
fn a_test_begins_under_no_force_that_moves_its_structure_and_a_preload_is_taken_out_by_zero() {
    let mut limited = config();
    (limited.limits.force_stands_m, limited.limits.force_n) = (Some(2e-3), Some(5000.0));
    // Half of 2 mm at 158 kN/m are 158 N.
    for (n, starts) in [
        (1000.0, false),
        (-1000.0, false),
        (190.0, false),
        (120.0, true),
    ] {
        let mut b = bench();
        let reply = started_under(&mut b, &limited, n);
        if starts {
            done(&reply);
            continue;
        }
        let Reply::Refused(refused) = reply else {
            panic!("{n} N: {reply:?}");
        };
        assert!(refused.is(NotReady::Strained), "{refused}");
        assert!((refused.value - f64::from(n)).abs() < 20.0, "{refused}");
        assert!(refused.accepted.contains("--zero force=0`"), "{refused}");
        assert_eq!(b.mode(), Mode::Armed);
        // What stands under a preload says so, and is started.
        done(&b.event(Event::Stop));
        b.until(Mode::Idle);
        let zero = Command::Zero {
            actuator: 0,
            channel: Channel::Force,
            value: 0.0,
        };
        let reply = b.ask(zero);
        assert!(matches!(reply, Reply::Zeroed { .. }), "{reply:?}");
        b.settle();
        done(&b.event(Event::Arm));
        b.until(Mode::Armed);
        for _ in 0..300 {
            b.step();
        }
        done(&b.event(Event::Start));
    }
    // A commissioning signal takes no force.
    let mut b = bench();
    done(&b.ask(Command::Configure(limited.into())));
    let signal = CommissioningSignal {
        actuator: 0,
        shape: SignalShape::Sine { frequency_hz: 5.0 },
        amplitude_m: 0.001,
        seconds: 1.0,
    };
    done(&b.ask(Command::Signal(Some(signal))));
    b.hardware.broken.dead_force = Some(force_code(1000.0));
    b.settle();
    done(&b.event(Event::Arm));
    b.until(Mode::Armed);
    done(&b.event(Event::Start));
}

/// The loop takes the force without what `[rig]` says of it, and so does what lets a test start.
#[test]
fn a_test_begins_under_the_force_that_its_loop_takes() {
    let mut limited = config();
    (limited.limits.force_stands_m, limited.limits.force_n) = (Some(2e-3), Some(5000.0));
    limited.rig.force_offset_n = [1000.0].into_iter().collect();
    limited.rig.force_gain = [1.25].into_iter().collect();
    // An offset that is not this cell's any more: the loop would have -800 N of a reading of none.
    for (read_n, starts) in [
        (0.0, false),
        (1000.0, true),
        (1150.0, true),
        (1250.0, false),
    ] {
        let mut b = bench();
        let reply = started_under(&mut b, &limited, read_n);
        if starts {
            done(&reply);
            continue;
        }
        let Reply::Refused(refused) = reply else {
            panic!("{read_n} N: {reply:?}");
        };
        assert!(refused.is(NotReady::Strained), "{refused}");
        let taken_n = f64::from(read_n - 1000.0) / 1.25;
        assert!((refused.value - taken_n).abs() < 20.0, "{refused}");
        assert!(
            refused
                .accepted
                .ends_with("rig.force_offset_n is not this cell's"),
            "{refused}"
        );
    }
}

#[test]
fn an_output_stays_where_it_is_until_a_sample_has_come() {
    let mut b = fresh();
    b.hardware.board.code = [3000];
    b.hardware.broken.no_sample = true;
    for _ in 0..300 {
        b.step();
    }
    assert_eq!(b.code(), 3000);
    b.hardware.broken.no_sample = false;
    for _ in 0..300 {
        b.step();
    }
    assert_ne!(b.code(), 3000, "it follows where the piston stands");
}

/// Over +-50 mm a code of the command is 24 um, over +-250 mm 122 um: half a millimetre is fewer codes there.
#[test]
fn a_command_that_reads_back_a_few_millimetres_off_over_a_long_stroke_is_seen() {
    for (half_m, codes_off, is_seen) in [
        (0.25, 18, true),
        (0.25, 14, false),
        (0.05, 24, true),
        (0.05, 18, false),
    ] {
        let mut b = bench();
        b.hardware.board.wired = [Calibration::over(half_m, 1e4, &CODES)];
        done(&b.ask(Command::Calibrate(0, b.hardware.board.wired[0])));
        b.settle();
        b.hardware.board.dead_output = Some(0);
        b.hardware.board.code = [b.code() + codes_off];
        for _ in 0..20 {
            b.step();
        }
        let mut coarse = config();
        coarse.limits.frozen_m = Some(1e-3);
        done(&b.ask(Command::Configure(coarse.into())));
        b.upload(&pulse(), 0.01);
        let output = Some(Obstacle::Fault(Fault::Output));
        let reply = b.event(Event::Arm);
        let stands = matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == output);
        assert_eq!(stands, is_seen, "{half_m} m, {codes_off} codes");
    }
}

/// Fault 21 stands against arming until the wrong number has been written again.
fn stands_against_arming_until(harm: impl FnOnce(&mut Bench), written: impl FnOnce(&mut Bench)) {
    let mut b = loaded(config(), harm);
    let memory = Some(Obstacle::Fault(Fault::Memory));
    assert_eq!(obstacle(b.event(Event::Arm)), memory);
    written(&mut b);
    for _ in 0..300 {
        b.step();
    }
    done(&b.event(Event::Arm));
}

// proves: fault.memory by turn_over_zero
#[test]
fn a_wrong_bit_in_a_calibration_trips_before_a_command_is_sent_by_it() {
    for (copy, bit) in [(0, 23), (1, 23), (0, 0), (1, 0)] {
        let harm = |b: &mut Bench| b.turn_over_zero(copy, bit);
        trips(Fault::Memory, 0, harm);
        stands_against_arming_until(harm, |b| {
            done(&b.ask(Command::Calibrate(0, Calibration::nominal(&CODES))));
        });
    }
}

// proves: fault.memory by spoil_motion
#[test]
fn a_ground_motion_that_is_laid_over_the_steps_in_another_way_trips() {
    for copy in [0, 1] {
        let harm = |b: &mut Bench| b.spoil_motion(copy);
        trips(Fault::Memory, 0, harm);
        stands_against_arming_until(harm, |b| b.upload(&pulse(), 0.01));
    }
}

/// Bit 22 of the zero makes half of the range three quarters of it, which a calibration may have.
#[test]
fn a_wrong_bit_in_what_the_tasks_keep_is_neither_sent_nor_saved_with_a_new_zero() {
    for copy in [0, 1] {
        let mut b = loaded(config(), |b| b.turn_over_zero_of_the_tasks(copy, 22));
        let memory = Some(Obstacle::Fault(Fault::Memory));
        let zero = Command::Zero {
            actuator: 0,
            channel: Channel::Force,
            value: 0.0,
        };
        assert_eq!(obstacle(b.ask(zero.clone())), memory);
        assert_eq!(obstacle(b.ask(Command::Save)), memory);
        done(&b.ask(Command::Calibrate(0, Calibration::nominal(&CODES))));
        assert!(matches!(b.ask(zero), Reply::Zeroed { .. }));
        done(&b.ask(Command::Save));
    }
}
