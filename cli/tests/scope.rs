//! `--scope`: what a browser sees of a running test and what it may do. With Chromium itself: `tests/chromium.rs`.
#![allow(missing_docs)]

mod common;

use common::{PATIENCE, command, started};
use serde_json::Value;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::Child;
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// A test in real time with its scope.
struct Running {
    child: Child,
    host: String,
    token: String,
}

impl Running {
    fn start(seconds: &str) -> Self {
        Self::start_with(&["--duration", seconds])
    }

    fn start_with(more: &[&str]) -> Self {
        Self::of("examples/table1.toml", more)
    }

    fn of(test: &str, more: &[&str]) -> Self {
        let mut run = command(&["run", test, "--json", "--scope"]);
        run.args(more);
        let (child, mut said, line) = started(run, "http://");
        let url = line.split("http://").nth(1).expect(&line).trim();
        let (host, token) = url.split_once('/').unwrap();
        let (host, token) = (host.to_owned(), token.trim_end_matches('/').to_owned());
        assert!(
            host.starts_with("127.0.0.1:"),
            "the loopback unless told otherwise"
        );
        assert_eq!(token.len(), 32, "128 random bits");
        std::thread::spawn(move || std::io::copy(&mut said, &mut std::io::sink()));
        Self { child, host, token }
    }

    /// Status and body of a GET.
    fn get(&self, path: &str, host: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let status = answer.split(' ').nth(1).unwrap().parse().unwrap();
        (status, answer)
    }

    fn socket(
        &self,
        path: &str,
        origin: Option<&str>,
    ) -> Option<WebSocket<MaybeTlsStream<TcpStream>>> {
        let mut request = format!("ws://{}{path}", self.host)
            .into_client_request()
            .unwrap();
        if let Some(origin) = origin {
            let origin = origin.parse().unwrap();
            request.headers_mut().insert("Origin", origin);
        }
        tungstenite::connect(request).ok().map(|(socket, _)| socket)
    }

    fn own_socket(&self) -> WebSocket<MaybeTlsStream<TcpStream>> {
        let origin = format!("http://{}", self.host);
        let path = format!("/{}/ws", self.token);
        self.socket(&path, Some(&origin)).expect("its own page may")
    }

