//! Effects, from mid-test or from the start, and their accepted names.

use super::draw::Draw;
use super::rig::DrawnRig;
use serde::Serialize;

/// A cause: name and side.
pub(super) type Name = (&'static str, &'static str);

/// The effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// The actuator's delay grows.
    ActuatorLate,
    /// Its gain is too large or too small.
    ActuatorGain,
    /// The displacement transducer's gain is too large or too small.
    DisplacementGain,
    /// Its zero jumps.
    DisplacementOffset,
    /// It reads late.
    DisplacementLate,
    /// The load cell's gain is too large or too small.
    ForceGain,
    /// It reads late.
    ForceLate,
    /// The actuator's stroke is limited.
    StrokeLimit,
    /// The actuator's velocity is limited.
    RateLimit,
    /// A reading freezes, with its noise.
    Frozen,
    /// Play between actuator and specimen.
    Play,
    /// Mass on the load cell.
    Mass,
    /// The specimen breaks.
    Break,
    /// The actuator is off its command by an offset.
    ActuatorOffset,
    /// Friction holds it back.
    ActuatorFriction,
    /// Its valve overlaps.
    Overlap,
    /// The zero of the displacement transducer drifts.
    DisplacementDrift,
    /// The zero of the load cell jumps.
    ForceOffset,
    /// It drifts.
    ForceDrift,
    /// A sensor is noisier.
    Noise,
    /// Mains hum on a sensor.
    Hum,
    /// Friction in a bearing next to the specimen.
    BearingFriction,
}

impl Kind {
    /// Those drawn in mid-test; the first is drawn twice as often.
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

    /// Those drawn only for tests with an effect of any kind.
    pub const OTHERS: [Self; 9] = [
        Self::ActuatorOffset,
        Self::ActuatorFriction,
        Self::Overlap,
        Self::DisplacementDrift,
        Self::ForceOffset,
        Self::ForceDrift,
        Self::Noise,
        Self::Hum,
        Self::BearingFriction,
    ];

    /// Its name in tables.
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
            Self::ActuatorOffset => "actuator offset",
            Self::ActuatorFriction => "actuator friction",
            Self::Overlap => "valve overlap",
            Self::DisplacementDrift => "LVDT drift",
            Self::ForceOffset => "load cell offset",
            Self::ForceDrift => "load cell drift",
            Self::Noise => "sensor noise",
            Self::Hum => "mains hum",
            Self::BearingFriction => "bearing friction",
        }
    }

    /// Whether the displacement transducer reads wrong.
    pub(super) const fn lies(self) -> bool {
        matches!(
            self,
            Self::DisplacementGain | Self::DisplacementOffset | Self::DisplacementLate
        )
    }
}

/// An effect that begins in mid-test or from the start.
pub(super) struct DrawnEffect {
    pub(super) kind: Kind,
    /// Its table in the test file.
    pub(super) text: String,
    /// When it begins, s of model time.
    pub(super) from_s: f64,
    /// The correct names.
    pub(super) right: Vec<Name>,
    /// Names that are also correct at first: a drift looks like an offset until it has moved on.
    pub(super) at_first: Vec<Name>,
}

impl DrawnEffect {
    pub(super) fn new(rig: &DrawnRig, draw: &mut Draw) -> Self {
        let from_s = draw.between(0.25, 0.5) * rig.seconds;
        let at = draw.between(-1.0, 13.0).max(0.0) as usize;
        Self::of(Kind::ALL[at.min(12)], from_s, rig, draw)
    }

    /// An effect of any kind: in two of three tests from [`Kind::OTHERS`], and in every second from the start.
    pub(super) fn any(rig: &DrawnRig, draw: &mut Draw) -> Self {
        let from_s = draw.between(-0.5, 0.5).max(0.0) * rig.seconds;
        let at = draw.between(0.0, 13.0) as usize;
        let kind = match draw.between(0.0, 3.0) {
            x if x < 1.0 => Kind::ALL[at.min(12)],
            _ => Kind::OTHERS[at % Kind::OTHERS.len()],
        };
        Self::of(kind, from_s, rig, draw)
    }

