//! `outerloop new`: a commented test file, a declared model, or a signal, as a start.

use crate::keys;
use askama::Template;
use experiment::failure::Failure;
use experiment::files::signal::{SignalPoints, SignalShape};
use experiment::files::test::TestFile;
use experiment::files::{look_ahead, output, units};
use experiment::numbers::three;
use std::f64::consts::TAU;
use std::io::{BufRead, stdin};
use std::path::{Path, PathBuf};

/// Write a commented test file: asks for the structure and the rig, or copies an example
#[derive(clap::Args, Debug)]
pub struct New {
    /// The file to write; an existing file is overwritten only with --force
    #[arg(default_value = "test.toml")]
    file: PathBuf,
    /// Copy this example instead of asking
    #[arg(long, value_name = "EXAMPLE")]
    from: Option<Example>,
    /// Write a declared model for `outerloop diagnose` instead, with every key explained
    #[arg(long, value_name = "FILE", conflicts_with_all = ["file", "from"])]
    model: Option<PathBuf>,
    /// Write a signal for measuring an actuator's frequency response instead, for `run --signal` and `board commission --signal`
    #[arg(long, value_name = "FILE", conflicts_with_all = ["file", "from", "model"])]
    signal: Option<PathBuf>,
    #[command(flatten)]
    shape: SignalArguments,
}

/// What the signal is.
#[derive(clap::Args, Debug)]
struct SignalArguments {
    /// Shape of the signal
    #[arg(long, default_value = "chirp", requires = "signal")]
    shape: SignalShape,
    /// Its largest displacement, mm
    #[arg(long, value_name = "MM", default_value_t = 5.0, value_parser = |text: &str| number_in("mm", text), requires = "signal")]
    peak_mm: f64,
    /// Its lowest and its highest frequency, Hz
    #[arg(long, value_name = "LOW,HIGH", default_value = "0.2,10", value_parser = band, requires = "signal")]
    band_hz: [f64; 2],
    /// Its length, s
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = |text: &str| number_in("s", text), requires = "signal")]
    seconds: f64,
}

impl SignalArguments {
    fn text(&self) -> Result<String, Failure> {
        let made = SignalPoints::made(self.shape, 1e-3 * self.peak_mm, self.band_hz, self.seconds);
        Ok(made.map_err(Failure::input)?.to_csv())
    }
}

/// A number, with its unit if one is given.
fn number_in(unit: &str, text: &str) -> Result<f64, String> {
    match units::converted(text, unit) {
        Ok(Some(x)) => Ok(x),
        Ok(None) => Err(format!(
            "`{text}` is no number: accepted is one, with its unit if you like, as in `5 {unit}`"
        )),
        Err(why) => Err(format!("`{text}` is refused: {why}")),
    }
}

/// Two frequencies, Hz.
fn band(text: &str) -> Result<[f64; 2], String> {
    let Some((low, high)) = text.split_once(',') else {
        return Err(format!(
            "`{text}` is no band: accepted are two frequencies with a comma between them, as in `0.2,10`"
        ));
    };
    Ok([number_in("Hz", low)?, number_in("Hz", high)?])
}

/// The examples of the repository.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Example {
    /// One degree of freedom on an actuator 4 ms late: the structure of Table 1 of the paper
    Table1,
    /// A steel frame at yield on a hydraulic actuator, with noise and a Kalman filter: the experiment of the paper
    SteelFrame,
    /// Three storeys, an actuator at each
    ThreeStorey,
    /// Three storeys, of which the lowest stands in the laboratory
    Hybrid,
    /// A frame on two coupled actuators: displacement and rotation
    CoupledFrame,
    /// A servo-hydraulic ram in place of a real one, for the tutorial
    HydraulicRam,
}

impl Example {
    const fn text(self) -> &'static str {
        match self {
            Self::Table1 => include_str!("../../../examples/table1.toml"),
            Self::SteelFrame => include_str!("../../../examples/steel-frame.toml"),
            Self::ThreeStorey => include_str!("../../../examples/three-storey.toml"),
            Self::Hybrid => include_str!("../../../examples/hybrid.toml"),
            Self::CoupledFrame => include_str!("../../../examples/coupled-frame.toml"),
            Self::HydraulicRam => include_str!("../../../examples/hydraulic-ram.toml"),
        }
    }
}

