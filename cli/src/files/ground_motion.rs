//! Ground motions: `time_s,acc_g` CSV, PEER AT2, or one acceleration a line.

use super::read;
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

/// What is said about a file that does not say it itself.
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
}

impl GroundMotionFile {
    /// Reads a file by its ending and its first lines.
    ///
    /// # Errors
    /// Anything that cannot be what it says, with the line.
    pub fn load(path: &Path, columns: Columns) -> Result<Self, Failure> {
        let text = read(path)?;
        let name = path
            .file_stem()
            .map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let file = path.display().to_string();
        let at2 = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("at2"));
        let header = text.lines().find(|l| !is_comment(l)).unwrap_or("");
        let (interval_s, acc) = if at2 {
            read_at2(&file, &text)?
        } else if header.contains(',') || header.contains("time") {
            read_csv(&file, &text)?
        } else {
            read_column(&file, &text, columns)?
        };
        if acc.len() < 2 {
            return Err(Failure::input(format!(
                "{file}: has {} points: accepted are at least 2",
                acc.len()
            )));
        }
        Ok(Self {
            name,
            acc_m_per_s2: acc.iter().map(|a| *a as f32).collect(),
            interval_s,
        })
    }
}

fn is_comment(line: &str) -> bool {
    line.trim().is_empty() || line.trim_start().starts_with('#')
}

fn number(file: &str, line: usize, text: &str) -> Result<f64, Failure> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err(Failure::input(format!(
            "{file}, line {line}: `{}` is no finite number",
            text.trim()
        ))),
    }
}

fn read_csv(file: &str, text: &str) -> Result<(f64, Vec<f64>), Failure> {
    let mut lines = text.lines().enumerate().filter(|(_, l)| !is_comment(l));
    let (at, header) = lines
        .next()
        .ok_or_else(|| Failure::input(format!("{file}: is empty")))?;
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let factor = match names[..] {
        ["time_s", "acc_g"] => Unit::G.in_si(),
        ["time_s", "acc_m/s2" | "acc_m_per_s2"] => Unit::MetrePerSecondSquared.in_si(),
        ["time_s", "acc_gal"] => Unit::Gal.in_si(),
        _ => {
            return Err(Failure::input(format!(
                "{file}, line {}: header `{}` is refused: accepted are time_s with acc_g, acc_m/s2 or acc_gal",
                at + 1,
                header.trim()
            )));
        }
    };
    let (mut times, mut acc) = (Vec::<f64>::new(), Vec::new());
    for (i, line) in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let [t, a] = cells[..] else {
            return Err(Failure::input(format!(
                "{file}, line {}: has {} columns where the header has 2",
                i + 1,
                cells.len()
            )));
        };
        let t = number(file, i + 1, t)?;
        // The interval is that of the first two points; published files round their times.
        if let [first, second, ..] = times[..] {
            let expected = first + (second - first) * times.len() as f64;
            if (t - expected).abs() > 0.05 * (second - first) + 1e-4 * expected.abs() {
                return Err(Failure::input(format!(
                    "{file}, line {}: time {t} s where {expected:.4} s is expected: accepted is a constant interval",
                    i + 1
                )));
            }
        } else if let [first] = times[..]
            && t <= first
        {
            return Err(Failure::input(format!(
                "{file}, line {}: time {t} s does not increase",
                i + 1
            )));
        }
        times.push(t);
        acc.push(number(file, i + 1, a)? * factor);
    }
    let interval = match times[..] {
        [first, .., last] => (last - first) / (times.len() - 1) as f64,
        _ => 0.0,
    };
    // The mean interval of rounded times, itself rounded back to a tenth of a microsecond.
    Ok(((interval * 1e7).round() / 1e7, acc))
}

