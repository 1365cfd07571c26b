//! Tests of two coupled actuators: physics, interlocks in both coordinate systems, refusals.
use crate::common::{KEYS, command, json, json_with, outerloop, refused, root};
use experiment::coupled::figures::CoupledFigures;
use experiment::coupled::interface::InterfaceTrace;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::summary::{Summary, TestVerdict};
use experiment::trace::{AnyRecord, Response, TestObserver, Trace};
use experiment::{Experiment, Shaking};
use nalgebra::{SMatrix, SVector};
use outerloop_core::{Event, Mode};
use plant::linear::Linear;

const EXAMPLE: &str = "examples/coupled-frame.toml";
/// A rig without noise, without the brace, and with ideal actuators.
const EXACT: [&str; 5] = [
    "plant.coupled.ideal=true",
    "plant.coupled.specimen.springs=[]",
    "plant.sensors.displacement_noise_mm=0",
    "plant.sensors.force_noise_n=0",
    "coupled.compensation=none",
];

fn experiment(overrides: &[&str]) -> Experiment {
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    let test = TestFile::load_any(&root().join(EXAMPLE), &overrides).unwrap();
    Experiment::new(test, &near_fault(), Some(12.0)).unwrap()
}

fn run(overrides: &[&str]) -> (Experiment, Response, Trace, Summary) {
    let e = experiment(overrides);
    let ideal = e.ideal().unwrap();
    let run = e.run(e.test.compensation(), &ideal, 1, true, ()).unwrap();
    (e, ideal, run.trace.unwrap(), run.summary)
}

/// The part of the record that only two coupled actuators have.
fn interface(record: &Trace) -> &InterfaceTrace {
    record.interface.as_ref().unwrap()
}

fn figures(summary: &Summary) -> &CoupledFigures {
    summary.coupled.as_ref().unwrap()
}

#[test]
fn without_actuator_error_it_is_the_exact_solution() {
    let (e, ideal, record, summary) = run(&EXACT);
    assert!(summary.eps_max < 1e-5, "{}", summary.eps_max);
    // u'' = M^-1 (-K u - C u') - iota a_g, with the ground acceleration linear between samples.
    let s = &e.test.coupled_part().unwrap().declared.structure;
    let square = |m: &[Vec<f64>]| SMatrix::<f64, 2, 2>::from_fn(|i, j| m[i][j]);
    let (mass, stiffness) = (square(&s.mass), square(&s.stiffness));
    // The same damping ratio in both modes: C = 2 zeta M sqrt(M^-1 K).
    let root_m = SMatrix::<f64, 2, 2>::from_diagonal(&mass.diagonal().map(f64::sqrt));
    let per_root = SMatrix::<f64, 2, 2>::from_diagonal(&mass.diagonal().map(|x| 1.0 / x.sqrt()));
    let modes = (per_root * stiffness * per_root).symmetric_eigen();
    let w = SMatrix::<f64, 2, 2>::from_diagonal(&modes.eigenvalues.map(f64::sqrt));
    let c = root_m * modes.eigenvectors * w * modes.eigenvectors.transpose() * root_m * 0.08;
    let inverse = mass.try_inverse().unwrap();
    let mut a = SMatrix::<f64, 4, 4>::zeros();
    a.fixed_view_mut::<2, 2>(0, 2).fill_with_identity();
    a.fixed_view_mut::<2, 2>(2, 0)
        .copy_from(&(-inverse * stiffness));
    a.fixed_view_mut::<2, 2>(2, 2).copy_from(&(-inverse * c));
    let mut b = SMatrix::<f64, 4, 1>::zeros();
    b[2] = -1.0;
    let mut exact = Linear::new(&a, &b, e.test.config.model_step_s());
    let peaks = ideal.peaks_m();
    for n in 0..record.len() {
        for j in 0..2 {
            let off = (exact.state[j] - f64::from(record.floors[j].command_m[n])).abs();
            assert!(off < 4e-3 * peaks[j], "{n} {j}: {off}");
        }
        let at = |n: usize| SVector::from([f64::from(record.ground_m_per_s2[n])]);
        let next = (n + 1).min(record.len() - 1);
        exact.step(&at(n), &at(next));
    }
}

