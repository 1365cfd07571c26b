//! Grades an answer by the key.

use super::answer::{Answer, ChannelAnswer};
use exam::{ChannelKey, Hidden, Key};

/// A set of possible causes with more members than this says nothing.
const LARGEST_SET: usize = 5;

/// The mark of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Mark {
    /// Every name right and no other; or the set of those that no analysis of the record can distinguish; or correctly
    /// `none` or `unknown`.
    Exact,
    /// `ambiguous`, with the right name among at most five.
    Set,
    /// A name of the right family.
    Family,
    /// Only one of two.
    Part,
    /// `unknown` although a name could be found.
    Abstained,
    /// `none` although something is hidden, or not assessed.
    Missed,
    /// `unknown` although nothing is hidden.
    Alarm,
    /// Names an effect that is not in the record.
    Wrong,
}

impl Mark {
    /// True if the answer helps: exact, set or family.
    pub fn is_right(self) -> bool {
        matches!(self, Self::Exact | Self::Set | Self::Family)
    }

    /// All, from best to worst.
    pub const ALL: [Self; 8] = [
        Self::Exact,
        Self::Set,
        Self::Family,
        Self::Part,
        Self::Abstained,
        Self::Missed,
        Self::Alarm,
        Self::Wrong,
    ];
}

/// The mark of a record and of each of its channels.
#[derive(Clone, Copy, Debug)]
pub struct Grade {
    /// The mark of the whole record.
    pub mark: Mark,
    /// The marks of actuator and specimen.
    pub channels: [Mark; 2],
}

/// Marks an answer.
pub fn grade(key: &Key, answer: &Answer) -> Grade {
    let channels = key
        .channels
        .each_ref()
        .map(|k| channel(k, &answer.channel(k.channel.name())));
    let something =
        |i: usize| !key.channels[i].hidden.is_empty() || key.channels[i].outside.is_some();
    let worst = channels[0].max(channels[1]);
    let found =
        (0..2).any(|i| something(i) && (channels[i].is_right() || channels[i] == Mark::Part));
    let both = something(0) && something(1);
    let mark = match worst {
        Mark::Abstained | Mark::Missed if both && found => Mark::Part,
        worst => worst,
    };
    Grade { mark, channels }
}

fn channel(key: &ChannelKey, answer: &ChannelAnswer) -> Mark {
    let names_something = matches!(answer.verdict.as_str(), "effect" | "partial" | "ambiguous");
    if key.hidden.is_empty() {
        return match (names_something, answer.verdict.as_str()) {
            (true, _)
                if key
                    .echo
                    .is_some_and(|e| answer.named().iter().all(|n| *n == e)) =>
            {
                Mark::Exact
            }
            (true, _) => Mark::Wrong,
            (_, "unknown") if key.outside.is_some() => Mark::Exact,
            (_, "unknown") => Mark::Alarm,
            (_, "none") if key.outside.is_none() => Mark::Exact,
            _ => Mark::Missed,
        };
    }
    match answer.verdict.as_str() {
        "unknown" => Mark::Abstained,
        "effect" | "partial" | "ambiguous" => named(&key.hidden, answer),
        _ => Mark::Missed,
    }
}

