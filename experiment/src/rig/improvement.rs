//! Applies what a diagnosis found about a rig to the next test.

use super::{Departures, Quantity, ROWS};
use diagnosis::Model;
use outerloop_core::Config;
use outerloop_core::Prediction;
use outerloop_core::config::PerActuator;
use plant::{Channel, Effect};

/// Unexpected delay, ms, from which prediction is worthwhile.
const WORTH_PREDICTING_MS: f64 = 0.25;

/// The filter's model always has a lag; the shortest accepted one is practically none.
pub(super) const LEAST_LAG_MS: f64 = 0.05;

/// Applies what `model` knows to `config`, and reports in sentences what was done with each part of it.
pub fn apply(model: &Model, config: &mut Config) -> Vec<String> {
    let known = Departures::of_model(model, config.compensation.delay_ms.at(0));
    let mut said = space(&known, config);
    timing(&known, config, &mut said);
    for (channel, effect) in known.not_correctable() {
        let at_rest_alone =
            effect == Effect::StribeckFriction && known[Quantity::BearingFriction] == 0.0;
        let why = if at_rest_alone {
            "what was found of it is there at rest alone, and no force that slides"
        } else {
            why_not(channel, effect)
        };
        said.push(format!("{effect} is not taken out: {why}"));
    }
    for &channel in Channel::ALL {
        let corrected = model.channel(channel).and_then(|own| own.remainder);
        if corrected.is_some() {
            said.push(format!(
                "the correction without a name of the {channel} is not taken out: nobody knows what it is of"
            ));
        }
    }
    said
}

/// The note on a loop that waits for its force: none of the test file's own timing is changed for that, whereas a model
/// given to a test (`run --model`) expects it and sends the command ahead.
pub fn remark_on_lateness(config: &Config) -> Option<String> {
    let late_ms = config
        .rig
        .force_late_ms
        .iter()
        .fold(0.0_f64, |m, ms| m.max(*ms));
    let compensated = config.compensation.kind;
    if late_ms <= WORTH_PREDICTING_MS || compensated.predictor != Prediction::None {
        return None;
    }
    Some(format!(
        "The displacement waits {late_ms:.2} ms for its force (rig.force_late_ms, or channel_skew in [declared]), and the loop is later by \
         as much: compensation.delay_ms = {} has to have that in it, and {compensated} does not predict. With {compensated}+afp the \
         command is sent ahead, as run --model does.",
        config.compensation.delay_ms
    ))
}

/// The same without the timing, which a test file may state differently.
pub fn correct(model: &Model, config: &mut Config) {
    let known = Departures::of_model(model, config.compensation.delay_ms.at(0));
    space(&known, config);
}

/// What to do about an effect that remains.
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
        // With a force that it slides at, it would be taken out.
        (Channel::Specimen, Effect::CoulombFriction, _) => {
            "the loop takes out a friction that slides at one force, and what was found does not"
        }
        (Channel::Specimen, _, Hysteresis | Damping | Stiffness | Asymmetry) => {
            "what a specimen does is what the test is made to find out, so it belongs into the result"
        }
        (_, _, Slow) => "let the rig warm up, and zero the channel before each test",
        (_, _, Gap) => "it is in the rig's mechanics, and only a repair takes it away",
        (_, _, Limit) => {
            "it is in the rig's mechanics, and only a repair or a smaller motion takes it away"
        }
        (_, _, Interference) => "find its source; a filter would delay the measurement",
        _ => "the loop has no correction for it",
    }
}

fn only(x: f64) -> PerActuator {
    [x].into_iter().collect()
}

/// Everything except the actuator's timing, in sentences.
fn space(known: &Departures, config: &mut Config) -> Vec<String> {
    let mut said = Vec::new();
    for (quantity, row) in ROWS {
        let value = known[*quantity];
        if let Some((per_unit, setting, in_words)) = row.correction
            && value != row.ideal
        {
            *setting(&mut config.rig) = only(value * per_unit);
            said.push(in_words(value));
        }
    }
    let mass_kg = known[Quantity::Mass];
    if mass_kg != 0.0 {
        let floors = config.structure.mass_kg.len();
        let masses = &mut config.structure.physical_mass_kg;
        let _ = masses.resize(floors, 0.0);
        masses[0] = mass_kg;
        said.push(format!(
            "the inertia of {mass_kg:.2} kg on the load cell counts as part of the structure's"
        ));
    }
    said
}

/// Timing goes into the clamp and the predictors (as one delay) and into the filter's model of the actuator. Additional
/// delay is not only known but predicted: a damping that compensates for it only compensates for its energy.
fn timing(known: &Departures, config: &mut Config, said: &mut Vec<String>) {
    let [delay_ms, lag_ms] = known.to_expect_ms();
    let late_ms = delay_ms + lag_ms;
    if late_ms <= 0.0 {
        return;
    }
    let c = &mut config.compensation;
    let more_ms = late_ms - c.delay_ms.at(0);
    c.delay_ms = late_ms.into();
    config.estimation.delay_ms = delay_ms.into();
    config.estimation.lag_ms = lag_ms.max(LEAST_LAG_MS).into();
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
        // A displacement that waits 1.5 ms for its force is late by that much more.
        assert!((config.compensation.delay_ms.at(0) - 11.5).abs() < 1e-9);
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