impl New {
    /// Writes the file.
    ///
    /// # Errors
    /// A file that already exists; an answer that cannot be used.
    pub fn run(&self) -> Result<(), Failure> {
        let path = self
            .model
            .as_ref()
            .or(self.signal.as_ref())
            .unwrap_or(&self.file);
        let file = path.display();
        look_ahead::file(Some(path))?;
        if path.exists() && !look_ahead::is_forced() {
            return Err(Failure::input(format!(
                "{file}: is there already: accepted is the name of a new file, or --force"
            )));
        }
        let (text, next) = match (&self.model, &self.signal, self.from) {
            (_, Some(_), _) => (
                self.shape.text()?,
                format!(
                    "outerloop run TEST.toml --signal {file} --out out; outerloop identify out/record.csv --out out/actuator"
                ),
            ),
            (Some(_), ..) => (
                keys::declared_model(&keys::all()),
                format!(
                    "write your numbers into it; outerloop diagnose --model {file} --train RECORD@T0..T1 --test RECORD@T1..T2"
                ),
            ),
            (None, None, example) => {
                let text = match example {
                    Some(example) => example.text().to_owned(),
                    None => {
                        let text =
                            asked(path.parent().unwrap_or(Path::new("")), &mut stdin().lock())?;
                        TestFile::parse(&text, &file.to_string(), Path::new(""), &[])?;
                        text
                    }
                };
                let next = format!(
                    "outerloop check {file}; outerloop run {file} --out out; outerloop keys lists all that it can say."
                );
                (text, next)
            }
        };
        output::write(path, &text)?;
        println!("{file} is written. Next: {next}");
        Ok(())
    }
}

/// A person's description of the structure and the rig.
#[derive(Template)]
#[template(path = "new.toml", escape = "none")]
struct RigInWords {
    storeys: usize,
    mass_kg: f64,
    stiffness_n_per_m: f64,
    damping_ratio: f64,
    delay_ms: f64,
    lag_ms: f64,
    stroke_mm: f64,
    force_kn: f64,
    record: String,
}

fn asked(folder: &Path, from: &mut impl BufRead) -> Result<String, Failure> {
    println!(
        "An empty answer takes the value in brackets; a value may say another unit, as in `1 t` or `158 N/mm`."
    );
    let mut number = |question: &str, unit: &'static str, usual: f64, range| {
        answered(question, unit, usual, range, from)
    };
    let storeys = loop {
        let n = number(
            "Storeys, all of them in the laboratory",
            "",
            1.0,
            [1.0, 8.0],
        )?;
        if n.fract() == 0.0 {
            break n;
        }
        println!("{n} is no whole number. Once more:");
    };
    let mass_kg = number("Mass of a floor", "kg", 1000.0, [1e-3, 1e9])?;
    let stiffness = number("Stiffness of a storey", "kN/m", 158.0, [1e-6, 1e9])?;
    let damping = number("Damping ratio, of critical", "%", 2.0, [0.0, 50.0])?;
    println!(
        "`outerloop identify` finds the next two from a record of the actuator; guesses will do for now."
    );
    let delay_ms = number("Transport delay of the actuator", "ms", 4.0, [0.0, 1000.0])?;
    let lag_ms = number(
        "Lag (time constant) of the actuator",
        "ms",
        0.0,
        [0.0, 1000.0],
    )?;
    let stroke_mm = number(
        "Largest displacement that the rig may see",
        "mm",
        100.0,
        [1e-3, 1e4],
    )?;
    let force_kn = number(
        "Largest force that the rig may see",
        "kN",
        25.0,
        [1e-6, 1e6],
    )?;
    let record = ground_motion(folder, from)?;
    let rig = RigInWords {
        storeys: storeys as usize,
        mass_kg,
        stiffness_n_per_m: stiffness * 1e3,
        damping_ratio: damping / 100.0,
        delay_ms,
        lag_ms,
        stroke_mm,
        force_kn,
        record,
    };
    let text = rig.render().map(|text| text + "\n");
    text.map_err(|e| Failure::test(format!("the test file cannot be written: {e}")))
}

