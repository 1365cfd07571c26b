//! `outerloop board desk` on the emulated board, with the chip's own converters and with external ones: four wires in
//! place of a rig, a whole test, and crashes.
#![allow(missing_docs)]

mod common;

use common::{command, is_as_its_schema_says, json, narrow, outerloop, refused, root};
use link::Telemetry;
use link::frame::{Decoder, FrameKind};
use outerloop_cli::board::desk::MODEL_CYCLES;
use outerloop_cli::board::emulated::{Emulated, EmulatedRig};
use outerloop_cli::board::{Image, Port};
use outerloop_core::Mode;
use serde_json::Value;
use serialport::{ClearBuffer, SerialPort, TTYPort};
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Rows beside those of the methods: two rates, the saves, the whole test, the calibration, eight drills and the reset pin.
const OTHER_ROWS: usize = 14;

#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn four_wires_close_the_loop_of_the_emulated_board_with_every_bit_proven() {
    let short = ["--duration", "0.5", "--methods", SOME];
    goes_through(&short, ("NUCLEO-F429ZI", 8190), (3, 1));
}

#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn four_wires_close_the_loop_behind_external_converters_with_every_bit_proven() {
    let short = ["--duration", "0.5", "--methods", SOME];
    let image = [&short[..], &["--image", "nucleo_f429zi_16"]].concat();
    goes_through(&image, ("NUCLEO-F429ZI 16 bits", 65_535), (3, 1));
}

/// Its image is not the released one, which has fewer methods.
#[test]
#[ignore = "needs an image with all methods and the emulator: scripts/emu-test --nightly runs it"]
fn every_method_keeps_its_deadline_on_the_desk_with_every_bit_proven() {
    let whole = ["--duration", "0.5"];
    goes_through(&whole, ("NUCLEO-F429ZI", 8190), (MODEL_CYCLES.len(), 0));
}

#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn the_pages_lines_run_one_test_at_a_serial_port() {
    for (image, block) in [(Image::Internal, 0), (Image::External, 1)] {
        as_the_page_says(image, block);
    }
}

/// A program that is gone without a word, as docs/commissioning.md has it tried: fault 12 after half a second, and PERMIT low.
#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn the_pages_lines_on_a_program_that_is_killed_in_a_slow_sine_are_so() {
    let folder = tempfile::tempdir().unwrap();
    write_calibration(folder.path(), 0);
    at_a_port(Image::Internal, |port, board| {
        let calibrate = "board calibrate --port /dev/ttyACM0 --file four-wires.toml";
        follow(calibrate, port, folder.path());
        let signal = "--signal sine --amplitude-mm 1 --from-hz 1 --seconds 60 --out sine.csv";
        let line = format!("board commission examples/desk.toml --port {port} {signal}");
        let mut sine = in_folder(&line, port, folder.path());
        sine.args(["--yes", "--piston-at", "none"]);
        let sine = sine.stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        let mut sine = Killed(sine.unwrap());
        let began = board.until(Mode::Commissioning, || {});
        while board.now().1 < began + Duration::from_secs(1) {
            std::thread::sleep(Duration::from_millis(5));
        }
        assert_eq!(board.now().0, Some(Mode::Commissioning));
        let killed = board.now().1;
        sine.0.kill().unwrap();
        sine.0.wait().unwrap();
        // Nothing is sent from here on, and what comes is thrown away.
        let line = serialport::new(port, link::BAUD).open().unwrap();
        let tripped = board.until(Mode::Tripped, || line.clear(ClearBuffer::Input).unwrap());
        drop(line);
        let after_ms = (tripped - killed).as_millis();
        println!("tripped {after_ms} ms after the program was killed");
        // Its last message was up to a tenth of a second old. Telemetry and the killing take some milliseconds.
        assert!((380..700).contains(&after_ms), "{after_ms} ms");
        let status = json(&["board", "status", "--port", port, "--json"]);
        assert_eq!(status["trip"]["fault"], 12, "{status}");
        assert_eq!(status["permit"], false, "{status}");
        let said = outerloop(&["board", "status", "--port", port]).stdout;
        let said = String::from_utf8(said).unwrap();
        assert!(said.contains("tripped on link_lost"), "{said}");
    });
}

#[test]
fn an_image_that_four_wires_make_no_rig_is_refused_in_one_sentence() {
    let line = "board desk --emulated --out desk --image nucleo_f429zi_3";
    let words: Vec<&str> = line.split(' ').collect();
    refused(&words, &["`nucleo_f429zi_3`", "nucleo_f429zi_16"]);
}

