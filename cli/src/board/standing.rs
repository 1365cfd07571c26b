//! Where the pistons stand before anything is armed. Only a person sees a transducer that is dead, slipped or of another
//! scale, unless a second one is compared with it (`limits.disagree_m`).

use experiment::failure::Failure;
use link::reply::Identity;
use link::telemetry::StepReport;
use outerloop_core::Config;
use std::str::FromStr;

/// Largest accepted difference between a person's reading of the scale and the board's, mm.
const OFF_MM: f64 = 1.0;

/// Where a person says that the pistons stand.
#[derive(Clone, Debug, PartialEq)]
pub enum PistonsAt {
    /// Readings of their scales, mm, from actuator 1 on.
    Mm(Vec<f64>),
    /// No piston is connected to the board.
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

/// Where a test assumes that its pistons stand: the board's readings, corrected by what the test says of the rig.
#[derive(Clone, Debug)]
pub struct Standing {
    /// Displacement, mm, and force, kN, from actuator 1 on, as the loop uses them.
    taken: Vec<[f64; 2]>,
    /// A second transducer is compared with that of the only actuator.
    pub seen_twice: bool,
}

impl Standing {
    /// From the step `step` of the board `identity`, for the actuators of a test with this many coordinates. A second
    /// displacement, that of actuator 1, is compared if the test has a limit for it and the board has no other actuator.
    pub fn of(identity: &Identity, coordinates: usize, step: &StepReport, config: &Config) -> Self {
        let each = identity.calibrations().enumerate().take(coordinates);
        let read = each.filter_map(|(actuator, lines)| {
            Some(lines.readings(step.codes(actuator)?).map(f64::from))
        });
        Self::by(read, config, identity.actuators() == 1)
    }

    /// From displacements, m, and forces, N, as they are read; `alone`: the board has one actuator.
    fn by(read: impl Iterator<Item = [f64; 2]>, config: &Config, alone: bool) -> Self {
        let taken = read.enumerate().map(|(actuator, [m, n])| {
            [
                config.rig.displacement_m(actuator, m) * 1e3,
                config.rig.force_n(actuator, n) * 1e-3,
            ]
        });
        Self {
            taken: taken.collect(),
            seen_twice: config.limits.disagree_m.is_some() && alone,
        }
    }

    /// The question to a person before anything moves. Without a second transducer it does not contain the board's
    /// reading, which the person would only repeat.
    pub fn question(&self) -> String {
        if self.seen_twice {
            let read = self
                .taken
                .iter()
                .map(|[mm, kn]| format!("{mm:.2} mm with {kn:.2} kN"));
            return format!(
                "the board reads {}: Enter, if that is where it stands on the piston, arms it and lets it go slowly to zero; Ctrl-C gives it up",
                read.collect::<Vec<_>>().join(", ")
            );
        }
        let what = match self.taken.len() {
            1 => "where does the piston stand on its scale, mm".to_owned(),
            all => format!(
                "where do the {all} pistons stand on their scales, mm, with commas between them"
            ),
        };
        format!(
            "{what} (none, where none hangs on the board)? If the board reads the same, it is armed and lets go slowly to zero; Ctrl-C gives it up"
        )
    }

    /// Checks that the pistons stand where a person says.
    ///
    /// # Errors
    /// They do not.
    pub fn compare(&self, said: &PistonsAt) -> Result<(), Failure> {
        let PistonsAt::Mm(said) = said else {
            return Ok(());
        };
        if said.len() != self.taken.len() {
            return Err(Failure::input(format!(
                "the positions of {} pistons were stated: accepted are {}, as many as the board has actuators; nothing has moved",
                said.len(),
                self.taken.len()
            )));
        }
        let each = said.iter().zip(&self.taken).enumerate();
        let mut off = each.filter(|(_, (said, [read, _]))| (*said - read).abs() > OFF_MM);
        match off.next() {
            None => Ok(()),
            Some((actuator, (said, [read, _]))) => Err(Failure::test(format!(
                "the piston of actuator {} was said to stand at {said} mm, and the board reads {read:.2} mm: look at the transducer, \
                 its calibration and the test's [rig] (accepted is {OFF_MM} mm of difference); nothing has moved",
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
            taken: vec![[12.3, 0.0], [-4.0, 1.0]],
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

    /// A piston at 5 mm by its transducer, in a test that says that this reads 3 mm too much: for the loop it is at 2 mm.
    #[test]
    fn a_person_is_compared_with_what_the_loop_believes() {
        let mut config = Config::shear_frame([1000.0], [158e3], [0.02]);
        config.rig.displacement_offset_m = [3e-3].into_iter().collect();
        let standing = Standing::by([[5e-3, 0.0]].into_iter(), &config, true);
        let said = |mm: &str| standing.compare(&mm.parse().unwrap());
        assert!(said("2").is_ok());
        let wrong = said("5").unwrap_err().to_string();
        assert!(wrong.contains("2.0"), "{wrong}");
    }
}