#[test]
fn it_says_that_nothing_is_watched() {
    let said = run(&[]).3.watch.unwrap().sentence();
    assert!(said.contains("two actuators on one coupler"), "{said}");
}

#[test]
fn a_shaking_turned_round_turns_everything_round() {
    // With both pins at the x of the interface point, rotations of either sign move them alike.
    let quiet = [
        "coupled.coupler.pin_x_m=[0,0]",
        "plant.sensors.displacement_noise_mm=0",
        "plant.sensors.force_noise_n=0",
    ];
    let plus = run(&quiet).2;
    let e = experiment(&quiet);
    let turned: Vec<f32> = e.shaking().acc_m_per_s2.iter().map(|a| -a).collect();
    let shaking = Shaking {
        acc_m_per_s2: &turned,
        ..e.shaking()
    };
    let e = Experiment::with_shaking(e.test.clone(), String::new(), e.seconds, e.scale, &shaking);
    let kind = e.test.compensation();
    let minus = e
        .run(kind, &e.ideal().unwrap(), 1, true, ())
        .unwrap()
        .trace
        .unwrap();
    let [first, second] = [0, 1].map(|i| (&plus.floors[i], &minus.floors[i]));
    for (a, b) in [
        (&first.0.command_m, &first.1.command_m),
        (&second.0.command_m, &second.1.command_m),
        (&second.0.sent_m, &second.1.sent_m),
        (&second.0.estimated_force_n, &second.1.estimated_force_n),
    ] {
        assert!(a.len() == 12_000 && a.len() == b.len());
        let peak = a.iter().fold(0.0_f32, |m, x| m.max(x.abs()));
        let off = a
            .iter()
            .zip(b)
            .fold(0.0_f32, |m, (x, y)| m.max((x + y).abs()));
        assert!(off < 1e-4 * peak, "{off} of {peak}");
    }
}

/// Holds a running test, and measures how far the interface is from its target.
#[derive(Default)]
struct Held {
    done: usize,
    steps: usize,
    target: [f32; 2],
    off: [f32; 2],
}

impl TestObserver for Held {
    fn on_step(&mut self, _: &AnyRecord<'_>) {
        self.done += 1;
    }

    fn on_idle_step(&mut self, r: &AnyRecord<'_>) {
        if r.mode() == Some(Mode::Holding) {
            self.steps += 1;
            self.target = [0, 1].map(|i| r.command_m[i]);
            self.off = [0, 1].map(|i| r.estimated_displacement_m[i] - r.command_m[i]);
        }
    }

    fn requested_event(&mut self) -> Option<Event> {
        match (self.done, self.steps) {
            (6350, 0) => Some(Event::Hold),
            (_, 1500) => Some(Event::Stop),
            _ => None,
        }
    }
}

/// The structure's modes, which a hold stops, would otherwise pull the interface towards zero.
#[test]
fn in_a_hold_the_interface_stands_where_it_is_held() {
    let e = experiment(&[]);
    let mut held = Held::default();
    let ideal = e.ideal().unwrap();
    e.run(e.test.compensation(), &ideal, 1, false, &mut held)
        .unwrap();
    let Held {
        steps, target, off, ..
    } = held;
    println!("off by {off:?} of {target:?}");
    assert!(
        steps >= 1500 && target[0].abs() > 5e-3,
        "{steps} {target:?}"
    );
    assert!(
        off[0].abs() < 5e-5 && off[1].abs() < 5e-4,
        "{off:?} of {target:?}"
    );
}

