//! What goes wrong in mid-test, and what it may be called.

use super::draw::Draw;
use super::rig::DrawnRig;
use serde::Serialize;

/// A cause: name and side.
pub(super) type Name = (&'static str, &'static str);

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The actuator is later.
    ActuatorLate,
    /// It goes too far, or not far enough.
    ActuatorGain,
    /// The displacement transducer reads a share more or less.
    DisplacementGain,
    /// Its zero moves.
    DisplacementOffset,
    /// It reads late.
    DisplacementLate,
    /// The load cell reads a share more or less.
    ForceGain,
    /// It reads late.
    ForceLate,
    /// The stroke ends.
    StrokeLimit,
    /// The actuator gets no faster.
    RateLimit,
    /// A reading stands, with its noise.
    Frozen,
    /// Play between actuator and specimen.
    Play,
    /// Mass on the load cell.
    Mass,
    /// The specimen breaks.
    Break,
}

impl Kind {
    /// All of them; the first is drawn twice as often.
    pub const ALL: [Self; 13] = [
        Self::ActuatorLate,
        Self::ActuatorGain,
        Self::DisplacementGain,
        Self::DisplacementOffset,
        Self::DisplacementLate,
        Self::ForceGain,
        Self::ForceLate,
        Self::StrokeLimit,
        Self::RateLimit,
        Self::Frozen,
        Self::Play,
        Self::Mass,
        Self::Break,
    ];

    /// In tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ActuatorLate => "actuator late",
            Self::ActuatorGain => "actuator gain",
            Self::DisplacementGain => "LVDT gain",
            Self::DisplacementOffset => "LVDT offset",
            Self::DisplacementLate => "LVDT late",
            Self::ForceGain => "load cell gain",
            Self::ForceLate => "load cell late",
            Self::StrokeLimit => "stroke limit",
            Self::RateLimit => "rate limit",
            Self::Frozen => "frozen with noise",
            Self::Play => "play",
            Self::Mass => "mass on the load cell",
            Self::Break => "specimen breaks",
        }
    }

    /// The displacement transducer lies.
    pub(super) const fn lies(self) -> bool {
        matches!(
            self,
            Self::DisplacementGain | Self::DisplacementOffset | Self::DisplacementLate
        )
    }
}

/// An effect that begins in mid-test.
pub(super) struct DrawnEffect {
    pub(super) kind: Kind,
    /// Its table.
    pub(super) text: String,
    /// When, s of the model.
    pub(super) from_s: f64,
    /// The names that are right.
    pub(super) right: Vec<Name>,
}

impl DrawnEffect {
    pub(super) fn new(rig: &DrawnRig, draw: &mut Draw) -> Self {
        let from_s = draw.between(0.25, 0.5) * rig.seconds;
        let at = draw.between(-1.0, 13.0).max(0.0) as usize;
        let kind = Kind::ALL[at.min(12)];
        let (body, right) = match kind {
            Kind::ActuatorLate | Kind::ActuatorGain | Kind::StrokeLimit | Kind::RateLimit => {
                of_the_actuator(kind, rig, draw)
            }
            Kind::Frozen
            | Kind::DisplacementGain
            | Kind::DisplacementOffset
            | Kind::DisplacementLate
            | Kind::ForceGain
            | Kind::ForceLate => of_a_sensor(kind, rig, draw),
            Kind::Play | Kind::Mass | Kind::Break => of_the_specimen(kind, rig, draw),
        };
        // Of two actuators it is the lower one's.
        let axis = if rig.storeys > 1 { "axis = 1\n" } else { "" };
        Self {
            kind,
            text: format!("[[plant.effects]]\nfrom_s = {from_s}\n{axis}{body}\n"),
            from_s,
            right,
        }
    }
}

fn of_the_actuator(kind: Kind, rig: &DrawnRig, draw: &mut Draw) -> (String, Vec<Name>) {
    let sign = draw.sign();
    let limit = draw.between(0.3, 0.7) * rig.peak_mm;
    match kind {
        Kind::ActuatorLate => {
            let more_ms = draw.ratio(3.0, 20.0).min(120.0 / rig.omega);
            (
                format!("name = 'delay_error'\ndelay_ms = {more_ms}"),
                vec![("delay_error", "actuator")],
            )
        }
        Kind::ActuatorGain => {
            let error = sign * draw.between(0.02, 0.1);
            (
                format!("name = 'gain_error'\nchannel = 'actuator'\nerror = {error}"),
                vec![("gain_error", "actuator")],
            )
        }
        Kind::StrokeLimit => (
            format!("name = 'saturation'\nchannel = 'actuator'\nlimit_mm = {limit}"),
            vec![("saturation", "actuator")],
        ),
        _ => (
            format!("name = 'rate_limit'\nrate_mm_per_s = {}", limit * rig.omega),
            vec![("rate_limit", "actuator")],
        ),
    }
}

fn of_a_sensor(kind: Kind, rig: &DrawnRig, draw: &mut Draw) -> (String, Vec<Name>) {
    let sign = draw.sign();
    let late_ms = draw.ratio(3.0, 10.0);
    match kind {
        Kind::DisplacementGain => {
            let error = sign * draw.between(0.02, 0.1);
            (
                format!("name = 'gain_error'\nsensor = 'displacement'\nerror = {error}"),
                vec![("gain_error", "displacement")],
            )
        }
        Kind::DisplacementOffset => {
            let offset = sign * draw.between(0.02, 0.06) * rig.peak_mm;
            (
                format!("name = 'offset'\nsensor = 'displacement'\noffset_mm = {offset}"),
                vec![("offset", "displacement")],
            )
        }
        // Command to displacement alone does not tell it from an actuator that is late.
        Kind::DisplacementLate => (
            format!("name = 'channel_skew'\nskew_ms = {}", -late_ms),
            vec![
                ("channel_skew", "displacement"),
                ("delay_error", "actuator"),
            ],
        ),
        Kind::ForceGain => {
            let error = sign * draw.between(0.05, 0.2);
            (
                format!("name = 'gain_error'\nsensor = 'force'\nerror = {error}"),
                vec![("gain_error", "force")],
            )
        }
        Kind::ForceLate => (
            format!("name = 'channel_skew'\nskew_ms = {late_ms}"),
            vec![("channel_skew", "force")],
        ),
        _ => {
            let sensor = if sign > 0.0 { "force" } else { "displacement" };
            (
                format!("sensor = '{sensor}'\nfrozen = true"),
                vec![("frozen_sensor", sensor)],
            )
        }
    }
}

fn of_the_specimen(kind: Kind, rig: &DrawnRig, draw: &mut Draw) -> (String, Vec<Name>) {
    match kind {
        Kind::Play => {
            let width = draw.between(0.02, 0.06) * rig.peak_mm;
            (
                format!("name = 'dead_band'\nchannel = 'specimen'\nwidth_mm = {width}"),
                vec![("dead_band", "specimen")],
            )
        }
        Kind::Mass => {
            let mass = draw.between(0.02, 0.1) * rig.mass_kg;
            (
                format!("name = 'inertia_force'\nmass_kg = {mass}"),
                vec![("inertia_force", "force")],
            )
        }
        _ => {
            let lost = draw.between(0.15, 0.6);
            (
                format!("name = 'degradation'\ntravel_mm = 1e-3\nlost_share = {lost}"),
                vec![("degradation", "specimen"), ("gain_error", "force")],
            )
        }
    }
}
