//! Measured data as input for a diagnosis: `FILE[@T0..T1]`, in mm, N and s.

use super::columns::Columns;
use super::missing_rows;
use super::recording::SiRecording;
use crate::failure::Failure;
use crate::trace::Trace;
use diagnosis::{Diagnosis, ForceUnit};
use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A file, and the part of it to use.
#[derive(Clone, Debug, PartialEq)]
pub struct FilePart {
    /// The file.
    pub file: PathBuf,
    /// Start and end, s, infinite if open; the first is included and the last is not. `None`: the whole record.
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

/// Files that were read, each once, however many of its parts are used.
#[derive(Debug, Default)]
pub struct RecordFiles {
    read: HashMap<PathBuf, SiRecording>,
    columns: Columns,
}

impl RecordFiles {
    /// With the command line's statements about the files' columns.
    pub fn with(columns: &Columns) -> Self {
        Self {
            read: HashMap::new(),
            columns: columns.clone(),
        }
    }

    /// The parts, in order; one with gaps gives as many recordings as it has pieces.
    ///
    /// # Errors
    /// A file that cannot be used; a span outside its record.
    pub fn parts(&mut self, parts: &[FilePart]) -> Result<Vec<diagnosis::Recording>, Failure> {
        let each: Vec<Vec<_>> = parts
            .iter()
            .map(|p| parts_of(self.whole_file(&p.file)?, p.span_s))
            .collect::<Result<_, _>>()?;
        Ok(each.into_iter().flatten().collect())
    }

