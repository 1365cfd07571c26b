//! Turns the engine's result for a channel into an answer.

use super::channel::ChannelDiagnosis;
use super::found::while_moving;
use crate::criteria::{
    ACCOUNTS, BESIDE_NOISE, DISPLACEMENT_TRANSDUCER, NOISE, SET_LEAVES, TRANSDUCER, WORTH_A_NAME,
};
use crate::engine::drivetrain::without_known as without_known_motion;
use crate::engine::{
    self, ActuatorChannel, Asked, Candidate, Found, KnownNoise, Named, Said, SpecimenData,
};
use crate::model::Model;
use crate::model::answer::{ChannelAnswer, Errors, FoundEffect, Member, Nearest, Traces, Verdict};
use crate::model::interval;
use crate::numbers::signals::{end_of, nrmse, rms};
use crate::prepare::advice;
use crate::prepare::known::without_known;
use crate::prepare::noise::hum::without_hum;
use crate::prepare::noise::{Noise, NoiseSource};
use crate::record::recording::Recording;
use plant::{Channel, Effect};

/// Multiple of its cut-off beyond which the displacement's low-pass passes nothing.
const PASSES: f64 = 1.3;

/// Residuals of a model on training and held-out records.
type Left = [Vec<Vec<f64>>; 2];

/// Size of a residual: rms, and as a fraction of the output.
#[derive(Clone, Copy)]
struct Share {
    rms: f64,
    nrmse: f64,
}

/// A channel's data in the engine, and its records without the contribution of effects already in the model.
struct ChannelData<'a, A> {
    data: &'a A,
    bare: [&'a [Recording]; 2],
    noise: Noise,
    /// True if a rest determines the noise.
    told: bool,
    /// Cut-off of the displacement, Hz.
    cutoff_hz: f64,
    /// A residual below this fraction of the output is within the class of a good transducer. A sure name is still
    /// given there if a rest shows that the residual is not noise.
    transducer: f64,
    /// Fraction of the output that any device of its kind leaves of a model with the usual parts.
    ordinary: f64,
}

/// Note for an unnamed cause in an actuator.
const SAGS: &str = "The ram is slower for some tenths of a second after it has moved fast, as where the supply's pressure sags: look at the \
                    accumulator, the pump and the pressure at the valve.";

impl<A: Asked> ChannelData<'_, A> {
    /// True if the residual of the declared model is too small for any name: within the class of a good transducer.
    fn is_of_its_class(&self, said: &Said<A::Fit>, left: Share) -> bool {
        left.nrmse < self.transducer && !(self.told && matches!(said, Said::Names(_)))
    }

    /// True if the residual, less the noise if a rest determines it, is no more than any device of its kind leaves.
    fn is_ordinary(&self, left: Share) -> bool {
        let noise = if self.told { self.noise.rms } else { 0.0 };
        left.nrmse * (1.0 - (noise / left.rms).powi(2)).max(0.0).sqrt() < self.ordinary
    }

    fn left(&self, fit: &A::Fit) -> Option<Left> {
        let [train, test] = self.bare;
        Some([
            self.data.residuals(fit, train)?,
            self.data.residuals(fit, test)?,
        ])
    }
}

/// Records without mains hum in their displacement: it is picked up by the cable and moves nothing.
pub(super) fn without_mains(records: &[Recording]) -> Vec<Recording> {
    let quiet = |r: &Recording| Recording {
        displacement_mm: r.displacement_mm.as_ref().map(|x| without_hum(x, r)),
        ..r.clone()
    };
    records.iter().map(quiet).collect()
}

/// Names for the answer, with the model that contains them.
struct Given<'a, F> {
    candidate: &'a Candidate<F>,
    names: &'a [(Effect, f64)],
    is_set: bool,
}

impl<'a, F> Given<'a, F> {
    fn new(candidate: &'a Candidate<F>, names: &'a [(Effect, f64)], is_set: bool) -> Self {
        Self {
            candidate,
            names,
            is_set,
        }
    }
}