#[test]
fn energies_balance_over_the_interface() {
    let (_, _, record, summary) = run(&["coupled.compensation=coupled-fixed"]);
    let (of_interface, floors) = (interface(&record), &record.floors);
    // Eq 12 less HSEM is the final R (u_m - u_c), the sum of its increments.
    let last = record.len() - 1;
    let left: f64 = (0..2)
        .map(|i| {
            let (moved, floor) = (&of_interface.displacement[i], &floors[i]);
            let error = |n: usize| f64::from(moved[n]) - f64::from(floor.command_m[n]);
            let force = |n: usize| f64::from(floor.estimated_force_n[n]);
            force(last) * error(last) - force(0) * error(0)
        })
        .sum();
    let balance = summary.energy_error_j - summary.energy_error_hsem_j - left;
    assert!(
        balance.abs() < 1e-6 * summary.energy_error_j.abs(),
        "{balance}"
    );
    // The work of the actuators on their strokes is that of force and moment on x and rotation.
    let (mut strokes, mut interface, mut turned) = (0.0, 0.0, 0.0);
    for n in 1..record.len() {
        let work = |force: &[f32], at: &[f32]| {
            0.5 * (f64::from(force[n]) + f64::from(force[n - 1]))
                * (f64::from(at[n]) - f64::from(at[n - 1]))
        };
        for i in 0..2 {
            strokes += work(&floors[i].force_n, &of_interface.true_stroke_m[i]);
            interface += work(&floors[i].estimated_force_n, &of_interface.truth[i]);
            turned += work(&floors[i].estimated_force_n, &of_interface.truth[i]).abs();
        }
    }
    assert!(
        (strokes - interface).abs() < 2e-3 * turned,
        "{strokes} {interface} of {turned}"
    );
}

#[test]
fn with_a_coupling_that_vanishes_x_moves_as_one_degree_of_freedom() {
    let stiffness = [
        "coupled.structure.stiffness=[[208e3,1],[1,192e3]]",
        "coupled.specimen.stiffness=[[104e3,0],[0,96e3]]",
    ];
    let overrides = [&EXACT[..], &stiffness[..]].concat();
    let (e, ideal, record, _) = run(&overrides);
    let peaks = ideal.peaks_m();
    assert!(peaks[1] < 1e-3 * peaks[0]);
    let w: f64 = 208.0_f64.sqrt();
    let a = SMatrix::<f64, 2, 2>::new(0.0, 1.0, -w * w, -0.08 * w);
    let b = SMatrix::<f64, 2, 1>::new(0.0, -1.0);
    let mut exact = Linear::new(&a, &b, e.test.config.model_step_s());
    for n in 0..record.len() - 1 {
        let off = (exact.state[0] - f64::from(record.floors[0].command_m[n])).abs();
        assert!(off < 2e-3 * peaks[0], "{n}: {off}");
        let at = |n: usize| SVector::from([f64::from(record.ground_m_per_s2[n])]);
        exact.step(&at(n), &at(n + 1));
    }
}

#[test]
fn knowing_the_coupling_is_worth_what_the_comparison_says() {
    let eps = |kind: &str| run(&[&format!("coupled.compensation={kind}")]).3;
    let [none, uncoupled, fixed, coupled] =
        ["none", "uncoupled", "coupled-fixed", "coupled"].map(eps);
    assert_ne!(none.verdict, TestVerdict::Completed);
    assert!(coupled.eps_rms < 0.02, "{}", coupled.eps_rms);
    assert!(fixed.eps_rms > 2.0 * coupled.eps_rms || fixed.verdict != TestVerdict::Completed);
    assert!(uncoupled.verdict != TestVerdict::Completed || uncoupled.eps_rms > fixed.eps_rms);
    // The estimate comes nearer to the rig than the declaration.
    for name in ["slow_pole_hz.0", "slow_pole_hz.1"] {
        let f = figures(&coupled)
            .found
            .iter()
            .find(|f| f.name == name)
            .unwrap();
        let (before, after) = (
            (f.declared - f.simulated).abs(),
            (f.found - f.simulated).abs(),
        );
        assert!(after < 0.5 * before, "{f:?}");
    }
}

