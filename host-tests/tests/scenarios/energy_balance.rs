//! Eq 15: the works of all terms of the equation of motion, summed from the records, balance.

use host_tests::{Scenario, Shaking, table1};

fn shaking() -> Shaking {
    Shaking {
        acc_m_per_s2: (0..2000)
            .map(|i| {
                let t = f64::from(i) * 0.01;
                (3.0 * (11.0 * t).sin() * (0.7 * t).sin() + 2.0 * (4.0 * t).cos()) as f32
            })
            .collect(),
        interval_s: 0.01,
    }
}

#[test]
fn eq_15_closes_to_rounding_with_compensation_and_a_late_actuator() {
    let config = table1();
    let (m, zeta, k) = (1000.0, 0.02, 158e3_f64);
    let c = 2.0 * zeta * (k * m).sqrt();
    let trace = Scenario::delayed(config, 4.0).run::<1>(&shaking(), 20.0, 1);
    let mut work = [0.0_f64; 5];
    let mut last = [0.0_f64; 5];
    let mut scale = 0.0_f64;
    for pair in trace.records.windows(2) {
        let r = &pair[1];
        let du = f64::from(r.command_m[0]) - f64::from(pair[0].command_m[0]);
        let v = f64::from(r.velocity_m_per_s[0]);
        let force = [
            m * f64::from(r.acceleration_m_per_s2[0]),
            c * v,
            f64::from(r.estimated_force_n[0]),
            f64::from(r.added_damping_n_s_per_m[0]) * v,
            m * f64::from(r.ground_m_per_s2),
        ];
        for i in 0..5 {
            work[i] += 0.5 * (last[i] + force[i]) * du;
        }
        last = force;
        scale = scale.max(work.iter().fold(0.0, |s, w| s + w.abs()));
    }
    let rest: f64 = work.iter().sum();
    println!(
        "inertia {:.1}, damping {:.1}, specimen {:.1}, compensation {:.1}, ground {:.1} J; rest {rest:.1e}",
        work[0], work[1], work[2], work[3], work[4]
    );
    assert!(work[3] > 0.1 * work[1], "the compensation did work");
    assert!(rest.abs() < 3e-6 * scale, "rest {rest} J of {scale} J");
}

#[test]
fn what_the_compensation_takes_out_is_what_the_actuator_put_in() {
    let trace = Scenario::delayed(table1(), 4.0).run::<1>(&shaking(), 20.0, 1);
    let last = trace.records.last().unwrap();
    println!(
        "monitor: {:.4} of the energy in the test",
        last.energy_ratio
    );
    assert!(last.energy_ratio < 0.03);
}
