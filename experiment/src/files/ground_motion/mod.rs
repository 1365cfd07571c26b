//! Ground motions: CSV with `time_s,acc_g` in any dialect, PEER AT2, the networks' formats, or accelerations alone.

mod at2;
mod fortran;
mod knet;
mod points;
mod strong_motion;

pub use points::{AccelerationUnit, ColumnChoice};

use super::header::Header;
use super::table::{NumberTable, number};
use super::{binary, decode};
use crate::failure::Failure;
use points::{Points, SHOWN, refuse_line};
use std::path::Path;

/// A ground motion in SI units.
#[derive(Clone, Debug)]
pub struct GroundMotionFile {
    /// Name to show.
    pub name: String,
    /// Acceleration, m/s^2.
    pub acc_m_per_s2: Vec<f32>,
    /// Interval of the points, s.
    pub interval_s: f64,
}

/// The strongest ever recorded is 4.4 g (Iwate-Miyagi 2008): above this limit the file's unit must be wrong.
const STRONGEST_M_PER_S2: f64 = 6.0 * 9.80665;

/// Sampling intervals of accelerograms, s: outside them the time has another unit than its name says.
const INTERVALS_S: std::ops::RangeInclusive<f64> = 2e-5..=0.5;

impl GroundMotionFile {
    /// Reads a file according to its extension and its first lines.
    ///
    /// # Errors
    /// Anything that cannot be what it says, with the line.
    pub fn load(path: &Path, columns: ColumnChoice) -> Result<Self, Failure> {
        let file = path.display().to_string();
        let points = Self::points(path, &file, columns)?;
        if let (Some(own), Some(said)) = (points.unit, columns.unit)
            && own != said
        {
            return Err(Failure::input(format!(
                "{file}: is in {} and --unit says {}: accepted is the file's own",
                own.name(),
                said.name()
            )));
        }
        let interval_s = points.interval_s;
        if let Some(dt) = columns.interval_s
            && (dt - interval_s).abs() > 1e-3 * interval_s
        {
            return Err(Failure::input(format!(
                "{file}: has an interval of {interval_s} s and --dt says {dt} s: accepted is the file's own"
            )));
        }
        let name = path.file_stem().map(|s| s.to_string_lossy());
        Self::of_points(&file, &name.unwrap_or_default(), points)
    }

    /// The contents of the file, according to its format.
    fn points(path: &Path, file: &str, columns: ColumnChoice) -> Result<Points, Failure> {
        let bytes = decode::bytes(path)?;
        if binary::is_binary(&bytes) {
            return of_variables(&binary::parse(file, bytes)?, columns);
        }
        let text = decode::text(file, bytes)?;
        let at2 = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("at2"));
        let first = text.lines().find(|l| !is_comment(l)).unwrap_or("");
        if at2 || at2::is_at2(&text) {
            at2::parse(file, &text)
        } else if knet::is_knet(&text) {
            knet::parse(file, &text)
        } else if let Some(format) = strong_motion::Format::of(&text) {
            format.parse(file, &text)
        } else if first.split_whitespace().all(|w| number(w).is_some()) && !first.is_empty() {
            read_numbers(file, &text, columns)
        } else {
            read_csv(file, &text)
        }
    }

    /// From times, s, and accelerations, g; `name` is for display.
    ///
    /// # Errors
    /// As for a file with the header `time_s,acc_g`.
    pub fn of_columns(name: &str, time_s: Vec<f64>, acc_g: Vec<f64>) -> Result<Self, Failure> {
        let names = ["time_s", "acc_g"].map(str::to_owned);
        let table = NumberTable::of_columns(name, "its names", &names, vec![time_s, acc_g])?;
        Self::of_points(name, name, points_of(&table)?)
    }

    /// From a file's contents, if they can be an earthquake.
    fn of_points(file: &str, name: &str, points: Points) -> Result<Self, Failure> {
        let acc = points.acc_m_per_s2;
        if acc.len() < 2 {
            return Err(Failure::input(format!(
                "{file}: has {} points: accepted are at least 2",
                acc.len()
            )));
        }
        if !INTERVALS_S.contains(&points.interval_s) {
            return Err(Failure::input(format!(
                "{file}: samples lie {} s apart, as in no accelerogram: accepted are {} to {} s; is the time in another unit \
                 than seconds?",
                points.interval_s,
                INTERVALS_S.start(),
                INTERVALS_S.end()
            )));
        }
        let peak = acc.iter().fold(0.0_f64, |p, a| p.max(a.abs()));
        if peak > STRONGEST_M_PER_S2 {
            return Err(Failure::input(format!(
                "{file}: reaches {:.3} g by its unit, more than any earthquake: accepted are up to 6 g; is the unit \
                 right?",
                peak / AccelerationUnit::G.in_si()
            )));
        }
        Ok(Self {
            name: name.to_owned(),
            acc_m_per_s2: acc.iter().map(|a| *a as f32).collect(),
            interval_s: points.interval_s,
        })
    }
}

fn is_comment(line: &str) -> bool {
    line.trim().is_empty() || line.trim_start().starts_with('#')
}

fn read_csv(file: &str, text: &str) -> Result<Points, Failure> {
    points_of(&NumberTable::parse(file, text)?)
}

