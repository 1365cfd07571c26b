//! What an operator sees: arming, running, holding, tripping, clearing.
#![allow(missing_docs)]

mod common;

use common::{Rig, ground, shaking, started, table1};
use outerloop_core::{
    Design, Event, Fault, GroundMotion, HISTORY, Method, Mode, OBSTACLE_STEPS, OuterLoop, Sample,
    flag,
};

const RECORD_S: f64 = 6.0;

#[test]
fn arming_moves_nothing_and_the_approach_is_slow() {
    let points = shaking(RECORD_S);
    let config = table1();
    let mut outer = OuterLoop::<1>::new(Design::new(&config).unwrap());
    let mut position = 0.004_f32;
    for _ in 0..100 {
        let step = outer.step(&Sample::new([position], [0.0]), &ground(&points));
        assert!(!step.permit && (step.command_m[0] - position).abs() < 1e-9);
    }
    outer.handle(Event::Arm).unwrap();
    let early = outer.handle(Event::Start).unwrap_err();
    assert_eq!((early.mode, early.event), (Mode::Approaching, Event::Start));
    let mut steps = 0;
    while position != 0.0 {
        let step = outer.step(&Sample::new([position], [0.0]), &ground(&points));
        assert!(
            step.permit && (step.command_m[0] - position).abs() < 1.01e-6,
            "2 mm/s is 1 um a step"
        );
        position = step.command_m[0];
        steps += 1;
        assert!(steps < 5000);
    }
    assert_eq!(outer.handle(Event::Start), Ok(Mode::Running));
}

#[test]
fn with_offsets_and_gains_the_actuator_itself_stays_where_it_is_and_then_comes_to_zero() {
    let points = shaking(RECORD_S);
    let mut config = table1();
    let only = |x: f64| [x].into_iter().collect();
    config.rig.command_gain = only(1.25);
    config.rig.command_offset_m = only(0.002);
    config.rig.displacement_gain = only(0.8);
    config.rig.displacement_offset_m = only(0.003);
    // The actuator is where its command puts it; its transducer has errors of its own.
    let moved = |command_m: f32| 1.25 * command_m + 0.002;
    let read = |position_m: f32| 0.8 * position_m + 0.003;
    let mut outer = OuterLoop::<1>::new(Design::new(&config).unwrap());
    let mut position = 0.004_f32;
    for _ in 0..100 {
        let step = outer.step(&Sample::new([read(position)], [0.0]), &ground(&points));
        let would_be = moved(step.command_m[0]);
        assert!(!step.permit && (would_be - position).abs() < 1e-8);
    }
    outer.handle(Event::Arm).unwrap();
    for _ in 0..5000 {
        let step = outer.step(&Sample::new([read(position)], [0.0]), &ground(&points));
        let next = moved(step.command_m[0]);
        assert!((next - position).abs() < 1.01e-6, "2 mm/s is 1 um a step");
        position = next;
    }
    assert!(position.abs() < 1e-8, "{position} m from the start");
    assert_eq!(outer.handle(Event::Start), Ok(Mode::Running));
    let step = outer.step(&Sample::new([read(position)], [0.0]), &ground(&points));
    assert!((moved(step.command_m[0]) - position).abs() < 1e-5);
}

#[test]
fn a_record_ends_in_a_hold_and_a_clear() {
    let points = shaking(RECORD_S);
    let mut rig = Rig::new(8);
    let mut outer = started(&table1(), &mut rig, &ground(&points));
    let mut steps = 0;
    while outer.mode() == Mode::Running {
        rig.step(&mut outer, &ground(&points));
        steps += 1;
    }
    assert_eq!(
        (outer.mode(), steps),
        (Mode::Finished, ground(&points).steps() + 1)
    );
    let mut last = [rig.sent; 2];
    for _ in 0..2000 {
        let now = rig.step(&mut outer, &ground(&points)).command_m[0];
        let bump = (now - last[1]) - (last[1] - last[0]);
        assert!(
            last[0] == last[1] || bump.abs() < 1.3e-6,
            "5 m/s^2 is 1.25 um a step squared: {bump:e}"
        );
        last = [last[1], now];
    }
    assert_eq!(last[0], last[1]);
    assert_eq!(outer.handle(Event::Clear), Ok(Mode::Idle));
}

