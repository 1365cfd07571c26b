//! The rig watch on the flashed image: its slow part in the tasks, its fast part in the control interrupt, and the PC that
//! recomputes both with the same bits. The tests are `examples/rig-watch.toml` with other effects.

#[path = "common/example.rs"]
mod example;
#[path = "common/load.rs"]
mod load;

use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::summary::TestVerdict;
use experiment::trace::Trace;
use experiment::watch::{WatchEvent, WatchReport};
use link::Status;
use outerloop_core::{Fault, flag};
use std::path::Path;

/// The strong part of the motion: two natural periods of 1 s before the effect that begins in mid-test, and some after.
const SECONDS: f64 = 14.0;

/// Largest mean time to judge a block, per cent of its duration: 1.3 to 1.6 was measured.
const MEAN_SHARE: f64 = 2.0;

/// The example with another table of effects, and keys that are set.
fn run(effect: &str, set: &[&str]) -> JudgedRun {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/rig-watch.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let (rig, _) = text.split_once("[[plant.effects]]").unwrap();
    let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
    let test = TestFile::parse(&format!("{rig}{effect}"), "t.toml", Path::new(""), &set);
    let experiment = Experiment::new(test.unwrap(), &near_fault(), Some(SECONDS)).unwrap();
    let ideal = experiment.ideal().unwrap();
    let (run, status) = example::run(&experiment, &ideal);
    println!("{}", run.summary.sentence());
    looks_at_its_cost(&status, &run);
    let board = run.summary.board.as_ref().unwrap();
    // What the watch requested is in these records: each was recomputed on the PC with the same bits.
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));
    assert_eq!(board.timing.map(|t| t.overruns), Some(0));
    let flags = &run.trace.as_ref().unwrap().flags;
    assert!(flags.iter().all(|f| f & flag::WATCH_LATE == 0), "late");
    run
}

/// Checks the watch's processor load with everything on and telemetry filling the link, interrupts included; and that the board
/// itself reports what the PC has computed.
fn looks_at_its_cost(status: &Status, run: &JudgedRun) {
    let own = status.watch.as_ref().expect("it is watched");
    let [mean, worst] = load::of_the_watch(status);
    assert!(mean < MEAN_SHARE && worst < 100.0);
    let told = run.summary.watch.as_ref().unwrap();
    assert_eq!(own.state.name(), told.state);
    // The last event is the end of the test, and the last change is before it.
    let changed_s = told.events.iter().rev().nth(1).map_or(0.0, |e| e.t_s);
    let since_s = f64::from(own.since_step) / 2000.0;
    assert!((since_s - changed_s).abs() < 0.01, "{since_s} {changed_s}");
    let end = told.events.last().map_or(&[][..], |e| &e.set);
    assert_eq!(own.named.len(), end.len(), "{own:?}");
    let held = told.events.last().is_some_and(|e| e.held);
    assert!(own.held || !held, "{own:?}");
    for (own, told) in own.named.iter().zip(end) {
        let cause = (own.cause.name(), own.cause.side().name());
        assert_eq!((own.actuator, cause), (1, (told.name, told.side)));
        assert_eq!(f64::from(own.value), told.value);
        assert_eq!(f64::from(own.corrected), told.corrected.unwrap_or(0.0));
    }
}

fn watched(run: &JudgedRun) -> &WatchReport {
    let report = run.summary.watch.as_ref().unwrap();
    println!("{}", report.sentence());
    assert!(report.not_watched.is_empty(), "{report:?}");
    report
}

/// The first event with a name.
fn named(report: &WatchReport) -> &WatchEvent {
    let first = report.events.iter().find(|e| !e.set.is_empty());
    first.unwrap_or_else(|| panic!("nothing named: {report:?}"))
}

fn holds(event: &WatchEvent, name: &str, side: &str) -> bool {
    event.set.iter().any(|c| (c.name, c.side) == (name, side))
}

