//! A designed test: its command, and the predictions of each possible cause.

use crate::document::plot::{
    Colour, Curve, FIFTH, FOURTH, HALF, TESTED, THIRD, WIDE, WRONG, history, path, plot,
};
use crate::document::{Document, Table, table};
use crate::wording::{digits, plan, quantity};
use diagnosis::{Form, Next, Outlook, Phase};
use experiment::numbers::percent;
use plant::Channel;

/// Colours of the possible causes.
const COLOURS: [Colour; 5] = [TESTED, WRONG, THIRD, FOURTH, FIFTH];

/// Everything about a designed test.
pub(super) fn section(d: &mut Document, n: &Next) {
    d.heading("The next test");
    d.say(plan::summary(n));
    d.say(plan::limits(n));
    d.figure(
        "Its command. `outerloop run TEST.toml --signal FILE` plays it on a simulated rig, `outerloop board commission TEST.toml \
         --signal FILE` on a board; `outerloop diagnose` takes its record beside the first, each with a `--train` of its own.",
        || {
            let time = n.time_s();
            let command = history(time.len(), |i| (time[i], n.command_mm[i]));
            plot(WIDE, "time [s]", "command [mm]", &[Curve::new(TESTED, command)])
        },
    );
    let head = [
        "phase of the next test",
        "amplitude",
        "top speed",
        "frequency",
        "takes",
    ];
    d.table(table(&head).with_rows(n.phases.iter().map(phase_row)));
    for o in &n.channels {
        d.subheading(format!("What it will tell of the {}", o.channel.name()));
        d.say(plan::expectation(o));
        if o.candidates.len() > 1 {
            d.table(predictions(o));
            d.explain(
                "What stays apart is counted after every number of a wrong model has been moved as far as the records let it be \
                 moved.",
            );
            pictures(d, o, n);
        } else if !o.parameters.is_empty() {
            d.table(numbers(o));
        }
    }
}

fn phase_row(p: &Phase) -> Vec<String> {
    let or_none = |x: f64, unit: &str| match x {
        0.0 => "-".to_owned(),
        x => quantity(x, unit),
    };
    let frequency = match p.form {
        Form::Chirp => format!("to {}", quantity(p.frequency_hz, "Hz")),
        _ => or_none(p.frequency_hz, "Hz"),
    };
    vec![
        p.form.in_words().to_owned(),
        or_none(p.amplitude_mm, "mm"),
        or_none(p.speed_mm_per_s, "mm/s"),
        frequency,
        quantity(p.seconds, "s"),
    ]
}

/// The predictions of each possible cause.
fn predictions(o: &Outlook) -> Table {
    let first = format!("if it is, in the {},", o.channel.name());
    let mut t = table(&[
        first.as_str(),
        "probability",
        "peak",
        "area of the loops",
        "apart from the first, rms",
        "stays apart by",
    ]);
    for c in &o.candidates {
        t.add_row([
            plan::name(c).to_owned(),
            c.probability.map_or_else(|| "?".into(), percent),
            quantity(c.peak, &o.unit),
            quantity(c.loop_area, &plan::area_unit(o)),
            quantity(c.apart_rms, &o.unit),
            c.separation.map_or_else(
                || "-".into(),
                |s| format!("{} times what is left", digits(s)),
            ),
        ]);
    }
    t
}

/// Each parameter of a model, with its interval now and after the test.
fn numbers(o: &Outlook) -> Table {
    let first = format!("number of the {}", o.channel.name());
    let mut t = table(&[
        first.as_str(),
        "value",
        "known to, 90 %",
        "with the next test",
    ]);
    for p in &o.parameters {
        t.add_row([
            p.name.clone(),
            digits(p.value),
            format!("+- {}", digits(p.half_now)),
            format!("+- {}", digits(p.half_then)),
        ]);
    }
    t
}

/// The predicted responses of the causes over time, and their loops.
fn pictures(d: &mut Document, o: &Outlook, n: &Next) {
    let causes = || o.candidates.iter().zip(COLOURS);
    let caption = format!(
        "What each predicts, less what {} predicts; what the model leaves today is {} rms.",
        plan::name(&o.candidates[0]),
        quantity(o.left_rms, &o.unit)
    );
    let (unit, answer) = match o.channel {
        Channel::Actuator => ("mm", "displacement"),
        Channel::Specimen => (o.unit.as_str(), "force"),
    };
    d.figure(caption, || {
        let (time, first) = (n.time_s(), &o.candidates[0].answer);
        let others = causes().skip(1).map(|(c, colour)| {
            let points = history(time.len(), |i| (time[i], c.answer[i] - first[i]));
            Curve::new(colour, points).named(plan::name(c))
        });
        let others: Vec<Curve> = others.collect();
        plot(WIDE, "time [s]", &format!("apart [{unit}]"), &others)
    });
    d.pair(|d| {
        for (c, colour) in causes() {
            d.figure(format!("If it is {}.", plan::name(c)), || {
                let points = path(n.command_mm.len(), |i| (n.command_mm[i], c.answer[i]));
                let curve = [Curve::new(colour, points)];
                plot(HALF, "command [mm]", &format!("{answer} [{unit}]"), &curve)
            });
        }
    });
}
