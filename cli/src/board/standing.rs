//! Where the pistons stand before anything is armed. A transducer that is dead, slipped or of another scale is seen by nobody but a
//! person where no second one is compared with it (`limits.disagree_m`).

use experiment::failure::Failure;
use link::reply::Identity;
use link::telemetry::StepReport;
use std::str::FromStr;

/// So far may lie between what a person reads off a scale and what the board reads, mm.
const OFF_MM: f64 = 1.0;

/// Where a person says that the pistons stand.
#[derive(Clone, Debug, PartialEq)]
pub enum PistonsAt {
    /// On their scales, mm, from actuator 1 on.
    Mm(Vec<f64>),
    /// No piston hangs on the board.
    NoPiston,
}

impl FromStr for PistonsAt {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.trim() == "none" {
            return Ok(Self::NoPiston);
        }
        let mm: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
        match mm {
            Ok(mm) if mm.iter().all(|x: &f64| x.is_finite()) => Ok(Self::Mm(mm)),
            _ => Err(format!(
                "`{}` is no position: accepted are millimetres, one for each actuator with commas between them, or none where \
                 no piston hangs on the board",
                text.trim()
            )),
        }
    }
}

/// What a board reads of its pistons.
#[derive(Clone, Debug)]
pub struct Standing {
    /// Displacement, mm, and force, kN, from actuator 1 on.
    read: Vec<[f64; 2]>,
    /// A second transducer is compared with that of every actuator.
    pub seen_twice: bool,
}

impl Standing {
    /// In the step `step` of the board `identity`, of the actuators of a test with so many coordinates; `compared`: it has a
    /// second displacement compared, which is that of actuator 1.
    pub fn of(identity: &Identity, coordinates: usize, step: &StepReport, compared: bool) -> Self {
        let each = identity.calibrations().enumerate().take(coordinates);
        let read = each.filter_map(|(actuator, lines)| {
            let [displacement, force] = step.codes(actuator)?;
            Some([
                f64::from(lines.displacement.quantity(displacement)) * 1e3,
                f64::from(lines.force.quantity(force)) * 1e-3,
            ])
        });
        Self {
            read: read.collect(),
            seen_twice: compared && identity.actuators() == 1,
        }
    }

    /// What a person is asked before anything moves. Where nobody else sees the pistons, what the board reads is not told:
    /// it would be what the person says.
    pub fn question(&self) -> String {
        if self.seen_twice {
            let read = self
                .read
                .iter()
                .map(|[mm, kn]| format!("{mm:.2} mm with {kn:.2} kN"));
            return format!(
                "the board reads {}: Enter, if that is where it stands on the piston, arms it and lets it go slowly to zero; Ctrl-C gives it up",
                read.collect::<Vec<_>>().join(", ")
            );
        }
        let what = match self.read.len() {
            1 => "where does the piston stand on its scale, mm".to_owned(),
            all => format!(
                "where do the {all} pistons stand on their scales, mm, with commas between them"
            ),
        };
        format!(
            "{what} (none, where none hangs on the board)? If the board reads the same, it is armed and lets go slowly to zero; Ctrl-C gives it up"
        )
    }

    /// Whether the pistons stand where a person says.
    ///
    /// # Errors
    /// They do not.
    pub fn compare(&self, said: &PistonsAt) -> Result<(), Failure> {
        let PistonsAt::Mm(said) = said else {
            return Ok(());
        };
        if said.len() != self.read.len() {
            return Err(Failure::input(format!(
                "the positions of {} pistons were stated: accepted are {}, as many as the board has actuators; nothing has moved",
                said.len(),
                self.read.len()
            )));
        }
        let each = said.iter().zip(&self.read).enumerate();
        let mut off = each.filter(|(_, (said, [read, _]))| (*said - read).abs() > OFF_MM);
        match off.next() {
            None => Ok(()),
            Some((actuator, (said, [read, _]))) => Err(Failure::test(format!(
                "the piston of actuator {} was said to stand at {said} mm, and the board reads {read:.2} mm: look at the transducer \
                 and its calibration (accepted is {OFF_MM} mm of difference); nothing has moved",
                actuator + 1
            ))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piston_has_to_stand_where_a_person_says() {
        let standing = Standing {
            read: vec![[12.3, 0.0], [-4.0, 1.0]],
            seen_twice: false,
        };
        let said = |text: &str| standing.compare(&text.parse().unwrap());
        assert!(said("12, -4.4").is_ok() && said("none").is_ok());
        let wrong = said("12, 0").unwrap_err().to_string();
        assert!(
            wrong.contains("actuator 2") && wrong.contains("-4.00 mm"),
            "{wrong}"
        );
        assert!(said("12").is_err());
        for text in ["", "12 mm", "nan", "1;2"] {
            assert!(PistonsAt::from_str(text).is_err(), "{text}");
        }
        assert!(!standing.question().contains("12.3"));
    }
}
