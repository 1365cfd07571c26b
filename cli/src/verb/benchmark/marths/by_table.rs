//! An external controller as a table: `--targets` writes the targets, `--follow` judges its commands.

use super::super::command_table;
use super::super::followed::{Followed, FollowedMarthsRow};
use super::super::shared::refused;
use super::Marths;
use crate::answer::benchmark::of_followed;
use crate::provenance::WithProvenance;
use crate::verb::{hand_over, no_files};
use benchmarks::marths::RATE_HZ;
use benchmarks::marths::bench::MarthsRecord;
use benchmarks::marths::criteria::MEANING;
use benchmarks::marths::follow;
use benchmarks::marths::table::both;
use experiment::failure::Failure;
use experiment::files::output;
use std::path::Path;

/// The columns to be filled in.
const COMMANDS: [&str; 2] = ["command_m", "command2_m"];

impl Marths {
    /// `--targets` and `--follow`: one ground motion.
    pub(super) fn by_table(
        &self,
        records: &[MarthsRecord],
        out: Option<&Path>,
    ) -> Result<(), Failure> {
        let [record] = records else {
            return Err(Failure::input(
                "--targets and --follow: with them goes one ground motion, as in --records ElCentro",
            ));
        };
        let [first, second] = follow::targets_m(record);
        let targets = [("target_m", first), ("target2_m", second)];
        if let Some(file) = &self.targets {
            let comment = format!(
                "{}: strokes of the reference structure at {RATE_HZ} Hz. A command is held until the next sample.",
                record.name
            );
            let text = command_table::text(&comment, RATE_HZ, &targets, &COMMANDS);
            return output::write(file, text);
        }
        match &self.follow {
            Some(file) => {
                let commands_m = command_table::commands(file, &targets, &COMMANDS)?;
                self.judge((file, &commands_m), out, record)
            }
            None => Ok(()),
        }
    }

    fn judge(
        &self,
        (file, commands_m): (&Path, &[Vec<f64>]),
        out: Option<&Path>,
        record: &MarthsRecord,
    ) -> Result<(), Failure> {
        let [first, second] = commands_m else {
            return Err(Failure::input(
                "--follow: two columns of commands are wanted",
            ));
        };
        let found = follow::judge(record, [first, second], self.seed).map_err(refused)?;
        let row = FollowedMarthsRow {
            controller: file.display().to_string(),
            record: &record.name,
            j: found,
            perturbed: 0,
        };
        let answer = Followed {
            rules: "official".to_owned(),
            seed: self.seed,
            criteria: MEANING,
            rows: [row],
        };
        hand_over((out, self.json), no_files, |page| {
            let lead = format!(
                "{}, the loop not closed: the targets are those of the table, and J8 has no figure.",
                record.name
            );
            let j = &found;
            let figures = [j.j1_ms, j.j2, j.j3, j.j4_ms, j.j5, j.j6, j.j7, j.j8, j.j9];
            let true_one = ("J2 of the true strokes, %", j.j2_true);
            let all = MEANING.into_iter().zip(figures).chain([true_one]);
            let known = all.filter(|(_, figure)| figure.iter().all(|x| x.is_finite()));
            let known = known.map(|(meaning, figure)| (meaning, both(figure)));
            of_followed(lead, known, page).with_figures("marths.json", &WithProvenance::of(&answer))
        })
    }
}
