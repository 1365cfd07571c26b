//! A whole pseudodynamic test on the flashed image, over the link, as `outerloop run` does it.

use crate::desk::{Desk, PERIOD_NS, TABLE_1, fine, image};
use emu::{Firmware, LoggedEvent};
use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::summary::TestVerdict;
use experiment::trace::Trace;
use outerloop_cli::board::Image;
use outerloop_cli::board::limits::PlannedMotion;
use outerloop_cli::board::{BoardBench, Operator};
use std::path::Path;

#[test]
fn ten_seconds_at_an_exact_period_with_the_bits_of_the_loop_on_this_machine() {
    let test = TestFile::parse(TABLE_1, "test.toml", Path::new(""), &[]).unwrap();
    let experiment = Experiment::new(test.clone(), &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    let mut desk = Desk::new(None);
    desk.calibrate();
    let plan = PlannedMotion::of(&experiment, &ideal);
    let bench = BoardBench::new(desk.connection(), plan, Operator::not_asked());
    let method = test.config.compensation.kind;
    let run = experiment
        .run_on(&bench, method, &ideal, true, None::<Trace>)
        .unwrap();
    let summary = &run.summary;
    assert_eq!(
        summary.verdict,
        TestVerdict::Completed,
        "{}",
        summary.sentence()
    );
    assert_eq!(summary.steps, 20_000);

    // Every word of every step, including the commands, is what the loop here computes from the board's codes.
    let board = summary.board.as_ref().unwrap();
    println!("{}", board.sentence());
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));
    assert_eq!(board.steps_dropped, Some(0));
    assert!(board.steps_received > 20_000);

    // 12 bits over 100 mm: 24 um, with a peak of 20 mm.
    println!(
        "eps_rms {:.4}, eps_max {:.4} on {:?} converters",
        summary.eps_rms,
        summary.eps_max,
        crate::IMAGE
    );
    assert!(summary.eps_rms < 0.01 && summary.eps_max < 0.02);

    drop(bench);
    let status = desk.status();
    let log = desk.log();
    // Over the whole run the triggers are at the timer's instants; the emulator stops between instructions, 11 ns each.
    for (i, at) in (0_u64..).zip(&log.triggers_ns) {
        let exact = log.triggers_ns[0] + i * PERIOD_NS;
        assert!(at.abs_diff(exact) <= 11, "trigger {i}: {at} ns, {exact} ns");
    }
    let timing = status.timing;
    assert_eq!(timing.period_cycles, 84_000);
    assert!(
        timing.shortest_period_cycles >= 83_997 && timing.longest_period_cycles <= 84_003,
        "{timing:?}"
    );
    assert_eq!(timing.overruns, 0);

    let external = crate::IMAGE == Image::External;
    // From the trigger to the command: the conversions, then the step. Telemetry of every step and the link's commands load
    // the board throughout, and delay it by no more than one instruction.
    let (soonest, latest) = (
        log.latency_ns.iter().min().unwrap(),
        log.latency_ns.iter().max().unwrap(),
    );
    let longest_step = log.step_instructions.iter().max().unwrap();
    let share = f64::from(timing.worst_step_cycles) / f64::from(timing.period_cycles);
    println!(
        "trigger to command {soonest} to {latest} ns; step at most {longest_step} instructions and {} cycles, {:.2} % of \
         the period; stack {} bytes",
        timing.worst_step_cycles,
        share * 100.0,
        status.stack_bytes
    );
    // With external converters it includes 11 us of waiting.
    assert!(share < if external { 0.06 } else { 0.03 }, "{share}");
    let firmware = Firmware::read(image()).unwrap();
    let kib = |bytes: u64| bytes as f64 / 1024.0;
    println!(
        "flash {:.1} KiB, RAM {:.1} KiB without the stack",
        kib(firmware.flash_bytes()),
        kib(firmware.ram_bytes().unwrap())
    );
    // The output takes the command this long after the trigger; every command was written by then, so it was output.
    assert!(*latest < if external { 60_000 } else { 40_000 });
    assert_eq!(log.violations, []);
    assert!(status.stack_bytes > 1000 && status.stack_bytes < 70 * 1024);

    let codes: Vec<i32> = log
        .seen
        .iter()
        .filter_map(|(_, s)| match s {
            LoggedEvent::Command(code) => Some(i32::from(*code)),
            _ => None,
        })
        .collect();
    let jump = codes.windows(2).map(|w| (w[1] - w[0]).abs()).max().unwrap();
    // 20 mm at 2 Hz is 0.25 m/s: 5.2 codes a step, plus one of the error feedback.
    println!("largest step of the command {jump} codes");
    assert!(jump <= 12 * i32::from(fine()), "{jump}");
}

#[test]
fn the_control_interrupt_begins_as_early_under_the_worst_load_of_the_link() {
    let mut desk = Desk::new(None);
    let quiet = spread(&mut desk, false);
    let loaded = spread(&mut desk, true);
    println!("trigger to command: quiet {quiet:?} ns, with the line full both ways {loaded:?} ns");
    // The same step, the same instants: only the instruction that the interrupt hits may differ.
    assert!(loaded.1 <= quiet.1 + 200, "{loaded:?} after {quiet:?}");
}

/// The shortest and the longest time from trigger to command, ns, over a quarter of a second in idle.
fn spread(desk: &mut Desk, full: bool) -> (u32, u32) {
    let begin = desk.log().latency_ns.len();
    for _ in 0..500 {
        if full {
            // 50 bytes a step are all that the line carries.
            desk.wire.send(&[0x55; 49]);
            desk.wire.send(&[0]);
        }
        desk.step();
    }
    let log = desk.log();
    let seen = &log.latency_ns[begin.max(100)..];
    (*seen.iter().min().unwrap(), *seen.iter().max().unwrap())
}

/// A rig at rest on either side of zero is read where it is, to half a code.
#[test]
fn a_converter_has_no_step_at_zero() {
    let calibration = link::Calibration::nominal(&crate::desk::codes());
    for offset_mm in [-20.0, -0.1, 0.1, 20.0] {
        let rig = format!(
            "[actuator]\nkind = 'delay'\ndelay_ms = 3.0\n[specimen]\nkind = 'linear'\n[sensors]\n\
             displacement_offset_mm = {offset_mm}\nforce_offset_n = {}\n",
            100.0 * offset_mm
        );
        let mut desk = Desk::with(crate::desk::Bench {
            rig: Some(toml::from_str(&rig).unwrap()),
            ..Default::default()
        });
        desk.calibrate();
        // The rig has been at rest throughout.
        for _ in 0..50 {
            desk.step();
        }
        let read = desk.step();
        let of =
            |line: link::channel::ChannelCalibration, code| (line.quantity(code), line.per_code);
        let wanted = [offset_mm * 1e-3, 100.0 * offset_mm];
        let got = [
            of(calibration.displacement, read.displacement),
            of(calibration.force, read.force),
        ];
        for (wanted, (got, per_code)) in wanted.into_iter().zip(got) {
            // Both conversions of a pair are alike: a code of the sum is half a code of one.
            let codes = (f64::from(got) - wanted) / f64::from(per_code);
            assert!(codes.abs() <= 1.01, "{offset_mm} mm: {codes} codes");
        }
    }
}
