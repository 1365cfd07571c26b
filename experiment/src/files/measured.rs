//! Measured data as a diagnosis takes it: `FILE[@T0..T1]`, in mm, N and s.

use super::columns::Columns;
use super::recording::SiRecording;
use crate::failure::Failure;
use crate::trace::Trace;
use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A file, and the part of it that is meant.
#[derive(Clone, Debug, PartialEq)]
pub struct FilePart {
    /// The file.
    pub file: PathBuf,
    /// From when to when, s, infinite where it is open; the first belongs to it and the last does not. `None`: the
    /// whole record.
    pub span_s: Option<[f64; 2]>,
}

impl std::str::FromStr for FilePart {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((file, span)) = text.rsplit_once('@').filter(|(_, s)| s.contains("..")) else {
            return Ok(Self {
                file: text.into(),
                span_s: None,
            });
        };
        let refuse = |why: &str| {
            format!(
                "`{text}`: {why}: accepted are FILE@T0..T1 with T0 below T1, FILE@T0.. and FILE@..T1, in seconds"
            )
        };
        let (from, to) = span.split_once("..").unwrap_or((span, ""));
        let second = |what: &str, open: f64| {
            if what.trim().is_empty() {
                return Ok(open);
            }
            let s: f64 = what
                .trim()
                .parse()
                .map_err(|_| refuse(&format!("`{what}` is not a number")))?;
            let finite = s.is_finite().then_some(s);
            finite.ok_or_else(|| refuse(&format!("`{what}` is not finite")))
        };
        let (from, to) = (second(from, f64::NEG_INFINITY)?, second(to, f64::INFINITY)?);
        if from >= to {
            return Err(refuse(&format!("{from} s is not below {to} s")));
        }
        Ok(Self {
            file: file.into(),
            span_s: Some([from, to]),
        })
    }
}

/// Files that were read, each once however many parts of it are used.
#[derive(Debug, Default)]
pub struct RecordFiles {
    read: HashMap<PathBuf, SiRecording>,
    columns: Columns,
}

impl RecordFiles {
    /// With what is said on the command line about the files' columns.
    pub fn with(columns: &Columns) -> Self {
        Self {
            read: HashMap::new(),
            columns: columns.clone(),
        }
    }

    /// The parts, in order.
    ///
    /// # Errors
    /// A file that cannot be used; a span that is not inside its record.
    pub fn parts(&mut self, parts: &[FilePart]) -> Result<Vec<diagnosis::Recording>, Failure> {
        parts.iter().map(|p| self.part(p)).collect()
    }

    /// True if every force that was read is in newtons.
    pub fn force_has_unit(&self) -> bool {
        let mut forces = self.read.values().filter(|r| r.force().is_some());
        forces.all(SiRecording::force_has_unit)
    }

    /// True if a force was read, and all of them are in newtons.
    pub fn force_in_newtons(&self) -> bool {
        self.force_has_unit() && self.read.values().any(|r| r.force().is_some())
    }

    fn part(&mut self, part: &FilePart) -> Result<diagnosis::Recording, Failure> {
        part_of(self.whole_file(&part.file)?, part.span_s)
    }

    /// The recording behind `path`; one file under two names is one recording.
    pub(super) fn whole_file(&mut self, path: &Path) -> Result<&SiRecording, Failure> {
        let same = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        if !self.read.contains_key(&same) {
            let recording = SiRecording::load_with_any_time(path, &self.columns)?;
            for note in &recording.notes {
                super::note(format_args!("{note}"));
            }
            self.read.insert(same.clone(), recording);
        }
        Ok(&self.read[&same])
    }
}

/// The part of a recording between two times, on an even grid.
///
/// # Errors
/// A span that is not inside the record; time that does not increase; a quantity without a number inside the span.
pub fn part_of(
    recording: &SiRecording,
    span_s: Option<[f64; 2]>,
) -> Result<diagnosis::Recording, Failure> {
    let sound = match rows_of(recording, span_s) {
        Some(rows) => {
            refuse_gap(recording, &rows)?;
            recording.between_gaps(&rows)
        }
        // That it is empty is said below.
        None => 0..recording.time_s.len(),
    };
    let whole = in_mm(recording, sound.clone());
    // All parts of a file on one grid, where one can be laid through the whole of it.
    let whole = whole.clone().made_even().unwrap_or(whole);
    let used = match span_s {
        None => whole,
        Some(span_s) => inside(&whole, span_s)?,
    };
    // A step backward has a line in the file; what else is wrong has none.
    if used.uneven_at().is_some()
        && let Some(sample) = used.backward_at()
    {
        let skipped = used.before.as_ref().map_or(0, |b| b.time_s.len());
        return Err(recording.refuse_time(sound.start + skipped + sample));
    }
    used.made_even().map_err(Failure::input)
}

/// That every quantity has a number in these rows.
///
/// # Errors
/// The first gap.
pub(super) fn refuse_gap(recording: &SiRecording, rows: &Range<usize>) -> Result<(), Failure> {
    match recording.gap_in(rows) {
        None => Ok(()),
        Some((time_s, refusal)) => Err(Failure::input(format!(
            "{refusal}; this is at {time_s} s: FILE@T0..T1 takes a part of the record without it"
        ))),
    }
}

