//! What a diagnosis found out about a rig, in the next test.

mod cause;

pub use cause::Causes;

use diagnosis::Model;
use outerloop_core::Config;
use outerloop_core::Prediction;
use outerloop_core::config::PerActuator;
use plant::{Channel, Effect};

/// Lateness, ms, beyond what was expected, from which on a prediction is worth while.
const WORTH_PREDICTING_MS: f64 = 0.25;

/// The filter's model has a lag always; the shortest that it takes is as good as none.
pub(crate) const LEAST_LAG_MS: f64 = 0.05;

/// Puts what `model` knows into `config`, and says in sentences what was done with each part of it.
pub fn apply(model: &Model, config: &mut Config) -> Vec<String> {
    let causes = Causes::of(model, config.compensation.delay_ms);
    let mut said = Vec::new();
    space(&causes, config, &mut said);
    timing(&causes, config, &mut said);
    for &(channel, effect) in &causes.left {
        said.push(format!(
            "{effect} is not taken out: {}",
            why_not(channel, effect)
        ));
    }
    said
}

/// The same without the timing, which a test file may tell its compensation otherwise.
pub(crate) fn correct(model: &Model, config: &mut Config) {
    let causes = Causes::of(model, config.compensation.delay_ms);
    space(&causes, config, &mut Vec::new());
}

/// Everything but the actuator's own time.
fn space(causes: &Causes, config: &mut Config, said: &mut Vec<String>) {
    command(causes, config, said);
    readings(causes, config, said);
    forces(causes, config, said);
}

/// What to do about an effect that stays.
fn why_not(channel: Channel, effect: Effect) -> &'static str {
    use plant::Family::{
        Asymmetry, Damping, Gap, Hysteresis, Interference, Limit, Slow, Stiffness,
    };
    match (channel, effect, effect.entry().family) {
        (_, Effect::OilColumn, _) => {
            "only its lag is; its ringing needs a notch in the actuator's own controller"
        }
        (_, Effect::StribeckFriction, _) => {
            "only its sliding part is; what sticks on top of it at rest is left"
        }
        (Channel::Specimen, _, Hysteresis | Damping | Stiffness | Asymmetry) => {
            "what a specimen does is what the test is made to find out, so it belongs into the result"
        }
        (_, _, Slow) => "let the rig warm up, and zero the channel before each test",
        (_, _, Gap | Limit) => {
            "it is in the rig's mechanics, and only a repair or a smaller motion takes it away"
        }
        (_, _, Interference) => "find its source; a filter would delay the measurement",
        _ => "the loop has no correction for it",
    }
}

fn only(x: f64) -> PerActuator {
    [x].into_iter().collect()
}

/// Where the actuator goes: a matter of the command.
fn command(causes: &Causes, config: &mut Config, said: &mut Vec<String>) {
    let gain = causes.command_gain;
    if gain != 1.0 {
        config.rig.command_gain = only(gain);
        said.push(format!(
            "the actuator goes {gain:.4} times as far as it is sent: commands are divided by that"
        ));
    }
    let offset = causes.command_offset_mm;
    if offset != 0.0 {
        config.rig.command_offset_m = only(offset * 1e-3);
        said.push(format!(
            "the actuator stands at {offset:.4} mm for a command of 0: that is taken off the command"
        ));
    }
}

/// What the transducers say of it.
fn readings(causes: &Causes, config: &mut Config, said: &mut Vec<String>) {
    let (rig, gain) = (&mut config.rig, causes.displacement_gain);
    if gain != 1.0 {
        rig.displacement_gain = only(gain);
        said.push(format!(
            "the displacement reads {gain:.4} times what it is, as actuator and force say together: readings are divided \
             by that"
        ));
    }
    let offset = causes.displacement_offset_mm;
    if offset != 0.0 {
        rig.displacement_offset_m = only(offset * 1e-3);
        said.push(format!(
            "the displacement reads {offset:.4} mm too much, as actuator and force say together: that is taken off the \
             reading"
        ));
    }
    if causes.force_gain != 1.0 {
        rig.force_gain = only(causes.force_gain);
        said.push(format!(
            "forces are divided by {:.4}, as a load cell's; if the specimen is that much stiffer or softer, declare its \
             stiffness instead",
            causes.force_gain
        ));
    }
    if causes.force_offset_n != 0.0 {
        rig.force_offset_n = only(causes.force_offset_n);
        said.push(format!(
            "{:.2} N are taken off the force",
            causes.force_offset_n
        ));
    }
    let late_ms = causes.force_late_ms;
    if late_ms != 0.0 {
        rig.force_late_ms = only(late_ms);
        let (late, early) = if late_ms > 0.0 {
            ("force", "displacement")
        } else {
            ("displacement", "force")
        };
        said.push(format!(
            "the {late} is read {:.3} ms late: the {early} is held back as long, so that both are of one instant",
            late_ms.abs()
        ));
    }
}

