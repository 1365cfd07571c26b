//! A board's identity, status and calibration.

use crate::board::describe_words;
use crate::document::{Document, Grade};
use experiment::coupled::figures::axis_name;
use experiment::watch::{NamedCause, WatchEvent};
use link::reply::Identity;
use link::status::{Status, WatchStatus};
use link::{Calibration, CodeRange};
use outerloop_core::coupled::INTERFACE_AXIS;
use schemars::JsonSchema;
use serde::Serialize;

/// Its identity: firmware, clocks and capacities.
pub fn of_identity(identity: &Identity) -> Document {
    let mut d = Document::new("What a board is", "As it says itself.", true);
    let (version, mhz) = (&identity.version, f64::from(identity.clock_hz) / 1e6);
    let (hz, fastest_hz) = (identity.rate_hz, identity.fastest_rate_hz);
    let (floors, points) = (identity.max_dof, identity.max_points);
    d.say(format!(
        "{}: firmware {version} ({}), {mhz} MHz; control at {hz} Hz, at most {fastest_hz} Hz; a command leaves {} us after \
         its sample; {} actuators, at most {floors} floors and {points} points of ground motion.",
        identity.board,
        identity.commit,
        identity.output_delay_us,
        identity.actuators(),
    ));
    d
}

/// Its status, one sentence for each item.
pub fn of_status(identity: &Identity, status: &Status) -> Document {
    let lead = format!("{} with firmware {}.", identity.board, identity.version);
    let mut d = Document::new("How a board stands", lead, true);
    let us = |cycles: u32| f64::from(cycles) / f64::from(identity.clock_hz) * 1e6;
    let timing = status.timing;
    d.say(format!(
        "{}, PERMIT {}, {}, {}, {} points of ground motion loaded",
        status.mode.name(),
        if status.permit { "high" } else { "low" },
        if status.configured {
            "a test is accepted"
        } else {
            "no test is accepted"
        },
        if status.calibrated {
            format!("calibration {:08x}", identity.calibration_number())
        } else {
            "not calibrated".into()
        },
        status.points
    ));
    readings(&mut d, identity, status);
    d.say(format!(
        "control step {:.1} us at worst, {:.1} us on average of {:.1} us; period {} to {} cycles of {}; {} overruns",
        us(timing.worst_step_cycles),
        us(timing.mean_step_cycles),
        us(timing.period_cycles),
        timing.shortest_period_cycles,
        timing.longest_period_cycles,
        timing.period_cycles,
        timing.overruns
    ));
    d.say(format!(
        "stack {} bytes at most; {} frames received, {} spoilt; {} steps could not be sent",
        status.stack_bytes,
        status.link.good,
        status.link.bad(),
        status.dropped_steps
    ));
    let several = identity.actuators() > 1;
    if let Some(trip) = status.trip {
        let of = match trip.limited_axis() {
            Some(axis) if axis >= usize::from(INTERFACE_AXIS) => {
                let name = axis_name(trip.axis).unwrap_or("the interface");
                format!(" of {name}")
            }
            Some(axis) if several => format!(" of actuator {}", axis + 1),
            _ => String::new(),
        };
        let trip = format!(
            "tripped on {}{of} at control step {}: {} against a limit of {}; `outerloop board clear` clears it",
            trip.fault.name(),
            trip.tick,
            trip.value,
            trip.limit
        );
        d.verdict(Grade::Bad, trip);
    }
    if let Some(watch) = &status.watch {
        let (clock_hz, period) = (f64::from(identity.clock_hz), timing.period_cycles);
        let watched = describe_watch(watch, identity.actuators(), clock_hz, period);
        d.say(watched);
    }
    if !status.crystal_ok {
        let why = "the crystal has the wrong frequency: the board refuses to arm";
        d.verdict(Grade::Bad, why);
    }
    if !status.converters_ok {
        let why = "a converter outside the chip did not answer when the board started: the board refuses to arm";
        d.verdict(Grade::Bad, why);
    }
    if let Some(words) = describe_words(status.started, status.last_crash.as_ref()) {
        d.say(words);
    }
    d
}

/// The readings of each actuator's transducer and load cell.
fn readings(d: &mut Document, identity: &Identity, status: &Status) {
    let reading = |line: link::channel::ChannelCalibration, code: u16| {
        (f64::from(code) - f64::from(line.zero_code)) * f64::from(line.per_code)
    };
    let several = identity.actuators() > 1;
    let codes = std::iter::once(&status.codes).chain(&status.other_codes);
    let all = (1..).zip(identity.calibrations().zip(codes));
    for (actuator, (lines, &[displacement, force])) in all {
        let whose = match several {
            true => format!("actuator {actuator}: "),
            false => String::new(),
        };
        d.say(format!(
            "{whose}displacement {:.3} mm (code {displacement}), force {:.1} N (code {force})",
            reading(lines.displacement, displacement) * 1e3,
            reading(lines.force, force)
        ));
    }
}

/// What `board calibrate` answers in JSON.
#[derive(Serialize, JsonSchema)]
pub struct CalibrationAnswer {
    /// The actuator, from 1.
    pub actuator: u8,
    /// How many the board has.
    pub actuators: usize,
    /// Number of the calibration of all of them, as `board.calibration` of a test file requires it.
    pub number: String,
    /// Widths of the converters' codes.
    pub codes: CodeRange,
    /// The lines in force: quantity = per_code * (code - zero_code), in m and N.
    pub calibration: Calibration,
    /// The channels that were zeroed.
    pub zeroed: Vec<Zeroed>,
    /// What will happen to a calibration that was changed and not saved.
    pub not_kept: Option<&'static str>,
}

