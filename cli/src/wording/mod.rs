//! A diagnosis in words, for the terminal and the report.

pub mod plan;

use diagnosis::{ChannelAnswer, DependsOn, FoundEffect, FoundParameter, Member, Verdict};
use experiment::numbers::percent;
use plant::{Channel, Effect};

/// The verdict in one sentence.
pub fn headline(a: &ChannelAnswer) -> String {
    let channel = a.channel.name();
    let found: Vec<&str> = a.effects.iter().map(|e| e.name.name()).collect();
    let found = found.join(" and ");
    match a.verdict {
        Verdict::None if a.ordinary => format!(
            "Nothing is missing in the {channel} model: an ordinary ram, which leaves {} of the motion beyond its delay and lag, rms.",
            percent(a.error_before.test_nrmse)
        ),
        Verdict::None => {
            format!("The {channel} model lacks nothing that shows above the noise.")
        }
        Verdict::Effect => format!("The {channel} model lacks {found}. {}", change(a)),
        Verdict::Ambiguous => {
            let is_open = |e: &&FoundEffect| a.members.iter().any(|m| m.name == e.name);
            let sure: Vec<&str> = (a.effects.iter().filter(|e| !is_open(e)))
                .map(|e| e.name.name())
                .collect();
            let open: Vec<&str> = a.members.iter().map(|m| m.name.name()).collect();
            let lacks = match (&sure[..], &open[..]) {
                ([], _) | (_, []) => {
                    let others = a.alternatives.iter().map(|e| e.name());
                    format!("{found}, or {}", others.collect::<Vec<_>>().join(" or "))
                }
                (sure, open) => format!("{}, and {}", sure.join(" and "), open.join(" or ")),
            };
            format!(
                "The {channel} model lacks {lacks}: this data cannot tell which. {}",
                change(a)
            )
        }
        Verdict::Partial => format!(
            "The {channel} model lacks {found}, and something beside it that has no name. {}",
            change(a)
        ),
        Verdict::Unknown => {
            let nearest = a.nearest.as_ref().filter(|n| n.explained >= 0.01);
            let nearest = nearest.map_or(String::new(), |n| {
                format!(
                    " The nearest is {}, which explains {:.0} % of its squares and cannot be vouched for; a saved model has it \
                     switched off.",
                    n.name.name(),
                    100.0 * n.explained,
                )
            });
            format!(
                "Something is missing in the {channel} model, and no effect of the library accounts for it.{nearest}"
            )
        }
        // The first note says why.
        Verdict::NotAssessed => match a.notes.first() {
            Some(why) => format!(
                "The {channel} was not assessed: {}.",
                why.trim_end_matches('.')
            ),
            None => format!("The {channel} was not assessed."),
        },
    }
}

/// Ratio of an error to the noise above which more is said to be missing.
const MORE: f64 = 1.5;
/// A share of the motion at the level of rounding, for a simulated record without noise.
const EXACT: f64 = 1e-9;
/// Ratio to the noise up to which nothing remains.
const NOTHING: f64 = 1.1;
/// Share of the squares from which on lines that are also present at rest are the main residual.
const DISTURBED: f64 = 0.1;

/// Frequencies of what oscillates both at rest and in motion, if it is most of the residual.
fn disturbed(a: &ChannelAnswer) -> Option<String> {
    let r = a.remainder.as_ref()?;
    let own: Vec<_> = r.lines.iter().filter(|l| l.at_rest).collect();
    let squares: f64 = own.iter().map(|l| l.rms * l.rms).sum();
    let all: Vec<String> = own
        .iter()
        .map(|l| format!("{} Hz", digits(l.frequency_hz)))
        .collect();
    (!own.is_empty() && squares >= DISTURBED * r.rms * r.rms).then(|| all.join(" and "))
}

/// How certain the names are, if the search gives it, and what may be true in the place of each.
pub fn sureness(a: &ChannelAnswer) -> Option<String> {
    let open = |e: &&FoundEffect| a.members.iter().any(|m| m.name == e.name);
    let sure = a.effects.iter().filter(|e| e.q.is_some() && !open(e));
    let sure: Vec<Member> = sure.filter_map(|e| Some(member((e.name, e.p?)))).collect();
    let said = match (&sure[..], &a.members[..]) {
        ([], []) => return None,
        ([one], []) => format!(
            "Of names given with this certainty or more at most {:.0} in 100 are false.",
            100.0 * (1.0 - one.probability)
        ),
        (sure, []) | ([], sure) => format!("Probabilities: {}.", each(sure)),
        (sure, open) => format!("Probabilities: {}; beside that {}.", each(sure), each(open)),
    };
    let rivals: Vec<String> = a.effects.iter().filter_map(rivals).collect();
    Some(said + &rivals.concat())
}

