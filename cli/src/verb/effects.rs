//! `outerloop effects`: every effect with its name in files and results.

use super::{hand_over, no_files};
use crate::document::{Document, table};
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
    /// A list that cannot be written as JSON.
    pub fn run(&self) -> Result<(), Failure> {
        let all: Vec<_> = catalogue().iter().map(ListedEffect::of).collect();
        hand_over((None, self.json), no_files, |page| {
            document(&all, page).with_figures("effects.json", &all)
        })
    }
}

fn document(all: &[ListedEffect], with_page: bool) -> Document {
    let head = ["family", "effect", "channels", "parameters [unit]"];
    let mut t = table(&head).with_words(4).of_text();
    let mut family = "";
    for e in all {
        let mut parameters: Vec<String> = Vec::new();
        for p in &e.parameters {
            let text = match p.unit {
                "" => p.name.to_owned(),
                unit => format!("{} [{unit}]", p.name),
            };
            if !parameters.contains(&text) {
                parameters.push(text);
            }
        }
        let shown = if family == e.family { "" } else { e.family };
        family = e.family;
        let (channels, parameters) = (e.channels.join(", "), parameters.join("\n"));
        t.add_row([shown, e.name, &channels, &parameters]);
    }
    let mut d = Document::new("Effects", "What a rig can have.", with_page);
    d.table(t);
    d
}
