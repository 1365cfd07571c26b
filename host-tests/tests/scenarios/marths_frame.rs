//! The multi-axial benchmark without the problem's tables: its actuators, its loop and its criteria on a frame and a ground
//! motion made up here.

use benchmarks::marths::bench::{MarthsRow, Problem, rows};
use benchmarks::marths::contestants::PairContestant::{
    self, Coupled, CoupledFixed, CoupledRaw, Fir, None, Rodeac,
};
use benchmarks::marths::criteria::{Both, Criteria};
use benchmarks::marths::frame::InterfaceFrame;
use benchmarks::marths::structure::PhysicalMatrices;
use host_tests::{data, frame};
use std::ops::ControlFlow;

fn problem() -> Problem {
    let [stiffness, mass, start] = frame::tables();
    Problem::parse(&stiffness, &mass, &start).expect("a frame of the problem's size")
}

/// A row for each controller, under half a minute of the generated motion, as strong as El Centro.
fn judged<const N: usize>(
    problem: &Problem,
    controllers: [PairContestant; N],
    plants: usize,
) -> [MarthsRow; N] {
    let motion = data::drawn();
    let points = motion.acc_m_per_s2.iter().take(3000);
    let points: Vec<f64> = points.map(|a| 0.7 * f64::from(*a)).collect();
    let record = problem.record("drawn", &points, motion.interval_s);
    let records = [record.expect("a structure")];
    let go_on = |_| ControlFlow::Continue(());
    let found = rows(problem, &records, &controllers, plants, 1, go_on).expect("trials");
    for row in &found {
        println!("{}: {:.3?}", row.controller, row.j);
    }
    found.try_into().expect("a row each")
}

/// A criterion of x and rotation, or of both actuators.
type Criterion = (&'static str, fn(&Criteria) -> Both);

/// Each of `criteria` is below `most` with the compensation, and above ten times that without.
fn told_apart(criteria: &[(Criterion, Both)], [good, none]: [&MarthsRow; 2]) {
    for ((name, of), most) in criteria {
        let (found, without) = (of(&good.j), of(&none.j));
        for i in 0..2 {
            assert!(found[i] < most[i], "{name}: {found:.3?}, at most {most:?}");
            assert!(without[i] > 10.0 * most[i], "{name}: {without:.3?} without");
        }
    }
}

#[test]
fn the_pair_is_tracked_to_its_noise_and_without_compensation_it_is_far_off() {
    let [none, taps, rodeac, coupled] = judged(&problem(), [None, Fir, Rodeac, Coupled], 0);
    let criteria: [(Criterion, Both); 5] = [
        (("J2", |j| j.j2), [1.7, 1.0]),
        (("J2 of the true strokes", |j| j.j2_true), [0.3, 0.2]),
        (("J5", |j| j.j5), [0.2, 0.68]),
        (("J3", |j| j.j3), [1.7, 1.0]),
        (("J6", |j| j.j6), [0.2, 0.8]),
    ];
    told_apart(&criteria, [&coupled, &none]);
    // A sample is 1 ms.
    assert!(coupled.j.j1_ms.iter().all(|late| late.abs() < 1.5));
    assert!(none.j.j1_ms.iter().all(|late| *late > 20.0));
    assert_eq!(
        none.j.j2, taps.j.j2,
        "an inverse of one tap sends the target"
    );
    for i in 0..2 {
        let learnt = 10.0 * rodeac.j.j2_true[i];
        assert!(learnt < none.j.j2_true[i], "{:?}", rodeac.j);
        let apart = (coupled.j.j7[i] - coupled.j7_floor[i]).abs();
        assert!(
            apart < 0.2,
            "J7 {:?}, floor {:?}",
            coupled.j.j7,
            coupled.j7_floor
        );
    }
}

/// If what is really in the laboratory is subtracted, a loop without error is the whole structure.
#[test]
fn with_the_right_part_declared_the_structure_moves_as_its_reference_does() {
    let part = PhysicalMatrices::of_two(&InterfaceFrame::published().in_structure());
    let [none, coupled] = judged(&problem().with(&part), [None, Coupled], 0);
    assert!(coupled.j7_floor.iter().all(|floor| *floor < 0.02));
    let criteria: [(Criterion, Both); 3] = [
        (("J7", |j| j.j7), [0.2, 0.45]),
        (("J8", |j| j.j8), [0.08, 0.08]),
        (("J9", |j| j.j9), [0.2, 0.45]),
    ];
    told_apart(&criteria, [&coupled, &none]);
}

#[test]
fn on_drawn_plants_the_estimation_is_what_tracks() {
    let [fixed, raw, coupled] = judged(&problem(), [CoupledFixed, CoupledRaw, Coupled], 8);
    // In this row the plant is the nominal one.
    assert!(fixed.j.j2_true[0] < 0.4 && fixed.j.j2_true[1] < 0.25);
    for row in [&fixed, &raw, &coupled] {
        assert_eq!(
            (row.worst.perturbed, row.worst.lost),
            (8, 0),
            "{}",
            row.controller
        );
        println!("{}: {:.3?}", row.controller, row.worst);
    }
    for i in 0..2 {
        let (found, floor) = (raw.worst.j2_true[i], raw.j2_true_floor[i]);
        assert!(found < floor + 0.15, "{found}, floor {floor}");
        assert!(fixed.worst.j2_true[i] > 10.0 * found, "{:?}", fixed.worst);
        let (j5, most) = (coupled.worst.j5[i], [0.2, 0.9][i]);
        assert!(j5 < most && fixed.worst.j5[i] > 10.0 * j5, "{j5}");
        assert!(
            coupled.worst.j2_true[i] < [0.35, 0.2][i],
            "{:?}",
            coupled.worst
        );
    }
}
