//! An external model whose element is a rig behind the firmware's own station: the PC's side, over frames.

use experiment::files::test::TestFile;
use experiment::trace::Trace;
use host_tests::loopback::Loopback;
use outerloop_cli::board::{self, BoardConnection, Connection, Operator, Port, Timeouts};
use outerloop_cli::serve::{
    Arrival, DeclaredElement, Mover, SessionSummary, SessionVerdict, serve_client, serve_on_board,
};
use plant::Rig;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

const STIFFNESS: f64 = 158e3;
/// Numbers in a message.
const LENGTH: usize = 16;
pub const QUICK: Timeouts = Timeouts {
    answer: Duration::from_millis(200),
    stop: Duration::from_millis(40),
    silence: Duration::from_millis(200),
};

/// A rig 2 ms late. The loopback's time runs only while the PC reads, so a model is never too late for it.
fn test(pace: &str) -> TestFile {
    test_with(pace, &[])
}

fn test_with(pace: &str, more: &[&str]) -> TestFile {
    let text = "[structure]\nmass_kg = 1000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.02\n\
                [loop]\nsubsteps = 20\nsolve_substeps = 12\nlate_limit_steps = 60000\napproach_m_per_s = 0.2\n\
                [limits]\ndisplacement_m = 0.03\nforce_n = 7000\nvelocity_m_per_s = 1\ntracking_m = 0.02\n\
                [plant.actuator]\nkind = \"delay\"\ndelay_ms = 2\n[plant.specimen]\nkind = \"linear\"\n";
    let pace = format!("serve.pace={pace}");
    let overrides: Vec<String> = std::iter::once(pace.as_str())
        .chain(more.iter().copied())
        .map(str::to_owned)
        .collect();
    TestFile::parse(text, "t.toml", Path::new(""), &overrides).unwrap()
}

fn loopback(test: &TestFile) -> Loopback {
    let storeys = &test.config.structure.stiffness_n_per_m;
    Loopback::new(Rig::new(&test.plant, storeys, test.config.timing.rate_hz, 1).unwrap())
}

/// A board calibrated as it is wired, prepared by `prepare`.
fn served(test: &TestFile, prepare: impl FnOnce(&mut Loopback)) -> Box<dyn Mover> {
    let mut loopback = loopback(test);
    prepare(&mut loopback);
    let [wired] = loopback.board.hardware.board.wired;
    let port: Box<dyn Port> = Box::new(loopback);
    let mut connection: BoardConnection = Connection::new(port, QUICK);
    board::calibrate(&mut connection, wired).unwrap();
    serve_on_board(test, connection, Operator::not_asked(), false, true, None).unwrap()
}

/// A client that asks for the forces at each position, in steps of 10 ms; returns the answers.
fn client<const N: usize>(address: std::net::SocketAddr, path: Vec<[f64; N]>) -> Vec<[f64; N]> {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_nodelay(true).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(60)))
        .unwrap();
    let n = N as i32;
    let header = [n, n, n, 0, 1, 0, 0, 0, n, 0, LENGTH as i32];
    let bytes: Vec<u8> = header.iter().flat_map(|i| i.to_le_bytes()).collect();
    stream.write_all(&bytes).unwrap();
    let say = |stream: &mut TcpStream, numbers: &[f64]| {
        let mut message = [0.0; LENGTH];
        message[..numbers.len()].copy_from_slice(numbers);
        let bytes: Vec<u8> = message.iter().flat_map(|x| x.to_le_bytes()).collect();
        stream.write_all(&bytes)
    };
    let mut forces = Vec::new();
    for (i, u) in path.into_iter().enumerate() {
        let t = 0.01 * (i + 1) as f64;
        let mut answer = [0; 8 * LENGTH];
        let still = [0.0; N];
        let trial = [&[3.0], &u[..], &still, &still, &[t]].concat();
        let asked = say(&mut stream, &trial).and_then(|()| say(&mut stream, &[10.0]));
        if asked.is_err() || stream.read_exact(&mut answer).is_err() {
            return forces;
        }
        let (numbers, _) = answer.as_chunks();
        let force: [f64; N] = std::array::from_fn(|j| f64::from_le_bytes(numbers[j]));
        forces.push(force);
        if force[0].is_nan() {
            break;
        }
        let _ = say(&mut stream, &[5.0]);
    }
    let _ = say(&mut stream, &[99.0]);
    forces
}

