//! The report of a sweep: the error over the key, the fragility curves, every test.

use super::figures::figure;
use super::page::{escape, page, test_file};
use super::plot::{self, Colour, Curve, FIFTH, FOURTH, GROUND, TALL, TESTED, THIRD, WRONG};
use super::rths::table;
use crate::sweep::{self, Fragility, SweepResult};
use experiment::Experiment;
use experiment::numbers::{length, percent, percent_or_lost};
use experiment::summary::{GOOD_EPS_RMS, POOR_EPS_RMS};

/// Curves of compensations; more would hide each other.
const COLOURS: [Colour; 5] = [TESTED, WRONG, THIRD, FOURTH, FIFTH];
/// Errors below this are drawn at it.
const LEAST: f64 = 1e-6;
/// Points of a drawn distribution.
const POINTS: usize = 200;

/// The report of a sweep that began with the test `first`.
pub fn of_sweep(s: &SweepResult<'_>, first: &Experiment) -> String {
    let mut names: Vec<&'static str> = s.rows.iter().map(|r| r.summary.compensation).collect();
    names.sort_unstable();
    names.dedup();
    let body = [
        verdict(s, &names),
        errors(s, &names),
        fragility(s),
        "<h2>Every test</h2>".into(),
        rows(s),
        test_file(&first.test.text),
    ]
    .concat();
    let title = format!("One test over {}", s.path);
    let lead = format!(
        "{} tests: each value on each ground motion under each compensation, judged by the same integration with an ideal \
         actuator.",
        s.rows.len()
    );
    page(&title, &lead, &body)
}

fn values(s: &SweepResult<'_>) -> Vec<f64> {
    let mut values: Vec<f64> = s.rows.iter().map(|r| r.value).collect();
    values.dedup();
    values
}

/// Up to where each compensation is usable.
fn verdict(s: &SweepResult<'_>, names: &[&'static str]) -> String {
    let values = values(s);
    let good = |name: &str, value: f64, most: f64| {
        sweep::worst(s.rows, name, value).is_some_and(|e| e <= most)
    };
    let lines = names.iter().map(|name| {
        let usable = values.iter().filter(|v| good(name, **v, POOR_EPS_RMS)).count();
        let fine = values.iter().filter(|v| good(name, **v, GOOD_EPS_RMS)).count();
        let class = match (fine == values.len(), usable == values.len()) {
            (true, _) => "good",
            (_, true) => "fair",
            _ => "bad",
        };
        format!(
            "<p class=\"verdict {class}\"><b>{name}</b>: an error of at most {} at {fine} of {} values, at most {} at {usable}.</p>",
            percent(GOOD_EPS_RMS),
            values.len(),
            percent(POOR_EPS_RMS),
        )
    });
    lines.collect()
}

fn errors(s: &SweepResult<'_>, names: &[&'static str]) -> String {
    let values = values(s);
    let curve = |(name, colour): (&&'static str, Colour)| {
        let point = |v: &f64| {
            let error = sweep::worst(s.rows, name, *v)?;
            Some((*v, error.clamp(LEAST, 1.0).log10()))
        };
        Curve::new(colour, values.iter().filter_map(point).collect()).named(name)
    };
    let curves: Vec<Curve> = names.iter().zip(COLOURS).map(curve).collect();
    let svg = plot::plot(TALL.of_percent(), s.path, "eps_rms [%]", &curves);
    format!(
        "<h2>The error</h2>{}",
        figure(
            &svg,
            "The worst of the ground motions. A test that tripped or ran away counts as 100 %; an error below 0.0001 % is \
             drawn there."
        )
    )
}

fn fragility(s: &SweepResult<'_>) -> String {
    let Some(mm) = s.limit_mm else {
        return String::new();
    };
    let (Some(low), Some(high)) = (values(s).first().copied(), values(s).last().copied()) else {
        return String::new();
    };
    let mut curves = Vec::new();
    for (f, colour) in s.fragility.iter().zip([GROUND].into_iter().chain(COLOURS)) {
        let counted = f.shares.iter();
        let counted = counted.map(|c| (c.value, 100.0 * c.beyond as f64 / c.of as f64));
        curves.push(Curve::new(colour, counted.collect()).dots());
        if let Some(l) = f.fit {
            let at = |i: usize| low + (high - low) * i as f64 / (POINTS - 1) as f64;
            let point = |i: usize| (at(i), 100.0 * l.at(at(i).max(1e-9)));
            curves.push(Curve::new(colour, (0..POINTS).map(point).collect()).named(f.of));
        }
    }
    let svg = plot::plot(TALL, s.path, "ground motions beyond the limit [%]", &curves);
    let line = |f: &Fragility| vec![f.of.to_owned(), escape(&f.in_words())];
    format!(
        "<h2>Where a floor moves further than {}</h2>{}{}",
        length(1e-3 * mm),
        figure(
            &svg,
            "Dots: counted. Lines: lognormal distributions of greatest likelihood (Baker 2015). `ideal` is the structure on \
             an ideal rig; the distance to it is what the test makes of its fragility. A test that tripped or ran away \
             counts as beyond."
        ),
        table(&["of", "lognormal"], s.fragility.iter().map(line))
    )
}

fn rows(s: &SweepResult<'_>) -> String {
    let head = [
        s.path,
        "ground motion",
        "compensation",
        "verdict",
        "eps_rms",
        "peak",
        "ideal peak",
    ];
    let line = |r: &sweep::swept_test::SweptTest| {
        vec![
            r.value.to_string(),
            escape(&r.summary.record),
            r.summary.compensation.to_owned(),
            r.summary.verdict.name().to_owned(),
            percent_or_lost(r.summary.error()),
            length(r.summary.peak_displacement_m),
            length(r.ideal_peak_m),
        ]
    };
    table(&head, s.rows.iter().map(line))
}
