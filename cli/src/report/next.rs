//! The next test as a part of the report: its command, and what each possible cause predicts.

use super::page::escape;

use super::plot::{
    Colour, Curve, FIFTH, FOURTH, HALF, TESTED, THIRD, WIDE, WRONG, history, path, plot,
};
use super::rths::table;
use crate::terminal::next::{
    NUMBER_HEAD, PHASE_HEAD, PREDICTION_HEAD, number_rows, phase_row, prediction_rows,
};
use crate::wording::plan;
use crate::wording::quantity;
use diagnosis::{Next, Outlook};
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
    html += &table(&PHASE_HEAD, n.phases.iter().map(phase_row));
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
            let rows = number_rows(o);
            let signed = |row: Vec<String>| row.iter().map(|c| c.replace("+-", "±")).collect();
            html += &table(&NUMBER_HEAD, rows.map(signed));
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

/// A table of the causes, their answers over time, and their loops.
fn predictions(o: &Outlook, n: &Next) -> String {
    let mut html = table(&PREDICTION_HEAD, prediction_rows(o));
    html += "<p>What stays apart is counted after every number of a wrong model has been moved as far as the \
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
