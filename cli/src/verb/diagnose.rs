//! `outerloop diagnose`: what the declared model lacks to explain a measurement.

mod coupled;
mod dial;
mod setting;
mod witness;

use super::hand_over;
use crate::answer::{DiagnosisSection, Witness, of_diagnosis};
use crate::designed_test;
use crate::provenance::WithProvenance;
use crate::terminal;
use diagnosis::{Diagnosis, ForceUnit, Model, Next, Turned};
use experiment::failure::Failure;
use experiment::files::columns::Columns;
use experiment::files::measured::{FilePart, RecordFiles, without_force_unit};
use experiment::files::witness::WitnessColumn;
use experiment::files::{look_ahead, model, output};
use plant::Channel;
use schemars::JsonSchema;
use serde::Serialize;
use setting::DialArgument;
use std::path::{Path, PathBuf};

/// Find what the declared model lacks
#[derive(clap::Args, Debug)]
pub struct Diagnose {
    /// The declared model
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Training record, in which effects are searched; may be given several times
    #[arg(long, value_name = "FILE[@T0..T1]", required = true)]
    train: Vec<FilePart>,
    /// Held-out record, which judges the answer and takes no part in the search; may be given several times
    #[arg(long, value_name = "FILE[@T0..T1]", required = true)]
    test: Vec<FilePart>,
    /// Data without motion, for estimating the noise; left out: searched for before and after the motion
    #[arg(long, value_name = "FILE@T0..T1")]
    rest: Vec<FilePart>,
    /// Write the improved model there
    #[arg(long, value_name = "FILE")]
    save_model: Option<PathBuf>,
    /// Add a correction without a name to the saved model, if the remaining error depends clearly enough on the motion in
    /// held-out data
    #[arg(long)]
    remainder: bool,
    /// Design the test that tells most about what is left open, and write its command there (time_s,command_mm). It
    /// keeps the limits of the model's table [limits], else the range of the records. If no test can tell more, none is
    /// written, and the answer says so
    #[arg(long, value_name = "FILE")]
    next: Option<PathBuf>,
    /// An unused channel, such as a pressure, tested for the named effect: its file, and its column by name or number; may be given
    /// several times
    #[arg(long, value_name = "FILE:COLUMN")]
    witness: Vec<WitnessColumn>,
    /// Records at three or more settings of one adjustment, such as the tension of a brake, each with the value of its setting; checks
    /// that only the named parameter follows
    #[arg(long, value_name = "VALUE=FILE[@T0..T1]")]
    dial: Vec<DialArgument>,
    /// Write report.html, diagnosis.json and model.toml there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

impl Diagnose {
    /// Diagnoses the records.
    ///
    /// # Errors
    /// Data or a model that cannot be judged.
    pub fn run(&self) -> Result<(), Failure> {
        let out = look_ahead::folder(
            self.out.as_deref(),
            &["report.html", "diagnosis.json", "model.toml"],
        )?;
        let out = out.as_deref();
        let is_model = |text: &str| model::parse("", text).is_ok();
        look_ahead::file_of_kind(self.save_model.as_deref(), "declared model", is_model)?;
        look_ahead::file_of_kind(
            self.next.as_deref(),
            "designed test",
            designed_test::is_designed,
        )?;
        let declared = model::load(&self.model)?;
        if let Some(specimen) = &declared.coupled {
            return self.several(specimen, out);
        }
        let mut library = RecordFiles::with(&self.columns);
        let mut sets = [library.parts(&self.train)?, library.parts(&self.test)?];
        let rest = library.parts(&self.rest)?;
        let called = self.called(&declared, &mut sets)?;
        let [train, test] = &sets;
        let specimen = declared.specimen.as_ref();
        if library.force_in_newtons()
            && specimen.is_some_and(|s| s.force_unit == ForceUnit::Without)
        {
            return Err(Failure::input(format!(
                "{}: specimen.force_unit is \"1\", and the records' force is in newtons: accepted is a model in newtons, \
                 without this key",
                self.model.display()
            )));
        }
        let mut diagnosis = terminal::while_waiting("diagnosing", || {
            diagnosis::diagnose(&declared, train, test, &rest)
        })
        .map_err(Failure::input)?;
        if self.remainder {
            with_remainder(&mut diagnosis);
        } else {
            let channels = diagnosis.channels.iter_mut();
            channels.for_each(|c| c.error_with_remainder = None);
        }
        if !library.force_has_unit() {
            without_force_unit(&mut diagnosis);
        }
        let beside = Beside {
            witness: self.heard(&declared, &diagnosis, &sets, &called),
            dial: self.turned(&declared, &diagnosis, &mut library)?,
        };
        let next = match &self.next {
            Some(path) if diagnosis::why_no_test(&diagnosis).is_none() => {
                let design = || diagnosis::next(&declared, &diagnosis, train, test);
                let next = terminal::while_waiting("designing the next test", design);
                let next = next.map_err(|e| Failure::input(format!("--next: {e}")))?;
                designed_test::write(path, &next)?;
                Some(next)
            }
            _ => None,
        };
        self.answer(&declared, &diagnosis, (next.as_ref(), &beside), out)
    }

