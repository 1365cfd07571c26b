//! The same on the flashed image, behind an emulated board.

use crate::client::{STIFFNESS, Server};
use crate::{MISCHIEF, continuous, now_and_then, passes_its_force_limit, without_a_jump};

/// PERMIT is low after whatever a client does, nothing is lost, and the next one is served.
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
        "serve.patience_s=2",
        "--set",
        "limits.displacement_m=0.02",
        "--set",
        "limits.force_n=5000",
    ]);
    // The client dies, half a message comes, nothing comes, NaN, 1e9.
    let chosen = [0, 1, 2, 4, 5];
    for (number, (verdict, reason, mischief)) in chosen.map(|i| MISCHIEF[i]).into_iter().enumerate()
    {
        let reason = reason.trim_end_matches(" 0.");
        let mut client = server.client();
        for i in 1..=5 {
            let u = 1e-3 * f64::from(i);
            let force = client.step(u, 1e-3 * f64::from(i)).unwrap();
            // Codes of 12 bits over twice the range.
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

/// The board knows of a late model by its own clock: it holds, goes on, and the PC works out every step of it again.
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