#[test]
fn interlocks_act_in_both_systems_of_coordinates_and_say_which() {
    for (limit, fault, axis) in [
        ("stroke_m=0.02", "displacement", "actuator"),
        ("velocity_m_per_s=0.2", "velocity", "actuator"),
        ("force_n=500", "force", "actuator"),
        ("x_m=0.01", "displacement", "x"),
        ("x_velocity_m_per_s=0.1", "velocity", "x"),
        ("x_force_n=500", "force", "x"),
        ("x_tracking_m=0.00005", "tracking", "x"),
        ("rotation_rad=0.003", "displacement", "rotation"),
        ("rotation_velocity_rad_per_s=0.03", "velocity", "rotation"),
        ("moment_n_m=40", "force", "rotation"),
    ] {
        let set = format!("coupled.limits.{limit}");
        let said = json_with(1, &["run", EXAMPLE, "--json", "--set", &set]);
        assert_eq!(said["verdict"], "tripped", "{limit}");
        assert_eq!(said["trip"], fault, "{limit}");
        let of = said["trip_axis"].as_str().unwrap();
        assert!(of.starts_with(axis), "{limit}: {of}");
    }
}

#[test]
fn results_have_the_keys_of_other_tests_and_the_record_both_systems() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let said = json(&["run", EXAMPLE, "--json", "--duration", "5", "--out", out]);
    for key in KEYS.into_iter().chain(["provenance", "seed"]) {
        assert!(said.get(key).is_some(), "{key}");
    }
    let record = std::fs::read_to_string(folder.path().join("record.csv")).unwrap();
    let head = record.lines().next().unwrap();
    for name in [
        "target_m",
        "displacement_m",
        "force_n",
        "target2_rad",
        "displacement2_rad",
        "force2_n_m",
        "actuator_command_m",
        "actuator_displacement2_m",
        "actuator_force2_n",
        "true_displacement2_rad",
        "true_actuator_displacement2_m",
    ] {
        assert!(head.split(',').any(|c| c == name), "{name} in {head}");
    }
    assert_eq!(record.lines().count(), 1 + 5 * 1000);
    let mut names: Vec<&str> = head.split(',').collect();
    names.sort_unstable();
    assert!(names.windows(2).all(|w| w[0] != w[1]), "{head}");
    // Channels that such a test does not have are no columns of zeros.
    assert!(
        !head.contains("gain") && !head.contains("damping"),
        "{head}"
    );
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    let drawn = page.split("<script>").next().unwrap();
    assert!(drawn.contains("What the actuators did") && drawn.contains("<svg"));

    let model = folder.path().join("model.toml");
    let declared = "[coupled]\ncoordinates = [\"x_m\", \"rotation_rad\"]\n\
         mass = [[{ value = 0, tolerance = 1 }, { value = 0, tolerance = 0.1 }], [{ value = 0, tolerance = 0.1 }, { value = 0, tolerance = 0.1 }]]\n\
         damping = [[{ value = 0, tolerance = 50 }, { value = 0, tolerance = 50 }], [{ value = 0, tolerance = 50 }, { value = 0, tolerance = 50 }]]\n\
         stiffness = [[{ value = 104e3, tolerance = 2e3 }, { value = 30e3, tolerance = 1e3 }], [{ value = 30e3, tolerance = 1e3 }, { value = 96e3, tolerance = 2e3 }]]\n";
    std::fs::write(&model, declared).unwrap();
    let record = folder.path().join("record.csv");
    let record = record.to_str().unwrap();
    let (train, test) = (format!("{record}@0..2.5"), format!("{record}@2.5.."));
    let model = model.to_str().unwrap();
    let found = json(&[
        "diagnose", "--model", model, "--train", &train, "--test", &test, "--json",
    ]);
    assert_eq!(found["coordinates"].as_array().unwrap().len(), 2);
}

