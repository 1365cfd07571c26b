//! The decision on a channel, made once: training data propose, held-out data confirm, names that the motion cannot tell apart are
//! given together, and at its rail an output has no names but a limit. What follows describes; no verdict and no name changes.
//!
//! A record is decided on anew if mains hum or corners of the motion are what an answer leaves (`hum`, `corners`), each time
//! from the search on.

use crate::engine::{Named, Said};
use crate::model::answer::{FoundEffect, Line, Member, Verdict};
use crate::prepare::input::{Deficiency, share};
use plant::Effect;

/// What is given for a channel.
#[derive(Debug)]
pub struct Decision {
    /// The verdict if the motion could tell all names apart.
    pub found: Verdict,
    /// The verdict.
    pub verdict: Verdict,
    /// The names that the model has, in a set the likeliest.
    pub effects: Vec<FoundEffect>,
    /// Names that may be in the rig in addition or instead.
    pub alternatives: Vec<Effect>,
    /// The members of a set with their probabilities.
    pub members: Vec<Member>,
    /// Why it is not `none` although the training data have nothing.
    pub forbids_none: Option<Forbids>,
    /// Why there is no verdict although there are names.
    pub forbids_names: Option<String>,
    /// Why the motion cannot tell names apart.
    pub lacks: Vec<String>,
}

/// Why `none` cannot be said.
#[derive(Debug)]
pub struct Forbids {
    /// The reason.
    pub reason: String,
    /// Lines that the motion does not have, if it is these.
    pub lines: Vec<Line>,
    /// What they leave of the noise's squares.
    pub noise_share: f64,
}

/// A model that held-out data confirm.
#[derive(Debug)]
pub struct Confirmed {
    /// It accounts for the training data: it leaves a small part of the residual, or noise.
    pub accounts: bool,
    /// The credible fraction of its names' probabilities.
    pub trust: f64,
    /// Its effects with their parameters.
    pub effects: Vec<FoundEffect>,
}

/// What is known beside a model of the training data.
pub struct Beside<'a> {
    /// The converter's steps, if the training data have nothing else.
    pub steps: Option<FoundEffect>,
    /// Why it is not `none` if the training data have nothing.
    pub forbids_none: Option<Forbids>,
    /// Why there is no verdict if the names are not those of a limit: the output sits at its rail.
    pub rail: &'a dyn Fn() -> Option<String>,
    /// Hum in the reading, which was taken off, or what an actuator's loop swings by itself.
    pub swing: Option<FoundEffect>,
    /// What a motion lacks to tell names from others.
    pub lacks: &'a dyn Fn(&[FoundEffect]) -> Vec<Deficiency>,
}

/// What the training data propose; `None` if nothing is missing. `ordinary`: what is left is what any sound device, or a good
/// transducer, leaves.
pub fn proposed<F>(said: &Said<F>, ordinary: bool) -> Option<&Said<F>> {
    let missing = !matches!(said, Said::Nothing) && !ordinary;
    missing.then_some(said)
}

/// The decision on what is proposed, with its model if held-out data confirm it.
pub fn decide<F>(proposed: Option<&Said<F>>, model: Option<Confirmed>, beside: Beside) -> Decision {
    let laws = match (proposed, model) {
        (Some(Said::Names(named)), Some(model)) => names(named, model),
        (Some(Said::Set(_, set)), Some(model)) => one_of(set, model.effects),
        (Some(_), _) => Decision::of(Verdict::Unknown, Vec::new()),
        (None, _) => nothing(beside.steps, beside.forbids_none),
    };
    let mut decision = laws.with_swing(beside.swing).unless(beside.rail);
    for lack in (beside.lacks)(&decision.effects) {
        decision.widen(lack);
    }
    for effect in &mut decision.effects {
        let member = decision.members.iter().find(|m| m.name == effect.name);
        effect.p = Some(member.map_or(effect.alone(), |m| m.probability));
    }
    decision
}

impl Decision {
    fn of(found: Verdict, effects: Vec<FoundEffect>) -> Self {
        Self {
            found,
            verdict: found,
            effects,
            alternatives: Vec::new(),
            members: Vec::new(),
            forbids_none: None,
            forbids_names: None,
            lacks: Vec::new(),
        }
    }

    /// With what swings beside the laws: there is something to name, and of what has no name a part.
    fn with_swing(mut self, swing: Option<FoundEffect>) -> Self {
        let Some(swing) = swing else {
            return self;
        };
        self.effects.insert(0, swing);
        self.found = match self.found {
            Verdict::None => Verdict::Effect,
            Verdict::Unknown => Verdict::Partial,
            named => named,
        };
        self.verdict = self.found;
        self
    }

    /// No verdict if the output sits at its rail and the names are not those of a limit.
    fn unless(self, rail: &dyn Fn() -> Option<String>) -> Self {
        let is_limit = |e: &FoundEffect| e.name == Effect::Saturation;
        let named = !self.effects.is_empty() && !self.effects.iter().any(is_limit);
        match named.then(rail).flatten() {
            None => self,
            why => Self {
                forbids_names: why,
                ..Self::of(Verdict::NotAssessed, Vec::new())
            },
        }
    }

