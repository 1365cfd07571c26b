//! The flashed image on an emulated board: both are built, and the link runs over the emulator's pipes.

use super::bench::only_x_and_rotation;
use super::build::{built_emulator, built_image};
use super::desk;
use super::desk::incident::Incident;
use super::image::Image;
use super::in_turns::{InTurns, Turns};
use super::limits::PlannedMotion;
use experiment::failure::Failure;
use experiment::files::test::TestFile;
use link::Calibration;
use outerloop_core::config::Limits;
use plant::RigSpec;
use plant::coupled::{CoupledRigSpec, CouplerSpec};
use serde::{Deserialize, Serialize};
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// Floors, sampling clock and slowest rate of the images.
const IMAGE_FLOORS: usize = 3;
const IMAGE_TIMER_HZ: f64 = 84e6;
const IMAGE_SLOWEST_HZ: f64 = 100.0;

/// Refuses a test that the image cannot run, before anything is built.
///
/// # Errors
/// What the test needs and the image does not have.
pub fn can_run(test: &TestFile) -> Result<(), Failure> {
    let config = &test.config;
    let floors = config.degrees_of_freedom();
    let actuators = config.physical_storeys().min(floors);
    let rate_hz = config.timing.rate_hz;
    let refuse = |what: String| Err(Failure::input(format!("--emulated: {what}")));
    if let Some(part) = &test.coupled {
        only_x_and_rotation(part)?;
    }
    let Some(image) = Image::of(test) else {
        let bits = match (actuators, test.board.converter_bits) {
            (3, Some(bits)) => format!(" and board.converter_bits = {bits}"),
            _ => String::new(),
        };
        return refuse(format!(
            "the test has {actuators} storeys in the laboratory, each with an actuator{bits}: accepted on the images for the NUCLEO-F429ZI are 1, and 3 with converters of 16 bits (structure.physical_storeys, board.converter_bits); the simulated rig runs any number without --emulated"
        ));
    };
    if floors > IMAGE_FLOORS {
        return refuse(format!(
            "the test has {floors} floors: accepted on the image for the NUCLEO-F429ZI are up to {IMAGE_FLOORS}"
        ));
    }
    let fastest_hz = f64::from(link::fastest_rate_hz(
        link::BAUD,
        image.actuators(),
        image.inputs(),
    ));
    let divides = (IMAGE_TIMER_HZ / rate_hz).fract() == 0.0;
    if !(divides && (IMAGE_SLOWEST_HZ..=fastest_hz).contains(&rate_hz)) {
        return refuse(format!(
            "loop.rate_hz = {rate_hz}: accepted on the image for the NUCLEO-F429ZI are whole divisors of 84 MHz from {IMAGE_SLOWEST_HZ} to {fastest_hz} Hz"
        ));
    }
    Ok(())
}

/// The rig file for the emulator.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EmulatedRig {
    /// The rig behind the converters.
    pub rig: RigSpec,
    /// Two coupled actuators in place of those of `rig`; they have its sensors.
    pub coupled: Option<CoupledLaboratory>,
    /// Stiffness of each storey that has an actuator, N/m.
    pub storey_n_per_m: Vec<f64>,
    /// Rate at which the rig is stepped, Hz: the control rate.
    pub rate_hz: f64,
    /// Seed of everything random in it.
    pub seed: u64,
    /// The ranges of the sensors and actuators, the same for all.
    pub calibration: Calibration,
    /// The image, and so the converters.
    pub image: Image,
    /// Runs by the wall clock, as a board would, and not as fast as possible.
    pub real_time: bool,
    /// Four wires on a desk in place of the rig: the command is both displacement and force.
    pub four_wires: bool,
    /// What is done to the board 600 control steps after PERMIT came, 0.3 s at 2 kHz.
    pub incident: Option<Incident>,
}

/// Two coupled actuators and what they hold.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CoupledLaboratory {
    /// The rig.
    pub rig: CoupledRigSpec,
    /// Where the actuators are attached to the coupler.
    pub coupler: CouplerSpec,
}

impl EmulatedRig {
    /// The laboratory of a test file that an image can run, see [`can_run`].
    pub fn of(test: &TestFile, seed: u64) -> Self {
        let config = &test.config;
        let image = Image::of(test).unwrap_or_default();
        let physical = config.physical_storeys().min(config.degrees_of_freedom());
        Self {
            rig: test.plant.clone(),
            coupled: test.coupled.as_ref().map(|part| CoupledLaboratory {
                rig: part.rig.clone(),
                coupler: part.declared.coupler.clone(),
            }),
            storey_n_per_m: config
                .structure
                .stiffness_n_per_m
                .iter()
                .copied()
                .take(physical)
                .collect(),
            rate_hz: config.timing.rate_hz,
            seed,
            calibration: Calibration::nominal(&image.codes()),
            image,
            real_time: false,
            four_wires: false,
            incident: None,
        }
    }

    /// A bare board with four wires, which runs `image` and undergoes `incident`.
    ///
    /// # Errors
    /// None, as long as the desk's test is valid.
    pub fn on_desk(image: Image, incident: Option<Incident>) -> Result<Self, Failure> {
        let laboratory = Self::of(&desk::experiment(1.0, 2000)?.test, 1);
        Ok(Self {
            calibration: desk::calibration(&image.codes()),
            image,
            four_wires: true,
            incident,
            ..laboratory
        })
    }

