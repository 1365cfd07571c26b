//! `VALUE=FILE[@T0..T1]`: a setting of a dial and its record.

use experiment::files::measured::FilePart;

/// The setting of a dial and its record.
#[derive(Clone, Debug, PartialEq)]
pub struct DialArgument {
    /// The setting, in the dial's own unit.
    pub at: f64,
    /// Its record.
    pub part: FilePart,
}

impl std::str::FromStr for DialArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refuse = |why: &str| {
            format!(
                "`{text}`: {why}: accepted is VALUE=FILE or VALUE=FILE@T0..T1, the value a finite number in the dial's own unit"
            )
        };
        let (at, part) = text.split_once('=').ok_or_else(|| refuse("has no `=`"))?;
        let at: f64 = at
            .trim()
            .parse()
            .map_err(|_| refuse("the value is no number"))?;
        if !at.is_finite() {
            return Err(refuse("the value is not finite"));
        }
        Ok(Self {
            at,
            part: part.parse()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dial_is_a_number_and_a_part_of_a_file() {
        let d: DialArgument = "20=damper.csv@0..9".parse().unwrap();
        assert_eq!((d.at, d.part.span_s), (20.0, Some([0.0, 9.0])));
        for (text, said) in [
            ("damper.csv", "has no `=`"),
            ("tight=damper.csv", "is no number"),
            ("inf=damper.csv", "is not finite"),
            ("3=damper.csv@9..0", "is not below"),
        ] {
            let e = text.parse::<DialArgument>().unwrap_err();
            assert!(e.contains(said), "{e}");
        }
    }
}
