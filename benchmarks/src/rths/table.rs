//! Rows as cells, for the terminal and for reports.

use super::bench::{LOST_PERCENT, RthsRow};

/// The rows of one ground motion after another, with the motion's name.
pub fn by_record(rows: &[RthsRow]) -> impl Iterator<Item = (&str, &[RthsRow])> {
    let groups = rows.chunk_by(|a, b| a.record == b.record);
    groups.map(|group| (group[0].record.as_str(), group))
}

/// Header of the summary of one ground motion: one row for each controller, with cases 1 to 4 side by side. A specimen that
/// yields has one more column.
pub fn summary_head(rows: &[RthsRow]) -> Vec<&'static str> {
    let yields = rows.iter().any(|r| r.energy_error.is_some());
    let mut head = SUMMARY_HEAD.to_vec();
    if yields {
        head.push("energy");
    }
    head
}

const SUMMARY_HEAD: [&str; 7] = ["controller", "J2", "J2*", "J4", "J4*", "J4 worst", "lost"];

/// The meaning of the summary's header.
pub const SUMMARY_LEGEND: &str = "Per cent, cases 1/2/3/4. J2: tracking error; J4: error of the specimen's floor \
    against the reference structure (standard deviations). As read, the noise of the sensor counts in; * is the \
    displacement as it was. Worst: of the perturbed plants, as read. Lost: J4 of 100 % or more, of all \
    perturbed plants; in a cell, a figure of 1000 % or more. Energy: error of what a yielding specimen has taken in the end";

/// Header of the table for specimens that yield.
pub const YIELDING_HEAD: [&str; 7] = [
    "controller",
    "degrading: J2*",
    "J4*",
    "energy",
    "pinched: J2*",
    "J4*",
    "energy",
];

/// Its meaning.
pub const YIELDING_LEGEND: &str = "Specimens that yield, nominal plant, per cent, the largest of cases 1 to 4. Degrading: \
    loses stiffness and strength; pinched: slips around zero beside that. Energy: error of what the specimen has taken in \
    the end";

/// The table of one ground motion for both specimens that yield, with one row for each controller.
pub fn yielding_summary(degrading: &[RthsRow], pinched: &[RthsRow]) -> Vec<Vec<String>> {
    let figures: [fn(&RthsRow) -> f64; 3] = [
        |r| r.j2_true,
        |r| r.j4_true,
        // A row without it does not belong to a specimen that yields.
        |r| r.energy_error.unwrap_or(f64::INFINITY),
    ];
    names(degrading)
        .into_iter()
        .map(|name| {
            let mut row = vec![name.to_owned()];
            for rows in [degrading, pinched] {
                for figure in figures {
                    let own = rows.iter().filter(|r| r.controller == name).map(figure);
                    row.push(number(own.fold(0.0, f64::max)));
                }
            }
            row
        })
        .collect()
}

/// Each controller once, in the order of the rows.
pub(super) fn names(rows: &[RthsRow]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for row in rows {
        if !names.contains(&row.controller.as_str()) {
            names.push(&row.controller);
        }
    }
    names
}

/// Header of the table with all criteria.
pub const HEAD: [&str; 17] = [
    "case",
    "controller",
    "knows",
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
    "J4 worst",
    "J4* worst",
    "lost",
];

/// A number of at most five characters.
pub fn number(x: f64) -> String {
    match x {
        x if x >= 10.0 * LOST_PERCENT || x.is_nan() => "lost".into(),
        x if x.abs() >= 100.0 => format!("{x:.0}"),
        x if x.abs() >= 10.0 => format!("{x:.1}"),
        x => format!("{x:.2}"),
    }
}

/// The summary of one ground motion: first the noise alone, then one row for each controller.
pub fn summary(rows: &[RthsRow]) -> Vec<Vec<String>> {
    let names = names(rows);
    let own =
        |name: &str| -> Vec<&RthsRow> { rows.iter().filter(|r| r.controller == name).collect() };
    let join = |rows: &[&RthsRow], figure: &dyn Fn(&RthsRow) -> f64| {
        let cells: Vec<_> = rows.iter().map(|r| number(figure(r))).collect();
        cells.join("/")
    };
    let mut cells = Vec::new();
    if let Some(first) = names.first() {
        let rows = own(first);
        let floor = |i: usize| join(&rows, &move |r: &RthsRow| r.floor[i]);
        let none = || String::from("0");
        cells.push(vec![
            "(the noise alone)".into(),
            floor(1),
            none(),
            floor(3),
            none(),
            floor(3),
            String::new(),
        ]);
    }
    for name in names {
        let rows = own(name);
        let perturbed: usize = rows.iter().map(|r| r.perturbed).sum();
        let (worst, lost) = if perturbed == 0 {
            ("-".to_owned(), "-".to_owned())
        } else {
            let lost: usize = rows.iter().map(|r| r.lost).sum();
            (join(&rows, &|r| r.j4_worst), format!("{lost}/{perturbed}"))
        };
        let mut row = vec![
            name.to_owned(),
            join(&rows, &|r| r.j[1]),
            join(&rows, &|r| r.j2_true),
            join(&rows, &|r| r.j[3]),
            join(&rows, &|r| r.j4_true),
            worst,
            lost,
        ];
        if rows.iter().any(|r| r.energy_error.is_some()) {
            row.push(join(&rows, &|r| r.energy_error.unwrap_or(0.0)));
        }
        cells.push(row);
    }
    cells
}

/// The cells of a row, under [`HEAD`].
pub fn cells(row: &RthsRow) -> Vec<String> {
    let mut cells = vec![
        row.case.to_string(),
        row.controller.clone(),
        row.prior_knowledge.to_owned(),
    ];
    for (i, j) in row.j.iter().enumerate() {
        cells.push(number(*j));
        match i {
            1 => cells.push(number(row.j2_true)),
            3 => cells.push(number(row.j4_true)),
            _ => {}
        }
    }
    if row.perturbed == 0 {
        cells.extend(std::iter::repeat_n("-".to_owned(), 3));
    } else {
        cells.extend([row.j4_worst, row.j4_true_worst].map(number));
        cells.push(format!("{}/{}", row.lost, row.perturbed));
    }
    cells
}

/// The cells of the noise alone in the case of `row`, under [`HEAD`].
pub fn floor_cells(row: &RthsRow) -> Vec<String> {
    let mut cells = vec![
        row.case.to_string(),
        "(the noise alone)".into(),
        String::new(),
    ];
    for (i, floor) in row.floor.iter().enumerate() {
        cells.push(if i == 0 { "-".into() } else { number(*floor) });
        if i == 1 || i == 3 {
            cells.push(number(0.0));
        }
    }
    cells.extend(std::iter::repeat_n(String::new(), 3));
    cells
}