    fn account(mut self) -> Value {
        let mut out = String::new();
        self.child
            .stdout
            .as_mut()
            .unwrap()
            .read_to_string(&mut out)
            .unwrap();
        let _ = self.child.wait();
        serde_json::from_str(&out).unwrap()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn next(socket: &mut WebSocket<MaybeTlsStream<TcpStream>>) -> Option<Value> {
    loop {
        match socket.read().ok()? {
            Message::Text(text) => return serde_json::from_str(&text).ok(),
            Message::Close(_) => return None,
            _ => {}
        }
    }
}

#[test]
fn every_step_of_twelve_channels_arrives_in_time_and_no_peak_is_lost() {
    let running = Running::start("6");
    let mut socket = running.own_socket();
    let hello = next(&mut socket).unwrap();
    assert_eq!(hello["channels"].as_array().unwrap().len(), 12);
    let (mut expected, mut peak, mut steps, mut latency) = (None, 0.0_f64, 0, Vec::new());
    let mut last = Value::Null;
    while let Some(message) = next(&mut socket) {
        let now = std::time::SystemTime::now();
        let now = now
            .duration_since(std::time::UNIX_EPOCH)
            .unwrap()
            .as_millis() as f64;
        latency.push(now - message["wall_ms"].as_f64().unwrap());
        for point in message["points"].as_array().unwrap() {
            let number = |i: usize| point[i].as_f64().unwrap();
            let first = number(0);
            assert!(expected.is_none_or(|tick| tick == first), "no step is lost");
            expected = Some(first + number(1));
            steps += number(1) as usize;
            peak = peak.max(number(4)).max(-number(3));
        }
        last = message;
    }
    assert_eq!(last["ended"], true);
    let account = running.account();
    assert_eq!(account["steps"], 12_000);
    assert!(steps >= 12_000, "{steps}");
    // Values are sent with six digits.
    let true_peak = account["peak_displacement_m"].as_f64().unwrap() * 1e3;
    assert!((peak / true_peak - 1.0).abs() < 1e-5, "{peak} {true_peak}");
    // A message is sent every 20 ms; the worst few are due to other load on the machine.
    latency.sort_by(f64::total_cmp);
    assert!(latency[latency.len() * 9 / 10] < 100.0, "{latency:?}");
}

#[test]
fn what_the_rig_watch_says_is_shown_as_it_changes() {
    // The delay grows at 8 s.
    let running = Running::of("examples/rig-watch.toml", &["--duration", "10"]);
    let mut socket = running.own_socket();
    let (mut said, mut at_step) = (Vec::new(), Vec::new());
    while let Some(message) = next(&mut socket) {
        let Some(now) = message["watch"].as_str().map(str::to_owned) else {
            continue;
        };
        if said.last() != Some(&now) {
            said.push(now);
            at_step.push(message["step"].as_u64().unwrap());
        }
    }
    let named = said
        .iter()
        .position(|s| s.starts_with("named") && s.contains("delay_error"));
    let named = named.unwrap_or_else(|| panic!("{said:?}"));
    assert!(
        said[..named].iter().all(|s| !s.starts_with("named")),
        "{said:?}"
    );
    assert!(at_step[named] > 16_000, "{at_step:?}");
}

#[test]
fn without_the_token_or_from_another_origin_nothing_is_read_or_pressed() {
    let running = Running::start("20");
    let (host, token) = (running.host.clone(), running.token.clone());
    let (status, page) = running.get(&format!("/{token}/"), &host);
    assert!(status == 200 && page.contains("not the emergency stop"));
    assert!(
        !page.contains("http://") && !page.contains("https://"),
        "no network"
    );
    let wrong = "0".repeat(32);
    for (path, name) in [
        ("/".to_owned(), host.as_str()),
        (format!("/{wrong}/"), &host),
        // A foreign name for this address.
        (format!("/{token}/"), "rebound.example:80"),
    ] {
        let (status, body) = running.get(&path, name);
        assert!(status == 403 && !body.contains("<html"), "{path} {name}");
    }
    let own = format!("http://{host}");
    let path = format!("/{token}/ws");
    for (path, origin) in [
        (path.as_str(), None),
        (&path, Some("http://foreign.example")),
        (&path, Some("null")),
        (&format!("/{wrong}/ws"), Some(own.as_str())),
        ("/ws", Some(&own)),
    ] {
        assert!(running.socket(path, origin).is_none(), "{path} {origin:?}");
    }
}

#[test]
fn buttons_hold_resume_and_stop_and_a_browser_that_goes_disturbs_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut running = Running::start_with(&["--duration", "60", "--out", out.to_str().unwrap()]);
    let began = Instant::now();
    let mut socket = running.own_socket();
    let wait = |socket: &mut WebSocket<_>, mode: &str| {
        let began = Instant::now();
        loop {
            let message = next(socket).expect("the test goes on");
            if message["mode"] == mode {
                return message;
            }
            assert!(began.elapsed() < PATIENCE, "never {mode}");
        }
    };
    let message = wait(&mut socket, "running");
    assert_eq!(message["allowed"], serde_json::json!(["hold", "stop"]));
    // Requests that do not apply now, or are unknown, have no effect.
    for nothing in ["resume", "clear", "arm", "{}"] {
        socket.send(Message::text(nothing)).unwrap();
    }
    socket.send(Message::text("hold")).unwrap();
    let message = wait(&mut socket, "holding");
    assert_eq!(message["allowed"], serde_json::json!(["stop", "resume"]));
    let step = message["step"].as_u64().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    // Another browser, closed during the test.
    drop(running.own_socket());
    socket.send(Message::text("resume")).unwrap();
    let message = wait(&mut socket, "running");
    assert!(message["step"].as_u64().unwrap() < step + 400, "it stood");
    socket.send(Message::text("stop")).unwrap();
    while let Some(message) = next(&mut socket) {
        assert!(began.elapsed() < PATIENCE, "never stopped: {message}");
    }
    assert_eq!(
        running.child.wait().unwrap().code(),
        Some(1),
        "stopped by hand"
    );
    let summary = is_kept(&out);
    let archive = out.join("record.h5");
    let found = common::json(&["replay", archive.to_str().unwrap(), "--json"]);
    assert_eq!(found["values_different"], 0, "hold and all: {found}");
    assert_eq!(found["steps"], summary["steps"]);
}

/// Checks the record of a test that was stopped by hand, and its verdict.
fn is_kept(out: &Path) -> Value {
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["verdict"], "stopped");
    let record = std::fs::read_to_string(out.join("record.csv")).unwrap();
    let rows = record.lines().filter(|l| !l.starts_with('#')).count() - 1;
    assert_eq!(summary["steps"].as_u64().unwrap(), rows as u64, "kept");
    summary
}