    /// With the names that a motion cannot tell from those given, if any: then all of them are a set.
    fn widen(&mut self, lack: Deficiency) {
        let own = self.effects.iter().map(|e| e.name);
        let named: Vec<Effect> = own.chain(self.members.iter().map(|m| m.name)).collect();
        let alike = |group: &&Vec<Effect>| named.iter().any(|n| group.contains(n));
        let Some(group) = lack.alike.iter().find(alike) else {
            return;
        };
        self.lacks.push(lack.sentence);
        let is_member = |e: &&FoundEffect| self.members.iter().any(|m| m.name == e.name);
        let sure = self.effects.iter().filter(|e| !is_member(e));
        let sure = sure.map(|e| Member {
            name: e.name,
            probability: e.alone(),
        });
        let mut all: Vec<Member> = sure.chain(self.members.iter().copied()).collect();
        share(&mut all, group, &named);
        let names: Vec<_> = all.iter().map(|m| (m.name, m.probability)).collect();
        self.alternatives = others(&names, &self.effects);
        self.members = all;
        if !self.alternatives.is_empty() {
            self.verdict = Verdict::Ambiguous;
            self.effects.iter_mut().for_each(|e| e.q = None);
        }
    }
}

/// Nothing is missing: the converter's steps, if they can be seen; no verdict of `none` where something forbids it.
fn nothing(steps: Option<FoundEffect>, forbids_none: Option<Forbids>) -> Decision {
    match (steps, forbids_none) {
        (Some(steps), _) => Decision::of(Verdict::Effect, vec![steps]),
        (None, Some(why)) => Decision {
            forbids_none: Some(why),
            ..Decision::of(Verdict::Unknown, Vec::new())
        },
        (None, None) => Decision::of(Verdict::None, Vec::new()),
    }
}

/// Sure names. If one of further names is sure to be there, they are a set; if anything else is, they are a part.
fn names<F>(named: &Named<F>, model: Confirmed) -> Decision {
    let open = named.more && !named.lead && !named.beside.is_empty();
    let mut effects = model.effects;
    for effect in &mut effects {
        let own = named.names.iter().position(|n| n.0 == effect.name);
        effect.q = own.map(|i| 1.0 - model.trust * named.names[i].1.min(1.0));
        if let Some(rivals) = own.and_then(|i| named.rivals.get(i)) {
            effect.rivals = members(rivals);
        }
    }
    effects.retain(|e| open || named.names.iter().any(|n| n.0 == e.name));
    let found = if open {
        Verdict::Ambiguous
    } else if model.accounts && !named.more {
        Verdict::Effect
    } else {
        Verdict::Partial
    };
    Decision {
        alternatives: others(&named.beside, &effects),
        members: members(&named.beside),
        ..Decision::of(found, effects)
    }
}

/// One of a set.
fn one_of(set: &[(Effect, f64)], mut effects: Vec<FoundEffect>) -> Decision {
    effects.retain(|e| set.iter().any(|s| s.0 == e.name));
    Decision {
        alternatives: others(set, &effects),
        members: members(set),
        ..Decision::of(Verdict::Ambiguous, effects)
    }
}

fn members(names: &[(Effect, f64)]) -> Vec<Member> {
    let member = |&(name, probability): &(Effect, f64)| Member { name, probability };
    names.iter().map(member).collect()
}

