//! `outerloop benchmark rths`: its rules on the problem's records if available, the rest on a generated earthquake.

use crate::common::{is_as_its_schema_says, json, outerloop, refused};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const RTHS: [&str; 2] = ["benchmark", "rths"];

fn with<'a>(arguments: &[&'a str]) -> Vec<&'a str> {
    [&RTHS[..], arguments].concat()
}

fn rows<'a>(answer: &'a Value, controller: &str) -> Vec<&'a Value> {
    let all = answer["rows"].as_array().unwrap();
    all.iter()
        .filter(|r| r["controller"] == controller)
        .collect()
}

fn number(row: &Value, name: &str) -> f64 {
    row[name]
        .as_f64()
        .unwrap_or_else(|| panic!("{name} in {row}"))
}

const OURS: &str = "hydraulic/mu=1.5,hydraulic/mu=0.78/lead=0.5,amb/lead=1";

#[test]
fn official_rules_on_the_problems_own_record() {
    let Some(records) = test_data::file("ground-motion/RTHSBENCH_ElCentro.csv") else {
        return;
    };
    let folder = records.ancestors().nth(2).unwrap().to_owned();
    let folder = folder.to_string_lossy();
    let answer = json(&with(&[
        "--json",
        "--records",
        "ElCentro",
        "--controllers",
        OURS,
        "--plants",
        "2",
        "--data",
        &folder,
    ]));
    is_as_its_schema_says("benchmark-rths", &answer, "best");
    assert_eq!(answer["rules"], "official");
    // Targets for this program's developers are not part of the result.
    assert!(answer.get("targets").is_none());
    // Besides the rows: yielding specimens with the nominal plant, and the meaning of the criteria.
    for specimen in ["degrading", "pinched"] {
        assert_eq!(answer[specimen].as_array().unwrap().len(), 4 * 3);
        assert!(number(&answer[specimen][0], "energy_error") > 0.0);
    }
    assert_eq!(answer["criteria"].as_array().unwrap().len(), 9);
    for controller in OURS.split(',') {
        for row in rows(&answer, controller) {
            assert_eq!(row["lost"], 0, "{row}");
            assert_eq!(row["perturbed"], 2);
        }
    }
}

/// 30 s of decaying noise, always the same, as a ground motion in g.
pub fn earthquake(folder: &Path) -> PathBuf {
    let mut text = String::from("time_s,acc_g\n");
    let mut state = 1_u64;
    for i in 0..1500 {
        let t = f64::from(i) * 0.02;
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let noise = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        let strength = (t / 3.0) * (1.0 - t / 3.0).exp();
        writeln!(text, "{t:.4},{:.6}", 0.7 * noise * strength).unwrap();
    }
    let file = folder.join("decaying-noise.csv");
    std::fs::write(&file, text).unwrap();
    file
}

#[test]
fn an_earthquake_of_our_own_has_all_that_a_row_has_and_the_report_stands_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = earthquake(folder.path());
    let out = folder.path().join("out");
    let (file, out_text) = (file.to_string_lossy(), out.to_string_lossy());
    let arguments = with(&[
        "--json",
        "--plants",
        "4",
        "--controllers",
        "pi-phase-lead,hydraulic/mu=1.5,hydraulic,ats",
        "--record",
        &file,
        "--out",
        &out_text,
    ]);
    let mut found = json(&arguments);
    for (controller, most) in [
        ("pi-phase-lead", 130.0),
        ("hydraulic/mu=1.5", 5.0),
        ("ats", 8.0),
    ] {
        let rows = rows(&found, controller);
        assert_eq!(rows.len(), 4);
        for row in rows {
            for name in ["J1", "J2", "J3", "J4", "J5", "J6", "J7", "J8", "J9"] {
                assert!(number(row, name).is_finite());
            }
            assert!(number(row, "J4_worst_perturbed") < most, "{row}");
            // J2 as measured combines the remaining error and the sensor's noise, which are independent.
            let whole = number(row, "J2_true").hypot(number(row, "J2_floor"));
            assert!((number(row, "J2") / whole - 1.0).abs() < 0.08, "{row}");
        }
    }
    // The delay of the force spoils the result of a controller that does not correct it, however well it tracks.
    let j4 = |name| number(rows(&found, name)[3], "J4_true");
    assert!(j4("hydraulic") > 10.0 * j4("hydraulic/mu=1.5"));

    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("decaying-noise") && page.contains("<svg") && !page.contains(">NaN"));
    assert!(!page.contains(" src=") && !page.contains("href="));
    let written: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("rths.json")).unwrap()).unwrap();
    assert_eq!(written, found);
    let mut again = json(&arguments);
    for answer in [&mut found, &mut again] {
        answer["seconds"] = Value::Null;
        assert_eq!(answer["provenance"]["seed"], answer["seed"]);
        answer["provenance"] = Value::Null;
    }
    assert_eq!(again, found, "seeded runs repeat");
}

