//! `outerloop effects`: every effect by the name that files and answers use.

use super::json;
use crate::document::table;
use crate::terminal::output;
use experiment::failure::Failure;
use plant::catalogue;
use plant::effect::Entry;
use schemars::JsonSchema;
use serde::Serialize;

/// An effect of the list.
#[derive(Serialize, JsonSchema)]
pub struct ListedEffect {
    name: &'static str,
    family: &'static str,
    /// Where it acts.
    channels: Vec<&'static str>,
    parameters: Vec<ListedParameter>,
    /// What it does.
    physics: &'static str,
}

#[derive(Serialize, JsonSchema)]
struct ListedParameter {
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
}

impl ListedEffect {
    fn of(e: &Entry) -> Self {
        let parameters = e.parameters.iter().map(|p| ListedParameter {
            name: p.name,
            unit: p.accept.unit,
            meaning: p.meaning,
        });
        Self {
            name: e.effect.name(),
            family: e.family.name(),
            channels: e.channels.iter().map(|c| c.name()).collect(),
            parameters: parameters.collect(),
            physics: e.physics,
        }
    }
}

/// List every effect that a rig can have and a diagnosis can name
#[derive(clap::Args, Debug)]
pub struct Effects {
    /// One JSON array on standard output and nothing else
    #[arg(long)]
    json: bool,
}

impl Effects {
    /// Prints the list.
    ///
    /// # Errors
    /// None; the signature is that of every verb.
    pub fn run(&self) -> Result<(), Failure> {
        if self.json {
            let all: Vec<_> = catalogue().iter().map(ListedEffect::of).collect();
            answer!("{}", json(&all)?);
            return Ok(());
        }
        let head = ["family", "effect", "channels", "parameters [unit]"];
        let mut t = table(&head).with_words(4).of_text();
        let mut family = "";
        for e in catalogue() {
            let same = family == e.family.name();
            family = e.family.name();
            let mut parameters: Vec<String> = Vec::new();
            for p in e.parameters {
                let text = match p.accept.unit {
                    "" => p.name.to_owned(),
                    unit => format!("{} [{unit}]", p.name),
                };
                if !parameters.contains(&text) {
                    parameters.push(text);
                }
            }
            let channels: Vec<_> = e.channels.iter().map(|c| c.name()).collect();
            t.add_row([
                if same { "" } else { family }.to_owned(),
                e.effect.name().to_owned(),
                channels.join(", "),
                parameters.join("\n"),
            ]);
        }
        answer!("{}", output::for_reading(&t.to_string()));
        Ok(())
    }
}