#[test]
fn a_hold_in_mid_test_costs_time_and_nothing_else() {
    let points = shaking(RECORD_S);
    let peak = |hold: bool| {
        let mut rig = Rig::new(0);
        let mut outer = started(&table1(), &mut rig, &ground(&points));
        let mut solved = Vec::new();
        for i in 0..400_000 {
            if hold && i == 3000 {
                outer.handle(Event::Hold).unwrap();
            }
            if hold && i == 6000 {
                outer.handle(Event::Start).unwrap();
            }
            let record = rig.step(&mut outer, &ground(&points)).record;
            if record.has(flag::SOLVED) {
                solved.push(record.command_m[0]);
            }
            if outer.mode() == Mode::Finished {
                return solved;
            }
        }
        panic!("the test did not finish");
    };
    let (straight, held) = (peak(false), peak(true));
    assert_eq!(
        straight, held,
        "with an ideal actuator a hold changes no bit of the motion"
    );
}

/// A second hold on the way back from a first: the ramp begins where the command is, and every mode shows in the record.
#[test]
fn the_way_back_after_a_hold_can_be_held_without_a_jump() {
    let points = shaking(RECORD_S);
    for method in [Method::Paper, Method::Tangent] {
        let mut config = table1();
        config.compensation.kind = method;
        config.timing.approach_m_per_s = 0.02;
        let mut rig = Rig::new(8);
        let mut outer = started(&config, &mut rig, &ground(&points));
        let mut modes = vec![outer.mode()];
        let (mut last, mut last_step, mut largest) = (0.0_f32, 0.0_f32, 0.0_f32);
        for i in 0..30_000 {
            match i {
                3000 => drop(outer.handle(Event::Hold).unwrap()),
                5000 => drop(outer.handle(Event::Start).unwrap()),
                5100 => assert_eq!(outer.handle(Event::Hold), Ok(Mode::Holding)),
                7000 => drop(outer.handle(Event::Start).unwrap()),
                _ => {}
            }
            let record = rig.step(&mut outer, &ground(&points)).record;
            let mode = Mode::from_code(record.flags & 0xf).unwrap();
            if modes.last() != Some(&mode) {
                modes.push(mode);
            }
            let step = rig.sent - last;
            // Between the two holds: what the ramp of 5 m/s^2 at 2 kHz and the start of the way back change.
            if (5000..7000).contains(&i) {
                largest = largest.max((step - last_step).abs());
            }
            (last, last_step) = (rig.sent, step);
        }
        assert!(largest <= 1.002e-5, "{method}: {largest} m a step and step");
        let mut expected = vec![
            Mode::Running,
            Mode::Holding,
            Mode::Returning,
            Mode::Holding,
            Mode::Returning,
            Mode::Resuming,
            Mode::Running,
            Mode::Finished,
        ];
        expected.retain(|&m| m != Mode::Resuming || method == Method::Tangent);
        assert_eq!(modes, expected, "{method}");
    }
}