fn read_at2(file: &str, text: &str) -> Result<(f64, Vec<f64>), Failure> {
    let (mut points, mut interval) = (None, None);
    let mut acc = Vec::new();
    for (i, line) in text.lines().enumerate() {
        if points.is_none() {
            let upper = line.to_uppercase().replace(['=', ','], " ");
            let words: Vec<&str> = upper.split_whitespace().collect();
            let after = |key: &str| {
                let at = words.iter().position(|w| *w == key)?;
                words.get(at + 1)?.parse::<f64>().ok()
            };
            if let (Some(n), Some(dt)) = (after("NPTS"), after("DT")) {
                (points, interval) = (Some(n as usize), Some(dt));
            } else if i == 2 && !upper.contains(" G") {
                return Err(Failure::input(format!(
                    "{file}, line 3: the unit `{}` is refused: accepted is g",
                    line.trim()
                )));
            }
            continue;
        }
        for word in line.split_whitespace() {
            acc.push(number(file, i + 1, word)? * Unit::G.in_si());
        }
    }
    let (Some(points), Some(interval)) = (points, interval) else {
        return Err(Failure::input(format!(
            "{file}: has no line with NPTS and DT, which a PEER AT2 file has"
        )));
    };
    if points != acc.len() || interval <= 0.0 || interval.is_nan() {
        return Err(Failure::input(format!(
            "{file}: the header says NPTS = {points}, DT = {interval} s and the file has {} points",
            acc.len()
        )));
    }
    Ok((interval, acc))
}

fn read_column(file: &str, text: &str, columns: Columns) -> Result<(f64, Vec<f64>), Failure> {
    let (Some(interval), Some(unit)) = (columns.interval_s, columns.unit) else {
        return Err(Failure::input(format!(
            "{file}: has one number a line and no header: give --dt S and --unit g|m/s2|gal"
        )));
    };
    if !(interval > 0.0 && interval < 10.0) {
        return Err(Failure::input(format!(
            "--dt = {interval} is refused: accepted are seconds above 0 and below 10"
        )));
    }
    let mut acc = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, l)| !is_comment(l)) {
        acc.push(number(file, i + 1, line)? * unit.in_si());
    }
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

    #[test]
    fn all_three_forms_mean_the_same() {
        let csv = load(
            "a.csv",
            "# x\ntime_s,acc_g\n0,0.1\n0.02,-0.2\n0.04,0.3\n",
            Columns::default(),
        )
        .unwrap();
        let at2 = load(
            "a.AT2",
            "PEER\nx\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS=   3, DT= .0200 SEC\n .1 -.2\n .3\n",
            Columns::default(),
        )
        .unwrap();
        let columns = Columns {
            interval_s: Some(0.02),
            unit: Some(Unit::Gal),
        };
        let plain = load("a.txt", "98.0665\n-196.133\n294.1995\n", columns).unwrap();
        for other in [&at2, &plain] {
            assert!((csv.interval_s - other.interval_s).abs() < 1e-9);
            for (a, b) in csv.acc_m_per_s2.iter().zip(&other.acc_m_per_s2) {
                assert!((a - b).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn each_mistake_is_refused_with_its_line() {
        for (name, text, said) in [
            ("a.csv", "time_s,acc_g\n0,0\n0.02,0\n0.05,0\n", "line 4"),
            ("a.csv", "time_s,acc_g\n0,0\n0.02,NaN\n", "line 3"),
            ("a.csv", "time_s,acc_g\n0,0\n0.02,x\n", "line 3"),
            ("a.csv", "time_s,acc_ft\n0,0\n0.02,0\n", "line 1"),
            ("a.csv", "time_s,acc_g\n0,0\n0.02,0,0\n", "line 3"),
            ("a.csv", "time_s,acc_g\n0,0\n-0.02,0\n", "does not increase"),
            (
                "a.AT2",
                "x\ny\nACCELERATION IN UNITS OF G\nNPTS= 3, DT= .02 SEC\n.1 .2\n",
                "NPTS = 3",
            ),
            (
                "a.AT2",
                "x\ny\nVELOCITY IN UNITS OF CM/S\nNPTS= 2, DT= .02 SEC\n.1 .2\n",
                "unit",
            ),
            ("a.txt", "0\n1\n", "--dt"),
            ("a.csv", "time_s,acc_g\n", "0 points"),
        ] {
            let e = load(name, text, Columns::default()).unwrap_err();
            assert!(e.contains(said), "{e}");
            assert!(!e.contains('\n'));
        }
    }
}
