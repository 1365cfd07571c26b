//! The rig watch in whole simulated tests.

use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::watch::{NamedCause, WatchEvent, WatchReport};
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
fn a_specimen_that_hardens_softens_or_degrades_passes_in_silence() {
    for effect in [
        // Of its stiffness at 40 mm: 4 to 44 % more.
        "name = 'hardening'\nreference_mm = 200",
        "name = 'hardening'\nreference_mm = 160",
        "name = 'hardening'\nreference_mm = 100",
        "name = 'hardening'\nreference_mm = 60",
        // 9 to 29 % less.
        "name = 'softening'\nreference_mm = 400",
        "name = 'softening'\nreference_mm = 200",
        "name = 'softening'\nreference_mm = 100",
        // Less than 30 % of it, and slowly: by the way.
        "name = 'degradation'\ntravel_mm = 1000\nlost_share = 0.3",
        "name = 'degradation'\ntravel_mm = 300\nlost_share = 0.5",
        // 7 to 29 % of it, by the largest motion.
        "name = 'degradation'\nreference_mm = 500",
        "name = 'degradation'\nreference_mm = 320",
        "name = 'degradation'\nreference_mm = 200",
        "name = 'degradation'\nreference_mm = 100",
    ] {
        let report = watched(&format!("[[plant.effects]]\n{effect}\n"));
        assert!(
            report.events.iter().all(|e| e.set.is_empty()),
            "{effect}: {report:?}"
        );
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

const JUMP: &str = "[[plant.effects]]\nname = 'delay_error'\ndelay_ms = 12\nfrom_s = 8\n";

/// What goes wrong from 8 s on, and the cause that a set has to hold.
const EACH: [(&str, [&str; 2]); 26] = [
    (
        "name = 'delay_error'\ndelay_ms = 12",
        ["delay_error", "actuator"],
    ),
    (
        "name = 'gain_error'\nchannel = 'actuator'\nerror = 0.08",
        ["gain_error", "actuator"],
    ),
    (
        "name = 'offset'\nchannel = 'actuator'\noffset_mm = 2",
        ["offset", "actuator"],
    ),
    (
        "name = 'drift'\nchannel = 'actuator'\nrate_mm_per_s = 0.3",
        ["drift", "actuator"],
    ),
    (
        "name = 'coulomb_friction'\nchannel = 'actuator'\nerror_mm = 1.2",
        ["coulomb_friction", "actuator"],
    ),
    // The overlap of a valve.
    (
        "name = 'dead_band'\nchannel = 'actuator'\nwidth_mm = 3",
        ["dead_band", "actuator"],
    ),
    (
        "name = 'rate_limit'\nrate_mm_per_s = 120",
        ["rate_limit", "actuator"],
    ),
    (
        "name = 'saturation'\nchannel = 'actuator'\nlimit_mm = 20",
        ["saturation", "actuator"],
    ),
    (
        "name = 'gain_error'\nsensor = 'displacement'\nerror = 0.08",
        ["gain_error", "displacement"],
    ),
    (
        "name = 'offset'\nsensor = 'displacement'\noffset_mm = 2",
        ["offset", "displacement"],
    ),
    (
        "name = 'drift'\nsensor = 'displacement'\nrate_mm_per_s = 0.3",
        ["drift", "displacement"],
    ),
    (
        "name = 'channel_skew'\nskew_ms = -12",
        ["channel_skew", "displacement"],
    ),
    (
        "sensor = 'displacement'\nfrozen = true",
        ["frozen_sensor", "displacement"],
    ),
    (
        "sensor = 'displacement'\nname = 'sensor_noise'\nrms_mm = 0.4",
        ["sensor_noise", "displacement"],
    ),
    (
        "sensor = 'displacement'\nname = 'mains_hum'\namplitude_mm = 0.3",
        ["mains_hum", "displacement"],
    ),
    (
        "name = 'gain_error'\nsensor = 'force'\nerror = 0.15",
        ["gain_error", "force"],
    ),
    (
        "name = 'offset'\nsensor = 'force'\noffset_n = 500",
        ["offset", "force"],
    ),
    (
        "name = 'drift'\nsensor = 'force'\nrate_n_per_s = 80",
        ["drift", "force"],
    ),
    (
        "name = 'channel_skew'\nskew_ms = 12",
        ["channel_skew", "force"],
    ),
    (
        "name = 'inertia_force'\nmass_kg = 800",
        ["inertia_force", "force"],
    ),
    (
        "sensor = 'force'\nname = 'sensor_noise'\nrms_n = 60",
        ["sensor_noise", "force"],
    ),
    (
        "sensor = 'force'\nname = 'mains_hum'\namplitude_n = 60",
        ["mains_hum", "force"],
    ),
    (
        "name = 'dead_band'\nchannel = 'specimen'\nwidth_mm = 1.5",
        ["dead_band", "specimen"],
    ),
    (
        "name = 'coulomb_friction'\nchannel = 'specimen'\nforce_n = 300",
        ["coulomb_friction", "specimen"],
    ),
    (
        "name = 'degradation'\ntravel_mm = 1e-3\nlost_share = 0.6",
        ["degradation", "specimen"],
    ),
    (
        "name = 'degradation'\ntravel_mm = 1e-3\nlost_share = 0.6",
        ["gain_error", "force"],
    ),
];

#[test]
fn each_cause_of_the_list_is_named_on_its_side() {
    let mut wrong = Vec::new();
    for (effect, [name, side]) in EACH {
        let report = watched(&format!("[[plant.effects]]\n{effect}\nfrom_s = 8\n"));
        if !report.events.iter().any(|e| holds(e, name, side)) {
            wrong.push((name, side, report.sentence()));
        }
    }
    assert_eq!(wrong, []);
}

#[test]
fn an_offset_that_moves_on_is_a_drift_with_its_rate_and_one_that_jumps_is_none() {
    for (place, side, mm_or_n, jumps, moves) in [
        ("channel = 'actuator'", "actuator", "mm", 2.0, 0.3),
        ("sensor = 'displacement'", "displacement", "mm", 2.0, 0.3),
        ("sensor = 'force'", "force", "n", 500.0, 80.0),
    ] {
        let effect = |name: &str, key: &str, value: f64| {
            watched(&format!(
                "[[plant.effects]]\nname = '{name}'\n{place}\n{key} = {value}\nfrom_s = 8\n"
            ))
        };
        let jumped = effect("offset", &format!("offset_{mm_or_n}"), jumps);
        assert!(jumped.events.iter().any(|e| holds(e, "offset", side)));
        let drifts = jumped.events.iter().any(|e| holds(e, "drift", side));
        assert!(!drifts, "{}", jumped.sentence());
        let moved = effect("drift", &format!("rate_{mm_or_n}_per_s"), moves);
        let last = moved.events.last().expect("it is named");
        let drift = last
            .set
            .iter()
            .find(|c| (c.name, c.side) == ("drift", side));
        let rate = drift
            .unwrap_or_else(|| panic!("{}", moved.sentence()))
            .value;
        assert!((rate / moves - 1.0).abs() < 0.2, "{side}: {rate}");
    }
}

#[test]
fn a_delay_that_jumps_is_corrected_and_what_it_adds_to_the_error_is_halved() {
    let plain = run(JUMP, &[]).summary;
    let sound = run("", &[]).summary;
    let corrected = run(JUMP, &["watch.correct=['lateness']"]).summary;
    let [added, left] = [&plain, &corrected].map(|s| s.eps_rms - sound.eps_rms);
    println!(
        "eps_rms sound {:.4}, jump {:.4}, corrected {:.4}",
        sound.eps_rms, plain.eps_rms, corrected.eps_rms
    );
    assert!(left < 0.5 * added, "{left} of {added}");
    let report = corrected.watch.unwrap();
    println!("{}", report.sentence());
    assert!(
        report.sentence().contains("it was corrected for"),
        "{}",
        report.sentence()
    );
    let last = report.events.last().unwrap();
    assert!(last.corrected && !last.held, "{report:?}");
    let steps = &report.corrections;
    assert!(
        steps
            .iter()
            .all(|c| c.name == "delay_error" && c.side == "actuator")
    );
    assert!(steps[0].t_s > 8.0 && steps.len() > 10);
    for pair in steps.windows(2) {
        // At most 40 ms of lateness a second.
        let moved = pair[1].corrected - pair[0].corrected;
        assert!(
            moved.abs() <= 40.0 * (pair[1].t_s - pair[0].t_s) + 0.05,
            "{pair:?}"
        );
    }
    assert!(plain.watch.unwrap().corrections.is_empty());
}

#[test]
fn a_gain_and_a_late_force_are_corrected_and_what_they_add_to_the_error_is_halved() {
    let allowed = "watch.correct=['lateness','gain','late_sensor']";
    let sound = run("", &[]).summary.eps_rms;
    for (what, effect) in [
        (
            "gain_error",
            "channel = 'actuator'\nname = 'gain_error'\nerror = -0.08",
        ),
        ("channel_skew", "name = 'channel_skew'\nskew_ms = 8"),
    ] {
        let effect = format!("[[plant.effects]]\nfrom_s = 6\n{effect}\n");
        let [plain, corrected] = [&[][..], &[allowed]].map(|set| run(&effect, set).summary);
        println!(
            "{effect}: eps_rms sound {sound:.4}, with it {:.4}, corrected {:.4}; {}",
            plain.eps_rms,
            corrected.eps_rms,
            corrected.watch.as_ref().unwrap().sentence()
        );
        let [added, left] = [&plain, &corrected].map(|s| s.eps_rms - sound);
        assert!(left < 0.5 * added, "{effect}: {left} of {added}");
        let steps = corrected.watch.unwrap().corrections;
        assert!(!steps.is_empty() && steps.iter().all(|c| c.name == what));
    }
}

#[test]
fn a_set_with_a_sensor_in_it_is_not_corrected_for() {
    // Specimen and load cell are not declared: nothing tells an actuator that goes too far from a transducer that reads too much.
    let (before, _) = RIG.split_once("[declared.specimen]").unwrap();
    let (_, behind) = RIG.split_once("tolerance = 3 }\n").unwrap();
    let text = format!(
        "{before}{behind}[[plant.effects]]\nchannel = 'actuator'\nname = 'gain_error'\nerror = -0.08\nfrom_s = 6\n"
    );
    let set = "watch.correct=['lateness','gain','late_sensor']".to_owned();
    let report = run_file(&text, &[set]).summary.watch.unwrap();
    let last = report.events.last().unwrap();
    assert!(holds(last, "gain_error", "actuator") && holds(last, "gain_error", "displacement"));
    assert!(
        report.corrections.is_empty() && !last.corrected,
        "{report:?}"
    );
}

#[test]
fn what_a_sensor_shows_after_something_else_has_a_name_is_named_beside_it() {
    let correct = "watch.correct=['lateness']";
    for (name, side, size) in [
        ("mains_hum", "displacement", "amplitude_mm = 0.5"),
        ("mains_hum", "force", "amplitude_n = 100"),
        ("sensor_noise", "force", "rms_n = 60"),
    ] {
        let second =
            format!("[[plant.effects]]\nfrom_s = 12\nname = '{name}'\nsensor = '{side}'\n{size}\n");
        let report = run(&format!("{JUMP}{second}"), &[correct]).summary.watch;
        let report = report.unwrap();
        let first = named(&report);
        assert!(holds(first, "delay_error", "actuator") && !holds(first, name, side));
        let last = report.events.last().unwrap();
        println!("{}", report.sentence());
        assert!(
            holds(last, "delay_error", "actuator") && holds(last, name, side),
            "{name} of {side}: {report:?}"
        );
        let beside = |c: &&NamedCause| c.beside;
        let names: Vec<_> = last
            .set
            .iter()
            .filter(beside)
            .map(|c| (c.name, c.side))
            .collect();
        assert_eq!(names, [(name, side)]);
        assert!(report.sentence().contains(&format!("; and {name} of the ")));
        // It goes on being corrected for.
        let corrected = report.corrections.last().unwrap();
        assert!(last.corrected && corrected.corrected > 8.0, "{corrected:?}");
    }
}

#[test]
fn what_a_sensor_shows_stands_against_no_correction_and_no_stop() {
    let hum = "[[plant.effects]]\nfrom_s = 5\nname = 'mains_hum'\nsensor = 'displacement'\namplitude_mm = 0.5\n";
    let both = format!("{hum}{JUMP}");
    let corrected = run(&both, &["watch.correct=['lateness']"]).summary.watch;
    let corrected = corrected.unwrap();
    let first = named(&corrected);
    assert!(holds(first, "mains_hum", "displacement") && first.set.len() == 1);
    let last = corrected.corrections.last().expect("it is corrected for");
    assert!(last.corrected > 8.0, "{last:?}");
    let stopped = run(&both, &["watch.trip_eps=0.1"]).summary;
    assert_eq!(stopped.trip, Some("watch"), "{}", stopped.sentence());
}

#[test]
fn a_correction_that_finds_nothing_to_correct_changes_no_bit() {
    for more in ["", "[plant.specimen]\nkind = 'bilinear'\nyield_mm = 12\n"] {
        for method in ["compensation.kind='paper'", "compensation.kind='inverse'"] {
            let off = run(more, &[method, "watch.on=false"]);
            let all = "watch.correct=['lateness','gain','late_sensor']";
            let on = run(more, &[method, all, "watch.trip_eps=0.5"]);
            let [a, b] = [&off, &on].map(|r| &r.trace.as_ref().unwrap().floors[0]);
            assert_eq!(a.sent_m, b.sent_m, "{method} {more}");
            assert_eq!(on.summary.trip, None);
        }
    }
}

#[test]
fn an_adaptive_compensation_is_held_while_the_displacement_reads_a_tenth_too_much() {
    let lies = "[[plant.effects]]\nname = 'gain_error'\nsensor = 'displacement'\nerror = 0.1\nfrom_s = 8\n";
    // The published gains of `amb` are not those of this motion.
    let of_this_motion = [
        "compensation.delay_ms=14",
        "compensation.amb.gains=[3e6,3e4,30,0]",
    ];
    for (method, own) in [
        ("ats", &[][..]),
        ("amb", &of_this_motion),
        ("mcs", &[]),
        ("adaptive-inverse", &[]),
        ("afp", &[]),
        ("darby", &[]),
        ("hydraulic", &[]),
    ] {
        let kind = format!("compensation.kind='{method}'");
        let tried = [("", true), (lies, false), (lies, true)].map(|(more, guard)| {
            let guard = format!("watch.guard={guard}");
            run(more, &[&[kind.as_str(), &guard][..], own].concat()).summary
        });
        let [sound, free, held] = &tried;
        println!(
            "{method}: eps_rms sound {:.4}, unguarded {:.4}, guarded {:.4}",
            sound.eps_rms, free.eps_rms, held.eps_rms
        );
        // It has followed for two seconds until it is named.
        let [added, left] = [free, held].map(|s| s.eps_rms - sound.eps_rms);
        assert!(left < 0.6 * added, "{method}: {left} of {added}");
        let [free, held] = [free, held].map(|s| s.watch.as_ref().unwrap());
        let first = named(held);
        assert!(
            first.held && holds(first, "gain_error", "displacement"),
            "{held:?}"
        );
        assert!(held.sentence().contains("was held"), "{}", held.sentence());
        assert!(free.events.iter().all(|e| !e.held), "{free:?}");
    }
}

#[test]
fn a_transducer_that_freezes_with_its_noise_stops_the_test() {
    // The reading alone: the force goes on with the motion.
    let frozen = |side: &str| {
        let effect = format!("[[plant.effects]]\nsensor = '{side}'\nfrozen = true\nfrom_s = 8\n");
        run(&effect, &[]).summary
    };
    let summary = frozen("displacement");
    assert_eq!(summary.trip, Some("watch"), "{}", summary.sentence());
    let report = summary.watch.unwrap();
    assert_eq!(report.state, "trip", "{report:?}");
    let first = named(&report);
    assert!(
        holds(first, "frozen_sensor", "displacement") && first.t_s < 9.5,
        "{report:?}"
    );
    // A force that stands drives the motion away in one direction, as on a plateau of yielding; but this specimen is elastic.
    let summary = frozen("force");
    assert_eq!(summary.trip, Some("watch"), "{}", summary.sentence());
    let report = summary.watch.unwrap();
    let first = named(&report);
    assert!(
        holds(first, "frozen_sensor", "force") && first.t_s < 8.2,
        "{report:?}"
    );
}

#[test]
fn a_test_is_stopped_where_what_was_named_will_add_more_than_was_declared() {
    // It comes to 0.70 of the peak, rms over the whole test; the first name may also be a friction, which adds less.
    let plain = run(JUMP, &[]).summary;
    assert!((plain.eps_rms - 0.70).abs() < 0.02, "{}", plain.eps_rms);
    let stopped = |eps: f64, more: &str| {
        let limit = format!("watch.trip_eps={eps}");
        run(JUMP, &[&limit, more]).summary
    };
    let nothing = "watch.correct=[]";
    for eps in [0.1, 0.3] {
        let s = stopped(eps, nothing);
        println!("{}", s.sentence());
        let trip = s.trip_detail.expect("it is stopped");
        assert!(
            trip.fault.name() == "watch" && f64::from(trip.value) > eps,
            "{trip:?}"
        );
        assert!(f64::from(trip.value) < 1.4, "{trip:?}");
        assert!(s.eps_rms < 0.1, "stopped after {}", s.eps_rms);
        assert!(s.sentence().contains("watch.trip_eps"), "{}", s.sentence());
    }
    assert_eq!(stopped(1.4, nothing).trip, None);
    let corrected = stopped(0.1, "watch.correct=['lateness']");
    assert_eq!(corrected.trip, None, "what is corrected will not be added");
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
    let [said] = &report.not_watched[..] else {
        panic!("one sentence, not {:?}", report.not_watched)
    };
    assert!(said.len() < 160 && said.contains("[declared]"), "{said}");
    let all_the_same = "only noise, hum, play and a load cell that stands are watched, not a displacement transducer that stands";
    assert!(said.contains(all_the_same), "{said}");
    let outlook = report.outlook();
    assert!(
        outlook.contains("no error by its size") && outlook.contains(all_the_same),
        "{outlook}"
    );
}

/// [`RIG`] without a part of what is declared.
fn undeclared(from: &str, to: &str) -> String {
    let (before, rest) = RIG.split_once(from).unwrap();
    let (_, behind) = rest.split_once(to).unwrap();
    format!("{before}{to}{behind}")
}

#[test]
fn a_rig_that_nobody_declared_is_watched_for_noise_hum_and_play_and_for_no_displacement_that_stands()
 {
    let rig = undeclared("[declared.actuator]", "[plant.actuator]");
    let with = |effect: &str| {
        let text = format!("{rig}[[plant.effects]]\n{effect}\nfrom_s = 8\n");
        run_file(&text, &[]).summary
    };
    for (effect, [name, side]) in EACH {
        let takes_no_model = ["sensor_noise", "mains_hum"].contains(&name)
            || (name, side) == ("dead_band", "specimen");
        if takes_no_model {
            let report = with(effect).watch.unwrap();
            assert!(
                report.events.iter().any(|e| holds(e, name, side)),
                "{effect}: {report:?}"
            );
        }
    }
    let stands = "sensor = 'displacement'\nfrozen = true";
    let summary = with(stands);
    let report = summary.watch.unwrap();
    assert_ne!(summary.trip, Some("watch"));
    assert!(report.events.iter().all(|e| e.set.is_empty()), "{report:?}");
}

#[test]
fn without_a_declared_actuator_no_limit_and_no_displacement_that_stands_is_promised() {
    let rig = undeclared("[declared.actuator]", "[declared.specimen]");
    let report = run_file(&rig, &[]).summary.watch.unwrap();
    let outlook = report.outlook();
    assert!(outlook.contains("gain_error of the load cell"), "{outlook}");
    assert!(!outlook.contains("limits of stroke"), "{outlook}");
    let gap = "Between command and displacement only noise and hum are watched, not a displacement transducer that stands";
    assert!(outlook.contains(gap), "{outlook}");
}

#[test]
fn what_is_inside_the_declared_tolerance_of_the_mass_or_the_forces_zero_has_no_name() {
    for (key, rig) in [
        (
            "mass_kg",
            "[[plant.effects]]\nname = 'inertia_force'\nmass_kg = 500\n",
        ),
        (
            "offset_n",
            "[[plant.effects]]\nname = 'offset'\nsensor = 'force'\noffset_n = 300\nfrom_s = 12\n",
        ),
    ] {
        let wide = format!("declared.specimen.{key}={{value=0,tolerance=600}}");
        let narrow = format!("declared.specimen.{key}={{value=0,tolerance=0}}");
        let tried = [wide, narrow].map(|set| run(rig, &[&set]).summary.watch.unwrap());
        let has_name = |r: &WatchReport| r.events.iter().any(|e| !e.set.is_empty());
        assert_eq!(
            tried.each_ref().map(has_name),
            [false, true],
            "{key}: {tried:?}"
        );
    }
}

#[test]
fn a_load_cell_with_a_declared_mass_has_no_noise_of_its_own() {
    // A noise that comes up with the motion is the mass's as well as the sensor's.
    let rig =
        "[[plant.effects]]\nname = 'sensor_noise'\nsensor = 'force'\nrms_n = 60\nfrom_s = 8\n";
    let declared = "declared.specimen.mass_kg={value=20,tolerance=4}";
    let [undeclared, declared] =
        [&[][..], &[declared]].map(|set| run(rig, set).summary.watch.unwrap());
    assert!(holds(named(&undeclared), "sensor_noise", "force"));
    assert!(
        declared.events.iter().all(|e| e.set.is_empty()),
        "{declared:?}"
    );
    let [said] = &declared.not_watched[..] else {
        panic!("{declared:?}")
    };
    assert!(said.starts_with("Noise and hum of the load cell"), "{said}");
}

#[test]
fn where_a_declared_value_cannot_be_watched_nothing_is_and_the_sentence_says_why() {
    let told = [
        "declared.actuator.delay_ms.value=200",
        "estimation.delay_ms=6",
        "estimation.lag_ms=8",
        "compensation.delay_ms=6",
    ];
    let report = run("", &told).summary.watch.unwrap();
    let [why] = &report.not_watched[..] else {
        panic!("{:?}", report.not_watched);
    };
    assert!(why.starts_with("Nothing is watched"), "{why}");
    assert!(why.contains("delay_s = 0.2"), "{why}");
    assert!(report.events.is_empty() && report.watchable.is_empty());
}

#[test]
fn what_the_watch_cannot_do_is_refused_and_its_names_are_the_catalogues() {
    for (set, said) in [
        ("watch.correct=['latenes']", "`latenes` (`lateness`?)"),
        ("watch.trip_eps=-0.1", "watch.trip_eps"),
        ("watch={on=false, trip_eps=0.1}", "watch.on"),
    ] {
        let e = TestFile::parse(RIG, "t.toml", Path::new(""), &[set.to_owned()]).unwrap_err();
        assert!(e.to_string().contains(said), "{e}");
    }
    let adaptive = "[compensation]\nkind = 'ats'\n[watch]\ncorrect = ['lateness']\n";
    let text = RIG.replace("[compensation]\nkind = 'inverse'\n", adaptive);
    let test = TestFile::parse(&text, "t.toml", Path::new(""), &[]).unwrap();
    let method = test.config.compensation.kind;
    let experiment = Experiment::new(test, &near_fault(), Some(1.0)).unwrap();
    let ideal = experiment.ideal().unwrap();
    let refused = experiment.run(method, &ideal, 3, false, ()).unwrap_err();
    assert!(refused.to_string().contains("learns lateness"), "{refused}");
    for cause in outerloop_core::watch::Cause::ALL {
        let known = |e: &&plant::Effect| e.name() == cause.name();
        assert!(plant::Effect::ALL.iter().any(|e| known(&e)), "{cause:?}");
    }
}
