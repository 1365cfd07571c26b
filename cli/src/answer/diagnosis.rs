//! A diagnosis: the verdict, the residual before and after, the loops, and what the residual depends on.

use super::witness::{self, Witness};
use super::{dial, next};
use crate::document::plot::{Curve, HALF, IDEAL, TALL, TESTED, WRONG, history, path, plot};
use crate::document::{Document, Grade, Table, table};
use crate::wording::{
    self, corrected, depends_on, digits, headline, parameter, plan, predicted, quantity, refitted,
    rest as sentence, sureness,
};
use diagnosis::{ChannelAnswer, Diagnosis, Next, Traces, Turned, Verdict};
use experiment::numbers::percent;
use plant::Channel;

/// A diagnosis with its further results.
#[derive(Clone, Copy, Debug)]
pub struct DiagnosisSection<'a> {
    /// The title of the page.
    pub title: &'a str,
    /// The diagnosis.
    pub diagnosis: &'a Diagnosis,
    /// The next test, if requested.
    pub next: Option<&'a Next>,
    /// The testimonies of unused channels.
    pub witnesses: &'a [Witness],
    /// How the named parameters follow a dial, if there is one.
    pub dial: Option<&'a [Turned]>,
    /// The model as declared, and as improved.
    pub models: [&'a str; 2],
}

/// A diagnosis.
pub fn of_diagnosis(s: &DiagnosisSection<'_>, with_page: bool) -> Document {
    let lead = "What was measured is compared with what the declared model says, its parameters refitted around what was \
                declared; what is left beyond the noise is traced to an effect that the model lacks.";
    let mut d = Document::new(s.title, lead, with_page);
    let channels = &s.diagnosis.channels;
    d.on_page(|d| {
        channels
            .iter()
            .for_each(|c| d.verdict(grade(c.verdict), headline(c)));
        to_do(d, s);
    });
    for c in channels {
        heading(&mut d, c);
        d.tell(headline(c));
        details(&mut d, c);
        d.tell("");
    }
    d.on_terminal(|d| d.table(errors_of(channels)));
    for c in channels {
        pictures(&mut d, c);
        shares(&mut d, c);
    }
    witness::section(&mut d, s.witnesses);
    dial::section(&mut d, s.dial);
    d.tell(format!("Diagnosed in {:.2} s.", s.diagnosis.seconds));
    if let Some(n) = s.next {
        d.tell("");
        next::section(&mut d, n);
    }
    models(&mut d, s.models);
    d
}

/// The models at the end of a page.
pub(super) fn models(d: &mut Document, [declared, improved]: [&str; 2]) {
    d.heading("The models");
    d.subheading("As declared");
    d.file(declared);
    d.subheading("With what was found");
    d.file(improved);
}

fn to_do(d: &mut Document, s: &DiagnosisSection<'_>) {
    let step = |c: &ChannelAnswer| {
        let said = wording::next(c)?;
        let name = c.channel.name();
        Some(format!("**{name}**: {}", said.trim_start_matches("Next: ")))
    };
    let mut steps: Vec<String> = s.diagnosis.channels.iter().filter_map(step).collect();
    steps.extend(
        s.next
            .map(|n| format!("**play the next test**: {}", plan::summary(n))),
    );
    if !steps.is_empty() {
        d.heading("What to do next");
        d.items(steps);
    }
}

/// Everything about a channel, as part of another page.
pub(super) fn channel(d: &mut Document, a: &ChannelAnswer) {
    heading(d, a);
    d.verdict(grade(a.verdict), headline(a));
    details(d, a);
    pictures(d, a);
    shares(d, a);
}

fn heading(d: &mut Document, a: &ChannelAnswer) {
    d.heading(match a.channel {
        Channel::Actuator => "Actuator: command to displacement",
        Channel::Specimen => "Specimen: displacement to force",
    });
}

const fn grade(verdict: Verdict) -> Grade {
    match verdict {
        Verdict::None | Verdict::Effect => Grade::Good,
        Verdict::Ambiguous | Verdict::Partial => Grade::Fair,
        Verdict::Unknown | Verdict::NotAssessed => Grade::Bad,
    }
}

