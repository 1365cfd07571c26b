//! A fitted model under each of the names that its force may have.

use super::motion::Motion;
use super::posterior::{Candidate, OTHER_NAME};
use super::row::{A_PARAMETER, Form, Row};
use super::search::price_of_many;
use super::specimen::{SpecimenData, SpecimenModelFit, Term};
use super::verdict::UNEXPLAINED;
use crate::laws::specimen::element::{Element, Law};
use crate::numbers::signals::{add_columns, add_scaled, difference, rms};
use plant::{Effect, Family};

/// A spring whose declared stiffness is wrong by more than this multiple of what it stiffens may be one read by a scale that
/// is wrong.
const BENDS: f64 = 3.0;

/// If less than the first fraction of a stiffness remains within a gap, there is no spring in it, and below the second
/// there may be none.
const NO_SPRING: f64 = 0.1;
const HARDLY_A_SPRING: f64 = 0.3;

/// Families of laws that may be part of a declared spring.
const OF_A_SPRING: [Family; 4] = [
    Family::Hysteresis,
    Family::Gap,
    Family::Stiffness,
    Family::Asymmetry,
];

/// Fraction of the slopes that is left out at each end: an average over a reversal has a false one.
const NOISE_OF_SLOPES: f64 = 0.003;
/// Smallest step between samples that has a slope, over the rms step.
const LEAST_STEP: f64 = 0.05;
/// A slope may miss the declared stiffness by this multiple of its tolerance, or this fraction of what the laws change,
/// unless at a place or in contact: they are approximations.
const ROOM: f64 = 2.0;
const OF_THE_LAW: f64 = 0.1;
/// Fraction of the slopes that is certainly in contact if there is a gap.
const IN_CONTACT: f64 = 0.1;

/// A fit under each of the names that its force may have.
pub fn candidates(
    data: &SpecimenData,
    mut fit: SpecimenModelFit,
) -> Vec<Candidate<SpecimenModelFit>> {
    let keeps = (0..fit.terms.len()).map(|i| data.keeps_within_a_gap(&fit, i));
    let keeps: Vec<f64> = keeps.collect();
    let is_empty = |n: &(&mut Effect, &f64)| *n.1 < NO_SPRING;
    let empty = fit.names.iter_mut().zip(&keeps).filter(is_empty);
    empty.for_each(|n| *n.0 = Effect::DeadBand);
    let mut all = vec![fit.names.clone()];
    for (i, keeps) in keeps.into_iter().enumerate() {
        let known = all.clone();
        for other in other_names(data, &fit, i, keeps) {
            all.extend(known.iter().map(|names| {
                let mut names = names.clone();
                names[i] = other;
                names
            }));
        }
    }
    let of = |own: Vec<Effect>| {
        let mut evidence = fit.evidence;
        if own != fit.names {
            evidence.price += OTHER_NAME;
        }
        let named = SpecimenModelFit {
            names: own,
            evidence,
            ..fit.clone()
        };
        match data.softer_than_declared(&named) {
            None => vec![named],
            Some(softer) => data.with_wrong_stiffness(&named, softer),
        }
    };
    let all = all.into_iter().flat_map(of);
    all.map(|fit| candidate(data, fit)).collect()
}

/// Other names of one of a fit's terms; `keeps`: the fraction of a spring that it keeps within a gap.
fn other_names(data: &SpecimenData, fit: &SpecimenModelFit, i: usize, keeps: f64) -> Vec<Effect> {
    let other = |i: usize| {
        let (term, own) = (fit.terms[i], &fit.strengths[i]);
        data.rows[term.row].other_name(term.shape, own, fit.names[i], &data.sizes)
    };
    let has_only = |own| data.has_only(fit, own);
    let late_s = data.late_s(fit);
    let is_of = |i: &usize, family| fit.names[*i].entry().family == family;
    let stiffer = fit.declared[0] - data.declared_values()[0];
    let own = fit.terms[i];
    // A scale that is wrong, or a frame that gives way, and bends a little.
    let bends = || {
        let row = &data.rows[own.row];
        row.is_spring() && row.frees == Some(0) && (stiffer / fit.strengths[i][0]).abs() > BENDS
    };
    let mut all = Vec::from_iter(other(i));
    all.extend(match fit.names[i] {
        // Damping, mass and what else a clip would also limit tell it from a spring that softens, and so does a corner.
        Effect::Saturation if has_only(0) && data.is_alone(fit, i) && !data.has_a_corner(own) => {
            vec![Effect::Softening]
        }
        // A late dashpot is one behind its brace: only a spring or a mass would tell the difference.
        Effect::ChannelSkew if late_s.is_some_and(|s| s > 0.0) && has_only(1) => {
            vec![Effect::MaxwellDamper]
        }
        // A frame whose joints close gives way more at first.
        Effect::Hardening if bends() && stiffer < 0.0 => {
            vec![Effect::GainError, Effect::RigCompliance]
        }
        Effect::Hardening | Effect::Softening if bends() => vec![Effect::GainError],
        Effect::Hardening if keeps < HARDLY_A_SPRING => vec![Effect::DeadBand],
        // A higher-order filter delays, and leads or lags with the square of the frequency, as a mass does.
        Effect::InertiaForce => {
            let kg = fit.declared[2] - data.declared_values()[2];
            let of_a_filter = late_s.map_or(0.0, |s| 1e3 * fit.declared[0].abs() * s * s);
            Vec::from_iter((kg.abs() < of_a_filter).then_some(Effect::ChannelSkew))
        }
        // A play narrower than the travel over which friction builds up may be how it builds up.
        Effect::Backlash => {
            let width_mm = match data.rows[own.row].form {
                Form::Element(_) => 2.0 * own.shape[0],
                _ => own.shape[0],
            };
            let friction = (0..fit.terms.len()).filter(|i| is_of(i, Family::Friction));
            let wider = |f: &usize| width_mm < data.builds_up_over_mm(&fit.terms[*f]);
            Vec::from_iter(friction.filter(wider).map(|f| fit.names[f]).next())
        }
        // Friction with hysteresis that yields as early as friction may is one sliding contact with a rounded knee.
        name if name.entry().family == Family::Friction => {
            let early = |i: &usize| is_of(i, Family::Hysteresis) && other(*i).is_some();
            Vec::from_iter((0..fit.terms.len()).find(early).map(|i| fit.names[i]))
        }
        _ => Vec::new(),
    });
    all
}

