//! Rows as cells, for the terminal and for the report.

use super::bench::LOST_PERCENT;
use super::{Row, verdict::Worst};

/// Head of the table of one ground motion.
pub const HEAD: [&str; 17] = [
    "case",
    "controller",
    "J1",
    "J2",
    "J2*",
    "J3",
    "J4",
    "J4*",
    "J5",
    "J6",
    "J7",
    "J8",
    "J9",
    "J2* worst",
    "J4 worst",
    "own worst",
    "lost",
];

/// What the head means.
pub const LEGEND: &str = "J1 in ms, J2 to J9 in per cent on the nominal plant; * without the sensor's noise; worst: of \
                          the perturbed plants; own: J4 against the structure with the specimen of the plant; lost: \
                          J4 of 100 % or more, or tripped";

/// A number of at most four letters.
pub fn number(x: f64) -> String {
    match x {
        x if x >= 10.0 * LOST_PERCENT => "lost".into(),
        x if x.abs() >= 100.0 => format!("{x:.0}"),
        x => format!("{x:.1}"),
    }
}

/// The cells of a row, under [`HEAD`].
pub fn cells(row: &Row) -> Vec<String> {
    let mut cells = vec![row.case.to_string(), row.controller.to_owned()];
    for (i, j) in row.j.iter().enumerate() {
        cells.push(number(*j));
        if i == 1 || i == 3 {
            cells.push(number(row.j_without_noise[i]));
        }
    }
    let p = &row.perturbed;
    if p.plants == 0 {
        cells.extend(std::iter::repeat_n("-".to_owned(), 4));
    } else {
        cells.extend([p.j2_worst, p.j4_worst, p.j4_own_worst].map(number));
        cells.push(format!("{}/{}", p.lost, p.plants));
    }
    cells
}

/// Head of the table of the worst.
pub const WORST_HEAD: [&str; 8] = [
    "controller",
    "J2",
    "J2*",
    "J4",
    "J4*",
    "J4 perturbed",
    "own",
    "lost",
];

/// The cells of a controller's worst, under [`WORST_HEAD`].
pub fn worst_cells(w: &Worst) -> Vec<String> {
    let mut cells = vec![w.controller.to_owned()];
    cells.extend(
        [
            w.j2,
            w.j2_without_noise,
            w.j4,
            w.j4_without_noise,
            w.j4_perturbed,
            w.j4_own_perturbed,
        ]
        .map(number),
    );
    cells.push(w.lost.to_string());
    cells
}
