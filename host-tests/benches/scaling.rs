//! Cost of a step with 1, 2, 4 and 8 degrees of freedom, and how it grows.
//!
//! `cargo bench -p host-tests --bench scaling`. The best of several runs, without the plant: a step is what the board does.
#![allow(missing_docs)]

use host_tests::Scenario;
use host_tests::qemu::bench::{rig, shaking};
use outerloop_core::{Config, Design, Event, GroundMotion, Method, Mode, OuterLoop, Sample};
use std::hint::black_box;
use std::time::Instant;

const STEPS: usize = 20_000;
const RUNS: usize = 15;

/// Nanoseconds per step with `method`: samples are recorded first, so that only core is timed.
fn cost_ns<const N: usize>(method: Method) -> f64 {
    let mut scenario = Scenario::delayed(
        Config::shear_frame([1000.0; N], [797.3e3; N], [0.02; N]),
        4.0,
    );
    scenario.config.compensation.kind = method;
    let motion = shaking(STEPS as f64 / scenario.config.timing.rate_hz);
    let step_s = scenario.config.model_step_s();
    let ground = GroundMotion::new(&motion.acc_m_per_s2, motion.interval_s, step_s);
    let ground = ground.expect("a possible record");
    let begin = || {
        let design = Design::<N>::new(&scenario.config).expect("a possible test");
        let mut outer = OuterLoop::new(design);
        let rest = Sample::new([0.0; N], [0.0; N]);
        while outer.mode() != Mode::Running {
            outer.step(&rest, &ground);
            let event = match outer.mode() {
                Mode::Idle => Event::Arm,
                _ => Event::Start,
            };
            let _ = outer.handle(event);
        }
        outer
    };
    let (mut outer, mut rig, mut command_m) = (begin(), rig::<N>(&scenario, 1), [0.0; N]);
    let samples: Vec<Sample<N>> = (0..STEPS)
        .map(|_| {
            let sample = rig(&command_m);
            command_m = outer.step(&sample, &ground).command_m;
            sample
        })
        .collect();
    let run = |_| {
        let mut outer = begin();
        let began = Instant::now();
        for sample in &samples {
            black_box(outer.step(black_box(sample), &ground).command_m);
        }
        assert_eq!(outer.mode(), Mode::Running, "the whole loop was at work");
        began.elapsed().as_secs_f64() * 1e9 / STEPS as f64
    };
    (0..RUNS).map(run).fold(f64::INFINITY, f64::min)
}

/// Least squares fit of `a + b n + c n^2`.
fn fit(points: &[(f64, f64)]) -> [f64; 3] {
    let mut m = [[0.0; 4]; 3];
    for &(n, ns) in points {
        // Relative errors: the cost of one floor matters as much as that of eight.
        let row = [1.0 / ns, n / ns, n * n / ns];
        for i in 0..3 {
            for j in 0..3 {
                m[i][j] += row[i] * row[j];
            }
            m[i][3] += row[i];
        }
    }
    for i in 0..3 {
        for k in 0..3 {
            if k != i {
                let factor = m[k][i] / m[i][i];
                for j in 0..4 {
                    m[k][j] -= factor * m[i][j];
                }
            }
        }
    }
    core::array::from_fn(|i| m[i][3] / m[i][i])
}

fn main() {
    println!("nanoseconds of a step of core on this machine, by degrees of freedom n");
    println!(
        "{:12} {:>7} {:>7} {:>7} {:>7}   a + b n + c n^2",
        "", 1, 2, 4, 8
    );
    for method in [Method::None, Method::Paper, Method::Afp, Method::Tangent] {
        let costs = [
            cost_ns::<1>(method),
            cost_ns::<2>(method),
            cost_ns::<4>(method),
            cost_ns::<8>(method),
        ];
        let points: Vec<_> = [1.0, 2.0, 4.0, 8.0].into_iter().zip(costs).collect();
        let [a, b, c] = fit(&points);
        print!("{:12}", method.name());
        for ns in costs {
            print!(" {ns:7.1}");
        }
        println!("   {a:.0} {b:+.1} n {c:+.2} n^2");
    }
}
