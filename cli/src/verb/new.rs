//! `outerloop new`: a commented test file to begin with.

use experiment::failure::Failure;
use experiment::files::output;
use experiment::files::test::TestFile;
use experiment::numbers::three;
use std::f64::consts::TAU;
use std::io::{BufRead, stdin};
use std::path::{Path, PathBuf};

/// Write a commented test file: asks for the structure and the rig, or copies an example
#[derive(clap::Args, Debug)]
pub struct New {
    /// The file to write; an existing file is not overwritten
    #[arg(default_value = "test.toml")]
    file: PathBuf,
    /// Begin with this example instead of asking
    #[arg(long, value_name = "EXAMPLE")]
    from: Option<Example>,
}

/// The examples of the repository.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Example {
    /// One degree of freedom on an actuator 4 ms late: the structure of Table 1 of the paper
    Table1,
    /// A steel frame at its yield on a hydraulic actuator, with noise and a Kalman filter: the paper's own experiment
    SteelFrame,
    /// Three storeys, an actuator at each
    ThreeStorey,
    /// Three storeys, of which the lowest stands in the laboratory
    Hybrid,
    /// A frame on two coupled actuators: displacement and rotation
    CoupledFrame,
}

impl Example {
    const fn text(self) -> &'static str {
        match self {
            Self::Table1 => include_str!("../../../examples/table1.toml"),
            Self::SteelFrame => include_str!("../../../examples/steel-frame.toml"),
            Self::ThreeStorey => include_str!("../../../examples/three-storey.toml"),
            Self::Hybrid => include_str!("../../../examples/hybrid.toml"),
            Self::CoupledFrame => include_str!("../../../examples/coupled-frame.toml"),
        }
    }
}

impl New {
    /// Writes the file.
    ///
    /// # Errors
    /// A file that is there already; an answer that cannot be used.
    pub fn run(&self) -> Result<(), Failure> {
        let file = self.file.display();
        if self.file.exists() {
            return Err(Failure::input(format!(
                "{file}: is there already: accepted is the name of a new file"
            )));
        }
        let text = match self.from {
            Some(example) => example.text().to_owned(),
            None => {
                let text = asked(&mut stdin().lock())?;
                TestFile::parse(&text, &file.to_string(), Path::new(""), &[])?;
                text
            }
        };
        output::write(&self.file, &text)?;
        println!(
            "{file} is written. Next: outerloop check {file}; outerloop run {file} --out out; outerloop keys lists all \
             that it can say."
        );
        Ok(())
    }
}

/// What a person says of the structure and the rig.
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

