//! Parts that may act between command and displacement besides a delay and a lag.

#[cfg(doc)]
use crate::numbers::operators::dahl;
use plant::Effect;

/// A part of the signal path from command to displacement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PartKind {
    /// A second first-order lag after the first: its time constant, s.
    SecondLag,
    /// The spring of the oil under the mass: natural frequency, Hz, damping ratio, and its increase with speed (orifices
    /// damp by the square of the speed), s/mm.
    OilColumn,
    /// A cylinder of unequal areas: the flow is e + b e^2 of the valve's opening e; b, 1/mm.
    UnequalAreas,
    /// A single rod: the flow drives the piston at 1 + r times its mean speed one way and 1 - r times the other; r.
    TwoSpeeds,
    /// An overlapped valve: no flow up to this opening, mm.
    Overlap,
    /// A flow that saturates smoothly, e0 tanh(e / e0): e0, mm.
    FlowLimit,
    /// A largest speed, mm/s.
    RateLimit,
    /// Square root of the pressure that a spring behind the piston leaves to the flow: its force per mm, over that
    /// which stalls the piston. Any ram with a specimen has it, so it has no name.
    Load,
    /// A sagging supply: the fraction of its pressure that a mean speed of 1 mm/s takes from the flow, s/mm, and the
    /// time in which the accumulator recovers, s. A sound ram does not have it, and the catalogue has no name for it.
    Sag,
    /// A largest speed after all lags, mm/s: the catalogue's equation.
    Slew,
    /// Play after the drive: its width, mm.
    Play,
    /// No response to commands within a band: its width and its middle, mm.
    DeadBand,
    /// Dry friction in the drive: its elastic give, mm, and how round it turns over, see [`dahl`]; its strength is an
    /// amplitude.
    Friction,
    /// Friction of the piston's seals against the spring of the oil, inside the position loop: the compression of the
    /// oil and the give of the seals, mm.
    Seal,
    /// The same for friction that falls with speed: compression and give, mm, level at rest over that in motion, speed
    /// at which it falls, mm/s.
    StickySeal,
    /// The rig yields under load: an amplitude.
    Compliance,
    /// Different gains on the two sides: an amplitude.
    SideGain,
    /// A drifting zero: its time constant, s; an amplitude.
    Drift,
    /// A drifting gain: its time constant, s, and how much it warms by its own motion, 1/mm^2, over how much with time; an
    /// amplitude.
    GainDrift,
    /// Stops of the reading, after gain, offset and all others: the lower, the upper, and how far their corners are rounded, mm.
    Stops,
}

/// Sizes of the records, the reference for shapes.
#[derive(Clone, Copy, Debug)]
pub struct ActuatorScales {
    /// Largest displacement from the middle, mm.
    pub x_mm: f64,
    /// Largest speed, mm/s.
    pub speed_mm_per_s: f64,
    /// Largest valve opening, mm: the lag of the response behind its command.
    pub opening_mm: f64,
    /// Sampling interval, s.
    pub interval_s: f64,
    /// Length of a record, s.
    pub seconds: f64,
    /// Smallest and largest displacement, mm.
    pub ends_mm: [f64; 2],
}

impl PartKind {
    /// All of them, in the order in which they act.
    pub const ALL: [Self; 20] = [
        Self::SecondLag,
        Self::OilColumn,
        Self::UnequalAreas,
        Self::TwoSpeeds,
        Self::Overlap,
        Self::FlowLimit,
        Self::RateLimit,
        Self::Load,
        Self::Sag,
        Self::Slew,
        Self::Play,
        Self::DeadBand,
        Self::Friction,
        Self::Seal,
        Self::StickySeal,
        Self::Compliance,
        Self::SideGain,
        Self::Drift,
        Self::GainDrift,
        Self::Stops,
    ];

    /// Its name in the catalogue; none for what any sound ram has, and for a sagging supply.
    pub const fn effect(self) -> Option<Effect> {
        Some(match self {
            Self::Load | Self::Sag => return None,
            Self::SecondLag => Effect::SecondLag,
            Self::OilColumn => Effect::OilColumn,
            Self::UnequalAreas | Self::TwoSpeeds | Self::SideGain => Effect::AsymmetricActuator,
            Self::Overlap | Self::DeadBand => Effect::DeadBand,
            Self::FlowLimit | Self::RateLimit | Self::Slew => Effect::RateLimit,
            Self::Play => Effect::Backlash,
            Self::Stops => Effect::Saturation,
            Self::Friction | Self::Seal => Effect::CoulombFriction,
            Self::StickySeal => Effect::StribeckFriction,
            Self::Compliance => Effect::RigCompliance,
            Self::Drift => Effect::Drift,
            Self::GainDrift => Effect::TemperatureGain,
        })
    }

