//! A board before a test: idle, calibrated as the test requires, with limits that can act.

use super::connection::Connection;
use super::image::{Image, converter_bits};
use super::limits::{self, PlannedMotion};
use super::orders::{clear, identify, status};
use super::port::Port;
use super::wording::describe_words;
use experiment::failure::Failure;
use link::limits::CalibratedRange;
use link::reply::Identity;
use outerloop_core::{Config, Mode};

/// The board's identity, and `config` with all limits that it requires. `hold`: how the test's actuators hold the
/// structure; `wanted`: the number that its calibration must have, eight hexadecimal digits, and the resolution of its
/// converters.
///
/// # Errors
/// A board that is silent, not idle or not calibrated as wanted; limits that cannot act on it.
pub(crate) fn ready<P: Port>(
    board: &mut Connection<P>,
    (config, hold): (&Config, Hold),
    plan: &PlannedMotion,
    wanted: (Option<&str>, Option<u16>),
) -> Result<(Identity, Config), Failure> {
    let identity = identify(board)?;
    make_idle(board)?;
    check_board(wanted, &identity)?;
    let actuators = match hold {
        Hold::Storeys => check_actuators(config, &identity)?,
        Hold::Coupler => check_coupled(&identity)?,
    };
    let config = with_limits(config, plan, (&identity, actuators))?;
    Ok((identity, config))
}

/// What a test's actuators hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hold {
    /// Each actuator holds a storey of its own.
    Storeys,
    /// Two actuators hold a coupler.
    Coupler,
}

/// Makes a finished board idle, and refuses one that is neither idle nor finished.
fn make_idle<P: Port>(board: &mut Connection<P>) -> Result<(), Failure> {
    let now = status(board)?;
    if let Some(said) = describe_words(now.started, now.last_crash.as_ref()) {
        eprintln!("outerloop: note: {said}");
    }
    match (now.mode, now.trip) {
        (Mode::Idle, _) => Ok(()),
        (Mode::Finished, _) => clear(board),
        (Mode::Tripped, Some(trip)) => Err(Failure::test(format!(
            "the board stands tripped on {}: accepted is an idle board; look, then `outerloop board clear`",
            trip.fault.name()
        ))),
        (mode, _) => Err(Failure::test(format!(
            "the board is {}: accepted is an idle board",
            mode.name()
        ))),
    }
}

/// Checks that the board's converters and calibration are those that the test names.
fn check_board(
    (calibration, bits): (Option<&str>, Option<u16>),
    identity: &Identity,
) -> Result<(), Failure> {
    let own = converter_bits(&identity.codes);
    if let Some(wanted) = bits.filter(|b| u32::from(*b) != own) {
        return Err(Failure::input(format!(
            "board.converter_bits = {wanted}: the board's converters have {own} bits: accepted is the image for the converters that the test asks for ({} or {} for 16 bits)",
            Image::External.name(),
            Image::Three.name()
        )));
    }
    let number = format!("{:08x}", identity.calibration_number());
    match calibration {
        Some(wanted) if !wanted.eq_ignore_ascii_case(&number) => Err(Failure::input(format!(
            "board.calibration = \"{wanted}\": the board's calibration has the number {number}: accepted is the board as it was calibrated for this test; `outerloop board calibrate` shows its lines"
        ))),
        _ => Ok(()),
    }
}

/// Checks that the board has one actuator for each storey in the laboratory, and no other; gives their number.
fn check_actuators(config: &Config, identity: &Identity) -> Result<usize, Failure> {
    let storeys = config.physical_storeys().min(config.degrees_of_freedom());
    let own = identity.actuators();
    if storeys == own {
        return Ok(own);
    }
    Err(Failure::input(format!(
        "the test has {storeys} storeys in the laboratory, each with an actuator, and the board has {own}: accepted is a test with as many (structure.physical_storeys), or the image with as many actuators ({} for 3)",
        Image::Three.name()
    )))
}

/// Checks that the board can run the loop of two coupled actuators; gives their number.
fn check_coupled(identity: &Identity) -> Result<usize, Failure> {
    if identity.actuators() == Image::Three.actuators() {
        return Ok(2);
    }
    Err(Failure::input(format!(
        "the test has two coupled actuators, [coupled], and the board has {}: accepted is the image {}, whose first two they are",
        identity.actuators(),
        Image::Three.name()
    )))
}

/// The configuration with all limits that the board requires for its first actuators; the person is shown those that were
/// computed.
fn with_limits(
    config: &Config,
    plan: &PlannedMotion,
    (identity, actuators): (&Identity, usize),
) -> Result<Config, Failure> {
    let used = identity.calibrations().take(actuators);
    let shown = CalibratedRange::by_all(used, &identity.codes);
    let mut limited = config.clone();
    limited.limits = plan.limits(&config.limits, &shown);
    if limited.limits != config.limits {
        eprintln!(
            "outerloop: limits in force:\n{}",
            limits::describe(&config.limits, &limited.limits)
        );
    }
    shown.check(&limited).map_err(|refusal| {
        let value = match refusal.value {
            value if value.is_nan() => String::new(),
            value => format!(" = {value:.4}"),
        };
        Failure::input(format!(
            "{}{value} cannot act on this board: accepted is {}; it shows +-{:.1} mm and +-{:.2} kN with the spare codes left free",
            refusal.name,
            refusal.accepted,
            shown.displacement_m * 1e3,
            shown.force_n * 1e-3
        ))
    })?;
    Ok(limited)
}
