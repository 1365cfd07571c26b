//! Trials side by side have the same bits as trials run one by one.
#![allow(missing_docs)]

use benchmarks::rths::case::CASES;
use benchmarks::rths::channels::Noise;
use benchmarks::rths::parameters::Parameters;
use benchmarks::rths::trial::{Official, run};
use benchmarks::rths::yielding::Behaviour;
use benchmarks::rths::{Contestant, GroundRecord, Rules};

/// Three seconds of a ground motion of several frequencies that swells and fades, m/s^2.
fn record(rules: &Rules, behaviour: Behaviour) -> GroundRecord {
    let acc: Vec<f32> = (0..300)
        .map(|i| {
            let t = i as f32 * 0.01;
            let wave = (20.0 * t).sin() + 0.7 * (33.0 * t + 1.0).sin() + 0.4 * (71.0 * t).sin();
            4.0 * wave * (t * 1.05).sin().powi(2)
        })
        .collect();
    GroundRecord::new("waves", &acc, 0.01, rules, behaviour)
}

#[test]
fn four_lanes_are_four_trials() {
    let rules = Rules::official();
    let plants: [Parameters; 4] = std::array::from_fn(|l| Parameters::perturbed(l as u64));
    for behaviour in [Behaviour::Linear, Behaviour::Pinched] {
        let record = record(&rules, behaviour);
        let noise: Vec<Noise> = (0..4).map(|l| Noise::new(l, record.samples())).collect();
        for name in [
            "pi-phase-lead",
            "ats",
            "amb/lead=1",
            "hydraulic/mu=1.5",
            "tangent",
            "paper",
        ] {
            let contestant = Contestant::named(name).unwrap();
            let make = || contestant.make(&CASES[2]).unwrap();
            let made = [make(), make(), make(), make()];
            let mut hybrid = Official::new(&rules, &CASES[2], &plants, made).unwrap();
            let ground = record.ground(2);
            let four = [&noise[0], &noise[1], &noise[2], &noise[3]];
            let together = run(&mut hybrid, &plants, ground, &four, None);
            for l in 0..4 {
                let plant = [plants[l]];
                let mut one = Official::new(&rules, &CASES[2], &plant, [make()]).unwrap();
                let alone = run(&mut one, &plant, ground, &[&noise[l]], None);
                let scale = record.scale(2);
                assert_eq!(
                    together.verdict(l, scale, true),
                    alone.verdict(0, scale, true),
                    "{name}, lane {l}"
                );
            }
        }
    }
}

/// What the delay of the force costs a controller that tracks without error.
#[test]
fn the_unit_delay_costs_a_perfect_tracker_most_of_what_is_left() {
    let j4 = |rules: &Rules| {
        let record = record(rules, Behaviour::Linear);
        let noise = Noise::new(1, record.samples());
        let contestant = Contestant::named("hydraulic").unwrap();
        let plant = [Parameters::NOMINAL];
        let made = [contestant.make(&CASES[3]).unwrap()];
        let mut hybrid = Official::new(rules, &CASES[3], &plant, made).unwrap();
        let judge = run(&mut hybrid, &plant, record.ground(3), &[&noise], None);
        let verdict = judge.verdict(0, record.scale(3), true);
        assert!(verdict.j2_true < 0.2, "{}", verdict.j2_true);
        verdict.j4_true
    };
    let official = j4(&Rules::official());
    let without = j4(&Rules::official().with("no-unit-delay").unwrap());
    // Of the delay of one and a half samples, the half for which the force is held remains.
    assert!(
        (without / official - 1.0 / 3.0).abs() < 0.05,
        "{without} of {official}"
    );
}
