//! How long a step of a rig takes: `cargo run --release -p plant --example step_time`.

use std::hint::black_box;
use std::time::Instant;

use plant::{Rig, RigError, RigSpec};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (name, table) in [
        (
            "delay, linear, no noise",
            "actuator = { kind = 'delay', delay_ms = 4 }",
        ),
        (
            "second order, bilinear, no noise",
            "actuator = { kind = 'second_order', delay_ms = 8 }
             specimen = { kind = 'bilinear', yield_mm = 30 }",
        ),
        (
            "delay, linear, noise and 16 bits",
            "actuator = { kind = 'delay', delay_ms = 4 }
             sensors = { displacement_noise_mm = 0.1, force_noise_n = 20, bits = 16 }",
        ),
        (
            "random multiplier, linear, no noise",
            "actuator = { kind = 'random_multiplier', delay_ms = 4 }",
        ),
        (
            "servo-hydraulic, linear, no noise",
            "actuator = { kind = 'servo_hydraulic', delay_ms = 8 }",
        ),
        (
            "delay, Bouc-Wen, no noise",
            "actuator = { kind = 'delay', delay_ms = 4 }
             specimen = { kind = 'bouc_wen', yield_mm = 30 }",
        ),
    ] {
        let spec: RigSpec = toml::from_str(table)?;
        println!("{:7.1} ns a step: {name}", nanoseconds(&spec)?);
    }
    Ok(())
}

/// Best of five runs, of a motion that changes in every step.
fn nanoseconds(spec: &RigSpec) -> Result<f64, RigError> {
    const STEPS: u32 = 1_000_000;
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let mut rig = Rig::new(spec, &[158e3], 2000.0, 1)?;
        let (mut u, mut v) = (0.05, 0.0);
        let began = Instant::now();
        for _ in 0..STEPS {
            // An oscillator of 2 Hz, so that the commands cost next to nothing.
            v -= u * 4e-5;
            u += v;
            black_box(rig.step(black_box(&[u])));
        }
        best = began.elapsed().as_secs_f64().min(best);
    }
    Ok(best * 1e9 / f64::from(STEPS))
}