// proves: fault.force, limit.force_n
#[test]
fn the_first_fault_is_latched_with_the_last_steps_and_needs_a_clear() {
    let points = shaking(RECORD_S);
    let mut config = table1();
    config.limits.force_n = Some(20_000.0);
    let mut rig = Rig::new(8);
    let mut outer = started(&config, &mut rig, &ground(&points));
    for _ in 0..2000 {
        rig.step(&mut outer, &ground(&points));
    }
    let before = rig.sent;
    let mut sample = rig.sample();
    sample.force_n = [25_000.0];
    let step = outer.step(&sample, &ground(&points));
    assert_eq!(step.command_m[0], before, "the command stands where it was");
    assert!(!step.permit);
    let trip = outer.trip().unwrap();
    assert_eq!(
        (trip.fault, trip.value, trip.limit),
        (Fault::Force, 25_000.0, 20_000.0)
    );
    // A second fault changes nothing.
    sample.fault = Some(Fault::EmergencyStop);
    outer.step(&sample, &ground(&points));
    assert_eq!(outer.trip(), Some(trip));
    let last: Vec<_> = outer.history().map(|r| r.tick).collect();
    assert_eq!(last.len(), HISTORY);
    assert_eq!(last.last(), Some(&trip.tick));
    assert!(last.windows(2).all(|w| w[1] == w[0] + 1));
    assert!(outer.handle(Event::Start).is_err() && outer.handle(Event::Arm).is_err());
    assert_eq!(outer.handle(Event::Clear), Ok(Mode::Idle));
    assert_eq!(outer.trip(), None);
}

// proves: fault.adc_rail, fault.deadline_missed, fault.link_lost, fault.emergency_stop
#[test]
fn every_fault_of_the_board_trips_and_an_obstacle_forbids_arming() {
    let points = shaking(RECORD_S);
    for fault in [
        Fault::AdcRail,
        Fault::DeadlineMissed,
        Fault::LinkLost,
        Fault::EmergencyStop,
    ] {
        let mut rig = Rig::new(8);
        let mut outer = started(&table1(), &mut rig, &ground(&points));
        for _ in 0..500 {
            rig.step(&mut outer, &ground(&points));
        }
        let mut sample = rig.sample();
        sample.fault = Some(fault);
        outer.step(&sample, &ground(&points));
        assert_eq!(outer.trip().map(|t| t.fault), Some(fault));
        while outer.mode() == Mode::Stopping {
            outer.step(&sample, &ground(&points));
        }
        outer.handle(Event::Clear).unwrap();
        outer.step(&sample, &ground(&points));
        assert_eq!(outer.handle(Event::Arm).unwrap_err().obstacle, Some(fault));
        let good = rig.sample();
        for _ in 1..OBSTACLE_STEPS {
            outer.step(&good, &ground(&points));
            assert_eq!(outer.handle(Event::Arm).unwrap_err().obstacle, Some(fault));
        }
        // The loop that takes its place knows of it, too.
        let mut next = outer.clone();
        next.configure(Design::new(&table1()).unwrap()).unwrap();
        next.step(&good, &ground(&points));
        next.take_over(outer.obstacle(), outer.last_test());
        assert_eq!(next.handle(Event::Arm).unwrap_err().obstacle, Some(fault));
        outer.step(&good, &ground(&points));
        assert_eq!(outer.handle(Event::Arm), Ok(Mode::Approaching));
    }
}

// proves: fault.link_lost
#[test]
fn a_fault_that_is_no_emergency_ends_on_the_ramp_and_permit_falls_when_the_command_stands() {
    let points = shaking(RECORD_S);
    for kind in [Method::Paper, Method::None] {
        let mut config = table1();
        config.compensation.kind = kind;
        let mut rig = Rig::new(8);
        let mut outer = started(&config, &mut rig, &ground(&points));
        let (mut speed, mut steps) = (0.0_f32, 0);
        while speed < 2e-5 || steps < 1000 {
            let before = rig.sent;
            rig.step(&mut outer, &ground(&points));
            (speed, steps) = ((rig.sent - before).abs(), steps + 1);
        }
        let mut ramp = 0;
        loop {
            let mut sample = rig.sample();
            sample.fault = Some(Fault::LinkLost);
            let before = rig.sent;
            let step = outer.step(&sample, &ground(&points));
            let (permit, now) = (step.permit, step.command_m[0]);
            rig.sent = now;
            if !permit {
                assert_eq!(now, before, "it stands");
                break;
            }
            let slower = (now - before).abs();
            // The first is the test's own next step.
            assert!(ramp == 0 || slower < speed, "{slower} after {speed}");
            (speed, ramp) = (slower, ramp + 1);
        }
        assert!(ramp > 10, "{ramp} steps");
        let trip = outer.trip().unwrap();
        assert_eq!((outer.mode(), trip.fault), (Mode::Tripped, Fault::LinkLost));
        // The history ends with the step of the fault, and not with the ramp.
        assert_eq!(outer.history().last().unwrap().tick, trip.tick);
    }
}

