//! The scope's page and a report in headless Chromium, driven over its DevTools protocol.
#![allow(missing_docs)]

mod common;

use common::{PATIENCE, command, root};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Seconds for which a browser watches; OUTERLOOP_SCOPE_SECONDS changes this.
const SECONDS: u64 = 8;

/// A process that ends with the test.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts `command` and gives the first line of its standard error that contains `mark`.
fn started(command: &mut Command, mark: &str) -> (Ended, String) {
    let mut child = command
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap());
    let child = Ended(child);
    let mut line = String::new();
    while !line.contains(mark) {
        line.clear();
        assert!(
            said.read_line(&mut line).unwrap() > 0,
            "it ended without {mark}"
        );
    }
    std::thread::spawn(move || std::io::copy(&mut said, &mut std::io::sink()));
    (child, line.trim().to_owned())
}

/// A page of a browser.
struct Page {
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    number: u64,
}

impl Page {
    fn open(devtools: &str) -> Self {
        let host = devtools.split('/').nth(2).unwrap();
        let began = Instant::now();
        loop {
            let mut stream = TcpStream::connect(host).unwrap();
            write!(
                stream,
                "GET /json/list HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"
            )
            .unwrap();
            // It keeps the connection open, whatever the request says.
            let wait = Some(Duration::from_millis(300));
            stream.set_read_timeout(wait).unwrap();
            let (mut answer, mut part) = (Vec::new(), [0; 4096]);
            while let Ok(count @ 1..) = stream.read(&mut part) {
                answer.extend_from_slice(&part[..count]);
            }
            let answer = String::from_utf8_lossy(&answer);
            let body = answer.split_once("\r\n\r\n").map_or("", |(_, body)| body);
            let pages: Value = serde_json::from_str(body).unwrap_or_default();
            if let Some(url) = pages
                .as_array()
                .into_iter()
                .flatten()
                .find(|p| p["type"] == "page")
                .and_then(|p| p["webSocketDebuggerUrl"].as_str())
            {
                let socket = tungstenite::connect(url).unwrap().0;
                return Self { socket, number: 0 };
            }
            assert!(began.elapsed() < PATIENCE, "{pages}");
        }
    }

    fn ask(&mut self, method: &str, parameters: Value) -> Value {
        self.number += 1;
        let request = json!({ "id": self.number, "method": method, "params": parameters });
        self.socket
            .send(Message::text(request.to_string()))
            .unwrap();
        loop {
            if let Message::Text(text) = self.socket.read().unwrap() {
                let answer: Value = serde_json::from_str(&text).unwrap();
                if answer["id"] == self.number {
                    return answer["result"].clone();
                }
            }
        }
    }

    fn value(&mut self, expression: &str) -> Value {
        let parameters =
            json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        self.ask("Runtime.evaluate", parameters)["result"]["value"].clone()
    }

