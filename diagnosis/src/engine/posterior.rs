//! From scored models to the probability of each name and of no name.

use super::score::Evidence;
use plant::{Effect, Family};

/// Cost of the other name of a force or a response, nats: the shape slightly favours its own name.
pub const OTHER_NAME: f64 = 0.4;

/// Something that may be missing from a model.
pub trait Name: Copy + Eq {
    /// Its index in the list of all names.
    fn place(self) -> usize;

    /// Its family, if it has one.
    fn family(self) -> Option<Family>;
}

impl Name for Effect {
    fn place(self) -> usize {
        self as usize
    }

    fn family(self) -> Option<Family> {
        Some(self.entry().family)
    }
}

/// A model with its names; the declared model has none.
#[derive(Clone, Debug)]
pub struct Candidate<M, N = Effect> {
    /// The names, in ascending order, each once.
    pub names: Vec<N>,
    /// True if the model also has free functions.
    pub nameless: bool,
    /// True if one of its terms can be named only by family: no name in the list is its own.
    pub only_family: bool,
    /// The evidence for it.
    pub evidence: Evidence,
    /// The model itself, without free functions.
    pub model: M,
}

/// The best model of each set of names, with and without free functions, with its probability; the likeliest first.
#[derive(Clone, Debug)]
pub struct Posterior<M, N = Effect> {
    /// All models.
    pub models: Vec<(Candidate<M, N>, f64)>,
}

impl<M: Clone, N: Name> Posterior<M, N> {
    /// Computes the posterior of these models.
    pub fn of(mut all: Vec<Candidate<M, N>>) -> Self {
        let score = |c: &Candidate<M, N>| c.evidence.score();
        all.retain(|c| score(c).is_finite());
        all.sort_by(|a, b| score(b).total_cmp(&score(a)));
        let mut kept: Vec<Candidate<M, N>> = Vec::new();
        for c in all {
            let same = |k: &Candidate<M, N>| (&k.names, k.nameless) == (&c.names, c.nameless);
            if !kept.iter().any(same) {
                kept.push(c);
            }
        }
        let best = kept.first().map_or(0.0, score);
        let weights: Vec<f64> = kept.iter().map(|c| (score(c) - best).exp()).collect();
        let whole: f64 = weights.iter().sum();
        let models = kept.into_iter().zip(weights).map(|(c, w)| (c, w / whole));
        Self {
            models: models.collect(),
        }
    }

    /// Probability of the models for which `of` holds.
    pub fn share(&self, of: impl Fn(&Candidate<M, N>) -> bool) -> f64 {
        let all = self.models.iter().filter(|(c, _)| of(c));
        all.map(|(_, w)| w).sum()
    }

    /// Probability that a name is in the rig.
    pub fn name(&self, name: N) -> f64 {
        self.share(|c| c.names.contains(&name))
    }

    /// All names with their probabilities, the likeliest first.
    pub fn names(&self) -> Vec<(N, f64)> {
        let mut all: Vec<N> = self
            .models
            .iter()
            .flat_map(|(c, _)| c.names.clone())
            .collect();
        all.sort_by_key(|n| n.place());
        all.dedup();
        let mut with: Vec<(N, f64)> = all.into_iter().map(|n| (n, self.name(n))).collect();
        with.sort_by(|a, b| b.1.total_cmp(&a.1));
        with
    }

    /// Possible replacements of `name` in models with the others of `names`, with probabilities, the likeliest first.
    pub fn rivals(&self, name: N, names: &[N]) -> Vec<(N, f64)> {
        let stays = |c: &Candidate<M, N>| {
            let others = names.iter().filter(|n| **n != name);
            !c.names.contains(&name) && others.into_iter().all(|n| c.names.contains(n))
        };
        let mut rivals: Vec<(N, f64)> = Vec::new();
        for (c, w) in self.models.iter().filter(|m| stays(&m.0)) {
            for n in c.names.iter().filter(|n| !names.contains(n)) {
                match rivals.iter_mut().find(|r| r.0 == *n) {
                    Some(rival) => rival.1 += w,
                    None => rivals.push((*n, *w)),
                }
            }
        }
        rivals.sort_by(|a, b| b.1.total_cmp(&a.1));
        rivals
    }

