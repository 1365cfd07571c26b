//! Whether the error that a diagnosis predicts for held-out data is the actual one: pairs from open records and from simulated
//! rigs.

use crate::exam::examinee;
use crate::outside::Case;
use diagnosis::ChannelAnswer;
use exam::{Class, Options};

/// A predicted interval and the actual error.
#[derive(Clone, Debug)]
pub struct Pair {
    /// The record, and what it was trained on.
    pub name: String,
    /// 90 % interval of the rms.
    pub foretold: [f64; 2],
    /// rms on the held-out data.
    pub came: f64,
}

impl Pair {
    /// True if the actual error lies inside.
    pub fn holds(&self) -> bool {
        (self.foretold[0]..=self.foretold[1]).contains(&self.came)
    }

    fn of(name: String, a: &ChannelAnswer) -> Option<Self> {
        Some(Self {
            name,
            foretold: a.next_error_ci90?,
            came: a.error_after.test_rms,
        })
    }
}

/// The pairs of an open record: as given, with training and test data exchanged, and with either half of the training data.
pub fn of_case(case: &Case) -> Vec<Pair> {
    let [train, test] = case.spans();
    let halves = |spans: &[String]| -> Option<[Vec<String>; 2]> {
        let [only] = spans else { return None };
        let (file, span) = only.split_once('@')?;
        let (from, to) = span.split_once("..")?;
        let (from, to): (f64, f64) = (from.parse().ok()?, to.parse().ok()?);
        let middle = 0.5 * (from + to);
        Some([
            vec![format!("{file}@{from}..{middle}")],
            vec![format!("{file}@{middle}..{to}")],
        ])
    };
    let mut all = vec![
        ("as given", train.to_vec(), test.to_vec()),
        ("the other way round", test.to_vec(), train.to_vec()),
    ];
    if let Some([first, second]) = halves(train) {
        all.push(("first half", first, test.to_vec()));
        all.push(("second half", second, test.to_vec()));
    }
    all.into_iter()
        .filter_map(|(how, train, test)| {
            let (answer, _) = case.between(&train, &test).ok()?;
            Pair::of(format!("{}, {how}", case.id), &answer)
        })
        .collect()
}

/// The pairs of a simulated rig of the exam; its two records have different excitations.
pub fn of_rig(class: Class, seed: u64) -> Vec<Pair> {
    let case = exam::set(class, seed, &Options::default());
    let Ok(found) = examinee::found(&case.paper) else {
        return Vec::new();
    };
    let pair = |a: &ChannelAnswer| Pair::of(format!("{}, {}", case.id, a.channel.name()), a);
    found.channels.iter().filter_map(pair).collect()
}
