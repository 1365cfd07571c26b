//! The search for what explains a residual.

use crate::base::Base;
use crate::criteria::single::{
    ACCOUNTS, ALARMS, CERTAIN, EQUAL, EVIDENCE, EXPLAINS, INDIFFERENT, LEADING, LOOK_HZ, MATTERS,
    PAIRED, READING, REMAINS, SECOND,
};
use crate::fit::{Frame, Solution, settle};
use crate::library::candidate::Candidate;
use crate::library::candidates;
use crate::noise::Noise;
use crate::polish::{Shaped, polish};
use crate::problem::{FittedEffect, Problem};
use crate::signals::rms;
use crate::simpler;
use plant::{Channel, Effect};
use rayon::prelude::*;

/// What the search came to.
#[derive(Debug)]
pub struct Explanation {
    /// The model with its parameters refitted, without any effect.
    pub before: Solution,
    /// With the effects that were accepted; the same as `before` where none was.
    pub after: Solution,
    /// Effects that explain it equally well.
    pub alternatives: Vec<Effect>,
    /// Structured rms before and after.
    pub structured: [f64; 2],
    /// Best single effect and the rms that is left with it, where one is worth naming.
    pub nearest: Option<(Effect, f64)>,
    /// Every candidate: rms left, fall of the criterion; best first.
    pub tried: Vec<(Effect, f64, f64)>,
    /// What remains is too much for a verdict.
    pub vetoed: bool,
}

/// rms beyond the noise.
pub fn structured(residual_rms: f64, noise: &Noise) -> f64 {
    (residual_rms * residual_rms - noise.rms * noise.rms)
        .max(0.0)
        .sqrt()
}

impl Explanation {
    /// Nothing is missing.
    pub fn nothing(settled: Solution) -> Self {
        Self {
            after: settled.clone(),
            alternatives: Vec::new(),
            structured: [0.0; 2],
            nearest: None,
            tried: Vec::new(),
            vetoed: false,
            before: settled,
        }
    }
}

/// Searches, beginning with the declared parameters at their best; `None` where the equations have no solution.
pub fn explain(before: Solution, base: &Base, noise: &Noise) -> Option<Explanation> {
    let problem = &before.problem.clone();
    let left = |s: &Solution| {
        let residuals = s.problem.residuals(&s.effects, &s.problem.scales);
        let judged = problem.segments.iter().zip(residuals);
        rms(&judged
            .map(|(s, r)| s.without_corners(r))
            .collect::<Vec<_>>())
    };
    let start = structured(left(&before), noise);
    let mut out = Explanation {
        structured: [start; 2],
        ..Explanation::nothing(before)
    };
    if start < MATTERS * noise.rms || !noise.is_below(left(&out.before), problem.seconds()) {
        return Some(out);
    }
    let ln_n = (out.before.samples as f64).ln();
    // Fall of -2 ln L less what the unknowns cost; the noise is known, so the sum of squares is -2 ln L up to where
    // model error rules: there the evidence is counted in the residual's own size.
    let gain = |from: &Solution, to: &Solution| {
        let own = (to.cost / to.samples as f64).max(1.0);
        (from.cost - to.cost) / own - (to.unknowns as f64 - from.unknowns as f64) * ln_n
    };
    let mut library = candidates(base.channel);
    // Where no lag is declared, a second one is the first.
    if base.channel == Channel::Actuator && base.values[2] == 0.0 {
        library.retain(|c| c.effect != Effect::SecondLag);
    }
    let search = EffectSearch::new(problem, base, noise);
    let mut singles = search.best_with(&[], &library, &out.before);
    // What leaves more than was there before has fitted the noise's colour, not the record.
    let worst = left(&out.before);
    singles.retain(|s| left(s) <= worst);
    // Nothing that is read passes a stop or a clip.
    let all = singles.len();
    singles.retain(|s| !simpler::is_passed(s, noise));
    if singles.len() < all {
        library.retain(|c| c.effect != Effect::Saturation);
    }
    singles.sort_by(|a, b| score(a, ln_n).total_cmp(&score(b, ln_n)));
    let best_left = singles.first().map_or(0.0, left);
    // Where the best one leaves nothing but noise, its form is in the record, too, if it shows.
    let to_the_noise = structured(best_left, noise) < MATTERS * noise.rms;
    let accounts = |s: &Solution| {
        if to_the_noise {
            (left(s).powi(2) - best_left.powi(2)).max(0.0).sqrt() < EXPLAINS * noise.rms
        } else {
            structured(left(s), noise) < ACCOUNTS * start
        }
    };
    simplest_first(&mut singles, ln_n, accounts);
    out.tried = singles
        .iter()
        .map(|s| (s.effects[0].candidate.effect, left(s), gain(&out.before, s)))
        .collect();
    let Some(first) = singles.first().cloned() else {
        return Some(out);
    };
    let first_left = structured(left(&first), noise);
    out.nearest = Some((first.effects[0].candidate.effect, first_left));
    let explained = (start * start - first_left * first_left).max(0.0).sqrt();
    if gain(&out.before, &first) < EVIDENCE || explained < EXPLAINS * noise.rms {
        out.vetoed = start > ALARMS * noise.rms;
        return Some(out);
    }
    out.after = first.clone();
    out.alternatives = alternatives(&singles, out.before.cost, ln_n);
    let now = first_left;
    if now > (MATTERS * noise.rms).max(0.1 * start)
        && let Some((pair, others)) = search.second(&first, &singles, &library, ln_n, left)
    {
        let pair_left = structured(left(&pair), noise);
        let more = (now * now - pair_left * pair_left).max(0.0).sqrt();
        if gain(&first, &pair) > EVIDENCE && more > SECOND * start && pair_left < 0.5 * now {
            (out.after, out.alternatives) = (pair, others);
        }
    }
    if let Some(plain) = simpler::plain_friction(&out.after, base, noise) {
        out.after = plain;
    }
    // What may be something else is not certain anyway.
    if out.alternatives.is_empty()
        && let Some(told) = simpler::told(&out.after, base, noise)
    {
        out.after = told;
    }
    let named = |n: &Effect| out.after.effects.iter().any(|e| e.candidate.effect == *n);
    out.alternatives.retain(|n| !named(n));
    let now = structured(left(&out.after), noise);
    out.structured[1] = now;
    out.vetoed = now > (REMAINS * start).max(MATTERS * noise.rms);
    Some(out)
}

