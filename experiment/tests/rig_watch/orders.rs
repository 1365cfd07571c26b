//! What the watch does about what it has named: corrections, learning that is held, a stop.

use crate::{JUMP, RIG, holds, named, run, run_file};
use experiment::watch::NamedCause;

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