    fn of(kind: Kind, from_s: f64, rig: &DrawnRig, draw: &mut Draw) -> Self {
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
            Kind::ActuatorOffset
            | Kind::ActuatorFriction
            | Kind::Overlap
            | Kind::DisplacementDrift
            | Kind::ForceOffset
            | Kind::ForceDrift
            | Kind::Noise
            | Kind::Hum
            | Kind::BearingFriction => other(kind, rig, draw),
        };
        // With two actuators the effect is in the lower one.
        let axis = if rig.storeys > 1 { "axis = 1\n" } else { "" };
        Self {
            kind,
            text: format!("[[plant.effects]]\nfrom_s = {from_s}\n{axis}{body}\n"),
            from_s,
            at_first: right
                .iter()
                .filter(|name| name.0 == "drift")
                .map(|(_, side)| ("offset", *side))
                .collect(),
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
        Kind::DisplacementLate => (
            format!("name = 'channel_skew'\nskew_ms = {}", -late_ms),
            vec![("channel_skew", "displacement")],
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

fn other(kind: Kind, rig: &DrawnRig, draw: &mut Draw) -> (String, Vec<Name>) {
    let (sign, share) = (draw.sign(), draw.between(0.01, 0.06));
    let peak_n = rig.mass_kg * rig.omega * rig.omega * rig.peak_mm * 1e-3;
    let (way_mm, force_n) = (share * rig.peak_mm, share * peak_n);
    let (sensor, unit, least) = match sign > 0.0 {
        true => ("force", "n", peak_n),
        false => ("displacement", "mm", rig.peak_mm),
    };
    match kind {
        Kind::ActuatorOffset => (
            format!(
                "name = 'offset'\nchannel = 'actuator'\noffset_mm = {}",
                sign * way_mm
            ),
            vec![("offset", "actuator")],
        ),
        Kind::ActuatorFriction => (
            format!("name = 'coulomb_friction'\nchannel = 'actuator'\nerror_mm = {way_mm}"),
            vec![("coulomb_friction", "actuator")],
        ),
        // An overlap also reduces the gain, but only its own name is correct.
        Kind::Overlap => (
            format!(
                "name = 'dead_band'\nchannel = 'actuator'\nwidth_mm = {}",
                2.0 * way_mm
            ),
            vec![("dead_band", "actuator")],
        ),
        Kind::DisplacementDrift => (
            format!(
                "name = 'drift'\nsensor = 'displacement'\nrate_mm_per_s = {}",
                sign * way_mm / (0.25 * rig.seconds)
            ),
            vec![("drift", "displacement")],
        ),
        Kind::ForceOffset => (
            format!(
                "name = 'offset'\nsensor = 'force'\noffset_n = {}",
                sign * force_n
            ),
            vec![("offset", "force")],
        ),
        Kind::ForceDrift => (
            format!(
                "name = 'drift'\nsensor = 'force'\nrate_n_per_s = {}",
                sign * force_n / (0.25 * rig.seconds)
            ),
            vec![("drift", "force")],
        ),
        Kind::Noise => (
            format!(
                "name = 'sensor_noise'\nsensor = '{sensor}'\nrms_{unit} = {}",
                share * least
            ),
            vec![("sensor_noise", sensor)],
        ),
        Kind::Hum => (
            format!(
                "name = 'mains_hum'\nsensor = '{sensor}'\namplitude_{unit} = {}",
                share * least
            ),
            vec![("mains_hum", sensor)],
        ),
        _ => (
            format!("name = 'coulomb_friction'\nchannel = 'specimen'\nforce_n = {force_n}"),
            vec![("coulomb_friction", "specimen")],
        ),
    }
}
