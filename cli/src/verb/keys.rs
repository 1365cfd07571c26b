//! `outerloop keys`: every key of a test file.

use super::{hand_over, no_files};
use crate::document::{self, Document, table};
use crate::keys;
use crate::terminal::output;
use experiment::failure::Failure;
use experiment::nearest::nearest;

/// List every key of a test file: unit, default, what is accepted, meaning
#[derive(clap::Args, Debug)]
pub struct Keys {
    /// Only keys whose path or meaning contains this, e.g. `delay` or `plant.actuator`
    filter: Option<String>,
    /// Print a page in Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// One JSON list on standard output and nothing else
    #[arg(long)]
    json: bool,
}

impl Keys {
    /// Lists them.
    ///
    /// # Errors
    /// A filter that matches no key.
    pub fn run(&self) -> Result<(), Failure> {
        let mut groups = keys::all();
        if let Some(filter) = &self.filter {
            let wanted = filter.to_lowercase();
            for group in &mut groups {
                group.keys.retain(|k| {
                    k.path.contains(&wanted) || k.meaning.to_lowercase().contains(&wanted)
                });
            }
            groups.retain(|g| !g.keys.is_empty());
            if groups.is_empty() {
                let all = keys::all();
                let paths = all.iter().flat_map(|group| {
                    let keys = group.keys.iter().map(|key| key.path.as_str());
                    std::iter::once(group.path.as_str()).chain(keys)
                });
                let meant = nearest(&wanted, paths).map_or(String::new(), |n| format!(" (`{n}`?)"));
                return Err(Failure::input(format!(
                    "no key has `{filter}`{meant} in its path or meaning: `outerloop keys` lists all"
                )));
            }
        }
        if self.markdown {
            answer!("{}", keys::markdown(&groups)?.trim_end());
            return Ok(());
        }
        hand_over((None, self.json), no_files, |page| {
            document(&groups, page).with_figures("keys.json", &groups)
        })
    }
}

fn document(groups: &[keys::Group], with_page: bool) -> Document {
    let mut d = Document::new("Keys of a test file", "", with_page);
    for group in groups {
        let heading = format!("[{}]  {}", group.path, group.meaning);
        d.say(output::for_reading(&heading));
        let head = ["key", "unit", "default", "accepted", "meaning"];
        let mut t = table(&head).with_words(5).of_text();
        for key in &group.keys {
            t.add_row([
                key.name(),
                key.unit,
                key.default.as_deref().unwrap_or(""),
                &key.accepted,
                &key.meaning,
            ]);
        }
        d.table(t);
    }
    d
}

/// Print the JSON Schema of a file or of an answer
#[derive(clap::Args, Debug)]
pub struct Schema {
    /// `test`, `model`, or a verb for the answer of its --json; left out: prints all names
    what: Option<String>,
}

impl Schema {
    /// Prints it.
    ///
    /// # Errors
    /// A name without a schema.
    pub fn run(&self) -> Result<(), Failure> {
        let names = keys::SCHEMAS.map(|(name, _)| name);
        let Some(what) = &self.what else {
            answer!("{}", names.join("\n"));
            return Ok(());
        };
        let found = keys::SCHEMAS.iter().find(|(name, _)| name == what);
        let (_, schema) = found.ok_or_else(|| {
            let all = names.join(", ");
            Failure::input(format!(
                "the schema `{what}` is unknown: accepted are {all}"
            ))
        })?;
        answer!("{}", document::json(&schema())?);
        Ok(())
    }
}