/// The rows of a span, or of all; `None`: none is in it.
fn rows_of(recording: &SiRecording, span_s: Option<[f64; 2]>) -> Option<Range<usize>> {
    let [from_s, to_s] = span_s.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let inside = |t: &f64| (from_s..to_s).contains(t);
    let first = recording.time_s.iter().position(inside)?;
    let last = recording.time_s.iter().rposition(inside)?;
    Some(first..last + 1)
}

fn inside(
    whole: &diagnosis::Recording,
    [from_s, to_s]: [f64; 2],
) -> Result<diagnosis::Recording, Failure> {
    let (first, last) = (whole.time_s[0], whole.time_s[whole.time_s.len() - 1]);
    // Half open: the end may lie one interval behind the last sample, and intervals may be uneven.
    let steps = whole.time_s.windows(2).map(|t| t[1] - t[0]);
    let room = 1.5 * steps.fold(whole.interval_s(), f64::max);
    let open = |s: f64| s.is_infinite();
    let outside = from_s < first - room && !open(from_s) || to_s > last + room && !open(to_s);
    if outside || from_s > last || to_s <= first {
        return Err(Failure::input(format!(
            "{}: the span {from_s}..{to_s} s is not inside the record: accepted are times from {first} to {last} s",
            whole.name
        )));
    }
    Ok(whole.span(from_s, to_s))
}

/// Rows of the first axis of a recording in mm, N and s.
pub fn in_mm(recording: &SiRecording, rows: Range<usize>) -> diagnosis::Recording {
    let mm = |x: &[f64]| x[rows.clone()].iter().map(|x| x * 1e3).collect();
    diagnosis::Recording {
        name: recording.file.clone(),
        time_s: recording.time_s[rows.clone()].to_vec(),
        command_mm: recording.command_m().map(mm),
        displacement_mm: recording.displacement_m().map(mm),
        force_n: recording.force().map(|x| x[rows.clone()].to_vec()),
        ..diagnosis::Recording::default()
    }
}

/// The lowest axis of a test that ran, in mm, N and s.
pub fn in_mm_of(trace: &Trace) -> diagnosis::Recording {
    let floor = &trace.floors[0];
    let mm = |x: &[f32]| x.iter().map(|x| f64::from(*x) * 1e3).collect();
    diagnosis::Recording {
        name: "the test's record".into(),
        time_s: (0..trace.len()).map(|i| trace.time_s(i)).collect(),
        command_mm: Some(mm(&floor.sent_m)),
        displacement_mm: Some(mm(&floor.displacement_m)),
        force_n: Some(floor.force_n.iter().map(|x| f64::from(*x)).collect()),
        ..diagnosis::Recording::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_outside_of_a_span_is_none_of_its_business() {
        let rows: String = (0..300)
            .map(|i| {
                let x = if i == 100 {
                    "NaN".into()
                } else {
                    format!("{i}.5")
                };
                format!("{:.2},{x},{i}\n", f64::from(i) * 0.01)
            })
            .collect();
        let text = format!("time_s,command_mm,displacement_mm\n{rows}");
        let table = crate::files::table::NumberTable::parse_with_bad_cells("r.csv", &text, false);
        let recording = SiRecording::of(table.unwrap(), &Columns::default()).unwrap();
        let part = |span| part_of(&recording, span).map_err(|e| e.to_string());
        let before = part(Some([0.0, 1.0])).unwrap();
        assert_eq!((before.time_s.len(), before.time_s[0]), (100, 0.0));
        let after = part(Some([1.5, 3.0])).unwrap();
        let past = after.before.as_ref().unwrap();
        assert_eq!((after.time_s[0], past.time_s[0]), (1.5, 1.01));
        assert!(
            past.command_mm
                .as_ref()
                .unwrap()
                .iter()
                .all(|x| x.is_finite())
        );
        for span in [None, Some([0.5, 1.5])] {
            let e = part(span).unwrap_err();
            assert!(e.starts_with("r.csv, line 102: command_mm is `NaN`"), "{e}");
            assert!(e.contains("at 1 s: FILE@T0..T1 takes a part"), "{e}");
        }
        let e = part(Some([5.0, 6.0])).unwrap_err();
        assert!(
            e.contains("is not inside the record: accepted are times from 0 to 2.99"),
            "{e}"
        );
    }

    #[test]
    fn a_part_is_a_file_and_a_span() {
        let part = |text: &str| text.parse::<FilePart>();
        assert_eq!(part("a@b.csv").unwrap().file, PathBuf::from("a@b.csv"));
        let p = part("rig@lab.csv@-1.5..20").unwrap();
        assert_eq!(p.file, PathBuf::from("rig@lab.csv"));
        assert_eq!(p.span_s, Some([-1.5, 20.0]));
        assert_eq!(
            part("a.csv@..2").unwrap().span_s,
            Some([f64::NEG_INFINITY, 2.0])
        );
        assert_eq!(
            part("a.csv@2..").unwrap().span_s,
            Some([2.0, f64::INFINITY])
        );
        for (text, said) in [
            ("a.csv@5..2", "5 s is not below 2 s"),
            ("a.csv@five..9", "`five` is not a number"),
            ("a.csv@1..two", "`two` is not a number"),
            ("a.csv@1..inf", "`inf` is not finite"),
        ] {
            let e = part(text).unwrap_err();
            assert!(e.contains(said), "{e}");
        }
    }
}
