//! `outerloop serve` with clients that write bytes directly: what a genericClient of OpenSees sends, and what it never should.
//! With OpenSees itself: `tests/opensees.rs`.
#![allow(missing_docs)]

mod client;
#[path = "../common/mod.rs"]
mod common;
mod coupled;
mod emulated;

use client::{Client, STIFFNESS, Server, integrate};
use common::{is_as_its_schema_says, root};
use serde_json::Value;
use std::io::Write;
use std::process::Command;
use std::time::{Duration, Instant};

#[test]
fn a_served_linear_specimen_is_the_models_own_spring_at_a_thousand_steps_a_second() {
    let mut server = Server::start(&[]);
    let mut client = server.client();
    assert_eq!(client.ask(12.0), Some(STIFFNESS), "initial stiffness");
    assert_eq!(client.ask(13.0), Some(STIFFNESS), "tangent stiffness");
    assert_eq!(client.ask(14.0), Some(0.0), "damping is in the force");
    assert_eq!(client.ask(15.0), Some(0.0), "mass is, too");
    let began = Instant::now();
    let served = integrate(3000, |u, t| client.step(u, t).unwrap());
    let rate = 3000.0 / began.elapsed().as_secs_f64();
    client.say(&[99.0]);
    let own = integrate(3000, |u, _| STIFFNESS * u);
    let peak = own.iter().fold(0.0_f64, |p, u| p.max(u.abs()));
    let apart = own.iter().zip(&served).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0, f64::max) / peak;
    assert!(peak > 0.01 && apart < 1e-9, "{apart} of {peak} m");
    assert!(rate > 1000.0, "{rate} steps a second");
    let account = server.account();
    is_as_its_schema_says("serve", &account, "verdict");
    assert_eq!(account["verdict"], "completed");
    assert_eq!(
        (&account["targets"], &account["commits"]),
        (&3000.into(), &3000.into())
    );
    assert_eq!(account["permit"], false);
    assert!((account["peak_displacement_m"].as_f64().unwrap() / peak - 1.0).abs() < 1e-6);
    assert!(account["tracking_max_m"].as_f64().unwrap() < 1e-7);
    assert!(
        account.get("coordinates").is_none(),
        "x and rotation are others'"
    );
}

type Mischief = fn(&mut Client);

/// What a client may do, with the verdict and the reason.
const MISCHIEF: [(&str, &str, Mischief); 10] = [
    ("lost", "closed the connection", |c| {
        let _ = c.0.shutdown(std::net::Shutdown::Both);
    }),
    ("lost", "bytes into a message", |c| {
        let _ = c.0.write_all(&[0; 100]);
        let _ = c.0.shutdown(std::net::Shutdown::Both);
    }),
    ("lost", "s at most (serve.timeout_s)", |c| {
        assert_eq!(c.receive(), None)
    }),
    ("lost", "100 bytes into a message", |c| {
        let _ = c.0.write_all(&[0; 100]);
        assert_eq!(c.receive(), None);
    }),
    ("refused", "displacement 1 = NaN", |c| {
        assert!(c.step(f64::NAN, 0.1).unwrap().is_nan());
    }),
    ("refused", "displacement 1 = 1000000000 at 0.1 s", |c| {
        assert!(c.step(1e9, 0.1).unwrap().is_nan());
    }),
    ("refused", "the time inf", |c| {
        assert!(c.step(0.0, f64::INFINITY).unwrap().is_nan());
    }),
    ("refused", "asks for action 0.25", |c| {
        // NaN until the client leaves, or a closed connection, which OpenSees itself never notices.
        assert!(c.ask(0.25).is_none_or(f64::is_nan));
    }),
    (
        "refused",
        "in the same step: an integrator that iterates",
        |c| {
            c.say(&[3.0, 0.001, 0.0, 0.0, 0.1]);
            assert!(c.ask(10.0).is_some());
            c.say(&[3.0, 0.001, 0.5, 0.5, 0.1]);
            assert!(c.ask(10.0).is_some(), "another velocity is no other target");
            c.say(&[3.0, 0.002, 0.0, 0.0, 0.1]);
            assert!(c.ask(10.0).is_none_or(f64::is_nan));
        },
    ),
    ("refused", "goes back from 0.1 s to 0.05 s", |c| {
        assert!(c.step(0.001, 0.1).is_some());
        assert!(c.step(0.002, 0.05).unwrap().is_nan());
    }),
];

