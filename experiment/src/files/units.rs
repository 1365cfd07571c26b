//! Units in values: `delay_ms = "12 ms"`, `stiffness_n_per_m = "158 kN/m"`. A key's name states its unit; a value with
//! a unit is converted, and refused if that belongs to another quantity.

use toml::{Table, Value};

/// Endings of keys and the units that they stand for, the longest first.
const ENDINGS: [(&str, &str); 24] = [
    ("_n_s_per_mm", "N s/mm"),
    ("_n_s_per_m", "N s/m"),
    ("_n_per_mm", "N/mm"),
    ("_n_per_m", "N/m"),
    ("_mm_per_s", "mm/s"),
    ("_m_per_s2", "m/s²"),
    ("_m_per_s", "m/s"),
    ("_rad_per_s", "rad/s"),
    ("_ms_per_s", "ms/s"),
    ("_walk_per_s", "1/s"),
    ("_steps", "steps"),
    ("_bits", "bit"),
    ("_rad", "rad"),
    ("_n_m", "N m"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_ms", "ms"),
    ("_mm", "mm"),
    ("_kn", "kN"),
    ("_n", "N"),
    ("_m", "m"),
    ("_s", "s"),
    ("_j", "J"),
    ("_c", "°C"),
];

/// Symbols, their values in m, kg and s, and their powers of these.
const SYMBOLS: [(&str, f64, [i8; 3]); 15] = [
    ("m", 1.0, [1, 0, 0]),
    ("s", 1.0, [0, 0, 1]),
    ("N", 1.0, [1, 1, -2]),
    ("J", 1.0, [2, 1, -2]),
    ("Hz", 1.0, [0, 0, -1]),
    ("g", 1e-3, [0, 1, 0]),
    ("t", 1e3, [0, 1, 0]),
    ("gal", 1e-2, [1, 0, -2]),
    ("min", 60.0, [0, 0, 1]),
    ("in", 0.0254, [1, 0, 0]),
    ("ft", 0.3048, [1, 0, 0]),
    ("lb", 0.453_592_37, [0, 1, 0]),
    ("lbf", 4.448_221_615_260_5, [1, 1, -2]),
    ("kip", 4_448.221_615_260_5, [1, 1, -2]),
    ("%", 0.01, [0, 0, 0]),
];

/// Prefixes of the first six symbols.
const PREFIXES: [(&str, f64); 8] = [
    ("n", 1e-9),
    ("µ", 1e-6),
    ("u", 1e-6),
    ("m", 1e-3),
    ("c", 1e-2),
    ("k", 1e3),
    ("M", 1e6),
    ("G", 1e9),
];
const PREFIXED: usize = 6;

/// One g of acceleration, m/s².
const GRAVITY: f64 = 9.806_65;

/// Names of quantities, by their powers of m, kg and s.
const QUANTITIES: [(&str, [i8; 3]); 10] = [
    ("a length", [1, 0, 0]),
    ("a mass", [0, 1, 0]),
    ("a time", [0, 0, 1]),
    ("a force", [1, 1, -2]),
    ("a speed", [1, 0, -1]),
    ("an acceleration", [1, 0, -2]),
    ("a stiffness", [0, 1, -2]),
    ("a damping", [0, 1, -1]),
    ("an energy", [2, 1, -2]),
    ("a frequency", [0, 0, -1]),
];

/// The unit at the end of a key's name.
pub fn of_key(name: &str) -> Option<&'static str> {
    let ending = ENDINGS.iter().find(|(ending, _)| name.ends_with(ending));
    ending.map(|(_, unit)| *unit)
}

/// True if a value of this key may state its unit.
pub fn may_be_said(key: &str) -> bool {
    wanted(key).is_some()
}

/// Converts each value of `table` that states its unit to the unit of its key.
///
/// # Errors
/// An unknown unit, or one of a different quantity from the key's: path, value and what would be accepted.
pub fn convert(table: &mut Table) -> Result<(), String> {
    for (key, value) in table.iter_mut() {
        within(value, key, wanted(key))?;
    }
    Ok(())
}

/// The unit of a key's value; shares may be given in per cent.
fn wanted(key: &str) -> Option<&'static str> {
    if key.ends_with("_ratio") {
        return Some("");
    }
    of_key(key).filter(|unit| Unit::read(unit, false).is_some())
}