impl ChannelDiagnosis<'_> {
    /// Result of the engine for a specimen; `None` if a signal is missing or the noise cannot be determined.
    pub(super) fn specimen_by_engine(&self, improved: &mut Model) -> Option<ChannelAnswer> {
        let [train, test] = [self.train, self.test].map(without_mains);
        let train = without_known(&self.base, &train)?;
        let test = without_known(&self.base, &test)?;
        let mut data = SpecimenData::new(&self.base, &train)?;
        let half_rate = 0.5 / self.train[0].interval_s();
        let search = |data: &mut SpecimenData, before| {
            let noise = self.noise(data.cutoff_hz.min(half_rate))?;
            let known = KnownNoise {
                variance: noise.variance_of_means(data.every),
                told: noise.from == NoiseSource::Rest,
            };
            Some((engine::specimen(data, known, before)?, noise))
        };
        let (mut found, mut noise) = search(&mut data, None)?;
        // What is missing hides how fast the rig moves; what was found shows it.
        let elsewhere = |fit| Some((fit, data.cut_off_elsewhere(fit)?));
        if let Some((fit, mut again)) = found.leading().and_then(elsewhere)
            && let Some(second) = search(&mut again, Some(fit))
        {
            (found, noise) = second;
            data = again;
        }
        let told = noise.from == NoiseSource::Rest;
        let channel = ChannelData {
            data: &data,
            bare: [&train, &test],
            noise,
            told,
            cutoff_hz: data.cutoff_hz,
            transducer: TRANSDUCER,
            ordinary: self.base.ordinary(),
        };
        self.answer_of(&channel, &found, improved)
    }

    /// Result of the engine for an actuator.
    pub(super) fn actuator_by_engine(
        &self,
        noise: Noise,
        improved: &mut Model,
    ) -> Option<ChannelAnswer> {
        let [train, test] =
            [self.train, self.test].map(|records| without_known_motion(&self.base, records));
        let (train, test) = (train?, test?);
        let data = ActuatorChannel::new(&self.base, &train)?;
        let told = noise.from == NoiseSource::Rest;
        let [averages, samples] = [data.every, 1].map(|every| KnownNoise {
            variance: noise.variance_of_means(every),
            told,
        });
        let found = engine::actuator(&data, averages, samples)?;
        let channel = ChannelData {
            data: &data,
            bare: [&train, &test],
            noise,
            told,
            cutoff_hz: self.cutoff_hz(),
            transducer: DISPLACEMENT_TRANSDUCER,
            ordinary: self.base.ordinary(),
        };
        self.answer_of(&channel, &found, improved)
    }

    /// Turns what was found in a channel into an answer.
    fn answer_of<A: Asked>(
        &self,
        channel: &ChannelData<A>,
        found: &Found<A::Fit>,
        improved: &mut Model,
    ) -> Option<ChannelAnswer> {
        let declared = channel.data.settled(&found.declared);
        let before = channel.left(&declared)?;
        // The training residual decides which names are given; held-out data judge them.
        let trained = self.share(&before[0], self.train);
        let mut answer = self.blank(Verdict::None);
        answer.error_before = self.errors_left(&before);
        answer.error_after = answer.error_before;
        answer.refitted = advice::refitted(&self.base, &channel.data.declared(&declared));
        answer.noise_floor_rms = channel.noise.rms.min(answer.error_before.test_rms);
        let mut after = None;
        let plain = self.share(&channel.left(&found.nothing)?[0], self.train);
        let is_ordinary = channel.is_ordinary(plain);
        let sags = found.unnamed.is_some_and(|p| p >= engine::SURE);
        match &found.said {
            Said::Nothing => {
                answer.ordinary = is_ordinary && channel.data.is_of_higher_order(&found.nothing);
            }
            // In a sound ram the supply does not sag.
            said if is_ordinary && !(sags && matches!(said, Said::Unknown(_))) => {
                answer.ordinary = true;
            }
            said if channel.is_of_its_class(said, trained) => {}
            Said::Names(n) => {
                let named = Given::new(&n.model, &n.names, false);
                after = self.take_named(&mut answer, channel, &before, named, improved);
                if after.is_some() {
                    self.say_beside(&mut answer, n);
                }
            }
            Said::Set(c, names) => {
                let named = Given::new(c, names, true);
                after = self.take_named(&mut answer, channel, &before, named, improved);
            }
            Said::Unknown(likeliest) => {
                answer.verdict = Verdict::Unknown;
                if let Some(c) = likeliest {
                    let fit = channel.data.settled(&c.model);
                    let [_, left] = channel.left(&fit)?;
                    let name = c.names.first().copied().unwrap_or(Effect::Offset);
                    answer.nearest =
                        Some(self.nearest(name, channel.data, &fit, [&before[1], &left], improved));
                }
            }
        }
        answer.unnamed = found.unnamed;
        let kept = after.as_ref().unwrap_or(&before);
        if answer.verdict == Verdict::None {
            self.quantisation(&self.noise(self.cutoff_hz())?, &mut answer);
        } else if !channel.told {
            // Report the output's own noise, read where the best model leaves little else; for `none`, the residual.
            let own = self.own_noise(&kept[0], PASSES * channel.cutoff_hz);
            let felt = &mut answer.noise_floor_rms;
            *felt = own.map_or(*felt, |own| own.min(*felt));
        }
        answer.notes = advice::engine(&answer);
        if sags && answer.verdict == Verdict::Unknown && self.base.channel == Channel::Actuator {
            answer.notes.push(SAGS.into());
        }
        answer.traces = self.engine_traces(&before[1], &kept[1]);
        answer.residuals = kept.clone();
        Some(answer)
    }

    /// Size of residuals, which may be shorter than their records if the first samples only settled the model.
    fn share(&self, left: &[Vec<f64>], records: &[Recording]) -> Share {
        let own = records.iter().zip(left);
        let judged = own.filter_map(|(r, left)| Some(end_of(self.target_of(r)?, left.len())));
        Share {
            rms: rms(left),
            nrmse: nrmse(left, &judged.collect::<Vec<_>>().concat()),
        }
    }

    /// Errors from a model's residuals on training and held-out records.
    fn errors_left(&self, [train, test]: &Left) -> Errors {
        let test = self.share(test, self.test);
        Errors {
            train_nrmse: self.share(train, self.train).nrmse,
            test_nrmse: test.nrmse,
            test_rms: test.rms,
        }
    }

    /// Puts names into the answer and their model into `improved`, if the held-out data confirm them; returns the
    /// residuals. Held-out data judge the choice; they do not make it.
    fn take_named<A: Asked>(
        &self,
        answer: &mut ChannelAnswer,
        channel: &ChannelData<A>,
        before: &Left,
        Given {
            candidate,
            names,
            is_set,
        }: Given<A::Fit>,
        improved: &mut Model,
    ) -> Option<Left> {
        let fit = &channel.data.settled(&candidate.model);
        let after = channel.left(fit)?;
        let errors = self.errors_left(&after);
        let gain = interval::improvement(&before[1], &after[1], self.train[0].interval_s());
        // A model that does not reach the noise must explain most: a law not in the table may be the cause.
        let most = if candidate.evidence.left_rms() < 1.0 {
            1.0 - WORTH_A_NAME
        } else {
            SET_LEAVES
        };
        // Without the noise, if a rest determines it.
        let noise = if channel.told { channel.noise.rms } else { 0.0 };
        let beyond = |rms: f64| (rms * rms - noise * noise).max(0.0).sqrt();
        let left = self.without_refit_of(&candidate.names, answer.error_before.test_rms);
        let [had, has] = [left, errors.test_rms].map(beyond);
        // Held-out data that have died down to the noise are evidence neither way.
        if had.max(has) > 0.0 && (has > most * had || gain[0] <= 0.0 && !is_set) {
            answer.verdict = Verdict::Unknown;
            let left = [&before[1][..], &after[1]];
            answer.nearest = Some(self.nearest(names[0].0, channel.data, fit, left, improved));
            return None;
        }
        answer.noise_floor_rms = answer.noise_floor_rms.min(errors.test_rms);
        let trust = engine::trust(&candidate.evidence);
        let of = |(name, values): (Effect, Vec<_>)| {
            let sure = names.iter().find(|n| n.0 == name);
            FoundEffect {
                q: sure.filter(|_| !is_set).map(|s| 1.0 - trust * s.1.min(1.0)),
                ..FoundEffect::new(name, values)
            }
        };
        answer.effects = channel.data.figures(fit).into_iter().map(of).collect();
        answer.refitted = advice::refitted(&self.base, &channel.data.declared(fit));
        answer.improvement_ci90 = gain;
        channel.data.save(fit, improved);
        if is_set {
            let member = |&(name, probability): &(Effect, f64)| Member { name, probability };
            answer.members = names.iter().map(member).collect();
            answer
                .effects
                .retain(|e| names.iter().any(|s| s.0 == e.name));
            let given = |name: &Effect| answer.effects.iter().any(|e| e.name == *name);
            let others = names.iter().map(|s| s.0).filter(|n| !given(n));
            answer.alternatives = others.collect();
            answer.verdict = Verdict::Ambiguous;
        } else {
            let felt = answer.noise_floor_rms;
            let share = ACCOUNTS * while_moving(&before[0], self.train);
            let known = if channel.told {
                BESIDE_NOISE
            } else {
                f64::INFINITY
            };
            let most = share.min(known * felt).max(NOISE * felt);
            let only = candidate.names.len() == names.len();
            answer.verdict = if while_moving(&after[0], self.train) <= most && only {
                Verdict::Effect
            } else {
                Verdict::Partial
            };
        }
        answer.error_after = errors;
        Some(after)
    }

    /// Held-out rms error, the baseline for a model of these names. If one of them is an error of a declared parameter,
    /// the refit within the tolerances has already taken part of it, so the declared model counts.
    fn without_refit_of(&self, names: &[Effect], refitted: f64) -> f64 {
        let parameters = self.base.channel.parameters();
        let is_error = |name: &Effect| parameters.iter().any(|p| p.error == *name);
        let declared = names.iter().any(is_error).then(|| self.declared_leaves());
        declared.flatten().map_or(refitted, |d| d.max(refitted))
    }

    /// A model that was not confirmed, and the fraction of the held-out squares that it explains.
    fn nearest<A: Asked>(
        &self,
        name: Effect,
        data: &A,
        fit: &A::Fit,
        [before, after]: [&[Vec<f64>]; 2],
        model: &Model,
    ) -> Nearest {
        let share = rms(after) / rms(before).max(f64::MIN_POSITIVE);
        let mut model = model.bare(self.base.channel);
        data.save(fit, &mut model);
        // Do not save an inadmissible model: a saved file must be readable again.
        let own = model.channel(self.base.channel);
        let own = own.filter(|_| model.check().is_ok());
        Nearest {
            name,
            explained: (1.0 - share * share).clamp(0.0, 1.0),
            effects: own.as_ref().map_or(Vec::new(), |c| c.effects.to_vec()),
            elements: own.as_ref().map_or(Vec::new(), |c| c.elements.to_vec()),
        }
    }

    /// Adds what is still open besides sure names.
    fn say_beside<F>(&self, answer: &mut ChannelAnswer, named: &Named<F>) {
        let open = named.more && !named.lead && !named.beside.is_empty();
        if open {
            answer.verdict = Verdict::Ambiguous;
        } else {
            let sure = |e: &FoundEffect| named.names.iter().any(|n| n.0 == e.name);
            answer.effects.retain(sure);
        }
        if named.more && !open {
            answer.verdict = Verdict::Partial;
        }
        let member = |&(name, probability): &(Effect, f64)| Member { name, probability };
        for ((name, _), rivals) in named.names.iter().zip(&named.rivals) {
            let own = answer.effects.iter_mut().filter(|e| e.name == *name);
            own.for_each(|e| e.rivals = rivals.iter().map(member).collect());
        }
        let given = |name: Effect| answer.effects.iter().any(|e| e.name == name);
        let others = named.beside.iter().map(|n| n.0).filter(|n| !given(*n));
        answer.alternatives = others.collect();
        answer.members = named.beside.iter().map(member).collect();
    }

    fn engine_traces(&self, before: &[Vec<f64>], after: &[Vec<f64>]) -> Traces {
        let first = self.test.first().and_then(|r| {
            let (before, after) = (before.first()?, after.first()?);
            let judged = |x| end_of(x, before.len());
            let signals = [&r.time_s, self.input_of(r)?, self.target_of(r)?];
            Some(Traces::of(signals.map(|x| judged(x)), [before, after]))
        });
        first.unwrap_or_default()
    }
}