#[test]
fn compare_ranks_and_check_says_what_the_limits_leave() {
    let rows = json(&["compare", EXAMPLE, "--json", "--duration", "8"]);
    assert_eq!(rows["rows"].as_array().unwrap().len(), 4);
    let arguments = ["check", EXAMPLE, "--plants", "4", "--json"];
    let said = json(&arguments);
    assert_eq!(said["verdict"], "stable", "{}", said["reason"]);
    assert!(said["expected_eps_rms"].as_f64().unwrap() < 0.02);
    let tight = [&arguments[..], &["--set", "coupled.limits.x_m=0.0175"]].concat();
    let said = json_with(1, &tight);
    assert_eq!(said["verdict"], "doubtful", "{}", said["reason"]);
    let wrong = [&arguments[..], &["--compensation", "none"]].concat();
    assert_eq!(json_with(2, &wrong)["verdict"], "unstable");
}

#[test]
fn what_cannot_be_is_refused_in_one_sentence() {
    let set = |assignment: &str, words: &[&str]| {
        refused(&["run", EXAMPLE, "--set", assignment], words);
    };
    let set_emulated = |assignment: &str, words: &[&str]| {
        refused(&["run", EXAMPLE, "--emulated", "--set", assignment], words);
    };
    set(
        "coupled.structure.stiffness=[[1,2],[3,4]]",
        &["coupled.structure.stiffness", "symmetric"],
    );
    set(
        "coupled.structure.coordinates=[\"a_rad\",\"b_m\"]",
        &["coordinates", "first a displacement"],
    );
    set(
        "coupled.limits.force_n=0",
        &["coupled.limits.force_n = 0", "above 0"],
    );
    set(
        "coupled.coupler.pin_y_m=[0.1,0.1]",
        &["coupled.coupler.pin_y_m", "apart"],
    );
    set(
        "coupled.actuators.gain=[[1,1],[1,1]]",
        &["gain", "inverted"],
    );
    set(
        "coupled.actuators.delay_ms=[90,0]",
        &["delay", "60 sampling periods"],
    );
    set(
        "coupled.compensation=paper",
        &["compensation", "coupled-fixed"],
    );
    set(
        "plant.coupled.specimen.mass=[[1,2],[3,4]]",
        &["plant.coupled.specimen.mass", "symmetric"],
    );
    set("loop.time_scale=2", &["loop.time_scale", "real time"]);
    set("structure.mass_kg=1", &["structure", "beside [coupled]"]);
    let none = "two coupled actuators";
    refused(
        &["run", EXAMPLE, "--emulated", "--scope"],
        &["--scope", none],
    );
    set_emulated(
        "loop.rate_hz=1024",
        &["loop.rate_hz = 1024", "divisors of 84 MHz"],
    );
    let third = "coupled.structure={coordinates=['x_m','rotation_rad','top_m'],damping_ratio=0.04,\
                 mass=[[1000,0,0],[0,60,0],[0,0,500]],stiffness=[[208e3,60e3,0],[60e3,192e3,0],[0,0,1e5]]}";
    set_emulated(
        third,
        &[
            "coupled.structure.coordinates has 3 names",
            "accepted on a board are 2",
        ],
    );
    refused(
        &["improve", EXAMPLE],
        &["run, compare, check, sweep, serve"],
    );
    refused(
        &["run", EXAMPLE, "--compensation", "paper"],
        &["paper", "coupled-fixed"],
    );
    let output = command(&["new", "--from", "coupled-frame", "/dev/null"])
        .output()
        .unwrap();
    assert_eq!(
        output.status.code(),
        Some(2),
        "what is there is not overwritten"
    );
    assert!(String::from_utf8_lossy(&outerloop(&["keys"]).stdout).contains("coupled.limits"));
}

