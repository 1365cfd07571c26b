//! Two actuators on one coupler, served: the model commands x and rotation of the interface.

use crate::client::{Client, Server};
use crate::common::{is_as_its_schema_says, json, refused};
use serde_json::Value;

const EXAMPLE: &str = "examples/coupled-frame.toml";
/// `[coupled.specimen]` of the example: N/m, N/rad; N m/m, N m/rad.
pub const SPECIMEN: [[f64; 2]; 2] = [[104e3, 30e3], [30e3, 96e3]];
/// The model's part of the example's frame, in the same units, and its masses, kg and kg m^2.
const MODEL: [[f64; 2]; 2] = [[104e3, 30e3], [30e3, 96e3]];
const MASS: [f64; 2] = [1000.0, 60.0];

/// The specimen is as declared; the actuators are not.
const AS_DECLARED: &str = "plant.coupled.specimen.springs=[]";
/// A rig that is read at rest.
pub const STANDS: [&str; 4] = [
    "--set",
    "serve.settle_ms=100",
    "--set",
    "serve.average_ms=50",
];
const SILENT: [&str; 4] = [
    "--set",
    "plant.sensors.displacement_noise_mm=0",
    "--set",
    "plant.sensors.force_noise_n=0",
];

fn server(more: &[&str]) -> Server {
    let own = ["--set", AS_DECLARED];
    Server::of(EXAMPLE, &[&own[..], &STANDS, more].concat())
}

pub fn times(k: &[[f64; 2]; 2], u: [f64; 2]) -> [f64; 2] {
    k.map(|row| row[0] * u[0] + row[1] * u[1])
}

/// Targets that a client may send.
pub const TARGETS: [[f64; 2]; 5] = [
    [0.02, 0.0],
    [0.02, 0.03],
    [-0.015, 0.03],
    [-0.015, -0.02],
    [0.001, -0.002],
];

/// A figure of the account's coordinate `j`.
pub fn figure(account: &Value, j: usize, key: &str) -> f64 {
    account["coordinates"][j][key].as_f64().unwrap()
}