fn within(value: &mut Value, path: &str, unit: Option<&'static str>) -> Result<(), String> {
    match value {
        Value::Table(table) => {
            for (key, inner) in table.iter_mut() {
                // A declared parameter: { value = , tolerance = } in the unit of its name.
                let unit = match key.as_str() {
                    "value" | "tolerance" => unit,
                    key => wanted(key),
                };
                within(inner, &format!("{path}.{key}"), unit)?;
            }
        }
        Value::Array(list) => {
            for (i, inner) in list.iter_mut().enumerate() {
                within(inner, &format!("{path}.{i}"), unit)?;
            }
        }
        Value::String(text) => {
            if let Some(unit) = unit
                && let Some(number) = converted(text, unit)
                    .map_err(|why| format!("{path} = \"{text}\" is refused: {why}"))?
            {
                *value = Value::Float(number);
            }
        }
        _ => {}
    }
    Ok(())
}

/// The value given for the key at the end of a dotted path, `12 ms` or `12`, in the key's own unit.
///
/// # Errors
/// Not a number; an unknown unit or one of another quantity.
pub fn value_at(path: &str, text: &str) -> Result<f64, String> {
    let mut names = path.rsplit('.');
    let key = names.find(|name| name.parse::<usize>().is_err());
    let unit = key.and_then(|key| wanted(key.trim()));
    match unit {
        Some(unit) => converted(text, unit)?,
        None => text.trim().parse().ok(),
    }
    .filter(|x: &f64| x.is_finite())
    .ok_or_else(|| format!("`{}` is not a number", text.trim()))
}

/// The number of a value such as `12 ms` in `unit`; `None` for a text that does not begin with a number.
///
/// # Errors
/// An unknown unit, or one of another quantity.
pub fn converted(text: &str, unit: &str) -> Result<Option<f64>, String> {
    let Some((number, said)) = split(text) else {
        return Ok(None);
    };
    let key = Unit::read(unit, false).unwrap_or(Unit::ONE);
    let example = || {
        format!(
            "accepted is a number alone, or one with a unit, as in \"{number} {}\"",
            if unit.is_empty() { "%" } else { unit }
        )
    };
    if said.is_empty() {
        return Ok(Some(number));
    }
    let acceleration = key.powers == [1, 0, -2];
    let Some(value) = Unit::read(said, acceleration) else {
        return Err(format!("the unit `{said}` is unknown: {}", example()));
    };
    if value.powers != key.powers {
        return Err(format!(
            "{said} is {}, and the key is {}: {}",
            value.quantity(),
            key.quantity(),
            example()
        ));
    }
    Ok(Some(number * (value.size / key.size)))
}

/// A number and the text after it.
fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    // The longest prefix that is a number: `5e3 N`, not `5`.
    let ends = text.char_indices().map(|(at, c)| at + c.len_utf8());
    let mut numbers = ends.filter_map(|end| Some((text[..end].trim_end().parse().ok()?, end)));
    let (number, end): (f64, usize) = numbers.next_back()?;
    let begins = text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    begins.then(|| (number, text[end..].trim()))
}

/// A unit.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Unit {
    /// Its value in m, kg and s.
    size: f64,
    /// Its powers of m, kg and s.
    powers: [i8; 3],
}

impl Unit {
    const ONE: Self = Self {
        size: 1.0,
        powers: [0; 3],
    };

    /// Reads a product of symbols, each with a power, with a `/` before divisors: `N s/mm`, `kN*s/m`, `m/s²`,
    /// `N/(m/s)`. `gravity`: `g` is the acceleration of gravity and not a gram.
    fn read(text: &str, gravity: bool) -> Option<Self> {
        let mut unit = Self::ONE;
        let mut rest = text.trim();
        let mut divides = false;
        while !rest.is_empty() {
            let (factor, after) = match rest.strip_prefix('(') {
                Some(inner) => {
                    let close = inner.find(')')?;
                    (Self::read(&inner[..close], gravity)?, &inner[close + 1..])
                }
                None => {
                    let ends = |c: char| "/*·( )".contains(c);
                    let end = rest.find(ends).unwrap_or(rest.len());
                    (Self::power(&rest[..end], gravity)?, &rest[end..])
                }
            };
            let sign = if divides { -1 } else { 1 };
            unit.size *= factor.size.powi(i32::from(sign));
            for (power, of_it) in unit.powers.iter_mut().zip(factor.powers) {
                *power += sign * of_it;
            }
            let after = after.trim_start();
            divides = after.starts_with('/');
            rest = after.trim_start_matches(['/', '*', '·']).trim_start();
            if rest.is_empty() && rest.len() != after.len() {
                return None;
            }
        }
        Some(unit)
    }

