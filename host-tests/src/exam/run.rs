//! Runs an examinee through a plan.

use super::answer::Answer;
use super::grade::{Grade, grade};
use super::plan::Item;
use exam::reliability::Stated;
use exam::{ChannelKey, Key, Paper, set};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// A record that has been answered and graded.
#[derive(Clone, Debug)]
pub struct GradedRecord {
    /// Which.
    pub item: Item,
    /// Its key.
    pub key: Key,
    /// The answer, or the sentence with which the examinee gave up.
    pub answer: Result<Answer, String>,
    /// The grade; giving up counts as a channel that was not assessed.
    pub grade: Grade,
    /// Time of one core for the answer, s.
    pub seconds: f64,
}

impl GradedRecord {
    /// The probability stated of each name, and whether that name is hidden in its channel.
    pub fn stated(&self) -> Vec<Stated> {
        let Ok(answer) = &self.answer else {
            return Vec::new();
        };
        let of = |key: &ChannelKey| -> Vec<Stated> {
            let is = |name: &str| key.hidden.iter().any(|h| h.name == name);
            let channel = answer.channel(key.channel.name());
            let stated = channel.stated();
            stated.into_iter().map(|(name, p)| (p, is(name))).collect()
        };
        self.key.channels.iter().flat_map(of).collect()
    }
}

/// Sets every record, has it answered and grades it; `done` is called with each. A record has one core to itself, so
/// that its time does not depend on the others.
///
/// # Errors
/// A sentence: a thread could not be created, or a worker panicked.
pub fn run_exam(
    items: &[Item],
    examinee: impl Fn(&Item, &Paper) -> Result<Answer, String> + Sync,
    done: impl Fn(&GradedRecord) + Sync,
) -> Result<Vec<GradedRecord>, String> {
    let cores = std::thread::available_parallelism().map_or(1, |n| n.get());
    let next = AtomicUsize::new(0);
    let work = || -> Result<Vec<(usize, GradedRecord)>, String> {
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let alone = alone.map_err(|e| format!("no thread for the exam: {e}"))?;
        let mut own = Vec::new();
        while let Some((i, item)) = {
            let i = next.fetch_add(1, Ordering::Relaxed);
            items.get(i).map(|item| (i, item))
        } {
            let one = alone.install(|| answered(item, &examinee));
            done(&one);
            own.push((i, one));
        }
        Ok(own)
    };
    let mut all = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        let mut all = Vec::new();
        for worker in workers {
            let part = worker.join();
            all.extend(part.map_err(|_| "a worker of the exam panicked".to_string())??);
        }
        Ok::<_, String>(all)
    })?;
    all.sort_by_key(|(i, _)| *i);
    Ok(all.into_iter().map(|(_, graded)| graded).collect())
}

fn answered(
    item: &Item,
    examinee: &impl Fn(&Item, &Paper) -> Result<Answer, String>,
) -> GradedRecord {
    let case = set(item.class, item.seed, &item.options());
    let start = Clock::now();
    let answer = examinee(item, &case.paper);
    let seconds = start.seconds();
    let silence = Answer::default();
    let grade = grade(&case.key, answer.as_ref().unwrap_or(&silence));
    GradedRecord {
        item: *item,
        key: case.key,
        answer,
        grade,
        seconds,
    }
}

/// Time of this thread on a core, so that other load of the machine does not count; wall time if the system does not report it.
struct Clock {
    wall: Instant,
    core_s: Option<f64>,
}

impl Clock {
    fn now() -> Self {
        Self {
            wall: Instant::now(),
            core_s: core_s(),
        }
    }

    fn seconds(&self) -> f64 {
        match (core_s(), self.core_s) {
            (Some(now), Some(then)) => now - then,
            _ => self.wall.elapsed().as_secs_f64(),
        }
    }
}

fn core_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(1e-9 * nanoseconds)
}