#[test]
fn the_interface_stands_where_the_model_sends_it_and_its_forces_are_the_specimens() {
    // In mm and mrad, N and N m: a rig without noise, and that of the example.
    for (noise, off, off_force) in [
        (&SILENT[..], [5e-3, 3e-2], [0.05, 0.1]),
        (&[], [5e-2, 0.4], [8.0, 3.0]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().to_str().unwrap();
        let mut server = server(&[noise, &["--out", out]].concat());
        let mut client = server.client_of(2);
        let (mut worst, mut worst_force) = ([0.0_f64; 2], [0.0_f64; 2]);
        for (i, u) in (1..).zip(TARGETS) {
            let force = client.step_all(u, 0.01 * f64::from(i)).unwrap();
            client.say(&[7.0]);
            let at = client.receive_all().unwrap();
            let own = times(&SPECIMEN, u);
            for j in 0..2 {
                worst[j] = worst[j].max(1e3 * (at[j] - u[j]).abs());
                worst_force[j] = worst_force[j].max((force[j] - own[j]).abs());
            }
        }
        client.say(&[99.0]);
        let account = server.account();
        println!("off by {worst:?} mm, mrad; forces by {worst_force:?} N, N m; {account}");
        assert_eq!(account["verdict"], "completed", "{account}");
        for j in 0..2 {
            assert!(worst[j] < off[j], "{worst:?}");
            assert!(worst_force[j] < off_force[j], "{worst_force:?}");
        }
        let record = std::fs::read_to_string(folder.path().join("record.csv")).unwrap();
        let truth = last_of(&record, ["true_displacement_m", "true_displacement2_rad"]);
        println!("truth {truth:?} for {:?}", TARGETS[4]);
        for j in 0..2 {
            assert!(1e3 * (truth[j] - TARGETS[4][j]).abs() < off[j], "{truth:?}");
        }
        let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
        assert!(page.contains("Displacement of rotation") && page.contains("force [kN m]"));
    }
}

/// The last values of two columns of a record.
fn last_of(record: &str, names: [&str; 2]) -> [f64; 2] {
    let head = record.lines().next().unwrap();
    let last: Vec<&str> = record.lines().next_back().unwrap().split(',').collect();
    names.map(|name| {
        let place = head.split(',').position(|n| n == name).expect(name);
        last[place].parse().unwrap()
    })
}

/// x and rotation of the example's frame under a ground motion, by explicit Newmark; the specimen's force is `force`.
fn integrate(steps: usize, mut force: impl FnMut([f64; 2], f64) -> [f64; 2]) -> Vec<[f64; 2]> {
    let dt = 0.01;
    let ([mut u, mut v, mut a], mut path) = ([[0.0_f64; 2]; 3], Vec::new());
    for i in 0..steps {
        let t = i as f64 * dt;
        let half: [f64; 2] = std::array::from_fn(|j| v[j] + 0.5 * dt * a[j]);
        u = std::array::from_fn(|j| u[j] + dt * half[j]);
        let (specimen, model) = (force(u, t), times(&MODEL, u));
        let ground = 2.0 * (11.0 * t).sin() * (0.7 * t).sin();
        let load = [-MASS[0] * ground, 0.0];
        a = std::array::from_fn(|j| {
            let damping = 1.2 * MASS[j] * half[j];
            (load[j] - specimen[j] - model[j] - damping) / MASS[j]
        });
        v = std::array::from_fn(|j| half[j] + 0.5 * dt * a[j]);
        path.push(u);
    }
    path
}

#[test]
fn a_frame_half_of_which_is_served_moves_as_the_whole_one() {
    // As measured: a force carried to the target by a linear stiffness does not depend on where the rig stands.
    let mut server = server(&["--set", "serve.carry_force=false"]);
    let mut client = server.client_of(2);
    client.say(&[12.0]);
    let stiffness = client.receive_all().unwrap();
    assert_eq!(stiffness[..4], *SPECIMEN.as_flattened());
    let served = integrate(300, |u, t| client.step_all(u, t).unwrap());
    client.say(&[99.0]);
    let whole = integrate(300, |u, _| times(&SPECIMEN, u));
    let account = server.account();
    println!("{account}");
    is_as_its_schema_says("serve", &account, "verdict");
    assert_eq!(account["verdict"], "completed", "{account}");
    assert_eq!(account["targets"], 300);
    // As a share of the peak: the noise of the readings, which a model in closed loop accumulates.
    for (j, least, most) in [(0, 0.02, 1e-3), (1, 0.005, 1e-2)] {
        let peak = whole.iter().fold(0.0_f64, |p, u| p.max(u[j].abs()));
        let apart = whole.iter().zip(&served).map(|(a, b)| (a[j] - b[j]).abs());
        let apart = apart.fold(0.0, f64::max) / peak;
        println!("coordinate {j}: {apart} of {peak}");
        assert!(peak > least && apart < most, "{apart} of {peak}");
        assert!(
            (figure(&account, j, "peak") / peak - 1.0).abs() < 0.01,
            "{account}"
        );
    }
    // m and rad are not mixed: the figures common to all tests are those of x.
    for (of_all, of_x) in [
        ("peak_displacement_m", "peak"),
        ("tracking_rms_m", "tracking_rms"),
        ("tracking_max_m", "tracking_max"),
    ] {
        assert_eq!(
            account[of_all], account["coordinates"][0][of_x],
            "{account}"
        );
    }
    let names = [0, 1].map(|j| account["coordinates"][j]["name"].as_str().unwrap());
    assert_eq!(names, ["x_m", "rotation_rad"]);
}

/// Checks the reply to a target beyond a limit, and the reason.
fn refused_target(to: [f64; 2], said: &str) {
    let mut server = server(&[]);
    let mut client: Client = server.client_of(2);
    assert!(client.step_all([1e-3, 1e-3], 0.01).is_some());
    let answer = client.step_all(to, 0.02).unwrap();
    assert!(answer.iter().all(|force| force.is_nan()), "{answer:?}");
    client.say(&[99.0]);
    let account = server.account();
    assert_eq!(account["verdict"], "refused", "{account}");
    assert_eq!(
        (&account["targets"], &account["permit"]),
        (&1.into(), &false.into())
    );
    assert!(
        account["reason"].as_str().unwrap().contains(said),
        "{account}"
    );
}

#[test]
fn a_target_beyond_a_limit_of_its_own_coordinate_moves_nothing() {
    refused_target(
        [0.0, 0.051],
        "displacement 2 = 0.051 at 0.02 s, which the rig is not moved to: accepted are 0.05 rad (coupled.limits.rotation_rad)",
    );
    refused_target([0.045, 0.0], "accepted are 0.04 m (coupled.limits.x_m)");
}

#[test]
fn units_on_the_wire_are_the_models_and_a_rotation_is_in_rad() {
    let units = [
        "--set",
        "serve.length_unit=mm",
        "--set",
        "serve.force_unit=kN",
    ];
    let mut server = server(&[&SILENT[..], &units].concat());
    let mut client = server.client_of(2);
    client.say(&[12.0]);
    let stiffness = client.receive_all().unwrap();
    // kN/mm and kN/rad; kN mm/mm and kN mm/rad.
    let expected = [0.104, 30.0, 30.0, 96e3];
    for (k, expected) in stiffness.iter().zip(expected) {
        assert!((k / expected - 1.0).abs() < 1e-12, "{k} {expected}");
    }
    let force = client.step_all([5.0, 0.004], 0.1).unwrap();
    // 104e3 * 0.005 + 30e3 * 0.004 N, 30e3 * 0.005 + 96e3 * 0.004 N m.
    for (f, expected) in force.iter().zip([0.64, 534.0]) {
        assert!((f / expected - 1.0).abs() < 1e-3, "{f} {expected}");
    }
    client.say(&[7.0]);
    let at = client.receive_all().unwrap();
    assert!(
        (at[0] - 5.0).abs() < 0.01 && (at[1] - 0.004).abs() < 2e-5,
        "{:?}",
        &at[..2]
    );
    client.say(&[99.0]);
    let account = server.account();
    assert!(
        (figure(&account, 0, "peak") - 0.005).abs() < 1e-9,
        "{account}"
    );
    assert!(
        (figure(&account, 1, "peak") - 0.004).abs() < 1e-9,
        "{account}"
    );
}

#[test]
fn what_cannot_be_served_of_two_coupled_actuators_is_refused_in_one_sentence() {
    let third = "coupled.structure={coordinates=['x_m','rotation_rad','top_m'],damping_ratio=0.04,\
                 mass=[[1000,0,0],[0,60,0],[0,0,500]],stiffness=[[208e3,60e3,0],[60e3,192e3,0],[0,0,1e5]]}";
    // An address that does not exist here: if this is not refused, it does not wait for a client.
    let serve = ["serve", EXAMPLE, "--listen", "192.0.2.1:9"];
    for (set, words) in [
        (
            "serve.pace=continuous",
            ["serve.pace = \"continuous\" is refused", "stop_and_go"],
        ),
        ("serve.timeout_s=0", ["serve.timeout_s = 0", "86400"]),
        (
            third,
            [
                "coupled.structure.coordinates has 3 names",
                "accepted in a test that is served are 2",
            ],
        ),
    ] {
        refused(&[&serve[..], &["--set", set]].concat(), &words);
    }
    let scope = [&serve[..], &["--scope"]].concat();
    refused(&scope, &["--scope", "two coupled actuators"]);
    // A test on a ground motion does not use this key.
    let ran = json(&[
        "run",
        EXAMPLE,
        "--json",
        "--duration",
        "1",
        "--set",
        "serve.pace=continuous",
    ]);
    assert_eq!(ran["verdict"], "completed");
}
