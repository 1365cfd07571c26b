//! The diagnosis of this repository takes the exam.

use super::answer::Answer;
use diagnosis::{ActuatorModel, Declared, Diagnosis, Model, Recording, SpecimenModel};
use exam::{Paper, Parameter, Record};

/// Its answer to a question; the same as `outerloop diagnose --json` prints.
///
/// # Errors
/// The sentence of a refusal.
pub fn diagnosis(paper: &Paper) -> Result<Answer, String> {
    answer(&found(paper)?)
}

/// What the diagnosis finds about the rig of a question.
///
/// # Errors
/// The sentence of a refusal.
pub fn found(paper: &Paper) -> Result<Diagnosis, String> {
    beside(paper, &model(paper))
}

/// What it finds beside a model of that rig.
///
/// # Errors
/// The sentence of a refusal.
pub fn beside(paper: &Paper, model: &Model) -> Result<Diagnosis, String> {
    let train = recording("train", &paper.train);
    let rest: Vec<Recording> = paper
        .rest_s
        .iter()
        .map(|&(from_s, to_s)| train.span(from_s, to_s))
        .collect();
    let test = recording("test", &paper.test);
    diagnosis::diagnose(model, &[train], &[test], &rest).map_err(|refusal| refusal.to_string())
}

fn answer(found: &Diagnosis) -> Result<Answer, String> {
    let value = serde_json::to_value(found).map_err(|e| e.to_string())?;
    serde_json::from_value(value).map_err(|e| e.to_string())
}

fn recording(name: &str, record: &Record) -> Recording {
    Recording {
        name: name.into(),
        time_s: record.time_s.clone(),
        command_mm: Some(record.command_mm.clone()),
        displacement_mm: Some(record.displacement_mm.clone()),
        force_n: Some(record.force_n.clone()),
        ..Recording::default()
    }
}

fn model(paper: &Paper) -> Model {
    let known = |p: Parameter| Declared {
        value: p.value,
        tolerance: p.tolerance,
    };
    let (a, s) = (&paper.declared.actuator, &paper.declared.specimen);
    Model {
        actuator: Some(ActuatorModel {
            gain: Some(known(a.gain)),
            delay_ms: Some(known(a.delay_ms)),
            lag_ms: Some(known(a.lag_ms)),
            offset_mm: a.offset_mm.map(known),
            effects: Vec::new(),
            remainder: None,
        }),
        specimen: Some(SpecimenModel {
            stiffness_n_per_mm: Some(known(s.stiffness_n_per_mm)),
            damping_n_s_per_mm: s.damping_n_s_per_mm.map(known),
            mass_kg: s.mass_kg.map(known),
            offset_n: s.offset_n.map(known),
            ..SpecimenModel::default()
        }),
        ..Model::default()
    }
}
