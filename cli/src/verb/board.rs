//! `outerloop board`: what a person asks of a board at a serial port.

use super::json;
use super::place::Place;
use crate::board::{self, Connection, Course, Patience, Serial};
use crate::failure::Failure;
use crate::files::output;
use crate::files::signal::Signal;
use crate::files::test::TestFile;
use crate::provenance::Told;
use crate::scope::Scoped;
use clap::{Args, Subcommand};
use link::Calibration;
use link::command::{Channel, Shape};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Orders to a board at a serial port
#[derive(Args, Debug)]
pub struct Board {
    #[command(subcommand)]
    order: Order,
}

#[derive(Subcommand, Debug)]
enum Order {
    /// Who the board is: firmware, clocks, limits
    Identify(Plain),
    /// How it is: state, readings, times, the reason of a trip or a crash
    Status(Plain),
    Calibrate(Calibrate),
    Commission(Commission),
    /// Clear the end of a test or a fault
    Clear(Plain),
}

impl Board {
    /// Carries the order out.
    ///
    /// # Errors
    /// A port that cannot be opened; a board that is silent, of another version, or refuses.
    pub fn go(&self) -> Result<(), Failure> {
        match &self.order {
            Order::Identify(order) => order.identify(),
            Order::Status(order) => order.status(),
            Order::Calibrate(order) => order.go(),
            Order::Commission(order) => order.go(),
            Order::Clear(order) => order.clear(),
        }
    }
}

/// An order that needs nothing but the board
#[derive(Args, Debug)]
struct Plain {
    /// The board's serial port, e.g. /dev/ttyACM0
    #[arg(long, value_name = "DEV")]
    port: String,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

fn connect(device: &str) -> Result<Connection<Serial>, Failure> {
    Ok(Connection::new(Serial::open(device)?, Patience::BOARD))
}

impl Plain {
    fn identify(&self) -> Result<(), Failure> {
        let identity = board::identify(&mut connect(&self.port)?)?;
        if self.json {
            println!("{}", json(&Told::of(&identity))?);
            return Ok(());
        }
        println!(
            "{}: firmware {} ({}), {} MHz; control at {} Hz, at most {} Hz; a command leaves {} us after its sample; \
             {} actuators, at most {} floors and {} points of ground motion.",
            identity.board,
            identity.version,
            identity.commit,
            f64::from(identity.clock_hz) / 1e6,
            identity.rate_hz,
            identity.fastest_rate_hz,
            identity.output_delay_us,
            identity.actuators(),
            identity.max_dof,
            identity.max_points
        );
        Ok(())
    }

    fn status(&self) -> Result<(), Failure> {
        let connection = &mut connect(&self.port)?;
        let identity = board::identify(connection)?;
        let status = board::status(connection)?;
        if self.json {
            println!("{}", json(&Told::of(&status))?);
            return Ok(());
        }
        println!("{}", board::describe(&identity, &status));
        Ok(())
    }

    fn clear(&self) -> Result<(), Failure> {
        board::clear(&mut connect(&self.port)?)?;
        if self.json {
            println!("{}", json(&Told::of(&serde_json::Map::new()))?);
        } else {
            println!("The board is idle.");
        }
        Ok(())
    }
}

/// Shows the calibration, or exchanges it
#[derive(Args, Debug)]
struct Calibrate {
    /// The board's serial port, e.g. /dev/ttyACM0
    #[arg(long, value_name = "DEV")]
    port: String,
    /// Of which actuator, of a board with several, from 1
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=link::MAX_ACTUATORS as i64))]
    actuator: u8,
    /// The calibration to send, TOML as this command shows it
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// Make the present reading this value, m or N, e.g. displacement=0 or force=0
    #[arg(long, value_name = "CHANNEL=VALUE")]
    zero: Vec<Zero>,
    /// Keep the calibration, and the test if there is one, across power-off
    #[arg(long)]
    save: bool,
}

/// A channel and what it reads now.
#[derive(Clone, Copy, Debug)]
struct Zero {
    channel: Channel,
    value: f32,
}

impl FromStr for Zero {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let accepted = || {
            format!(
                "`{text}`: accepted are displacement=VALUE and force=VALUE with a value in m or N"
            )
        };
        let (channel, value) = text.split_once('=').ok_or_else(accepted)?;
        let channel = match channel {
            "displacement" => Channel::Displacement,
            "force" => Channel::Force,
            _ => return Err(accepted()),
        };
        let value: f32 = value.parse().map_err(|_| accepted())?;
        value
            .is_finite()
            .then_some(Self { channel, value })
            .ok_or_else(accepted)
    }
}