/// `kill`, a closed terminal and Ctrl-C stop a simulated test as the button does, and it can be replayed.
#[test]
#[cfg(unix)]
fn signals_stop_a_simulated_test_and_its_record_is_kept() {
    for signal in ["-TERM", "-HUP", "-INT"] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let mut running =
            Running::start_with(&["--duration", "60", "--out", out.to_str().unwrap()]);
        let mut socket = running.own_socket();
        while next(&mut socket).expect("the test goes on")["mode"] != "running" {}
        common::send_signal(&running.child, signal);
        while next(&mut socket).is_some() {}
        assert_eq!(running.child.wait().unwrap().code(), Some(1), "{signal}");
        let summary = is_kept(&out);
        let archive = out.join("record.h5");
        let found = common::json(&["replay", archive.to_str().unwrap(), "--json"]);
        assert_eq!(found["values_different"], 0, "{signal}: {found}");
        assert_eq!(found["steps"], summary["steps"], "{signal}");
    }
}

/// Verbs that run many tests report how many were done, and their results.
#[test]
#[cfg(unix)]
fn a_signal_leaves_the_tests_that_are_done() {
    let test = "examples/table1.toml";
    let sweep = "plant.actuator.delay_ms=0..3/1000";
    for (verb, file) in [
        (
            &["monte-carlo", test, "--tests", "1000000"][..],
            "tests.csv",
        ),
        (
            &[
                "sweep",
                test,
                "--over",
                sweep,
                "--compensations",
                "paper,none,afp,ats,tangent",
            ],
            "sweep.csv",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let mut command = command(verb);
        command.args(["--quiet", "--out", folder.path().to_str().unwrap()]);
        let child = command
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_secs(4));
        common::send_signal(&child, "-TERM");
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{verb:?}: {said}");
        assert!(
            said.contains("tests ran, and only they are reported"),
            "{said}"
        );
        let kept = std::fs::read_to_string(folder.path().join(file)).unwrap();
        assert!(kept.lines().count() > 2, "{verb:?}: {kept}");
    }
}

/// SIGTERM, on the flashed image: every step so far is recorded, and repeated by a replay. The board's side:
/// `emu/tests/rig/stopped.rs`.
#[test]
#[cfg(unix)]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn a_signal_stops_the_emulated_board_and_keeps_the_record() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let more = [
        "--emulated",
        "--duration",
        "40",
        "--out",
        out.to_str().unwrap(),
    ];
    let mut running = Running::start_with(&more);
    let mut socket = running.own_socket();
    while next(&mut socket).expect("the test goes on")["mode"] != "running" {}
    common::send_signal(&running.child, "-TERM");
    while next(&mut socket).is_some() {}
    assert_eq!(running.child.wait().unwrap().code(), Some(1));
    let board = &is_kept(&out)["board"];
    assert_eq!(
        (&board["steps_lost"], &board["steps_different"]),
        (&0.into(), &0.into())
    );
    let archive = out.join("record.h5");
    let found = common::json(&["replay", archive.to_str().unwrap(), "--json"]);
    assert_eq!(found["values_different"], 0, "{found}");
}

#[test]
fn a_scope_that_cannot_listen_is_refused_in_one_sentence() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    common::refused(
        &["run", "examples/table1.toml", "--json", "--scope", &address],
        &["--scope", &address, "free port"],
    );
}
