//! An external controller as a table: `--targets` writes the targets, `--follow` judges its commands.

use super::super::command_table;
use super::super::followed::{Followed, FollowedRthsRow};
use super::super::shared::refused;
use super::Rths;
use crate::answer::benchmark::of_followed;
use crate::provenance::WithProvenance;
use crate::verb::{hand_over, no_files};
use benchmarks::rths::case::CASES;
use benchmarks::rths::criteria::MEANING;
use benchmarks::rths::table::number;
use benchmarks::rths::{GroundRecord, RATE_HZ, Rules, follow};
use experiment::failure::Failure;
use experiment::files::output;
use std::path::Path;

/// The column to be filled in.
const COMMANDS: [&str; 1] = ["command_m"];

impl Rths {
    /// `--targets` and `--follow`: one record, one case.
    pub(super) fn by_table(
        &self,
        place: usize,
        records: &[GroundRecord],
        rules: &Rules,
        out: Option<&Path>,
    ) -> Result<(), Failure> {
        let [record] = records else {
            return Err(Failure::input(
                "--case: with it goes one ground motion, as in --records ElCentro --case 1",
            ));
        };
        let targets = [("target_m", follow::targets_m(record, place))];
        match (&self.targets, &self.follow) {
            (Some(file), _) => {
                let comment = format!(
                    "{}, case {}: floor 1 of the reference structure at {RATE_HZ} Hz. A command is held until the next sample.",
                    record.name, CASES[place].number
                );
                let text = command_table::text(&comment, RATE_HZ, &targets, &COMMANDS);
                output::write(file, text)
            }
            (_, Some(file)) => {
                let commands_m = command_table::commands(file, &targets, &COMMANDS)?.concat();
                self.judge((file, &commands_m), out, record, place, rules)
            }
            _ => Err(Failure::input(
                "--case: belongs to --targets or --follow; all four cases are run without it",
            )),
        }
    }

    fn judge(
        &self,
        (file, commands_m): (&Path, &[f64]),
        out: Option<&Path>,
        record: &GroundRecord,
        place: usize,
        rules: &Rules,
    ) -> Result<(), Failure> {
        let found = follow::judge(record, place, commands_m, self.seed, rules).map_err(refused)?;
        let row = FollowedRthsRow {
            controller: file.display().to_string(),
            case: CASES[place].number,
            record: &record.name,
            j: found.j,
            j2_true: found.j2_true,
            j4_true: found.j4_true,
            within_limits: found.within_limits,
            perturbed: 0,
            lost: 0,
        };
        let answer = Followed {
            rules: rules.name(),
            seed: self.seed,
            criteria: MEANING,
            rows: [row],
        };
        hand_over((out, self.json), no_files, |page| {
            let lead = format!(
                "{}, case {}, the loop not closed: the targets are those of the table.",
                record.name, CASES[place].number
            );
            let true_ones = [
                ("J2 of the displacement as it was, %", found.j2_true),
                ("J4 of the displacement as it was, %", found.j4_true),
            ];
            let all = MEANING.into_iter().zip(found.j).chain(true_ones);
            let all = all.map(|(meaning, j)| (meaning, number(j)));
            of_followed(lead, all, page).with_figures("rths.json", &WithProvenance::of(&answer))
        })
    }
}
