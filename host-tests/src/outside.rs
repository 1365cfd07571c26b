//! Third-party records with known causes: `outside/cases.toml` in the folder of the data.

use diagnosis::{ChannelAnswer, Model, Recording, Verdict};
use experiment::files::measured::{FilePart, RecordFiles};
use experiment::files::model;
use experiment::watch::{WatchReport, agreement, of_record};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A published parameter.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Published {
    /// Its value.
    pub value: f64,
    /// By how much an answer may differ.
    pub tolerance: f64,
}

/// Errors of a textbook fit.
#[derive(Clone, Debug, Deserialize)]
pub struct Reference {
    /// Error of the declared model, a fraction of the scatter.
    pub before_nrmse: f64,
    /// Error of the best single textbook law.
    pub after_nrmse: f64,
}

/// A record with its cause.
#[derive(Clone, Debug, Deserialize)]
pub struct Case {
    /// The folder of its files.
    #[serde(skip)]
    folder: PathBuf,
    /// Short name.
    pub id: String,
    /// `actuator` or `specimen`.
    pub channel: String,
    model: String,
    train: Vec<String>,
    test: Vec<String>,
    rest: Vec<String>,
    /// Correct verdicts.
    pub verdicts: Vec<String>,
    /// Correct names.
    pub names: Vec<String>,
    /// Half-correct names.
    pub half: Vec<String>,
    /// A set is correct if it contains one of these.
    pub set_must_hold_one_of: Vec<String>,
    /// Names that are always wrong, however well they fit.
    pub never: Vec<String>,
    /// Accepted names of each cause, if the case gives them.
    #[serde(default)]
    pub both: Vec<Vec<String>>,
    /// What is known of the cause.
    pub cause: String,
    /// Parameters as published.
    #[serde(default)]
    pub published: BTreeMap<String, Published>,
    /// Errors of a textbook fit.
    pub reference: Reference,
}

#[derive(Deserialize)]
struct Cases {
    case: Vec<Case>,
}

/// All cases of the first lot; `None` if the data are missing, which is counted.
pub fn cases() -> Option<Vec<Case>> {
    lot("outside")
}

/// All cases of a folder of the data.
pub fn lot(folder: &str) -> Option<Vec<Case>> {
    let path = test_data::file(&format!("{folder}/cases.toml"))?;
    cases_in(path.parent()?).ok()
}

/// All cases of a folder.
///
/// # Errors
/// The `cases.toml` cannot be read or parsed.
pub fn cases_in(folder: &Path) -> Result<Vec<Case>, String> {
    let path = folder.join("cases.toml");
    let refuse = |why: String| format!("{}: {why}", path.display());
    let text = std::fs::read_to_string(&path).map_err(|e| refuse(e.to_string()))?;
    let mut cases: Cases = toml::from_str(&text).map_err(|e| refuse(e.to_string()))?;
    for case in &mut cases.case {
        case.folder = folder.to_path_buf();
    }
    Ok(cases.case)
}

/// As [`Case::watched`], for a record with its model.
///
/// # Errors
/// The sentence of a refusal.
pub fn watched(declared: &Model, record: &Recording) -> Result<WatchReport, String> {
    let mut report = of_record(declared, record).map_err(|e| e.to_string())?;
    report.diagnosis = agreement(declared, record, &report, 1.0);
    Ok(report)
}

impl Case {
    /// The answer of `outerloop diagnose`, and how long it took.
    ///
    /// # Errors
    /// The sentence of a refusal.
    pub fn diagnose(&self) -> Result<(ChannelAnswer, f64), String> {
        self.between(&self.train, &self.test)
    }

    /// The whole first held-out file, and the start of its span, s.
    ///
    /// # Errors
    /// The sentence of a refusal.
    pub fn held_out(&self) -> Result<(Recording, f64), String> {
        let folder = &self.folder;
        let first = self.test.first().ok_or("nothing is held out")?;
        let (file, span) = first.split_once('@').unwrap_or((first, "0.."));
        let from_s = span.split_once("..").and_then(|s| s.0.parse().ok());
        let part: FilePart = folder.join(file).display().to_string().parse()?;
        let whole = RecordFiles::default()
            .parts(&[part])
            .map_err(|e| e.to_string())?;
        let whole = whole.into_iter().next().ok_or("no record")?;
        Ok((whole, from_s.unwrap_or(0.0)))
    }

