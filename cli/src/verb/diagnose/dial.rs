//! `diagnose --dial`: records at different settings of one adjustment of the rig.

use super::Diagnose;
use crate::terminal;
use diagnosis::{Diagnosis, Dose, Model, Turned, turned};
use experiment::failure::Failure;
use experiment::files::measured::RecordFiles;

/// Fewer settings may show a trend by chance.
const FEWEST: usize = 3;

impl Diagnose {
    /// How the named parameters follow the dial; `None` without a dial.
    ///
    /// # Errors
    /// Fewer than three settings; a repeated setting; a record that cannot be used.
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
