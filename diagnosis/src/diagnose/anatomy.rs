//! What the rest of a channel depends on.

use super::Channelled;
use crate::answer::{ChannelAnswer, Errors};
use crate::foretold::next_error;
use crate::problem::rms;
use crate::recording::Recording;
use crate::remainder::{Moves, anatomy, correction, rms_with};
use plant::Channel;

impl Channelled<'_> {
    /// Adds the anatomy of what a model leaves to an answer, record by record of training and test. A rest may be shorter
    /// than its record: it lacks the first samples then.
    pub(super) fn look_at_the_rest(
        &self,
        answer: &mut ChannelAnswer,
        train: &[Vec<f64>],
        test: &[Vec<f64>],
    ) {
        let answers = |records, rests| self.model_answers(records, rests);
        if let (Some(learned), Some(planned)) =
            (answers(self.train, train), answers(self.test, test))
        {
            answer.next_error_ci90 = Some(next_error(train, &learned, &planned));
        }
        let learned = self.moves(self.train, train);
        let judged = self.moves(self.test, test);
        if let (Some(learned), Some(judged)) = (learned, judged) {
            let found = anatomy(&learned, &judged);
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

    /// What a model answers to records of which it leaves these rests.
    fn model_answers(&self, records: &[Recording], rests: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
        let answer = |(r, rest): (&Recording, &Vec<f64>)| {
            let target = self.target_of(r)?;
            let judged = &target[target.len() - rest.len()..];
            Some(judged.iter().zip(rest).map(|(t, r)| t - r).collect())
        };
        records.iter().zip(rests).map(answer).collect()
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