#[test]
fn an_emergency_drops_permit_at_once_also_on_the_ramp_and_beside_what_is_none() {
    let points = shaking(RECORD_S);
    let mut rig = Rig::new(8);
    let mut outer = started(&table1(), &mut rig, &ground(&points));
    for _ in 0..2000 {
        rig.step(&mut outer, &ground(&points));
    }
    let mut sample = rig.sample();
    sample.fault = Some(Fault::LinkLost);
    assert!(outer.step(&sample, &ground(&points)).permit);
    assert_eq!(outer.mode(), Mode::Stopping);
    for event in [Event::Start, Event::Hold, Event::Stop, Event::Clear] {
        assert!(outer.handle(event).is_err(), "{event:?}");
    }
    sample.fault = Some(Fault::EmergencyStop);
    assert!(!outer.step(&sample, &ground(&points)).permit);
    assert_eq!(outer.trip().unwrap().fault, Fault::LinkLost);

    let mut limited = table1();
    limited.limits.force_n = Some(20_000.0);
    let mut rig = Rig::new(8);
    let mut outer = started(&limited, &mut rig, &ground(&points));
    let mut sample = rig.sample();
    (sample.force_n, sample.fault) = ([25_000.0], Some(Fault::LinkLost));
    assert!(!outer.step(&sample, &ground(&points)).permit);
    assert_eq!(outer.trip().unwrap().fault, Fault::Force);
}

#[test]
fn a_loop_that_has_seen_no_sample_is_not_armed() {
    let mut outer = OuterLoop::<1>::new(Design::new(&table1()).unwrap());
    let unseen = outer.handle(Event::Arm).unwrap_err();
    assert_eq!(unseen.obstacle, Some(Fault::StaleSample));
    // Nor does it where the converter has not answered yet and shows what it showed somebody else.
    let mut stale = Sample::new([0.01], [0.0]);
    stale.fresh = false;
    outer.step(&stale, &GroundMotion::none());
    assert_eq!(outer.handle(Event::Arm).unwrap_err(), unseen);
    outer.step(&Sample::new([0.01], [0.0]), &GroundMotion::none());
    assert_eq!(outer.handle(Event::Arm), Ok(Mode::Approaching));
    assert_eq!(outer.handle(Event::Stop), Ok(Mode::Idle));
    // After an exchange nobody knows it either.
    outer.configure(Design::new(&table1()).unwrap()).unwrap();
    assert!(outer.handle(Event::Arm).is_err());
}

// proves: fault.stale_sample, limit.stale_steps
#[test]
fn a_stale_sample_slows_the_test_down_and_too_many_trip_it() {
    let points = shaking(RECORD_S);
    let mut config = table1();
    config.limits.stale_steps = Some(40);
    let mut rig = Rig::new(0);
    let mut outer = started(&config, &mut rig, &ground(&points));
    for _ in 0..2000 {
        rig.step(&mut outer, &ground(&points));
    }
    let mut stale = rig.sample();
    stale.fresh = false;
    let mut speed = f32::INFINITY;
    for _ in 0..40 {
        let before = rig.sent;
        let step = outer.step(&stale, &ground(&points));
        rig.sent = step.command_m[0];
        assert!(step.record.has(flag::LATE) && !step.record.has(flag::SOLVED));
        assert!((rig.sent - before).abs() <= speed);
        speed = (rig.sent - before).abs();
    }
    assert_eq!(outer.mode(), Mode::Running);
    outer.step(&stale, &ground(&points));
    assert_eq!(outer.trip().map(|t| t.fault), Some(Fault::StaleSample));
}

