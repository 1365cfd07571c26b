//! A whole test in a page: one storey, an actuator that is 4 ms late, half a minute of a swinging ground.
//!
//! Prints the largest displacement with the paper's compensation and without any: 2 % of damping are less than 4 ms of
//! delay take away, so that the test without compensation grows for ever.
//!
//! ```text
//! cargo run --release -p core --example minimal
//! ```

use outerloop_core::{
    Config, Design, Event, GroundMotion, Method, Mode, OuterLoop, Refusal, Sample,
};

/// Restoring force per displacement, N/m.
const STIFFNESS: f32 = 158e3;

/// The largest displacement of a test, m.
fn largest(method: Method) -> Result<f32, Refusal> {
    let mut config = Config::shear_frame([1000.0], [f64::from(STIFFNESS)], [0.02]);
    config.compensation.kind = method;
    config.compensation.delay_ms = 4.0.into();
    let mut outer = OuterLoop::<1>::new(Design::new(&config)?);

    let points: [f32; 3000] = core::array::from_fn(|i| libm::sinf(0.11 * i as f32));
    let ground =
        GroundMotion::new(&points, 0.01, config.model_step_s()).unwrap_or(GroundMotion::none());

    // The rig: eight control periods of 0.5 ms late, elastic.
    let (mut on_the_way, mut largest) = ([0.0_f32; 8], 0.0_f32);
    while outer.mode() != Mode::Finished {
        let displacement_m = on_the_way[7];
        let sample = Sample::new([displacement_m], [STIFFNESS * displacement_m]);
        let step = outer.step(&sample, &ground);
        on_the_way.rotate_right(1);
        on_the_way[0] = step.command_m[0];
        largest = largest.max(displacement_m.abs());
        // What an operator does: an event that means nothing yet is refused and changes nothing.
        let _ = outer.handle(match outer.mode() {
            Mode::Idle => Event::Arm,
            _ => Event::Start,
        });
    }
    Ok(largest)
}

fn main() -> Result<(), Refusal> {
    for method in [Method::Paper, Method::None] {
        println!("{method}: {:.1} mm", 1e3 * largest(method)?);
    }
    Ok(())
}
