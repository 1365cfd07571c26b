//! Two tests side by side.

use crate::archive::ArchivedTest;
use crate::difference::{ComparedMotion, Difference, plain_text};
use crate::document::plot::{
    Curve, HALF, IDEAL, PlotShape, TALL, TESTED, WIDE, WRONG, history, path, plot,
};
use crate::document::{Document, Table, table};
use experiment::numbers::{si, three};

/// The two tests `pair`, from the files `names`.
pub fn of_difference(
    difference: &Difference,
    pair: [&ArchivedTest; 2],
    names: &[String; 2],
    with_page: bool,
) -> Document {
    let lead = format!(
        "First: {}. Second: {}. Compared at the integration steps over {} of model time.",
        names[0],
        names[1],
        si(difference.compared_s, "s")
    );
    let mut d = Document::new("Two tests side by side", lead, with_page);
    d.explain(format!("**{}**", difference.sentence()));
    if with_page {
        let motions = pair.map(ComparedMotion::of);
        let floors = pair[0].repeat.config.degrees_of_freedom();
        (0..floors).for_each(|floor| displacement(&mut d, &motions, floor, floors));
        let storeys = pair[0].repeat.config.physical_storeys();
        (0..storeys).for_each(|floor| loops(&mut d, &motions, floor));
        d.heading("Energy error");
        let caption = "What the actuator's error put in (negative) or took out, in all (Eq 12).";
        let curves = overlaid(&motions, "energy_error_j", 1.0);
        in_time(&mut d, WIDE, "energy error [J]", &curves, caption);
    }
    d.heading("What was set otherwise");
    if difference.settings.is_empty() {
        d.say("The same test: no key of its configuration, rig or ground motion differs.");
    } else {
        let settings = difference.settings.iter();
        let rows = settings.map(|s| [s.key.clone(), plain_text(&s.first), plain_text(&s.second)]);
        d.table(table(&["set otherwise", "first", "second"]).with_rows(rows.map(Vec::from)));
    }
    d.heading("Figures");
    let number = |v: &serde_json::Value| v.as_f64().map_or_else(|| plain_text(v), three);
    let figures = difference.figures.iter();
    let rows = figures.map(|f| vec![f.key.to_owned(), number(&f.first), number(&f.second)]);
    d.table(table(&["figure", "first", "second"]).with_rows(rows));
    d.heading("Channel by channel");
    d.on_terminal(|d| d.table(channels(difference, false)));
    d.on_page(|d| d.table(channels(difference, true)));
    d.tell(difference.sentence());
    d
}

fn channels(difference: &Difference, all: bool) -> Table {
    let shown = difference.channels.iter().filter(|c| all || c.is_motion());
    table(&["channel", "peak", "rms apart", "of peak", "most", "at"])
        .with_rows(shown.map(|c| c.cells().to_vec()))
}

/// The name of an axis' channel, as in `record.csv`.
fn named(quantity: &str, axis: usize, suffix: &str) -> String {
    match axis {
        0 => format!("{quantity}_{suffix}"),
        axis => format!("{quantity}{}_{suffix}", axis + 1),
    }
}

/// A channel of both tests over model time, multiplied by `factor`.
fn overlaid(motions: &[ComparedMotion<'_>; 2], name: &str, factor: f64) -> [Curve; 2] {
    let [first, second] = [0, 1].map(|k| {
        let motion = &motions[k];
        let values = motion.channel(name);
        let times: Vec<f64> = motion.times().collect();
        history(times.len(), |i| {
            let value = motion.at(values, times[i]).unwrap_or(f64::NAN);
            (times[i], value * factor)
        })
    });
    [
        Curve::new(IDEAL, first).named("first").thick(),
        Curve::new(TESTED, second).named("second"),
    ]
}

fn in_time(d: &mut Document, shape: PlotShape, label: &str, curves: &[Curve], caption: &str) {
    d.figure(caption, || plot(shape, "model time [s]", label, curves));
}

/// Time, s, and the computed displacements of both tests, mm, for as long as both run.
fn targets(motions: &[ComparedMotion<'_>; 2], axis: usize) -> Vec<(f64, f64, f64)> {
    let name = named("target", axis, "m");
    let [first, second] = motions;
    let (a, b) = (first.channel(&name), second.channel(&name));
    first
        .times()
        .map_while(|t| Some((t, 1e3 * first.at(a, t)?, 1e3 * second.at(b, t)?)))
        .collect()
}

fn displacement(d: &mut Document, motions: &[ComparedMotion<'_>; 2], floor: usize, floors: usize) {
    d.heading(match floors {
        1 => "Displacement".to_owned(),
        _ => format!("Displacement of floor {}", floor + 1),
    });
    let curves = overlaid(motions, &named("target", floor, "m"), 1e3);
    let caption = "What the integration computed in both tests.";
    in_time(d, TALL, "computed displacement [mm]", &curves, caption);
    let common = targets(motions, floor);
    let apart = history(common.len(), |i| {
        let (t, first, second) = common[i];
        (t, second - first)
    });
    let caption = "How far apart they are.";
    let curve = [Curve::new(WRONG, apart)];
    in_time(d, WIDE, "second less first [mm]", &curve, caption);
}

fn loops(d: &mut Document, motions: &[ComparedMotion<'_>; 2], axis: usize) {
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
    d.heading("Force against displacement, and second against first");
    d.pair(|d| {
        d.figure("As it was measured.", || {
            let curves = [curve(0, IDEAL, "first").thick(), curve(1, TESTED, "second")];
            plot(HALF, "measured displacement [mm]", "measured force [kN]", &curves)
        });
        let caption =
            "A line of slope 1: the same motion. Another slope: another size. A loop: one comes later.";
        d.figure(caption, || {
            let common = targets(motions, axis);
            let curve = path(common.len(), |i| (common[i].1, common[i].2));
            plot(
                HALF,
                "computed displacement of the first [mm]",
                "computed displacement of the second [mm]",
                &[Curve::new(TESTED, curve)],
            )
        });
    });
}
