//! What it is told of the rig, and what it says that it cannot see.

use crate::effects::EACH;
use crate::{RIG, holds, named, run, run_file};
use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::watch::WatchReport;
use std::path::Path;

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
    // In a comparison it leaves lateness to a method that learns it.
    let correct = "watch.correct=['lateness']".to_owned();
    let test = TestFile::parse(RIG, "t.toml", Path::new(""), &[correct]).unwrap();
    let experiment = Experiment::new(test, &near_fault(), Some(1.0)).unwrap();
    experiment.run(method, &ideal, 3, false, ()).unwrap();
    for cause in outerloop_core::watch::Cause::ALL {
        let known = |e: &&plant::Effect| e.name() == cause.name();
        assert!(plant::Effect::ALL.iter().any(|e| known(&e)), "{cause:?}");
    }
}
