//! What a board says, in words.

use experiment::coupled::figures::axis_name;
use experiment::watch::{NamedCause, WatchEvent};
use link::reply::Identity;
use link::status::{CrashCause, CrashReport, StartCause, Status, WatchStatus};
use outerloop_core::coupled::INTERFACE_AXIS;

/// Why the board last started, where nobody had asked for it.
pub fn describe_words(started: StartCause, words: Option<&CrashReport>) -> Option<String> {
    let Some(words) = words else {
        return (started == StartCause::Watchdog)
            .then(|| "the watchdog reset the board, and no word is left of why".into());
    };
    let cause = match words.cause {
        CrashCause::Panic => "panicked",
        CrashCause::HardFault => "took a hard fault",
        CrashCause::StackOverflow => "ran out of stack",
        CrashCause::Starved => "was reset because a task starved",
        CrashCause::ClockStopped => "lost its clock",
        CrashCause::LowSupply => "lost its supply",
        CrashCause::PermitStays => "was reset because its PERMIT line did not follow",
        CrashCause::Silent => "was reset because its control interrupt had stopped",
    };
    Some(format!(
        "the board {cause} at control step {} while {}: {}",
        words.tick,
        words.mode.name(),
        words.text
    ))
}

/// Why the board last started.
pub fn describe_start(status: &Status) -> String {
    let words = describe_words(status.started, status.last_crash.as_ref());
    words.unwrap_or_else(|| {
        let why = match status.started {
            StartCause::Power => "its power had been away",
            StartCause::BrownOut => "its supply had been too low",
            StartCause::Pin => "its reset pin was pulled",
            StartCause::Software | StartCause::Watchdog => "its program asked for it",
        };
        why.into()
    })
}

/// Everything that is worth watching, a line each.
pub fn describe(identity: &Identity, status: &Status) -> String {
    let us = |cycles: u32| f64::from(cycles) / f64::from(identity.clock_hz) * 1e6;
    let timing = status.timing;
    let mut lines = vec![
        format!(
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
        ),
        format!(
            "control step {:.1} us at worst, {:.1} us on average of {:.1} us; period {} to {} cycles of {}; {} overruns",
            us(timing.worst_step_cycles),
            us(timing.mean_step_cycles),
            us(timing.period_cycles),
            timing.shortest_period_cycles,
            timing.longest_period_cycles,
            timing.period_cycles,
            timing.overruns
        ),
        format!(
            "stack {} bytes at most; {} frames received, {} spoilt; {} steps could not be sent",
            status.stack_bytes,
            status.link.good,
            status.link.bad(),
            status.dropped_steps
        ),
    ];
    let several = identity.actuators() > 1;
    lines.splice(1..1, describe_readings(identity, status));
    if let Some(trip) = status.trip {
        let of = match trip.limited_axis() {
            Some(axis) if axis >= usize::from(INTERFACE_AXIS) => {
                let name = axis_name(trip.axis).unwrap_or("the interface");
                format!(" of {name}")
            }
            Some(axis) if several => format!(" of actuator {}", axis + 1),
            _ => String::new(),
        };
        lines.push(format!(
            "tripped on {}{of} at control step {}: {} against a limit of {}; `outerloop board clear` clears it",
            trip.fault.name(),
            trip.tick,
            trip.value,
            trip.limit
        ));
    }
    if let Some(watch) = &status.watch {
        let (clock_hz, period) = (f64::from(identity.clock_hz), timing.period_cycles);
        lines.push(describe_watch(
            watch,
            identity.actuators(),
            clock_hz,
            period,
        ));
    }
    if !status.crystal_ok {
        lines.push("the crystal has the wrong frequency: the board refuses to arm".into());
    }
    if !status.converters_ok {
        lines.push(
            "a converter outside the chip did not answer when the board started: the board refuses to arm".into(),
        );
    }
    lines.extend(describe_words(status.started, status.last_crash.as_ref()));
    lines.join("\n")
}

/// What each actuator's transducer and load cell read.
fn describe_readings(identity: &Identity, status: &Status) -> Vec<String> {
    let reading = |line: link::channel::ChannelCalibration, code: u16| {
        (f64::from(code) - f64::from(line.zero_code)) * f64::from(line.per_code)
    };
    let several = identity.actuators() > 1;
    let codes = std::iter::once(&status.codes).chain(&status.other_codes);
    let readings = (1..).zip(identity.calibrations().zip(codes)).map(
        |(actuator, (lines, &[displacement, force]))| {
            let whose = if several {
                format!("actuator {actuator}: ")
            } else {
                String::new()
            };
            format!(
                "{whose}displacement {:.3} mm (code {displacement}), force {:.1} N (code {force})",
                reading(lines.displacement, displacement) * 1e3,
                reading(lines.force, force)
            )
        },
    );
    readings.collect()
}

/// What the rig watch says on a board of so many actuators, of which values, and since when.
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
}