/// Names that the model does not have.
fn others(names: &[(Effect, f64)], effects: &[FoundEffect]) -> Vec<Effect> {
    let given = |name: &Effect| effects.iter().any(|e| e.name == *name);
    names.iter().map(|n| n.0).filter(|n| !given(n)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Candidate;
    use crate::engine::score::Evidence;
    use Effect::{
        BilinearHysteresis, ChannelSkew, CoulombFriction, MainsHum, Offset, Quantisation,
        Saturation, ViscousDamping,
    };

    fn effect(name: Effect) -> FoundEffect {
        FoundEffect::new(name, [])
    }

    fn alone() -> Beside<'static> {
        Beside {
            steps: None,
            forbids_none: None,
            rail: &|| None,
            swing: None,
            lacks: &|_| Vec::new(),
        }
    }

    fn model(name: Effect) -> Candidate<()> {
        Candidate {
            names: vec![name],
            nameless: false,
            only_family: false,
            evidence: Evidence::of_samples(0.0, 0.0),
            model: (),
        }
    }

    fn confirmed(accounts: bool, name: Effect) -> Option<Confirmed> {
        Some(Confirmed {
            accounts,
            trust: 0.96,
            effects: vec![effect(name)],
        })
    }

    fn one_of_two(beside: Beside) -> Decision {
        let set = vec![(ViscousDamping, 0.6), (Offset, 0.35)];
        let said = Said::Set(model(ViscousDamping), set);
        decide(Some(&said), confirmed(true, ViscousDamping), beside)
    }

    #[test]
    fn steps_are_named_before_anything_forbids_none() {
        let forbids = || Forbids {
            reason: "held-out data leave more".into(),
            lines: Vec::new(),
            noise_share: 1.0,
        };
        let of = |steps: Option<FoundEffect>| {
            let beside = Beside {
                steps,
                forbids_none: Some(forbids()),
                ..alone()
            };
            decide::<()>(None, None, beside)
        };
        let steps = of(Some(effect(Quantisation)));
        assert_eq!(steps.verdict, Verdict::Effect);
        assert!(steps.forbids_none.is_none());
        let forbidden = of(None);
        assert_eq!(forbidden.verdict, Verdict::Unknown);
        assert!(forbidden.forbids_none.is_some());
        assert_eq!(decide::<()>(None, None, alone()).verdict, Verdict::None);
    }

    #[test]
    fn hum_is_a_name_and_of_what_has_none_a_part() {
        let hum = || Beside {
            swing: Some(effect(MainsHum)),
            ..alone()
        };
        let unknown: Said<()> = Said::Unknown(None);
        assert_eq!(
            decide(None::<&Said<()>>, None, hum()).verdict,
            Verdict::Effect
        );
        let part = decide(Some(&unknown), None, hum());
        assert_eq!(part.verdict, Verdict::Partial);
        assert_eq!(part.effects[0].name, MainsHum);
        assert_eq!(one_of_two(hum()).verdict, Verdict::Ambiguous);
        assert_eq!(
            decide(Some(&unknown), None, alone()).verdict,
            Verdict::Unknown
        );
    }

    /// What is cut off at a rail passes for another effect, and is a limit.
    #[test]
    fn an_output_at_its_rail_has_no_names_but_a_limit() {
        let at_rail = || Beside {
            rail: &|| Some("it is clipped".into()),
            ..alone()
        };
        let of = |name| {
            let said = Said::Set(model(name), vec![(name, 0.6), (CoulombFriction, 0.35)]);
            decide(Some(&said), confirmed(true, name), at_rail())
        };
        let clipped = of(Offset);
        assert_eq!(clipped.verdict, Verdict::NotAssessed);
        assert_eq!(clipped.forbids_names.as_deref(), Some("it is clipped"));
        assert!(clipped.effects.is_empty() && clipped.members.is_empty());
        assert_eq!(of(Saturation).verdict, Verdict::Ambiguous);
        assert_eq!(decide::<()>(None, None, at_rail()).verdict, Verdict::None);
    }

    /// What the motion cannot tell is said of a set's other members, too, and takes nothing from the others.
    #[test]
    fn names_that_the_motion_cannot_tell_apart_are_given_together() {
        let lacks = |name: Effect, other: Effect| {
            move |_: &[FoundEffect]| {
                vec![Deficiency {
                    sentence: "one frequency".into(),
                    alike: vec![vec![name, other]],
                }]
            }
        };
        let of = |lacks: &dyn Fn(&[FoundEffect]) -> Vec<Deficiency>| {
            one_of_two(Beside { lacks, ..alone() })
        };
        let probability = |d: &Decision, name| {
            let own = d.members.iter().find(|m| m.name == name);
            own.map(|m| m.probability)
        };
        // `viscous_damping` is the model's, `offset` the other member.
        let own = of(&lacks(ViscousDamping, ChannelSkew));
        assert_eq!(own.alternatives, [Offset, ChannelSkew]);
        assert_eq!(probability(&own, Offset), Some(0.35));
        let other = of(&lacks(Offset, CoulombFriction));
        assert_eq!(other.alternatives, [Offset, CoulombFriction]);
        assert_eq!(probability(&other, ViscousDamping), Some(0.6));
        assert_eq!(other.lacks, ["one frequency"]);
        // A delay is five sevenths as common as a wrong zero; the damper beside them says nothing of it.
        let rarer = of(&lacks(Offset, ChannelSkew));
        let [zero, delay] = [Offset, ChannelSkew].map(|name| probability(&rarer, name).unwrap());
        assert!((delay / zero - 5.0 / 7.0).abs() < 1e-12, "{delay} {zero}");
        let none = of(&lacks(BilinearHysteresis, CoulombFriction));
        assert_eq!(none.alternatives, [Offset]);
        assert!(none.lacks.is_empty());
    }

    /// A name that held-out data do not confirm is `unknown`, not another name.
    #[test]
    fn held_out_data_withdraw_a_name() {
        let said = Said::Names(Named {
            model: model(Offset),
            names: vec![(Offset, 0.99)],
            rivals: vec![Vec::new()],
            beside: Vec::new(),
            more: false,
            lead: false,
        });
        let of = |model| decide(Some(&said), model, alone());
        assert_eq!(of(confirmed(true, Offset)).verdict, Verdict::Effect);
        assert_eq!(of(confirmed(false, Offset)).verdict, Verdict::Partial);
        let q = of(confirmed(true, Offset)).effects[0].q.unwrap();
        assert!((q - (1.0 - 0.96 * 0.99)).abs() < 1e-12, "{q}");
        let withdrawn = of(None);
        assert_eq!(withdrawn.verdict, Verdict::Unknown);
        assert!(withdrawn.effects.is_empty());
    }
}