/// An effect alone at its best.
pub fn best_alone(
    effect: Candidate,
    problem: &Problem,
    base: &Base,
    noise: &Noise,
) -> Option<Solution> {
    let settled = settle(problem, base, noise, &[])?;
    let search = EffectSearch::new(problem, base, noise);
    search.best_with(&[], &[effect], &settled).pop()
}

/// Cost and what the unknowns cost.
fn score(s: &Solution, ln_n: f64) -> f64 {
    s.cost + s.unknowns as f64 * ln_n
}

fn shaped(s: &Solution) -> Vec<Shaped> {
    s.effects
        .iter()
        .map(|e| (e.candidate, e.shapes.clone()))
        .collect()
}

/// What a search works with: the records as they are, and thinned for a screening of every candidate.
struct EffectSearch<'a> {
    base: &'a Base,
    noise: &'a Noise,
    thin_noise: Noise,
    /// So many samples are averaged for the screening.
    thin: usize,
}

impl<'a> EffectSearch<'a> {
    fn new(problem: &Problem, base: &'a Base, noise: &'a Noise) -> Self {
        let rate_hz = 1.0 / (problem.scales.interval_s * noise.every as f64);
        let times = (rate_hz / LOOK_HZ).round().max(1.0) as usize;
        Self {
            base,
            noise,
            thin_noise: noise.thinned(times),
            thin: noise.every * times,
        }
    }

    /// Each candidate at its best beside `fixed`, whose shapes stay; the leading ones are fitted to all samples, the
    /// others are as the screening left them.
    fn best_with(&self, fixed: &[Shaped], library: &[Candidate], from: &Solution) -> Vec<Solution> {
        // Around the declared values: without the effect the refitted ones have been pulled aside by it.
        let mut start = from.problem.clone();
        if fixed.is_empty() {
            start.set(self.base, self.base.values);
        }
        let thin = start.thinned(self.thin);
        let frame = Frame::new(&thin, self.base, &self.thin_noise, fixed);
        let new = |c: &&Candidate| fixed.iter().all(|(f, _)| f.effect != c.effect);
        let relevant: Vec<&Candidate> = library.iter().filter(new).collect();
        let mut found: Vec<(Shaped, f64)> = relevant
            .par_iter()
            .filter_map(|&candidate| {
                let (shapes, amplitudes) = frame.search(candidate)?;
                Some(((*candidate, shapes), amplitudes.cost))
            })
            .collect();
        found.sort_by(|a, b| a.1.total_cmp(&b.1));
        // Beside a fixed effect only the best matter, and their special cases.
        if !fixed.is_empty() {
            let leaders: Vec<Candidate> = found.iter().take(PAIRED).map(|f| f.0.0).collect();
            found.retain(|((c, _), _)| {
                let part_of =
                    |l: &Candidate| l.effect == c.effect || l.includes.contains(&c.effect);
                leaders.iter().any(part_of)
            });
        }
        let leading = if fixed.is_empty() { LEADING } else { PAIRED };
        let settled = found.par_iter().filter_map(|(effect, _)| {
            let mut all = fixed.to_vec();
            all.push(effect.clone());
            settle(&start, self.base, self.noise, &all)
        });
        let mut settled: Vec<Solution> = settled.collect();
        settled.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let polished = settled.into_par_iter().enumerate().map(|(rank, s)| {
            if rank < leading {
                polish(s, self.base, self.noise)
            } else {
                s
            }
        });
        polished.collect()
    }

