//! A diagnosis as a part of the report: the verdict, what is left before and after, the loops, what was tried.

use super::figures::figure as captioned;
use super::page::{each_tile, escape};
use super::plot::{Curve, HALF, IDEAL, TALL, TESTED, WRONG, history, path, plot};
use crate::terminal::percent;
use crate::wording::{
    corrected, depends_on, digits, headline, next, parameter, predicted, quantity, refitted,
    rest as sentence,
};
use diagnosis::{ChannelAnswer, Traces, Verdict};
use plant::Channel;
use std::fmt::Write as _;

/// Effects that are listed as tried.
const LISTED: usize = 10;

/// Everything about a channel.
pub fn channel(a: &ChannelAnswer) -> String {
    heading(a) + &verdict(a) + &details(a)
}

/// A channel whose verdict has been said.
pub fn channel_details(a: &ChannelAnswer) -> String {
    heading(a) + &details(a)
}

/// What to do next, as items of a list.
pub fn steps(a: &ChannelAnswer) -> String {
    let said = next(a).map(|s| s.trim_start_matches("Next: ").to_owned());
    said.map_or_else(String::new, |s| {
        format!("<li><b>{}</b>: {}</li>", a.channel.name(), escape(&s))
    })
}

fn heading(a: &ChannelAnswer) -> String {
    let what = match a.channel {
        Channel::Actuator => "Actuator: command to displacement",
        Channel::Specimen => "Specimen: displacement to force",
    };
    format!("<h2>{what}</h2>")
}

/// The verdict in a sentence.
pub fn verdict(a: &ChannelAnswer) -> String {
    format!(
        "<p class=\"verdict {}\">{}</p>",
        match a.verdict {
            Verdict::None | Verdict::Effect => "good",
            Verdict::Ambiguous | Verdict::Partial => "fair",
            Verdict::Unknown | Verdict::NotAssessed => "bad",
        },
        escape(&headline(a))
    )
}

/// Figures, sentences and pictures.
fn details(a: &ChannelAnswer) -> String {
    let mut html = String::new();
    if let Some(sentence) = crate::wording::sureness(a) {
        let _ = write!(html, "<p>{}</p>", escape(&sentence));
    }
    html += &found(a);
    // The first note says in figures what the verdict has said.
    for note in a.notes.iter().skip(1) {
        let _ = write!(html, "<p>{}</p>", escape(note));
    }
    html += &errors(a);
    for sentence in corrected(a)
        .into_iter()
        .chain(predicted(a))
        .chain(refitted(a))
    {
        let _ = write!(html, "<p>{}</p>", escape(&sentence));
    }
    if !a.traces.time_s.is_empty() {
        html += &residual(a);
        html += &loops(a);
        html += &rest(a);
    }
    html + &candidate_table(a)
}

fn found(a: &ChannelAnswer) -> String {
    if a.effects.is_empty() {
        return String::new();
    }
    let mut html = String::from("<ul class=\"found\">");
    for e in &a.effects {
        let parameters: Vec<String> = e.parameters.iter().map(|p| escape(&parameter(p))).collect();
        let _ = write!(
            html,
            "<li><b>{}</b> ({}): {}<br><span>{}</span></li>",
            e.name.name(),
            e.family.name(),
            parameters.join("; "),
            escape(e.name.entry().physics)
        );
    }
    html + "</ul>"
}

fn errors(a: &ChannelAnswer) -> String {
    let (before, after) = (&a.error_before, &a.error_after);
    // What was not worked out has no tile.
    if before.test_rms.is_nan() {
        return String::new();
    }
    let mut tiles = vec![(
        quantity(before.test_rms, &a.unit),
        "error of the refitted model on held-out data, rms",
    )];
    if !a.effects.is_empty() {
        tiles.push((quantity(after.test_rms, &a.unit), "with what was found"));
        let [low, high] = a.improvement_ci90.map(|x| quantity(x, &a.unit));
        tiles.push((
            format!("{low} to {high}"),
            "fall on held-out data, 90 % interval",
        ));
    }
    if !a.noise_floor_rms.is_nan() {
        tiles.push((quantity(a.noise_floor_rms, &a.unit), "the noise"));
    }
    tiles.push((
        format!(
            "{} / {}",
            percent(before.train_nrmse),
            percent(after.train_nrmse)
        ),
        "of the signal's deviation, on training data, before / after",
    ));
    tiles.push((
        format!(
            "{} / {}",
            percent(before.test_nrmse),
            percent(after.test_nrmse)
        ),
        "of the signal's deviation, on held-out data, before / after",
    ));
    format!("<div class=\"tiles broad\">{}</div>", each_tile(&tiles))
}

/// Measured less modelled over time, with the noise around it.
fn residual(a: &ChannelAnswer) -> String {
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
    let label = match a.channel {
        Channel::Actuator => "displacement [mm]".to_owned(),
        Channel::Specimen => format!("force [{}]", a.unit),
    };
    figure(
        "What is left",
        plot(TALL, "time [s]", &label, &curves),
        &format!("Measured less modelled, on the held-out data, {}.", span(t)),
    )
}