const fn member((name, probability): (Effect, f64)) -> Member {
    Member { name, probability }
}

/// Names with their probabilities.
fn each(members: &[Member]) -> String {
    let each = members.iter();
    let each = each.map(|m| format!("{} {:.0} %", m.name, 100.0 * m.probability));
    each.collect::<Vec<_>>().join(", ")
}

/// The names that may be true in place of a given one.
fn rivals(effect: &FoundEffect) -> Option<String> {
    let rivals = &effect.rivals[..];
    (!rivals.is_empty()).then(|| format!(" In the place of {}: {}.", effect.name, each(rivals)))
}

/// A multiple; without noise the exact number does not matter.
fn times(x: f64) -> String {
    if x > 1e3 {
        return "more than a thousand".into();
    }
    format!("{x:.1}")
}

/// What to do next, in one sentence; nothing if there was no verdict, since the notes give the reason.
pub fn next(a: &ChannelAnswer) -> Option<String> {
    let left = match a.error_after.test_nrmse < EXACT {
        true => 0.0,
        false => a.error_after.test_rms / a.noise_floor_rms.max(f64::MIN_POSITIVE),
    };
    let model = if a.effects.is_empty() {
        "nothing is added to the model"
    } else {
        "keep the improved model (--save-model)"
    };
    if let Some(disturbed) = disturbed(a) {
        return Some(format!(
            "Next: find what oscillates at {disturbed} while the rig is at rest, pumps and drives on and off one after the \
             other, stop it or filter it, and record again; it does not depend on the motion. Until then {model}."
        ));
    }
    if a.is_beyond_tests() {
        return Some(format!(
            "Next: look for what else acts on the rig, stop it or record it, and record again: no motion of this rig tells more of \
             what is left. Until then {model}."
        ));
    }
    Some(match a.verdict {
        Verdict::NotAssessed => return None,
        Verdict::None if left > MORE && !a.ordinary => format!(
            "Next: the training data needs no more than the declared model, but on the held-out data it is {} \
             times the noise off: look for what differs between the two, a zero that was set anew or another amplitude \
             or rate.",
            times(left)
        ),
        Verdict::None if a.refitted.iter().any(|r| r.tolerances().abs() > 1.0) => {
            "Next: nothing is missing, but a declared parameter is off by more than its tolerance: keep the refitted model \
             (--save-model) and take it into the next test (run --model)."
                .into()
        }
        Verdict::None if a.ordinary => {
            "Next: nothing; valve, oil and seals of any position loop leave as much.".into()
        }
        Verdict::None => "Next: nothing; this data gives no reason to change the model.".into(),
        Verdict::Ambiguous => "Next: let --next FILE design the test that tells these apart. Until then the improved model \
                               (--save-model) has the first of them, and is good for motions like those recorded."
            .into(),
        Verdict::Effect if left > MORE => format!(
            "Next: keep the improved model (--save-model) and diagnose again with it: what is left on the held-out data \
             is {} times the noise, so something smaller is missing too.",
            times(left)
        ),
        Verdict::Effect => {
            "Next: keep the improved model (--save-model) and take it into the next test (run --model).".into()
        }
        Verdict::Partial if left < NOTHING => {
            "Next: keep the improved model (--save-model); what it leaves on the held-out data is no more than the noise.".into()
        }
        Verdict::Partial => {
            "Next: keep the improved model (--save-model); let --next FILE design the test that tells most about what remains, \
             or vary one thing at a time, one amplitude at several rates and one rate at several amplitudes."
                .into()
        }
        Verdict::Unknown => {
            "Next: let --next FILE design the test that tells most, or vary one thing at a time, one amplitude at several rates \
             and one rate at several amplitudes, with two seconds of rest before and after; nothing is added to the model."
                .into()
        }
    })
}

/// A parameter that has moved by less than this share of its tolerance is as declared.
const MOVED: f64 = 0.05;