/// Figures and sentences.
fn details(d: &mut Document, a: &ChannelAnswer) {
    tiles(d, a);
    let mut lines: Vec<String> = sureness(a).into_iter().collect();
    for e in &a.effects {
        for p in &e.parameters {
            lines.push(format!("**{:22}** {}", e.name.name(), parameter(p)));
        }
    }
    // The first note gives the headline in figures.
    lines.extend(a.notes.iter().skip(1).cloned());
    let more = [sentence(a), corrected(a), predicted(a), refitted(a)];
    lines.extend(more.into_iter().flatten());
    d.items(lines);
    d.on_page(|d| {
        let physics = |e: &diagnosis::FoundEffect| {
            let entry = e.name.entry();
            format!(
                "**{}** ({}): {}",
                e.name.name(),
                e.family.name(),
                entry.physics
            )
        };
        d.items(a.effects.iter().map(physics).collect());
    });
    d.on_terminal(|d| d.items(wording::next(a).into_iter().collect()));
}

fn tiles(d: &mut Document, a: &ChannelAnswer) {
    let (before, after) = (&a.error_before, &a.error_after);
    // What was not computed has no tile.
    if before.test_rms.is_nan() {
        return;
    }
    let mut tiles = vec![(
        quantity(before.test_rms, &a.unit),
        "error of the refitted model on held-out data, rms".to_owned(),
    )];
    if !a.effects.is_empty() {
        tiles.push((
            quantity(after.test_rms, &a.unit),
            "with what was found".into(),
        ));
        let [low, high] = a.improvement_ci90.map(|x| quantity(x, &a.unit));
        tiles.push((
            format!("{low} to {high}"),
            "fall on held-out data, 90 % interval".into(),
        ));
    }
    if !a.noise_floor_rms.is_nan() {
        tiles.push((quantity(a.noise_floor_rms, &a.unit), "the noise".into()));
    }
    for (data, [before, after]) in [
        ("training", [before.train_nrmse, after.train_nrmse]),
        ("held-out", [before.test_nrmse, after.test_nrmse]),
    ] {
        tiles.push((
            format!("{} / {}", percent(before), percent(after)),
            format!("of the signal's deviation, on {data} data, before / after"),
        ));
    }
    d.tiles(tiles);
}

/// Errors on the held-out data; narrow enough for 80 columns.
fn errors_of(channels: &[ChannelAnswer]) -> Table {
    let mut t = table(&[
        "held out, rms",
        "verdict",
        "declared",
        "refitted",
        "improved",
        "noise",
        "fall, 90 %",
    ])
    .with_words(2);
    for a in channels {
        let rms = |x: f64| quantity(x, &a.unit);
        let [declared, refitted, improved] =
            [a.error_declared, a.error_before, a.error_after].map(|e| e.test_rms);
        t.add_row([
            a.channel.name().to_owned(),
            wording::verdict(a.verdict).to_owned(),
            rms(declared),
            rms(refitted),
            // Where nothing is added, a saved model keeps the declared values if the refitted ones are worse.
            rms(match a.effects.is_empty() {
                true => improved.min(declared),
                false => improved,
            }),
            rms(a.noise_floor_rms),
            if a.effects.is_empty() {
                "-".to_owned()
            } else {
                a.improvement_ci90.map(digits).join(" to ")
            },
        ]);
    }
    t
}

fn pictures(d: &mut Document, a: &ChannelAnswer) {
    if d.has_page() && !a.traces.time_s.is_empty() {
        residual(d, a);
        loops(d, a);
        if a.remainder.is_some() {
            left_over(d, a);
        }
    }
}

