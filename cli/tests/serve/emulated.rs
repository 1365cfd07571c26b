//! The same with the flashed image on an emulated board.

use crate::client::{STIFFNESS, Server};
use crate::coupled::{SPECIMEN, STANDS, TARGETS, figure, times};
use crate::{MISCHIEF, continuous, now_and_then, passes_its_force_limit, without_a_jump};

/// After anything that a client may do, PERMIT is low, nothing is lost, and the next client is served.
#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn whatever_a_client_does_the_emulated_board_stands_and_the_next_one_is_served() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("kept");
    let mut server = Server::start(&[
        "--emulated",
        "--out",
        out.to_str().unwrap(),
        "--set",
        "serve.timeout_s=2",
        "--set",
        "limits.displacement_m=0.02",
        "--set",
        "limits.force_n=5000",
    ]);
    // The client closes, closes within a message, sends nothing, NaN, 1e9.
    let chosen = [0, 1, 2, 4, 5];
    for (number, (verdict, reason, mischief)) in chosen.map(|i| MISCHIEF[i]).into_iter().enumerate()
    {
        let mut client = server.client();
        for i in 1..=5 {
            let u = 1e-3 * f64::from(i);
            let force = client.step(u, 1e-3 * f64::from(i)).unwrap();
            // 12-bit codes over twice the range.
            assert!((force - STIFFNESS * u).abs() < 20.0, "{force} at {u}");
        }
        mischief(&mut client);
        let account = server.account();
        let said = account["reason"].as_str().unwrap_or_default();
        assert_eq!(account["verdict"], verdict, "{account}");
        assert!(said.contains(reason), "{reason}: {said}");
        assert_eq!(account["permit"], false, "{reason}");
        let board = &account["board"];
        assert_eq!(
            (&board["steps_lost"], &board["steps_different"]),
            (&0.into(), &0.into())
        );
        let kept = match number {
            0 => out.clone(),
            n => folder.path().join(format!("kept-{}", n + 1)),
        };
        let record = std::fs::read_to_string(kept.join("record.csv")).unwrap();
        let steps = account["steps"].as_u64().unwrap() as usize;
        assert_eq!(record.lines().count(), steps + 1, "nothing is lost");
    }
}

/// The board detects a late model by its own clock: it holds and resumes, and the PC recomputes every step.
#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn a_model_that_is_sometimes_late_holds_the_emulated_board_and_goes_on_without_a_jump() {
    let place = [
        "--emulated",
        "--set",
        "limits.displacement_m=0.2",
        "--set",
        "limits.force_n=40000",
        "--set",
        "limits.velocity_m_per_s=3",
        // The emulated clock does not wait for a busy machine.
        "--set",
        "loop.late_limit_steps=20000",
    ];
    let (_, smooth) = continuous(&[], |_| 0);
    let (late, held) = continuous(&place, now_and_then);
    assert_eq!(late["verdict"], "completed", "{late}");
    assert_eq!(
        (&late["targets"], &late["permit"]),
        (&300.into(), &false.into())
    );
    assert!(late["late_targets"].as_u64().unwrap() >= 5, "{late}");
    assert!(late["longest_late_ms"].as_f64().unwrap() >= 30.0, "{late}");
    let board = &late["board"];
    assert_eq!(
        (&board["steps_lost"], &board["steps_different"]),
        (&0.into(), &0.into())
    );
    without_a_jump(&held, &smooth);
}

#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn a_specimen_behind_the_emulated_board_that_passes_its_force_limit_trips_it() {
    let mut server = Server::start(&[
        "--emulated",
        "--set",
        "limits.displacement_m=0.02",
        "--set",
        "limits.force_n=1000",
    ]);
    passes_its_force_limit(&mut server);
}

/// Stiffness of a storey of `examples/three-storey.toml`, N/m.
const STOREY: f64 = 797.3e3;