impl Calibrate {
    fn go(&self) -> Result<(), Failure> {
        let board = &mut connect(&self.port)?;
        let actuators = board::identify(board)?.actuators();
        let actuator = self.actuator - 1;
        if usize::from(actuator) >= actuators {
            return Err(Failure::input(format!(
                "--actuator {}: the board has {actuators}: accepted are 1 to {actuators}",
                self.actuator
            )));
        }
        if let Some(path) = &self.file {
            board::calibrate_one(board, actuator, read_calibration(path)?)?;
        }
        for zero in &self.zero {
            let (code, spread) = board::zero(board, actuator, zero.channel, zero.value)?;
            println!(
                "# {:?}: code {code:.1} with a spread of {spread} is {} now",
                zero.channel, zero.value
            );
        }
        if self.save {
            board::save(board)?;
        }
        let identity = board::identify(board)?;
        let calibration = identity.calibrations().nth(usize::from(actuator));
        let text = toml::to_string(&calibration)
            .map_err(|e| Failure::test(format!("the calibration cannot be shown: {e}")))?;
        if actuators > 1 {
            println!(
                "# actuator {} of {actuators}; the number is of all of them",
                self.actuator
            );
        }
        println!(
            "# number {:08x}; quantity = per_code * (code - zero_code), in m and N; the sensors' codes are 0 to {}, the command's 0 to {}",
            identity.calibration_number(),
            identity.codes.sensor_top,
            identity.codes.command_top
        );
        print!("{text}");
        Ok(())
    }
}

fn read_calibration(path: &Path) -> Result<Calibration, Failure> {
    let text = std::fs::read_to_string(path).map_err(|e| {
        Failure::input(format!(
            "{}: cannot be read ({e}): accepted is a calibration as `outerloop board calibrate` shows it",
            path.display()
        ))
    })?;
    toml::from_str(&text).map_err(|e| {
        Failure::input(format!(
            "{}: {}: accepted is a calibration as `outerloop board calibrate` shows it",
            path.display(),
            e.message()
        ))
    })
}

/// Moves the actuator by a signal and records it
#[derive(Args, Debug)]
struct Commission {
    /// The test file, whose limits are in force
    test: PathBuf,
    /// The board's serial port, e.g. /dev/ttyACM0
    #[arg(
        long,
        value_name = "DEV",
        required_unless_present = "emulated",
        conflicts_with = "emulated"
    )]
    port: Option<String>,
    /// On an emulated board, with the test's simulated rig behind its converters
    #[arg(long)]
    emulated: bool,
    /// Ask nobody between the approach and the start
    #[arg(long, conflicts_with = "emulated")]
    yes: bool,
    /// Seed of everything random in that rig
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Shape of the signal, constant, sine or chirp; or a file with time_s and command_mm, such as `diagnose --next` writes,
    /// which has its own amplitude, length and frequencies
    #[arg(long, value_name = "SHAPE|FILE", default_value = "chirp")]
    signal: Wanted,
    /// Largest displacement, mm
    #[arg(long, value_name = "MM", default_value_t = 5.0)]
    amplitude_mm: f32,
    /// Length, s, rise and fall of half a second included
    #[arg(long, value_name = "S", default_value_t = 30.0)]
    seconds: f32,
    /// Frequency of the sine, or at the start of the chirp, Hz
    #[arg(long, value_name = "HZ", default_value_t = 0.1)]
    from_hz: f32,
    /// Frequency at the end of the chirp, Hz
    #[arg(long, value_name = "HZ", default_value_t = 10.0)]
    to_hz: f32,
    /// The recording, CSV; `outerloop identify` reads it
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    scope: Scoped,
}

/// A shape that the board makes by itself, or a file.
#[derive(Clone, Debug)]
enum Wanted {
    Constant,
    Sine,
    Chirp,
    File(PathBuf),
}

impl FromStr for Wanted {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        Ok(match text {
            "constant" => Self::Constant,
            "sine" => Self::Sine,
            "chirp" => Self::Chirp,
            file if Path::new(file).exists() => Self::File(file.into()),
            other => {
                return Err(format!(
                    "`{other}` is no shape and no file: accepted are constant, sine, chirp, and a file with time_s and \
                     command_mm"
                ));
            }
        })
    }
}

impl Commission {
    fn course(&self) -> Result<Course, Failure> {
        let shape = match &self.signal {
            Wanted::File(path) => return Signal::load(path).map(Course::Points),
            Wanted::Constant => Shape::Constant,
            Wanted::Sine => Shape::Sine {
                frequency_hz: self.from_hz,
            },
            Wanted::Chirp => Shape::Chirp {
                from_hz: self.from_hz,
                to_hz: self.to_hz,
            },
        };
        Ok(Course::Formula(link::command::Signal {
            shape,
            amplitude_m: self.amplitude_mm / 1e3,
            seconds: self.seconds,
        }))
    }

    fn go(&self) -> Result<(), Failure> {
        let test = TestFile::load(&self.test, &[])?;
        let course = self.course()?;
        let place = Place::on_board(self.port.clone(), self.yes);
        let title = match &self.signal {
            Wanted::File(path) => format!("{} under {}", path.display(), self.test.display()),
            shape => format!("{shape:?} under {}", self.test.display()),
        };
        let rate_hz = test.config.timing.rate_hz;
        let mut scope = self.scope.open(&title, rate_hz, false)?;
        let played = place.play_course(&test, &course, self.seed, &mut scope)?;
        output::write(&self.out, &played.text)?;
        println!("{} steps are in {}.", played.steps, self.out.display());
        played.early.map_or(Ok(()), |why| {
            Err(Failure::test(format!(
                "the signal ended early: {why}; what was received is kept"
            )))
        })
    }
}