    /// What the rig watch would have said during the whole first held-out file, and whether the diagnosis agrees.
    ///
    /// # Errors
    /// The sentence of a refusal.
    pub fn watched(&self) -> Result<WatchReport, String> {
        let (record, _) = self.held_out()?;
        let declared = model::load(&self.folder.join(&self.model)).map_err(|e| e.to_string())?;
        watched(&declared, &record)
    }

    /// Training and held-out spans.
    pub fn spans(&self) -> [&[String]; 2] {
        [&self.train, &self.test]
    }

    /// The same with other spans.
    ///
    /// # Errors
    /// The sentence of a refusal.
    pub fn between(
        &self,
        train: &[String],
        test: &[String],
    ) -> Result<(ChannelAnswer, f64), String> {
        let folder = &self.folder;
        let mut library = RecordFiles::default();
        let mut parts = |spans: &[String]| {
            let parse = |s: &String| {
                let (file, span) = s.split_once('@').map_or((s.as_str(), ""), |p| p);
                let at = if span.is_empty() {
                    String::new()
                } else {
                    format!("@{span}")
                };
                format!("{}{at}", folder.join(file).display()).parse::<FilePart>()
            };
            let parts: Vec<FilePart> = spans.iter().map(parse).collect::<Result<_, _>>()?;
            library.parts(&parts).map_err(|e| e.to_string())
        };
        let (train, test, rest) = (parts(train)?, parts(test)?, parts(&self.rest)?);
        let declared = model::load(&folder.join(&self.model)).map_err(|e| e.to_string())?;
        let found =
            diagnosis::diagnose(&declared, &train, &test, &rest).map_err(|e| e.to_string())?;
        let own = found
            .channels
            .into_iter()
            .find(|c| c.channel.name() == self.channel);
        Ok((own.ok_or("the channel is missing")?, found.seconds))
    }

    /// Whether both causes are among the names; `None` if there is only one cause.
    pub fn has_both(&self, a: &ChannelAnswer) -> Option<bool> {
        let named = |names: &Vec<String>| {
            a.effects
                .iter()
                .any(|e| names.iter().any(|n| n == e.name.name()))
        };
        (self.both.len() > 1).then(|| self.both.iter().all(named))
    }

    /// Whether an answer that is not a set names a wrong effect; if the only correct verdict is `none`, any effect is wrong.
    pub fn is_wrong(&self, a: &ChannelAnswer) -> bool {
        let sure = !matches!(a.verdict, Verdict::Ambiguous);
        let wrong = |n: &str| self.never.iter().any(|w| w == n) || self.verdicts == ["none"];
        sure && a.effects.iter().any(|e| wrong(e.name.name()))
    }

    /// Points by the rules of the cases: 1 for a correct name or set with an error of at most 1.4 times a textbook fit's;
    /// half for a larger error, for a half-correct name and for `unknown` with the right nearest; 0 for a wrong name.
    pub fn points(&self, a: &ChannelAnswer) -> f64 {
        let verdict = match a.verdict {
            Verdict::None => "none",
            Verdict::Effect => "effect",
            Verdict::Ambiguous => "ambiguous",
            Verdict::Partial => "partial",
            Verdict::Unknown => "unknown",
            Verdict::NotAssessed => "not_assessed",
        };
        let has = |list: &[String], name: &str| list.iter().any(|n| n == name);
        if verdict == "unknown" {
            let near = a
                .nearest
                .as_ref()
                .is_some_and(|n| has(&self.names, n.name.name()));
            return match (has(&self.verdicts, "unknown"), near) {
                (true, _) => 1.0,
                (false, true) => 0.5,
                _ => 0.0,
            };
        }
        if verdict == "none" {
            return f64::from(u8::from(has(&self.verdicts, verdict)));
        }
        let named: Vec<&str> = a.effects.iter().map(|e| e.name.name()).collect();
        if named.iter().any(|n| has(&self.never, n)) || !has(&self.verdicts, verdict) {
            return 0.0;
        }
        let close = a.error_after.test_nrmse <= 1.4 * self.reference.after_nrmse;
        let share = if close { 1.0 } else { 0.5 };
        let mut all = named.clone();
        if verdict == "ambiguous" {
            all.extend(a.alternatives.iter().map(|e| e.name()));
            let holds = all.iter().any(|n| has(&self.set_must_hold_one_of, n));
            return if holds { share } else { 0.0 };
        }
        if named.iter().any(|n| has(&self.names, n)) {
            share
        } else if named.iter().any(|n| has(&self.half, n)) {
            0.5 * share
        } else {
            0.0
        }
    }
}