/// A number in `unit` between `low` and `high`; asks again until the answer is valid.
fn answered(
    question: &str,
    unit: &'static str,
    usual: f64,
    [low, high]: [f64; 2],
    from: &mut dyn BufRead,
) -> Result<f64, Failure> {
    let unit_said = if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    };
    loop {
        let answer = line(&format!("{question} [{usual}{unit_said}]"), from)?;
        if answer.is_empty() {
            return Ok(usual);
        }
        let why = match units::converted(&answer.replace(',', "."), unit) {
            // 0.02 would be 2 % to one engineer and 0.02 % to another.
            Ok(Some(x)) if unit == "%" && x > 0.0 && x < 0.2 && !answer.ends_with('%') => {
                format!(
                    "is that {x} % or {} %? Say it with its unit",
                    three(100.0 * x)
                )
            }
            Ok(Some(x)) if (low..=high).contains(&x) => return Ok(x),
            Ok(_) => format!("accepted are numbers from {low} to {high}{unit_said}"),
            Err(why) => why,
        };
        println!("`{answer}` is no answer: {why}. Once more:");
    }
}

/// The name of a ground motion in the test file's folder, or nothing; asks again until the file exists.
fn ground_motion(folder: &Path, from: &mut dyn BufRead) -> Result<String, Failure> {
    loop {
        let answer = line(
            "Ground motion, a file beside this one [the built-in near-fault record]",
            from,
        )?;
        if answer.is_empty() || folder.join(&answer).is_file() {
            return Ok(answer);
        }
        println!("`{answer}` is no answer: accepted are files that are there. Once more:");
    }
}

fn line(question: &str, from: &mut dyn BufRead) -> Result<String, Failure> {
    println!("{question}:");
    let mut answer = String::new();
    let read = from
        .read_line(&mut answer)
        .map_err(|e| Failure::input(format!("the answer cannot be read: {e}")))?;
    if read == 0 {
        return Err(Failure::input(format!(
            "standard input ended before `{question}` was answered: accepted are answers, or --from EXAMPLE; nothing is written"
        )));
    }
    Ok(answer.trim().to_owned())
}

impl RigInWords {
    /// The same value for each storey.
    fn each(&self, value: &f64) -> String {
        match self.storeys {
            1 => format!("{value}"),
            n => format!("[{}]", vec![format!("{value}"); n].join(", ")),
        }
    }

    /// Lowest natural frequency of a uniform shear frame, Hz: 2 sin(pi / (4 n + 2)) sqrt(k / m) / (2 pi).
    fn lowest_hz(&self) -> String {
        let share = 2.0 * (std::f64::consts::PI / (4 * self.storeys + 2) as f64).sin();
        three(share * (self.stiffness_n_per_m / self.mass_kg).sqrt() / TAU)
    }

    /// Tolerance of an answered value: this share of it, plus `least`.
    fn tolerance(value: &f64, share: f64, least: f64) -> String {
        three(share * value + least)
    }

    /// Two thirds of the rig's range, in displacement or force, whichever is smaller, mm.
    fn peak_mm(&self) -> f64 {
        let by_force = self.force_kn * 1e6 / self.stiffness_n_per_m;
        let mm = self.stroke_mm.min(by_force) * 2.0 / 3.0;
        three(mm).parse().unwrap_or(mm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(answers: &str) -> Result<String, String> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("KOBE.AT2"), "").unwrap();
        asked(folder.path(), &mut answers.as_bytes()).map_err(|e| e.to_string())
    }

    #[test]
    fn any_answers_give_a_file_that_is_accepted() {
        for (answers, said) in [
            ("\n\n\n\n\n\n\n\n\n", "158000"),
            (
                "3\n500\n200\n5\n8\n22,5\n40\n10\nKOBE.AT2\n",
                "lag_ms = 22.5",
            ),
        ] {
            let text = written(answers).unwrap();
            assert!(text.contains(said), "{text}");
            TestFile::parse(&text, "new", Path::new(""), &[]).unwrap();
        }
        let e = written("3\n").unwrap_err();
        assert!(e.contains("ended before `Mass of a floor"), "{e}");
    }

    #[test]
    fn a_wrong_answer_is_asked_again_and_a_value_may_say_its_unit() {
        let text =
            written("1.5\n1\nheavy\n5 kN\n2 t\n1e99\n316 N/mm\n0.03\n3 %\n0.008 s\n\n\n\n\n")
                .unwrap();
        for said in [
            "mass_kg = 2000\n",
            "stiffness_n_per_m = 316000\n",
            "damping_ratio = 0.03\n",
            "delay_ms = 8 ",
        ] {
            assert!(text.contains(said), "{said} is missing:\n{text}");
        }
    }
}
