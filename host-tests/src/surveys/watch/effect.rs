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
    /// The actuator stands beside its command.
    ActuatorOffset,
    /// Friction holds it back.
    ActuatorFriction,
    /// Its valve overlaps.
    Overlap,
    /// The zero of the displacement transducer wanders.
    DisplacementDrift,
    /// The zero of the load cell moves.
    ForceOffset,
    /// It wanders.
    ForceDrift,
    /// A sensor is noisier.
    Noise,
    /// The mains are on a sensor.
    Hum,
    /// A bearing beside the specimen rubs.
    BearingFriction,
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

    /// Those that are drawn beside the others, for tests of their own.
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

    /// The displacement transducer lies.
    pub(super) const fn lies(self) -> bool {
        matches!(
            self,
            Self::DisplacementGain | Self::DisplacementOffset | Self::DisplacementLate
        )
    }
}

/// An effect that begins in mid-test, or is there from the start.
pub(super) struct DrawnEffect {
    pub(super) kind: Kind,
    /// Its table.
    pub(super) text: String,
    /// When, s of the model.
    pub(super) from_s: f64,
    /// The names that are right.
    pub(super) right: Vec<Name>,
    /// Those that are right at first as well: a drift is an offset until it has moved on.
    pub(super) at_first: Vec<Name>,
}

impl DrawnEffect {
    pub(super) fn new(rig: &DrawnRig, draw: &mut Draw) -> Self {
        let from_s = draw.between(0.25, 0.5) * rig.seconds;
        let at = draw.between(-1.0, 13.0).max(0.0) as usize;
        Self::of(Kind::ALL[at.min(12)], from_s, rig, draw)
    }

    /// Of every kind, those of [`Kind::OTHERS`] in two of three tests, from the start in every second.
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
        // Of two actuators it is the lower one's.
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
        // What an overlap takes of each turn is a smaller gain, too.
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
