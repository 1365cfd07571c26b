//! The rig watch in whole simulated tests.

use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::watch::{WatchEvent, WatchReport};
use std::path::Path;

/// 1 Hz, 40 mm, 14 ms of an actuator that is as declared, and sensors with 0.1 % of noise.
const RIG: &str = "[structure]\nmass_kg = 4000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.03\n\
    [compensation]\nkind = 'inverse'\n[excitation]\npeak_response_mm = 40\n\
    [declared.actuator]\ngain = { value = 1, tolerance = 0.005 }\ndelay_ms = { value = 6, tolerance = 0.5 }\n\
    lag_ms = { value = 8, tolerance = 0.5 }\n\
    [declared.specimen]\nstiffness_n_per_mm = { value = 158, tolerance = 3 }\n\
    [plant.actuator]\nkind = 'lag_delay'\ndelay_ms = 6.2\nlag_ms = 7.9\n\
    [plant.sensors]\ndisplacement_noise_mm = 0.04\nforce_noise_n = 6\nbits = 16\ndisplacement_range_mm = 100\n";

fn run(more: &str, set: &[&str]) -> JudgedRun {
    let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
    let test = TestFile::parse(&format!("{RIG}{more}"), "t.toml", Path::new(""), &set);
    let test = test.unwrap_or_else(|e| panic!("{e}"));
    let method = test.config.compensation.kind;
    let experiment = Experiment::new(test, &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    experiment.run(method, &ideal, 3, true, ()).unwrap()
}

fn watched(more: &str) -> WatchReport {
    run(more, &[]).summary.watch.expect("it is on")
}

/// The first event with a name.
fn named(report: &WatchReport) -> &WatchEvent {
    let first = report.events.iter().find(|e| !e.set.is_empty());
    first.unwrap_or_else(|| panic!("nothing named: {report:?}"))
}

fn holds(event: &WatchEvent, name: &str, side: &str) -> bool {
    event.set.iter().any(|c| (c.name, c.side) == (name, side))
}

#[test]
fn a_sound_test_and_a_specimen_that_yields_pass_in_silence() {
    for specimen in [
        "",
        "[plant.specimen]\nkind = 'bilinear'\nyield_mm = 12\n",
        "[plant.specimen]\nkind = 'bouc_wen'\nyield_mm = 15\n",
    ] {
        let report = watched(specimen);
        assert!(
            report.events.iter().all(|e| e.set.is_empty()),
            "{specimen}: {report:?}"
        );
        assert!(report.not_watched.is_empty(), "{report:?}");
    }
}

#[test]
fn a_delay_that_jumps_is_named_within_two_cycles_on_its_side_and_by_its_size() {
    let report = watched("[[plant.effects]]\nname = 'delay_error'\ndelay_ms = 12\nfrom_s = 8\n");
    let first = named(&report);
    assert!(first.t_s > 8.0 && first.t_s < 10.0, "{report:?}");
    assert!(holds(first, "delay_error", "actuator"), "{report:?}");
    let last = report.events.last().unwrap();
    let late = last.set.iter().find(|c| c.name == "delay_error").unwrap();
    assert!(
        (late.value - 12.0).abs() < 3.0 && late.unit == "ms",
        "{report:?}"
    );
}

#[test]
fn a_transducer_that_freezes_with_its_noise_asks_for_a_trip() {
    // The reading alone: the force goes on with the motion.
    {
        let side = "displacement";
        let more = format!("[[plant.effects]]\nsensor = '{side}'\nfrozen = true\nfrom_s = 8\n");
        let report = watched(&more);
        assert_eq!(report.state, "trip", "{report:?}");
        let first = named(&report);
        assert!(
            holds(first, "frozen_sensor", side) && first.t_s < 9.5,
            "{report:?}"
        );
    }
}

#[test]
fn the_watch_looks_on_and_says_what_it_cannot_see() {
    let on = run("", &[]);
    let off = run("", &["watch.on=false"]);
    assert!(off.summary.watch.is_none());
    let [a, b] = [on, off].map(|r| r.trace.unwrap());
    assert_eq!(a.floors[0].sent_m, b.floors[0].sent_m);
    assert_eq!(a.floors[0].force_n, b.floors[0].force_n);
    let plain = "[structure]\nmass_kg = 4000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.03\n";
    let test = TestFile::parse(plain, "t.toml", Path::new(""), &[]).unwrap();
    let method = test.config.compensation.kind;
    let experiment = Experiment::new(test, &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    let report = experiment
        .run(method, &ideal, 1, false, ())
        .unwrap()
        .summary
        .watch
        .unwrap();
    assert_eq!(report.not_watched.len(), 2, "{report:?}");
}

#[test]
fn what_the_watch_does_not_do_is_refused_and_its_names_are_the_catalogues() {
    for (set, said) in [
        ("watch.correct=['late']", "watch.correct"),
        ("watch.trip_eps=0.1", "watch.trip_eps"),
    ] {
        let e = TestFile::parse(RIG, "t.toml", Path::new(""), &[set.to_owned()]).unwrap_err();
        assert!(e.to_string().contains(said), "{e}");
    }
    for cause in outerloop_core::watch::Cause::ALL {
        let known = |e: &&plant::Effect| e.name() == cause.name();
        assert!(plant::Effect::ALL.iter().any(|e| known(&e)), "{cause:?}");
    }
}
