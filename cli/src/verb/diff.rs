//! `outerloop diff`: two tests that ran, side by side.

use super::{hand_over, json};
use crate::archive;
use crate::difference::{self, Difference};
use crate::provenance::WithProvenance;
use crate::report;
use crate::terminal;
use experiment::failure::Failure;
use experiment::files::look_ahead;
use experiment::numbers::percent;
use serde_json::Value;
use std::path::PathBuf;

/// Compare two recorded tests: different settings, figures, how far apart their motions are
#[derive(clap::Args, Debug)]
pub struct Diff {
    /// The first test: the folder of `run --out`, its record.h5, or the file of `run --archive`
    first: PathBuf,
    /// The second test
    second: PathBuf,
    /// Exit with 1 where the computed displacement of a floor differs by more than this share of its peak, rms
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    within: Option<f64>,
    /// Write report.html and difference.json there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

impl Diff {
    /// Compares.
    ///
    /// # Errors
    /// No archive; tests of structures with other floors; motions further apart than `--within`.
    pub fn run(&self) -> Result<(), Failure> {
        let names = ["report.html", "difference.json"];
        let out = look_ahead::folder(self.out.as_deref(), &names)?;
        if let Some(share) = self.within.filter(|s| !(*s >= 0.0 && s.is_finite())) {
            return Err(Failure::input(format!(
                "--within {share}: accepted is a share of the peak from 0, such as 0.01 for 1 %"
            )));
        }
        let first = archive::load(&self.first)?;
        let second = archive::load(&self.second)?;
        let floors = |a: &archive::ArchivedTest| a.repeat.config.degrees_of_freedom();
        if floors(&first) != floors(&second) {
            return Err(Failure::input(format!(
                "{}, floors: {}; {}, floors: {}: accepted are two tests of as many floors",
                self.first.display(),
                floors(&first),
                self.second.display(),
                floors(&second)
            )));
        }
        let difference = Difference::of(&first, &second);
        if difference.compared_steps == 0 {
            return Err(Failure::test(format!(
                "{} and {} have no integration step in common: one of them ended before its first",
                self.first.display(),
                self.second.display()
            )));
        }
        let json_text = json(&WithProvenance::of(&difference))?;
        let page = || {
            let names = [&self.first, &self.second].map(|p| p.display().to_string());
            let page = report::of_difference(&difference, [&first, &second], &names);
            Ok(vec![("report.html", page)])
        };
        hand_over(
            (out.as_deref(), self.json),
            ("difference.json", &json_text),
            page,
            || print(&difference),
        )?;
        let apart = difference.of_displacement();
        match (self.within, apart) {
            (Some(within), Some(share)) if share > within => Err(Failure::test(format!(
                "the computed displacements differ by {} of the peak, rms: more than --within {within}",
                percent(share)
            ))),
            _ => Ok(()),
        }
    }
}

fn print(d: &Difference) {
    if d.settings.is_empty() {
        println!("The same test: no key of its configuration, rig or ground motion differs.\n");
    } else {
        let mut t = terminal::table(&["set otherwise", "first", "second"]);
        for s in &d.settings {
            t.add_row([
                s.key.clone(),
                difference::plain_text(&s.first),
                difference::plain_text(&s.second),
            ]);
        }
        println!("{t}\n");
    }
    let mut t = terminal::table(&["figure", "first", "second"]);
    for f in &d.figures {
        t.add_row([f.key.to_owned(), figure(&f.first), figure(&f.second)]);
    }
    println!("{t}\n");
    let mut t = terminal::table(&["channel", "peak", "rms apart", "of peak", "most", "at"]);
    for c in d.channels.iter().filter(|c| c.is_motion()) {
        t.add_row(c.cells());
    }
    println!("{t}");
    println!("{}", d.sentence());
}

/// A figure of a summary: a word, or a number with three digits.
fn figure(value: &Value) -> String {
    value
        .as_f64()
        .map_or_else(|| difference::plain_text(value), experiment::numbers::three)
}
