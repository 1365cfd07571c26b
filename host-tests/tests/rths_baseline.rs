//! The benchmark problem of real-time hybrid simulation: the published controller gives the published figures.
#![allow(missing_docs)]

use benchmarks::rths::baseline::Baseline;
use benchmarks::rths::case::CASES;
use benchmarks::rths::transfer::Parameters;
use benchmarks::rths::trial::{Shaking, judge};
use host_tests::data;

/// Table 3 of the problem: J1 in ms, J2 to J9 in per cent, El Centro, nominal plant.
const TABLE_3: [[f64; 9]; 4] = [
    [4.6, 10.4, 11.5, 36.1, 19.0, 32.3, 32.4, 14.8, 14.8],
    [4.6, 9.8, 11.1, 33.1, 17.1, 30.5, 30.5, 15.3, 15.2],
    [4.6, 9.1, 10.2, 49.9, 36.7, 49.8, 49.8, 35.5, 35.6],
    [4.6, 10.5, 11.3, 72.6, 35.2, 68.5, 68.7, 33.4, 33.3],
];

/// J3 and J5 are largest values of a noisy reading: they depend on the draw of the noise, the others do not.
const OF_A_PEAK: [usize; 2] = [2, 4];

#[test]
fn the_published_controller_reproduces_table_3() {
    let Some(record) = data::ground_motion("RTHSBENCH_ElCentro") else {
        return;
    };
    let points: Vec<f64> = record.acc_m_per_s2.iter().copied().map(f64::from).collect();
    let shaking = Shaking::new(&points, record.interval_s);
    for (case, published) in CASES.iter().zip(TABLE_3) {
        let reference = shaking.reference(case);
        for draw in [1, 2, 3, 8] {
            let mut baseline = Baseline::new(case).expect("a structure with mass");
            let (found, trace) = judge(
                &mut baseline,
                &Parameters::NOMINAL,
                &shaking,
                &reference,
                draw,
            );
            assert!(trace.demand.within_limits());
            println!("case {}, noise {draw}: {:.2?}", case.number, found.all());
            for (i, (j, published)) in found.all().iter().zip(published).enumerate() {
                let bound = match draw {
                    // The draw that `outerloop benchmark rths` uses.
                    8 => 0.5,
                    _ if OF_A_PEAK.contains(&i) => 0.8,
                    _ => 0.3,
                };
                assert!(
                    (j - published).abs() <= bound,
                    "case {}, J{} = {j:.2} instead of {published}",
                    case.number,
                    i + 1
                );
            }
        }
    }
}