#[test]
fn deviations_have_their_own_figures_and_names() {
    let folder = tempfile::tempdir().unwrap();
    let file = earthquake(folder.path());
    let file = file.to_string_lossy();
    let with_rules = |rules: &[&str]| {
        let fixed = [
            "--json",
            "--plants",
            "0",
            "--controllers",
            "hydraulic",
            "--record",
            &file,
        ];
        json(&with(&[&fixed[..], rules].concat()))
    };
    let j4 = |answer: &Value| number(rows(answer, "hydraulic")[3], "J4_true");
    let official = with_rules(&[]);
    let no_delay = with_rules(&["--deviate", "no-unit-delay"]);
    assert_eq!(no_delay["rules"], "official + no-unit-delay");
    // One of one and a half samples is gone.
    let share = j4(&no_delay) / j4(&official);
    assert!((share - 1.0 / 3.0).abs() < 0.1, "{share}");
    let own = with_rules(&["--rules", "own"]);
    assert_eq!(own["rules"], "own");
    assert!(j4(&own) < 0.5 * j4(&official));
    let estimated = with_rules(&["--deviate", "root-mean-square,half-scale"]);
    assert_eq!(
        estimated["rules"],
        "official + root-mean-square + half-scale"
    );
}

#[test]
fn a_table_of_commands_from_outside_gets_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    let file = earthquake(folder.path());
    let table = folder.path().join("targets.csv");
    let (file, table_text) = (file.to_string_lossy(), table.to_string_lossy());
    let output = outerloop(&with(&[
        "--record",
        &file,
        "--case",
        "2",
        "--targets",
        &table_text,
    ]));
    assert!(output.status.success());
    let text = std::fs::read_to_string(&table).unwrap();
    let rows: Vec<[f64; 2]> = text
        .lines()
        .skip(2)
        .map(|line| {
            let mut cells = line.split(',').map(|c| c.parse().unwrap());
            [cells.next().unwrap(), cells.next().unwrap()]
        })
        .collect();
    // Sent ahead by the actuator's delay.
    let mut led = String::from("time_s,target_m,command_m\n");
    for (k, [time_s, target_m]) in rows.iter().enumerate() {
        let command_m = rows.get(k + 95).map_or(0.0, |r| r[1]);
        writeln!(led, "{time_s:.9},{target_m:.9e},{command_m:.9e}").unwrap();
    }
    std::fs::write(&table, &led).unwrap();
    let follow = with(&[
        "--json",
        "--record",
        &file,
        "--case",
        "2",
        "--follow",
        &table_text,
    ]);
    let answer = json(&follow);
    is_as_its_schema_says("benchmark-rths-follow", &answer, "criteria");
    let row = &answer["rows"][0];
    assert!(
        number(row, "J1").abs() < 3.0 && number(row, "J2") < 40.0,
        "{row}"
    );
    // The targets of another case differ.
    let wrong = with(&["--record", &file, "--case", "3", "--follow", &table_text]);
    refused(
        &wrong,
        &["is not that of this ground motion and case", "--targets"],
    );
    refused(
        &with(&["--record", &file, "--follow", &table_text]),
        &["--case"],
    );
}

#[test]
fn a_specimen_that_yields_takes_energy_and_is_another_test() {
    let folder = tempfile::tempdir().unwrap();
    let file = earthquake(folder.path());
    let file = file.to_string_lossy();
    for specimen in ["degrading", "pinched"] {
        let answer = json(&with(&[
            "--json",
            "--plants",
            "0",
            "--controllers",
            "ats,pi-phase-lead",
            "--record",
            &file,
            "--specimen",
            specimen,
        ]));
        let energy = |name| number(rows(&answer, name)[0], "energy_error");
        assert!(
            energy("ats") < 10.0 && energy("ats") < energy("pi-phase-lead"),
            "{specimen}"
        );
    }
}

#[test]
fn bad_input_is_refused_in_one_sentence() {
    for (arguments, said) in [
        (
            &["--controllers", "magic"][..],
            "the controller `magic` is unknown",
        ),
        (&["--controllers", "amb/lead=9"], "`lead=9` is beyond"),
        (&["--controllers", "amb/gain=2"], "`gain=2` is no setting"),
        (
            &["--controllers", "pi-phase-lead/lead=1"],
            "a setting of core's methods",
        ),
        (
            &["--plants", "2000"],
            "--plants 2000: accepted are 0 to 1000",
        ),
        (&["--record", "nowhere.csv"], "nowhere.csv"),
        (
            &["--records", "Northridge"],
            "--records: `Northridge` is unknown: accepted are ElCentro",
        ),
        (
            &["--rules", "mine"],
            "--rules mine: accepted are official and own",
        ),
        (&["--deviate", "luck"], "the deviation `luck` is unknown"),
        (&["--specimen", "jelly"], "the specimen `jelly` is unknown"),
    ] {
        refused(&with(arguments), &[said]);
    }
}

/// The multi-axial problem has the same kind of page: tables, plots, what J7 hides.
#[test]
fn the_multi_axial_problem_has_a_page_with_pictures() {
    let Some(file) = test_data::file("marths/K_matrix.csv") else {
        return;
    };
    let data = file.ancestors().nth(2).unwrap().to_string_lossy();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_string_lossy();
    let output = outerloop(&[
        "benchmark",
        "marths",
        "--records",
        "ElCentro",
        "--controllers",
        "rodeac,coupled",
        "--plants",
        "1",
        "--data",
        &data,
        "--out",
        &out,
    ]);
    assert!(output.status.success(), "{output:?}");
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert_eq!(
        page.matches("<figure>").count(),
        4,
        "x, rotation, two actuators"
    );
    for word in [
        "<td>rodeac</td>",
        "<td>coupled</td>",
        "mrad",
        "subtracted as physical",
    ] {
        assert!(page.contains(word), "{word}");
    }
    let text = std::fs::read_to_string(folder.path().join("marths.json")).unwrap();
    let answer: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(rows(&answer, "coupled")[0]["record"], "ElCentro");
    assert_eq!(answer["declared_part"][0]["record"], "ElCentro");
}
