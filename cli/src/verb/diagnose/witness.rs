//! `diagnose --witness`: unused channels are checked for what was named.

use super::Diagnose;
use crate::answer::Witness;
use crate::terminal;
use diagnosis::{Diagnosis, Model, Recording, Witnessed, testimonies};
use experiment::failure::Failure;
use experiment::files::measured::FilePart;
use experiment::files::witness::{WitnessColumn, WitnessRecord};
use std::path::Path;

/// Training and held-out records.
type Sets<T> = [Vec<T>; 2];

/// The witness values at the times of each record; `None` where it does not cover the record.
pub(super) type Read = Sets<Option<Vec<f64>>>;

impl Diagnose {
    /// Reads each witness at the times of the records. A channel of the records that is itself a witness is removed from
    /// them, and from their data before the span.
    ///
    /// # Errors
    /// A witness that cannot be read, that covers no record of one of the sets, or that the declared model needs.
    pub(super) fn called(
        &self,
        declared: &Model,
        sets: &mut Sets<Recording>,
    ) -> Result<Vec<Read>, Failure> {
        let one = |witness: &WitnessColumn| {
            let read = witness.read(&self.columns)?;
            let refuse = |why: &str| Failure::input(format!("--witness {witness}: {why}"));
            // A separate file applies to every record; a file that is also judged, only to its own records.
            let own_file = |part: &FilePart| same_file(&part.file, &witness.file);
            let is_judged = self.train.iter().chain(&self.test).any(own_file);
            let [train, test] = [&sets[0], &sets[1]].map(|records| -> Vec<_> {
                let own = |r: &Recording| {
                    let beside = !is_judged || same_file(Path::new(&r.name), &witness.file);
                    beside.then(|| read_at(&read, r)).flatten()
                };
                records.iter().map(own).collect()
            });
            for (read, set) in [(&train, "--train"), (&test, "--test")] {
                if read.iter().all(Option::is_none) {
                    return Err(refuse(&format!(
                        "it covers no record of {set}: accepted is a channel that was recorded meanwhile"
                    )));
                }
            }
            for (records, read) in sets.iter_mut().zip([&train, &test]) {
                for (record, read) in records.iter_mut().zip(read) {
                    if let Some(channel) = read
                        .as_ref()
                        .and_then(|read| taken_out(declared, record, read))
                    {
                        return Err(refuse(&format!(
                            "it is the {channel}, which the declared model needs: accepted is a channel that takes no part"
                        )));
                    }
                }
            }
            Ok([train, test])
        };
        self.witness.iter().map(one).collect()
    }

    /// The testimony of each witness.
    pub(super) fn heard(
        &self,
        declared: &Model,
        diagnosis: &Diagnosis,
        [train, test]: &Sets<Recording>,
        called: &[Read],
    ) -> Vec<Witness> {
        let of = |(witness, read): (&WitnessColumn, &Read)| {
            let beside = |(records, read): (&[Recording], &[Option<Vec<f64>>])| {
                let pairs = records.iter().zip(read);
                let with = pairs.filter_map(|(record, read)| {
                    let read = read.clone()?;
                    Some(Witnessed {
                        record: record.clone(),
                        read,
                    })
                });
                with.collect::<Vec<_>>()
            };
            let views = [(&train[..], &read[0][..]), (&test[..], &read[1][..])].map(beside);
            let testimonies = terminal::while_waiting("asking the witness", || {
                testimonies(declared, diagnosis, train, &views)
            });
            Witness {
                file: witness.file.display().to_string(),
                column: witness.column.clone(),
                testimonies,
            }
        };
        self.witness.iter().zip(called).map(of).collect()
    }
}

fn read_at(read: &WitnessRecord, record: &Recording) -> Option<Vec<f64>> {
    let read = read.at(&record.time_s)?;
    read.iter().all(|x| x.is_finite()).then_some(read)
}

fn same_file(a: &Path, b: &Path) -> bool {
    a == b || matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Removes a witness from the record if it is one of its channels; gives the channel's name if the declared model needs
/// it.
fn taken_out(declared: &Model, record: &mut Recording, read: &[f64]) -> Option<&'static str> {
    let is = |own: &Option<Vec<f64>>| own.as_ref().is_some_and(|own| is_one(own, read));
    if is(&record.displacement_mm) {
        return Some("displacement");
    }
    let (command, force) = (is(&record.command_mm), is(&record.force_n));
    if command && declared.actuator.is_some() {
        return Some("command");
    }
    if force && declared.specimen.is_some() {
        return Some("force");
    }
    let mut part = Some(record);
    while let Some(own) = part {
        if command {
            own.command_mm = None;
        }
        if force {
            own.force_n = None;
        }
        part = own.before.as_deref_mut();
    }
    None
}

/// Whether two channels are the same up to their units.
fn is_one(own: &[f64], read: &[f64]) -> bool {
    let sums = own.iter().zip(read).fold([0.0; 3], |[a, b, c], (x, y)| {
        [a + x * x, b + x * y, c + y * y]
    });
    let [own, both, read] = sums;
    read > 0.0 && both * both >= (1.0 - 1e-9) * own * read
}