/// A fit under its names.
fn candidate(data: &SpecimenData, model: SpecimenModelFit) -> Candidate<SpecimenModelFit> {
    let mut names = model.names.clone();
    names.sort_by_key(|n| *n as usize);
    names.dedup();
    let plain = |t: &Term| data.rows[t.row].has_its_familys_name();
    Candidate {
        names,
        nameless: false,
        only_family: model.terms.iter().any(plain),
        evidence: model.evidence,
        model,
    }
}

/// True if a fit has a name of one of these families.
fn has_one_of(fit: &SpecimenModelFit, families: &[Family]) -> bool {
    fit.names
        .iter()
        .any(|n| families.contains(&n.entry().family))
}

/// The least and the greatest slope of a force that a declared stiffness may be, and the range of all its slopes, N/mm.
struct Slopes {
    low: f64,
    high: f64,
    range: f64,
}

impl SpecimenData<'_> {
    /// Whether the stiffness that one of a fit's laws frees is softer than declared. `None` if it is the declared one, if it
    /// already has a name, or if none is freed or declared. The least slope, the greatest, and all between fit; at a knee
    /// there is none between.
    fn softer_than_declared(&self, fit: &SpecimenModelFit) -> Option<bool> {
        let declared = self.declared_values()[0];
        let is_named = |n: &Effect| matches!(n, Effect::GainError | Effect::RigCompliance);
        if declared == 0.0 || fit.names.iter().any(is_named) {
            return None;
        }
        let Slopes { low, high, range } = self.slopes_of_freed(fit)?;
        let has_knee = fit.terms.iter().any(|t| self.is_knee(t));
        // In contact the slope is the spring's own, if nothing else bends and the fit leaves only noise.
        let bends = has_one_of(fit, &[Family::Hysteresis, Family::Stiffness]);
        let in_contact =
            has_one_of(fit, &[Family::Gap]) && !bends && fit.evidence.left_rms() < UNEXPLAINED;
        let of_the_law = if has_knee || in_contact {
            0.0
        } else {
            OF_THE_LAW * range
        };
        let around = of_the_law.max(ROOM * self.tolerance(0));
        // A device beside the spring may have one of its own.
        let has_device = has_one_of(
            fit,
            &[Family::Asymmetry, Family::Hysteresis, Family::Stiffness],
        );
        let [below, above] = [declared - low, high - declared];
        let between = below >= 0.0 && above >= 0.0 && !has_knee;
        let near = below.abs().min(above.abs()) < around;
        let kept = near || between || below < 0.0 && has_device;
        let nearest = if below.abs() < above.abs() { low } else { high };
        (!kept).then_some(nearest < declared)
    }

    /// Stiffness of a fit for small motions, N/mm: in contact if it has a gap, before a law yields that is part of the spring.
    pub fn stiffness_of_small_motions(&self, fit: &SpecimenModelFit) -> f64 {
        let changes = has_one_of(fit, &[Family::Gap, Family::Hysteresis]);
        let slopes = changes.then(|| self.slopes_of_freed(fit)).flatten();
        slopes.map_or(fit.declared[0], |s| s.high)
    }

    /// Slopes of the spring that one of a fit's laws frees, with all laws that may be part of it; `None` if none is freed.
    /// Friction is beside a spring, and within a gap there is none.
    fn slopes_of_freed(&self, fit: &SpecimenModelFit) -> Option<Slopes> {
        if !fit.terms.iter().any(|t| self.rows[t.row].frees == Some(0)) {
            return None;
        }
        let mut slopes: Vec<f64> = self.local_stiffness(fit).into_iter().map(|s| s.1).collect();
        slopes.sort_by(f64::total_cmp);
        let at = |share: f64| slopes.get((share * slopes.len() as f64) as usize).copied();
        let [least, most] = [at(NOISE_OF_SLOPES)?, at(1.0 - NOISE_OF_SLOPES)?];
        let [low, high] = if has_one_of(fit, &[Family::Gap]) {
            [at(1.0 - IN_CONTACT)?; 2]
        } else {
            // The motion may be away from where a spring is as declared.
            [least.min(fit.declared[0]), most.max(fit.declared[0])]
        };
        let range = most - least;
        Some(Slopes { low, high, range })
    }

    /// Travel over which friction builds up after a reversal, mm; 0 if its force depends on speed alone.
    fn builds_up_over_mm(&self, friction: &Term) -> f64 {
        let shape = friction.shape;
        match self.rows[friction.row].form {
            Form::Element(law) if law.slides() => Element { law, shape }.yields_at(),
            Form::Effect(c) if c.effect == Effect::StribeckFriction => shape[0],
            _ => 0.0,
        }
    }

    /// True for a spring that changes at a place.
    fn is_knee(&self, term: &Term) -> bool {
        matches!(self.rows[term.row].form, Form::Element(Law::Beyond))
    }

    /// Places, mm, and slopes there, N/mm, of the force of a fit's spring and of all laws that may be part of it.
    fn local_stiffness(&self, fit: &SpecimenModelFit) -> Vec<(f64, f64)> {
        let columns = self.stacked(Motion::declared);
        let x = &columns[0];
        let on = fit.acts_on().declared;
        let mut force = vec![0.0; x.len()];
        add_scaled(&mut force, x, fit.declared[0]);
        for ((term, strengths), name) in fit.terms.iter().zip(&fit.strengths).zip(&fit.names) {
            if OF_A_SPRING.contains(&name.entry().family) {
                let row = &self.rows[term.row];
                let own = |m: &Motion| m.columns(row, term.shape, &self.sizes, &on, None);
                add_columns(&mut force, &self.stacked(own), strengths, 1.0);
            }
        }
        let step = difference(&x[1..], x);
        let least = LEAST_STEP * rms(std::slice::from_ref(&step));
        let rise = difference(&force[1..], &force);
        let all = x.iter().zip(step).zip(rise);
        all.filter(|((_, dx), _)| dx.abs() > least)
            .map(|((x, dx), df)| (*x, df / dx))
            .collect()
    }

    /// Of the stiffness beyond a gap on both sides, the fraction that remains within it; 1 for a term that is no such gap.
    fn keeps_within_a_gap(&self, fit: &SpecimenModelFit, term: usize) -> f64 {
        let [gap, one_side, middle, _] = fit.terms[term].shape;
        if !self.is_knee(&fit.terms[term]) || one_side != 0.0 {
            return 1.0;
        }
        let slopes = self.local_stiffness(fit);
        let (within, beyond): (Vec<_>, Vec<_>) = slopes
            .into_iter()
            .partition(|(x, _)| (x - middle).abs() < gap);
        let [within, beyond] = [within, beyond].map(|all| {
            let mut slopes: Vec<f64> = all.into_iter().map(|s| s.1).collect();
            slopes.sort_by(f64::total_cmp);
            slopes.get(slopes.len() / 2).copied()
        });
        within.zip(beyond).map_or(1.0, |(w, b)| (w / b).abs())
    }

    /// A fit with the wrong stiffness under a name of its own; on a spring alone, a frame that gives way makes the same.
    fn with_wrong_stiffness(&self, fit: &SpecimenModelFit, softer: bool) -> Vec<SpecimenModelFit> {
        let is_stiffness = |r: &Row| matches!(r.form, Form::Parameter(0));
        let Some(row) = self.rows.iter().position(is_stiffness) else {
            return Vec::new();
        };
        let mut names = fit.names.clone();
        names.sort_by_key(|n| *n as usize);
        names.dedup();
        let mut families: Vec<Family> = names.iter().map(|n| n.entry().family).collect();
        let alone = price_of_many(&families);
        families.push(Family::Calibration);
        let price = price_of_many(&families) - alone + self.rows[row].price - A_PARAMETER;
        let mut names = vec![Effect::GainError];
        names.extend((softer && self.has_only(fit, 0)).then_some(Effect::RigCompliance));
        let of = |name| {
            let mut own = fit.clone();
            own.terms.push(Term {
                row,
                shape: [0.0; 4],
            });
            own.strengths.push(Vec::new());
            own.names.push(name);
            own.evidence.price += price;
            own
        };
        names.into_iter().map(of).collect()
    }
}