#[test]
fn whatever_a_client_does_the_rig_stands_the_reason_is_said_and_the_next_one_is_served() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("kept");
    let mut server = Server::start(&[
        "--out",
        out.to_str().unwrap(),
        "--set",
        "serve.timeout_s=0.4",
    ]);
    for (number, (verdict, reason, mischief)) in MISCHIEF.into_iter().enumerate() {
        let mut client = server.client();
        for i in 1..=20 {
            let u = 1e-3 * f64::from(i % 7);
            let force = client.step(u, 1e-3 * f64::from(i)).unwrap();
            assert!((force - STIFFNESS * u).abs() < 1e-6 * STIFFNESS * 1e-3);
        }
        mischief(&mut client);
        let account = server.account();
        let said = account["reason"].as_str().unwrap_or_default();
        assert_eq!(account["verdict"], verdict, "{reason}: {account}");
        assert!(
            said.contains(reason) && !said.contains('\n'),
            "{reason}: {said}"
        );
        assert_eq!(account["permit"], false, "{reason}");
        assert!(account["targets"].as_u64().unwrap() >= 20);
        // Nothing is lost: every step so far is in the record.
        let kept = match number {
            0 => out.clone(),
            n => folder.path().join(format!("kept-{}", n + 1)),
        };
        let lines = |name: &str| std::fs::read_to_string(kept.join(name)).unwrap();
        let steps = account["steps"].as_u64().unwrap() as usize;
        assert_eq!(lines("record.csv").lines().count(), steps + 1);
        assert!(lines("summary.json").contains(&account["client"].to_string()));
    }
    // An invalid first message.
    for (header, reason) in [
        ([7; 11], "controls 7 displacements and the rig has 1"),
        ([-3; 11], "is none of OpenSees'"),
    ] {
        let mut client = Client::connect(&server.address, &header);
        assert_eq!(client.receive(), None);
        let account = server.account();
        assert!(account["reason"].to_string().contains(reason), "{account}");
        assert_eq!(
            (&account["targets"], &account["permit"]),
            (&0.into(), &false.into())
        );
    }
    let mut silent = Client::connect(&server.address, &[]);
    assert_eq!(silent.receive(), None);
    assert!(
        server.account()["reason"]
            .to_string()
            .contains("said nothing for 0.4 s after it had connected")
    );
    // A connection without a valid first message leaves no folder.
    let folders = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(folders, MISCHIEF.len());
}

/// A connection that sends nothing, or only a few bytes, keeps no client waiting, however long the timeout.
#[test]
fn connections_that_do_not_speak_keep_no_client_waiting() {
    let mut server = Server::start(&["--set", "serve.timeout_s=3600"]);
    let began = Instant::now();
    let _silent: Vec<Client> = (0..20)
        .map(|i| Client::connect(&server.address, &vec![1; i % 3]))
        .collect();
    let mut client = server.client();
    assert!(client.step(0.001, 0.1).is_some());
    drop(client);
    let reason = |server: &mut Server| server.account()["reason"].to_string();
    assert!(reason(&mut server).contains("closed the connection"));
    for _ in 0..20 {
        assert!(reason(&mut server).contains("said nothing for 5 s"));
    }
    // In sequence they would have taken 100 s.
    assert!(began.elapsed().as_secs() < 60, "{:?}", began.elapsed());
}

/// As with Ctrl-C: the rig comes to rest, the record is kept, and the exit status says that the test was not completed.
#[test]
#[cfg(unix)]
fn a_signal_in_the_middle_of_a_test_keeps_the_record() {
    for signal in ["-TERM", "-HUP"] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("out");
        let mut server = Server::start(&["--out", out.to_str().unwrap()]);
        let mut client = server.client();
        client.step(1e-3, 0.02).unwrap();
        common::send_signal(&server.child, signal);
        // Further requests get no force, as soon as the signal has arrived.
        let answered = |i: i32| {
            let answer = client.step(1e-3 + 1e-6 * f64::from(i), 0.02 * f64::from(i));
            answer.is_some_and(f64::is_finite)
        };
        assert!(!(2..2000).all(answered), "{signal}");
        drop(client);
        let account = server.account();
        assert_eq!(account["verdict"], "stopped", "{account}");
        assert_eq!(account["permit"], false, "{account}");
        assert_eq!(server.child.wait().unwrap().code(), Some(1), "{signal}");
        let record = std::fs::read_to_string(out.join("record.csv")).unwrap();
        assert!(record.lines().count() > 10, "{record}");
    }
    // If nothing moves, the exit status is 0.
    let mut idle = Server::start(&[]);
    common::send_signal(&idle.child, "-TERM");
    assert_eq!(idle.child.wait().unwrap().code(), Some(0));
}

/// A rig with a force limit of 1 kN, sent to 5 mm and then to 10 mm.
fn passes_its_force_limit(server: &mut Server) {
    let mut client = server.client();
    assert!(client.step(0.005, 0.1).is_some());
    // OpenSees would wait forever on a closed connection, so the reply is NaN.
    assert!(client.step(0.01, 0.2).unwrap().is_nan());
    assert!(client.step(0.01, 0.3).unwrap().is_nan());
    client.say(&[99.0]);
    let account = server.account();
    assert_eq!(
        (&account["verdict"], &account["trip"]),
        (&"tripped".into(), &"force".into())
    );
    assert_eq!(account["permit"], false);
}

#[test]
fn a_specimen_that_passes_its_force_limit_trips_and_answers_nothing_more() {
    let mut server = Server::start(&["--quiet", "--once", "--set", "limits.force_n=1000"]);
    passes_its_force_limit(&mut server);
    assert_eq!(
        server.child.wait().unwrap().code(),
        Some(1),
        "--once says how it went"
    );
}

