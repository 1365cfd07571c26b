//! The rig watch in whole simulated tests.

mod declared;
mod effects;
mod names;
mod orders;

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
    run_file(&format!("{RIG}{more}"), &set)
}

fn run_file(text: &str, set: &[String]) -> JudgedRun {
    let test = TestFile::parse(text, "t.toml", Path::new(""), set);
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

/// A delay that jumps in mid-test.
const JUMP: &str = "[[plant.effects]]\nname = 'delay_error'\ndelay_ms = 12\nfrom_s = 8\n";