/// Refitted declared parameters, if some were free: those that moved, with how far, and those that did not.
pub fn refitted(a: &ChannelAnswer) -> Option<String> {
    let (moved, stay): (Vec<_>, Vec<_>) = a
        .refitted
        .iter()
        .partition(|r| r.tolerances().abs() > MOVED);
    let moved: Vec<String> = moved
        .iter()
        .map(|r| {
            let off = r.tolerances();
            format!(
                "{} = {} ({:.1} tolerances {} {}{})",
                r.name,
                digits(r.value),
                off.abs(),
                if off > 0.0 { "above" } else { "below" },
                digits(r.declared),
                match off.abs() {
                    off if off > BEYOND_THE_END => ", outside what was declared",
                    off if off > AT_THE_END => ", the end of what was declared",
                    _ => "",
                }
            )
        })
        .collect();
    let stay: Vec<String> = stay.iter().map(|r| r.name.clone()).collect();
    let parts = [("Refitted: ", moved), ("As declared: ", stay)];
    let parts = parts.iter().filter(|(_, all)| !all.is_empty());
    let said: Vec<String> = parts
        .map(|(how, all)| format!("{how}{}.", all.join(", ")))
        .collect();
    (!said.is_empty()).then(|| said.join(" "))
}

/// Tolerances from which on a parameter is at the limit that the declaration allows, or, free as a cause, outside it.
const AT_THE_END: f64 = 2.95;
const BEYOND_THE_END: f64 = 3.05;

/// Two errors that differ by more than this fraction are both given.
const ANOTHER: f64 = 0.01;

/// The change of the error on held-out data.
fn change(a: &ChannelAnswer) -> String {
    let (before, after) = (a.error_before.test_rms, a.error_after.test_rms);
    let declared = a.error_declared.test_rms;
    let refitted = if (declared / before - 1.0).abs() > ANOTHER {
        format!(
            " with the declared parameters refitted, {} as declared,",
            quantity(declared, &a.unit)
        )
    } else {
        String::new()
    };
    format!(
        "On held-out data the error falls from {}{refitted} to {} rms; the noise is {}.",
        quantity(before, &a.unit),
        quantity(after, &a.unit),
        quantity(a.noise_floor_rms, &a.unit)
    )
}

/// What the remaining error of a channel depends on, in words: position and velocity are those of its input.
pub const fn depends_on(d: DependsOn, channel: Channel) -> &'static str {
    match (d, channel) {
        (DependsOn::Displacement, Channel::Actuator) => "the command",
        (DependsOn::Displacement, Channel::Specimen) => "the displacement",
        (DependsOn::Velocity, Channel::Actuator) => "the speed of the command",
        (DependsOn::Velocity, Channel::Specimen) => "the velocity",
        (DependsOn::DisplacementAndVelocity, Channel::Actuator) => "the command and its speed",
        (DependsOn::DisplacementAndVelocity, Channel::Specimen) => {
            "displacement and velocity together"
        }
        (DependsOn::Memory, _) => "the motion since the last reversal",
        (DependsOn::Frequency, _) => "the frequency (a linear filter)",
        (DependsOn::Time, _) => "the time",
        (DependsOn::Amplitude, _) => "the amplitude",
        (DependsOn::OtherChannel, Channel::Actuator) => "the force",
        (DependsOn::OtherChannel, Channel::Specimen) => "the command",
    }
}

/// The effect of a correction without a name on the held-out error, in one sentence.
pub fn corrected(a: &ChannelAnswer) -> Option<String> {
    let with = a.error_with_remainder?;
    Some(format!(
        "Held out: {} rms refitted, {} with what has a name, {} with a correction for the residual, which has none.",
        quantity(a.error_before.test_rms, &a.unit),
        quantity(a.error_after.test_rms, &a.unit),
        quantity(with.test_rms, &a.unit)
    ))
}

/// The error that was predicted for the held-out data, in one sentence.
pub fn predicted(a: &ChannelAnswer) -> Option<String> {
    let [low, high] = a.next_error_ci90?;
    let reached = a.error_after.test_rms;
    let held = if (low..=high).contains(&reached) {
        "it is"
    } else {
        "it is outside, at"
    };
    Some(format!(
        "The training data and the held-out motion alone predict an error of {} to {} rms (90 %); {held} {}.",
        digits(low),
        quantity(high, &a.unit),
        quantity(reached, &a.unit)
    ))
}

/// What is known of the residual, in one sentence.
pub fn rest(a: &ChannelAnswer) -> Option<String> {
    let r = a.remainder.as_ref()?;
    let mut parts: Vec<String> = Vec::new();
    if let Some(s) = r.shares.first() {
        parts.push(format!(
            "{} {} {:.0} % of its squares on held-out data",
            depends_on(s.depends_on, a.channel),
            match s.depends_on {
                DependsOn::DisplacementAndVelocity => "account for",
                _ => "alone accounts for",
            },
            100.0 * s.share
        ));
    } else {
        parts.push(
            "no class of dependence accounts for more than 2 % of its squares on held-out data"
                .into(),
        );
    }
    for l in &r.lines {
        parts.push(format!(
            "a line at {} Hz holds {} rms{}",
            digits(l.frequency_hz),
            quantity(l.rms, &a.unit),
            if l.at_rest { ", in the rest, too" } else { "" }
        ));
    }
    Some(format!(
        "Of the residual, {} rms, {}.",
        quantity(r.rms, &a.unit),
        parts.join("; ")
    ))
}

