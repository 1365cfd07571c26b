//! Ground motions: CSV with `time_s,acc_g` in any dialect, PEER AT2, the networks' formats, or accelerations alone.

mod at2;
mod fortran;
mod strong_motion;

use super::header::unit_named;
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
    const fn name(self) -> &'static str {
        match self {
            Self::G => "g",
            Self::MetrePerSecondSquared => "m/s2",
            Self::Gal => "gal",
        }
    }

    fn in_si(self) -> f64 {
        match self {
            Self::G => 9.80665,
            Self::MetrePerSecondSquared => 1.0,
            Self::Gal => 0.01,
        }
    }

    /// By its name, in lower case.
    fn named(name: &str) -> Option<Self> {
        match unit_named(name)? {
            "g" => Some(Self::G),
            "m_per_s2" => Some(Self::MetrePerSecondSquared),
            "gal" => Some(Self::Gal),
            _ => None,
        }
    }
}

/// The strongest that was ever recorded is 4.4 g (Iwate-Miyagi 2008): beyond this the unit is not what the file says.
const STRONGEST_M_PER_S2: f64 = 6.0 * 9.80665;

/// What a file holds.
struct Points {
    interval_s: f64,
    acc_m_per_s2: Vec<f64>,
    /// The unit that the file itself says; `None`: it was said beside it.
    unit: Option<Unit>,
}

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
        let points = if at2 || at2::is_at2(&text) {
            at2::parse(&file, &text)?
        } else if let Some(format) = strong_motion::Format::of(&text) {
            format.parse(&file, &text)?
        } else if first.split_whitespace().all(|w| number(w).is_some()) && !first.is_empty() {
            read_numbers(&file, &text, columns)?
        } else {
            read_csv(&file, &text)?
        };
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

    /// Times, s, and accelerations, g; `name` is shown.
    ///
    /// # Errors
    /// As of a file with the header `time_s,acc_g`.
    pub fn of_columns(name: &str, time_s: Vec<f64>, acc_g: Vec<f64>) -> Result<Self, Failure> {
        let names = ["time_s", "acc_g"].map(str::to_owned);
        let table = NumberTable::of_columns(name, "its names", &names, vec![time_s, acc_g])?;
        Self::of_points(name, name, points_of(&table)?)
    }

    /// What a file says, if it can be an earthquake.
    fn of_points(file: &str, name: &str, points: Points) -> Result<Self, Failure> {
        let acc = points.acc_m_per_s2;
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

/// That something in a line, counted from 0, is not what it should be.
fn refuse_line(file: &str, line: usize, text: &str, accepted: &str) -> Failure {
    let shown: String = text.trim().chars().take(SHOWN).collect();
    let line = line + 1;
    Failure::input(format!(
        "{file}, line {line}: `{shown}` is refused: accepted is {accepted}"
    ))
}

/// Letters of a line that a message shows.
const SHOWN: usize = 60;

/// All numbers from line `from`, counted from 0, to the end, in m/s^2.
fn values(
    file: &str,
    text: &str,
    from: usize,
    width: Option<usize>,
    unit: Unit,
) -> Result<Vec<f64>, Failure> {
    let mut acc = Vec::new();
    for (i, line) in text.lines().enumerate().skip(from) {
        for value in fortran::numbers(line, width) {
            let value = value.map_err(|word| refuse_line(file, i, word, "a finite number"))?;
            acc.push(value * unit.in_si());
        }
    }
    Ok(acc)
}

fn read_csv(file: &str, text: &str) -> Result<Points, Failure> {
    points_of(&NumberTable::parse(file, text)?)
}

/// A table with times and accelerations.
fn points_of(table: &NumberTable) -> Result<Points, Failure> {
    let names: Vec<String> = table.headers.iter().map(|h| h.name(|_| false)).collect();
    let unit = match &names[..] {
        [time, acc] if time == "time_s" => acc.strip_prefix("acc_").and_then(Unit::named),
        _ => None,
    }
    .ok_or_else(|| {
        let header: String = names.join(",").chars().take(SHOWN).collect();
        table.refuse_header(format!(
            "the header `{header}` is refused: accepted are time_s and one of acc_g, acc_m_per_s2 and acc_gal; read too \
             are PEER AT2, COSMOS, CSMIP, SMC and ESM files, and plain numbers with --dt and --unit"
        ))
    })?;
    let interval = interval_s(table)?;
    Ok(Points {
        interval_s: interval,
        acc_m_per_s2: table.columns[1].iter().map(|a| a * unit.in_si()).collect(),
        unit: Some(unit),
    })
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

/// Accelerations alone, any number of them a line, or time and acceleration in two columns without a header.
fn read_numbers(file: &str, text: &str, columns: Columns) -> Result<Points, Failure> {
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
            Ok(points(interval_s(&table)?, &table.columns[1]))
        }
        None => Err(Failure::input(format!(
            "{file}: has numbers and no times: accepted with --dt S"
        ))),
    }
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
    fn the_networks_formats_hold_the_same_motion() {
        // 0.1, -0.2 and 0.3 g in cm/s^2, eight fields of ten a line.
        let fixed = "   98.0665 -196.1330  294.1995\n";
        let csmip = format!(
            "CORRECTED ACCELEROGRAM\nstation\n      3 points of accel data equally spaced at  .020 sec, in cm/sec2. \
             (8f10.4)\n{fixed}      3 points of veloc data equally spaced at  .020 sec, in cm/sec.  (8f10.4)\n{fixed}"
        );
        let reals: String = (1..=100)
            .map(|i| {
                let x = if i == 62 { 0.02 } else { f64::from(i) };
                format!("{x:15.6E}{}", if i % 5 == 0 { "\n" } else { "" })
            })
            .collect();
        let cosmos = format!(
            "Corrected acceleration  (Format v01.20 with 13 text lines)\n 100 Real-header values follow on 20 lines, \
             Format= (5E15.6)\n{reals}      3 acceleration pts, approx 0 secs, units=cm/sec2 (04), \
             Format=(8F10.4)\n{fixed}End-of-data for Chan  1 acceleration\n"
        );
        let integers: String = (1..=48)
            .map(|i| {
                let n = match i {
                    16 => 1,
                    17 => 3,
                    _ => -32768,
                };
                format!("{n:10}{}", if i % 8 == 0 { "\n" } else { "" })
            })
            .collect();
        let reals: String = (1..=50)
            .map(|i| {
                let x = if i == 2 { 50.0 } else { 1.7e38 };
                format!("{x:15.7E}{}", if i % 5 == 0 { "\n" } else { "" })
            })
            .collect();
        let smc = format!(
            "2 CORRECTED ACCELEROGRAM\n{}{integers}{reals}|a comment\n{fixed}",
            "text\n".repeat(10)
        );
        let esm = "EVENT_NAME: central_italy\nSAMPLING_INTERVAL_S: 0.020000\nNDATA: 3\nUNITS: cm/s^2\n\
                   DATA_TYPE: ACCELERATION\n98.0665\n-196.133\n294.1995\n";
        let at2 = "PEER\nKöln\nACCELERATION TIME HISTORY IN UNITS OF CM/SEC/SEC\nNPTS= 3, DT= .0200 SEC\n\
                   .980665D+02-.196133D+03 .2941995D+03\n";
        let dialect = "Zeit [s];Acceleration (m/s²)\n0,00;0,980665\n0,02;-1,96133\n0,04;2,941995\n";
        for (name, text) in [
            ("a.v2", csmip.as_str()),
            ("b.V2C", &cosmos),
            ("c.smc", &smc),
            ("d.ASC", esm),
            ("e.txt", at2),
            ("f.csv", dialect),
        ] {
            let g = load(name, text, Columns::default()).unwrap();
            assert!(
                (g.interval_s - 0.02).abs() < 1e-9,
                "{name}: {}",
                g.interval_s
            );
            let expected = [0.1, -0.2, 0.3].map(|x| (x * 9.80665) as f32);
            assert_eq!(g.acc_m_per_s2.len(), 3, "{name}");
            for (a, b) in g.acc_m_per_s2.iter().zip(expected) {
                assert!((a - b).abs() < 1e-5, "{name}: {a} {b}");
            }
        }
        let one_line = load("g.txt", "98.0665 -196.133 294.1995", plain(0.02, Unit::Gal)).unwrap();
        assert_eq!(one_line.acc_m_per_s2.len(), 3);
        let unit = Columns {
            unit: Some(Unit::Gal),
            ..Columns::default()
        };
        let two = load("h.txt", "0 98.0665\n0.02 -196.133\n0.04 294.1995\n", unit).unwrap();
        assert!((two.interval_s - 0.02).abs() < 1e-9 && two.acc_m_per_s2.len() == 3);

        let less = esm.replace("NDATA: 3", "NDATA: 4");
        let velocity = esm.replace("ACCELERATION", "VELOCITY");
        let few = csmip.replacen("      3", "     30", 1);
        for (name, text, said) in [
            ("d.ASC", less.as_str(), "NPTS = 4"),
            ("d.ASC", &velocity, "line 5: `VELOCITY`"),
            ("a.v2", &few, "line 5: `3 po`"),
            ("e.txt", &at2.replace("CM/SEC/SEC", "FT/SEC/SEC"), "line 3"),
        ] {
            let e = load(name, text, Columns::default()).unwrap_err();
            assert!(e.contains(said), "{said} is not in: {e}");
        }
        let e = load("a.csv", "time_s,acc_g\n0,0\n0.02,1\n", unit).unwrap_err();
        assert!(e.contains("is in g and --unit says gal"), "{e}");
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