// proves: fault.target_late
#[test]
fn a_late_target_trips_after_its_time() {
    let points = shaking(RECORD_S);
    let mut config = table1();
    config.timing.late_limit_steps = 25;
    let mut rig = Rig::new(0);
    let mut outer = started(&config, &mut rig, &ground(&points));
    let mut stale = rig.sample();
    stale.fresh = false;
    for _ in 0..25 {
        outer.step(&stale, &ground(&points));
    }
    assert_eq!(outer.mode(), Mode::Running);
    outer.step(&stale, &ground(&points));
    assert_eq!(
        outer.trip().map(|t| (t.fault, t.value)),
        Some((Fault::TargetLate, 26.0))
    );
}

// proves: fault.energy_ratio, limit.energy_warning, limit.energy_trip
#[test]
fn the_energy_monitor_warns_and_trips_an_uncompensated_test() {
    let points = shaking(60.0);
    let mut config = table1();
    config.compensation.kind = Method::None;
    (config.limits.energy_warning, config.limits.energy_trip) = (Some(0.1), Some(0.5));
    let trip = |config| {
        let mut rig = Rig::new(8);
        let mut outer = started(&config, &mut rig, &ground(&points));
        let mut warned = None;
        for i in 0..120_000 {
            let record = rig.step(&mut outer, &ground(&points)).record;
            if warned.is_none() && record.has(flag::ENERGY_WARNING) {
                warned = Some(i);
            }
            if outer.mode() != Mode::Running {
                return (warned, outer.trip().map(|t| (t.fault, i)));
            }
        }
        (warned, None)
    };
    let (warned, tripped) = trip(config.clone());
    let (fault, at) = tripped.unwrap();
    assert_eq!(fault, Fault::EnergyRatio);
    assert!(warned.unwrap() < at);
    config.compensation.kind = Method::Paper;
    assert_eq!(
        trip(config),
        (None, None),
        "what the damping takes out again is no error"
    );
}

#[test]
fn a_configuration_is_exchanged_only_while_idle() {
    let points = shaking(RECORD_S);
    let mut rig = Rig::new(8);
    let config = table1();
    let mut outer = started(&config, &mut rig, &ground(&points));
    assert!(outer.configure(Design::new(&config).unwrap()).is_err());
    outer.handle(Event::Stop).unwrap();
    outer.handle(Event::Clear).unwrap();
    assert!(outer.configure(Design::new(&config).unwrap()).is_ok());
}

#[test]
fn a_commissioning_signal_is_followed_within_the_limits_and_ends_without_a_bump() {
    let mut config = table1();
    config.limits.displacement_m = Some(0.01);
    let mut outer = OuterLoop::<1>::new(Design::new(&config).unwrap());
    let none = GroundMotion::none();
    let tick = |outer: &mut OuterLoop<1>, goal: Option<f32>| {
        outer.set_commissioning_command(goal.map(|g| [g]));
        outer.step(&Sample::new([0.0], [0.0]), &none).command_m[0]
    };
    tick(&mut outer, None);
    outer.handle(Event::Arm).unwrap();
    outer.handle(Event::Start).unwrap();
    let sine = |i: u16, amplitude: f32| amplitude * libm::sinf(f32::from(i) * 0.01);
    for i in 0..1000 {
        assert_eq!(tick(&mut outer, Some(sine(i, 0.005))), sine(i, 0.005));
    }
    // Stopped at speed: the command slows down from the speed it had.
    let (before, last) = (sine(998, 0.005), sine(999, 0.005));
    assert_eq!(outer.handle(Event::Stop), Ok(Mode::Finished));
    let next = tick(&mut outer, None);
    assert!(
        ((next - last) - (last - before)).abs() < 2e-6,
        "{next} {last} {before}"
    );

    outer.handle(Event::Clear).unwrap();
    tick(&mut outer, None);
    outer.handle(Event::Arm).unwrap();
    while tick(&mut outer, None) != 0.0 {}
    outer.handle(Event::Start).unwrap();
    let mut i = 0;
    while outer.mode().permits_motion() {
        assert!(tick(&mut outer, Some(sine(i, 0.02))).abs() <= 0.01);
        i += 1;
    }
    assert_eq!(outer.trip().unwrap().fault, Fault::Displacement);
}