/// One client on `rig`: its answers, the rig's account, and its record.
fn session(
    test: &TestFile,
    rig: &mut dyn Mover,
    path: &[f64],
) -> (Vec<f64>, SessionSummary, Trace) {
    let path: Vec<[f64; 1]> = path.iter().map(|u| [*u]).collect();
    let (forces, summary, trace) = session_of(test, rig, &path);
    (forces.into_flattened(), summary, trace)
}

/// The same with several degrees of freedom.
pub fn session_of<const N: usize>(
    test: &TestFile,
    rig: &mut dyn Mover,
    path: &[[f64; N]],
) -> (Vec<[f64; N]>, SessionSummary, Trace) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let (address, path) = (listener.local_addr().unwrap(), path.to_vec());
    let outside = std::thread::spawn(move || client(address, path));
    let (stream, client) = listener.accept().unwrap();
    let at = std::time::Instant::now();
    let arrival = Arrival { stream, client, at };
    let served = serve_client(arrival, &DeclaredElement::of(test).unwrap(), rig);
    let summary = served.summary.clone();
    served.answer_nan_until_gone();
    let trace = rig.take_trace().unwrap();
    (outside.join().unwrap(), summary, trace)
}

/// A sine of 10 mm.
fn swing(steps: usize) -> Vec<f64> {
    (0..steps).map(|i| 0.01 * (0.11 * i as f64).sin()).collect()
}

#[test]
fn a_board_serves_one_client_after_another_and_every_step_is_proven() {
    for pace in ["stop_and_go", "continuous"] {
        let t = test(pace);
        let mut rig = served(&t, |_| {});
        for _ in 0..2 {
            let path = swing(120);
            let (forces, summary, trace) = session(&t, rig.as_mut(), &path);
            let why = summary.sentences();
            assert_eq!(summary.verdict, SessionVerdict::Completed, "{pace}: {why}");
            assert!(!summary.permit && summary.targets == 120, "{why}");
            let board = summary.board.as_ref().unwrap();
            assert_eq!((board.steps_lost, board.steps_different), (0, 0), "{why}");
            assert_eq!(trace.len(), summary.steps);
            // A code is 24 um; in continuous mode the actuator is 2 ms behind, and the damping is in the answer.
            let room_n = if pace == "stop_and_go" { 12.0 } else { 120.0 };
            let first = usize::from(pace == "continuous");
            for (f, u) in forces.iter().zip(&path).skip(first) {
                assert!((f - STIFFNESS * u).abs() < room_n, "{pace}: {f} at {u}");
            }
        }
    }
}

#[test]
fn a_cut_wire_is_told_and_what_came_before_it_is_kept() {
    let t = test("stop_and_go");
    let mut rig = served(&t, |board| {
        let cut: host_tests::loopback::FaultInjection = Box::new(|b| b.cut = true);
        board.incidents.push_back((4000, cut));
    });
    let (forces, summary, trace) = session(&t, rig.as_mut(), &swing(400));
    assert_eq!(summary.verdict, SessionVerdict::RigLost);
    let why = summary.reason.unwrap();
    assert!(why.contains("the link to the board is lost"), "{why}");
    assert!(!forces.is_empty() && forces.len() < 400);
    assert_eq!(trace.len(), summary.steps);
    assert!(trace.len() > 1000, "nothing is lost");
    assert!(summary.board.unwrap().link.is_some());
}