    /// A symbol with its power: `mm`, `s2`, `s^2`, `s²`.
    fn power(text: &str, gravity: bool) -> Option<Self> {
        if text == "1" {
            return Some(Self::ONE);
        }
        let (symbol, power) = match text.strip_suffix(['2', '²']) {
            Some(symbol) => (symbol.trim_end_matches('^'), 2),
            None => (text, 1),
        };
        let one = Self::symbol(symbol, gravity)?;
        Some(Self {
            size: one.size.powi(i32::from(power)),
            powers: one.powers.map(|p| p * power),
        })
    }

    fn symbol(text: &str, gravity: bool) -> Option<Self> {
        if gravity && text == "g" {
            return Some(Self {
                size: GRAVITY,
                powers: [1, 0, -2],
            });
        }
        let find = |name: &str, among: &[(&str, f64, [i8; 3])]| {
            let found = among.iter().find(|(symbol, ..)| *symbol == name);
            found.map(|(_, size, powers)| (*size, *powers))
        };
        let alone = find(text, &SYMBOLS).map(|found| (1.0, found));
        let (factor, (size, powers)) = alone.or_else(|| {
            PREFIXES.iter().find_map(|(prefix, factor)| {
                let symbol = text.strip_prefix(prefix)?;
                Some((*factor, find(symbol, &SYMBOLS[..PREFIXED])?))
            })
        })?;
        Some(Self {
            size: factor * size,
            powers,
        })
    }

    fn quantity(&self) -> &'static str {
        if self.powers == [0; 3] {
            return "a share";
        }
        let found = QUANTITIES.iter().find(|(_, powers)| *powers == self.powers);
        found.map_or("another quantity", |(name, _)| name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(text: &str, unit: &str) -> Result<Option<f64>, String> {
        converted(text, unit)
    }

    #[test]
    fn values_are_converted_to_the_unit_of_their_key() {
        for (text, unit, expected) in [
            ("12 ms", "ms", 12.0),
            ("0.012 s", "ms", 12.0),
            ("158 kN/m", "N/m", 158e3),
            ("158 N/mm", "N/m", 158e3),
            ("1e3N/m", "N/mm", 1.0),
            ("2.5 t", "kg", 2500.0),
            ("500 g", "kg", 0.5),
            ("0.3 g", "m/s²", 2.941_995),
            ("50 cm/s2", "m/s²", 0.5),
            ("50 gal", "m/s²", 0.5),
            ("4 in", "mm", 101.6),
            ("10 kip", "N", 44_482.216_152_605),
            ("3 kN s/m", "N s/mm", 3.0),
            ("3 kN/(m/s)", "N s/mm", 3.0),
            ("-5 µm", "m", -5e-6),
            ("2 %", "", 0.02),
            ("7", "mm", 7.0),
            ("2 kHz", "Hz", 2000.0),
            ("5 1/s", "1/s", 5.0),
        ] {
            let found = one(text, unit).unwrap().unwrap();
            assert!(
                (found - expected).abs() <= 1e-12 * expected.abs(),
                "{text}: {found}"
            );
        }
        assert_eq!(one("fast", "Hz"), Ok(None));
        assert_eq!(one("inf", "Hz"), Ok(None));
    }

    #[test]
    fn another_quantity_is_named() {
        for (text, unit, said) in [
            ("1000 N", "kg", "N is a force, and the key is a mass"),
            ("158 kN", "N/m", "kN is a force, and the key is a stiffness"),
            ("5 mm", "ms", "mm is a length, and the key is a time"),
            ("5 furlong", "m", "the unit `furlong` is unknown"),
            ("5 N/", "N", "the unit `N/` is unknown"),
            ("5 m/s", "m", "m/s is a speed"),
        ] {
            let e = one(text, unit).unwrap_err();
            assert!(
                e.contains(said) && e.contains("as in \"") && !e.contains('\n'),
                "{e}"
            );
        }
    }

    #[test]
    fn every_ending_with_a_physical_unit_can_be_read() {
        for (ending, unit) in ENDINGS {
            assert_eq!(
                may_be_said(ending),
                // An angle has no power of m, kg and s: a value in Hz would be accepted for rad/s.
                !["steps", "bit", "°C", "rad", "rad/s"].contains(&unit),
                "{ending}"
            );
        }
    }
}