    /// The posterior under the condition that nothing without a name is in the rig.
    pub fn named(&self) -> Self {
        self.only(|c| !c.nameless)
    }

    /// The posterior given the name count of the smallest named model for which `does` holds; `None` if there is none.
    pub fn with_as_few_names(&self, does: impl Fn(&Candidate<M, N>) -> bool) -> Option<Self> {
        let enough = self.models.iter().map(|m| &m.0);
        let enough = enough.filter(|c| !c.names.is_empty() && does(c));
        let fewest = enough.map(|c| c.names.len()).min()?;
        Some(self.only(|c| c.names.len() == fewest))
    }

    fn only(&self, of: impl Fn(&Candidate<M, N>) -> bool) -> Self {
        let kept = self.models.iter().filter(|m| of(&m.0));
        let whole: f64 = kept.clone().map(|m| m.1).sum();
        let models = kept.map(|(c, w)| (c.clone(), w / whole.max(f64::MIN_POSITIVE)));
        Self {
            models: models.collect(),
        }
    }

    /// Fraction of the largest reduction of the declared model's residual, in log squares, that this model achieves.
    pub fn explained(&self, by: &Candidate<M, N>) -> f64 {
        let density = |c: &Candidate<M, N>| c.evidence.log_density;
        let most = self.models.iter().map(|m| density(&m.0));
        let most = most.fold(f64::NEG_INFINITY, f64::max);
        self.declared().map_or(0.0, |declared| {
            let whole = (most - density(declared)).max(f64::MIN_POSITIVE);
            (density(by) - density(declared)) / whole
        })
    }

    /// Probability that at least one name of this family is in the rig.
    pub fn family(&self, family: Family) -> f64 {
        self.share(|c| c.names.iter().any(|n| n.family() == Some(family)))
    }

    /// Probability that something without a name is in the rig.
    pub fn unnamed(&self) -> f64 {
        self.share(|c| c.nameless)
    }

    /// The best model without any name or free function.
    pub fn declared(&self) -> Option<&Candidate<M, N>> {
        let plain = |c: &&Candidate<M, N>| c.names.is_empty() && !c.nameless;
        self.models.iter().map(|m| &m.0).find(plain)
    }
}

#[cfg(test)]
mod tests {
    use super::super::score::{BLOCKS, Score};
    use super::super::verdict::{NOTHING, Said, verdict};
    use super::*;

    /// A candidate whose residual is `left` times the noise, at this price.
    fn candidate(names: &[Effect], left: f64, price: f64) -> Candidate<()> {
        let score = Score::new(1.0, [100.0; BLOCKS]);
        Candidate {
            names: names.to_vec(),
            nameless: false,
            only_family: false,
            evidence: score.evidence(&[100.0 * (1.0 + left * left); BLOCKS], price),
            model: (),
        }
    }

    #[test]
    fn rivals_that_leave_as_much_are_a_set_and_what_leaves_half_is_a_name() {
        let declared = candidate(&[], 9.0, 0.0);
        let [friction, backlash] = [Effect::CoulombFriction, Effect::Backlash];
        let alike = Posterior::of(vec![
            declared.clone(),
            candidate(&[friction], 1.0, 3.0),
            candidate(&[backlash], 1.0, 3.0),
        ]);
        let Said::Set(_, set) = verdict(&alike, NOTHING) else {
            panic!("no set");
        };
        assert_eq!(set.len(), 2);
        let clear = Posterior::of(vec![
            declared.clone(),
            candidate(&[friction], 1.0, 3.0),
            candidate(&[backlash], 2.0, 3.0),
        ]);
        assert!((clear.name(friction) - 1.0).abs() < 1e-3);
        assert!(matches!(verdict(&clear, NOTHING), Said::Names(n) if n.names.len() == 1));
        // Each of two names is judged by how much it improves the other's model.
        let both = Posterior::of(vec![
            declared,
            candidate(&[friction], 5.0, 3.0),
            candidate(&[backlash], 5.0, 3.0),
            candidate(&[friction, backlash], 0.5, 7.5),
        ]);
        assert!(matches!(verdict(&both, NOTHING), Said::Names(n) if n.names.len() == 2));
    }