/// Measured less modelled over time, with the noise around it.
fn residual(d: &mut Document, a: &ChannelAnswer) {
    let t = &a.traces;
    let left = |model: &[f64]| history(t.time_s.len(), |i| (t.time_s[i], t.measured[i] - model[i]));
    let mut curves = vec![Curve::new(WRONG, left(&t.before)).named("declared model")];
    if !a.effects.is_empty() {
        curves.push(Curve::new(TESTED, left(&t.after)).named("with what was found"));
    }
    let ends = [t.time_s[0], t.time_s[t.time_s.len() - 1]];
    for (side, name) in [(2.0, "noise, two standard deviations"), (-2.0, "")] {
        let at = side * a.noise_floor_rms;
        curves.push(Curve::new(IDEAL, ends.map(|t| (t, at)).to_vec()).named(name));
    }
    let label = format!("{} [{}]", output(a), unit(a));
    d.subheading("What is left");
    let [from, to] = ends.map(digits);
    let caption = format!("Measured less modelled, on the held-out data, {from} to {to} s.");
    d.figure(caption, || plot(TALL, "time [s]", &label, &curves));
}

/// The input of a channel.
const fn input(a: &ChannelAnswer) -> &'static str {
    match a.channel {
        Channel::Actuator => "command",
        Channel::Specimen => "displacement",
    }
}

/// The output of a channel.
const fn output(a: &ChannelAnswer) -> &'static str {
    match a.channel {
        Channel::Actuator => "displacement",
        Channel::Specimen => "force",
    }
}

fn unit(a: &ChannelAnswer) -> &str {
    match a.channel {
        Channel::Actuator => "mm",
        Channel::Specimen => &a.unit,
    }
}

/// The loop of the channel, measured and modelled, before and after the improvement.
fn loops(d: &mut Document, a: &ChannelAnswer) {
    let t = &a.traces;
    let (label, what) = match a.channel {
        Channel::Actuator => (
            "displacement less command [mm]".to_owned(),
            "What the actuator makes of a command",
        ),
        Channel::Specimen => (format!("force [{}]", a.unit), "Force against displacement"),
    };
    let window = window(&t.input);
    let picture = |model: &[f64]| -> String {
        let points = |y: &[f64]| {
            path(window.len(), |i| {
                let i = window.start + i;
                let from = match a.channel {
                    Channel::Actuator => t.input[i],
                    Channel::Specimen => 0.0,
                };
                (t.input[i], y[i] - from)
            })
        };
        let measured = Curve::new(IDEAL, points(&t.measured));
        let curves = [
            measured.thick().named("measured"),
            Curve::new(TESTED, points(model)).named("model"),
        ];
        plot(HALF, &format!("{} [mm]", input(a)), &label, &curves)
    };
    let Traces { before, after, .. } = t;
    let [from, to] = [window.start, window.end - 1].map(|i| digits(t.time_s[i]));
    d.subheading(what);
    d.pair(|d| {
        let caption = format!("The declared model, refitted. From {from} to {to} s.");
        d.figure(caption, || picture(before));
        if !a.effects.is_empty() {
            let caption = format!("With what was found. From {from} to {to} s.");
            d.figure(caption, || picture(after));
        }
    });
}

/// Largest number of turns of a motion in a plot of loops: more cannot be distinguished.
const TURNS: usize = 9;

/// The part of a long record whose loops are plotted: a few turns around its largest motion.
fn window(input: &[f64]) -> std::ops::Range<usize> {
    let n = input.len();
    let mean = input.iter().sum::<f64>() / n as f64;
    let largest = input.iter().map(|x| (x - mean).abs()).fold(0.0, f64::max);
    // A turn is where the motion reverses by a tenth of the largest motion.
    let (mut turns, mut extreme, mut up) = (vec![0], 0, true);
    for i in 1..n {
        let back = if up {
            input[extreme] - input[i]
        } else {
            input[i] - input[extreme]
        };
        if back < 0.0 {
            extreme = i;
        } else if back > 0.1 * largest {
            turns.push(extreme);
            (extreme, up) = (i, !up);
        }
    }
    turns.push(n - 1);
    if turns.len() <= TURNS + 1 {
        return 0..n;
    }
    let size = |w: &[usize]| (input[w[0]] - mean).abs();
    let first = turns[..turns.len() - TURNS]
        .iter()
        .enumerate()
        .max_by(|a, b| size(&[*a.1]).total_cmp(&size(&[*b.1])))
        .map_or(0, |(i, _)| i);
    turns[first]..turns[first + TURNS] + 1
}