    /// The longest piece of a part, for fits to a single record.
    ///
    /// # Errors
    /// As for [`RecordFiles::parts`].
    pub fn longest(&mut self, part: &FilePart) -> Result<diagnosis::Recording, Failure> {
        longest_part_of(self.whole_file(&part.file)?, part.span_s)
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

    /// The recording in `path`; one file under two names is one recording.
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

/// The part of a recording between two times, on an even grid: one recording, or, if more than twenty rows are missing,
/// one for each piece between the gaps. Gaps are not filled, and what has memory starts anew after them. For fewer
/// missing rows the recording marks them as unmeasured.
///
/// # Errors
/// A span outside the record; time that does not increase; a quantity without a number inside the span; a fifth of the
/// time without rows; no piece that is long enough.
pub fn parts_of(
    recording: &SiRecording,
    span_s: Option<[f64; 2]>,
) -> Result<Vec<diagnosis::Recording>, Failure> {
    let n = recording.time_s.len();
    let (sound, rows) = match rows_of(recording, span_s) {
        Some(rows) => {
            refuse_gap(recording, &rows)?;
            (recording.between_gaps(&rows), rows)
        }
        // An empty span is reported below.
        None => (0..n, 0..n),
    };
    let gaps = diagnosis::gaps(&recording.time_s[sound.clone()]);
    let gaps: Vec<usize> = gaps.into_iter().map(|i| sound.start + i).collect();
    let mut edges = vec![sound.start];
    edges.extend(&gaps);
    edges.push(sound.end);
    let pieces = edges.windows(2).map(|e| e[0]..e[1]);
    let mut touched: Vec<_> = pieces
        .filter(|piece| piece.start < rows.end && rows.start < piece.end)
        .collect();
    if let [piece] = &touched[..] {
        let mut part = part_of(recording, piece.clone(), span_s)?;
        part.remarks
            .splice(0..0, missing_rows::said(recording, &rows)?);
        return Ok(vec![part]);
    }
    if let Some([from_s, to_s]) = span_s {
        let (first, last) = (recording.time_s[0], recording.time_s[n - 1]);
        let room = 2.0 * diagnosis::usual_interval_s(&recording.time_s);
        if (from_s.is_finite() && from_s < first - room) || (to_s.is_finite() && to_s > last + room)
        {
            return Err(outside(&recording.file, [from_s, to_s], [first, last]));
        }
    }
    let remark = missing_rows::said(recording, &rows)?.unwrap_or_default();
    let long = |piece: &Range<usize>| {
        piece.end.min(rows.end) - piece.start.max(rows.start) >= diagnosis::FEWEST_SAMPLES
    };
    touched.retain(long);
    let mut parts = touched
        .into_iter()
        .map(|piece| {
            let [from, to] = [piece.start.max(rows.start), piece.end.min(rows.end)];
            // Open if it ends at a gap.
            let behind = if to == piece.end {
                f64::INFINITY
            } else {
                recording.time_s[to]
            };
            let span_s = [recording.time_s[from], behind];
            part_of(recording, piece, Some(span_s))
        })
        .collect::<Result<Vec<_>, _>>()?;
    match parts.first_mut() {
        Some(first) => first.remarks.push(remark),
        None => {
            return Err(Failure::input(format!(
                "{remark} No piece has {} rows, which is what can be judged.",
                diagnosis::FEWEST_SAMPLES
            )));
        }
    }
    Ok(parts)
}

/// The longest of [`parts_of`], for fits to a single record.
///
/// # Errors
/// As for [`parts_of`].
pub fn longest_part_of(
    recording: &SiRecording,
    span_s: Option<[f64; 2]>,
) -> Result<diagnosis::Recording, Failure> {
    let mut parts = parts_of(recording, span_s)?;
    let remarks = parts[0].remarks.clone();
    let several = parts.len() > 1;
    parts.sort_by_key(|p| p.time_s.len());
    let mut longest = parts.pop().unwrap_or_default();
    if several {
        longest.remarks = remarks;
        longest.remarks.push(format!(
            "{}: what follows is of the longest piece, {:.3} to {:.3} s.",
            longest.name,
            longest.time_s[0],
            longest.time_s[longest.time_s.len() - 1]
        ));
    }
    Ok(longest)
}

/// The part between two times of a piece without gaps, on an even grid.
fn part_of(
    recording: &SiRecording,
    sound: Range<usize>,
    span_s: Option<[f64; 2]>,
) -> Result<diagnosis::Recording, Failure> {
    let whole = in_mm(recording, sound.clone());
    let used = match span_s {
        None => whole,
        Some(span_s) => match inside(&whole, span_s)? {
            even if even.uneven_at().is_none() => even,
            // Put uneven parts of a file on one grid, if one fits the whole of it.
            _ => inside(&whole.clone().made_even().unwrap_or(whole), span_s)?,
        },
    };
    // A step backward has a line in the file; other errors do not.
    if used.uneven_at().is_some()
        && let Some(sample) = used.backward_at()
    {
        let skipped = used.before.as_ref().map_or(0, |b| b.time_s.len());
        return Err(recording.refuse_time(sound.start + skipped + sample));
    }
    used.made_even().map_err(Failure::input)
}

/// Checks that every quantity has a number in these rows.
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

/// The rows of a span, or all rows; `None` if the span contains none.
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
    // Half-open: the end may lie one interval after the last sample, and intervals may be uneven.
    let steps = whole.time_s.windows(2).map(|t| t[1] - t[0]);
    let room = 1.5 * steps.fold(whole.interval_s(), f64::max);
    let open = |s: f64| s.is_infinite();
    let outside = from_s < first - room && !open(from_s) || to_s > last + room && !open(to_s);
    if outside || from_s > last || to_s <= first {
        return Err(self::outside(&whole.name, [from_s, to_s], [first, last]));
    }
    Ok(whole.span(from_s, to_s))
}

/// The refusal of a span outside its record.
pub(super) fn outside(name: &str, [from_s, to_s]: [f64; 2], [first, last]: [f64; 2]) -> Failure {
    Failure::input(format!(
        "{name}: the span {from_s}..{to_s} s is not inside the record: accepted are times from {first} to {last} s"
    ))
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

/// The lowest axis of a test that was run, in mm, N and s.
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

/// For a force without a unit in the file: removes units from every statement about it.
pub fn without_force_unit(diagnosis: &mut Diagnosis) {
    if let Some(specimen) = &mut diagnosis.improved.specimen {
        specimen.force_unit = ForceUnit::Without;
    }
    for channel in diagnosis.channels.iter_mut().filter(|c| c.unit == "N") {
        channel.unit = "1".into();
        for p in channel.effects.iter_mut().flat_map(|e| &mut e.parameters) {
            p.unit = p.unit.replace('N', "1");
        }
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
        let part = |span| longest_part_of(&recording, span).map_err(|e| e.to_string());
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

    /// A sine at 1 kHz without the rows selected by `lost`.
    fn with_lost(lost: impl Fn(usize) -> bool) -> SiRecording {
        let row = |i: usize| {
            let t = i as f64 * 1e-3;
            format!("{t:.4},{0},{0}\n", (6.0 * t).sin())
        };
        let rows: String = (0..20_000).filter(|i| !lost(*i)).map(row).collect();
        let text = format!("time_s,command_mm,displacement_mm\n{rows}");
        SiRecording::parse("gap.csv", &text).unwrap()
    }

    #[test]
    fn missing_rows_stay_missing_and_the_grid_is_that_of_the_others() {
        let recording = with_lost(|i| (5000..5200).contains(&i));
        let parts = parts_of(&recording, None).unwrap();
        let lengths: Vec<usize> = parts.iter().map(|p| p.time_s.len()).collect();
        assert_eq!(lengths, [5000, 14_800]);
        let remark = "from 4.999 s to 5.2 s (200 rows)";
        assert!(
            parts[0].remarks[0].contains(remark),
            "{:?}",
            parts[0].remarks
        );
        for part in &parts {
            assert!((part.interval_s() - 1e-3).abs() < 1e-9);
            assert_eq!(part.unmeasured(), [0_usize; 0]);
            assert!(part.before.is_none(), "memory begins again");
            let x = part.displacement_mm.as_ref().unwrap();
            let recorded = |(t, x): (&f64, &f64)| (x - (6.0 * t).sin()).abs() < 1e-3;
            assert!(part.time_s.iter().zip(x).all(recorded));
        }
        // A span without the gap does not mention it.
        for span in [[0.0, 4.9], [5.3, 15.0]] {
            let parts = parts_of(&recording, Some(span)).unwrap();
            assert_eq!((parts.len(), &parts[0].remarks[..]), (1, &[][..]));
            let past = parts[0].before.as_ref().map(|b| b.time_s[0]);
            assert_eq!(past, (span[0] > 5.2).then_some(5.2));
        }
        let e = parts_of(&recording, Some([0.0, 100.0]))
            .unwrap_err()
            .to_string();
        assert!(e.contains("is not inside the record"), "{e}");
        let longest = longest_part_of(&recording, Some([0.0, 8.0])).unwrap();
        assert_eq!(longest.time_s[0], 0.0);
        assert!(
            longest.remarks[1].contains("0.000 to 4.999 s"),
            "{:?}",
            longest.remarks
        );
        // A third of the rows in 66 gaps: ten are named, and the record is refused.
        let e = parts_of(&with_lost(|i| i % 300 >= 200), None)
            .unwrap_err()
            .to_string();
        assert!(e.contains("and in 56 gaps more") && e.contains("33"), "{e}");
    }

    #[test]
    fn a_few_missing_rows_are_named_and_known_as_not_measured_and_move_no_other_sample() {
        let gone = |i: usize| matches!(i, 5000..5010 | 9000..9003 | 12_000 | 15_000..15_020);
        let recording = with_lost(gone);
        let part = |span| longest_part_of(&recording, span).unwrap();
        let all = part(None);
        assert_eq!(all.time_s.len(), 20_000);
        assert!((all.interval_s() - 1e-3).abs() < 1e-9);
        let lost: Vec<usize> = (0..20_000).filter(|i| gone(*i)).collect();
        assert_eq!(all.unmeasured(), lost);
        for said in [
            "4.999 s to 5.01 s (10 rows)",
            "8.999 s to 9.003 s (3 rows)",
            "14.999 s to 15.02 s (20 rows). Nothing is judged there",
        ] {
            assert!(all.remarks[0].contains(said), "{:?}", all.remarks);
        }
        let x = all.displacement_mm.as_ref().unwrap();
        let written = |i: &usize| (x[*i] - (6e-3 * *i as f64).sin()).abs() < 1e-9;
        assert!((0..20_000).filter(|i| !gone(*i)).all(|i| written(&i)));
        let before = part(Some([0.0, 4.9]));
        assert_eq!((before.time_s.len(), &before.remarks[..]), (4900, &[][..]));
        assert!(before.unmeasured().is_empty());
        // A part that begins after some and ends after others mentions its own.
        let inside = part(Some([5.5, 14.0]));
        assert_eq!(inside.unmeasured(), [3500, 3501, 3502, 6500]);
        // Two of seven rows, repeatedly.
        let e = parts_of(&with_lost(|i| matches!(i % 7, 2 | 3)), None).unwrap_err();
        assert!(
            e.to_string().contains("28.6 % of the time has no rows"),
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