/// The mark of an answer that names something, in a channel that hides something from the list.
fn named(hidden: &[Hidden], answer: &ChannelAnswer) -> Mark {
    let all = answer.named();
    let effects: Vec<&str> = answer.effects.iter().map(|e| e.name.as_str()).collect();
    let near = |name: &str, h: &Hidden| {
        name == h.name || h.same.contains(&name) || exam::effect::family(name) == Some(h.family)
    };
    let every_name_in_it = hidden.iter().all(|h| all.contains(&h.name));
    let stranger = effects.iter().any(|e| !hidden.iter().any(|h| near(e, h)));
    if answer.verdict == "ambiguous" {
        let inseparable = all
            .iter()
            .all(|n| hidden.iter().any(|h| *n == h.name || h.same.contains(n)));
        if every_name_in_it && inseparable {
            return Mark::Exact;
        }
        if every_name_in_it && all.len() <= LARGEST_SET {
            return Mark::Set;
        }
    }
    if stranger || effects.is_empty() {
        return Mark::Wrong;
    }
    let exactly = |h: &Hidden| effects.contains(&h.name);
    if answer.verdict == "effect" && effects.len() == hidden.len() && hidden.iter().all(exactly) {
        return Mark::Exact;
    }
    let covered = |h: &Hidden| effects.iter().any(|e| near(e, h));
    if hidden.iter().all(covered) {
        Mark::Family
    } else {
        Mark::Part
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exam::answer::Effect;
    use exam::{Channel, Equations};

    fn hidden(name: &'static str, same: &'static [&'static str]) -> Hidden {
        Hidden {
            name,
            family: exam::effect::family(name).unwrap(),
            equations: Equations::Matched,
            equation: "",
            size: 10.0,
            parameters: vec![],
            same,
        }
    }

    fn mark(
        hidden: Vec<Hidden>,
        outside: Option<&'static str>,
        verdict: &str,
        effects: &[&str],
        alternatives: &[&str],
    ) -> Mark {
        let key = ChannelKey {
            channel: Channel::Specimen,
            hidden,
            outside,
            echo: None,
            floor_rms: 1.0,
        };
        let answer = ChannelAnswer {
            verdict: verdict.into(),
            effects: effects
                .iter()
                .map(|n| Effect {
                    name: (*n).into(),
                    ..Default::default()
                })
                .collect(),
            alternatives: alternatives.iter().map(|n| (*n).into()).collect(),
            ..Default::default()
        };
        channel(&key, &answer)
    }

    #[test]
    fn one_effect() {
        let one = || vec![hidden("coulomb_friction", &[])];
        let m = |verdict, effects: &[&str], others: &[&str]| {
            mark(one(), None, verdict, effects, others)
        };
        assert_eq!(m("effect", &["coulomb_friction"], &[]), Mark::Exact);
        assert_eq!(m("effect", &["stribeck_friction"], &[]), Mark::Family);
        assert_eq!(m("effect", &["hardening"], &[]), Mark::Wrong);
        assert_eq!(
            m("effect", &["coulomb_friction", "drift"], &[]),
            Mark::Wrong
        );
        assert_eq!(
            m("ambiguous", &["backlash"], &["coulomb_friction"]),
            Mark::Set
        );
        assert_eq!(m("ambiguous", &["backlash"], &["drift"]), Mark::Wrong);
        assert_eq!(m("unknown", &[], &[]), Mark::Abstained);
        assert_eq!(m("none", &[], &[]), Mark::Missed);
        assert_eq!(m("not_assessed", &[], &[]), Mark::Missed);
        assert_eq!(m("effect", &[], &[]), Mark::Wrong);
    }

    #[test]
    fn a_list_of_everything_is_no_set() {
        let all: Vec<&str> = exam::effect::LIST.iter().map(|e| e.0).collect();
        let one = vec![hidden("coulomb_friction", &[])];
        assert_eq!(mark(one, None, "ambiguous", &["drift"], &all), Mark::Wrong);
    }

    #[test]
    fn inseparable_names_make_the_exact_set() {
        let one = || vec![hidden("gain_error", &["rig_compliance"])];
        let set = mark(
            one(),
            None,
            "ambiguous",
            &["rig_compliance"],
            &["gain_error"],
        );
        assert_eq!(set, Mark::Exact);
        let guess = mark(one(), None, "effect", &["rig_compliance"], &[]);
        assert_eq!(guess, Mark::Family);
    }

    #[test]
    fn two_effects() {
        let two = || vec![hidden("hardening", &[]), hidden("viscous_damping", &[])];
        let m = |effects: &[&str]| mark(two(), None, "effect", effects, &[]);
        assert_eq!(m(&["viscous_damping", "hardening"]), Mark::Exact);
        assert_eq!(m(&["maxwell_damper", "hardening"]), Mark::Family);
        assert_eq!(m(&["hardening"]), Mark::Part);
        assert_eq!(m(&["hardening", "drift"]), Mark::Wrong);
    }

    #[test]
    fn nothing_hidden_and_nothing_in_the_list() {
        let clean = |verdict, effects: &[&str]| mark(vec![], None, verdict, effects, &[]);
        assert_eq!(clean("none", &[]), Mark::Exact);
        assert_eq!(clean("unknown", &[]), Mark::Alarm);
        assert_eq!(clean("not_assessed", &[]), Mark::Missed);
        assert_eq!(clean("effect", &["drift"]), Mark::Wrong);
        let strange = |verdict, effects: &[&str]| mark(vec![], Some("?"), verdict, effects, &[]);
        assert_eq!(strange("unknown", &[]), Mark::Exact);
        assert_eq!(strange("none", &[]), Mark::Missed);
        assert_eq!(strange("ambiguous", &["drift"]), Mark::Wrong);
    }
}