/// The name of a verdict, as in files.
pub const fn verdict(v: Verdict) -> &'static str {
    match v {
        Verdict::None => "none",
        Verdict::Effect => "effect",
        Verdict::Ambiguous => "ambiguous",
        Verdict::Partial => "partial",
        Verdict::Unknown => "unknown",
        Verdict::NotAssessed => "not assessed",
    }
}

/// A 90 % interval that contains zero and is wider than this multiple of the value does not determine it.
const TOLD: f64 = 10.0;

/// A parameter with its 90 % interval.
pub fn parameter(p: &FoundParameter) -> String {
    let value = quantity(p.value, &p.unit);
    if p.ci90[0] == p.ci90[1] {
        return format!("{} = {value}", p.name);
    }
    let [low, high] = p.ci90;
    if low < 0.0 && high > 0.0 && high - low > TOLD * p.value.abs() {
        return format!("{} = {value}  (this record does not determine it)", p.name);
    }
    format!(
        "{} = {value}  (90 %: {} to {})",
        p.name,
        digits(p.ci90[0]),
        digits(p.ci90[1])
    )
}

/// A value with its unit, if it has one.
pub fn quantity(x: f64, unit: &str) -> String {
    match unit {
        _ if x.is_nan() => "-".into(),
        "" | "1" => digits(x),
        unit => format!("{} {unit}", digits(x)),
    }
}

