//! Ground motions: CSV with `time_s,acc_g`, PEER AT2, or one acceleration a line.

use super::read;
use super::table::{NumberTable, number};
use crate::failure::Failure;
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

/// What is said on the command line about a file that does not say it itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Columns {
    /// `--dt`, s.
    pub interval_s: Option<f64>,
    /// `--unit`.
    pub unit: Option<Unit>,
}

/// Unit of an acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Unit {
    /// Standard gravity, 9.80665 m/s^2.
    #[value(name = "g")]
    G,
    /// m/s^2.
    #[value(name = "m/s2")]
    MetrePerSecondSquared,
    /// cm/s^2.
    #[value(name = "gal")]
    Gal,
}

impl Unit {
    fn in_si(self) -> f64 {
        match self {
            Self::G => 9.80665,
            Self::MetrePerSecondSquared => 1.0,
            Self::Gal => 0.01,
        }
    }

    /// The unit of a column `acc_...`.
    fn of_column(name: &str) -> Option<Self> {
        match name {
            "acc_g" => Some(Self::G),
            "acc_m/s2" | "acc_m_per_s2" => Some(Self::MetrePerSecondSquared),
            "acc_gal" => Some(Self::Gal),
            _ => None,
        }
    }
}

/// The strongest that was ever recorded is 4.4 g (Iwate-Miyagi 2008): beyond this the unit is not what the file says.
const STRONGEST_M_PER_S2: f64 = 6.0 * 9.80665;

/// Points in m/s^2 and their interval in s.
type Points = (f64, Vec<f64>);

impl GroundMotionFile {
    /// Reads a file by its ending and its first lines.
    ///
    /// # Errors
    /// Anything that cannot be what it says, with the line.
    pub fn load(path: &Path, columns: Columns) -> Result<Self, Failure> {
        let text = read(path)?;
        let file = path.display().to_string();
        let at2 = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("at2"));
        let first = text.lines().find(|l| !is_comment(l)).unwrap_or("");
        let (interval_s, acc) = if at2 {
            read_at2(&file, &text)?
        } else if number(first).is_some() {
            read_column(&file, &text, columns)?
        } else {
            read_csv(&file, &text)?
        };
        if acc.len() < 2 {
            return Err(Failure::input(format!(
                "{file}: has {} points: accepted are at least 2",
                acc.len()
            )));
        }
        let peak = acc.iter().fold(0.0_f64, |p, a| p.max(a.abs()));
        if peak > STRONGEST_M_PER_S2 {
            return Err(Failure::input(format!(
                "{file}: reaches {:.3} g by its unit, more than any earthquake: accepted are up to 6 g; is the unit \
                 right?",
                peak / Unit::G.in_si()
            )));
        }
        if let Some(dt) = columns.interval_s
            && (dt - interval_s).abs() > 1e-3 * interval_s
        {
            return Err(Failure::input(format!(
                "{file}: has an interval of {interval_s} s and --dt says {dt} s: accepted is the file's own"
            )));
        }
        Ok(Self {
            name: path
                .file_stem()
                .map_or_else(String::new, |s| s.to_string_lossy().into_owned()),
            acc_m_per_s2: acc.iter().map(|a| *a as f32).collect(),
            interval_s,
        })
    }
}

fn is_comment(line: &str) -> bool {
    line.trim().is_empty() || line.trim_start().starts_with('#')
}

fn number_at(file: &str, line: usize, text: &str) -> Result<f64, Failure> {
    number(text).ok_or_else(|| {
        Failure::input(format!(
            "{file}, line {line}: `{}` is refused: accepted is a finite number",
            text.trim()
        ))
    })
}

fn read_csv(file: &str, text: &str) -> Result<Points, Failure> {
    let table = NumberTable::parse(file, text)?;
    let names: Vec<&str> = table.names.iter().map(String::as_str).collect();
    let unit = match names[..] {
        ["time_s", acc] => Unit::of_column(acc),
        _ => None,
    }
    .ok_or_else(|| {
        table.refuse_header(format!(
            "the header `{}` is refused: accepted are time_s and one of acc_g, acc_m/s2 and acc_gal",
            names.join(",")
        ))
    })?;
    let interval = interval_s(&table)?;
    let acc = table.columns[1].iter().map(|a| a * unit.in_si()).collect();
    Ok((interval, acc))
}

