//! The flashed image on an emulated board: both are built, and the link runs over the emulator's pipes.

use super::port::Port;
use crate::failure::Failure;
use crate::files::test::TestFile;
use crate::trace::Response;
use link::channel::{Calibration, Line};
use link::{AdcCode, DacCode};
use plant::RigSpec;
use serde::{Deserialize, Serialize};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

/// How long a read waits for the first byte.
const WAIT: Duration = Duration::from_millis(5);

/// What the emulator is told on its command line's file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Laboratory {
    /// The rig behind the converters.
    pub rig: RigSpec,
    /// Stiffness of the structure's storeys with an actuator, N/m.
    pub storey_n_per_m: Vec<f64>,
    /// Rate at which the rig is stepped, Hz: the control rate.
    pub rate_hz: f64,
    /// Seed of everything random in it.
    pub seed: u64,
    /// The ranges of its sensors and of its actuator.
    pub calibration: Calibration,
}

/// Ranges of sensors and actuator over the peaks of the ideal test, at least: room for errors.
const ROOM: f64 = 1.5;

impl Laboratory {
    /// The laboratory of a test file.
    pub fn of(test: &TestFile, seed: u64) -> Self {
        let config = &test.config;
        let physical = config.physical_storeys().min(config.degrees_of_freedom());
        Self {
            rig: test.plant.clone(),
            storey_n_per_m: config
                .structure
                .stiffness_n_per_m
                .iter()
                .copied()
                .take(physical)
                .collect(),
            rate_hz: config.timing.rate_hz,
            seed,
            calibration: Calibration::UNCALIBRATED,
        }
    }

    /// With sensors and an actuator of the size that is right for a test whose floors move as in `ideal`: ranges of 1, 2
    /// or 5 times a power of ten that leave half as much again above its peaks. Forces are those of the elastic storeys.
    pub fn sized_for(mut self, ideal: &Response) -> Self {
        let peaks = ideal.peaks_m();
        let below = std::iter::once(&0.0).chain(&peaks);
        let (mut stroke_m, mut force_n) = (0.0_f64, 0.0_f64);
        for ((peak, below), k) in peaks.iter().zip(below).zip(&self.storey_n_per_m) {
            stroke_m = stroke_m.max(ROOM * peak);
            force_n = force_n.max(ROOM * k * (peak + below));
        }
        let (stroke_m, force_n) = (size_above(stroke_m), size_above(force_n));
        self.calibration = Calibration {
            displacement: Line::over(stroke_m, AdcCode::MAX),
            force: Line::over(force_n, AdcCode::MAX),
            command: Line::over(stroke_m, DacCode::MAX),
        };
        self
    }
}

/// The next of 1, 2 and 5 times a power of ten from `least` up.
fn size_above(least: f64) -> f32 {
    let decade = 10_f64.powf(least.log10().floor());
    let sizes = [1.0, 2.0, 5.0, 10.0].map(|x| x * decade);
    sizes.into_iter().find(|s| *s >= least).unwrap_or(least) as f32
}

/// An emulator and its pipes.
pub struct Emulated {
    child: Child,
    to: ChildStdin,
    from: Receiver<Vec<u8>>,
    _laboratory: tempfile::NamedTempFile,
}

impl Emulated {
    /// Builds the image and the emulator, and starts them with `laboratory` behind the converters.
    ///
    /// # Errors
    /// A checkout that cannot be found, or a build that fails: its last words.
    pub fn start(laboratory: &Laboratory) -> Result<Self, Failure> {
        Self::with(&build_emulator(&checkout()?)?, laboratory)
    }

