//! A specimen's motion as the model of its actuator tells it: better than a reading, where that has more than the motion or less.

use super::channel::ChannelDiagnosis;
use super::found::while_moving;
use crate::criteria::NOISE;
use crate::model::Model;
use crate::model::answer::{ChannelAnswer, Verdict};
use crate::numbers::signals::{end_of, mean};
use crate::record::recording::Recording;
use plant::Channel;

impl ChannelDiagnosis<'_> {
    /// Judges a specimen that is `unknown` by the motion that the model of its actuator tells, where that leaves no more than noise of the
    /// reading. Damping and mass feel what noise hides: a corner where friction lets go, a play that is crossed.
    pub(super) fn judge_as_driven(
        &self,
        answer: &mut ChannelAnswer,
        actuator: Option<&ChannelAnswer>,
        improved: &mut Model,
    ) {
        if self.base.channel != Channel::Specimen || answer.verdict != Verdict::Unknown {
            return;
        }
        let Some(actuator) = actuator.filter(|a| a.channel == Channel::Actuator) else {
            return;
        };
        let known = matches!(actuator.verdict, Verdict::None | Verdict::Effect);
        let most = NOISE * actuator.noise_floor_rms;
        let [train, test] = [self.train, self.test];
        let left = [
            (train, &actuator.residuals[0]),
            (test, &actuator.residuals[1]),
        ];
        if !known
            || left
                .iter()
                .any(|(set, left)| while_moving(left, set) > most)
        {
            return;
        }
        let [train, test] = left.map(|(set, left)| driven(set, left));
        let (Some(train), Some(test)) = (train, test) else {
            return;
        };
        let rest: Vec<Recording> = self.rest.iter().map(standing).collect();
        let own = ChannelDiagnosis {
            base: self.base.clone(),
            train: &train,
            test: &test,
            rest: &rest,
        };
        let mut with = improved.clone();
        let mut again = own.judge(&mut with);
        own.doubt_none(&mut again);
        if again.verdict == Verdict::Unknown || again.verdict == Verdict::NotAssessed {
            return;
        }
        again.notes.push(
            "The displacement is what the model of the actuator makes of the command: its reading differs from that by no more than \
             noise, and hides what damping and mass feel."
                .into(),
        );
        (*answer, *improved) = (again, with);
    }
}

/// A record in which nothing moves, without the noise of its displacement.
fn standing(r: &Recording) -> Recording {
    let still = |x: &Vec<f64>| vec![mean(x); x.len()];
    Recording {
        displacement_mm: r.displacement_mm.as_ref().map(still),
        ..r.clone()
    }
}

/// Records with the displacement that a model of the actuator leaves of its reading.
fn driven(records: &[Recording], left: &[Vec<f64>]) -> Option<Vec<Recording>> {
    let one = |(r, left): (&Recording, &Vec<f64>)| {
        let mut x = r.displacement_mm.clone()?;
        let from = x.len() - end_of(&x, left.len()).len();
        x[from..].iter_mut().zip(left).for_each(|(x, e)| *x -= e);
        Some(Recording {
            displacement_mm: Some(x),
            ..r.clone()
        })
    };
    records.iter().zip(left).map(one).collect()
}