/// Without noise the tests are those of the check: the same rigs, and each with its own ideal.
#[test]
fn drawn_rigs_are_those_of_the_check_and_say_by_what_they_differ() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let quiet = [
        "--json",
        "--set",
        "plant.sensors.displacement_noise_mm=0",
        "--set",
        "plant.sensors.force_noise_n=0",
        "--set",
        "coupled.compensation=coupled-fixed",
        "--set",
        "coupled.specimen.damping=[[200,0],[0,100]]",
        "--set",
        "excitation={scale=0.2,duration_s=8}",
    ];
    let drawn = ["sweep", EXAMPLE, "--drawn", "5", "--out", out];
    let swept = json(&[&drawn[..], &quiet[..]].concat());
    assert_eq!(swept["tests"], 5);
    assert_eq!(swept["completed"], 5);
    let check = outerloop(&[&["check", EXAMPLE, "--plants", "5"][..], &quiet[..]].concat());
    let check: serde_json::Value = serde_json::from_slice(&check.stdout).unwrap();
    assert_eq!(check["lost"], 0);
    assert_eq!(swept["eps_rms_worst"], check["drawn_eps_rms"]);
    let text = std::fs::read_to_string(folder.path().join("tests.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|l| l.split(',').collect()).collect();
    assert_eq!(rows.len(), 6);
    // A zero of a path that has none cannot differ, the gains of all four paths can.
    assert!(!text.contains("path_lead_ms.0.0") && text.contains("path_lead_ms.0.1_factor_1"));
    assert!(text.contains("gain.1.0_factor_1") && text.contains("specimen.damping_factor_1"));
    // The first rig once more, from the factors in its row.
    let factor = |name: &str| -> f64 {
        let column = format!("{name}_factor_1");
        let at = rows[0].iter().position(|c| *c == column).unwrap();
        rows[1][at].parse().unwrap()
    };
    let mut again = vec!["run".to_owned(), EXAMPLE.to_owned()];
    again.extend(quiet.map(str::to_owned));
    let two = |name: &str, of: [f64; 2]| [0, 1].map(|i| of[i] * factor(&format!("{name}.{i}")));
    let gain = |i: usize, of| two(&format!("gain.{i}"), of);
    let path = |i: usize, ms: f64| ms * factor(&format!("path_lead_ms.{i}.1"));
    let (k, c) = (factor("specimen.stiffness"), factor("specimen.damping"));
    for (key, value) in [
        (
            "actuators.slow_pole_hz",
            format!("{:?}", two("slow_pole_hz", [2.8, 3.3])),
        ),
        (
            "actuators.fast_pole_hz",
            format!("{:?}", two("fast_pole_hz", [40.0, 18.5])),
        ),
        (
            "actuators.delay_ms",
            format!("{:?}", two("delay_ms", [2.0, 2.0])),
        ),
        (
            "actuators.natural_hz",
            (80.0 * factor("natural_hz")).to_string(),
        ),
        (
            "actuators.path_lead_ms",
            format!("[[0,{}],[0,{}]]", path(0, 53.0), path(1, 32.0)),
        ),
        (
            "actuators.gain",
            format!(
                "[{:?},{:?}]",
                gain(0, [0.88, 0.128]),
                gain(1, [0.143, 0.91])
            ),
        ),
        (
            "specimen.stiffness",
            format!("[[{},{}],[{1},{}]]", 104e3 * k, 30e3 * k, 96e3 * k),
        ),
        (
            "specimen.damping",
            format!("[[{},0],[0,{}]]", 200.0 * c, 100.0 * c),
        ),
    ] {
        again.extend(["--set".to_owned(), format!("plant.coupled.{key}={value}")]);
    }
    let again: Vec<&str> = again.iter().map(String::as_str).collect();
    let alone = json_with(1, &again)["eps_rms"].as_f64().unwrap();
    let swept: f64 = rows[1][rows[1].len() - 2].parse().unwrap();
    assert!((swept / alone - 1.0).abs() < 1e-6, "{swept} {alone}");
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("The worst of them") && page.contains("gain.1.0, of the declared"));
}