/// A method's cycles and those of the model, which includes neither sampling nor command output.
fn stands_beside_the_model(rows: &[Value], method: &str) {
    let begins = format!("{method} for");
    let of_method = |row: &&Value| row["what"].as_str().unwrap().starts_with(&begins);
    let row = rows.iter().find(of_method).unwrap();
    let found = row["found"].as_str().unwrap();
    let number_behind = |words: &str| -> u32 {
        let (_, behind) = found.split_once(words).expect(found);
        let digits = behind.split(|letter: char| !letter.is_ascii_digit());
        digits.into_iter().next().unwrap().parse().expect(found)
    };
    let model = number_behind("; the model of the step alone: ");
    let worst = number_behind("; step ");
    assert!(MODEL_CYCLES.contains(&(method, model)), "{found}");
    assert!(worst > model && worst < 4 * model, "{found}");
}

/// Methods of a short desk test; the released images are built without the last.
const SOME: &str = "none,afp,paper+hydraulic,lagrange";

/// All rows of the desk with these options, on a board of this name and this highest sensor code, whose image has `built` of
/// the methods asked for and lacks others.
fn goes_through(
    options: &[&str],
    (board, sensor_top): (&str, u16),
    (built, lacking): (usize, usize),
) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().display().to_string();
    let mut desk = command(&["board", "desk", "--emulated", "--out", &out]);
    desk.args(["--seconds", "0.5"]).args(options);
    let (status, said) = narrow::told(desk);
    println!("{said}");
    assert_eq!(status, Some(0));
    narrow::check("board desk", &said);

    let text = std::fs::read_to_string(folder.path().join("desk.json")).unwrap();
    let found: Value = serde_json::from_str(&text).unwrap();
    is_as_its_schema_says("board-desk", &found, "rows");
    let own = &found["board"];
    assert_eq!(
        (&own["board"], &own["codes"]["sensor_top"]),
        (&board.into(), &sensor_top.into())
    );
    let rows = found["rows"].as_array().unwrap();
    let with = |verdict: &str| rows.iter().filter(|row| row["verdict"] == verdict).count();
    // The levels of the pins are never done.
    let (good, not_done) = (OTHER_ROWS + built, 1 + lacking);
    assert_eq!((with("good"), with("not_done")), (good, not_done), "{text}");
    assert_eq!(rows.len(), good + not_done);

    for method in ["afp", "paper+hydraulic"] {
        stands_beside_the_model(rows, method);
    }

    let whole = |row: &&Value| row["what"].as_str().unwrap().contains("closed loop");
    let whole = rows.iter().find(whole).unwrap()["found"].as_str().unwrap();
    let (before, _) = whole.split_once(" steps proven").unwrap();
    let steps: u32 = before.rsplit(' ').next().unwrap().parse().unwrap();
    assert!(whole.starts_with("completed") && steps >= 1000, "{whole}");

    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    let counted = format!("{good} rows as they have to be, 0 not, {not_done} not done");
    assert!(page.contains(&counted), "{counted}");
}

/// One test by itself, by the page's own lines and its block for `four-wires.toml`, at a serial port with the emulated
/// board behind it.
fn as_the_page_says(image: Image, block: usize) {
    let folder = tempfile::tempdir().unwrap();
    let by_itself = write_calibration(folder.path(), block);
    let lines = by_itself
        .lines()
        .filter_map(|l| l.strip_prefix("    outerloop "));
    let lines: Vec<&str> = lines.take(2).collect();
    assert!(lines[0].starts_with("board calibrate") && lines[1].starts_with("run"));

    at_a_port(image, |port, _| {
        for line in lines {
            follow(line, port, folder.path());
        }
        for order in ["identify", "status"] {
            let (status, text) = narrow::told(command(&["board", order, "--port", port]));
            assert_eq!(status, Some(0), "{text}");
            narrow::check(order, &text);
        }
        for (order, without) in [
            ("identify", "codes"),
            ("status", "mode"),
            ("calibrate", "calibration"),
            ("clear", "provenance"),
        ] {
            let answer = json(&["board", order, "--port", port, "--json"]);
            is_as_its_schema_says(&format!("board-{order}"), &answer, without);
        }
        // What it writes is what it reads.
        let number = || json(&["board", "calibrate", "--port", port, "--json"])["number"].clone();
        let before = number();
        for more in ["--out shown", "--file shown/calibration.toml"] {
            let line = format!("board calibrate --port /dev/ttyACM0 {more}");
            follow(&line, port, folder.path());
        }
        assert_eq!(number(), before);
    });
    let written = folder.path().join("four-wires/summary.json");
    let summary: Value = serde_json::from_str(&std::fs::read_to_string(written).unwrap()).unwrap();
    let own = &summary["board"];
    assert_eq!(summary["verdict"], "completed", "{summary}");
    assert_eq!(
        (&own["steps_lost"], &own["steps_different"]),
        (&0.into(), &0.into()),
        "{own}"
    );
    assert!(own["steps_received"].as_u64().unwrap() > 1000, "{own}");
}

