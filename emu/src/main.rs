//! `emu IMAGE LABORATORY`: the image on an emulated board, the serial port on standard input and output.

use clap::Parser;
use emu::nucleo::{Nucleo, RIGHT_CRYSTAL_HZ, USUAL_LSI_HZ};
use emu::{AnyRig, Converters, Firmware, InjectedFault, Laboratory, PlannedFault, Wire};
use link::Calibration;
use plant::coupled::{CoupledRig, CoupledRigSpec, CouplerSpec};
use plant::{Rig, RigSpec};
use serde::Deserialize;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// The flashed image on an emulated board
#[derive(Parser, Debug)]
#[command(version, about)]
struct Arguments {
    /// The image as it is flashed, an ELF file
    image: PathBuf,
    /// The rig behind the converters, a TOML file; `outerloop run --emulated` writes it
    laboratory: PathBuf,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct EmulatedRig {
    rig: RigSpec,
    coupled: Option<CoupledLaboratory>,
    storey_n_per_m: Vec<f64>,
    rate_hz: f64,
    seed: u64,
    calibration: Calibration,
    image: Converters,
    /// Runs by the wall clock.
    #[serde(default)]
    real_time: bool,
    /// Four wires in place of the rig.
    #[serde(default)]
    four_wires: bool,
    incident: Option<Incident>,
}

/// Two coupled actuators, with the sensors of the rig.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CoupledLaboratory {
    rig: CoupledRigSpec,
    coupler: CouplerSpec,
}

/// A fault of the board.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Incident {
    Drill(u32),
    Reset,
}

impl From<Incident> for PlannedFault {
    fn from(incident: Incident) -> Self {
        Self {
            after_steps: 600,
            fault: match incident {
                Incident::Drill(number) => InjectedFault::Drill(number),
                Incident::Reset => InjectedFault::Reset,
            },
        }
    }
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(sentence) => {
            eprintln!("emu: {sentence}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let firmware = Firmware::read(&arguments.image)?;
    let file = &arguments.laboratory;
    let text = std::fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))?;
    let room: EmulatedRig =
        toml::from_str(&text).map_err(|e| format!("{}: {e}", file.display()))?;
    let (sensors, rate_hz, seed) = (&room.rig.sensors, room.rate_hz, room.seed);
    let rig = match &room.coupled {
        None => Rig::new(&room.rig, &room.storey_n_per_m, rate_hz, seed).map(AnyRig::from),
        Some(own) => {
            CoupledRig::new(&own.rig, &own.coupler, sensors, rate_hz, seed).map(AnyRig::from)
        }
    };
    let rig = rig.map_err(|e| e.to_string())?;
    let wire = Wire::default();
    connect(&wire);
    let laboratory = Laboratory::new(wire.clone(), rig, firmware.symbol("DRILL")?)
        .with_converters(room.image)
        .wired(room.calibration)
        .with_plan(room.incident.map(Into::into))
        .on_four_wires(room.four_wires)
        .in_real_time(room.real_time);
    let board = Nucleo::new(RIGHT_CRYSTAL_HZ, USUAL_LSI_HZ, wire.clone())
        .map_err(|e| e.to_string())?
        .with_converters(room.image);
    let ended = emu::run(board, &firmware.images, laboratory);
    wire.close();
    ended
}

/// Standard input and output are the serial line, in turns: the PC sends its count of bytes (four, little-endian) and the
/// bytes; the board sends its time in nanoseconds (eight), its count and the bytes.
fn connect(wire: &Wire) {
    let wire = wire.clone();
    std::thread::spawn(move || {
        let _ = take_turns(&wire);
        wire.close();
    });
}

/// Until the PC or the board ends.
fn take_turns(wire: &Wire) -> std::io::Result<()> {
    let (mut from, mut to) = (std::io::stdin().lock(), std::io::stdout().lock());
    loop {
        let mut count = [0; 4];
        from.read_exact(&mut count)?;
        let mut bytes = vec![0; u32::from_le_bytes(count) as usize];
        from.read_exact(&mut bytes)?;
        let Some((at_ns, came)) = wire.exchange(&bytes) else {
            return Ok(());
        };
        to.write_all(&at_ns.to_le_bytes())?;
        to.write_all(&(came.len() as u32).to_le_bytes())?;
        to.write_all(&came)?;
        to.flush()?;
    }
}
