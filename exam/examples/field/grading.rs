//! Has this repository's diagnosis answer field records, and grades its answers.

use diagnosis::{ActuatorModel, Declared, Diagnosis, Model, Recording, SpecimenModel, Verdict};
use exam::Parameter;
use exam::field::{Believed, Field, Mark, Said, Span};

/// A field record, answered and graded.
pub struct GradedField {
    pub id: String,
    pub cause: &'static str,
    pub mark: Mark,
    pub said: Said,
    /// The nearest effects, the parameters that were found, and the notes.
    pub notes: Vec<String>,
    /// The names that were given with a `q`.
    pub vouched: Vec<Vouched>,
    /// Members of a set and possible additions to sure names: the probability of each, and whether it is in the rig.
    pub open: Vec<(f64, bool)>,
    /// True if at most one name is right: where several are, each is in the rig more often than its own probability.
    pub one_name: bool,
    /// Held-out NRMSE before, after, and the stated floor.
    pub errors: [f64; 3],
    /// How long the diagnosis took, s; 0 if it refused.
    pub seconds: f64,
    pub samples: usize,
}

/// A name, and how sure the diagnosis is of it.
#[derive(Clone, Debug)]
pub struct Vouched {
    pub name: &'static str,
    pub q: f64,
    /// Not in the rig, or claimed to be more of the cause than it is.
    pub is_false: bool,
    /// Held-out error after naming it, over the one before.
    pub leaves: f64,
    pub actuator: bool,
}

impl Vouched {
    /// As a table row: name, channel, whether it is false, share of the error left, `q`.
    pub fn row(&self) -> String {
        format!(
            "{} | {} | {} | {:.3} | {}",
            self.name,
            if self.actuator {
                "actuator"
            } else {
                "specimen"
            },
            u8::from(self.is_false),
            self.leaves,
            self.q
        )
    }
}

/// A record as the examinee gets it.
pub fn recording(name: &str, r: &exam::Record, before: Option<Box<Recording>>) -> Recording {
    let column = |c: &Vec<f64>| (!c.is_empty()).then(|| c.clone());
    Recording {
        name: name.into(),
        time_s: r.time_s.clone(),
        command_mm: column(&r.command_mm),
        displacement_mm: column(&r.displacement_mm),
        force_n: column(&r.force_n),
        before,
        ..Recording::default()
    }
}

/// The two records as the examinee gets them.
pub fn recordings(field: &Field) -> [Recording; 2] {
    let span = |name: &str, s: &Span| {
        let before = s.before.as_ref().map(|r| recording(name, r, None));
        recording(name, &s.record, before.map(Box::new))
    };
    [span("train", &field.train), span("test", &field.test)]
}

/// The declared model that the examinee gets.
pub fn model(believed: &Believed) -> Model {
    let known = |p: Parameter| Declared {
        value: p.value,
        tolerance: p.tolerance,
    };
    match believed {
        Believed::Actuator([gain, delay, lag, offset]) => Model {
            actuator: Some(ActuatorModel {
                gain: Some(known(*gain)),
                delay_ms: Some(known(*delay)),
                lag_ms: Some(known(*lag)),
                offset_mm: Some(known(*offset)),
                ..ActuatorModel::default()
            }),
            specimen: None,
            ..Model::default()
        },
        Believed::Specimen(all) => {
            let [k, c, m, offset] = all.map(|p| p.map(known));
            Model {
                actuator: None,
                specimen: Some(SpecimenModel {
                    stiffness_n_per_mm: k,
                    damping_n_s_per_mm: c,
                    mass_kg: m,
                    offset_n: offset,
                    ..SpecimenModel::default()
                }),
                ..Model::default()
            }
        }
    }
}

/// What the diagnosis said about the channel.
pub fn said(found: &Diagnosis) -> Said {
    let a = &found.channels[0];
    let verdict = match a.verdict {
        Verdict::None => "none",
        Verdict::Effect => "effect",
        Verdict::Ambiguous => "ambiguous",
        Verdict::Partial => "partial",
        Verdict::Unknown => "unknown",
        Verdict::NotAssessed => "not assessed",
    };
    Said {
        verdict: verdict.into(),
        names: a.effects.iter().map(|e| e.name.name().into()).collect(),
        others: a.alternatives.iter().map(|e| e.name().into()).collect(),
        q: a.effects.iter().filter_map(|e| e.q).collect(),
    }
}

fn notes(found: &Diagnosis) -> Vec<String> {
    let a = &found.channels[0];
    let nearest = a
        .nearest
        .iter()
        .map(|n| format!("nearest {} {:.2}", n.name, n.explained));
    let numbers = a.effects.iter().map(|e| {
        let each = |p: &diagnosis::FoundParameter| format!("{} {:.4} {}", p.name, p.value, p.unit);
        let all: Vec<String> = e.parameters.iter().map(each).collect();
        format!("{}: {}", e.name, all.join(", "))
    });
    let ordinary = a.ordinary.then(|| "an ordinary ram".to_owned());
    nearest
        .chain(numbers)
        .chain(ordinary)
        .chain(a.notes.iter().cloned())
        .collect()
}

/// Has a record diagnosed and grades the answer.
pub fn answer(field: Field) -> GradedField {
    let [train, test] = recordings(&field);
    let samples = train.time_s.len();
    let found = diagnosis::diagnose(&model(&field.believed), &[train], &[test], &[]);
    let (said, vouched, open, errors, seconds) = match &found {
        Err(why) => {
            let said = Said {
                verdict: format!("refused: {why}"),
                ..Said::default()
            };
            (said, Vec::new(), Vec::new(), [0.0; 3], 0.0)
        }
        Ok(d) => {
            let a = &d.channels[0];
            let mut said = said(d);
            let claims_all = field.truth.mark(&said) == Mark::Overclaimed;
            let leaves = a.error_after.test_rms / a.error_before.test_rms.max(f64::MIN_POSITIVE);
            let vouched = a.effects.iter().filter_map(|e| {
                Some(Vouched {
                    name: e.name.name(),
                    q: e.q?,
                    is_false: claims_all || !field.truth.allows(e.name.name()),
                    leaves,
                    actuator: matches!(field.believed, Believed::Actuator(_)),
                })
            });
            let members = a.members.iter();
            let open = members.map(|m| (m.probability, field.truth.allows(m.name.name())));
            let unit = a.error_before.test_nrmse / a.error_before.test_rms.max(f64::MIN_POSITIVE);
            let errors = [
                a.error_before.test_nrmse,
                a.error_after.test_nrmse,
                a.noise_floor_rms * unit,
            ];
            if a.verdict == Verdict::NotAssessed {
                said.verdict = format!("not assessed: {}", a.notes.join(" "));
            }
            (said, vouched.collect(), open.collect(), errors, d.seconds)
        }
    };
    GradedField {
        mark: field.truth.mark(&said),
        cause: field.truth.cause,
        id: field.id,
        said,
        vouched,
        open,
        one_name: field.truth.right.len() + field.truth.beside.len() <= 1,
        notes: found.map_or_else(|_| Vec::new(), |d| notes(&d)),
        errors,
        seconds,
        samples,
    }
}
