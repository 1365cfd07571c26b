//! A designed test in words.

use super::{digits, quantity};
use diagnosis::{Next, Origin, Outlook, Prediction};
use plant::Channel;

/// Its length and number of phases.
pub fn summary(n: &Next) -> String {
    let phases = n.phases.iter().filter(|p| p.amplitude_mm > 0.0).count();
    format!(
        "The next test: {phases} {} in {} s, with rest before and after.",
        if phases == 1 { "phase" } else { "phases" },
        digits(n.seconds)
    )
}

/// The limits and their origin.
pub fn limits(n: &Next) -> String {
    let l = &n.limits;
    let place = if l.middle_mm == 0.0 {
        "of zero".to_owned()
    } else {
        format!("of {} mm", digits(l.middle_mm))
    };
    let mut parts = vec![
        (
            format!("{} mm to either side {place}", digits(l.half_mm)),
            l.displacement_from,
        ),
        (
            format!("{} mm/s", digits(l.velocity_mm_per_s)),
            l.velocity_from,
        ),
    ];
    if let Some(force) = l.force_n {
        parts.push((
            format!("a predicted force of {} N", digits(force)),
            l.force_from,
        ));
    }
    let of = |origin: Origin| -> Vec<&str> {
        let own = parts.iter().filter(|p| p.1 == origin);
        own.map(|p| p.0.as_str()).collect()
    };
    let (declared, record) = (of(Origin::Declared), of(Origin::Record));
    let mut text = String::from("It stays within ");
    if !declared.is_empty() {
        text += &format!("{} (declared)", declared.join(", "));
    }
    if !record.is_empty() {
        if !declared.is_empty() {
            text += " and ";
        }
        text += &format!(
            "{} (what the records have shown; a table [limits] in the model allows more)",
            record.join(", ")
        );
    }
    text + "."
}

/// Ratio of the squares with a wrong cause to those with the right one, from which a name is certain.
const CERTAIN: f64 = 2.0;

/// The expected result for a channel.
pub fn expectation(o: &Outlook) -> String {
    let channel = o.channel.name();
    let left = quantity(o.left_rms, &o.unit);
    let Some(times) = o.squares_times else {
        let narrowing = o.parameters.iter().map(|p| p.half_then / p.half_now);
        let least = narrowing.fold(1.0, f64::min);
        return format!(
            "In the {channel} no rival is left: the test narrows the intervals of the model's numbers, the best of them {} \
             times.",
            digits(1.0 / least)
        );
    };
    if o.decides && times < CERTAIN {
        return format!(
            "In the {channel} the test is expected to decide: the nearest two differ by {} variances of the noise, all samples \
             taken together, however their numbers are moved; 100 are enough.",
            digits(o.variances.unwrap_or_default())
        );
    }
    if times >= CERTAIN {
        format!(
            "In the {channel} the test is expected to decide: with the wrong cause a model leaves at least {} times the \
             squares that it leaves with the right one (now {left} rms), however its numbers are moved.",
            digits(times)
        )
    } else if times > 1.05 {
        format!(
            "In the {channel} the test will not decide between all of them by itself: with one of the nearest two in the place \
             of the other a model leaves {} times the squares (now {left} rms), where {} times would be certain. Wider limits \
             tell more.",
            digits(times),
            digits(CERTAIN)
        )
    } else {
        format!(
            "In the {channel} no motion inside these limits tells the nearest two apart: they differ by less than a tenth of \
             what is left ({left} rms). {}",
            match o.channel {
                Channel::Specimen =>
                    "Repeat with a specimen of another stiffness, or with wider limits.",
                Channel::Actuator => "Repeat with wider limits, or read a second displacement.",
            }
        )
    }
}

/// The name of a possible cause.
pub fn name(p: &Prediction) -> &'static str {
    p.name.map_or("the model as it is", |n| n.name())
}

/// Unit of a loop's area.
pub fn area_unit(o: &Outlook) -> String {
    match o.unit.as_str() {
        "1" => "mm".into(),
        unit => format!("{unit} mm"),
    }
}