/// Writes the page's block for `four-wires.toml` into this folder; gives the page's section.
fn write_calibration(folder: &Path, block: usize) -> String {
    let page = std::fs::read_to_string(root().join("docs/desk.md")).unwrap();
    let (_, by_itself) = page.split_once("## One test by itself").unwrap();
    let copied = by_itself.split("```toml\n").nth(1 + block).unwrap();
    let (copied, _) = copied.split_once("```").unwrap();
    std::fs::write(folder.join("four-wires.toml"), copied).unwrap();
    by_itself.to_owned()
}

/// Acts on the emulated board at a serial port.
fn at_a_port(image: Image, act: impl FnOnce(&str, &Seen)) {
    let (mut outside, inside) = TTYPort::pair().unwrap();
    let port = inside.name().unwrap();
    // Its raw settings last while it is open here; `inside` is closed, since the tool needs exclusive access.
    let _open = File::open(&port).unwrap();
    drop(inside);
    let seen = Seen::default();
    std::thread::scope(|scope| {
        let board = scope.spawn(|| be_the_board(image, &mut outside, &seen));
        let ends = Ends(&seen.ended);
        act(&port, &seen);
        drop(ends);
        board.join().unwrap();
    });
}

/// What the board shows, whoever is at its port.
#[derive(Default)]
struct Seen {
    /// It is switched off.
    ended: AtomicBool,
    /// Its mode in the last telemetry, and its time.
    now: Mutex<(Option<Mode>, Duration)>,
}

impl Seen {
    fn now(&self) -> (Option<Mode>, Duration) {
        *self.now.lock().unwrap()
    }

    /// Waits for this mode, doing `meanwhile`; gives the board's time then.
    fn until(&self, mode: Mode, meanwhile: impl Fn()) -> Duration {
        let began = Instant::now();
        loop {
            let (now, at) = self.now();
            if now == Some(mode) {
                return at;
            }
            assert!(began.elapsed() < LONGEST, "it is {now:?}, not {mode:?}");
            meanwhile();
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// How long a mode may take to come on a busy machine.
const LONGEST: Duration = Duration::from_secs(60);

/// A program that does not outlive its test.
struct Killed(Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Ends the board when dropped, even if a line fails.
struct Ends<'a>(&'a AtomicBool);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// A line of the page, at this port and in this folder.
fn in_folder(line: &str, port: &str, folder: &Path) -> Command {
    let words = line.split(' ').map(|word| match word {
        "/dev/ttyACM0" => port.to_owned(),
        "examples/desk.toml" => root().join(word).display().to_string(),
        word => word.to_owned(),
    });
    let words: Vec<String> = words.collect();
    let mut tool = command(&words.iter().map(String::as_str).collect::<Vec<_>>());
    tool.current_dir(folder);
    tool
}

/// Runs it, without questions and with a short test.
fn follow(line: &str, port: &str, folder: &Path) {
    let mut tool = in_folder(line, port, folder);
    if line.starts_with("run") {
        tool.args(["--yes", "--piston-at", "none", "--duration", "0.5"]);
    }
    let output = tool.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    let refused = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}: {said}{refused}");
    println!("{said}");
}

/// The emulated board on its desk, by the wall clock, at the other end of a serial port. Unread bytes are lost, as on any
/// line.
fn be_the_board(image: Image, port: &mut TTYPort, seen: &Seen) {
    let rig = EmulatedRig {
        real_time: true,
        ..EmulatedRig::on_desk(image, None).unwrap()
    };
    let mut board = Emulated::start(&rig).unwrap();
    port.set_timeout(Duration::from_millis(100)).unwrap();
    let (mut bytes, mut decoder) = ([0; 4096], Decoder::new());
    while !seen.ended.load(Ordering::Relaxed) {
        if port.bytes_to_read().unwrap() > 0 {
            let count = port.read(&mut bytes).unwrap();
            board.write(&bytes[..count]).unwrap();
        }
        let count = board.read(&mut bytes).unwrap();
        for byte in &bytes[..count] {
            let frame = decoder.push(*byte);
            let telemetry = frame.filter(|f| f.kind == FrameKind::Telemetry);
            if let Some(told) = telemetry.and_then(|f| Telemetry::decode(f.body)) {
                let mode = told.steps.last().and_then(|step| step.mode());
                *seen.now.lock().unwrap() = (mode, board.now());
            }
        }
        let _ = port.write_all(&bytes[..count]);
    }
}
