//! `outerloop diagnose` of a specimen of several coordinates.

use super::{Diagnose, file_name, json};
use crate::provenance::WithProvenance;
use crate::report;
use crate::terminal;
use crate::verb::look_at_report;
use diagnosis::{CoupledDiagnosis, CoupledSpecimen, CoupledVerdict, Model};
use experiment::failure::Failure;
use experiment::files::measured::RecordFiles;
use experiment::files::{coupled, model, output};
use std::path::Path;

impl Diagnose {
    /// Diagnoses the table `[coupled]` of a model.
    ///
    /// # Errors
    /// Data that cannot be judged; an option that means nothing here.
    pub(super) fn several(
        &self,
        declared: &CoupledSpecimen,
        out: Option<&Path>,
    ) -> Result<(), Failure> {
        for (name, given) in [
            ("--rest", !self.rest.is_empty()),
            ("--remainder", self.remainder),
            ("--next", self.next.is_some()),
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
        if let Some(folder) = out {
            let title = format!(
                "What {} says about {}",
                file_name(&self.train[0].file),
                file_name(&self.model)
            );
            let page = report::of_coupled(&title, &d, [&text(declared)?, &improved]);
            output::write_all(
                folder,
                &[
                    ("report.html", page),
                    ("diagnosis.json", json(&WithProvenance::of(&d))?),
                    ("model.toml", improved),
                ],
            )?;
        }
        if self.json {
            answer!("{}", json(&WithProvenance::of(&d))?);
            return Ok(());
        }
        println!("{}", terminal::coupled::coupled(&d));
        if let Some(path) = &self.save_model {
            println!("{} is in {}", saved(&d), path.display());
        }
        look_at_report(out);
        Ok(())
    }
}

/// What a saved model is, truthfully.
fn saved(d: &CoupledDiagnosis) -> &'static str {
    let right = |v: CoupledVerdict| matches!(v, CoupledVerdict::None | CoupledVerdict::Unknown);
    if d.coordinates.iter().all(|c| right(c.verdict)) {
        "The model as it was declared"
    } else {
        "The improved model"
    }
}