/// Number of bins over a range.
const BINS: usize = 40;

/// Mean, tenth and ninetieth percentile of `left` in bins of another signal.
fn bands(of: &[f64], left: &[f64]) -> [Curve; 3] {
    let (low, high) = of
        .iter()
        .fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
    let mut bins: Vec<Vec<f64>> = vec![Vec::new(); BINS];
    for (x, y) in of.iter().zip(left) {
        let at = ((x - low) / (high - low).max(f64::MIN_POSITIVE) * BINS as f64) as usize;
        bins[at.min(BINS - 1)].push(*y);
    }
    let curve = |value: &dyn Fn(&[f64]) -> f64| -> Vec<(f64, f64)> {
        let filled = bins.iter().enumerate().filter(|(_, b)| b.len() > 4);
        filled
            .map(|(i, b)| {
                (
                    low + (high - low) * (i as f64 + 0.5) / BINS as f64,
                    value(b),
                )
            })
            .collect()
    };
    let sorted = |b: &[f64], share: f64| {
        let mut b = b.to_vec();
        b.sort_by(f64::total_cmp);
        b[((b.len() - 1) as f64 * share) as usize]
    };
    [
        Curve::new(IDEAL, curve(&|b| sorted(b, 0.1))).named("80 % of it"),
        Curve::new(IDEAL, curve(&|b| sorted(b, 0.9))),
        Curve::new(TESTED, curve(&|b| b.iter().sum::<f64>() / b.len() as f64)).named("mean"),
    ]
}

/// The residual against displacement and velocity.
fn left_over(d: &mut Document, a: &ChannelAnswer) {
    let t = &a.traces;
    let pairs = t.measured.iter().zip(&t.after);
    let left: Vec<f64> = pairs.map(|(m, a)| m - a).collect();
    let n = left.len();
    let h = (t.time_s[n - 1] - t.time_s[0]) / (n - 1) as f64;
    // Velocity over several samples, so that the noise of a reading does not hide it.
    let over = (n / 500).clamp(1, 20);
    let speed: Vec<f64> = (0..n - over)
        .map(|i| (t.input[i + over] - t.input[i]) / (over as f64 * h))
        .collect();
    let label = format!("left [{}]", unit(a));
    d.subheading("What the remaining error depends on");
    d.pair(|d| {
        let at = format!("{} [mm]", input(a));
        for (of, x_label, caption) in [
            (
                &t.input,
                at.as_str(),
                "Its mean, and where 80 % of it lies, against the place.",
            ),
            (&speed, "speed [mm/s]", "The same against the speed."),
        ] {
            d.figure(caption, || plot(HALF, x_label, &label, &bands(of, &left)));
        }
    });
}

/// What the remaining error depends on.
fn shares(d: &mut Document, a: &ChannelAnswer) {
    let Some(r) = a
        .remainder
        .as_ref()
        .filter(|r| !r.shares.is_empty() || !r.lines.is_empty())
    else {
        return;
    };
    let head = format!("residual of the {}: depends on", a.channel.name());
    let mut t = table(&[&head, "share of squares", "odd", "even"]);
    let part = |x: f64| if x > 0.0 { percent(x) } else { "-".into() };
    for s in &r.shares {
        let what = depends_on(s.depends_on, a.channel).to_owned();
        t.add_row([what, percent(s.share), part(s.odd), part(s.even)]);
        t.bar_last(s.share);
    }
    for l in &r.lines {
        let share = (l.rms / r.rms).powi(2);
        let what = format!("a line at {} Hz", digits(l.frequency_hz));
        t.add_row([what, percent(share), "-".to_owned(), "-".to_owned()]);
        t.bar_last(share);
    }
    d.table(t);
    d.explain(
        "Each class is learned alone from the training data and judged on the held-out data, so shares overlap. Odd is what \
         changes its sign with the motion.",
    );
}