    /// Writes and prints the result.
    fn answer(
        &self,
        declared: &Model,
        diagnosis: &Diagnosis,
        (next, beside): (Option<&Next>, &Beside),
        out: Option<&Path>,
    ) -> Result<(), Failure> {
        let designed = next.zip(self.next.as_deref());
        let no_test = self.next.as_deref().zip(diagnosis::why_no_test(diagnosis));
        let answer = DiagnosisAnswer {
            diagnosis,
            next: designed.map(|(design, file)| Designed { file, design }),
            no_test: no_test.as_ref().map(|(_, why)| why.as_str()),
            beside,
        };
        let (stated, improved) = (
            model::to_toml(declared)?,
            model::to_toml(&diagnosis.improved)?,
        );
        if let Some(path) = &self.save_model {
            output::write(path, &improved)?;
        }
        hand_over(
            (out, self.json),
            || Ok(vec![("model.toml", improved.as_str())]),
            |page| {
                let section = DiagnosisSection {
                    title: &self.title(),
                    diagnosis,
                    next,
                    witnesses: &beside.witness,
                    dial: beside.dial.as_deref(),
                    models: [&stated, &improved],
                };
                let mut d = of_diagnosis(&section, page);
                if let Some((_, path)) = designed {
                    d.tell(format!(
                        "The command of the next test is in {}",
                        path.display()
                    ));
                }
                if let Some((path, why)) = &no_test {
                    d.tell(format!("{} is not written: {why}.", path.display()));
                }
                if let Some(path) = &self.save_model {
                    d.tell(format!("{} is in {}", saved(diagnosis), path.display()));
                }
                d.with_figures("diagnosis.json", &WithProvenance::of(&answer))
            },
        )
    }

    fn title(&self) -> String {
        let (record, model) = (file_name(&self.train[0].file), file_name(&self.model));
        format!("What {record} says about {model}")
    }
}

/// A diagnosis as JSON, and the next test where one was asked for.
#[derive(Serialize, JsonSchema)]
pub(crate) struct DiagnosisAnswer<'a> {
    #[serde(flatten)]
    diagnosis: &'a Diagnosis,
    #[serde(skip_serializing_if = "Option::is_none")]
    next: Option<Designed<'a>>,
    /// Why no next test was designed, where --next asked for one.
    #[serde(skip_serializing_if = "Option::is_none")]
    no_test: Option<&'a str>,
    #[serde(flatten)]
    beside: &'a Beside,
}

/// What other channels and other records say about the named effects.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Beside {
    /// Channels that took no part in the diagnosis (--witness).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    witness: Vec<Witness>,
    /// Records at several settings of one adjustment (--dial).
    #[serde(skip_serializing_if = "Option::is_none")]
    dial: Option<Vec<Turned>>,
}

/// The next test as JSON.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Designed<'a> {
    file: &'a Path,
    #[serde(flatten)]
    design: &'a Next,
}

/// Adds the corrections without a name to the model that is saved.
fn with_remainder(diagnosis: &mut Diagnosis) {
    let Diagnosis {
        channels, improved, ..
    } = diagnosis;
    for c in channels {
        let Some(correction) = c.correction.clone() else {
            continue;
        };
        let model = if c.effects.is_empty() {
            "Nothing that has a name is added to the model; what is saved has"
        } else {
            "The improved model has"
        };
        c.notes.push(format!(
            "{model} a correction of the rest beside it, which has no name: it holds only inside the range of the training data, \
             and it does not say what is missing."
        ));
        match c.channel {
            Channel::Actuator => {
                if let Some(a) = &mut improved.actuator {
                    a.remainder = Some(correction);
                }
            }
            Channel::Specimen => {
                if let Some(s) = &mut improved.specimen {
                    s.remainder = Some(correction);
                }
            }
        }
    }
}

/// An accurate name for a saved model.
fn saved(diagnosis: &Diagnosis) -> &'static str {
    let channels = || diagnosis.channels.iter();
    if channels().any(|c| c.error_with_remainder.is_some()) {
        "The model with a correction that has no name"
    } else if channels().any(|c| !c.effects.is_empty()) {
        "The improved model"
    } else if channels().any(|c| !c.refitted.is_empty()) {
        "The declared model, refitted and with nothing added,"
    } else {
        "The model as it was declared"
    }
}

/// The last part of a path.
fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}
