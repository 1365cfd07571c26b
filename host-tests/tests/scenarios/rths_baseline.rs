//! The benchmark problem of real-time hybrid simulation by its own rules: published controllers give published figures.

use benchmarks::rths::channels::Noise;
use benchmarks::rths::yielding::Behaviour;
use benchmarks::rths::{Bench, Contestant, Record, RthsRow, Rules};
use host_tests::data;

/// Table 3 of the problem: J1 in ms, J2 to J9 in per cent, El Centro, nominal plant.
const TABLE_3: [[f64; 9]; 4] = [
    [4.6, 10.4, 11.5, 36.1, 19.0, 32.3, 32.4, 14.8, 14.8],
    [4.6, 9.8, 11.1, 33.1, 17.1, 30.5, 30.5, 15.3, 15.2],
    [4.6, 9.1, 10.2, 49.9, 36.7, 49.8, 49.8, 35.5, 35.6],
    [4.6, 10.5, 11.3, 72.6, 35.2, 68.5, 68.7, 33.4, 33.3],
];

fn record(name: &str) -> Option<Record> {
    let file = data::ground_motion(&format!("RTHSBENCH_{name}"))?;
    let rules = Rules::official();
    Some(Record::new(
        name,
        &file.acc_m_per_s2,
        file.interval_s,
        &rules,
        Behaviour::Linear,
    ))
}

/// The rows of some controllers, nominal plant.
fn rows(record: Record, names: &[&str], seed: u64) -> Vec<RthsRow> {
    let contestants: Vec<_> = names
        .iter()
        .map(|n| Contestant::named(n).expect("a controller"))
        .collect();
    let bench = Bench {
        rules: &Rules::official(),
        records: &[record],
        contestants: &contestants,
        plants: 0,
        seed,
    };
    bench.rows(|_| {}).expect("trials")
}

#[test]
fn the_published_controller_reproduces_table_3() {
    const SEEDS: [u64; 6] = [1, 2, 3, 4, 5, 6];
    let mut mean = [[0.0; 9]; 4];
    for seed in SEEDS {
        let Some(record) = record("ElCentro") else {
            return;
        };
        for (row, mean) in rows(record, &["pi-phase-lead"], seed).iter().zip(&mut mean) {
            assert!(row.within_limits);
            for (mean, j) in mean.iter_mut().zip(row.j) {
                *mean += j / SEEDS.len() as f64;
            }
        }
    }
    for (case, (found, published)) in mean.iter().zip(TABLE_3).enumerate() {
        println!("case {}: {found:.2?}", case + 1);
        for (i, (j, published)) in found.iter().zip(published).enumerate() {
            // J3 and J5 are the largest of a noisy reading; the published figure is one draw, ours the mean of six.
            assert!(
                (j - published).abs() <= 0.5,
                "case {}, J{} = {j:.2} instead of {published}",
                case + 1,
                i + 1
            );
        }
    }
}

/// J2, J2*, J4, J4* and J7 of cases 1 to 4 from an independent port, per cent.
const ADAPTIVE: [(&str, [[f64; 4]; 5]); 3] = [
    (
        "amb",
        [
            [2.55, 2.39, 1.57, 1.98],
            [0.37, 0.34, 0.27, 0.32],
            [3.16, 2.95, 3.03, 3.61],
            [1.9, 1.7, 2.6, 3.0],
            [1.8, 1.7, 2.6, 3.0],
        ],
    ),
    (
        "amb/lead=1",
        [
            [2.62, 2.46, 1.66, 2.08],
            [0.65, 0.62, 0.55, 0.66],
            [2.72, 2.55, 1.91, 2.28],
            [0.94, 0.90, 1.1, 1.1],
            [0.7, 0.6, 0.9, 1.0],
        ],
    ),
    (
        "fixed-inverse",
        [
            [2.5, 2.4, 1.6, 2.0],
            [0.33, 0.30, 0.28, 0.33],
            [3.7, 3.4, 3.9, 4.8],
            [2.6, 2.4, 3.6, 4.4],
            [2.5, 2.4, 3.5, 4.3],
        ],
    ),
];

#[test]
fn others_are_within_three_tenths_of_an_independent_port() {
    let Some(record) = record("ElCentro") else {
        return;
    };
    let found = rows(record, &ADAPTIVE.map(|(name, _)| name), 1);
    for (name, published) in ADAPTIVE {
        for row in found.iter().filter(|r| r.controller == name) {
            let figures = [row.j[1], row.j2_true, row.j[3], row.j4_true, row.j[6]];
            println!("{name}, case {}: {figures:.2?}", row.case);
            for (figure, published) in figures.iter().zip(published) {
                let published = published[usize::from(row.case) - 1];
                assert!(
                    (figure - published).abs() <= 0.3,
                    "{name}, case {}: {figure:.2} instead of {published}",
                    row.case
                );
            }
        }
    }
}

/// J2 of the noise alone, cases 1 to 4, per cent.
const NOISE: [(&str, [f64; 4]); 3] = [
    ("ElCentro", [2.51, 2.36, 1.54, 1.94]),
    ("Kobe", [2.83, 2.50, 1.92, 2.44]),
    ("Morgan", [3.16, 3.25, 2.98, 2.35]),
];

#[test]
fn the_noise_alone_is_as_large_as_it_is_said_to_be() {
    for (name, published) in NOISE {
        let Some(record) = record(name) else {
            return;
        };
        let floors = record.floors(&Noise::new(1, record.samples()), true);
        for (floor, published) in floors.iter().zip(published) {
            println!("{name}: {:.2} of {published}", floor[1]);
            assert!((floor[1] - published).abs() < 0.12, "{name}: {floor:?}");
        }
    }
}

/// J4 of the published controller on the worst of twenty drawn plants in an independent port, cases 1 to 4, per cent.
const WORST_DRAWN: [f64; 4] = [46.0, 42.0, 64.0, 104.0];

/// The port's draws are not known. Drawn evenly from three standard deviations to either side, plants give its figures;
/// `cargo run --release -p benchmarks --example worst_plants` prints other controllers and the normal draw beside them.
#[test]
fn evenly_drawn_plants_have_the_worst_figures_of_an_independent_port() {
    const SEEDS: std::ops::RangeInclusive<u64> = 1..=5;
    let rules = Rules::official()
        .with("uniform-plants")
        .expect("a deviation");
    let contestants = [Contestant::named("pi-phase-lead").expect("it is there")];
    let mut worst = [[0.0; 5]; 4];
    for (place, seed) in SEEDS.enumerate() {
        let Some(record) = record("ElCentro") else {
            return;
        };
        let bench = Bench {
            rules: &rules,
            records: &[record],
            contestants: &contestants,
            plants: 20,
            seed,
        };
        for row in bench.rows(|_| {}).expect("trials") {
            worst[usize::from(row.case) - 1][place] = row.j4_worst;
        }
    }
    for (case, (mut found, published)) in worst.into_iter().zip(WORST_DRAWN).enumerate() {
        found.sort_by(f64::total_cmp);
        println!("case {}: {found:.1?}, port {published}", case + 1);
        assert!(
            (found[2] / published - 1.0).abs() < 0.1,
            "case {}: {found:?}",
            case + 1
        );
    }
}
