//! `PATH=VALUES` of a sweep.

use experiment::failure::Failure;
use experiment::files::units;

/// A key and its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Dotted path of the key.
    pub path: String,
    /// Its values, ascending.
    pub values: Vec<f64>,
}

/// Largest number of values in a sweep.
const MOST: usize = 1000;

impl Range {
    /// Reads `PATH=A,B,C` or `PATH=FROM..TO/N`: N values at equal distances, both ends included. A value may have a unit.
    ///
    /// # Errors
    /// One sentence: no path, no numbers, fewer than two values, more than 1000, or one twice.
    pub fn parse(text: &str) -> Result<Self, Failure> {
        let refuse = |why: String| {
            Failure::input(format!(
                "--over {text}: {why}: accepted is PATH=FROM..TO/N or PATH=A,B,C with 2 to {MOST} values, e.g. \
                 plant.actuator.delay_ms=0..20/11"
            ))
        };
        let (path, values) = text
            .split_once('=')
            .ok_or_else(|| refuse("has no `=`".into()))?;
        let number = |text: &str| units::value_at(path, text).map_err(refuse);
        let mut values: Vec<f64> = match values.split_once("..") {
            None => values.split(',').map(number).collect::<Result<_, _>>()?,
            Some((from, rest)) => {
                let (to, n) = rest
                    .rsplit_once('/')
                    .ok_or_else(|| refuse("has no `/N` behind its range".into()))?;
                let (from, to) = (number(from)?, number(to)?);
                let n: usize = n
                    .trim()
                    .parse()
                    .map_err(|_| refuse(format!("`{}` is not a number of values", n.trim())))?;
                if !(2..=MOST).contains(&n) {
                    return Err(refuse(format!("has {n} values")));
                }
                let share = |i: usize| i as f64 / (n - 1) as f64;
                // To as many digits as people write: 0.1 times 3 is 0.3.
                let round = |x: f64| format!("{x:.12e}").parse().unwrap_or(x);
                (0..n)
                    .map(|i| round(from + (to - from) * share(i)))
                    .collect()
            }
        };
        if !(2..=MOST).contains(&values.len()) {
            return Err(refuse(format!("has {} value", values.len())));
        }
        values.sort_by(f64::total_cmp);
        if let Some(twice) = values.windows(2).find(|w| w[0] == w[1]) {
            return Err(refuse(format!("has {} twice", twice[0])));
        }
        Ok(Self {
            path: path.trim().to_owned(),
            values,
        })
    }

    /// The override that sets `value`.
    pub fn setting(&self, value: f64) -> String {
        format!("{}={value:?}", self.path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_and_ranges_are_read_and_mistakes_named() {
        let of = |text: &str| Range::parse(text).map_err(|e| e.to_string());
        assert_eq!(of("a.b=3,1, 2").unwrap().values, [1.0, 2.0, 3.0]);
        assert_eq!(of("a=0..0.3/4").unwrap().values, [0.0, 0.1, 0.2, 0.3]);
        assert_eq!(of("a=-2..-1/2").unwrap().values, [-2.0, -1.0]);
        let with_units = of("plant.actuator.delay_ms=1 ms,0.002 s").unwrap();
        assert_eq!(with_units.values, [1.0, 2.0]);
        let stiffness = of("structure.stiffness_n_per_m.0=1 kN/m..2 kN/m/3").unwrap();
        assert_eq!(stiffness.values, [1000.0, 1500.0, 2000.0]);
        for (text, said) in [
            ("a_ms=1,2 N", "N is a force"),
            ("a", "has no `=`"),
            ("a=1..2", "no `/N`"),
            ("a=1..2/1", "has 1 values"),
            ("a=1", "has 1 value"),
            ("a=1,x", "`x` is not a number"),
            ("a=1,1", "1 twice"),
            ("a=1..2/many", "`many`"),
        ] {
            let e = of(text).unwrap_err();
            assert!(e.contains(said) && e.contains("PATH=FROM..TO/N"), "{e}");
        }
    }
}
