//! What a diagnosis says, in words for the terminal and the report.

use diagnosis::{ChannelAnswer, FoundParameter, Verdict};

/// The verdict in one sentence.
pub fn headline(a: &ChannelAnswer) -> String {
    let channel = a.channel.name();
    let found: Vec<&str> = a.effects.iter().map(|e| e.name.name()).collect();
    let found = found.join(" and ");
    match a.verdict {
        Verdict::None => {
            format!("Nothing is missing in the {channel} model that the noise would show.")
        }
        Verdict::Effect => format!("The {channel} model lacks {found}. {}", change(a)),
        Verdict::Ambiguous => {
            let others: Vec<&str> = a.alternatives.iter().map(|e| e.name()).collect();
            format!(
                "The {channel} model lacks {found}, or {}: this data cannot tell which. {}",
                others.join(" or "),
                change(a)
            )
        }
        Verdict::Unknown => {
            let nearest = a.nearest.as_ref().map_or(String::new(), |n| {
                format!(
                    " The nearest is {}, which explains {:.0} % of it.",
                    n.name.name(),
                    100.0 * n.explained
                )
            });
            format!(
                "Something is missing in the {channel} model, and no effect that is known here explains enough of it.\
                 {nearest}"
            )
        }
        Verdict::NotAssessed => format!("The {channel} was not assessed."),
    }
}

/// What became of the error on held-out data.
fn change(a: &ChannelAnswer) -> String {
    let (before, after) = (a.error_before.test_rms, a.error_after.test_rms);
    format!(
        "On held-out data the error falls from {} to {} rms; the noise is {}.",
        quantity(before, &a.unit),
        quantity(after, &a.unit),
        quantity(a.noise_floor_rms, &a.unit)
    )
}

/// A name for a verdict, as files have it.
pub const fn verdict(v: Verdict) -> &'static str {
    match v {
        Verdict::None => "none",
        Verdict::Effect => "effect",
        Verdict::Ambiguous => "ambiguous",
        Verdict::Unknown => "unknown",
        Verdict::NotAssessed => "not assessed",
    }
}

/// A parameter with its 90 % interval.
pub fn parameter(p: &FoundParameter) -> String {
    let value = quantity(p.value, &p.unit);
    if p.ci90[0] == p.ci90[1] {
        return format!("{} = {value}", p.name);
    }
    format!(
        "{} = {value}  (90 %: {} to {})",
        p.name,
        digits(p.ci90[0]),
        digits(p.ci90[1])
    )
}

/// A value with its unit, where it has one.
pub fn quantity(x: f64, unit: &str) -> String {
    match unit {
        "" | "1" => digits(x),
        unit => format!("{} {unit}", digits(x)),
    }
}

/// Four digits that mean something.
pub fn digits(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let places = (3 - x.abs().log10().floor() as i32).clamp(0, 12) as usize;
    format!("{x:.places$}")
}

#[cfg(test)]
mod tests {
    use super::digits;

    #[test]
    fn numbers_have_four_digits() {
        for (x, text) in [
            (0.0, "0"),
            (0.012_345, "0.01235"),
            (-1.0, "-1.000"),
            (56.121_5, "56.12"),
            (123_456.7, "123457"),
        ] {
            assert_eq!(digits(x), text);
        }
    }
}