    /// The best pair that begins with one of the leading single effects: greedy, then each is replaced once by what does
    /// better beside the other.
    fn second(
        &self,
        first: &Solution,
        singles: &[Solution],
        library: &[Candidate],
        ln_n: f64,
        left: impl Fn(&Solution) -> f64,
    ) -> Option<(Solution, Vec<Effect>)> {
        let by_score = |a: &Solution, b: &Solution| score(a, ln_n).total_cmp(&score(b, ln_n));
        let mut all: Vec<Solution> = Vec::new();
        for leader in std::iter::once(first).chain(singles.iter().skip(1).take(1)) {
            let pairs = self.best_with(&shaped(leader), library, leader);
            let Some(pair) = pairs.iter().min_by(|a, b| by_score(a, b)).cloned() else {
                continue;
            };
            all.extend(pairs);
            // Only a second effect that carries its weight is worth another search.
            if score(leader, ln_n) - score(&pair, ln_n) > EVIDENCE {
                let other = shaped(&pair).split_off(1);
                all.extend(self.best_with(&other, library, &pair));
            }
        }
        all.sort_by(by_score);
        let best = all.first()?;
        let most = score(best, ln_n) + room(best);
        let best_left = left(best);
        let shows = |s: &Solution| {
            let more = (left(s).powi(2) - best_left.powi(2)).max(0.0).sqrt();
            score(s, ln_n) > most && more > EXPLAINS * self.noise.rms
        };
        let simpler = all.iter().find(|s| is_simpler(s, best) && !shows(s));
        let chosen = simpler.unwrap_or(best).clone();
        // What does as well in the place of either.
        let as_well = all.iter().filter(|s| score(s, ln_n) < most);
        let mut others: Vec<Effect> = as_well.filter_map(|s| in_its_place(s, &chosen)).collect();
        others.sort();
        others.dedup();
        Some((polish(chosen, self.base, self.noise), others))
    }
}

/// The effect that one pair has in the place of one of another pair; `None` where they have none in common, and where the
/// one contains the other.
fn in_its_place(pair: &Solution, of: &Solution) -> Option<Effect> {
    let has = |s: &Solution, e: &FittedEffect| {
        let same = |f: &FittedEffect| f.candidate.effect == e.candidate.effect;
        s.effects.iter().any(same)
    };
    let mut new = pair.effects.iter().filter(|e| !has(of, e));
    let mut gone = of.effects.iter().filter(|e| !has(pair, e));
    let (new, gone) = (new.next().filter(|_| new.next().is_none())?, gone.next()?);
    let contains = new.candidate.includes.contains(&gone.candidate.effect);
    (!contains).then_some(new.candidate.effect)
}

/// Whether a pair has a special case in place of one effect of another pair.
fn is_simpler(pair: &Solution, than: &Solution) -> bool {
    let has = |s: &Solution, e: &FittedEffect| {
        let same = |f: &FittedEffect| f.candidate.effect == e.candidate.effect;
        s.effects.iter().any(same)
    };
    let new = pair.effects.iter().find(|e| !has(than, e));
    let gone = than.effects.iter().find(|e| !has(pair, e));
    new.zip(gone)
        .is_some_and(|(new, gone)| gone.candidate.includes.contains(&new.candidate.effect))
}

/// By how much the cost of two explanations may differ that are equally good: by chance, or by a small part of what
/// neither of them explains.
fn room(best: &Solution) -> f64 {
    let expected = best.samples as f64;
    let unexplained = (best.cost - CERTAIN * expected).max(0.0);
    (EQUAL * (best.cost / expected).max(1.0)).max(INDIFFERENT * unexplained)
}

/// Of an effect and one that contains it as a special case, the special case goes first where it does as well, or
/// accounts for so much that the rest is a matter of its form.
fn simplest_first(singles: &mut [Solution], ln_n: f64, accounts: impl Fn(&Solution) -> bool) {
    let Some(best) = singles.first() else { return };
    let most = score(best, ln_n) + room(best);
    let included = best.effects[0].candidate.includes;
    let simpler = singles.iter().position(|s| {
        included.contains(&s.effects[0].candidate.effect) && (score(s, ln_n) < most || accounts(s))
    });
    if let Some(i) = simpler {
        singles[..=i].rotate_right(1);
    }
}

/// Single effects that are not worse than the first by more than chance, or by nothing that matters.
fn alternatives(singles: &[Solution], cost_before: f64, ln_n: f64) -> Vec<Effect> {
    let best = &singles[0];
    let most = score(best, ln_n) + room(best);
    let reads = |s: &Solution| s.effects.iter().any(|e| e.candidate.from_reading);
    let noisy = READING * (cost_before - best.cost).max(0.0);
    singles[1..]
        .iter()
        .filter(|other| {
            let candidate = &other.effects[0].candidate;
            // What contains the best explanation as a special case is no other explanation.
            let contains = candidate
                .includes
                .contains(&best.effects[0].candidate.effect);
            let most = if reads(best) || reads(other) {
                most + noisy
            } else {
                most
            };
            !contains && score(other, ln_n) < most
        })
        .map(|s| s.effects[0].candidate.effect)
        .collect()
}