    #[test]
    fn each_of_two_names_has_the_rivals_that_stand_in_its_place() {
        let [friction, backlash, damping] = [
            Effect::CoulombFriction,
            Effect::Backlash,
            Effect::ViscousDamping,
        ];
        let posterior = Posterior::of(vec![
            candidate(&[], 9.0, 0.0),
            candidate(&[friction, backlash], 0.5, 7.5),
            candidate(&[damping, backlash], 0.6, 7.5),
            candidate(&[friction, damping], 6.0, 7.5),
        ]);
        let Said::Names(n) = verdict(&posterior, NOTHING) else {
            panic!("no names");
        };
        let of = |name| {
            let at = n.names.iter().position(|named| named.0 == name);
            &n.rivals[at.expect("a name")]
        };
        assert!(matches!(of(friction)[..], [(rival, p)] if rival == damping && p > 0.03));
        assert_eq!(of(backlash).len(), 0, "{:?}", of(backlash));
    }

    #[test]
    fn a_sure_name_does_not_lead_where_one_of_two_others_is_sure_to_be_beside_it() {
        let friction = Effect::CoulombFriction;
        let with =
            |names: &[Effect], left, price| candidate(&[&[friction], names].concat(), left, price);
        let declared = candidate(&[], 9.0, 0.0);
        let leads = |others: Vec<Candidate<()>>| {
            let all = [vec![declared.clone(), with(&[], 1.0, 3.0)], others].concat();
            let Said::Names(n) = verdict(&Posterior::of(all), NOTHING) else {
                panic!("no names");
            };
            assert_eq!(n.names[0].0, friction);
            n.lead
        };
        let beside = |left| {
            [Effect::GainError, Effect::RigCompliance]
                .map(|n| with(&[n], left, 6.0))
                .to_vec()
        };
        assert!(!leads(beside(0.5)));
        // As likely to be nothing.
        assert!(leads(beside(0.85)));
    }

    #[test]
    fn what_free_functions_take_as_well_as_a_law_has_no_name() {
        let declared = candidate(&[], 9.0, 0.0);
        let friction = |left| candidate(&[Effect::CoulombFriction], left, 3.0);
        let nameless = |left: f64| Candidate {
            nameless: true,
            ..candidate(&[], left, 9.5)
        };
        let of = |named: f64, free: f64| {
            let all = vec![declared.clone(), friction(named), nameless(free)];
            verdict(&Posterior::of(all), NOTHING)
        };
        assert!(matches!(of(2.0, 1.9), Said::Names(n) if !n.more));
        // Friction explains nearly all of it: a plain name, but something more remains.
        assert!(matches!(of(1.0, 0.5), Said::Names(n) if n.more));
        assert!(matches!(of(2.0, 0.5), Said::Unknown(Some(_))));
    }

    #[test]
    fn nothing_is_said_to_be_missing_below_the_noise_and_unknown_above_it() {
        let quiet = Posterior::of(vec![candidate(&[], 0.3, 0.0)]);
        assert!(matches!(verdict(&quiet, NOTHING), Said::Nothing));
        // Only if no rest determines the noise, and only if no law explains the residual.
        let louder = [
            candidate(&[], 0.7, 0.0),
            candidate(&[Effect::Drift], 0.1, 3.0),
        ];
        let of = |all: &[Candidate<()>], allowed| verdict(&Posterior::of(all.to_vec()), allowed);
        assert!(matches!(of(&louder[..1], NOTHING), Said::Nothing));
        assert!(matches!(of(&louder, NOTHING), Said::Names(..)));
        assert!(matches!(
            of(&louder[..1], [NOTHING[0]; 2]),
            Said::Unknown(None)
        ));
        let loud = Posterior::of(vec![candidate(&[], 5.0, 0.0)]);
        assert!(matches!(verdict(&loud, NOTHING), Said::Unknown(None)));
    }
}