    /// The declared parameter that it may free from its tolerance, without a name for that: a piston that moves faster
    /// one way than the other has a mean offset.
    pub const fn takes_along(self) -> Option<usize> {
        match self {
            Self::UnequalAreas | Self::TwoSpeeds | Self::SideGain => Some(3),
            _ => None,
        }
    }

    /// True if either can replace the other: they are not put into one model.
    pub fn is_like(self, other: Self) -> bool {
        let group = |k: Self| match k {
            Self::Play | Self::Friction | Self::Seal | Self::StickySeal => 0,
            Self::Overlap | Self::DeadBand => 1,
            Self::FlowLimit | Self::RateLimit | Self::Slew => 2,
            Self::UnequalAreas | Self::TwoSpeeds | Self::SideGain => 3,
            Self::SecondLag | Self::OilColumn => 4,
            Self::Drift | Self::GainDrift => 5,
            Self::Stops => 6,
            Self::Compliance => 7,
            Self::Load => 8,
            Self::Sag => 9,
        };
        // Play after the drive and friction that compresses the oil inside the loop may occur together.
        let beside = |a, b| a == Self::Play && matches!(b, Self::Seal | Self::StickySeal);
        group(self) == group(other) && !beside(self, other) && !beside(other, self)
    }

    /// True if it makes a linear path of a higher order.
    pub const fn is_order(self) -> bool {
        matches!(self, Self::SecondLag | Self::OilColumn)
    }

    /// True if it adds a column with its own amplitude; otherwise it acts inside the signal path.
    pub const fn is_column(self) -> bool {
        matches!(
            self,
            Self::Friction | Self::Compliance | Self::SideGain | Self::Drift | Self::GainDrift
        )
    }

    /// True if its amplitude cannot be negative.
    pub const fn is_positive(self) -> bool {
        matches!(self, Self::Friction | Self::Compliance)
    }

    /// True if it acts on the valve's flow or on the oil, inside the first lag.
    pub const fn is_inside(self) -> bool {
        matches!(
            self,
            Self::UnequalAreas
                | Self::TwoSpeeds
                | Self::Overlap
                | Self::FlowLimit
                | Self::RateLimit
                | Self::Load
                | Self::Sag
                | Self::Seal
                | Self::StickySeal
        )
    }

    /// Its price, nats: how rare it is, and a little for each number.
    pub const fn price(self) -> f64 {
        match self {
            Self::OilColumn
            | Self::Sag
            | Self::Friction
            | Self::Seal
            | Self::Drift
            | Self::GainDrift => 3.7,
            Self::StickySeal => 4.5,
            Self::DeadBand => 3.3,
            Self::Load => 1.0,
            _ => 3.0,
        }
    }