/// The constant interval of a time column, s.
fn interval_s(table: &NumberTable) -> Result<f64, Failure> {
    let time = &table.columns[0];
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
        // Published times are rounded, to a tenth of a millisecond at worst.
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
    // The mean of rounded times, rounded back to a tenth of a microsecond.
    let mean = (time[time.len() - 1] - time[0]) / given.len() as f64;
    Ok((mean * 1e7).round() / 1e7)
}

/// PEER's format: three lines of text, the last of them with the unit, then NPTS and DT, then the values.
fn read_at2(file: &str, text: &str) -> Result<Points, Failure> {
    let mut head = None;
    let mut acc = Vec::new();
    for (i, line) in text.lines().enumerate() {
        if head.is_some() {
            for word in line.split_whitespace() {
                acc.push(number_at(file, i + 1, word)? * Unit::G.in_si());
            }
            continue;
        }
        let upper = line.to_uppercase();
        if i == 2 && !(upper.contains("ACCELERATION") && upper.trim_end().ends_with(" G")) {
            return Err(Failure::input(format!(
                "{file}, line 3: `{}` is refused: accepted is an acceleration in units of g",
                line.trim()
            )));
        }
        head = points_and_interval(&upper);
    }
    let (points, interval) = head.ok_or_else(|| {
        Failure::input(format!(
            "{file}: has no line with NPTS and DT, which a PEER AT2 file has"
        ))
    })?;
    if points != acc.len() as f64 || interval.is_nan() || interval <= 0.0 {
        return Err(Failure::input(format!(
            "{file}: the header says NPTS = {points} and DT = {interval} s, and the file has {} points: accepted are \
             as many as the header says, at an interval above 0",
            acc.len()
        )));
    }
    Ok((interval, acc))
}

/// `NPTS= 7500, DT= .02 SEC`, or in the older files `7500 .02 NPTS, DT`.
fn points_and_interval(upper: &str) -> Option<(f64, f64)> {
    let plain = upper.replace(['=', ','], " ");
    let words: Vec<&str> = plain.split_whitespace().collect();
    let at = |key: &str| words.iter().position(|w| *w == key);
    let (points, interval) = (at("NPTS")?, at("DT")?);
    let value = |i: usize| number(words.get(i)?);
    match (value(points + 1), value(interval + 1)) {
        (Some(n), Some(dt)) => Some((n, dt)),
        _ => Some((value(0)?, value(1)?)),
    }
}