/// Forces that the load cell feels and the structure does not have.
fn forces(causes: &Causes, config: &mut Config, said: &mut Vec<String>) {
    if causes.mass_kg != 0.0 {
        let floors = config.structure.mass_kg.len();
        let mut masses = config.structure.physical_mass_kg.clone();
        let _ = masses.resize(floors, 0.0);
        masses[0] = causes.mass_kg;
        config.structure.physical_mass_kg = masses;
        said.push(format!(
            "the inertia of {:.2} kg on the load cell counts as part of the structure's",
            causes.mass_kg
        ));
    }
    if let Some([force_n, mm]) = causes.friction {
        config.rig.bearing_friction_n = only(force_n);
        config.rig.bearing_presliding_m = only(mm * 1e-3);
        said.push(format!(
            "{force_n:.1} N of friction that builds up in {mm:.3} mm is taken out as the bearings'; if it is the \
             specimen's own, take it out of the model instead"
        ));
    }
}

/// Timing goes into the clamp and the predictors (as one delay) and into the filter's model of the actuator. What is later
/// than was expected is not only known but predicted: a damping that makes up for it makes up for its energy only.
fn timing(causes: &Causes, config: &mut Config, said: &mut Vec<String>) {
    let [delay_ms, lag_ms] = causes.late_ms;
    // A displacement that waits for its force is later by that.
    let delay_ms = delay_ms + causes.force_late_ms.max(0.0);
    let late_ms = delay_ms + lag_ms;
    if late_ms <= 0.0 {
        return;
    }
    let c = &mut config.compensation;
    let more_ms = late_ms - c.delay_ms;
    c.delay_ms = late_ms;
    config.estimation.delay_ms = delay_ms;
    config.estimation.lag_ms = lag_ms.max(LEAST_LAG_MS);
    said.push(format!(
        "the displacement is expected {late_ms:.2} ms late: {delay_ms:.2} ms of delay and {lag_ms:.2} ms of lag"
    ));
    if more_ms > WORTH_PREDICTING_MS && c.kind.predictor == Prediction::None {
        c.kind.predictor = Prediction::Afp;
        said.push(format!(
            "{more_ms:.2} ms of that are new: the command is sent ahead of them by the predictor afp"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::test::TestFile;
    use plant::EffectSpec;
    use std::path::Path;

    const TEST: &str = include_str!("../../../examples/table1.toml");

    fn table1() -> TestFile {
        TestFile::parse(TEST, "table1.toml", Path::new(""), &[]).unwrap()
    }

    #[test]
    fn what_a_test_declares_changes_nothing_of_its_loop() {
        let test = table1();
        let model = test.declared_model().unwrap();
        assert_eq!(
            model.actuator.as_ref().unwrap().delay_ms.unwrap().value,
            4.0
        );
        let mut config = test.config.clone();
        let said = apply(&model, &mut config);
        assert_eq!(said.len(), 1, "{said:?}");
        config.estimation = test.config.estimation.clone();
        assert_eq!(config, test.config);
    }

    #[test]
    fn each_finding_has_its_place_and_a_specimen_keeps_its_own() {
        let test = table1();
        let mut model = test.declared_model().unwrap();
        let specimen = model.specimen.as_mut().unwrap();
        specimen.mass_kg.as_mut().unwrap().value = 60.0;
        specimen.effects = vec![
            EffectSpec::new(Effect::GainError, &[("error", 0.06)]),
            EffectSpec::new(Effect::ChannelSkew, &[("skew_ms", 1.5)]),
            EffectSpec::new(
                Effect::CoulombFriction,
                &[("force_n", 300.0), ("presliding_mm", 0.2)],
            ),
            EffectSpec::new(Effect::QuadraticDamping, &[("damping_n_s2_per_mm2", 0.1)]),
        ];
        let actuator = model.actuator.as_mut().unwrap();
        actuator.gain.as_mut().unwrap().value = 1.05;
        actuator.effects = vec![EffectSpec::new(Effect::SecondLag, &[("lag_ms", 6.0)])];
        model.check().unwrap();
        let mut config = test.config.clone();
        let said = apply(&model, &mut config).join("\n");
        // A displacement that waits 1.5 ms for its force is as late again.
        assert!((config.compensation.delay_ms - 11.5).abs() < 1e-9);
        assert_eq!(config.compensation.kind.predictor, Prediction::Afp);
        assert_eq!(config.structure.physical_mass_kg.as_slice(), [60.0]);
        let rig = &config.rig;
        assert_eq!(rig.command_gain.as_slice(), [1.05]);
        assert_eq!(rig.force_gain.as_slice(), [1.06]);
        assert!((rig.force_late_ms[0] - 1.5).abs() < 1e-12);
        assert_eq!(rig.bearing_friction_n.as_slice(), [300.0]);
        assert!(
            said.contains("quadratic_damping is not taken out: what a specimen does"),
            "{said}"
        );
        config.check().unwrap();
    }
}
