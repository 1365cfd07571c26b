//! Numbers in text: three significant digits and an SI prefix.

/// SI prefixes, from the smallest, and their powers of ten.
const PREFIXES: [(&str, i32); 9] = [
    ("p", -12),
    ("n", -9),
    ("µ", -6),
    ("m", -3),
    ("", 0),
    ("k", 3),
    ("M", 6),
    ("G", 9),
    ("T", 12),
];

/// Three significant digits; an exponent below a thousandth and from a million on.
pub fn three(x: f64) -> String {
    let Some((mantissa, power)) = scientific(x) else {
        return special(x);
    };
    if (-3..6).contains(&power) {
        plain(mantissa, power)
    } else {
        format!("{mantissa:.2}e{power}")
    }
}

/// Three significant digits with the unit and its prefix, as `1.23 kN`.
pub fn si(x: f64, unit: &str) -> String {
    let spaced = |number: &str, prefix: &str| match unit {
        "" | "1" => number.to_owned(),
        unit => format!("{number} {prefix}{unit}"),
    };
    let Some((mantissa, power)) = scientific(x) else {
        return spaced(&special(x), "");
    };
    if matches!(unit, "" | "1") {
        return three(x);
    }
    let thousands = 3 * power.div_euclid(3);
    match PREFIXES.iter().find(|(_, p)| *p == thousands) {
        Some((prefix, _)) => spaced(&plain(mantissa, power - thousands), prefix),
        None => spaced(&format!("{mantissa:.2}e{power}"), ""),
    }
}

/// A length with its unit: a movement is read in millimetres as long as it is one.
pub fn length(m: f64) -> String {
    match m.abs() {
        a if (1e-6..10.0).contains(&a) => format!("{} mm", three(m * 1e3)),
        _ => si(m, "m"),
    }
}

/// A share in per cent.
pub fn percent(share: f64) -> String {
    format!("{} %", three(share * 100.0))
}

/// The share by which a small motion grows in a second, in per cent; no figure above a million, which means nothing there.
pub fn growth_percent(share: f64) -> String {
    match share > 1e4 {
        true => "more than 1e6 %".into(),
        false => percent(share),
    }
}

/// An error in a table; infinite where the test tripped or ran away.
pub fn percent_or_lost(error: f64) -> String {
    if error.is_finite() {
        percent(error)
    } else {
        "lost".into()
    }
}

/// An energy.
pub fn joule(j: f64) -> String {
    si(j, "J")
}

/// Three digits and the power of ten of a number that has them.
fn scientific(x: f64) -> Option<(f64, i32)> {
    if x == 0.0 || !x.is_finite() {
        return None;
    }
    let text = format!("{x:.2e}");
    let (mantissa, power) = text.split_once('e')?;
    Some((mantissa.parse().ok()?, power.parse().ok()?))
}

fn special(x: f64) -> String {
    if x == 0.0 {
        "0".into()
    } else if x.is_nan() {
        "NaN".into()
    } else {
        "infinite".into()
    }
}

fn plain(mantissa: f64, power: i32) -> String {
    let places = usize::try_from(2 - power).unwrap_or(0);
    format!("{:.places$}", mantissa * 10_f64.powi(power))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_whatever_the_size() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1.00"),
            (-0.012_345, "-0.0123"),
            (999.9, "1000"),
            (0.000_999_9, "0.00100"),
            (123_456.0, "123000"),
            (1.089_6e22, "1.09e22"),
            (4.874e-9, "4.87e-9"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "infinite"),
        ] {
            assert_eq!(three(x), text);
        }
    }

    #[test]
    fn a_growth_beyond_a_million_has_no_figure() {
        for (share, text) in [
            (-0.05, "-5.00 %"),
            (5000.0, "500000 %"),
            (9.03e154, "more than 1e6 %"),
            (f64::INFINITY, "more than 1e6 %"),
        ] {
            assert_eq!(growth_percent(share), text);
        }
    }

    #[test]
    fn prefixes_follow_the_size() {
        for (x, text) in [
            (0.0, "0 J"),
            (-1988.5, "-1.99 kJ"),
            (999.96, "1.00 kJ"),
            (0.03, "30.0 mJ"),
            (3.0e-7, "300 nJ"),
            (1e30, "1.00e30 J"),
            (f64::NAN, "NaN J"),
        ] {
            assert_eq!(joule(x), text);
        }
        assert_eq!(length(0.123_4), "123 mm");
        assert_eq!(length(-0.001_234), "-1.23 mm");
        assert_eq!(length(1.089_6e19), "1.09e19 m");
        assert_eq!(percent(0.018_04), "1.80 %");
        assert_eq!(percent(3.3e-5), "0.00330 %");
        assert_eq!(percent(2e4), "2.00e6 %");
        assert_eq!(si(0.25, "1"), "0.250");
    }
}