    /// Grid of its first shape; values in between are found by descent.
    pub fn grid(self, s: &ActuatorScales) -> Vec<Shapes> {
        let spread = |low: f64, high: f64, n: usize| -> Vec<Shapes> {
            let at = |i: usize| low * (high / low).powf(i as f64 / (n - 1) as f64);
            (0..n).map(|i| shapes([at(i)])).collect()
        };
        match self {
            Self::SecondLag => spread(s.interval_s, 80.0 * s.interval_s, 7),
            Self::OilColumn => spread(3.0, 0.3 / s.interval_s, 8)
                .into_iter()
                .flat_map(|f| {
                    let by_speed = 0.2 / s.speed_mm_per_s;
                    [[0.1, 0.0], [0.4, 0.0], [0.05, by_speed]].map(|[d, q]| shapes([f[0], d, q]))
                })
                .collect(),
            Self::UnequalAreas => [-0.6, -0.2, 0.2, 0.6]
                .map(|b| shapes([b / s.opening_mm]))
                .to_vec(),
            Self::TwoSpeeds => [-0.5, -0.2, 0.2, 0.5].map(|r| shapes([r])).to_vec(),
            Self::Overlap => spread(0.01 * s.opening_mm, 0.5 * s.opening_mm, 6),
            Self::FlowLimit => spread(0.2 * s.opening_mm, 2.0 * s.opening_mm, 6),
            Self::RateLimit | Self::Slew => {
                spread(0.3 * s.speed_mm_per_s, 1.05 * s.speed_mm_per_s, 8)
            }
            Self::Load => [0.05, 0.2].map(|l| shapes([l / s.x_mm])).to_vec(),
            Self::Sag => vec![shapes([0.1 / s.speed_mm_per_s, 0.3])],
            // The reading only shows the motion that they leave: they may be wider than that.
            Self::Play | Self::DeadBand => spread(0.002 * s.x_mm, 1.5 * s.x_mm, 10),
            Self::Stops => {
                let [low, high] = s.ends_mm;
                let (open, inside) = (10.0 * s.x_mm, 0.02 * s.x_mm);
                vec![
                    shapes([low + inside, high - inside]),
                    shapes([low - open, high - inside]),
                    shapes([low + inside, high + open]),
                ]
            }
            Self::Friction => spread(0.002 * s.x_mm, 0.1 * s.x_mm, 5)
                .into_iter()
                .flat_map(|f| [0.0, 1.0].map(|round| shapes([f[0], round])))
                .collect(),
            Self::Seal => spread(0.006 * s.x_mm, 0.1 * s.x_mm, 4)
                .into_iter()
                .map(|f| shapes([f[0], 0.003 * s.x_mm]))
                .collect(),
            Self::StickySeal => spread(0.01 * s.x_mm, 0.05 * s.x_mm, 2)
                .into_iter()
                .flat_map(|f| {
                    [0.03, 0.15].map(|v| shapes([f[0], 0.003 * s.x_mm, 1.6, v * s.speed_mm_per_s]))
                })
                .collect(),
            Self::Compliance | Self::SideGain => vec![shapes([])],
            Self::Drift => spread(0.3 * s.seconds, 20.0 * s.seconds, 3),
            Self::GainDrift => spread(0.3 * s.seconds, 20.0 * s.seconds, 3)
                .into_iter()
                .flat_map(|f| [0.0, 10.0].map(|own| shapes([f[0], own / s.x_mm.powi(2)])))
                .collect(),
        }
    }

    /// Number of its shapes.
    pub const fn shapes(self) -> usize {
        match self {
            Self::DeadBand | Self::Friction | Self::Seal | Self::Sag => 2,
            Self::GainDrift => 2,
            Self::OilColumn | Self::Stops => 3,
            Self::StickySeal => 4,
            Self::Compliance | Self::SideGain => 0,
            _ => 1,
        }
    }

    /// Bounds of a shape.
    pub fn bounds(self, which: usize, s: &ActuatorScales) -> [f64; 2] {
        match (self, which) {
            (Self::SecondLag, _) => [0.1 * s.interval_s, 0.5],
            (Self::OilColumn, 0) => [1.0, 0.4 / s.interval_s],
            (Self::OilColumn, 1) => [0.01, 1.0],
            (Self::OilColumn, _) => [0.0, 4.0 / s.speed_mm_per_s],
            (Self::UnequalAreas, _) => [-1.5 / s.opening_mm, 1.5 / s.opening_mm],
            (Self::TwoSpeeds, _) => [-0.9, 0.9],
            (Self::Overlap, _) => [0.0, 0.9 * s.opening_mm],
            (Self::FlowLimit, _) => [0.05 * s.opening_mm, 2.0 * s.opening_mm],
            (Self::RateLimit | Self::Slew, _) => [0.1 * s.speed_mm_per_s, 2.0 * s.speed_mm_per_s],
            (Self::Load, _) => [0.0, 0.8 / s.x_mm],
            (Self::Sag, 0) => [0.0, 1.5 / s.speed_mm_per_s],
            (Self::Sag, _) => [0.1, 1.0],
            (Self::DeadBand, 1) => [-0.5 * s.x_mm, 0.5 * s.x_mm],
            (Self::Play | Self::DeadBand, _) => [0.0, 4.0 * s.x_mm],
            (Self::Stops, 2) => [0.0, 0.3 * s.x_mm],
            (Self::Stops, _) => [s.ends_mm[0] - 20.0 * s.x_mm, s.ends_mm[1] + 20.0 * s.x_mm],
            (Self::Friction, 0) => [5e-4 * s.x_mm, 0.3 * s.x_mm],
            (Self::Friction, _) => [0.0, 1.0],
            (Self::Seal | Self::StickySeal, 0) => [0.0, 0.3 * s.x_mm],
            (Self::Seal | Self::StickySeal, 1) => [3e-4 * s.x_mm, 0.05 * s.x_mm],
            (Self::Seal | Self::StickySeal, 2) => [1.0, 4.0],
            (Self::Seal | Self::StickySeal, _) => [5e-3 * s.speed_mm_per_s, 0.6 * s.speed_mm_per_s],
            (Self::GainDrift, 1) => [0.0, 1e3 / s.x_mm.powi(2)],
            (Self::Drift | Self::GainDrift, _) => [0.3 * s.seconds, 200.0 * s.seconds],
            (Self::Compliance | Self::SideGain, _) => [0.0, 0.0],
        }
    }