    fn wait(&mut self, expression: &str) {
        let began = Instant::now();
        while self.value(expression) != true {
            let text = self.value("document.body.innerText");
            assert!(began.elapsed() < PATIENCE, "{expression}: {text}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

fn chromium() -> Option<&'static str> {
    let found = ["chromium", "google-chrome", "chromium-browser"]
        .into_iter()
        .find(|name| {
            let asked = Command::new(name).arg("--version").output();
            asked.is_ok_and(|out| out.status.success())
        });
    if found.is_none() {
        test_data::not_run("Chromium is not installed (scripts/setup)");
    }
    found
}

/// A browser with a page, and the folder of its profile.
fn open_in(chromium: &str, url: &str) -> (Ended, tempfile::TempDir, Page) {
    let profile = tempfile::tempdir().unwrap();
    let (browser, line) = started(
        Command::new(chromium)
            .args([
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-background-networking",
            ])
            .args(["--remote-debugging-port=0", "--window-size=1200,1000"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg(url),
        "DevTools listening on",
    );
    let page = Page::open(line.split_whitespace().last().unwrap());
    (browser, profile, page)
}

fn look_on(arguments: &[&str]) {
    let Some(chromium) = chromium() else { return };
    let seconds = std::env::var("OUTERLOOP_SCOPE_SECONDS");
    let seconds = seconds.ok().and_then(|s| s.parse().ok()).unwrap_or(SECONDS);
    let emulated = arguments.contains(&"--emulated");
    // A board has no room for so many points of ground motion, so there the test runs ten times slower than the
    // earthquake.
    let laboratory_s = seconds * 3 + 60;
    let duration = (if emulated {
        laboratory_s / 10
    } else {
        laboratory_s
    })
    .to_string();
    let (mut test, line) = started(
        command(arguments).args(["--scope", "--duration", &duration]),
        "the scope is at",
    );
    let url = line.split_whitespace().last().unwrap();
    let (browser, _profile, mut page) = open_in(chromium, url);
    page.wait("document.getElementById('mode').textContent === 'running'");
    assert!(
        page.value("document.body.innerText")
            .to_string()
            .contains("not the emergency stop")
    );
    // A browser that has just started first has to catch up.
    page.wait("Date.now() - newest.wall_ms < 200");
    // While it watches, every step arrives, in order and soon.
    let before = page.value("[steps, Date.now()]");
    let mut latency: Vec<f64> = Vec::new();
    let began = Instant::now();
    while began.elapsed() < Duration::from_secs(seconds) {
        std::thread::sleep(Duration::from_millis(200));
        // The age of the newest message when the page is asked; at worst its latency plus the period between two.
        latency.push(page.value("Date.now() - newest.wall_ms").as_f64().unwrap());
    }
    let after = page.value("[steps, Date.now()]");
    let number = |v: &Value, i: usize| v[i].as_f64().unwrap();
    let rate = (number(&after, 0) - number(&before, 0)) / (number(&after, 1) - number(&before, 1));
    latency.sort_by(f64::total_cmp);
    let typical = latency[latency.len() / 2];
    println!(
        "{rate:.2} steps a ms; asked {} times, the newest point is {typical} ms old, {} ms at the 99th percentile, {} ms at most",
        latency.len(),
        latency[latency.len() * 99 / 100],
        latency[latency.len() - 1]
    );
    assert_eq!(page.value("lost"), 0, "no step is missing");
    if emulated {
        assert!(rate > 0.1, "{rate}");
    } else {
        assert!((1.8..2.2).contains(&rate), "{rate} steps a ms");
    }
    assert!(typical < 100.0, "{latency:?}");
    if seconds >= 120 {
        // This limit requires that the machine does nothing else.
        assert!(latency[latency.len() * 99 / 100] < 100.0, "{latency:?}");
    }
    // The plots are drawn: an empty one would have a single colour.
    let drawn = "[...document.querySelectorAll('canvas')].every(c => { const d = c.getContext('2d').getImageData(60, 0, c.width - 70, c.height).data; return new Set(new Uint32Array(d.buffer)).size > 4 })";
    assert_eq!(page.value(drawn), true, "every plot has a curve");
    if let Some(file) = std::env::var_os("OUTERLOOP_SCREENSHOT") {
        let shot = page.ask("Page.captureScreenshot", json!({ "format": "png" }));
        let text = shot["data"].as_str().unwrap();
        std::fs::write(root().join(file), base64(text)).unwrap();
    }
    // Buttons.
    assert_eq!(
        page.value("document.getElementById('resume').disabled"),
        true
    );
    page.value("document.getElementById('hold').click()");
    page.wait("document.getElementById('mode').textContent === 'holding'");
    page.value("document.getElementById('resume').click()");
    page.wait("document.getElementById('mode').textContent === 'running'");
    // A page of another origin and a wrong token are both refused.
    let (host, token) = url.trim_start_matches("http://").split_once('/').unwrap();
    let token = token.trim_end_matches('/');
    page.ask(
        "Page.navigate",
        json!({ "url": "data:text/html,<title>foreign</title>" }),
    );
    page.wait("document.title === 'foreign'");
    let opened = format!(
        "new Promise(said => {{ const s = new WebSocket('ws://{host}/{token}/ws'); s.onopen = () => said('opened'); s.onerror = () => said('refused') }})"
    );
    assert_eq!(page.value(&opened), "refused", "a foreign origin");
    let wrong = format!("http://{host}/{}/", "0".repeat(32));
    page.ask("Page.navigate", json!({ "url": wrong }));
    page.wait("document.title !== 'foreign' && document.readyState === 'complete'");
    let body = page.value("document.body.innerText").to_string();
    assert!(!body.contains("emergency stop"), "a wrong token: {body}");
    // A closed browser disturbs nothing.
    drop(page);
    drop(browser);
    std::thread::sleep(Duration::from_millis(500));
    assert!(test.0.try_wait().unwrap().is_none(), "the test goes on");
}

#[test]
fn a_plot_of_a_report_is_saved_as_numbers_and_as_a_drawing() {
    let Some(chromium) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let test = ["run", "examples/table1.toml", "--duration", "10", "--quiet"];
    let ran = command(&[&test[..], &["--out", out]].concat()).status();
    assert!(ran.unwrap().success());
    let (_browser, _profile, mut page) = open_in(chromium, &format!("file://{out}/report.html"));
    // A browser may show its empty first page for a moment, which is also complete.
    page.wait(
        "location.protocol === 'file:' && document.readyState === 'complete'
         && document.querySelectorAll('.plot .save button').length >= 2",
    );
    // The files to be saved are kept here, in the order of the buttons.
    let saved = page.value(
        "window.blobs = []; HTMLAnchorElement.prototype.click = () => {};
         URL.createObjectURL = (blob) => { blobs.push(blob); return 'blob:none' };
         for (const b of [...document.querySelectorAll('.plot .save button')].slice(0, 2)) b.click();
         Promise.all(blobs.map((blob) => blob.text())).then((texts) => window.saved = texts)",
    );
    assert_eq!(saved.as_array().map(Vec::len), Some(2), "{saved}");
    let (csv, svg) = (saved[0].as_str().unwrap(), saved[1].as_str().unwrap());
    let mut lines = csv.lines();
    let head = "\"curve\",\"time of the model [s]\",\"displacement [mm]\"";
    assert_eq!(lines.next(), Some(head));
    let tested = lines.filter_map(|line| line.strip_prefix("\"test\","));
    let values = tested.map(|line| line.split_once(',').unwrap().1.parse::<f64>().unwrap());
    let peak = values.fold(0.0, |peak: f64, x| peak.max(x.abs()));
    let summary = std::fs::read_to_string(folder.path().join("summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&summary).unwrap();
    let whole = summary["peak_displacement_m"].as_f64().unwrap() * 1e3;
    assert!((peak / whole - 1.0).abs() < 1e-3, "{peak} mm of {whole} mm");
    for word in [
        "time of the model [s]",
        "displacement [mm]",
        "ideal actuator",
        "<style",
    ] {
        assert!(svg.contains(word), "{word}");
    }
    let sound =
        "!new DOMParser().parseFromString(saved[1], 'image/svg+xml').querySelector('parsererror')";
    assert_eq!(page.value(sound), true, "{svg}");
    // The files that the page links to are next to it.
    let links =
        page.value("[...document.querySelectorAll('a')].map((a) => a.getAttribute('href'))");
    for link in links.as_array().unwrap() {
        assert!(
            folder.path().join(link.as_str().unwrap()).exists(),
            "{link}"
        );
    }
}

/// Decodes base64 without a library, for an optional screenshot.
fn base64(text: &str) -> Vec<u8> {
    let digit = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let letters: Vec<u8> = text.bytes().filter(|c| *c != b'=').collect();
    let mut bytes = Vec::new();
    for four in letters.chunks(4) {
        let bits = four
            .iter()
            .fold(0_u32, |bits, c| bits << 6 | u32::from(digit(*c)));
        let bits = bits << (6 * (4 - four.len()));
        bytes.extend_from_slice(&bits.to_be_bytes()[1..four.len()]);
    }
    bytes
}

#[test]
fn a_browser_sees_every_step_of_a_running_test_and_its_buttons_work() {
    look_on(&["run", "examples/table1.toml"]);
}

/// For two minutes: `OUTERLOOP_SCOPE_SECONDS=120`, see docs/scope.md.
#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn a_browser_sees_every_step_of_a_test_on_the_emulated_board() {
    look_on(&[
        "run",
        "examples/table1.toml",
        "--emulated",
        "--set",
        "loop.time_scale=10",
    ]);
}