/// From a table with times and accelerations.
fn points_of(table: &NumberTable) -> Result<Points, Failure> {
    let names: Vec<String> = table.headers.iter().map(|h| h.name(|_| false)).collect();
    let time = names.iter().position(|name| name == "time_s");
    let is_acceleration =
        |(at, header): &(usize, &Header)| header.is_acceleration() && names[*at].starts_with("acc");
    let accelerations = || table.headers.iter().enumerate().filter(is_acceleration);
    if accelerations().count() > 1 {
        let all: Vec<&str> = accelerations().map(|(_, h)| h.text.as_str()).collect();
        return Err(table.refuse_header(format!(
            "has {} accelerations, {}: accepted is a file with one",
            all.len(),
            all.join(", ")
        )));
    }
    let found = accelerations()
        .next()
        .and_then(|(at, header)| Some((time?, at, AccelerationUnit::named(&header.unit)?)));
    let (time, acc, unit) = found.ok_or_else(|| {
        let header: String = names.join(",").chars().take(SHOWN).collect();
        table.refuse_header(format!(
            "the header `{header}` is refused: accepted are time_s and one of acc_g, acc_m_per_s2 and acc_gal; read too \
             are PEER AT2, COSMOS, CSMIP, SMC, ESM and K-NET files, and plain numbers with --dt and --unit"
        ))
    })?;
    let interval = interval_s(table, &table.columns[time])?;
    Ok(Points {
        interval_s: interval,
        acc_m_per_s2: table.columns[acc]
            .iter()
            .map(|a| a * unit.in_si())
            .collect(),
        unit: Some(unit),
    })
}

/// The variables of a MAT or HDF5 file: a table with times, or one series plus command-line options.
fn of_variables(table: &NumberTable, columns: ColumnChoice) -> Result<Points, Failure> {
    match (&table.columns[..], columns.interval_s, columns.unit) {
        ([acc], Some(interval_s), Some(unit)) if interval_s > 0.0 && interval_s < 10.0 => Ok(Points {
            interval_s,
            acc_m_per_s2: acc.iter().map(|a| a * unit.in_si()).collect(),
            unit: None,
        }),
        ([_], ..) => Err(table.refuse_header(
            "one series and no times: accepted with --dt S (above 0 and below 10) and --unit g|m/s2|gal",
        )),
        _ => points_of(table),
    }
}

/// The constant interval of a time column, s.
fn interval_s(table: &NumberTable, time: &[f64]) -> Result<f64, Failure> {
    let mut steps: Vec<f64> = time.windows(2).map(|t| t[1] - t[0]).collect();
    let given = steps.clone();
    steps.sort_by(f64::total_cmp);
    let Some(&usual) = steps.get(steps.len() / 2) else {
        return Ok(0.0);
    };
    for (i, step) in given.iter().enumerate() {
        if *step <= 0.0 {
            return Err(table.refuse_row(
                i + 1,
                format!(
                    "time {} s follows on {} s: accepted is time that increases",
                    time[i + 1],
                    time[i]
                ),
            ));
        }
        // Published times are rounded, at worst to a tenth of a millisecond.
        if (step - usual).abs() > 0.01 * usual + 1.01e-4_f64.min(0.1 * usual) {
            return Err(table.refuse_row(
                i + 1,
                format!(
                    "time {} s comes {step:.6} s after the one before it, the others {usual:.6} s: accepted is a \
                     constant interval",
                    time[i + 1]
                ),
            ));
        }
    }
    // The mean interval of rounded times, rounded back to a tenth of a microsecond.
    let mean = (time[time.len() - 1] - time[0]) / given.len() as f64;
    Ok((mean * 1e7).round() / 1e7)
}

/// Accelerations alone, any number per line, or time and acceleration in two columns without a header.
fn read_numbers(file: &str, text: &str, columns: ColumnChoice) -> Result<Points, Failure> {
    let Some(unit) = columns.unit else {
        return Err(Failure::input(format!(
            "{file}: has numbers and no header: accepted with --unit g|m/s2|gal, and --dt S unless it has two columns, \
             time and acceleration"
        )));
    };
    if let Some(dt) = columns.interval_s
        && !(dt > 0.0 && dt < 10.0)
    {
        return Err(Failure::input(format!(
            "--dt = {dt} is refused: accepted are seconds above 0 and below 10"
        )));
    }
    let mut rows = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, l)| !is_comment(l)) {
        let row: Result<Vec<f64>, &str> = fortran::numbers(line, None).into_iter().collect();
        rows.push(row.map_err(|word| refuse_line(file, i, word, "a finite number"))?);
    }
    let points = |interval_s: f64, acc: &[f64]| Points {
        interval_s,
        acc_m_per_s2: acc.iter().map(|a| a * unit.in_si()).collect(),
        unit: None,
    };
    match columns.interval_s {
        Some(interval_s) => Ok(points(interval_s, &rows.concat())),
        None if rows.iter().all(|row| row.len() == 2) => {
            let named: String = rows
                .iter()
                .map(|r| format!("{},{}\n", r[0], r[1]))
                .collect();
            let table = NumberTable::parse(file, &format!("time_s,acc\n{named}"))?;
            Ok(points(
                interval_s(&table, &table.columns[0])?,
                &table.columns[1],
            ))
        }
        None => Err(Failure::input(format!(
            "{file}: has numbers and no times: accepted with --dt S"
        ))),
    }
}

#[cfg(test)]
mod tests;