#[test]
fn a_board_that_starts_again_under_a_client_is_told_at_once() {
    let t = test("stop_and_go");
    let (again, waits) = (t.clone(), Arc::new(AtomicBool::new(false)));
    let waited = Arc::clone(&waits);
    let mut rig = served(&t, |board| {
        // The board has run for 10 s; after a restart its step numbers need 10 s to reach this again.
        for _ in 0..1000 {
            board.read(&mut [0; 4096]).unwrap();
        }
        let fresh: host_tests::loopback::FaultInjection = Box::new(move |b| {
            *b = loopback(&again);
            let waited = Arc::clone(&waited);
            let late: host_tests::loopback::FaultInjection =
                Box::new(move |_| waited.store(true, Relaxed));
            b.incidents.push_back((10_000, late));
        });
        board.incidents.push_back((board.steps + 4000, fresh));
    });
    let (forces, summary, _) = session(&t, rig.as_mut(), &swing(400));
    assert_eq!(summary.verdict, SessionVerdict::RigLost);
    let why = summary.reason.unwrap();
    assert!(why.contains("the board has started again"), "{why}");
    assert!(!forces.is_empty() && forces.len() < 400 && !summary.permit);
    assert!(!waits.load(Relaxed), "told after 5 s of the board");
}

#[test]
fn a_lost_frame_ends_a_continuous_test_whose_answer_it_may_have_held_and_no_other() {
    for (pace, verdict) in [
        ("stop_and_go", SessionVerdict::Completed),
        ("continuous", SessionVerdict::RigLost),
    ] {
        // The specimen is not as declared, so that a force which was not measured would show.
        let yields = [
            "plant.specimen.kind='bilinear'",
            "plant.specimen.yield_mm=4",
        ];
        let t = test_with(pace, &yields);
        let (whole, ..) = session(&t, served(&t, |_| {}).as_mut(), &swing(200));
        let mut rig = served(&t, |board| {
            let lose: host_tests::loopback::FaultInjection = Box::new(|b| b.drop_frames = 1);
            board.incidents.push_back((2500, lose));
        });
        let (forces, summary, _) = session(&t, rig.as_mut(), &swing(200));
        let apart = forces.iter().zip(&whole).filter(|(f, _)| f.is_finite());
        let apart = apart.map(|(f, g)| (f - g).abs()).fold(0.0, f64::max);
        println!("{pace}: {} forces, {apart:.1} N apart", forces.len());
        assert!(apart < 30.0, "{pace}: {apart} N");
        assert_eq!(summary.verdict, verdict, "{pace}: {}", summary.sentences());
        assert!(summary.board.as_ref().unwrap().steps_lost > 0);
        assert!(!summary.permit);
        if pace == "continuous" {
            assert!(summary.reason.unwrap().contains("a step was lost"));
        }
    }
}

#[test]
fn a_step_that_came_out_otherwise_ends_it_at_a_standstill() {
    let t = test("stop_and_go");
    let mut rig = served(&t, |board| {
        let turn: host_tests::loopback::FaultInjection = Box::new(|b| b.wrong_bits = 1);
        board.incidents.push_back((2500, turn));
    });
    let (_, summary, _) = session(&t, rig.as_mut(), &swing(200));
    assert_eq!(summary.verdict, SessionVerdict::RigLost);
    assert!(summary.targets < 200 && !summary.permit);
    let why = summary.reason.unwrap();
    assert!(why.contains("worked a step out otherwise"), "{why}");
}

#[test]
fn a_force_beyond_its_limit_trips_the_board_and_stands_against_the_next_client() {
    let t = test("stop_and_go");
    let mut rig = served(&t, |_| {});
    let (_, summary, _) = session(&t, rig.as_mut(), &[0.01, 0.031]);
    assert_eq!(
        summary.verdict,
        SessionVerdict::Refused,
        "{}",
        summary.sentences()
    );
    let mut tight = t.clone();
    tight.config.limits.force_n = Some(1000.0);
    let mut rig = served(&tight, |_| {});
    let (forces, summary, _) = session(&tight, rig.as_mut(), &[0.004, 0.01]);
    assert_eq!(summary.trip, Some("force"), "{}", summary.sentences());
    assert!(forces[1].is_nan() && !summary.permit);
    // It stays where it tripped, beyond its limit: the next client is refused for that, and nothing moves.
    let (_, summary, _) = session(&tight, rig.as_mut(), &[0.002, 0.004]);
    assert_eq!(
        (summary.verdict, summary.permit),
        (SessionVerdict::Refused, false)
    );
    let why = summary.reason.unwrap();
    assert!(
        why.contains("the interlock force stands against it"),
        "{why}"
    );
}