/// Four significant digits; more for large numbers, which are not rounded before the decimal point.
pub fn digits(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    if x.abs() < 1e-6 {
        return format!("{x:.3e}");
    }
    let places = (3 - x.abs().log10().floor() as i32).clamp(0, 12) as usize;
    format!("{x:.places$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use diagnosis::{Declared, Model, Recording, SpecimenModel};

    /// A declared spring of 100 N/mm with an additional `force`, at rest for two seconds.
    fn answer(force: impl Fn(f64, f64) -> f64) -> ChannelAnswer {
        let record = |name: &str, hz: f64| {
            let time_s: Vec<f64> = (0..12_000).map(|i| f64::from(i) * 1e-3).collect();
            let moves = |t: f64| (std::f64::consts::TAU * hz * (t - 2.0).max(0.0)).sin() * 5.0;
            let noise = |i: usize| 0.5 * (((i * 7919) % 1009) as f64 / 504.5 - 1.0);
            let x: Vec<f64> = time_s.iter().map(|t| moves(*t)).collect();
            let speed = |t: f64| (moves(t + 1e-4) - moves(t - 1e-4)) / 2e-4;
            let reads =
                |(i, t): (usize, &f64)| 100.0 * moves(*t) + force(moves(*t), speed(*t)) + noise(i);
            Recording {
                name: name.into(),
                force_n: Some(time_s.iter().enumerate().map(reads).collect()),
                displacement_mm: Some(x),
                time_s,
                command_mm: None,
                ..Recording::default()
            }
        };
        let stiffness = Declared {
            value: 100.0,
            tolerance: 0.5,
        };
        let model = Model {
            actuator: None,
            specimen: Some(SpecimenModel {
                stiffness_n_per_mm: Some(stiffness),
                ..SpecimenModel::default()
            }),
            ..Model::default()
        };
        let d = diagnosis::diagnose(&model, &[record("a", 0.9)], &[record("b", 1.3)], &[]).unwrap();
        d.channels[0].clone()
    }

    #[test]
    fn what_is_next_depends_on_what_was_found() {
        let nothing = answer(|_, _| 0.0);
        assert_eq!(nothing.verdict, Verdict::None);
        assert!(next(&nothing).unwrap().contains("no reason to change"));
        assert!(refitted(&nothing).unwrap().contains("stiffness_n_per_mm"));

        // A simulated record has no noise: a rounding error counts as nothing, and nobody reads 300 digits.
        let mut exact = nothing.clone();
        exact.noise_floor_rms = 0.0;
        (exact.error_after.test_rms, exact.error_after.test_nrmse) = (1e-14, 1e-16);
        assert!(!next(&exact).unwrap().contains("times the noise"));
        (exact.error_after.test_rms, exact.error_after.test_nrmse) = (1.0, 0.1);
        assert!(next(&exact).unwrap().contains("more than a thousand times"));

        let cubic = answer(|x, _| 0.4 * x * x * x);
        assert!(!cubic.effects.is_empty(), "{cubic:?}");
        assert!(next(&cubic).unwrap().contains("--save-model"));

        // Neither a spring nor a damper: no effect of the list has a force of this sign.
        let odd = answer(|x, v| 8.0 * (3.0 * x).sin() * (0.7 * v).cos());
        assert_eq!(odd.verdict, Verdict::Unknown, "{odd:?}");
        let said = next(&odd).unwrap();
        assert!(said.contains("--next FILE") && said.contains("nothing is added"));
        let mut disturbed = odd.clone();
        disturbed.disturbed = true;
        let said = next(&disturbed).unwrap();
        assert!(
            !said.contains("--next") && said.contains("nothing is added"),
            "{said}"
        );
    }

    #[test]
    fn each_name_has_its_certainty_and_its_rivals_behind_it() {
        let mut a = answer(|_, _| 0.0);
        assert_eq!(sureness(&a), None);
        let given = |(name, p): (Effect, f64)| FoundEffect {
            q: Some(1.0 - p),
            p: Some(p),
            name,
            family: name.entry().family,
            parameters: Vec::new(),
            rivals: Vec::new(),
        };
        a.effects = vec![given((Effect::CoulombFriction, 0.96))];
        let said = sureness(&a).unwrap();
        assert!(said.ends_with("at most 4 in 100 are false."), "{said}");
        a.effects.push(given((Effect::Backlash, 0.8)));
        a.effects[1].rivals = vec![member((Effect::DeadBand, 0.15))];
        let two = "Probabilities: coulomb_friction 96 %, backlash 80 %";
        let rival = " In the place of backlash: dead_band 15 %.";
        assert_eq!(sureness(&a).unwrap(), format!("{two}.{rival}"));
        a.members = vec![member((Effect::Drift, 0.6)), member((Effect::Offset, 0.3))];
        let beside = "; beside that drift 60 %, offset 30 %.";
        assert_eq!(sureness(&a).unwrap(), format!("{two}{beside}{rival}"));
        a.verdict = Verdict::Ambiguous;
        let lacks = "lacks coulomb_friction and backlash, and drift or offset: this data";
        assert!(headline(&a).contains(lacks), "{}", headline(&a));
        a.effects.clear();
        assert_eq!(
            sureness(&a).unwrap(),
            "Probabilities: drift 60 %, offset 30 %."
        );
    }

    #[test]
    fn a_sound_ram_is_said_to_be_ordinary_and_nothing_is_advised() {
        let mut sound = answer(|_, _| 0.0);
        (sound.channel, sound.ordinary) = (Channel::Actuator, true);
        sound.error_before.test_nrmse = 0.003;
        sound.error_after.test_rms = 9.0 * sound.noise_floor_rms;
        assert_eq!(
            headline(&sound),
            "Nothing is missing in the actuator model: an ordinary ram, which leaves 0.300 % of the motion beyond its delay and lag, rms."
        );
        assert!(next(&sound).unwrap().starts_with("Next: nothing;"));
    }

    #[test]
    fn what_a_rest_depends_on_is_called_by_its_name() {
        assert_eq!(
            depends_on(DependsOn::OtherChannel, Channel::Actuator),
            "the force"
        );
        assert_eq!(
            depends_on(DependsOn::Displacement, Channel::Actuator),
            "the command"
        );
        assert_eq!(
            depends_on(DependsOn::OtherChannel, Channel::Specimen),
            "the command"
        );
    }

    #[test]
    fn an_interval_that_tells_nothing_is_not_written_out() {
        let give = |ci90| FoundParameter {
            name: "presliding_mm".into(),
            value: 0.18,
            unit: "mm".into(),
            ci90,
        };
        let said = [[-9.9, 10.2], [-0.1, 0.5], [0.1, 0.26]].map(|ci90| parameter(&give(ci90)));
        assert!(
            said[0].ends_with("(this record does not determine it)"),
            "{}",
            said[0]
        );
        assert!(said[1].contains("90 %: -0.1000 to 0.5000"), "{}", said[1]);
        assert!(said[2].contains("90 %: 0.1000 to 0.2600"), "{}", said[2]);
    }

    #[test]
    fn numbers_have_four_digits() {
        for (x, text) in [
            (0.0, "0"),
            (0.012_345, "0.01235"),
            (-1.0, "-1.000"),
            (56.121_5, "56.12"),
            (123_456.7, "123457"),
            (4.874e-9, "4.874e-9"),
        ] {
            assert_eq!(digits(x), text);
        }
    }
}
