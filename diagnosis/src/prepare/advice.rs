//! Wording of notes, and of the experiment that would decide.

use crate::criteria::REACH;
use crate::model::answer::{ChannelAnswer, FoundEffect, Refitted, Verdict};
use crate::model::base::Base;
use crate::numbers::signals::{difference, mean};
use plant::{Channel, Effect, Family};

/// The free declared parameters, as refitted.
pub fn refitted(base: &Base, theta: &[f64; 4]) -> Vec<Refitted> {
    let parameters = base.channel.parameters();
    base.free
        .iter()
        .map(|f| Refitted {
            name: parameters[f.index].name.to_owned(),
            value: theta[f.index],
            declared: base.values[f.index],
            tolerance: f.tolerance,
            ci90: [f64::NAN; 2],
        })
        .collect()
}

/// Fraction of the held-out squares above which their mean makes up most of the residual.
const MOSTLY_ZERO: f64 = 0.7;
/// Smallest residual for which that is reported, in noise rms.
const LOUD: f64 = 2.0;

/// Note if the held-out residual is mostly a constant, and the training residual is not.
pub fn another_zero(answer: &ChannelAnswer) -> Option<String> {
    let t = &answer.traces;
    let left = answer.error_after;
    let mean = mean(&difference(&t.measured, &t.after));
    let squares = left.test_rms * left.test_rms;
    let trained = left.train_nrmse * left.test_rms / left.test_nrmse.max(f64::MIN_POSITIVE);
    let is_new = trained < 0.5 * left.test_rms;
    (squares > 0.0
        && mean * mean > MOSTLY_ZERO * squares
        && left.test_rms > LOUD * answer.noise_floor_rms
        && is_new)
        .then(|| {
            format!(
                "Of what is left of the held-out data, {} {unit} rms, most is a constant {} {unit}, which the training \
                 data do not have: a zero was set anew between them, or it has drifted. Without it {} {unit} rms is left.",
                four(left.test_rms),
                four(mean),
                four((squares - mean * mean).max(0.0).sqrt()),
                unit = answer.unit
            )
        })
}

/// Formats with four digits.
pub fn four(x: f64) -> String {
    let places = if x == 0.0 || !x.is_finite() {
        0
    } else {
        (3 - x.abs().log10().floor() as i32).clamp(0, 9) as usize
    };
    format!("{x:.places$}")
}

/// For a name that is the error of a declared parameter: says whether the refitted parameter already contains it, as in
/// the engine's answers, or whether it acts on the refitted value.
pub fn one_change(answer: &ChannelAnswer, held: bool) -> Vec<String> {
    let channel = answer.channel;
    let of = |e: &FoundEffect| {
        let parameter = &channel.parameters()[channel.parameter_of_error(e.name)?];
        let named = |r: &&Refitted| r.name == parameter.name;
        let r = answer.refitted.iter().find(named)?;
        let (name, effect) = (parameter.name, e.name);
        if held {
            return (r.tolerances().abs() > REACH).then(|| {
                format!(
                    "The {effect} is the change of {name} from {} to {}, which the refitted parameter holds: one change, not two.",
                    four(r.declared),
                    four(r.value)
                )
            });
        }
        let error = e.parameters.first()?.value;
        // A load cell's gain is an addition to the stiffness.
        if channel == Channel::Specimen && effect == Effect::GainError {
            return Some(format!(
                "The {effect} acts on the force of the refitted {name}: together {}.",
                four(parameter.with_error(r.value, error))
            ));
        }
        Some(format!(
            "The {effect} comes on top of the refitted {name} of {}: the improved model has {}.",
            four(r.value),
            four(parameter.with_error(r.value, error))
        ))
    };
    answer.effects.iter().filter_map(of).collect()
}

/// Notes on the engine's result. `verdict`: the answer's if the motion could tell all names apart.
pub fn engine(answer: &ChannelAnswer, verdict: Verdict) -> Vec<String> {
    let (before, after) = (answer.error_before.test_rms, answer.error_after.test_rms);
    let unit = &answer.unit;
    let said = match verdict {
        Verdict::None => format!(
            "No law of the table and no parameter outside its tolerance is worth its price: what is left is {before:.4} {unit} rms."
        ),
        Verdict::Unknown => format!(
            "What the declared model leaves ({before:.4} {unit} rms) has no name that is probable enough; the model is left as \
             it was."
        ),
        _ => {
            let names: Vec<&str> = answer.effects.iter().map(|e| e.name.name()).collect();
            format!(
                "The {} model lacks {}: with it the held-out error falls from {before:.4} to {after:.4} {unit} rms.",
                answer.channel.name(),
                names.join(" and ")
            )
        }
    };
    let mut notes = vec![said];
    if verdict == Verdict::Ambiguous
        && let Some(first) = answer.effects.first()
    {
        notes.push(
            "These data do not tell which member of the set it is. The model has the first.".into(),
        );
        notes.push(experiment(first.name).to_owned());
    }
    notes.extend(shared_stiffness(answer));
    notes.extend(one_change(answer, true));
    notes
}

/// For a spring far from its declared value because an element that yields acts with it: their joint stiffness.
fn shared_stiffness(answer: &ChannelAnswer) -> Option<String> {
    let spring = answer.refitted.iter().find(|r| r.name == STIFFNESS)?;
    if (spring.value - spring.declared).abs() <= REACH * spring.tolerance {
        return None;
    }
    let has = |e: &&FoundEffect| e.family == Family::Hysteresis;
    let effect = answer.effects.iter().find(has)?;
    let own = effect.value(STIFFNESS)?;
    Some(format!(
        "Of the declared {:.1} N/mm the model keeps {:.1} N/mm as a spring and has {:.1} N/mm in {}, which gives way: together \
         {:.1} N/mm for small motions.",
        spring.declared,
        spring.value,
        own,
        effect.name,
        spring.value + own
    ))
}

/// Name of a declared parameter.
const STIFFNESS: &str = "stiffness_n_per_mm";

/// The next measurement that would tell an effect from those that look like it.
fn experiment(effect: Effect) -> &'static str {
    match effect.entry().family {
        Family::Timing => {
            "To tell a delay from a lag, a second lag or the oil column, excite higher frequencies: a chirp to 1 / (10 T) \
             of the shortest time constant; to tell channel skew from viscous damping, use a specimen of another stiffness."
        }
        Family::Damping => {
            "To tell viscous damping from channel skew, repeat with a specimen of another stiffness; to tell kinds of \
             damping apart, use two rates and two amplitudes."
        }
        Family::Friction | Family::Hysteresis | Family::Gap => {
            "To tell friction, hysteresis and lost motion apart, repeat with two amplitudes and two rates, with reversals \
             at rest."
        }
        Family::Calibration | Family::Stiffness => {
            "To tell a gain error from the rig's compliance and from a stiffness that depends on amplitude, sweep the \
             amplitude, or read a second displacement sensor."
        }
        Family::Slow => {
            "To tell offset, drift and temperature apart, record longer, with pauses at rest."
        }
        Family::Limit => {
            "To tell a limit from softening, look for samples that pile up at one value, and go further."
        }
        Family::Asymmetry => {
            "To tell asymmetry from drift, take frequencies in random order and a rest afterwards."
        }
        Family::Inertia => {
            "To tell inertia from stiffness, move the rig without the specimen, or at higher frequency."
        }
        Family::Interference => {
            "To find interference, record at rest with pumps and drives on and off."
        }
    }
}
