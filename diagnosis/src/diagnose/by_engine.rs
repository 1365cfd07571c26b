//! Turns the engine's result for a channel into an answer.

use super::channel::ChannelDiagnosis;
use super::decision::{Confirmed, proposed};
use super::heard::Heard;
use crate::criteria::{DISPLACEMENT_TRANSDUCER, TRANSDUCER};
use crate::engine::drivetrain::without_known as without_known_motion;
use crate::engine::{self, ActuatorChannel, Asked, Found, KnownNoise, Said, SpecimenData};
use crate::model::Model;
use crate::model::answer::{Errors, FoundEffect, Traces, Verdict};
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
pub(super) type Left = [Vec<Vec<f64>>; 2];

/// Size of a residual: rms, and as a fraction of the output.
#[derive(Clone, Copy)]
struct Share {
    rms: f64,
    nrmse: f64,
}

/// A channel's data in the engine, and its records without the contribution of effects already in the model.
pub(super) struct ChannelData<'a, A> {
    pub data: &'a A,
    bare: [&'a [Recording]; 2],
    pub noise: Noise,
    /// True if a rest determines the noise.
    pub told: bool,
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

    pub fn left(&self, fit: &A::Fit) -> Option<Left> {
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

impl ChannelDiagnosis<'_> {
    /// Result of the engine for a specimen; `None` if a signal is missing or the noise cannot be determined.
    pub(super) fn specimen_by_engine(&self, model: &Model) -> Option<Heard> {
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
        self.answer_of(&channel, &found, model)
    }

    /// Result of the engine for an actuator.
    pub(super) fn actuator_by_engine(&self, noise: Noise, model: &Model) -> Option<Heard> {
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
        self.answer_of(&channel, &found, model)
    }

    /// The answer on what the engine found in a channel. Training data propose, held-out data judge.
    fn answer_of<A: Asked>(
        &self,
        channel: &ChannelData<A>,
        found: &Found<A::Fit>,
        model: &Model,
    ) -> Option<Heard> {
        let declared = channel.data.settled(&found.declared);
        let before = channel.left(&declared)?;
        let unnamed = self.share(&channel.left(&found.nothing)?[0], self.train);
        let sags = found.unnamed.is_some_and(|p| p >= engine::SURE)
            && self.base.channel == Channel::Actuator;
        // In a sound ram the supply does not sag.
        let sound =
            channel.is_ordinary(unnamed) && !(sags && matches!(found.said, Said::Unknown(_)));
        let trained = self.share(&before[0], self.train);
        let proposed = proposed(
            &found.said,
            sound || channel.is_of_its_class(&found.said, trained),
        );

        let mut answer = self.blank(Verdict::None);
        answer.unnamed = found.unnamed;
        answer.error_before = self.errors_left(&before);
        answer.error_after = answer.error_before;
        answer.refitted = advice::refitted(&self.base, &channel.data.declared(&declared));
        answer.noise_floor_rms = channel.noise.rms.min(answer.error_before.test_rms);
        let higher_order = || channel.data.is_of_higher_order(&found.nothing);
        let said_nothing = matches!(found.said, Said::Nothing);
        answer.ordinary = sound && (!said_nothing || higher_order());

        let tried = proposed.and_then(|said| self.tried(channel, said, &before));
        let (kept, near) = match tried {
            Some(tried) if tried.confirmed => (Some(tried), None),
            near => (None, near),
        };
        let mut with = model.clone();
        let confirmed = kept.as_ref().map(|kept| {
            answer.noise_floor_rms = answer.noise_floor_rms.min(kept.errors.test_rms);
            answer.refitted = advice::refitted(&self.base, &channel.data.declared(&kept.fit));
            answer.improvement_ci90 = kept.gain;
            answer.error_after = kept.errors;
            channel.data.save(&kept.fit, &mut with);
            let figures = channel.data.figures(&kept.fit).into_iter();
            Confirmed {
                accounts: kept.accounts,
                trust: kept.trust,
                effects: figures
                    .map(|(name, own)| FoundEffect::new(name, own))
                    .collect(),
            }
        });
        let left = kept.map_or_else(|| before.clone(), |kept| kept.left);
        let mut steps = None;
        if proposed.is_none() {
            steps = self.steps(&self.noise(self.cutoff_hz())?);
        } else if !channel.told {
            // Report the output's own noise, read where the best model leaves little else; for `none`, the residual.
            let own = self.own_noise(&left[0], PASSES * channel.cutoff_hz);
            let felt = &mut answer.noise_floor_rms;
            *felt = own.map_or(*felt, |own| own.min(*felt));
        }
        answer.traces = self.engine_traces(&before[1], &left[1]);
        answer.residuals = left;
        let mut heard = self.heard(answer, proposed, confirmed, steps, [model, &with]);
        if let (Some(near), Verdict::Unknown) = (near, heard.found) {
            let name = found.said.likeliest().unwrap_or(Effect::Offset);
            heard.answer.nearest = Some(self.nearest(name, channel.data, &near, &before, model));
        }
        if sags && proposed.is_some() && heard.found == Verdict::Unknown {
            heard.answer.notes.push(SAGS.into());
        }
        Some(heard)
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
    pub(super) fn errors_left(&self, [train, test]: &Left) -> Errors {
        let test = self.share(test, self.test);
        Errors {
            train_nrmse: self.share(train, self.train).nrmse,
            test_nrmse: test.nrmse,
            test_rms: test.rms,
        }
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