/// The image for three actuators: a model with three degrees of freedom gets the forces of the frame from all three load
/// cells. A target beyond one floor's limit moves none of them, and the next client is served.
#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn three_actuators_of_the_emulated_board_answer_a_model_of_three_degrees_of_freedom() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("frame.toml");
    let text = format!(
        "[structure]\nmass_kg = [1000, 1000, 1000]\nstiffness_n_per_m = [{STOREY}, {STOREY}, {STOREY}]\n\
         damping_ratio = [0.02, 0.02, 0.02]\n\
         [loop]\nrate_hz = 1000\napproach_m_per_s = 0.2\n\
         [serve]\npace = 'stop_and_go'\nsettle_ms = 10\naverage_ms = 2\ntimeout_s = 60\n\
         [limits]\ndisplacement_m = 0.03\nforce_n = 20e3\n\
         [plant.actuator]\nkind = 'delay'\ndelay_ms = [3, 4, 5]\n"
    );
    std::fs::write(&file, text).unwrap();
    let mut server = Server::of(file.to_str().unwrap(), &["--emulated"]);
    let mut client = server.client_of(3);
    for i in 1..=6 {
        let t = 0.01 * f64::from(i);
        let u = [4e-3, 7e-3, -2e-3].map(|most: f64| most * (9.0 * t).sin());
        let force = client.step_all(u, t).unwrap();
        let ways = [u[0], u[1] - u[0], u[2] - u[1], 0.0];
        for (j, force) in force.into_iter().enumerate() {
            let own = STOREY * (ways[j] - ways[j + 1]);
            // 16-bit codes over 100 mm and 100 kN are 1.5 um and 1.5 N.
            assert!(
                (force - own).abs() < 15.0,
                "{force} of {own} N at floor {j}"
            );
        }
    }
    // No actuator moves if one floor's target is beyond its limit.
    let answer = client.step_all([1e-3, 1e9, 1e-3], 0.1).unwrap();
    assert!(answer.iter().all(|force| force.is_nan()), "{answer:?}");
    client.say(&[99.0]);
    let account = server.account();
    let said = account["reason"].as_str().unwrap_or_default();
    assert_eq!(account["verdict"], "refused", "{account}");
    assert!(said.contains("displacement 2 = 1000000000"), "{said}");
    let mut next = server.client_of(3);
    assert!(next.step_all([1e-3, 2e-3, 3e-3], 0.01).is_some());
    next.say(&[99.0]);
    let second = server.account();
    assert_eq!(second["verdict"], "completed", "{second}");
    for (account, targets) in [(account, 6), (second, 1)] {
        assert_eq!(
            (&account["targets"], &account["permit"]),
            (&targets.into(), &false.into())
        );
        let board = &account["board"];
        let lost = (&board["steps_lost"], &board["steps_different"]);
        assert_eq!(lost, (&0.into(), &0.into()));
    }
}

/// Two actuators on one coupler are the first two of that image: x and rotation reach a model's targets, both load cells
/// together give the specimen's force and moment, and a rotation beyond its limit moves nothing.
#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn two_coupled_actuators_of_the_emulated_board_answer_a_model_with_force_and_moment() {
    let own = ["--emulated", "--set", "plant.coupled.specimen.springs=[]"];
    let mut server = Server::of("examples/coupled-frame.toml", &[&own[..], &STANDS].concat());
    let mut client = server.client_of(2);
    for (i, u) in (1..).zip(TARGETS) {
        let force = client.step_all(u, 0.01 * f64::from(i)).unwrap();
        let specimen = times(&SPECIMEN, u);
        println!("{force:?} N, N m at {u:?}; the specimen has {specimen:?}");
        for j in 0..2 {
            assert!(
                (force[j] - specimen[j]).abs() < [12.0, 6.0][j],
                "{force:?} {specimen:?}"
            );
        }
    }
    let answer = client.step_all([0.0, 0.06], 0.1).unwrap();
    assert!(answer.iter().all(|force| force.is_nan()), "{answer:?}");
    client.say(&[99.0]);
    let account = server.account();
    assert_eq!(account["verdict"], "refused", "{account}");
    let said = account["reason"].as_str().unwrap_or_default();
    assert!(
        said.contains("0.05 rad (coupled.limits.rotation_rad)"),
        "{said}"
    );
    assert_eq!(
        (&account["targets"], &account["permit"]),
        (&5.into(), &false.into())
    );
    println!("{account}");
    // Noise and codes of the readings.
    for (j, most) in [(0, 1e-4), (1, 5e-4)] {
        assert!(figure(&account, j, "tracking_max") < most, "{account}");
    }
    let board = &account["board"];
    let lost = (&board["steps_lost"], &board["steps_different"]);
    assert_eq!(lost, (&0.into(), &0.into()));
    assert_eq!(board["timing"]["overruns"], 0, "{account}");
    // The next client is served in the same way.
    let mut next = server.client_of(2);
    assert!(next.step_all([1e-3, 2e-3], 0.01).unwrap()[0].is_finite());
    next.say(&[99.0]);
    assert_eq!(server.account()["verdict"], "completed");
}