/// When a test departs from the sound one, s: until then they are the same to the bit.
fn departs_s(sound: &JudgedRun, other: &JudgedRun) -> f64 {
    let [was, is] = [sound, other].map(|r| r.trace.as_ref().unwrap());
    let bits = |t: &Trace, i: usize| t.floors[0].displacement_m[i].to_bits();
    let first = (0..was.len().min(is.len())).find(|&i| bits(was, i) != bits(is, i));
    was.time_s(first.expect("they differ"))
}

const JUMP: &str = "[[plant.effects]]\nname = 'delay_error'\ndelay_ms = 12\nfrom_s = 8\n";

#[test]
fn a_delay_that_jumps_in_mid_test_is_named_within_two_cycles_and_corrected() {
    let sound = run("", &[]);
    assert!(watched(&sound).events.iter().all(|e| e.set.is_empty()));
    let plain = run(JUMP, &[]);
    let corrected = run(JUMP, &["watch.correct=['lateness']"]);
    let jump_s = departs_s(&sound, &plain);
    for jumped in [&plain, &corrected] {
        let first = named(watched(jumped));
        println!("jump at {jump_s:.2} s, named at {:.2} s", first.t_s);
        assert!(first.t_s > jump_s && first.t_s < jump_s + 2.0, "{first:?}");
        assert!(holds(first, "delay_error", "actuator"), "{first:?}");
    }
    let eps = [&sound, &plain, &corrected].map(|r| r.summary.eps_rms);
    println!(
        "eps_rms sound {:.4}, jump {:.4}, corrected {:.4}",
        eps[0], eps[1], eps[2]
    );
    assert!(eps[2] - eps[0] < 0.6 * (eps[1] - eps[0]), "{eps:?}");
    assert!(!watched(&corrected).corrections.is_empty());
}

#[test]
fn a_transducer_whose_gain_changes_under_an_adaptive_compensation_is_named_and_what_was_learnt_held()
 {
    let lies = "[[plant.effects]]\nname = 'gain_error'\nsensor = 'displacement'\nerror = 0.08\nfrom_s = 8\n";
    let ats = "compensation.kind='ats'";
    let free = run(lies, &[ats, "watch.guard=false"]);
    let guarded = run(lies, &[ats]);
    for (run, holds_it) in [(&free, false), (&guarded, true)] {
        let report = watched(run);
        assert!(
            holds(named(report), "gain_error", "displacement"),
            "{report:?}"
        );
        assert_eq!(report.events.iter().any(|e| e.held), holds_it, "{report:?}");
        let flags = &run.trace.as_ref().unwrap().flags;
        let held = flags.iter().filter(|f| *f & flag::GUARDED != 0).count();
        assert_eq!(held > 1000, holds_it, "{held} steps");
    }
    println!(
        "eps_rms under ats free {:.4}, guarded {:.4}",
        free.summary.eps_rms, guarded.summary.eps_rms
    );
}

// proves: fault.watch by frozen
#[test]
fn a_transducer_that_stands_with_its_noise_stops_the_test() {
    let stands = "[[plant.effects]]\nsensor = 'displacement'\nfrozen = true\nfrom_s = 8\n";
    // In a motion as large as this one the derived limits would trip first; these are wide.
    let wide = [
        "limits.stale_steps=500",
        "limits.displacement_m=0.05",
        "limits.tracking_m=0.05",
    ];
    let run = run(stands, &wide);
    assert_eq!(run.summary.verdict, TestVerdict::Tripped);
    let board = run.summary.board.as_ref().unwrap();
    assert_eq!(board.trip, Some(Fault::Watch));
    assert!(holds(named(watched(&run)), "frozen_sensor", "displacement"));
}

#[test]
fn a_specimen_that_yields_passes_in_silence() {
    let run = run("[plant.specimen]\nkind = 'bilinear'\nyield_mm = 12\n", &[]);
    assert_eq!(run.summary.verdict, TestVerdict::Completed);
    assert!(watched(&run).events.iter().all(|e| e.set.is_empty()));
}
