//! The closed loop of core and the simulated rig.

use super::{Finished, Progress, Trace};
use crate::failure::Failure;
use crate::files::ground_motion::GroundMotionFile;
use crate::files::test::TestFile;
use ::plant::Rig;
use outerloop_core::{Design, Event, GroundMotion, OuterLoop, Sample, State};
use std::time::Instant;

/// Idle steps before arming: the loop averages where the specimen stands.
const IDLE_STEPS: usize = 256;
/// Steps between two reports of progress.
const PROGRESS_STEPS: usize = 1 << 14;

/// Idles, arms, approaches, runs.
pub fn run<const N: usize>(
    test: &TestFile,
    design: Design<N>,
    shaking: &GroundMotionFile,
    seconds: f64,
    seed: u64,
    progress: Progress<'_>,
) -> Result<Finished, Failure> {
    let config = &test.config;
    let rate_hz = config.timing.rate_hz;
    let physical = config.physical_storeys();
    let storeys = &config.structure.stiffness_n_per_m[..physical];
    let mut rig =
        Rig::new(&test.plant, storeys, rate_hz, seed).map_err(|e| Failure::input(e.to_string()))?;
    let scale = test.excitation.scale as f32;
    let acc: Vec<f32> = shaking.acc_m_per_s2.iter().map(|a| a * scale).collect();
    let ground =
        GroundMotion::new(&acc, shaking.interval_s, config.model_step_s()).ok_or_else(|| {
            Failure::input(format!(
                "{}: an interval of {} s cannot be laid over integration steps of {} s",
                shaking.name,
                shaking.interval_s,
                config.model_step_s()
            ))
        })?;
    let steps = (seconds * config.timing.time_scale * rate_hz).round() as usize;
    let began = Instant::now();
    let mut outer = OuterLoop::new(design);
    let mut trace = Trace::with_floors(N);
    let mut command_m = [0.0; N];
    let mut tick = 0_usize;
    loop {
        let reading = rig.step(&command_m[..physical]);
        let mut sample = Sample::new([0.0; N], [0.0; N]);
        for j in 0..physical {
            sample.displacement_m[j] = reading.displacement_m[j] as f32;
            sample.force_n[j] = reading.force_n[j] as f32;
        }
        let before = outer.state();
        let step = outer.step(&sample, &ground);
        command_m = step.command_m.map(f64::from);
        tick += 1;
        match before {
            State::Idle if tick >= IDLE_STEPS => {
                outer
                    .handle(Event::Arm)
                    .map_err(|e| Failure::Test(e.to_string()))?;
            }
            // Refused until the approach has ended, which it does: the distance is finite.
            State::Armed => drop(outer.handle(Event::Start)),
            State::Running => trace.push(trace.time_s.len() as f64 / rate_hz, &step.record),
            _ => {}
        }
        let done = trace.time_s.len();
        if done > 0 && done.is_multiple_of(PROGRESS_STEPS) {
            progress(done as f64 / steps as f64);
        }
        let over = !matches!(outer.state(), State::Idle | State::Armed | State::Running);
        if done >= steps || over {
            break;
        }
    }
    Ok(Finished {
        trace,
        state: outer.state(),
        trip: outer.trip(),
        wall_s: began.elapsed().as_secs_f64(),
    })
}
