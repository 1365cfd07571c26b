//! Two methods on a specimen that yields, behind an actuator that is 8 ms late.
//!
//! The reference is the same test with an ideal actuator. Variable damping (`paper`) takes out the energy that lateness puts
//! in, but not the stiffness that it adds; a tangent force behind adaptive forward prediction (`tangent`) takes out both. You
//! should see an error of some per cent of the peak for the first and a tenth of that or less for the second.
//!
//! ```text
//! cargo run --release -p core --example yielding
//! ```

use outerloop_core::{
    Config, Design, Event, GroundMotion, Method, Mode, OuterLoop, Refusal, Sample,
};

/// Elastic stiffness, N/m, displacement at yield, m, and stiffness behind it over the elastic one.
const SPECIMEN: (f32, f32, f32) = (158e3, 0.02, 0.05);

/// Control periods of 0.5 ms.
const PERIODS: usize = 20_000;

/// An elastic-plastic slider beside a spring: the simplest specimen that yields.
struct Specimen {
    slid_m: f32,
}

impl Specimen {
    fn force_n(&mut self, displacement_m: f32) -> f32 {
        let (stiffness, yield_m, hardening) = SPECIMEN;
        let elastic_m = (displacement_m - self.slid_m).clamp(-yield_m, yield_m);
        self.slid_m = displacement_m - elastic_m;
        stiffness * (hardening * displacement_m + (1.0 - hardening) * elastic_m)
    }
}

/// Where the structure went behind an actuator that is `late` control periods late, at most 16, m.
fn response(method: Method, late: usize) -> Result<Vec<f32>, Refusal> {
    let mut config = Config::shear_frame([1000.0], [f64::from(SPECIMEN.0)], [0.02]);
    config.compensation.kind = method;
    config.compensation.delay_ms = 8.0.into();
    let mut outer = OuterLoop::<1>::new(Design::new(&config)?);
    let points: [f32; 1000] = core::array::from_fn(|i| {
        let t = 0.01 * i as f32;
        3.0 * libm::sinf(9.0 * t) * libm::sinf(0.314 * t)
    });
    let ground =
        GroundMotion::new(&points, 0.01, config.model_step_s()).unwrap_or(GroundMotion::none());
    let (mut on_the_way, mut specimen) = ([0.0_f32; 17], Specimen { slid_m: 0.0 });
    let mut targets_m = Vec::with_capacity(PERIODS);
    while targets_m.len() < PERIODS && outer.mode() != Mode::Finished {
        let displacement_m = on_the_way[late];
        let force_n = specimen.force_n(displacement_m);
        let step = outer.step(&Sample::new([displacement_m], [force_n]), &ground);
        targets_m.push(step.record.command_m[0]);
        on_the_way.rotate_right(1);
        on_the_way[0] = step.command_m[0];
        let _ = outer.handle(match outer.mode() {
            Mode::Idle => Event::Arm,
            _ => Event::Start,
        });
    }
    Ok(targets_m)
}

fn main() -> Result<(), Refusal> {
    let ideal = response(Method::None, 0)?;
    let peak = ideal.iter().fold(0.0_f32, |peak, u| peak.max(u.abs()));
    println!("ideal actuator: {:.1} mm", 1e3 * peak);
    for method in [Method::Paper, Method::Tangent] {
        let late = response(method, 15)?;
        let error = ideal
            .iter()
            .zip(&late)
            .fold(0.0_f32, |most, (a, b)| most.max((a - b).abs()));
        println!("{method}: off by {:.2} % of that", 1e2 * error / peak);
    }
    Ok(())
}