fn asked(from: &mut impl BufRead) -> Result<String, Failure> {
    println!("An empty answer takes the value in brackets.");
    let number = |question: &str, usual: f64, from: &mut dyn BufRead, low: f64, high: f64| {
        let answer = line(&format!("{question} [{usual}]"), from)?;
        if answer.is_empty() {
            return Ok(usual);
        }
        let read = answer.replace(',', ".").parse().ok();
        read.filter(|x| (low..=high).contains(x)).ok_or_else(|| {
            Failure::input(format!(
                "`{answer}` is no answer to `{question}`: accepted are numbers from {low} to {high}"
            ))
        })
    };
    let storeys = number(
        "Storeys, all of them in the laboratory",
        1.0,
        from,
        1.0,
        8.0,
    )?;
    let mass_kg = number("Mass of a floor, kg", 1000.0, from, 1e-3, 1e9)?;
    let stiffness = number("Stiffness of a storey, kN/m", 158.0, from, 1e-6, 1e9)?;
    let damping = number("Damping ratio, per cent of critical", 2.0, from, 0.0, 50.0)?;
    println!(
        "`outerloop identify` finds the next two from a record of the actuator; guesses will do for now."
    );
    let delay_ms = number(
        "Transport delay of the actuator, ms",
        4.0,
        from,
        0.0,
        1000.0,
    )?;
    let lag_ms = number(
        "Lag (time constant) of the actuator, ms",
        0.0,
        from,
        0.0,
        1000.0,
    )?;
    let stroke_mm = number(
        "Largest displacement that the rig may see, mm",
        100.0,
        from,
        1e-3,
        1e4,
    )?;
    let force_kn = number(
        "Largest force that the rig may see, kN",
        25.0,
        from,
        1e-6,
        1e6,
    )?;
    let record = line(
        "Ground motion, a file [the built-in near-fault record]",
        from,
    )?;
    Ok(RigInWords {
        storeys: storeys.round() as usize,
        mass_kg,
        stiffness_n_per_m: stiffness * 1e3,
        damping_ratio: damping / 100.0,
        delay_ms,
        lag_ms,
        stroke_mm,
        force_kn,
        record,
    }
    .text())
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
    fn text(&self) -> String {
        let each = |x: f64| match self.storeys {
            1 => format!("{x}"),
            n => format!("[{}]", vec![format!("{x}"); n].join(", ")),
        };
        // The lowest mode of a uniform shear frame: 2 sin(pi / (4 n + 2)) sqrt(k / m).
        let share = 2.0 * (std::f64::consts::PI / (4 * self.storeys + 2) as f64).sin();
        let hz = share * (self.stiffness_n_per_m / self.mass_kg).sqrt() / TAU;
        let (kind, lag) = if self.lag_ms > 0.0 {
            (
                "lag_delay",
                format!("lag_ms = {:<14}# first-order time constant\n", self.lag_ms),
            )
        } else {
            ("delay", String::new())
        };
        let record = if self.record.is_empty() {
            "# record = \"KOBE.AT2\"   # a file beside this one; left out: the built-in near-fault record\n".to_owned()
        } else {
            format!("record = {:?}\n", self.record)
        };
        format!(
            "# A fast pseudodynamic test. `outerloop keys` lists every key with unit, default and meaning.\n\
             #\n\
             #   outerloop check FILE           can it be stable, before the oil is on\n\
             #   outerloop run FILE --out out   the test on the simulated rig, with a report\n\
             \n\
             [structure]               # from the ground up; its lowest natural frequency is about {} Hz\n\
             mass_kg = {}\n\
             stiffness_n_per_m = {}\n\
             damping_ratio = {}\n\
             \n\
             [loop]\n\
             rate_hz = 2000            # control steps in a second\n\
             time_scale = 1            # 1: real time, 10: ten times slower\n\
             \n\
             [compensation]\n\
             kind = \"paper\"            # `outerloop run --help` lists all\n\
             delay_ms = {:<15}# what the compensation is told: delay and lag of the actuator\n\
             \n\
             [limits]                  # the test trips beyond them\n\
             displacement_m = {}\n\
             force_n = {}\n\
             \n\
             [excitation]\n\
             {record}\
             peak_response_mm = {:<7}# the motion is scaled until the linear structure moves so far\n\
             \n\
             [plant.actuator]          # the simulated rig; `outerloop identify RECORD --write FILE` fills this in\n\
             kind = \"{kind}\"\n\
             delay_ms = {:<15}# transport delay\n\
             {lag}\
             \n\
             [plant.specimen]\n\
             kind = \"linear\"           # or bilinear, bouc_wen: then yield_mm as well\n\
             \n\
             [plant.sensors]\n\
             displacement_noise_mm = 0 # rms\n\
             force_noise_n = 0         # rms\n",
            three(hz),
            each(self.mass_kg),
            each(self.stiffness_n_per_m),
            each(self.damping_ratio),
            self.delay_ms + self.lag_ms,
            self.stroke_mm / 1e3,
            self.force_kn * 1e3,
            self.peak_mm(),
            self.delay_ms,
        )
    }

    /// Two thirds of what the rig may see, in displacement and force.
    fn peak_mm(&self) -> f64 {
        let by_force = self.force_kn * 1e6 / self.stiffness_n_per_m;
        let mm = self.stroke_mm.min(by_force) * 2.0 / 3.0;
        three(mm).parse().unwrap_or(mm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answered(answers: &str) -> Result<String, String> {
        asked(&mut answers.as_bytes()).map_err(|e| e.to_string())
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
            let text = answered(answers).unwrap();
            assert!(text.contains(said), "{text}");
            TestFile::parse(&text, "new", Path::new(""), &[]).unwrap();
        }
        let e = answered("3\n").unwrap_err();
        assert!(e.contains("ended before `Mass of a floor"), "{e}");
        let e = answered("1\nheavy\n").unwrap_err();
        assert!(
            e.contains("`heavy`") && e.contains("Mass of a floor"),
            "{e}"
        );
    }
}
