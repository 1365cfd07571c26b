//! Many tests: the error over the values of a key, or over the drawn rigs.

use super::figures::Figures;
use super::section::TestSection;
use crate::document::plot::{
    Colour, Curve, FIFTH, FOURTH, HALF, TALL, TESTED, THIRD, WRONG, history, plot,
};
use crate::document::{Document, Grade, table};
use crate::many::{OneOfMany, Outcome, worst};
use experiment::Experiment;
use experiment::drawn::DrawnQuantity;
use experiment::numbers::{length, percent, percent_or_lost, three};
use experiment::summary::{GOOD_EPS_RMS, POOR_EPS_RMS, TestVerdict};

/// Colours of the compensations; more curves would hide each other.
const COLOURS: [Colour; 5] = [TESTED, WRONG, THIRD, FOURTH, FIFTH];
/// Errors below this are drawn at it.
const LEAST: f64 = 1e-6;
/// Dots of a page; where there are more, the best tests are thinned out.
const DOTS: usize = 12_000;

/// The error on a logarithmic axis of per cent: a lost test counts as 100 %.
fn on_axis(error: f64) -> f64 {
    error.clamp(LEAST, 1.0).log10()
}

/// Tests over the values of `path`; `first` is the first of them.
pub fn of_values(
    path: &str,
    rows: &[OneOfMany],
    compensations: &[&'static str],
    first: &Experiment,
    with_page: bool,
) -> Document {
    let lead = format!(
        "{} tests: each value on each ground motion under each compensation, judged by the same integration with an ideal \
         actuator.",
        rows.len()
    );
    let mut d = Document::new(format!("One test over {path}"), lead, with_page);
    let mut values: Vec<f64> = rows.iter().map(|r| r.value).collect();
    values.dedup();
    d.on_page(|d| usable(d, rows, &values, compensations));
    d.heading("The error");
    d.figure(
        "The worst of the ground motions. A test that tripped or ran away counts as 100 %; an error below 0.0001 % is drawn there.",
        || {
            let curve = |(name, colour): (&&'static str, Colour)| {
                let point = |v: &f64| Some((*v, on_axis(worst(rows, name, *v)?)));
                Curve::new(colour, values.iter().filter_map(point).collect()).named(name)
            };
            let curves: Vec<Curve> = compensations.iter().zip(COLOURS).map(curve).collect();
            plot(TALL.of_percent(), path, "eps_rms [%]", &curves)
        },
    );
    let key = path.rsplit('.').next().unwrap_or(path);
    let mut t = table(&[&[key, "ideal peak"], compensations].concat());
    for value in values {
        let own = rows.iter().filter(|r| r.value == value);
        let peak_m = own.map(|r| r.ideal_peak_m).fold(0.0, f64::max);
        let errors = compensations.iter().map(|name| worst(rows, name, value));
        let errors = errors.map(|e| e.map_or_else(String::new, percent_or_lost));
        t.add_row(
            [value.to_string(), length(peak_m)]
                .into_iter()
                .chain(errors),
        );
    }
    d.table(t);
    d.items(vec![
        "eps_rms (Eq 18) of each compensation, and the largest ideal peak; of several ground motions the worst. `lost`: the test \
         tripped or ran away."
            .into(),
    ]);
    d.heading("Every test");
    d.on_page(|d| {
        let head = [
            path,
            "ground motion",
            "compensation",
            "verdict",
            "eps_rms",
            "peak",
            "ideal peak",
        ];
        let row = |r: &OneOfMany| {
            vec![
                r.value.to_string(),
                r.summary.record.clone(),
                r.summary.compensation.to_owned(),
                r.summary.verdict.name().to_owned(),
                percent_or_lost(r.summary.error()),
                length(r.summary.peak_displacement_m),
                length(r.ideal_peak_m),
            ]
        };
        d.table(table(&head).with_rows(rows.iter().map(row)));
    });
    d.test_file(&first.test.text);
    d
}

/// How many values each compensation is usable at.
fn usable(d: &mut Document, rows: &[OneOfMany], values: &[f64], compensations: &[&'static str]) {
    for name in compensations {
        let at_most = |most: f64| {
            let good = |v: &&f64| worst(rows, name, **v).is_some_and(|e| e <= most);
            values.iter().filter(good).count()
        };
        let (fine, usable) = (at_most(GOOD_EPS_RMS), at_most(POOR_EPS_RMS));
        let grade = match (fine == values.len(), usable == values.len()) {
            (true, _) => Grade::Good,
            (_, true) => Grade::Fair,
            _ => Grade::Bad,
        };
        d.verdict(
            grade,
            format!(
                "**{name}**: an error of at most {} at {fine} of {} values, at most {} at {usable}.",
                percent(GOOD_EPS_RMS),
                values.len(),
                percent(POOR_EPS_RMS),
            ),
        );
    }
}

/// Tests on drawn rigs.
#[derive(Clone, Copy, Debug)]
pub struct Drawn<'a> {
    /// What they came to.
    pub outcome: &'a Outcome,
    /// What of the rigs was drawn.
    pub quantities: &'a [DrawnQuantity],
    /// Each test.
    pub rows: &'a [OneOfMany],
    /// The factors of its rig, as many as there are quantities.
    pub factors: &'a [Vec<f64>],
}

/// Tests on drawn rigs; `worst`: the worst of them again, with the factors of its rig, for the page.
pub fn of_rigs(drawn: &Drawn<'_>, worst: Option<(&[f64], TestSection<'_>)>) -> Document {
    let Drawn { outcome, rows, .. } = *drawn;
    let title = format!("One test on {} rigs", rows.len());
    let lead = format!(
        "{}, compensation **{}**, on rigs that are not quite the declared one. Each is judged by the same integration with an \
         ideal actuator on the same specimen.",
        rows.first().map_or("", |r| r.summary.record.as_str()),
        outcome.compensation
    );
    let mut d = Document::new(title, lead, worst.is_some());
    d.on_page(|d| rigs_verdict(d, outcome));
    d.heading("The error");
    let mut t = table(&[
        "compensation",
        "tests",
        "completed",
        "eps_rms, median",
        "95 %",
        "worst",
    ]);
    t.add_row([
        outcome.compensation.to_owned(),
        outcome.tests.to_string(),
        outcome.completed.to_string(),
        percent_or_lost(outcome.eps_rms_median),
        percent_or_lost(outcome.eps_rms_95),
        percent_or_lost(outcome.eps_rms_worst),
    ]);
    d.table(t);
    d.items(vec![format!(
        "{} tests on {} threads in {:.1} s: {:.0} tests and {:.2} million control steps a second.",
        outcome.tests,
        outcome.threads,
        outcome.wall_s,
        outcome.tests_per_s,
        outcome.control_steps_per_s * 1e-6
    )]);
    let caption = "What share of the tests stays below which error. A test that tripped or ran away counts as 100 %.";
    d.figure(caption, || {
        let mut errors: Vec<f64> = rows.iter().map(|r| r.summary.error()).collect();
        errors.sort_by(f64::total_cmp);
        let share = |i: usize| 100.0 * (i as f64 + 0.5) / errors.len() as f64;
        let points = history(errors.len(), |i| (share(i), on_axis(errors[i])));
        let curve = [Curve::new(TESTED, points)];
        let below = "tests, the best first [%]";
        plot(TALL.of_percent(), below, "eps_rms [%]", &curve)
    });
    d.heading("Over what was drawn");
    over_the_rigs(&mut d, drawn);
    if let Some((factors, section)) = worst {
        d.heading("The worst of them");
        let named = drawn.quantities.iter().zip(factors);
        let factors = named.map(|(q, factor)| vec![q.name.clone(), three(*factor)]);
        d.on_page(|d| d.table(table(&["of the declared", "factor"]).with_rows(factors)));
        let caption = "Over the response of the same rig with an ideal actuator.";
        Figures::of(&section).response(&mut d, caption);
        d.test_file(&section.experiment.test.text);
    }
    d
}