/// A servo that goes further than it is sent: the command never leaves the stroke, the actuator does.
// proves: fault.reading, limit.displacement_m
#[test]
fn an_actuator_that_is_read_beyond_the_stroke_trips_in_every_mode_with_permission() {
    let none = GroundMotion::none();
    let points = shaking(RECORD_S);
    let modes = [
        Mode::Armed,
        Mode::Running,
        Mode::Commissioning,
        Mode::Holding,
        Mode::Finished,
    ];
    for mode in modes {
        let mut config = table1();
        config.limits.displacement_m = Some(0.01);
        let mut outer = OuterLoop::<1>::new(Design::new(&config).unwrap());
        let quiet = ground(&points);
        let stands = |outer: &mut OuterLoop<1>, read_m: f32| {
            let shaken = if mode == Mode::Armed { &none } else { &quiet };
            outer.step(&Sample::new([read_m], [0.0]), shaken).permit
        };
        stands(&mut outer, 0.0);
        outer.handle(Event::Arm).unwrap();
        if mode != Mode::Armed {
            outer.handle(Event::Start).unwrap();
        }
        match mode {
            Mode::Commissioning => outer.set_commissioning_command(Some([0.0])),
            Mode::Holding => {
                outer.handle(Event::Hold).unwrap();
            }
            Mode::Finished => {
                outer.handle(Event::Stop).unwrap();
            }
            _ => {}
        }
        assert_eq!(outer.mode(), mode);
        // Three per cent are the noise's and the calibration's.
        assert!(stands(&mut outer, -0.0102), "{mode:?}");
        assert!(!stands(&mut outer, -0.0104), "{mode:?}");
        let trip = outer.trip().unwrap();
        assert_eq!(trip.fault, Fault::Reading, "{mode:?}");
        assert_eq!((trip.value, trip.limit), (-0.0104, 0.0103));
    }
}

#[test]
fn a_known_error_of_the_transducer_is_no_motion_beyond_the_stroke() {
    let mut config = table1();
    config.limits.displacement_m = Some(0.01);
    config.rig.displacement_offset_m = [0.002].into_iter().collect();
    let none = GroundMotion::none();
    for (read_m, fault) in [(0.0119, None), (-0.009, Some(Fault::Reading))] {
        let mut outer = OuterLoop::<1>::new(Design::new(&config).unwrap());
        outer.step(&Sample::new([0.002], [0.0]), &none);
        outer.handle(Event::Arm).unwrap();
        outer.step(&Sample::new([read_m], [0.0]), &none);
        assert_eq!(outer.trip().map(|t| t.fault), fault, "{read_m}");
    }
}

#[test]
fn a_sensor_that_stands_away_from_zero_does_not_forbid_arming() {
    let mut config = table1();
    config.limits.stale_steps = Some(3);
    let mut outer = OuterLoop::<1>::new(Design::new(&config).unwrap());
    for _ in 0..100 {
        outer.step(&Sample::new([0.003], [0.0]), &GroundMotion::none());
    }
    assert_eq!(outer.handle(Event::Arm), Ok(Mode::Approaching));
}
