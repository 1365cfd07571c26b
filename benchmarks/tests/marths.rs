//! The multi-axial benchmark compared with the figures of an independent port of the problem.
#![allow(missing_docs)]

use benchmarks::marths::bench::{MarthsRecord, MarthsRow, Problem, rows};
use benchmarks::marths::contestants::PairContestant;
use std::path::{Path, PathBuf};

fn data() -> Option<PathBuf> {
    Some(
        test_data::file("marths/K_matrix.csv")?
            .ancestors()
            .nth(2)?
            .to_owned(),
    )
}

fn problem(folder: &Path) -> (Problem, MarthsRecord) {
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let problem = Problem::parse(
        &read("marths/K_matrix.csv"),
        &read("marths/M_matrix.csv"),
        &read("marths/initial_parameters.csv"),
    )
    .unwrap();
    let points: Vec<f64> = read("ground-motion/RTHSBENCH_ElCentro.csv")
        .lines()
        .filter_map(|l| l.split_once(',')?.1.trim().parse::<f64>().ok())
        .map(|g| g * 9.80665)
        .collect();
    let record = problem.record("ElCentro", &points, 0.02).unwrap();
    (problem, record)
}

fn close(name: &str, found: [f64; 2], known: [f64; 2], within: f64) {
    for i in 0..2 {
        assert!(
            (found[i] - known[i]).abs() <= within,
            "{name}: {found:?}, known {known:?} within {within}"
        );
    }
}

#[test]
fn published_controllers_have_the_figures_that_others_found() {
    let Some(folder) = data() else { return };
    let (problem, record) = problem(&folder);
    let of = |contestant| -> MarthsRow {
        rows(
            &problem,
            std::slice::from_ref(&record),
            &[contestant],
            0,
            1,
            |_| std::ops::ControlFlow::Continue(()),
        )
        .unwrap()
        .remove(0)
    };
    let none = of(PairContestant::None);
    close("none J2", none.j.j2, [53.0, 33.0], 1.0);
    close("none J5", none.j.j5, [39.0, 13.0], 1.0);
    close("none J7", none.j.j7, [36.0, 11.0], 1.0);
    let fir = of(PairContestant::Fir);
    close("fir J2", fir.j.j2, [32.0, 11.0], 1.0);
    close("fir J7", fir.j.j7, [20.0, 15.0], 1.0);
    let rodeac = of(PairContestant::Rodeac);
    close("rodeac J2", rodeac.j.j2, [3.4, 1.8], 0.3);
    close("rodeac J2*", rodeac.j.j2_true, [2.0, 1.2], 0.3);
    close("rodeac J7", rodeac.j.j7, [9.6, 8.5], 0.3);
    close("floor of J7", rodeac.j7_floor, [9.78, 7.69], 0.05);
}

#[test]
fn a_pair_of_coupled_actuators_is_tracked_on_drawn_plants() {
    let Some(folder) = data() else { return };
    let (problem, record) = problem(&folder);
    let contestants = [
        PairContestant::CoupledFixed,
        PairContestant::CoupledRaw,
        PairContestant::Coupled,
    ];
    let all = rows(
        &problem,
        std::slice::from_ref(&record),
        &contestants,
        8,
        1,
        |_| std::ops::ControlFlow::Continue(()),
    )
    .unwrap();
    let [fixed, raw, coupled] = &all[..] else {
        panic!("three rows")
    };
    for row in &all {
        assert_eq!(
            (row.worst.perturbed, row.worst.lost),
            (8, 0),
            "{}",
            row.controller
        );
    }
    let below = |found: [f64; 2], most: [f64; 2]| {
        assert!(
            found[0] <= most[0] && found[1] <= most[1],
            "{found:?}, at most {most:?}"
        );
    };
    below(coupled.worst.j2_true, [0.45, 0.20]);
    below(coupled.worst.j5, [0.4, 1.0]);
    close("J7 at its floor", coupled.worst.j7, coupled.j7_floor, 0.1);
    below(raw.worst.j2_true, raw.j2_true_floor.map(|f| f + 0.1));
    // Without the estimation the errors of a drawn plant are visible, which is what the estimation is for.
    assert!(
        fixed.worst.j2_true[0] > 10.0 * raw.worst.j2_true[0],
        "{fixed:?}"
    );
}
