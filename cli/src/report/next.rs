//! The next test as a part of the report: its command, and what each possible cause predicts.

use super::page::escape;
use super::plot::{
    Colour, Curve, FIFTH, FOURTH, HALF, TESTED, THIRD, WIDE, WRONG, history, path, plot,
};
use crate::terminal::percent;
use crate::wording::plan;
use crate::wording::{digits, quantity};
use diagnosis::{Form, Next, Outlook};
use plant::Channel;
use std::fmt::Write as _;

/// Colours of the possible causes.
const COLOURS: [Colour; 5] = [TESTED, WRONG, THIRD, FOURTH, FIFTH];

/// Everything about a designed test.
pub fn section(n: &Next) -> String {
    let time = n.time_s();
    let command = history(time.len(), |i| (time[i], n.command_mm[i]));
    let mut html = format!(
        "<h2 id=\"next\">The next test</h2><p>{} {}</p><figure>{}<figcaption>Its command. <code>outerloop run TEST.toml --signal FILE</code> \
         plays it on a simulated rig, <code>outerloop board commission TEST.toml --signal FILE</code> on a board; \
         <code>outerloop diagnose</code> takes its record beside the first, each with a <code>--train</code> of its own.\
         </figcaption></figure>",
        escape(&plan::summary(n)),
        escape(&plan::limits(n)),
        plot(
            WIDE,
            "time [s]",
            "command [mm]",
            &[Curve::new(TESTED, command)]
        )
    );
    html += &phases(n);
    for o in &n.channels {
        let _ = write!(
            html,
            "<h3>{}</h3><p>{}</p>",
            of(o),
            escape(&plan::expectation(o))
        );
        if o.candidates.len() > 1 {
            html += &predictions(o, n);
        } else if !o.parameters.is_empty() {
            html += &parameter_table(o);
        }
    }
    html
}

fn of(o: &Outlook) -> &'static str {
    match o.channel {
        Channel::Actuator => "What it will tell of the actuator",
        Channel::Specimen => "What it will tell of the specimen",
    }
}

fn phases(n: &Next) -> String {
    let mut html = String::from(
        "<div class=\"scroll\"><table><tr><th>phase</th><th>amplitude</th><th>top speed</th><th>frequency</th><th>takes</th></tr>",
    );
    let or_none = |x: f64, unit: &str| match x {
        0.0 => "-".to_owned(),
        x => quantity(x, unit),
    };
    for p in &n.phases {
        let to = if p.form == Form::Chirp { "to " } else { "" };
        let _ = write!(
            html,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{to}{}</td><td>{}</td></tr>",
            p.form.in_words(),
            or_none(p.amplitude_mm, "mm"),
            or_none(p.speed_mm_per_s, "mm/s"),
            or_none(p.frequency_hz, "Hz"),
            quantity(p.seconds, "s"),
        );
    }
    html + "</table></div>"
}

/// A table of the causes, their answers over time, and their loops.
fn predictions(o: &Outlook, n: &Next) -> String {
    let mut html = String::from(
        "<div class=\"scroll\"><table><tr><th>if it is</th><th>probability</th><th>peak</th><th>area of the loops</th>\
         <th>apart from the first, rms</th><th>stays apart by</th></tr>",
    );
    for c in &o.candidates {
        let _ = write!(
            html,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            plan::name(c),
            c.probability.map_or_else(|| "?".into(), percent),
            quantity(c.peak, &o.unit),
            quantity(c.loop_area, &plan::area_unit(o)),
            quantity(c.apart_rms, &o.unit),
            c.separation.map_or_else(
                || "-".into(),
                |s| format!("{} times what is left", digits(s))
            ),
        );
    }
    html += "</table></div><p>What stays apart is counted after every number of a wrong model has been moved as far as the \
             records let it be moved.</p>";
    let time = n.time_s();
    let first = &o.candidates[0].answer;
    let others: Vec<Curve> = o
        .candidates
        .iter()
        .zip(COLOURS)
        .skip(1)
        .map(|(c, colour)| {
            let points = history(time.len(), |i| (time[i], c.answer[i] - first[i]));
            Curve::new(colour, points).named(plan::name(c))
        })
        .collect();
    let unit = if o.channel == Channel::Actuator {
        "mm"
    } else {
        &o.unit
    };
    let _ = write!(
        html,
        "<figure>{}<figcaption>What each predicts, less what {} predicts; what the model leaves today is {} rms.</figcaption></figure>",
        plot(WIDE, "time [s]", &format!("apart [{unit}]"), &others),
        plan::name(&o.candidates[0]),
        quantity(o.left_rms, &o.unit)
    );
    html += "<div class=\"pair\">";
    for (c, colour) in o.candidates.iter().zip(COLOURS) {
        let points = path(n.command_mm.len(), |i| (n.command_mm[i], c.answer[i]));
        let label = match o.channel {
            Channel::Actuator => "displacement [mm]".to_owned(),
            Channel::Specimen => format!("force [{}]", o.unit),
        };
        let curve = [Curve::new(colour, points)];
        let _ = write!(
            html,
            "<figure>{}<figcaption>If it is {}.</figcaption></figure>",
            plot(HALF, "command [mm]", &label, &curve),
            plan::name(c)
        );
    }
    html + "</div>"
}

fn parameter_table(o: &Outlook) -> String {
    let mut html = String::from(
        "<div class=\"scroll\"><table><tr><th>number</th><th>value</th><th>known to, 90 %</th><th>with the next test</th></tr>",
    );
    for p in &o.parameters {
        let _ = write!(
            html,
            "<tr><td>{}</td><td>{}</td><td>&plusmn; {}</td><td>&plusmn; {}</td></tr>",
            escape(&p.name),
            digits(p.value),
            digits(p.half_now),
            digits(p.half_then)
        );
    }
    html + "</table></div>"
}
