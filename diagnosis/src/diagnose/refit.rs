//! Declared parameters in an answer: the residual of the model as declared, intervals of refitted parameters, what is
//! saved of them, and the probability of each name.

use super::channel::ChannelDiagnosis;
use crate::criteria::REACH;
use crate::model::Model;
use crate::model::answer::{ChannelAnswer, Errors, Refitted, Verdict};
use crate::model::interval;
use crate::model::interval::NINETY;
use crate::model::saved_element::SavedElement;
use crate::numbers::signals::{end_of, nrmse, rms};
use crate::prepare::advice::four;
use crate::prepare::problem::Problem;
use plant::{Channel, EffectSpec};

/// A refit whose held-out residual exceeds that of the declared values by this fraction is not saved.
const WORSE: f64 = 0.01;
/// Least saved tolerance, as a fraction of the declared one.
const LEAST_TOLERANCE: f64 = 0.1;

/// Errors of the declared channel with the parameters of two problems.
fn errors(train: &Problem, test: &Problem) -> Errors {
    let of = |problem: &Problem| {
        let left = problem.residuals();
        let targets = problem.segments.iter().map(|s| s.seen(&s.target));
        (
            nrmse(&left, &targets.collect::<Vec<_>>().concat()),
            rms(&left),
        )
    };
    let ((train_nrmse, _), (test_nrmse, test_rms)) = (of(train), of(test));
    Errors {
        train_nrmse,
        test_nrmse,
        test_rms,
    }
}

impl ChannelDiagnosis<'_> {
    /// Training and held-out records with the declared parameters; `None` if a signal is missing.
    fn as_declared(&self) -> Option<[Problem; 2]> {
        let cutoff_hz = self.cutoff_hz();
        let [train, test] = [self.train, self.test].map(|set| self.problem(set, cutoff_hz));
        Some([train?, test?])
    }

    /// Residual of the declared channel on the held-out records, rms; `None` if a signal is missing.
    pub(super) fn declared_leaves(&self) -> Option<f64> {
        let [train, test] = self.as_declared()?;
        Some(errors(&train, &test).test_rms)
    }

    /// Reports the errors of the model as declared and the intervals of its refitted parameters, and saves those.
    pub(super) fn state_refit(&self, answer: &mut ChannelAnswer, improved: &mut Model) {
        if answer.verdict == Verdict::NotAssessed {
            return;
        }
        let Some([mut train, mut test]) = self.as_declared() else {
            return;
        };
        answer.error_declared = errors(&train, &test);
        let mut theta = self.base.values;
        for r in &answer.refitted {
            theta[self.place_of(r)] = r.value;
        }
        train.set(&self.base, theta);
        test.set(&self.base, theta);
        self.state_intervals(answer, &train);
        let declared = answer.error_declared.test_rms;
        let refitted = errors(&train, &test).test_rms;
        let nothing_added = answer.effects.is_empty();
        if nothing_added && refitted > (1.0 + WORSE) * declared {
            answer.notes.push(format!(
                "The parameters refitted to the training data leave {} {unit} rms of the held-out data, as declared they leave {} \
                 {unit}: the declared values are kept.",
                four(refitted),
                four(declared),
                unit = answer.unit
            ));
            return;
        }
        self.save_refit(answer, improved);
    }

    /// Index among the channel's parameters.
    fn place_of(&self, r: &Refitted) -> usize {
        let mut all = self.base.channel.parameters().iter();
        all.position(|p| p.name == r.name).unwrap_or_default()
    }

    /// Intervals of the refitted parameters, from how far blocks of the residual pull them and from their tolerance.
    fn state_intervals(&self, answer: &mut ChannelAnswer, train: &Problem) {
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); self.base.free.len()];
        let mut left = Vec::new();
        for (segment, residual) in train.segments.iter().zip(&answer.residuals[0]) {
            let judged = residual.len().min(segment.seen(&segment.target).len());
            left.extend_from_slice(end_of(residual, judged));
            let own = train.base_columns(&self.base, segment);
            for (all, column) in columns.iter_mut().zip(&own) {
                all.extend_from_slice(end_of(column, judged));
            }
        }
        let spread = interval::by_blocks(&columns, &left, train.scales.interval_s);
        let free = self.base.free.iter().zip(&spread);
        for (r, (f, sigma)) in answer.refitted.iter_mut().zip(free) {
            // Two independent sources.
            let both = 1.0 / (sigma.powi(-2) + f.tolerance.powi(-2)).sqrt();
            r.ci90 = [r.value - NINETY * both, r.value + NINETY * both];
        }
    }

    /// Writes the refit into the saved model, unless something was added: an addition has its own. A tolerance ends
    /// where the declared one ends, so that a parameter does not drift over repeated diagnoses.
    fn save_refit(&self, answer: &ChannelAnswer, improved: &mut Model) {
        let Some((places, _)) = improved.channel_mut(self.base.channel) else {
            return;
        };
        for r in &answer.refitted {
            let Some(place) = places[self.place_of(r)].as_mut() else {
                continue;
            };
            if answer.effects.is_empty() {
                place.value = r.value;
            }
            if place.tolerance == r.tolerance {
                let moved = (place.value - r.declared).abs();
                let reach = r.tolerance - moved / REACH;
                place.tolerance = reach.max(LEAST_TOLERANCE * r.tolerance);
            }
        }
    }

    /// Writes the nearest candidate into the saved model, disabled, so that it can be tried.
    pub(super) fn save_nearest(&self, answer: &ChannelAnswer, improved: &mut Model) {
        let unknown = answer.verdict == Verdict::Unknown;
        let Some(nearest) = answer.nearest.as_ref().filter(|_| unknown) else {
            return;
        };
        if let Some((_, effects)) = improved.channel_mut(self.base.channel) {
            let names = nearest.effects.iter().map(|e| e.name).collect::<Vec<_>>();
            effects.retain(|old| old.enabled || !names.contains(&old.name));
            let off = nearest.effects.iter().cloned();
            effects.extend(off.map(|e| EffectSpec {
                enabled: false,
                ..e
            }));
        }
        if let (Channel::Specimen, Some(specimen)) = (self.base.channel, &mut improved.specimen) {
            // Those of an earlier record may differ.
            specimen.elements.retain(|old| old.enabled);
            let off = nearest.elements.iter().cloned();
            let off = off.map(|e| SavedElement {
                enabled: false,
                ..e
            });
            specimen.elements.extend(off);
        }
    }
}