/// A margin ends where a rig that is as much later or stronger makes the planned motion poor, and knowing more of the actuators
/// leaves more of it.
#[test]
fn the_margins_of_a_check_are_where_the_planned_motion_becomes_poor() {
    let duration = ["--set", "excitation.duration_s=8"];
    // The poles as they are, so that the motion is good without learning, too.
    let poles = ["--set", "coupled.actuators.slow_pole_hz=[2.8,3.3]"];
    let margins = |compensation: &str, more: &[&str]| {
        let check = ["check", EXAMPLE, "--plants", "1", "--json"];
        let of = ["--compensation", compensation];
        let said = outerloop(&[&check[..], &of, &duration, more].concat());
        let said: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
        ["delay", "gain"].map(|name| {
            let found = |key: &str| said["margins"][name][key].as_f64().unwrap();
            (found("present"), found("limit"))
        })
    };
    let [delay, gain] = margins("coupled", &[]);
    println!("{delay:?} {gain:?}");
    assert_eq!((delay.0, gain.0), (2.0, 1.0));
    let poor = |keys: [String; 2]| {
        let [first, second] = keys.each_ref().map(String::as_str);
        let run = ["run", EXAMPLE, "--json", "--set", first, "--set", second];
        let said = outerloop(&[&run[..], &duration].concat());
        let said: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
        said["verdict"] != "completed" || said["eps_rms"].as_f64().unwrap() > 0.1
    };
    let rig = |ms: f64, factor: f64| {
        let [a, b, c, d] = [0.88, 0.128, 0.143, 0.91].map(|gain| factor * gain);
        poor([
            format!("plant.coupled.actuators.delay_ms=[{ms},{ms}]"),
            format!("plant.coupled.actuators.gain=[[{a},{b}],[{c},{d}]]"),
        ])
    };
    assert!(!rig(2.0 + 0.95 * (delay.1 - 2.0), 1.0));
    assert!(rig(2.0 + 1.05 * (delay.1 - 2.0), 1.0));
    assert!(!rig(2.0, 1.0 + 0.95 * (gain.1 - 1.0)));
    assert!(rig(2.0, 1.0 + 1.05 * (gain.1 - 1.0)));
    let fixed = margins("coupled-fixed", &poles);
    assert!(fixed[0].1 < delay.1 && fixed[1].1 < gain.1, "{fixed:?}");
}

/// The margins of a check with these keys, and what the terminal says.
fn margins_with(keys: &[&str]) -> (serde_json::Value, String) {
    let duration = [
        "check",
        EXAMPLE,
        "--plants",
        "1",
        "--set",
        "excitation.duration_s=8",
    ];
    let check = [&duration[..], keys].concat();
    let said = outerloop(&[&check[..], &["--json"]].concat());
    let said: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
    let text = String::from_utf8(outerloop(&check).stdout).unwrap();
    let words: Vec<&str> = text.split_whitespace().collect();
    (said, words.join(" "))
}

/// An unstable motion has no margins, nor has one that is poor on the rig as it is.
#[test]
fn a_test_that_is_lost_or_poor_as_it_is_has_no_margins() {
    let late = "plant.coupled.actuators.delay_ms=[40,40]";
    for (keys, verdict, why) in [
        (["--set", late], "unstable", "the test is unstable"),
        (
            ["--compensation", "uncoupled"],
            "doubtful",
            "the planned motion is poor on the rig as it is",
        ),
    ] {
        let (answer, text) = margins_with(&keys);
        assert_eq!(answer["verdict"], verdict, "{keys:?}");
        for name in ["delay", "gain"] {
            let margin = &answer["margins"][name];
            assert_eq!(margin["search"], "no_margin", "{keys:?}: {margin}");
            assert_eq!(margin["why"], why, "{keys:?}: {margin}");
            assert!(margin["limit"].is_null(), "{keys:?}: {margin}");
        }
        assert!(
            text.contains(&format!("There are no margins: {why}.")),
            "{text}"
        );
        assert!(!text.contains("0.0 %"), "{text}");
    }
}

