//! The report of two tests side by side.

use super::figures::figure;
use super::page::{escape, page};
use super::plot::{self, Curve, HALF, IDEAL, TALL, TESTED, WIDE, WRONG, history, path};
use super::rths::table;
use crate::archive::ArchivedTest;
use crate::difference::{ComparedMotion, Difference, plain_text};
use experiment::numbers::{si, three};

/// The report of the tests `pair`, which the files `names` hold.
pub fn of_difference(d: &Difference, pair: [&ArchivedTest; 2], names: &[String; 2]) -> String {
    let motions = pair.map(ComparedMotion::of);
    let floors = pair[0].repeat.config.degrees_of_freedom();
    let mut html = format!("<p><b>{}</b></p>", escape(&d.sentence()));
    for floor in 0..floors {
        html += &displacement(&motions, floor, floors);
    }
    for floor in 0..pair[0].repeat.config.physical_storeys() {
        html += &loops(&motions, floor);
    }
    html += &energy(&motions);
    html += &settings(d);
    html += "<h2>Figures</h2>";
    html += &table(
        &["figure", "first", "second"],
        d.figures.iter().map(|f| {
            let number = |v: &serde_json::Value| v.as_f64().map_or_else(|| plain_text(v), three);
            vec![f.key.to_owned(), number(&f.first), number(&f.second)]
        }),
    );
    html += "<h2>Channel by channel</h2>";
    html += &table(
        &[
            "channel",
            "peak of the first",
            "rms apart",
            "of the peak",
            "most",
            "at",
        ],
        d.channels.iter().map(|c| c.cells().to_vec()),
    );
    let lead = format!(
        "First: {}. Second: {}. Compared at the integration steps over {} of model time.",
        escape(&names[0]),
        escape(&names[1]),
        si(d.compared_s, "s")
    );
    page("Two tests side by side", &lead, &html)
}

/// The name of a channel of an axis, as `record.csv` has it.
fn named(quantity: &str, axis: usize, suffix: &str) -> String {
    match axis {
        0 => format!("{quantity}_{suffix}"),
        axis => format!("{quantity}{}_{suffix}", axis + 1),
    }
}

/// A channel of both tests over model time, times `factor`.
fn both(motions: &[ComparedMotion<'_>; 2], name: &str, factor: f64) -> [Vec<(f64, f64)>; 2] {
    [0, 1].map(|k| {
        let motion = &motions[k];
        let values = motion.channel(name);
        let times: Vec<f64> = motion.times().collect();
        history(times.len(), |i| {
            let value = motion.at(values, times[i]).unwrap_or(f64::NAN);
            (times[i], value * factor)
        })
    })
}

fn overlaid(motions: &[ComparedMotion<'_>; 2], name: &str, factor: f64) -> [Curve; 2] {
    let [first, second] = both(motions, name, factor);
    [
        Curve::new(IDEAL, first).named("first").thick(),
        Curve::new(TESTED, second).named("second"),
    ]
}

fn in_time(shape: plot::PlotShape, label: &str, curves: &[Curve], caption: &str) -> String {
    figure(&plot::plot(shape, "model time [s]", label, curves), caption)
}

fn displacement(motions: &[ComparedMotion<'_>; 2], floor: usize, floors: usize) -> String {
    let name = named("target", floor, "m");
    let title = match floors {
        1 => "Displacement".to_owned(),
        _ => format!("Displacement of floor {}", floor + 1),
    };
    let [first, second] = motions;
    let (a, b) = (first.channel(&name), second.channel(&name));
    let common: Vec<(f64, f64)> = first
        .times()
        .map_while(|t| Some((t, 1e3 * (second.at(b, t)? - first.at(a, t)?))))
        .collect();
    let apart = Curve::new(WRONG, history(common.len(), |i| common[i]));
    format!(
        "<h2>{title}</h2>{}{}",
        in_time(
            TALL,
            "computed displacement [mm]",
            &overlaid(motions, &name, 1e3),
            "What the integration computed in both tests."
        ),
        in_time(
            WIDE,
            "second less first [mm]",
            &[apart],
            "How far apart they are."
        )
    )
}

fn loops(motions: &[ComparedMotion<'_>; 2], axis: usize) -> String {
    let curve = |k: usize, colour, name| {
        let motion: &ComparedMotion<'_> = &motions[k];
        let of = |quantity, suffix| motion.channel(&named(quantity, axis, suffix));
        let (displacement, force) = (of("displacement", "m"), of("force", "n"));
        let times: Vec<f64> = motion.times().collect();
        let point = |i: usize| {
            let at = |values| motion.at(values, times[i]).unwrap_or(f64::NAN);
            (1e3 * at(displacement), 1e-3 * at(force))
        };
        Curve::new(colour, path(times.len(), point)).named(name)
    };
    let svg = plot::plot(
        HALF,
        "measured displacement [mm]",
        "measured force [kN]",
        &[curve(0, IDEAL, "first").thick(), curve(1, TESTED, "second")],
    );
    let [first, second] = motions;
    let name = named("target", axis, "m");
    let (a, b) = (first.channel(&name), second.channel(&name));
    let common: Vec<(f64, f64)> = first
        .times()
        .map_while(|t| Some((1e3 * first.at(a, t)?, 1e3 * second.at(b, t)?)))
        .collect();
    let against = plot::plot(
        HALF,
        "computed displacement of the first [mm]",
        "computed displacement of the second [mm]",
        &[Curve::new(TESTED, path(common.len(), |i| common[i]))],
    );
    format!(
        "<h2>Force against displacement, and second against first</h2><div class=\"pair\">{}{}</div>",
        figure(&svg, "As it was measured."),
        figure(
            &against,
            "A line of slope 1: the same motion. Another slope: another size. A loop: one comes later."
        )
    )
}

fn energy(motions: &[ComparedMotion<'_>; 2]) -> String {
    format!(
        "<h2>Energy error</h2>{}",
        in_time(
            WIDE,
            "energy error [J]",
            &overlaid(motions, "energy_error_j", 1.0),
            "What the actuator's error put in (negative) or took out, in all (Eq 12)."
        )
    )
}

fn settings(d: &Difference) -> String {
    let rows = d.settings.iter().map(|s| {
        let cell = |v| escape(&plain_text(v));
        vec![escape(&s.key), cell(&s.first), cell(&s.second)]
    });
    match d.settings.is_empty() {
        true => "<h2>What was set otherwise</h2><p>Nothing.</p>".into(),
        false => format!(
            "<h2>What was set otherwise</h2>{}",
            table(&["key", "first", "second"], rows)
        ),
    }
}
