//! `diagnose --dial`: records in which one thing of the rig was turned.

use super::Diagnose;
use crate::terminal;
use diagnosis::{Diagnosis, Dose, Model, Turned, turned};
use experiment::failure::Failure;
use experiment::files::measured::{FilePart, RecordFiles};

/// Fewer settings go one way by chance.
const FEWEST: usize = 3;

/// Where the dial stood, and the record of it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DialArgument {
    at: f64,
    part: FilePart,
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

impl Diagnose {
    /// How the names go with the dial; `None` where none was turned.
    ///
    /// # Errors
    /// Fewer than three settings, one twice, a record that cannot be used.
    pub(super) fn turned(
        &self,
        declared: &Model,
        diagnosis: &Diagnosis,
        library: &mut RecordFiles,
    ) -> Result<Option<Vec<Turned>>, Failure> {
        if self.dial.is_empty() {
            return Ok(None);
        }
        let mut settings: Vec<f64> = self.dial.iter().map(|d| d.at).collect();
        settings.sort_by(f64::total_cmp);
        settings.dedup();
        if settings.len() < FEWEST || settings.len() < self.dial.len() {
            return Err(Failure::input(format!(
                "--dial: {} records at {} settings: accepted are {FEWEST} settings and more, each with one record",
                self.dial.len(),
                settings.len()
            )));
        }
        let mut doses = Vec::new();
        for d in &self.dial {
            let records = library.parts(std::slice::from_ref(&d.part))?;
            doses.push(Dose { at: d.at, records });
        }
        let turned = || turned(declared, diagnosis, &doses);
        Ok(Some(terminal::while_waiting("turning the dial", turned)))
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