/// The loop of the channel, measured and modelled, without and with what was found.
fn loops(a: &ChannelAnswer) -> String {
    let t = &a.traces;
    let (x_label, y_label, what) = match a.channel {
        Channel::Actuator => (
            "command [mm]",
            "displacement less command [mm]".to_owned(),
            "What the actuator makes of a command",
        ),
        Channel::Specimen => (
            "displacement [mm]",
            format!("force [{}]", a.unit),
            "Force against displacement",
        ),
    };
    let window = window(&t.input);
    let picture = |model: &[f64], caption: &str| -> String {
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
        let curves = [
            Curve::new(IDEAL, points(&t.measured))
                .thick()
                .named("measured"),
            Curve::new(TESTED, points(model)).named("model"),
        ];
        let svg = plot(HALF, x_label, &y_label, &curves);
        captioned(&svg, caption)
    };
    let Traces { before, after, .. } = t;
    let from_to = format!(
        "From {} to {} s.",
        digits(t.time_s[window.start]),
        digits(t.time_s[window.end - 1])
    );
    let mut html = format!("<h3>{what}</h3><div class=\"pair\">");
    html += &picture(
        before,
        &format!("The declared model, within three tolerances. {from_to}"),
    );
    if !a.effects.is_empty() {
        html += &picture(after, &format!("With what was found. {from_to}"));
    }
    html + "</div>"
}

/// Turns of a motion that a picture of loops shows: more are a blot.
const TURNS: usize = 9;

/// The part of a long record whose loops are shown: a few turns around its largest motion.
fn window(input: &[f64]) -> std::ops::Range<usize> {
    let n = input.len();
    let mean = input.iter().sum::<f64>() / n as f64;
    let largest = input.iter().map(|x| (x - mean).abs()).fold(0.0, f64::max);
    // A turn is one that comes back by a tenth of the largest motion.
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

/// From when to when the held-out data of the pictures goes.
fn span(t: &Traces) -> String {
    format!(
        "{} to {} s",
        digits(t.time_s[0]),
        digits(t.time_s[t.time_s.len() - 1])
    )
}

/// What is left against displacement and speed, and what it depends on.
fn rest(a: &ChannelAnswer) -> String {
    let Some(r) = &a.remainder else {
        return String::new();
    };
    let t = &a.traces;
    let mut html = format!(
        "<h3>What the rest depends on</h3><p>{}</p>",
        escape(&sentence(a).unwrap_or_default())
    );
    if !r.shares.is_empty() || !r.lines.is_empty() {
        html += "<div class=\"scroll\"><table><tr><th>depends on</th><th>share of squares</th><th></th><th>odd</th><th>even</th></tr>";
        let row = |what: &str, share: f64, odd: &str, even: &str| {
            format!(
                "<tr><td>{}</td><td>{}</td><td class=\"bar\"><i style=\"width:{:.1}%\"></i></td><td>{odd}</td><td>{even}</td></tr>",
                escape(what),
                percent(share),
                100.0 * share.min(1.0)
            )
        };
        for s in &r.shares {
            html += &row(
                depends_on(s.depends_on, a.channel),
                s.share,
                &percent(s.odd),
                &percent(s.even),
            );
        }
        for l in &r.lines {
            html += &row(
                &format!("a line at {} Hz", digits(l.frequency_hz)),
                (l.rms / r.rms).powi(2),
                "",
                "",
            );
        }
        html += "</table></div><p>Each class is learned alone from the training data and judged on the held-out data, so shares \
                 overlap. Odd is what changes its sign with the motion.</p>";
    }
    let left: Vec<f64> = t
        .measured
        .iter()
        .zip(&t.after)
        .map(|(m, a)| m - a)
        .collect();
    let n = left.len();
    let h = (t.time_s[n - 1] - t.time_s[0]) / (n - 1) as f64;
    // Speeds over a few samples, behind which the noise of a reading does not hide them.
    let over = (n / 500).clamp(1, 20);
    let speed: Vec<f64> = (0..n - over)
        .map(|i| (t.input[i + over] - t.input[i]) / (over as f64 * h))
        .collect();
    let unit = match a.channel {
        Channel::Actuator => "mm".to_owned(),
        Channel::Specimen => a.unit.clone(),
    };
    let label = format!("left [{unit}]");
    let against = |of: &[f64], label_x: &str, caption: &str| -> String {
        let svg = plot(HALF, label_x, &label, &bands(of, &left));
        captioned(&svg, caption)
    };
    let input = match a.channel {
        Channel::Actuator => "command [mm]",
        Channel::Specimen => "displacement [mm]",
    };
    html += "<div class=\"pair\">";
    html += &against(
        &t.input,
        input,
        "Its mean, and where 80 % of it lies, against the place.",
    );
    html += &against(&speed, "speed [mm/s]", "The same against the speed.");
    html + "</div>"
}

/// Bins over a range.
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

fn candidate_table(a: &ChannelAnswer) -> String {
    let Some(most) = a.tried.iter().map(|t| t.rms_left).reduce(f64::max) else {
        return String::new();
    };
    let mut html = String::from(
        "<h3>What was tried</h3><p>The ten effects that came nearest, each added alone; the bar is what it leaves of the \
         training data's error; green is what was taken. They stand in the order of the evidence, the fall of the Bayesian \
         information criterion, which counts what an effect costs in numbers to fit.</p>\
         <div class=\"scroll\"><table><tr><th>effect</th><th>left, rms</th><th></th><th>evidence</th></tr>",
    );
    for t in a.tried.iter().take(LISTED) {
        let _ = write!(
            html,
            "<tr{}><td>{}</td><td>{}</td><td class=\"bar\"><i style=\"width:{:.1}%\"></i></td><td>{:.0}</td></tr>",
            if a.effects.iter().any(|e| e.name == t.name) {
                " class=\"taken\""
            } else {
                ""
            },
            t.name.name(),
            quantity(t.rms_left, &a.unit),
            100.0 * t.rms_left / most.max(f64::MIN_POSITIVE),
            t.bic_gain
        );
    }
    html + "</table></div>"
}

fn figure(title: &str, svg: String, caption: &str) -> String {
    format!("<h3>{title}</h3>{}", captioned(&svg, caption))
}
