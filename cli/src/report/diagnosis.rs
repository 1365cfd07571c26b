//! A diagnosis as a part of the report: the verdict, what is left before and after, the loops, what was tried.

use super::plot::{Curve, HALF, IDEAL, TALL, TESTED, WRONG, history, path, plot};
use super::{Drawn, escape};
use crate::terminal::percent;
use crate::wording::{headline, next, parameter, quantity, refitted};
use diagnosis::{ChannelAnswer, Traces, Verdict};
use plant::Channel;
use std::fmt::Write as _;

/// Effects that are listed as tried.
const LISTED: usize = 10;

/// Everything about a channel.
///
/// # Errors
/// The drawing library's.
pub fn channel(a: &ChannelAnswer) -> Drawn {
    let mut html = format!(
        "<h2>{}</h2><p class=\"verdict {}\">{}</p>",
        match a.channel {
            Channel::Actuator => "Actuator: command to displacement",
            Channel::Specimen => "Specimen: displacement to force",
        },
        match a.verdict {
            Verdict::None | Verdict::Effect => "good",
            Verdict::Ambiguous | Verdict::Partial => "fair",
            Verdict::Unknown | Verdict::NotAssessed => "bad",
        },
        escape(&headline(a))
    );
    html += &found(a);
    // The first note says in figures what the verdict has said, unless there is none.
    for note in a
        .notes
        .iter()
        .skip(usize::from(a.verdict != Verdict::NotAssessed))
    {
        let _ = write!(html, "<p>{}</p>", escape(note));
    }
    if let Some(sentence) = next(a) {
        let _ = write!(html, "<p>{}</p>", escape(&sentence));
    }
    html += &errors(a);
    if let Some(sentence) = refitted(a) {
        let _ = write!(html, "<p>{}</p>", escape(&sentence));
    }
    if !a.traces.time_s.is_empty() {
        html += &residual(a)?;
        html += &loops(a)?;
    }
    Ok(html + &tried(a))
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
    let tile = |value: String, meaning: &str| {
        format!("<div class=\"tile\"><b>{value}</b><span>{meaning}</span></div>")
    };
    let mut tiles = vec![tile(
        quantity(before.test_rms, &a.unit),
        "error of the declared model on held-out data, rms",
    )];
    if !a.effects.is_empty() {
        tiles.push(tile(
            quantity(after.test_rms, &a.unit),
            "with what was found",
        ));
        let [low, high] = a.improvement_ci90.map(|x| quantity(x, &a.unit));
        tiles.push(tile(
            format!("{low} to {high}"),
            "is gained on held-out data, 90 % interval",
        ));
    }
    tiles.push(tile(
        quantity(a.noise_floor_rms, &a.unit),
        "the noise: nothing can be better",
    ));
    tiles.push(tile(
        format!(
            "{} / {}",
            percent(before.train_nrmse),
            percent(after.train_nrmse)
        ),
        "of what moves, on training data, before / after",
    ));
    tiles.push(tile(
        format!(
            "{} / {}",
            percent(before.test_nrmse),
            percent(after.test_nrmse)
        ),
        "of what moves, on held-out data, before / after",
    ));
    format!("<div class=\"tiles broad\">{}</div>", tiles.concat())
}

/// Measured less modelled over time, with the noise around it.
fn residual(a: &ChannelAnswer) -> Drawn {
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
        plot(TALL, "time [s]", &label, &curves)?,
        "Measured less modelled, on the held-out data.",
    )
}

/// The loop of the channel, measured and modelled, without and with what was found.
fn loops(a: &ChannelAnswer) -> Drawn {
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
    let picture = |model: &[f64], caption: &str| -> Drawn {
        let points = |y: &[f64]| {
            path(y.len(), |i| {
                let from = match a.channel {
                    Channel::Actuator => t.input[i],
                    Channel::Specimen => 0.0,
                };
                (t.input[i], y[i] - from)
            })
        };
        let curves = [
            Curve::new(IDEAL, points(&t.measured))
                .broad()
                .named("measured"),
            Curve::new(TESTED, points(model)).named("model"),
        ];
        let svg = plot(HALF, x_label, &y_label, &curves)?;
        Ok(format!(
            "<figure>{svg}<figcaption>{caption}</figcaption></figure>"
        ))
    };
    let Traces { before, after, .. } = t;
    let mut html = format!("<h3>{what}</h3><div class=\"pair\">");
    html += &picture(before, "The declared model, inside its tolerances.")?;
    if !a.effects.is_empty() {
        html += &picture(after, "With what was found.")?;
    }
    Ok(html + "</div>")
}

fn tried(a: &ChannelAnswer) -> String {
    let Some(most) = a.tried.iter().map(|t| t.rms_left).reduce(f64::max) else {
        return String::new();
    };
    let mut html = String::from(
        "<h3>What was tried</h3><p>Every effect of the library was added alone and fitted; the bar is what it leaves \
         of the training data's error; green is what was taken. Evidence is the fall of the Bayesian information criterion.</p>\
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

fn figure(title: &str, svg: String, caption: &str) -> Drawn {
    Ok(format!(
        "<h3>{title}</h3><figure>{svg}<figcaption>{caption}</figcaption></figure>"
    ))
}