/// A channel that was zeroed.
#[derive(Serialize, JsonSchema)]
pub struct Zeroed {
    /// `displacement` or `force`.
    pub channel: &'static str,
    /// Mean of its codes.
    pub code: f32,
    /// The largest of them less the smallest.
    pub spread: u16,
    /// What that reads now, m or N.
    pub value: f32,
}

/// The calibration of one of its actuators; `file`: as a file has it. On a terminal everything else is a comment, so that the
/// output is such a file, too.
pub fn of_calibration(found: &CalibrationAnswer, file: &str) -> Document {
    let (number, actuator, of) = (&found.number, found.actuator, found.actuators);
    let lead = format!("Actuator {actuator} of {of}.");
    let mut d = Document::new("A board's calibration", lead, true);
    let zeroed = found.zeroed.iter().map(|zeroed| {
        let Zeroed {
            channel,
            code,
            spread,
            value,
        } = zeroed;
        format!("{channel}: code {code:.1} with a spread of {spread} is {value} now")
    });
    let several =
        (of > 1).then(|| format!("actuator {actuator} of {of}; the number is of all of them"));
    let lines = format!(
        "number {number}; quantity = per_code * (code - zero_code), in m and N; the sensors' codes are 0 to {}, the command's 0 to {}",
        found.codes.sensor_top, found.codes.command_top
    );
    for sentence in zeroed.chain(several).chain([lines]) {
        d.tell(format!("# {sentence}"));
        d.explain(sentence);
    }
    if let Some(said) = found.not_kept {
        d.on_page(|d| d.verdict(Grade::Fair, said));
    }
    d.heading("As `board calibrate --file` accepts it");
    d.file(file);
    d.on_terminal(|d| d.file(file));
    d
}

/// The rig watch's findings on a board with this many actuators, with their values and their time.
fn describe_watch(
    watch: &WatchStatus,
    actuators: usize,
    clock_hz: f64,
    period_cycles: u32,
) -> String {
    let us = |cycles: u32| f64::from(cycles) / clock_hz * 1e6;
    let since_s = f64::from(watch.since_step) * f64::from(period_cycles) / clock_hz;
    let named = |named: &link::status::NamedCause| {
        let actuator = (actuators > 1).then_some(usize::from(named.actuator));
        let corrected = f64::from(named.corrected);
        NamedCause {
            corrected: (corrected != 0.0).then_some(corrected),
            ..NamedCause::of(&named.finding(), actuator)
        }
    };
    let now = WatchEvent {
        t_s: since_s,
        state: watch.state.name(),
        set: watch.named.iter().map(named).collect(),
        corrected: watch.named.iter().any(|named| named.corrected != 0.0),
        held: watch.held,
    };
    format!(
        "the rig watch says {} ({} blocks judged, {:.0} us each at worst, {:.0} us on average)",
        now.in_words(),
        watch.blocks,
        us(watch.worst_cycles),
        us(watch.mean_cycles)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use outerloop_core::watch::{Cause, State};

    #[test]
    fn the_watch_is_told_with_values_intervals_and_since_when() {
        let named = |cause, value| link::status::NamedCause {
            actuator: 2,
            cause,
            value,
            sd: 0.1 * value,
            corrected: match cause {
                Cause::ActuatorLate => 11.5,
                _ => 0.0,
            },
        };
        let watch = WatchStatus {
            state: State::Named,
            since_step: 18_000,
            named: [
                named(Cause::ActuatorLate, 12.0),
                named(Cause::ForceGain, 0.05),
            ]
            .into_iter()
            .collect(),
            held: true,
            blocks: 5000,
            worst_cycles: 16_800,
            mean_cycles: 1680,
        };
        assert_eq!(
            describe_watch(&watch, 3, 168e6, 84_000),
            "the rig watch says named since 9.00 s: delay_error of the actuator 2 (12.0 ms, 10.0 to 14.0), or gain_error of the load \
             cell 2 (0.0500, 0.0418 to 0.0582); delay_error is corrected for by 11.5 ms; what the compensation learns is held at what \
             was declared (5000 blocks judged, 100 us each at worst, 10 us on average)"
        );
    }

    #[test]
    fn a_calibration_is_printed_as_a_file_and_the_page_has_it_with_what_was_done() {
        let codes = CodeRange {
            sensor_top: 8190,
            sensor_rail: 16,
            sensor_spare: 80,
            command_top: 4095,
            command_spare: 40,
        };
        let calibration = Calibration::nominal(&codes);
        let found = CalibrationAnswer {
            actuator: 2,
            actuators: 3,
            number: "00c0ffee".into(),
            codes,
            calibration,
            zeroed: vec![Zeroed {
                channel: "force",
                code: 4101.5,
                spread: 3,
                value: -250.0,
            }],
            not_kept: Some("the next reset takes it back"),
        };
        let document = of_calibration(&found, &toml::to_string(&calibration).unwrap());
        let printed = document.terminal();
        let read: Calibration = toml::from_str(&printed).unwrap();
        assert_eq!(read, calibration, "{printed}");
        let page = document.page();
        for words in [
            "force: code 4101.5 with a spread of 3 is -250 now",
            "actuator 2 of 3; the number is of all of them",
            "number 00c0ffee; quantity",
            "codes are 0 to 8190, the command's 0 to 4095",
        ] {
            assert!(printed.contains(words), "{words}: {printed}");
            assert!(
                page.replace("&#39;", "'").contains(words),
                "{words}: {page}"
            );
        }
        assert!(page.contains("the next reset takes it back"), "{page}");
        assert!(page.contains("[displacement]"), "{page}");
    }
}
