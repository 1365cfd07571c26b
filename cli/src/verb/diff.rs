//! `outerloop diff`: two completed tests, side by side.

use super::{hand_over, no_files};
use crate::answer::of_difference;
use crate::archive;
use crate::difference::Difference;
use crate::provenance::WithProvenance;
use experiment::failure::Failure;
use experiment::files::look_ahead;
use experiment::numbers::percent;
use std::path::PathBuf;

/// Compare two recorded tests: different settings, figures, how far apart their motions are
#[derive(clap::Args, Debug)]
pub struct Diff {
    /// The first test: the folder of `run --out`, its record.h5, or the file of `run --archive`
    first: PathBuf,
    /// The second test
    second: PathBuf,
    /// Exit status 1 if the computed displacement of a floor differs by more than this share of its peak, rms
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
    /// Compares two tests, without a limit on their difference.
    pub(super) fn of([first, second]: [PathBuf; 2], out: Option<PathBuf>, json: bool) -> Self {
        Self {
            first,
            second,
            within: None,
            out,
            json,
        }
    }

    /// Compares the tests.
    ///
    /// # Errors
    /// A file that is no archive; tests with different numbers of floors; motions further apart than `--within`.
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
        let wanted = (out.as_deref(), self.json);
        hand_over(wanted, no_files, |page| {
            let names = [&self.first, &self.second].map(|p| p.display().to_string());
            of_difference(&difference, [&first, &second], &names, page)
                .with_figures("difference.json", &WithProvenance::of(&difference))
        })?;
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
