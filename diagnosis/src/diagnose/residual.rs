//! The dependence of a channel's remaining error.

use super::channel::ChannelDiagnosis;
use super::decision::Forbids;
use super::heard::Heard;
use crate::criteria::{LINES, LITTLE, TRANSDUCER};
use crate::diagnose::expected_error::next_error;
use crate::diagnose::remainder::{
    Moves, anatomy, clock, correction, is_in, lines, rms_with, tones,
};
use crate::laws::specimen::figures::SLIDING;
use crate::model::answer::{ChannelAnswer, Errors, Line, Verdict};
use crate::numbers::coherence::linear_share;
use crate::numbers::signals::{difference, mean, rms};
use crate::prepare::advice::four;
use crate::record::recording::{Recording, range};
use crate::record::rest;
use plant::{Channel, Effect, Family};

/// Range of the mains line, Hz: an effect of its own.
const MAINS_HZ: std::ops::Range<f64> = 44.0..66.0;

/// Rms residual about its mean in a record's longest rest, and its lines there that are also in the measurement; `None`
/// if the record has no rest.
fn lines_at_rest(r: &Recording, rest: &[f64], measured: &[f64]) -> Option<(f64, Vec<Line>)> {
    // Its first samples may have been skipped.
    let skipped = r.time_s.len() - rest.len();
    let (from, end) = rest::spans(r).into_iter().max_by_key(|(a, b)| b - a)?;
    let part = from.saturating_sub(skipped)..end.checked_sub(skipped)?;
    let about_mean = |x: &[f64]| {
        let mean = mean(x);
        x.iter().map(|x| x - mean).collect::<Vec<f64>>()
    };
    let still = about_mean(rest.get(part.clone())?);
    let read = about_mean(measured.get(part)?);
    let mut found = tones(&still, r.interval_s());
    found.retain(|l| is_in(l, &read, r.interval_s()));
    found.iter_mut().for_each(|l| l.at_rest = true);
    Some((rms(&[still]), found))
}

/// Each line with its frequency and its amplitude, in words.
fn in_words(found: &[Line], unit: &str) -> Vec<String> {
    let words = |l: &Line| {
        let amplitude = four(std::f64::consts::SQRT_2 * l.rms);
        format!(
            "{:.3} Hz with an amplitude of {amplitude} {unit}",
            l.frequency_hz
        )
    };
    found.iter().map(words).collect()
}

/// Fraction of the squares contained in lines.
fn held(found: &[Line], whole: f64) -> f64 {
    let square: f64 = found.iter().map(|l| l.rms * l.rms).sum();
    square / (whole * whole).max(f64::MIN_POSITIVE)
}

/// Fraction of the whole residual that lines of a rest must contain to be worth a note.
const MATTERS: f64 = 0.02;
/// Fraction for them to be most of it.
const MOSTLY: f64 = 0.5;
/// Largest difference between readings of one line, in a rest of a second or two and in the whole record, Hz.
const SAME_HZ: f64 = 1.0;

/// Additional power of the motion with which an unnamed error may grow beyond the motion that was learned from: the
/// next terms of a force's series are its square and its cube.
const BEYOND: i32 = 2;

/// Factor on the predicted error because the planned response goes further than those learned from. If names account
/// for the record, the model extrapolates.
fn beyond(verdict: Verdict, learned: &[Vec<f64>], planned: &[Vec<f64>]) -> f64 {
    if matches!(verdict, Verdict::None | Verdict::Effect) {
        return 1.0;
    }
    let [learned, planned] = [learned, planned].map(|x| range(&x.concat()));
    (planned / learned.max(f64::MIN_POSITIVE))
        .max(1.0)
        .powi(BEYOND)
}

