//! A signal on the simulated rig, in this process: core's loop follows targets instead of a structure.

use super::plant::{FromRest, sample};
use super::played::Played;
use crate::failure::Failure;
use crate::files::signal::SignalPoints;
use crate::files::test::TestFile;
use crate::floors::with_floors;
use crate::trace::TestObserver;
use ::plant::Rig;
use outerloop_core::{Design, Event, GroundMotion, Mode, OuterLoop, config::Limits};

/// Plays `signal` under `limits` on the simulated rig of `test`.
///
/// # Errors
/// A refused parameter; a test with more than one actuator.
pub fn play(
    test: &TestFile,
    limits: Limits,
    signal: &SignalPoints,
    seed: u64,
    observer: &mut dyn TestObserver,
) -> Result<Played, Failure> {
    let mut config = test.config.clone();
    config.limits = limits;
    let refuse = |e: &dyn std::fmt::Display| Failure::input(e.to_string());
    if config.physical_storeys() != 1 {
        return Err(Failure::input(format!(
            "the test has {} storeys in the laboratory: accepted for a signal is one actuator",
            config.physical_storeys()
        )));
    }
    let rate_hz = config.timing.rate_hz;
    let storeys = &config.structure.stiffness_n_per_m[..1];
    let mut rig = Rig::new(&test.plant, storeys, rate_hz, seed).map_err(|e| refuse(&e))?;
    // The structure is not involved: only one of its floors, the actuator's, moves.
    let floors = config.degrees_of_freedom();
    with_floors!(floors, N => {
        let design = Design::<N>::new(&config).map_err(|e| refuse(&e))?;
        let mut outer = OuterLoop::new(design);
        let mut goals = signal.every(1.0 / rate_hz).into_iter();
        let mut played = Played::new();
        let (mut command_m, mut from_rest) = (0.0_f64, FromRest::default());
        loop {
            let reading = rig.step(&[command_m]);
            let read = (&reading.displacement_m[..], &reading.force_n[..]);
            let sample = sample(read, reading.at_rail);
            let before = outer.mode();
            if matches!(before, Mode::Running | Mode::Commissioning) {
                match goals.next() {
                    Some(goal_m) => {
                        let mut goal = [0.0; N];
                        goal[0] = goal_m as f32;
                        outer.set_commissioning_command(Some(goal));
                    }
                    None => drop(outer.handle(Event::Finish)),
                }
            }
            let step = outer.step(&sample, &GroundMotion::none());
            let record = *step.record;
            command_m = f64::from(step.command_m[0]);
            match outer.mode() {
                Mode::Commissioning => {
                    observer.on_step(&(&record).into());
                    let (x, f) = (sample.displacement_m[0], sample.force_n[0]);
                    // The command that was active during the sample.
                    played.add(rate_hz, record.command_m[0], x, f);
                }
                Mode::Finished => return Ok(played),
                Mode::Tripped => {
                    let fault = outer.trip().map_or("a fault", |t| t.fault.name());
                    return Ok(played.ended_early(format!("the loop tripped on {fault}")));
                }
                mode => {
                    if !from_rest.care(&mut outer, mode)? {
                        observer.on_idle_step(&(&record).into());
                    }
                }
            }
            if let Some(event) = observer.requested_event()
                && outer.handle(event).is_ok()
                && event == Event::Stop
            {
                return Ok(played.ended_early(Played::BY_HAND.into()));
            }
        }
    })
}
