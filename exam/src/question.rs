//! What to hide in a case.

use crate::class::Class;
use crate::draws::Draws;
use crate::effect::{self, Channel, Equations, LIST, Physics, Scale, family};
use crate::lab::Undeclared;
use crate::outside;

/// One thing to hide.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Question {
    /// An effect of the list.
    Effect(&'static str, Channel, Equations),
    /// A force that is ahead of its displacement.
    EarlyForce,
    /// One of the kinds outside the list.
    Outside(usize),
}

impl Question {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Effect(name, ..) => name,
            Self::EarlyForce => "channel_skew",
            Self::Outside(_) => "",
        }
    }

    pub(crate) fn channel(self) -> Channel {
        match self {
            Self::Effect(_, channel, _) => channel,
            Self::EarlyForce => Channel::Specimen,
            Self::Outside(kind) => outside::KINDS[kind].1,
        }
    }

    pub(crate) fn equations(self) -> Equations {
        match self {
            Self::Effect(_, _, equations) => equations,
            Self::EarlyForce => Equations::Matched,
            Self::Outside(_) => Equations::Unseen,
        }
    }

    /// None if the list has no such effect in the channel.
    pub(crate) fn draw(self, scale: &Scale, rng: &mut Draws) -> Option<Physics> {
        match self {
            Self::Effect(name, channel, equations) => {
                effect::draw(name, channel, equations, scale, rng)
            }
            Self::EarlyForce => Some(effect::early_force()),
            Self::Outside(kind) => Some(outside::draw(kind, scale, rng)),
        }
    }
}

/// What the declared model of such a case must leave out.
pub(crate) fn undeclared(questions: &[Question]) -> Undeclared {
    let asks = |name, channel| {
        questions
            .iter()
            .any(|q| q.name() == name && q.channel() == channel)
    };
    // The frame of `y / (1 + k / k_frame)` yields only to a spring.
    let compliant = asks("rig_compliance", Channel::Actuator);
    let early = questions.iter().any(|q| matches!(q, Question::EarlyForce));
    Undeclared {
        offset_mm: asks("offset", Channel::Actuator),
        offset_n: asks("offset", Channel::Specimen),
        damping: early || compliant || asks("viscous_damping", Channel::Specimen),
        mass: compliant || asks("inertia_force", Channel::Specimen),
    }
}

/// What a case of this class and seed hides; the effects take turns.
pub(crate) fn questions(class: Class, seed: u64, rng: &mut Draws) -> Vec<Question> {
    let turn = |n: usize| (seed % n as u64) as usize;
    let one = |equations| {
        let (name, _, channel) = LIST[turn(LIST.len())];
        vec![Question::Effect(name, channel, equations)]
    };
    match class {
        Class::Matched => one(Equations::Matched),
        Class::Unseen => one(Equations::Unseen),
        Class::Clean => Vec::new(),
        Class::Outside => vec![Question::Outside(turn(outside::KINDS.len()))],
        Class::Two => two(seed, rng),
        Class::Confounded => vec![confounded(seed, rng)],
    }
}

/// Two effects of different families: every third pair in two channels, every second pair by unseen equations.
fn two(seed: u64, rng: &mut Draws) -> Vec<Question> {
    let equations = if seed.is_multiple_of(2) {
        Equations::Matched
    } else {
        Equations::Unseen
    };
    let apart = seed.is_multiple_of(3);
    loop {
        let (a, b) = (rng.pick(LIST), rng.pick(LIST));
        // A coarse converter would hide the rest; an offset and a drift would be the same thing twice.
        let coarse = [a.0, b.0].contains(&"quantisation");
        let slow = ["calibration", "slow"];
        let blurred = slow.contains(&a.1) && slow.contains(&b.1);
        // The frame of `y / (1 + k / k_frame)` yields to a declared spring and to no other force.
        let compliant = [a, b]
            .iter()
            .any(|e| e.0 == "rig_compliance" && e.2 == Channel::Actuator);
        let unframed = apart && compliant;
        // A valve is one equation: two changes of it do not add up.
        let unseen = equations == Equations::Unseen;
        let in_valve = |name| unseen && VALVE.contains(&name);
        let one_valve = in_valve(a.0) && in_valve(b.0);
        let confused = coarse || blurred || unframed || one_valve;
        if a.1 != b.1 && (a.2 != b.2) == apart && !confused {
            let mut both = [a, b];
            both.sort_by_key(|e| if in_valve(e.0) { 0 } else { stage(e.0, e.2) });
            return both
                .map(|(name, _, channel)| Question::Effect(name, channel, equations))
                .to_vec();
        }
    }
}

/// Effects that the exam writes as a change of the valve's equation where their own equation is not the textbook's.
const VALVE: [&str; 3] = ["lag_error", "rate_limit", "asymmetric_actuator"];

/// The place of an effect in its channel, from what drives to what reads: a valve and its oil move a drive with lost motion up to
/// its stops; the forces of a specimen pass a load cell, whose range ends.
fn stage(name: &str, channel: Channel) -> u8 {
    match (channel, name) {
        (Channel::Actuator, "lag_error") => 0,
        (Channel::Actuator, "delay_error" | "second_lag" | "oil_column" | "rate_limit") => 1,
        (
            Channel::Specimen,
            "channel_skew" | "gain_error" | "rig_compliance" | "temperature_gain",
        ) => 3,
        (_, "saturation") => 4,
        _ => 2,
    }
}

fn confounded(seed: u64, rng: &mut Draws) -> Question {
    use Channel::{Actuator, Specimen};
    let matched = |name, channel| Question::Effect(name, channel, Equations::Matched);
    match seed % 4 {
        // At low frequency a late actuator is just late, whatever the reason.
        0 => matched(
            rng.pick(&["delay_error", "lag_error", "second_lag"]),
            Actuator,
        ),
        // F(t + d) = F + k d v on one spring.
        1 if rng.chance(0.5) => Question::EarlyForce,
        1 => matched("viscous_damping", Specimen),
        // A share of the force is lost either way.
        2 => matched(rng.pick(&["gain_error", "rig_compliance"]), Specimen),
        // Their loops look alike at one amplitude and one rate.
        _ => matched(
            rng.pick(&["coulomb_friction", "stribeck_friction", "backlash"]),
            Specimen,
        ),
    }
}

/// Whether the record must be so slow that the members of the set cannot be told apart.
pub(crate) fn slow_only(class: Class, questions: &[Question]) -> bool {
    class == Class::Confounded
        && questions
            .iter()
            .any(|q| q.channel() == Channel::Actuator && family(q.name()) == Some("timing"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_gets_its_turn_and_pairs_are_of_two_families() {
        let mut rng = Draws::new(5);
        let mut seen = std::collections::BTreeSet::new();
        for seed in 0..LIST.len() as u64 {
            let q = questions(Class::Unseen, seed, &mut rng)[0];
            seen.insert((q.name(), q.channel()));
            let pair = questions(Class::Two, seed, &mut rng);
            assert_ne!(family(pair[0].name()), family(pair[1].name()));
        }
        assert_eq!(seen.len(), LIST.len());
    }
}