    /// The same with an emulator that has been built.
    ///
    /// # Errors
    /// As [`Emulated::start`]; an emulator that does not start.
    pub fn with(emulator: &Path, laboratory: &Laboratory) -> Result<Self, Failure> {
        let cannot = |what: &str, e: &dyn std::fmt::Display| {
            Failure::test(format!("--emulated: {what}: {e}"))
        };
        let file = tempfile::NamedTempFile::new().map_err(|e| cannot("a temporary file", &e))?;
        let text = toml::to_string(laboratory).map_err(|e| cannot("the rig", &e))?;
        std::fs::write(file.path(), text).map_err(|e| cannot("the rig", &e))?;
        let mut child = Command::new(emulator)
            .arg(image()?)
            .arg(file.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|e| cannot("the emulator does not start", &e))?;
        let (Some(to), Some(out)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(Failure::test("--emulated: the emulator has no pipes"));
        };
        Ok(Self {
            child,
            to,
            from: listen(out),
            _laboratory: file,
        })
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        // It ends with its pipe; if it does not, it is ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Port for Emulated {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self.from.recv_timeout(WAIT) {
            Ok(came) => {
                let count = came.len().min(bytes.len());
                bytes[..count].copy_from_slice(&came[..count]);
                Ok(count)
            }
            Err(RecvTimeoutError::Timeout) => Ok(0),
            Err(RecvTimeoutError::Disconnected) => Err(io::Error::other("the emulator has ended")),
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.to.write_all(bytes)?;
        self.to.flush()
    }
}

/// Takes what the emulator says off its pipe, as it comes.
fn listen(mut out: impl Read + Send + 'static) -> Receiver<Vec<u8>> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        // No more than a reader of the port has room for.
        let mut bytes = [0; 1024];
        while let Ok(count @ 1..) = out.read(&mut bytes) {
            if sender.send(bytes[..count].to_vec()).is_err() {
                break;
            }
        }
    });
    receiver
}

/// The folder with `firmware` and `emu` in it: here or above.
fn checkout() -> Result<PathBuf, Failure> {
    let here = std::env::current_dir().unwrap_or_default();
    let is_root =
        |p: &&Path| p.join("emu/Cargo.toml").is_file() && p.join("scripts/cross").is_file();
    here.ancestors()
        .find(is_root)
        .or_else(|| Some(Path::new(env!("CARGO_MANIFEST_DIR")).parent()?).filter(is_root))
        .map(Path::to_path_buf)
        .ok_or_else(|| {
            Failure::input(format!(
                "--emulated: {} is in no checkout of this project: accepted is one, with its folders firmware and emu",
                here.display()
            ))
        })
}

/// The image as it is flashed: the one that OUTERLOOP_IMAGE names, else it is built.
fn image() -> Result<PathBuf, Failure> {
    if let Some(built) = std::env::var_os("OUTERLOOP_IMAGE") {
        return Ok(built.into());
    }
    let root = checkout()?;
    let target = target_folder(&root);
    let mut build = Command::new(root.join("scripts/cross"));
    build.args([
        "build",
        "-p",
        "firmware",
        "--bin",
        "nucleo_f429zi",
        "--release",
    ]);
    run(build.current_dir(&root).env("CARGO_TARGET_DIR", &target))?;
    Ok(target.join("cross/thumbv7em-none-eabihf/release/nucleo_f429zi"))
}

/// The emulator.
fn build_emulator(root: &Path) -> Result<PathBuf, Failure> {
    let target = target_folder(root).join("emu");
    let mut build = Command::new("cargo");
    // The emulator's crate asks for a newer compiler than it needs.
    build.args(["build", "--release", "--ignore-rust-version"]);
    run(build
        .current_dir(root.join("emu"))
        .env("CARGO_TARGET_DIR", &target))?;
    Ok(target.join("release/emu"))
}

fn target_folder(root: &Path) -> PathBuf {
    let named = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    root.join(named.unwrap_or_else(|| "target".into()))
}

fn run(build: &mut Command) -> Result<(), Failure> {
    eprintln!("outerloop: {}", shown(build));
    // Its own account goes to standard error: standard output belongs to the result.
    let out = build
        .stdout(Stdio::null())
        .status()
        .map_err(|e| Failure::test(format!("--emulated: {}: {e}", shown(build))))?;
    if out.success() {
        Ok(())
    } else {
        Err(Failure::test(format!(
            "--emulated: `{}` failed ({out}); scripts/setup installs what it needs",
            shown(build)
        )))
    }
}

fn shown(build: &Command) -> String {
    let words = std::iter::once(build.get_program()).chain(build.get_args());
    let words: Vec<_> = words.map(|w| w.to_string_lossy()).collect();
    words.join(" ")
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