/// Gains of up to 91 may not grow by a third, as those of the example: 100 is the largest that a rig may have.
#[test]
fn a_margin_of_coupled_actuators_ends_at_a_rig_that_is_refused() {
    let declared = "coupled.actuators.gain=[[86.4,13.1],[14.0,92.7]]";
    let rig = "plant.coupled.actuators.gain=[[88,12.8],[14.3,91]]";
    let (answer, text) = margins_with(&["--set", declared, "--set", rig]);
    let gain = &answer["margins"]["gain"];
    assert_eq!(gain["search"], "refused", "{gain}");
    let searched = gain["searched_to"].as_f64().unwrap();
    assert!((1.09..100.0 / 91.0).contains(&searched), "{searched}");
    let delay = &answer["margins"]["delay"];
    assert_eq!(delay["search"], "found", "{delay}");
    for words in [
        "none up to 1.09",
        "ended at a refusal: plant.coupled.actuators.gain is 100.",
        "the loop does not know of it and keeps its parameters",
    ] {
        assert!(text.contains(words), "{words} is not in: {text}");
    }
}

#[test]
fn a_sweep_has_the_figures_of_each_test() {
    let over = "coupled.actuators.slow_pole_hz.0=2.65,2.8";
    let compensations = "coupled-fixed,coupled";
    let said = json(&[
        "sweep",
        EXAMPLE,
        "--duration",
        "8",
        "--over",
        over,
        "--compensations",
        compensations,
        "--json",
    ]);
    let rows = said["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    let alone = json(&["run", EXAMPLE, "--duration", "8", "--json"]);
    let coupled = &rows[1];
    assert_eq!(coupled["compensation"], "coupled");
    for key in ["eps_rms", "eps_max", "verdict", "peak_displacement_m"] {
        assert_eq!(coupled[key], alone[key], "{key}");
    }
    let error = |row: usize| rows[row]["eps_rms"].as_f64().unwrap();
    // If the pole is declared correctly, it need not be identified; both are then nearer.
    assert!(error(2) < 0.8 * error(0), "{} {}", error(2), error(0));
    refused(
        &["sweep", EXAMPLE, "--over", over, "--compensations", "paper"],
        &["paper", "coupled-fixed"],
    );
}

#[test]
fn an_archive_is_replayed_to_the_bit_and_two_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (first, second) = (path("first.h5"), path("second.h5"));
    let run = ["run", EXAMPLE, "--duration", "6", "--json"];
    json(&[&run[..], &["--archive", &first]].concat());
    let other = ["--set", "coupled.spread.gain_ratio=0.02"];
    json(&[&run[..], &other, &["--archive", &second]].concat());
    for archive in [&first, &second] {
        let said = json(&["replay", archive, "--json"]);
        assert_eq!(said["values_different"], 0);
        assert_eq!(said["steps"], 6 * 1000);
    }
    let said = json(&["diff", &first, &second, "--json"]);
    let channels = said["channels"].as_array().unwrap();
    let of = |name: &str| channels.iter().find(|c| c["channel"] == name).unwrap();
    assert!(of("target_m")["rms_of_peak"].as_f64().unwrap() > 0.0);
    assert_eq!(of("target2_rad")["unit"], "rad");
    assert!(of("actuator_command2_m")["rms"].as_f64().unwrap() > 0.0);
    assert!(
        channels
            .iter()
            .all(|c| c["channel"] != "target2_m" && c["channel"] != "command_m")
    );
}