    /// With sensors and an actuator sized for a test with these limits: ranges of 1, 2 or 5 times a power of ten in which
    /// the limits can act and the noise at the plan's peaks reaches no rail.
    pub fn sized_for(mut self, limits: &Limits, plan: &PlannedMotion) -> Self {
        let of = |top: u16, spare: u16| 1.0 - 2.0 * f64::from(spare) / f64::from(top);
        let codes = &self.image.codes();
        let free = of(codes.sensor_top, codes.sensor_spare)
            .min(of(codes.command_top, codes.command_spare));
        let room = |limit: Option<f64>, peak: f64| (limit.unwrap_or(0.0) / free).max(peak);
        let (peak_m, peak_n) = plan.noisy_peaks();
        let stroke_m = size_above(room(limits.displacement_m, peak_m));
        let force_n = size_above(room(limits.force_n, peak_n));
        self.calibration = Calibration::over(stroke_m, force_n, codes);
        self
    }
}

impl EmulatedRig {
    /// By the wall clock.
    pub fn in_real_time(mut self, wanted: bool) -> Self {
        self.real_time = wanted;
        self
    }

    /// With sensors and an actuator of this range to either side, m.
    pub fn over(mut self, half_m: f32) -> Self {
        let codes = self.image.codes();
        let wide = Calibration::over(half_m, 1.0, &codes);
        self.calibration.displacement = wide.displacement;
        self.calibration.command = wide.command;
        self
    }
}

/// The next of 1, 2 and 5 times a power of ten from `least` up.
fn size_above(least: f64) -> f32 {
    let decade = 10_f64.powf(least.log10().floor());
    let sizes = [1.0, 2.0, 5.0, 10.0].map(|x| x * decade);
    sizes.into_iter().find(|s| *s >= least).unwrap_or(least) as f32
}

/// An emulated board at the other end of a port.
pub type Emulated = InTurns<Emulator>;

/// An emulator and its pipes.
pub struct Emulator {
    child: Child,
    to: ChildStdin,
    from: ChildStdout,
    _laboratory: tempfile::NamedTempFile,
}

impl Emulated {
    /// Builds the image and the emulator, and starts them with `laboratory` behind the converters.
    ///
    /// # Errors
    /// A checkout that cannot be found; a build that fails; an emulator that does not start.
    pub fn start(laboratory: &EmulatedRig) -> Result<Self, Failure> {
        Self::with(&built_emulator()?, laboratory)
    }

    /// The same with an emulator that is already built.
    ///
    /// # Errors
    /// As [`Emulated::start`].
    pub fn with(emulator: &Path, laboratory: &EmulatedRig) -> Result<Self, Failure> {
        let cannot = |what: &str, e: &dyn std::fmt::Display| {
            Failure::test(format!("--emulated: {what}: {e}"))
        };
        let file = tempfile::NamedTempFile::new().map_err(|e| cannot("a temporary file", &e))?;
        let text = toml::to_string(laboratory).map_err(|e| cannot("the rig", &e))?;
        std::fs::write(file.path(), text).map_err(|e| cannot("the rig", &e))?;
        let mut command = Command::new(emulator);
        // Ctrl-C in the terminal is for this program, which ends the test first.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command
            .arg(built_image(laboratory.image)?)
            .arg(file.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|e| cannot("the emulator does not start", &e))?;
        let (Some(to), Some(from)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(Failure::test("--emulated: the emulator has no pipes"));
        };
        Ok(Self::new(Emulator {
            child,
            to,
            from,
            _laboratory: file,
        }))
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // Its pipes are still open here, so it would not end by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Turns for Emulator {
    fn exchange(&mut self, bytes: &[u8]) -> io::Result<(u64, Vec<u8>)> {
        self.turn(bytes).map_err(|e| match e.kind() {
            ErrorKind::UnexpectedEof | ErrorKind::BrokenPipe => {
                io::Error::other("the emulator has ended")
            }
            _ => e,
        })
    }
}

impl Emulator {
    /// Lengths and bytes in the format of `emu`.
    fn turn(&mut self, bytes: &[u8]) -> io::Result<(u64, Vec<u8>)> {
        self.to.write_all(&(bytes.len() as u32).to_le_bytes())?;
        self.to.write_all(bytes)?;
        self.to.flush()?;
        let (mut at_ns, mut count) = ([0; 8], [0; 4]);
        self.from.read_exact(&mut at_ns)?;
        self.from.read_exact(&mut count)?;
        let mut came = vec![0; u32::from_le_bytes(count) as usize];
        self.from.read_exact(&mut came)?;
        Ok((u64::from_le_bytes(at_ns), came))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_those_that_are_sold() {
        let cases = [
            (0.03, 0.05),
            (0.05, 0.05),
            (0.0501, 0.1),
            (18_000.0, 20_000.0),
            (9e3, 1e4),
        ];
        for (least, size) in cases {
            assert!((size_above(least) / size - 1.0).abs() < 1e-6, "{least}");
        }
    }
}