fn rigs_verdict(d: &mut Document, o: &Outcome) {
    let grade = match o.eps_rms_95 {
        e if e <= GOOD_EPS_RMS && o.completed == o.tests => Grade::Good,
        e if e <= POOR_EPS_RMS => Grade::Fair,
        _ => Grade::Bad,
    };
    let most = if o.eps_rms_95.is_finite() {
        format!(
            "95 % of the rigs have an error of at most **{}** rms, the worst {}.",
            percent(o.eps_rms_95),
            percent_or_lost(o.eps_rms_worst)
        )
    } else {
        "On more than one rig in twenty it tripped or ran away.".into()
    };
    let (completed, tests) = (o.completed, o.tests);
    d.verdict(
        grade,
        format!("{completed} of {tests} tests ran to their end. {most}"),
    );
}

/// The error over each of what was drawn.
fn over_the_rigs(d: &mut Document, drawn: &Drawn<'_>) {
    let Drawn {
        quantities,
        rows,
        factors,
        ..
    } = *drawn;
    let error = |i: &usize| rows[*i].summary.error();
    let mut order: Vec<usize> = (0..rows.len()).collect();
    order.sort_by(|a, b| error(b).total_cmp(&error(a)));
    let half = DOTS / 2 / quantities.len().max(1);
    let (worst, rest) = order.split_at(order.len().min(half));
    let stride = rest.len().div_ceil(half.max(1)).max(1);
    let shown: Vec<usize> = worst
        .iter()
        .chain(rest.iter().step_by(stride))
        .copied()
        .collect();
    let dots = |colour: Colour, quantity: usize, lost: bool| {
        let of = |i: &&usize| (rows[**i].summary.verdict != TestVerdict::Completed) == lost;
        let points = shown.iter().filter(of);
        let points = points.map(|i| (factors[*i][quantity], on_axis(error(i))));
        Curve::new(colour, points.collect()).dots()
    };
    d.pair(|d| {
        for (i, quantity) in quantities.iter().enumerate() {
            let deviation = percent(quantity.deviation);
            let caption = format!("A dot a test; standard deviation {deviation}.");
            d.figure(caption, || {
                let curves = [
                    dots(TESTED, i, false).named("ran to its end"),
                    dots(WRONG, i, true).named("tripped or ran away"),
                ];
                let label = format!("{}, of the declared [1]", quantity.name);
                plot(HALF.of_percent(), &label, "eps_rms [%]", &curves)
            });
        }
    });
}