impl ChannelDiagnosis<'_> {
    /// Rms over the held-out data of a friction that sticks in their rests: it holds any force up to its own, as left
    /// by the last motions, which are smaller than the noise.
    fn may_stick(&self, answer: &ChannelAnswer) -> f64 {
        let friction = answer
            .effects
            .iter()
            .filter(|e| e.family == Family::Friction);
        let forces = friction.flat_map(|e| e.parameters.iter());
        let forces = forces.filter(|p| p.name == SLIDING);
        let force = forces.map(|p| p.value.abs()).fold(0.0, f64::max);
        let whole: usize = self.test.iter().map(|r| r.time_s.len()).sum();
        let moving: usize = self.test.iter().map(|r| rest::moving(r).len()).sum();
        force * ((whole - moving) as f64 / whole.max(1) as f64).sqrt()
    }

    /// Adds the anatomy of a model's residual to an answer in which something is missing.
    pub(super) fn analyse_residual(&self, heard: &mut Heard) {
        let Heard {
            answer,
            found,
            lines,
            ..
        } = heard;
        if matches!(found, Verdict::None | Verdict::NotAssessed) {
            return;
        }
        let [train, test] = std::mem::take(&mut answer.residuals);
        self.add_anatomy(answer, *found, &train, &test);
        answer.residuals = [train, test];
        if let Some(r) = answer.remainder.as_mut().filter(|_| !lines.is_empty()) {
            r.lines = std::mem::take(lines);
        }
    }

    /// The same, by record of training and test. A residual may be shorter than its record, which then lacks its first
    /// samples.
    fn add_anatomy(
        &self,
        answer: &mut ChannelAnswer,
        verdict: Verdict,
        train: &[Vec<f64>],
        test: &[Vec<f64>],
    ) {
        let answers = |records, rests| self.model_answers(records, rests);
        if let (Some(learned), Some(planned)) =
            (answers(self.train, train), answers(self.test, test))
        {
            let [low, high] = next_error(train, &learned, &planned);
            let high = high * beyond(verdict, &learned, &planned);
            answer.next_error_ci90 = Some([low, high.hypot(self.may_stick(answer))]);
            let of = |records: &[Recording], answers: &[Vec<f64>], rests: &[Vec<f64>]| {
                let all = records.iter().zip(answers).zip(rests);
                let moves = all.filter_map(|((r, y), rest)| {
                    let skipped = r.time_s.len() - rest.len();
                    let input = self.input_of(r)?[skipped..].to_vec();
                    Some(Moves {
                        begin_s: r.time_s[skipped],
                        ..Moves::new(y, input, rest.clone(), r.interval_s())
                    })
                });
                moves.collect::<Vec<_>>()
            };
            let (of_train, of_test) = (
                of(self.train, &learned, train),
                of(self.test, &planned, test),
            );
            answer.notes.extend(self.other_clock(&of_train, &of_test));
        }
        let learned = self.moves(self.train, train);
        let judged = self.moves(self.test, test);
        if let (Some(learned), Some(judged)) = (learned, judged) {
            let mut found = anatomy(&learned, &judged);
            if let Some(r) = self.test.first() {
                let measured = self.target_of(r).map_or(&[][..], Vec::as_slice);
                found.lines.retain(|l| is_in(l, measured, r.interval_s()));
                // No motion of this rig shows what another axis does.
                answer.disturbed |= matches!(verdict, Verdict::Partial | Verdict::Unknown)
                    && held(&found.lines, rms(test)) > MOSTLY
                    && !self.hunts(r);
            }
            answer.correction = correction(&learned, &found);
            answer.error_with_remainder = answer.correction.as_ref().map(|c| {
                let shrinks = |moves: &[Moves], rests: &[Vec<f64>]| {
                    rms_with(c, moves) / rms(rests).max(f64::MIN_POSITIVE)
                };
                let (train, test) = (shrinks(&learned, train), shrinks(&judged, test));
                Errors {
                    train_nrmse: train * answer.error_after.train_nrmse,
                    test_nrmse: test * answer.error_after.test_nrmse,
                    test_rms: test * answer.error_after.test_rms,
                }
            });
            answer.remainder = Some(found);
        }
    }

    /// A residual that is speed times time: one clock runs faster or slower than the other.
    fn other_clock(&self, train: &[Moves], test: &[Moves]) -> Option<String> {
        let found = clock(train, test)?;
        let output = self.output();
        let (way, ms) = (
            if found.late > 0.0 { "late" } else { "early" },
            1e3 * found.at_the_end_s.abs(),
        );
        Some(format!(
            "{:.0} % of the squares of what is left are speed times time: the {output} comes more and more {way}, by {:.0} ppm \
             of the time, {ms:.1} ms at the end of the training data. The two loggers' clocks run at different rates: \
             record both channels by one clock, or stretch the time of one of them by that.",
            100.0 * found.share,
            1e6 * found.late.abs()
        ))
    }

    /// The name of the channel's output.
    fn output(&self) -> &'static str {
        match self.base.channel {
            Channel::Actuator => "displacement",
            Channel::Specimen => "force",
        }
    }

    /// Lines that are also present at rest are a disturbance whatever else is missing: reports their frequency and
    /// amplitude.
    pub(super) fn note_disturbances(&self, answer: &mut ChannelAnswer) {
        if matches!(answer.verdict, Verdict::None | Verdict::NotAssessed) {
            return;
        }
        let t = &answer.traces;
        let rest = difference(&t.measured, &t.after);
        let Some(r) = self.test.first().filter(|_| !rest.is_empty()) else {
            return;
        };
        // In the reading itself: what a model makes of its input's noise is a band, with a seeming line at its end.
        let Some((still, mut found)) = lines_at_rest(r, &t.measured, &t.measured) else {
            return;
        };
        if answer.effects.iter().any(|e| e.name == Effect::MainsHum) {
            found.retain(|l| !MAINS_HZ.contains(&l.frequency_hz));
        }
        let share = held(&found, rms(&[rest]));
        if held(&found, still) < LINES || share < MATTERS {
            return;
        }
        answer.disturbed |= share > MOSTLY && !self.hunts(r);
        let all = in_words(&found, &answer.unit);
        answer.notes.push(format!(
            "A disturbance of {} stands in the rest, too: the motion does not bring it about, and no element of a model of the motion \
             will take it. Look for a pump, a valve that hunts, a dither, another machine.",
            all.join(" and ")
        ));
        if let Some(anatomy) = &mut answer.remainder {
            let near = |a: &Line, b: &Line| {
                (a.frequency_hz - b.frequency_hz).abs() < a.width_hz.max(b.width_hz) + SAME_HZ
            };
            anatomy.lines.retain(|l| !found.iter().any(|f| near(l, f)));
            found.append(&mut anatomy.lines);
            anatomy.lines = found;
        }
    }

    /// A model's responses to records, from its residuals.
    fn model_answers(&self, records: &[Recording], rests: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
        let answer = |(r, rest): (&Recording, &Vec<f64>)| {
            let target = self.target_of(r)?;
            let judged = &target[target.len() - rest.len()..];
            Some(difference(judged, rest))
        };
        records.iter().zip(rests).map(answer).collect()
    }

    /// A residual with lines that the motion lacks is not noise, however little the motion causes it.
    pub(super) fn lines_in_place_of_noise(&self, answer: &ChannelAnswer) -> Option<Forbids> {
        let t = &answer.traces;
        let rest = difference(&t.measured, &t.before);
        if rest.is_empty() || answer.error_before.test_nrmse < TRANSDUCER {
            return None;
        }
        let r = self.test.first()?;
        let whole = rms(std::slice::from_ref(&rest));
        let mut found = lines(&rest, &t.input, r.interval_s());
        found.retain(|l| is_in(l, &t.measured, r.interval_s()));
        let mut noise_share = 1.0;
        if held(&found, whole) < LINES {
            // A motion of many frequencies has harmonics everywhere: then lines are only visible at rest.
            let (still, mut at_rest) = lines_at_rest(r, &rest, &t.measured)?;
            at_rest.retain(|l| !MAINS_HZ.contains(&l.frequency_hz));
            let share = held(&at_rest, still);
            if share < LINES {
                return None;
            }
            noise_share = (1.0 - share).max(0.0);
            found = at_rest;
        }
        let reason = format!(
            "What is left ({whole:.4} {} rms) is mostly lines that the motion does not have: {}. That is no noise, but a \
             disturbance: a pump, a valve that hunts, another axis; its cause is outside these channels.",
            answer.unit,
            in_words(&found, &answer.unit).join(", ")
        );
        Some(Forbids {
            reason,
            lines: found,
            noise_share,
        })
    }

    /// For an unknown cause, notes how much of the output is linear in its input at all: if that is little, no element
    /// of a model of this input will help.
    pub(super) fn note_low_coherence(&self, answer: &mut ChannelAnswer) {
        if answer.verdict != Verdict::Unknown {
            return;
        }
        let longest = self.train.iter().max_by_key(|r| r.time_s.len());
        let share = longest.and_then(|r| linear_share(self.input_of(r)?, self.target_of(r)?));
        let Some(share) = share.filter(|s| *s < LITTLE) else {
            return;
        };
        let [input, output] = match self.base.channel {
            Channel::Actuator => ["command", "displacement"],
            Channel::Specimen => ["displacement", "force"],
        };
        answer.notes.push(format!(
            "No linear model of the {input}, of whatever order, makes more than some {:.0} % of the squares of the \
             {output} (their coherence): the rest comes from an input that is not in the record, or from something \
             strongly nonlinear. Record what else acts on the rig.",
            100.0 * share
        ));
    }

    fn moves(&self, records: &[Recording], rests: &[Vec<f64>]) -> Option<Vec<Moves>> {
        records
            .iter()
            .zip(rests)
            .map(|(r, rest)| {
                let skipped = r.time_s.len() - rest.len();
                let other = match self.base.channel {
                    Channel::Actuator => &r.force_n,
                    Channel::Specimen => &r.command_mm,
                };
                let other = other
                    .as_ref()
                    .map_or_else(Vec::new, |o| o[skipped..].to_vec());
                let input = &self.input_of(r)?[skipped..];
                Some(Moves::new(input, other, rest.clone(), r.interval_s()))
            })
            .collect()
    }
}
