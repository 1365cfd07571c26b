//! `record.h5` and the archive: read by h5py and by this program, and replayed to the bit.

use crate::common::{json, json_with, outerloop, refused, root};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

const FRAME: &str = "examples/steel-frame.toml";

/// 1.5 s of the noisy steel frame, ten times slower than real time, archived.
fn archived(folder: &Path) -> String {
    let file = folder.join("test.h5").display().to_string();
    let out = folder.join("out").display().to_string();
    json(&[
        "run",
        FRAME,
        "--json",
        "--duration",
        "1.5",
        "--seed",
        "7",
        "--archive",
        &file,
        "--out",
        &out,
    ]);
    file
}

#[test]
fn an_archived_test_is_worked_out_again_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let file = archived(folder.path());
    let found = json(&["replay", &file, "--json"]);
    assert_eq!(found["values_different"], 0, "{found}");
    assert!(found["channels"].as_u64().unwrap() >= 16);
    let out = folder.path().join("out");
    let record = out.join("record.h5").display().to_string();
    let said = String::from_utf8(outerloop(&["replay", &record]).stdout).unwrap();
    assert!(said.contains("the same to the bit"), "{said}");
    let again = folder.path().join("again").display().to_string();
    let page = |file: &str| {
        let output = outerloop(&["replay", file, "--out", &again]);
        let page = std::fs::read_to_string(format!("{again}/report.html")).unwrap();
        (output, page)
    };
    assert!(page(&record).1.contains("class=\"verdict good\""));

    // One wrong bit in one force value is found, with its location.
    let mut bytes = std::fs::read(&file).unwrap();
    let h5 = hdf5_pure::File::from_bytes(bytes.clone()).unwrap();
    let force: Vec<f32> = h5.dataset("force_n").unwrap().read().unwrap();
    let at = 1234;
    let pattern: Vec<u8> = force[at..at + 8]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let place = bytes
        .windows(pattern.len())
        .position(|w| w == pattern)
        .unwrap();
    bytes[place] ^= 1;
    std::fs::write(&file, &bytes).unwrap();
    let found = json_with(1, &["replay", &file, "--json"]);
    assert_eq!(found["values_different"], 1);
    let first = found["first_difference"].as_str().unwrap();
    assert!(first.starts_with("force_n at step 1234"), "{first}");
    let (output, page) = page(&file);
    assert!(page.contains("class=\"verdict bad\"") && page.contains(first));
    assert!(String::from_utf8_lossy(&output.stderr).contains(first));

    let whole = std::fs::read(folder.path().join("out/record.h5")).unwrap();
    let flags: Vec<u32> = h5.dataset("flags_1").unwrap().read().unwrap();
    let pattern: Vec<u8> = flags[..64].iter().flat_map(|x| x.to_le_bytes()).collect();
    let mut forged = whole.clone();
    let place = { forged.windows(pattern.len()) }.position(|w| w == pattern);
    forged[place.unwrap()] ^= 1;
    std::fs::write(&file, &forged).unwrap();
    let found = json_with(1, &["replay", &file, "--json"]);
    let first = found["first_difference"].as_str().unwrap();
    assert!(first.starts_with("flags at step 0, "), "{first}");

    // Items that no step depends on are checked as well: a time, or a word of the summary.
    let text = |word: &str| -> Vec<u8> { word.encode_utf16().flat_map(u16::to_le_bytes).collect() };
    for (name, pattern, other) in [
        (
            "time_s",
            0.0625_f64.to_le_bytes().to_vec(),
            0.0626_f64.to_le_bytes().to_vec(),
        ),
        ("summary", text("\"completed\""), text("\"complxted\"")),
    ] {
        let mut forged = whole.clone();
        let place = forged
            .windows(pattern.len())
            .position(|w| w == pattern)
            .unwrap();
        forged[place..place + other.len()].copy_from_slice(&other);
        std::fs::write(&file, &forged).unwrap();
        let found = json_with(1, &["replay", &file, "--json"]);
        assert_eq!(found["values_different"], 0);
        assert_eq!(found["changed"], serde_json::json!([name]));
    }

    refused(&["replay", FRAME], &["steel-frame.toml", "is no archive"]);
    std::fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    refused(&["replay", &file], &["cannot be replayed"]);
}

#[test]
fn summary_and_report_say_who_ran_what_when() {
    let folder = tempfile::tempdir().unwrap();
    archived(folder.path());
    let read = |name: &str| std::fs::read_to_string(folder.path().join("out").join(name)).unwrap();
    let summary: Value = serde_json::from_str(&read("summary.json")).unwrap();
    assert_eq!(summary["seed"], 7);
    let origin = &summary["provenance"];
    assert!(
        origin["command"]
            .as_str()
            .unwrap()
            .contains("run examples/steel-frame.toml --json")
    );
    assert!(origin["date"].as_str().unwrap().starts_with("20"));
    assert_eq!(origin["files"][0]["file"], FRAME);
    let hash = origin["files"][0]["sha256"].as_str().unwrap();
    let sum = Command::new("sha256sum")
        .arg(FRAME)
        .current_dir(root())
        .output()
        .unwrap();
    assert!(String::from_utf8(sum.stdout).unwrap().starts_with(hash));
    let report = read("report.html");
    for word in [
        hash,
        "operator",
        "run examples/steel-frame.toml",
        "[structure]",
    ] {
        assert!(report.contains(word), "{word}");
    }
}

#[test]
fn h5py_opens_the_record() {
    let venv = Command::new("scripts/h5py-venv")
        .current_dir(root())
        .output()
        .unwrap();
    if !venv.status.success() {
        test_data::not_run(&format!(
            "h5py: {}",
            String::from_utf8_lossy(&venv.stderr).trim()
        ));
        return;
    }
    let python = String::from_utf8(venv.stdout).unwrap();
    let folder = tempfile::tempdir().unwrap();
    archived(folder.path());
    let script = r#"
import csv, json, sys, h5py, numpy
h5 = h5py.File(sys.argv[1] + "/record.h5", "r")
text = lambda d: "".join(map(chr, numpy.asarray(d).ravel()))
rows = list(csv.reader(open(sys.argv[1] + "/record.csv")))
for j, name in enumerate(rows[0]):
    column = numpy.asarray(h5[name]).ravel()
    kind = numpy.float64 if name == "time_s" else column.dtype
    assert (column == numpy.array([row[j] for row in rows[1:]]).astype(kind)).all(), name
    assert h5[name].attrs["MATLAB_class"] in (b"single", b"double", b"uint32"), name
assert text(h5["units/force_n"]) == "N" and text(h5["units/velocity_m_per_s"]) == "m/s"
assert json.loads(text(h5["summary"]))["verdict"] == "completed"
assert json.loads(text(h5["repeat"]))["seed"] == 7
assert "[structure]" in text(h5["test_file"])
print(len(rows) - 1, len(rows[0]))
"#;
    let output = Command::new(root().join(python.trim()))
        .args(["-c", script])
        .arg(folder.path().join("out"))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "30000 19");
}
