//! `outerloop board desk` on the emulated board, with the chip's own converters and with external ones: four wires in place of
//! a rig, a whole test, and crashes.
#![allow(missing_docs)]

mod common;

use common::{command, narrow, refused};
use outerloop_cli::board::desk::MODEL_CYCLES;
use serde_json::Value;

/// What the emulated board cannot show.
const NOT_SHOWN: usize = 3;

#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn four_wires_close_the_loop_of_the_emulated_board_with_every_bit_proven() {
    goes_through(&[], ("NUCLEO-F429ZI", 8190));
}

#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn four_wires_close_the_loop_behind_external_converters_with_every_bit_proven() {
    let image = ["--image", "nucleo_f429zi_16"];
    goes_through(&image, ("NUCLEO-F429ZI 16 bits", 65_535));
}

#[test]
fn an_image_that_four_wires_make_no_rig_is_refused_in_one_sentence() {
    let line = "board desk --emulated --out desk --image nucleo_f429zi_3";
    let words: Vec<&str> = line.split(' ').collect();
    refused(&words, &["`nucleo_f429zi_3`", "nucleo_f429zi_16"]);
}

/// All rows of the desk, on the image that is asked for: whose board has this name, and sensors with this highest code.
fn goes_through(image: &[&str], (board, sensor_top): (&str, u16)) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().display().to_string();
    let short = ["--seconds", "0.5", "--duration", "0.5"];
    let mut desk = command(&["board", "desk", "--emulated", "--out", &out]);
    desk.args(short).args(["--methods", "none,afp,lagrange"]);
    desk.args(image);
    let (status, said) = narrow::told(desk);
    println!("{said}");
    assert_eq!(status, Some(0));
    narrow::check("board desk", &said);

    let text = std::fs::read_to_string(folder.path().join("desk.json")).unwrap();
    let found: Value = serde_json::from_str(&text).unwrap();
    let own = &found["board"];
    assert_eq!(
        (&own["board"], &own["codes"]["sensor_top"]),
        (&board.into(), &sensor_top.into())
    );
    let rows = found["rows"].as_array().unwrap();
    let with = |verdict: &str| rows.iter().filter(|row| row["verdict"] == verdict).count();
    // Two rates, the two methods that the image carries, the whole test, the calibration, eight drills and the reset pin.
    assert_eq!((with("good"), with("not_done")), (15, NOT_SHOWN), "{text}");
    assert_eq!(rows.len(), 15 + NOT_SHOWN);

    // Each method's cycles beside the model's, which has neither the sample before the step nor the command behind it.
    let of_afp = |row: &&Value| row["what"].as_str().unwrap().starts_with("afp for");
    let afp = rows.iter().find(of_afp).unwrap()["found"].as_str().unwrap();
    let number_behind = |words: &str| -> u32 {
        let (_, behind) = afp.split_once(words).expect(afp);
        let digits = behind.split(|letter: char| !letter.is_ascii_digit());
        digits.into_iter().next().unwrap().parse().expect(afp)
    };
    let model = number_behind("; the model of the step alone: ");
    let worst = number_behind("; step ");
    assert!(MODEL_CYCLES.contains(&("afp", model)), "{afp}");
    assert!(worst > model && worst < 4 * model, "{afp}");

    let whole = |row: &&Value| row["what"].as_str().unwrap().contains("closed loop");
    let whole = rows.iter().find(whole).unwrap()["found"].as_str().unwrap();
    let (before, _) = whole.split_once(" steps proven").unwrap();
    let steps: u32 = before.rsplit(' ').next().unwrap().parse().unwrap();
    assert!(whole.starts_with("completed") && steps >= 1000, "{whole}");

    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("15 rows as they have to be, 0 not, 3 not done"));
}