    /// Step of a shape for a slope.
    pub fn step(self, which: usize, s: &ActuatorScales) -> f64 {
        match (self, which) {
            (Self::SecondLag, _) => 0.1 * s.interval_s,
            (Self::OilColumn, 0) => 0.02,
            (Self::OilColumn, 1) => 2e-3,
            (Self::OilColumn, _) => 2e-3 / s.speed_mm_per_s,
            (Self::UnequalAreas, _) => 1e-3 / s.opening_mm,
            (Self::TwoSpeeds, _) => 1e-3,
            (Self::Load, _) => 1e-3 / s.x_mm,
            (Self::Sag, 0) => 1e-3 / s.speed_mm_per_s,
            (Self::Sag, _) => 1e-2,
            (Self::Overlap | Self::FlowLimit, _) => 1e-3 * s.opening_mm,
            (Self::RateLimit | Self::Slew, _) | (Self::StickySeal, 3) => 1e-3 * s.speed_mm_per_s,
            (Self::Seal | Self::StickySeal, 0 | 1) => 2e-4 * s.x_mm,
            (Self::StickySeal, _) | (Self::Friction, 1) => 1e-2,
            (Self::GainDrift, 1) => 1e-2 / s.x_mm.powi(2),
            (Self::Drift | Self::GainDrift, _) => 1e-2 * s.seconds,
            _ => 1e-3 * s.x_mm,
        }
    }
}

/// Damping ratio from which nothing rings: two lags in series have 1 or more.
const RINGS: f64 = 0.95;

/// A usual damping ratio of an oil column, by leakage and seals, and the scatter of its logarithm.
const OF_OIL: f64 = 0.15;
const SCATTER_OF_OIL: f64 = 0.8;

/// Ratio of friction at rest to that in motion below which it is plain friction.
const STICKS: f64 = 1.05;

impl Part {
    /// Its name in the catalogue.
    pub fn effect(&self) -> Option<Effect> {
        match self.kind {
            PartKind::StickySeal if self.shapes[2] < STICKS => Some(Effect::CoulombFriction),
            kind => kind.effect(),
        }
    }

    /// Its price, nats: that of its kind, and how rare such a damping is in an oil column.
    pub fn price(&self) -> f64 {
        let damped = match self.kind {
            PartKind::OilColumn => (self.shapes[1] / OF_OIL).max(1.0).ln() / SCATTER_OF_OIL,
            _ => 0.0,
        };
        self.kind.price() + 0.5 * damped * damped
    }

    /// True for a resonance that does not ring: it may be a lag.
    pub fn is_overdamped(&self) -> bool {
        self.kind == PartKind::OilColumn && self.shapes[1] > RINGS
    }
}

/// Shapes of a part; unused ones are 0.
pub type Shapes = [f64; 4];

/// The first shapes as given, the others 0.
pub fn shapes<const N: usize>(first: [f64; N]) -> Shapes {
    let mut all = [0.0; 4];
    all[..N].copy_from_slice(&first);
    all
}

/// A part with its shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Its kind.
    pub kind: PartKind,
    /// Its shapes.
    pub shapes: Shapes,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_oil_column_that_hardly_rings_is_rare() {
        let of = |damping| Part {
            kind: PartKind::OilColumn,
            shapes: shapes([20.0, damping]),
        };
        assert_eq!(of(0.1).price(), PartKind::OilColumn.price());
        // A column damped like a delay's best imitation, against one as the leakage makes it.
        let rarer = of(0.87).price() - of(0.2).price();
        assert!((2.0..3.0).contains(&rarer), "{rarer}");
    }
}