fn read_column(file: &str, text: &str, columns: Columns) -> Result<Points, Failure> {
    let (Some(interval), Some(unit)) = (columns.interval_s, columns.unit) else {
        return Err(Failure::input(format!(
            "{file}: has one number a line and no header: accepted with --dt S and --unit g|m/s2|gal"
        )));
    };
    if !(interval > 0.0 && interval < 10.0) {
        return Err(Failure::input(format!(
            "--dt = {interval} is refused: accepted are seconds above 0 and below 10"
        )));
    }
    let lines = text.lines().enumerate().filter(|(_, l)| !is_comment(l));
    let acc = lines
        .map(|(i, line)| Ok(number_at(file, i + 1, line)? * unit.in_si()))
        .collect::<Result<_, Failure>>()?;
    Ok((interval, acc))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(name: &str, text: &str, columns: Columns) -> Result<GroundMotionFile, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        GroundMotionFile::load(&path, columns).map_err(|e| e.to_string())
    }

    fn plain(dt: f64, unit: Unit) -> Columns {
        Columns {
            interval_s: Some(dt),
            unit: Some(unit),
        }
    }

    #[test]
    fn the_same_motion_in_every_format_is_the_same() {
        let csv = load(
            "a.csv",
            "time_s,acc_g\n0,0.1\n0.02,-0.2\n0.04,0.3\n",
            Columns::default(),
        )
        .unwrap();
        let head = "PEER\nx\nACCELERATION TIME SERIES IN UNITS OF G\n";
        let text = format!("{head}NPTS=   3, DT= .0200 SEC\n .1 -.2\n .3\n");
        let at2 = load("a.AT2", &text, Columns::default()).unwrap();
        let text = format!("{head}   3   .0200   NPTS, DT\n .1 -.2\n .3\n");
        let old_at2 = load("a.at2", &text, Columns::default()).unwrap();
        let text = "# gal\n98.0665\n-196.133\n294.1995\n";
        let column = load("a.txt", text, plain(0.02, Unit::Gal)).unwrap();
        for other in [&at2, &old_at2, &column] {
            assert!((csv.interval_s - other.interval_s).abs() < 1e-9);
            for (a, b) in csv.acc_m_per_s2.iter().zip(&other.acc_m_per_s2) {
                assert!((a - b).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn rounded_times_are_a_constant_interval() {
        let mut text = "time_s,acc_g\n".to_owned();
        for i in 0..4000 {
            text += &format!("{:.4},0.1\n", f64::from(i) / 256.0);
        }
        let g = load("a.csv", &text, Columns::default()).unwrap();
        assert!((g.interval_s - 1.0 / 256.0).abs() < 1e-7);
    }

    #[test]
    fn each_mistake_is_refused_with_its_line() {
        let at2 = "x\ny\nACCELERATION IN UNITS OF G\n";
        for (name, text, said) in [
            (
                "a.csv",
                "time_s,acc_g\n0,0\n0.02,0\n0.04,0\n0.07,0\n",
                "line 5",
            ),
            ("a.csv", "time_s,acc_g\n0,0\n0.02,NaN\n", "line 3"),
            ("a.csv", "time_s,acc_g\n0,0\n0.02,x\n", "line 3"),
            (
                "a.csv",
                "time_s,acc_ft\n0,0\n0.02,0\n",
                "line 1: the header",
            ),
            ("a.csv", "time_s,vel_g\n0,0\n0.02,0\n", "line 1: the header"),
            ("a.csv", "acc_g\n0\n0.02\n", "line 1: the header"),
            ("a.csv", "0,0.1\n0.02,0.2\n", "line 1: `0` stands where"),
            (
                "a.csv",
                "time_s,acc_g\n0,0\n0.02,0,0\n",
                "line 3: has 3 columns",
            ),
            (
                "a.csv",
                "time_s,acc_g\n0,0\n-0.02,0\n",
                "line 3: time -0.02 s",
            ),
            ("a.csv", "time_s,acc_g\n0,0\n0.02,820\n", "820.000 g"),
            ("a.csv", "time_s,acc_g\n", "0 points"),
            ("a.csv", "", "is empty"),
            (
                "a.AT2",
                &format!("{at2}NPTS= 3, DT= .02 SEC\n.1 .2\n"),
                "NPTS = 3",
            ),
            (
                "a.AT2",
                &format!("{at2}NPTS= 2, DT= 0 SEC\n.1 .2\n"),
                "DT = 0",
            ),
            (
                "a.AT2",
                &format!("{at2}NPTS= 2, DT= .02 SEC\n.1 ab\n"),
                "line 5: `ab`",
            ),
            ("a.AT2", &format!("{at2}.1 .2\n"), "no line with NPTS"),
            (
                "a.AT2",
                "x\ny\nVELOCITY IN UNITS OF CM/S\nNPTS= 2, DT= .02 SEC\n.1 .2\n",
                "line 3",
            ),
            ("a.txt", "0\n1\n", "--dt"),
        ] {
            let e = load(name, text, Columns::default()).unwrap_err();
            assert!(e.contains(said), "{said} is not in: {e}");
            assert!(!e.contains('\n'));
        }
        let e = load("a.txt", "0\n1\nx\n", plain(0.01, Unit::G)).unwrap_err();
        assert!(e.contains("line 3: `x`"), "{e}");
        let e = load("a.txt", "0\n1\n", plain(-1.0, Unit::G)).unwrap_err();
        assert!(e.contains("--dt = -1"), "{e}");
        let csv = "time_s,acc_g\n0,0\n0.02,1\n";
        let e = load("a.csv", csv, plain(0.01, Unit::G)).unwrap_err();
        assert!(e.contains("0.02 s and --dt says 0.01 s"), "{e}");
    }
}
