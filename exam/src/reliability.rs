//! Whether stated probabilities are true: how often a name is in the rig, by the probability stated for it.

use std::fmt::Write as _;

/// A stated probability, and whether what it was stated of is so.
pub type Stated = (f64, bool);

/// Bounds of the classes of stated probabilities.
const BOUNDS: [f64; 7] = [0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0];

/// One class of stated probabilities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Class {
    /// Its bounds; the lower one is outside.
    pub ends: [f64; 2],
    /// Number of names.
    pub names: usize,
    /// Mean of the probabilities stated.
    pub stated: f64,
    /// Share of the names that are in the rig.
    pub is: f64,
}

/// The classes that have names.
pub fn classes(stated: &[Stated]) -> Vec<Class> {
    let all = BOUNDS.windows(2).filter_map(|ends| {
        let own = stated.iter().filter(|s| s.0 > ends[0] && s.0 <= ends[1]);
        let own: Vec<&Stated> = own.collect();
        let mean =
            |of: fn(&Stated) -> f64| own.iter().map(|s| of(s)).sum::<f64>() / own.len() as f64;
        (!own.is_empty()).then(|| Class {
            ends: [ends[0], ends[1]],
            names: own.len(),
            stated: mean(|s| s.0),
            is: mean(|s| f64::from(u8::from(s.1))),
        })
    });
    all.collect()
}

/// The classes as a table in Markdown.
pub fn table(stated: &[Stated]) -> String {
    let mut text = String::from(
        "| probability stated | names | mean of it | in the rig |\n|---|---|---|---|\n",
    );
    for c in classes(stated) {
        let [low, high] = c.ends;
        let _ = writeln!(
            text,
            "| {low} to {high} | {} | {:.2} | {:.2} |",
            c.names, c.stated, c.is
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_counted_by_the_probability_stated_of_them() {
        let stated = [(0.2, false), (0.3, true), (0.95, true)];
        let all = classes(&stated);
        assert_eq!(all.len(), 2);
        assert_eq!((all[0].names, all[0].is), (2, 0.5));
        assert!((all[0].stated - 0.25).abs() < 1e-12);
        assert!(table(&stated).contains("| 0.9 to 1 | 1 | 0.95 | 1.00 |"));
    }
}
