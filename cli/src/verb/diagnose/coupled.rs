//! `outerloop diagnose` for a specimen with several coordinates.

use super::{Diagnose, hand_over};
use crate::answer::of_coupled;
use crate::provenance::WithProvenance;
use crate::terminal;
use diagnosis::{CoupledDiagnosis, CoupledSpecimen, CoupledVerdict, Model};
use experiment::failure::Failure;
use experiment::files::measured::RecordFiles;
use experiment::files::{coupled, model, output};
use std::path::Path;

impl Diagnose {
    /// Diagnoses the table `[coupled]` of a model.
    ///
    /// # Errors
    /// Data that cannot be judged; an option that does not apply here.
    pub(super) fn several(
        &self,
        declared: &CoupledSpecimen,
        out: Option<&Path>,
    ) -> Result<(), Failure> {
        for (name, given) in [
            ("--rest", !self.rest.is_empty()),
            ("--remainder", self.remainder),
            ("--next", self.next.is_some()),
            ("--witness", !self.witness.is_empty()),
            ("--dial", !self.dial.is_empty()),
        ] {
            if given {
                return Err(Failure::input(format!(
                    "{name} has no meaning for a model of several coordinates, [coupled]: accepted are --train, --test, \
                     --save-model, --out and --json"
                )));
            }
        }
        let mut library = RecordFiles::with(&self.columns);
        let [train, test] = coupled::parts(&mut library, declared, [&self.train, &self.test])?;
        let d = terminal::while_waiting("diagnosing", || {
            diagnosis::diagnose_coupled(declared, &train, &test)
        })
        .map_err(Failure::input)?;
        let text = |specimen: &CoupledSpecimen| {
            model::to_toml(&Model {
                coupled: Some(specimen.clone()),
                ..Model::default()
            })
        };
        let improved = text(&d.improved)?;
        if let Some(path) = &self.save_model {
            output::write(path, &improved)?;
        }
        let stated = text(declared)?;
        hand_over(
            (out, self.json),
            || Ok(vec![("model.toml", improved.as_str())]),
            |page| {
                let models = [stated.as_str(), improved.as_str()];
                let mut document = of_coupled(&self.title(), &d, models, page);
                if let Some(path) = &self.save_model {
                    document.tell(format!("{} is in {}", saved(&d), path.display()));
                }
                document.with_figures("diagnosis.json", &WithProvenance::of(&d))
            },
        )
    }
}

/// An accurate name for a saved model.
fn saved(d: &CoupledDiagnosis) -> &'static str {
    let right = |v: CoupledVerdict| matches!(v, CoupledVerdict::None | CoupledVerdict::Unknown);
    if d.coordinates.iter().all(|c| right(c.verdict)) {
        "The model as it was declared"
    } else {
        "The improved model"
    }
}
