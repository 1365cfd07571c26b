//! The targets, and by how much they are reached or missed.

use super::Row;
use serde::Serialize;

/// Targets, per cent: J2 and J4 of the nominal plant, J4 of the worst perturbed one.
pub const TARGETS: [f64; 3] = [2.0, 3.0, 10.0];

/// The worst of one controller over all cases and records, per cent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst {
    /// Its name.
    pub controller: &'static str,
    /// J2 as read.
    pub j2: f64,
    /// J2 without the sensor's noise.
    pub j2_without_noise: f64,
    /// J2 of the noise alone, which nobody can be better than.
    pub j2_of_noise: f64,
    /// J4 as read.
    pub j4: f64,
    /// J4 without the sensor's noise.
    pub j4_without_noise: f64,
    /// J4 of the worst perturbed plant against the structure with its own specimen.
    pub j4_own_perturbed: f64,
    /// J4 of the worst perturbed plant against the nominal structure.
    pub j4_perturbed: f64,
    /// The same of a controller without any error.
    pub j4_perturbed_perfect: f64,
    /// Perturbed plants that were lost.
    pub lost: usize,
}

impl Worst {
    /// Of each controller, in the order in which they come.
    pub fn of(rows: &[Row]) -> Vec<Self> {
        let mut names: Vec<&'static str> = Vec::new();
        for row in rows {
            if !names.contains(&row.controller) {
                names.push(row.controller);
            }
        }
        names
            .iter()
            .map(|name| Self::of_controller(rows, name))
            .collect()
    }

    fn of_controller(rows: &[Row], controller: &'static str) -> Self {
        let own = || rows.iter().filter(|r| r.controller == controller);
        let worst = |value: fn(&Row) -> f64| own().map(value).fold(0.0, f64::max);
        Self {
            controller,
            j2: worst(|r| r.j[1]),
            j2_without_noise: worst(|r| r.j_without_noise[1]),
            j2_of_noise: worst(|r| r.j2_of_noise),
            j4: worst(|r| r.j[3]),
            j4_without_noise: worst(|r| r.j_without_noise[3]),
            j4_own_perturbed: worst(|r| r.perturbed.j4_own_worst),
            j4_perturbed: worst(|r| r.perturbed.j4_worst),
            j4_perturbed_perfect: worst(|r| r.perturbed.j4_worst_perfect),
            lost: own().map(|r| r.perturbed.lost).sum(),
        }
    }

    /// The three targets in a sentence each.
    pub fn sentences(&self) -> Vec<String> {
        let [j2, j4, perturbed] = TARGETS;
        let said = |value: f64, target: f64| {
            if value <= target {
                "reached".to_owned()
            } else {
                format!("missed by {:.2} points", value - target)
            }
        };
        vec![
            format!(
                "J2 at most {j2:.0} %: {:.2} % without the sensor's noise, {}; {:.2} % as read, {}. The noise alone is \
                 {:.2} % of the motion under the weakest record, which no controller can be better than.",
                self.j2_without_noise,
                said(self.j2_without_noise, j2),
                self.j2,
                said(self.j2, j2),
                self.j2_of_noise,
            ),
            format!(
                "J4 at most {j4:.0} % on the nominal plant: {:.2} % without the sensor's noise, {}; {:.2} % as read, {}.",
                self.j4_without_noise,
                said(self.j4_without_noise, j4),
                self.j4,
                said(self.j4, j4),
            ),
            format!(
                "J4 below {perturbed:.0} % on the worst perturbed plant: {:.2} % against the structure with the specimen \
                 that was tested, {}; {:.2} % against the structure with the nominal specimen, {}, where a controller \
                 without any error has {:.2} %: the stiffness of the specimen is perturbed, and the true response with it.",
                self.j4_own_perturbed,
                said(self.j4_own_perturbed, perturbed),
                self.j4_perturbed,
                said(self.j4_perturbed, perturbed),
                self.j4_perturbed_perfect,
            ),
        ]
    }
}

/// What to know beside any of these figures.
pub const CAUTION: &str = "Real rigs are reported to be 3 to 5 times worse than this virtual one.";