#[test]
fn units_on_the_wire_are_the_models() {
    let mut server = Server::start(&[
        "--once",
        "--set",
        "serve.length_unit=in",
        "--set",
        "serve.force_unit=kip",
    ]);
    let mut client = server.client();
    // 158 kN/m are 0.902 kip/in.
    let expected = STIFFNESS * 0.0254 / 4448.2216152605;
    let near = |x: Option<f64>, y: f64| assert!((x.unwrap() / y - 1.0).abs() < 1e-12, "{x:?} {y}");
    near(client.ask(12.0), expected);
    near(client.step(0.5, 0.1), 0.5 * expected);
    // The command is in single precision.
    assert!((client.ask(7.0).unwrap() - 0.5).abs() < 1e-7);
    client.say(&[99.0]);
    assert_eq!(server.account()["verdict"], "completed");
    assert_eq!(server.child.wait().unwrap().code(), Some(0));
}

/// An actuator with a delay of 8 ms and a model with a step of 10 ms, in real time; `sleep` is the model's time for a step, ms.
fn continuous(place: &[&str], sleep: impl Fn(usize) -> u64) -> (Value, Vec<f64>) {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "--once",
        "--out",
        folder.path().to_str().unwrap(),
        "--set",
        "serve.pace=continuous",
        "--set",
        "loop.substeps=20",
        "--set",
        "loop.solve_substeps=12",
        "--set",
        "plant.actuator.kind=delay",
        "--set",
        "plant.actuator.delay_ms=8",
    ];
    let mut server = Server::start(&[&arguments, place].concat());
    let mut client = server.client();
    let mut count = 0;
    integrate(300, |u, t| {
        count += 1;
        std::thread::sleep(Duration::from_millis(sleep(count)));
        client.step(u, t).unwrap()
    });
    client.say(&[99.0]);
    let account = server.account();
    assert_eq!(server.child.wait().unwrap().code(), Some(0));
    let record = std::fs::read_to_string(folder.path().join("record.csv")).unwrap();
    let mut lines = record.lines();
    let mut names = lines.next().unwrap().split(',');
    let column = names.position(|name| name == "command_m").unwrap();
    let command = lines.map(|l| l.split(',').nth(column).unwrap().parse().unwrap());
    (account, command.collect())
}

#[test]
fn a_model_that_is_sometimes_late_holds_the_rig_and_goes_on_without_a_jump() {
    let (punctual, smooth) = continuous(&[], |_| 0);
    let (late, held) = continuous(&[], now_and_then);
    for account in [&punctual, &late] {
        assert_eq!(account["verdict"], "completed", "{account}");
        assert_eq!(account["targets"], 300);
        // Eqs 12 and 14: the energy that the delay puts in is measured, and a damping removes it.
        assert!(account["energy_error_j"].as_f64().unwrap() < 0.0);
        assert!(account["mean_added_damping_n_s_per_m"].as_f64().unwrap() > 100.0);
    }
    assert!(late["late_targets"].as_u64().unwrap() >= 5, "{late}");
    let longest = late["longest_late_ms"].as_f64().unwrap();
    assert!((30.0..100.0).contains(&longest), "{late}");
    without_a_jump(&held, &smooth);
}

/// Time for a step of a model that is late in five steps of three hundred, ms.
fn now_and_then(step: usize) -> u64 {
    if step % 60 == 59 { 60 } else { 0 }
}

/// Compares the largest step of the command with that of a model that is never late.
#[track_caller]
fn without_a_jump(held: &[f64], smooth: &[f64]) {
    let most = |c: &[f64]| {
        let steps = c.windows(2).map(|w| (w[1] - w[0]).abs());
        steps.fold(0.0, f64::max)
    };
    // After a hold the command has 8 of 20 control steps to reach its target, at no more than 1.5 times their mean velocity.
    assert!(most(held) < 1.5 * 20.0 / 8.0 * most(smooth));
    let wide = held.iter().fold(0.0_f64, |p, u| p.max(u.abs()));
    assert!(
        most(held) < 0.1 * wide,
        "no jump: {} of {wide} m",
        most(held)
    );
}

#[test]
fn a_test_that_cannot_be_served_is_refused_in_one_sentence() {
    for (set, reason) in [
        ("serve.pace=hop", "serve.pace"),
        ("serve.timeout_s=0", "serve.timeout_s = 0"),
        ("serve.settle_ms=-1", "serve.settle_ms = -1"),
        ("serve.pace=continuous", "loop.solve_substeps is 0"),
    ] {
        let out = Command::new(env!("CARGO_BIN_EXE_outerloop"))
            .args(["serve", "examples/opensees.toml", "--set", set])
            .current_dir(root())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{said}");
        assert!(
            said.contains(reason) && said.trim().lines().count() == 1,
            "{said}"
        );
    }
    for (test, reason) in [
        ("examples/table1.toml", "limits.displacement_m is missing"),
        ("examples/hybrid.toml", "structure.physical_storeys"),
    ] {
        let out = Command::new(env!("CARGO_BIN_EXE_outerloop"))
            .args(["serve", test])
            .current_dir(root())
            .output()
            .unwrap();
        assert_eq!(out.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&out.stderr).contains(reason));
    }
}
