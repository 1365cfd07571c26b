//! The goals set in the benchmark problems are reached, by their own rules and on their own files.

use benchmarks::marths::bench::{MarthsRecord, Problem, rows};
use benchmarks::marths::contestants::PairContestant;
use benchmarks::rths::yielding::Behaviour;
use benchmarks::rths::{Benchmark, Contestant, GroundRecord, Rules};
use host_tests::data;
use host_tests::targets::{Goal, goals};
use serde_json::json;
use std::ops::ControlFlow;

fn rths(controllers: &[&str]) -> Option<Vec<Goal>> {
    let shaking = data::ground_motion("RTHSBENCH_ElCentro")?;
    let rules = Rules::official();
    let record = GroundRecord::new(
        "ElCentro",
        &shaking.acc_m_per_s2,
        shaking.interval_s,
        &rules,
        Behaviour::Linear,
    );
    let contestants: Vec<Contestant> = controllers
        .iter()
        .map(|name| Contestant::named(name).expect("a controller"))
        .collect();
    let bench = Benchmark {
        rules: &rules,
        records: &[record],
        contestants: &contestants,
        plants: 20,
        seed: 1,
    };
    let rows = bench.rows(|_| ControlFlow::Continue(())).expect("trials");
    let answer = json!({ "rules": rules.name(), "rows": rows, "seconds": 0 });
    Some(goals(&answer).expect("goals"))
}

#[test]
fn those_of_one_actuator_are_reached() {
    let controllers = [
        "hydraulic/mu=1.5",
        "hydraulic/mu=0.78/lead=0.5",
        "amb/lead=1",
    ];
    let Some(goals) = rths(&controllers) else {
        return;
    };
    // Six goals of our own and the distance of `amb/lead=1` from a port.
    assert_eq!(goals.len(), 7, "{goals:?}");
    for goal in &goals {
        assert!(goal.reached(), "{}", goal.sentence());
    }
}

#[test]
fn what_the_published_controller_misses_is_said_with_its_reason() {
    let Some(goals) = rths(&["pi-phase-lead"]) else {
        return;
    };
    let missed: Vec<String> = goals
        .iter()
        .filter(|goal| !goal.reached())
        .map(Goal::sentence)
        .collect();
    let worst = missed.iter().find(|said| said.contains("46/42/64/104"));
    let worst = worst.unwrap_or_else(|| panic!("{missed:?}"));
    assert!(worst.contains("missed by") && worst.contains("--deviate uniform-plants"));
}

fn marths() -> Option<(Problem, MarthsRecord)> {
    let text = |name: &str| {
        let file = test_data::file(&format!("marths/{name}"))?;
        Some(std::fs::read_to_string(file).expect("a text"))
    };
    let problem = Problem::parse(
        &text("K_matrix.csv")?,
        &text("M_matrix.csv")?,
        &text("initial_parameters.csv")?,
    )
    .expect("the problem");
    let shaking = data::ground_motion("RTHSBENCH_ElCentro")?;
    let points: Vec<f64> = shaking
        .acc_m_per_s2
        .iter()
        .copied()
        .map(f64::from)
        .collect();
    let record = problem.record("ElCentro", &points, shaking.interval_s);
    Some((problem, record.expect("a record")))
}

#[test]
fn those_of_two_actuators_are_reached() {
    let Some((problem, record)) = marths() else {
        return;
    };
    let contestants = [
        PairContestant::Rodeac,
        PairContestant::CoupledRaw,
        PairContestant::Coupled,
    ];
    let go_on = |_| ControlFlow::Continue(());
    let rows = rows(&problem, &[record], &contestants, 3, 1, go_on).expect("trials");
    let goals = goals(&json!({ "rows": rows })).expect("goals");
    // RoDeAC reproduced; J2*, J5, J7 and J2* of raw readings; none lost. J7's floor as identified: `benchmark_marths` of cli.
    assert_eq!(goals.len(), 6, "{goals:?}");
    for goal in &goals {
        assert!(goal.reached(), "{}", goal.sentence());
    }
    assert!(goals[1].asked.contains("100 were asked for"));
}
