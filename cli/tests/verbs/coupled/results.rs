//! Keys, records and archives.

use super::{EXAMPLE, run};
use crate::common::{KEYS, json};

#[test]
fn results_have_the_keys_of_other_tests_and_the_record_both_systems() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let said = json(&["run", EXAMPLE, "--json", "--duration", "5", "--out", out]);
    for key in KEYS.into_iter().chain(["provenance", "seed"]) {
        assert!(said.get(key).is_some(), "{key}");
    }
    let record = std::fs::read_to_string(folder.path().join("record.csv")).unwrap();
    let head = record.lines().next().unwrap();
    for name in [
        "target_m",
        "displacement_m",
        "force_n",
        "target2_rad",
        "displacement2_rad",
        "force2_n_m",
        "actuator_command_m",
        "actuator_displacement2_m",
        "actuator_force2_n",
        "true_displacement2_rad",
        "true_actuator_displacement2_m",
    ] {
        assert!(head.split(',').any(|c| c == name), "{name} in {head}");
    }
    assert_eq!(record.lines().count(), 1 + 5 * 1000);
    let mut names: Vec<&str> = head.split(',').collect();
    names.sort_unstable();
    assert!(names.windows(2).all(|w| w[0] != w[1]), "{head}");
    // Channels that such a test does not have are no columns of zeros.
    assert!(
        !head.contains("gain") && !head.contains("damping"),
        "{head}"
    );
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    let drawn = page.split("<script>").next().unwrap();
    assert!(drawn.contains("What the actuators did") && drawn.contains("<svg"));

    let model = folder.path().join("model.toml");
    let declared = "[coupled]\ncoordinates = [\"x_m\", \"rotation_rad\"]\n\
         mass = [[{ value = 0, tolerance = 1 }, { value = 0, tolerance = 0.1 }], [{ value = 0, tolerance = 0.1 }, { value = 0, tolerance = 0.1 }]]\n\
         damping = [[{ value = 0, tolerance = 50 }, { value = 0, tolerance = 50 }], [{ value = 0, tolerance = 50 }, { value = 0, tolerance = 50 }]]\n\
         stiffness = [[{ value = 104e3, tolerance = 2e3 }, { value = 30e3, tolerance = 1e3 }], [{ value = 30e3, tolerance = 1e3 }, { value = 96e3, tolerance = 2e3 }]]\n";
    std::fs::write(&model, declared).unwrap();
    let record = folder.path().join("record.csv");
    let record = record.to_str().unwrap();
    let (train, test) = (format!("{record}@0..2.5"), format!("{record}@2.5.."));
    let model = model.to_str().unwrap();
    let found = json(&[
        "diagnose", "--model", model, "--train", &train, "--test", &test, "--json",
    ]);
    assert_eq!(found["coordinates"].as_array().unwrap().len(), 2);
}

#[test]
fn it_says_that_nothing_is_watched() {
    let said = run(&[]).3.watch.unwrap().sentence();
    assert!(said.contains("two actuators on one coupler"), "{said}");
}

#[test]
fn an_archive_is_replayed_to_the_bit_and_two_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (first, second) = (path("first.h5"), path("second.h5"));
    let run = ["run", EXAMPLE, "--duration", "6", "--json"];
    json(&[&run[..], &["--archive", &first]].concat());
    let other = ["--set", "coupled.spread.gain_ratio=0.02"];
    json(&[&run[..], &other, &["--archive", &second]].concat());
    for archive in [&first, &second] {
        let said = json(&["replay", archive, "--json"]);
        assert_eq!(said["values_different"], 0);
        assert_eq!(said["steps"], 6 * 1000);
    }
    let said = json(&["diff", &first, &second, "--json"]);
    let channels = said["channels"].as_array().unwrap();
    let of = |name: &str| channels.iter().find(|c| c["channel"] == name).unwrap();
    assert!(of("target_m")["rms_of_peak"].as_f64().unwrap() > 0.0);
    assert_eq!(of("target2_rad")["unit"], "rad");
    assert!(of("actuator_command2_m")["rms"].as_f64().unwrap() > 0.0);
    assert!(
        channels
            .iter()
            .all(|c| c["channel"] != "target2_m" && c["channel"] != "command_m")
    );
}
