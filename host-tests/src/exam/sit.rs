//! An examinee works through a plan.

use super::answer::Answer;
use super::grade::{Grade, grade};
use super::plan::Item;
use exam::{Key, Paper, set};
use rayon::prelude::*;
use std::time::Instant;

/// A record that has been answered and graded.
#[derive(Clone, Debug)]
pub struct Sat {
    /// Which.
    pub item: Item,
    /// Its key.
    pub key: Key,
    /// What was answered; none where the examinee gave up with this sentence.
    pub answer: Result<Answer, String>,
    /// The grade; giving up counts as a channel that was not assessed.
    pub grade: Grade,
    /// Wall time of the answer, s; with every core busy on another record.
    pub seconds: f64,
}

/// Sets every record, has it answered and grades it; `done` is called with each.
pub fn sit(
    items: &[Item],
    examinee: impl Fn(&Item, &Paper) -> Result<Answer, String> + Sync,
    done: impl Fn(&Sat) + Sync,
) -> Vec<Sat> {
    items
        .par_iter()
        .map(|item| {
            let case = set(item.class, item.seed, &item.options());
            let start = Instant::now();
            let answer = examinee(item, &case.paper);
            let seconds = start.elapsed().as_secs_f64();
            let silence = Answer::default();
            let grade = grade(&case.key, answer.as_ref().unwrap_or(&silence));
            let sat = Sat {
                item: *item,
                key: case.key,
                answer,
                grade,
                seconds,
            };
            done(&sat);
            sat
        })
        .collect()
}
