//! An element beside the declared specimen: a law, its shape, and the force that it makes of a motion at strength 1.

use super::laws;
use super::track::{MotionScales, Track};
use crate::criteria::{
    BRISTLES, EXPONENTS, FRICTION_SPEED, FRICTION_YIELD, MAY_BE_BRISTLES, MAY_BE_FRICTION, NEARLY,
    RELAXES, STRIBECK_YIELD,
};
use crate::library::operators::way;
use crate::linear::Bound;
use plant::Effect;
use serde::{Deserialize, Serialize};

/// The law of an element; what its shape holds is in brackets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Law {
    /// Elastic, then it slides [give mm].
    Slider,
    /// Bristles: friction that builds up smoothly [give mm].
    Bristles,
    /// A slider whose force falls with speed [give mm, speed mm/s].
    Stribeck,
    /// Bouc-Wen [give mm, exponent, load, unload].
    BoucWen,
    /// Five sliders [largest give mm].
    Distributed,
    /// Friction in series with a spring [give mm, creep mm/s, exponent].
    InSeries,
    /// `|v|^a sign v` [exponent].
    PowerOfSpeed,
    /// `tanh(v / speed)` [speed mm/s].
    Saturating,
    /// Spring behind a dashpot [time constant s].
    Relaxing,
    /// `|x|^p x` [exponent].
    PowerOfPlace,
    /// What a spring has lost for good: `-|largest x so far|^p x` [exponent].
    Lessened,
    /// What a spring loses along the way: `-way / (way + half) x` [half mm].
    Fatigued,
    /// A spring that changes while something warms up: `(1 - exp(-t / T)) x` [time constant s].
    Warming,
    /// `|x - place|` [place mm].
    Away,
    /// `x^2`.
    Square,
    /// Spring beyond a place on one side [place mm, side], or on both of a middle [gap mm, 0, middle mm].
    Beyond,
    /// What a play takes from a spring [half width mm].
    Lost,
    /// A slider whose force grows with the distance from a place [give mm, place mm].
    SliderAway,
    /// A slider whose force grows along the way [give mm, place mm].
    SliderAlong,
    /// `|v|`.
    SizeOfSpeed,
    /// Settling in time [time constant s].
    Settling,
    /// A slider whose force is worn away [give mm, travel mm].
    Worn,
    /// A slider that is weak around a place [give mm, width mm, place mm].
    Pinched,
}

/// An element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// Its law.
    pub law: Law,
    /// Its shape, as the law reads it.
    pub shape: [f64; 4],
}

/// How a shape is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// By factors: it stays positive.
    Log,
    /// By steps of the given unit.
    Straight,
}

/// What an element's force depends on. Rivals are of another kind; within a kind the shape tells the name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ElementKind {
    /// A declared parameter that has left its tolerances.
    Parameter,
    /// A function of displacement.
    Place,
    /// A function of velocity.
    Speed,
    /// The way since the last reversals: friction and hysteresis.
    Memory,
    /// Lost motion.
    Play,
    /// The largest displacement or the way so far.
    Damage,
    /// A linear filter.
    Linear,
    /// Time.
    Time,
}

impl Law {
    /// Whether it gives first and slides then, with the same force anywhere and at any time.
    pub fn slides(self) -> bool {
        use Law::{BoucWen, Bristles, Distributed, InSeries, Slider, Stribeck};
        matches!(
            self,
            Slider | Bristles | Stribeck | BoucWen | Distributed | InSeries
        )
    }
}

impl Element {
    /// With a shape; what the law does not read is 0.
    pub fn new<const N: usize>(law: Law, given: [f64; N]) -> Self {
        let mut shape = [0.0; 4];
        shape[..N].copy_from_slice(&given);
        Self { law, shape }
    }

    /// Its force at strength 1, over the whole motion of a track.
    pub fn force(&self, t: &Track, sizes: &MotionScales) -> Vec<f64> {
        let [p, q, r, s] = self.shape;
        let h = t.interval_s;
        let x = &t.x;
        let of_x = |f: &dyn Fn(f64) -> f64| x.iter().map(|x| f(*x)).collect::<Vec<f64>>();
        let of_v = |f: &dyn Fn(f64) -> f64| t.v.iter().map(|v| f(*v)).collect::<Vec<f64>>();
        let times = |z: Vec<f64>, by: &[f64], f: &dyn Fn(f64) -> f64| -> Vec<f64> {
            z.into_iter().zip(by).map(|(z, b)| z * f(*b)).collect()
        };
        match self.law {
            Law::Slider => laws::slider(x, p),
            Law::Bristles => laws::bristles(x, p),
            Law::Stribeck => times(laws::slider(x, p), &t.v, &|v| (-(v / q).powi(2)).exp()),
            Law::BoucWen => laws::bouc_wen(x, p, q, r, s),
            Law::Distributed => laws::distributed(x, p),
            Law::InSeries => laws::in_series(x, h, p, q, r),
            Law::PowerOfSpeed => of_v(&|v| (v / sizes.v).abs().powf(p).copysign(v)),
            Law::Saturating => of_v(&|v| (v / p).tanh()),
            Law::Relaxing => laws::relaxing(x, h, p),
            Law::PowerOfPlace => of_x(&|x| x * (x / sizes.x).abs().powf(p)),
            Law::Lessened => {
                let mut largest = t.largest_before_mm;
                let lost = |x: &f64| {
                    largest = largest.max(x.abs());
                    -x * (largest / sizes.x).powf(p)
                };
                x.iter().map(lost).collect()
            }
            Law::Fatigued => {
                let lost = x.iter().zip(ways(t)).map(|(x, w)| -x * w / (w + p));
                lost.collect()
            }
            Law::Warming => times(settling(t, p), x, &|x| x),
            Law::Away => of_x(&|x| (x - p).abs()),
            Law::Square => of_x(&|x| x * x / sizes.x),
            Law::Beyond if q == 0.0 => of_x(&|x| (x - r) - (x - r).clamp(-p, p)),
            Law::Beyond => of_x(&|x| q * (q * (x - p)).max(0.0)),
            Law::Lost => laws::slider(x, p).into_iter().map(|z| -p * z).collect(),
            Law::SliderAway => times(laws::slider(x, p), x, &|x| ((x - q) / sizes.x).abs()),
            Law::SliderAlong => times(laws::slider(x, p), x, &|x| (x - q) / sizes.x),
            Law::SizeOfSpeed => of_v(&f64::abs),
            Law::Settling => settling(t, p),
            Law::Worn => times(laws::slider(x, p), &ways(t), &|w| (-w / q).exp()),
            Law::Pinched => times(laws::slider(x, p), x, &|x| {
                1.0 - (-((x - r) / q).powi(2)).exp()
            }),
        }
    }

    /// The force of a spring at some places.
    pub fn over(&self, places: &[f64], sizes: &MotionScales) -> Vec<f64> {
        let track = Track {
            interval_s: sizes.interval_s,
            fine: 1,
            x: places.to_vec(),
            largest_before_mm: 0.0,
            travel_before_mm: 0.0,
            v: vec![0.0; places.len()],
            a: Vec::new(),
            first: 0,
            time_s: Vec::new(),
            force: Vec::new(),
        };
        self.force(&track, sizes)
    }

    /// What its strength may be.
    pub fn bound(&self) -> Bound {
        match self.law {
            Law::PowerOfPlace
            | Law::Away
            | Law::Square
            | Law::SizeOfSpeed
            | Law::Settling
            | Law::Warming
            | Law::SliderAlong => Bound::FREE,
            // Softening beyond a gap is a spring that gives way.
            Law::Beyond => Bound::FREE,
            _ => Bound::POSITIVE,
        }
    }

    /// What it costs, in units of an element of one shape.
    pub fn price(&self) -> f64 {
        match self.law {
            Law::BoucWen | Law::InSeries | Law::Worn | Law::Pinched => 1.6,
            Law::Stribeck | Law::SliderAway | Law::SliderAlong => 1.3,
            _ => 1.0,
        }
    }

    /// Its kind.
    pub fn kind(&self, sizes: &MotionScales) -> ElementKind {
        match self.law {
            Law::InSeries if self.relaxes(sizes) => ElementKind::Linear,
            Law::Slider
            | Law::Bristles
            | Law::Stribeck
            | Law::BoucWen
            | Law::Distributed
            | Law::InSeries
            | Law::SliderAway
            | Law::SliderAlong
            | Law::Worn
            | Law::Pinched => ElementKind::Memory,
            Law::Lost => ElementKind::Play,
            Law::Lessened | Law::Fatigued => ElementKind::Damage,
            // What hardly grows with speed is friction whose reversals are smooth.
            Law::PowerOfSpeed if self.shape[0] < EXPONENTS[0] => ElementKind::Memory,
            Law::Saturating if self.shape[0] < FRICTION_SPEED * sizes.v => ElementKind::Memory,
            Law::PowerOfSpeed | Law::Saturating | Law::SizeOfSpeed => ElementKind::Speed,
            Law::PowerOfPlace | Law::Away | Law::Square | Law::Beyond => ElementKind::Place,
            Law::Relaxing => ElementKind::Linear,
            Law::Settling | Law::Warming => ElementKind::Time,
        }
    }

    /// Its name by its shape, not by its equation. `strength` tells a spring that stiffens from one that gives way.
    pub fn name(&self, sizes: &MotionScales, strength: f64) -> Effect {
        let [p, q, ..] = self.shape;
        let give = p / sizes.x;
        match self.law {
            Law::InSeries if self.relaxes(sizes) => Effect::MaxwellDamper,
            Law::Stribeck if give < STRIBECK_YIELD => Effect::StribeckFriction,
            Law::Slider
            | Law::Bristles
            | Law::InSeries
            | Law::SliderAway
            | Law::SliderAlong
            | Law::Distributed
            | Law::BoucWen
                if self.yields_at() < FRICTION_YIELD * sizes.x =>
            {
                Effect::CoulombFriction
            }
            Law::Slider | Law::SliderAway | Law::SliderAlong | Law::Stribeck => {
                Effect::BilinearHysteresis
            }
            Law::Bristles
            | Law::BoucWen
            | Law::Distributed
            | Law::InSeries
            | Law::Worn
            | Law::Pinched => Effect::BoucWenHysteresis,
            Law::PowerOfSpeed if p < EXPONENTS[0] => Effect::CoulombFriction,
            Law::PowerOfSpeed if p < EXPONENTS[1] => Effect::ViscousDamping,
            Law::PowerOfSpeed => Effect::QuadraticDamping,
            Law::Saturating if p < FRICTION_SPEED * sizes.v => Effect::CoulombFriction,
            Law::Saturating | Law::SizeOfSpeed => Effect::ViscousDamping,
            Law::Relaxing => Effect::MaxwellDamper,
            Law::PowerOfPlace if strength < 0.0 => Effect::Softening,
            Law::PowerOfPlace => Effect::Hardening,
            Law::Beyond if q == 0.0 && strength < 0.0 => Effect::Softening,
            Law::Beyond if q == 0.0 => Effect::Hardening,
            Law::Away | Law::Square | Law::Beyond => Effect::AsymmetricStiffness,
            Law::Lost => Effect::Backlash,
            Law::Lessened | Law::Fatigued => Effect::Degradation,
            Law::Warming => Effect::TemperatureGain,
            Law::Settling => Effect::Drift,
        }
    }

    /// Whether it lies so near to another kind that it is no rival of it: a force that saturates soon is nearly friction.
    pub fn is_nearly(&self, kind: ElementKind, sizes: &MotionScales) -> bool {
        let near = match self.law {
            Law::PowerOfSpeed => self.shape[0] < NEARLY * EXPONENTS[0],
            Law::Saturating => self.shape[0] < NEARLY * FRICTION_SPEED * sizes.v,
            Law::InSeries if self.relaxes(sizes) => {
                self.shape[2] * NEARLY > self.most_relaxing(sizes)
            }
            Law::InSeries => {
                return kind == ElementKind::Linear
                    && self.shape[2] < NEARLY * self.most_relaxing(sizes);
            }
            _ => false,
        };
        near && kind == ElementKind::Memory
    }

    /// Whether it is a dashpot for all that the motion shows: a force nearly in proportion to speed, or one behind a spring
    /// that gives way within less than the motion takes for a half of its range.
    pub fn is_dashpot(&self, sizes: &MotionScales) -> bool {
        match self.law {
            Law::Relaxing => self.shape[0] < sizes.x / sizes.v,
            Law::InSeries => self.relaxes(sizes) && self.shape[0] < MAY_BE_FRICTION * sizes.x,
            _ => self.name(sizes, 1.0) == Effect::ViscousDamping,
        }
    }

    /// Whether it yields so early that it may be the give of a sliding contact, and so late that it may be more than that.
    pub fn may_slide(&self, sizes: &MotionScales) -> bool {
        let give = self.yields_at() / sizes.x;
        let most = if self.is_bristles() {
            MAY_BE_BRISTLES
        } else {
            MAY_BE_FRICTION
        };
        self.law.slides() && give > FRICTION_YIELD && give < most
    }

    /// Whether it is Dahl's friction by its equation, Bouc-Wen's with an exponent of 1 and the same rate out and back: a
    /// material that yields comes back with the stiffness that it went out with.
    fn is_bristles(&self) -> bool {
        let [_, n, load, unload] = self.shape;
        self.law == Law::BoucWen && n < BRISTLES && unload > load / 3.0
    }

    /// Whether what is in series with the spring is more a dashpot than friction.
    fn relaxes(&self, sizes: &MotionScales) -> bool {
        self.law == Law::InSeries && self.shape[2] < self.most_relaxing(sizes)
    }

    /// The exponent from which on it is friction.
    fn most_relaxing(&self, sizes: &MotionScales) -> f64 {
        let [contact, spring] = RELAXES;
        if self.shape[0] < MAY_BE_FRICTION * sizes.x {
            contact
        } else {
            spring
        }
    }

    /// Where it yields, mm.
    pub fn yields_at(&self) -> f64 {
        let [give, n, load, _] = self.shape;
        match self.law {
            // The force that its loading rate leads to, over its first stiffness.
            Law::BoucWen if load > 0.0 => give * load.powf(-1.0 / n),
            Law::BoucWen => f64::INFINITY,
            // Half of the force is there at half of the largest give.
            Law::Distributed => 0.6 * give,
            _ => give,
        }
    }

    /// The shapes that can be moved, and how.
    pub fn movable(&self) -> &'static [(usize, Scale)] {
        use Scale::{Log, Straight};
        match self.law {
            Law::Slider
            | Law::Bristles
            | Law::Distributed
            | Law::PowerOfSpeed
            | Law::Saturating
            | Law::Relaxing
            | Law::Lost
            | Law::Lessened
            | Law::Fatigued
            | Law::Settling => &[(0, Log)],
            Law::Stribeck => &[(0, Log), (1, Log)],
            // Where it is written in its own rates, the give is the unit of its force.
            Law::BoucWen if self.shape[2] != 1.0 => &[(2, Straight), (3, Straight), (1, Log)],
            Law::BoucWen => &[(0, Log), (3, Straight), (1, Log)],
            Law::InSeries => &[(0, Log), (1, Log), (2, Log)],
            Law::PowerOfPlace => &[(0, Straight)],
            Law::SliderAway | Law::SliderAlong => &[(0, Log)],
            Law::Worn | Law::Pinched => &[(0, Log), (1, Log)],
            Law::Beyond if self.shape[1] == 0.0 => &[(0, Log)],
            Law::Away | Law::Beyond | Law::Warming => &[],
            Law::Square | Law::SizeOfSpeed => &[],
        }
    }

    /// Whether the shape can be one of its law.
    pub fn is_sound(&self, sizes: &MotionScales) -> bool {
        let [p, q, r, s] = self.shape;
        let x = sizes.x;
        match self.law {
            Law::Slider => (1e-4 * x..=0.97 * x).contains(&p),
            // With a longer give it is Bouc-Wen's.
            Law::Bristles => (1e-4 * x..=1.5 * FRICTION_YIELD * x).contains(&p),
            Law::Stribeck => (1e-4 * x..=0.5 * x).contains(&p) && q > 1e-3 * sizes.v && q < sizes.v,
            Law::BoucWen => {
                let grows = r * (MOST_GROWTH * x / p).powf(q);
                (2e-3 * x..=3.0 * x).contains(&p)
                    && (0.5..=8.0).contains(&q)
                    && (-1.0..=30.0).contains(&r)
                    && (-0.95..=30.0).contains(&s)
                    && grows > -4.0
            }
            // Longer yields are springs of unknown state.
            Law::Distributed => (5e-3 * x..=0.6 * x).contains(&p),
            Law::InSeries => {
                (1e-3 * x..=0.6 * x).contains(&p)
                    && (1e-3 * sizes.v..=3.0 * sizes.v).contains(&q)
                    && (1.1..=12.0).contains(&r)
            }
            Law::PowerOfSpeed => (0.1..=4.0).contains(&p),
            Law::Saturating => (3e-3 * sizes.v..=2.0 * sizes.v).contains(&p),
            Law::Relaxing => (2.0 * sizes.interval_s..=0.3 * sizes.seconds).contains(&p),
            Law::PowerOfPlace => (0.3..=7.0).contains(&p),
            Law::Lessened => (0.1..=4.0).contains(&p),
            Law::Lost => (5e-3 * x..=0.95 * x).contains(&p),
            Law::SliderAway | Law::SliderAlong => (1e-4 * x..=0.5 * x).contains(&p),
            Law::Settling | Law::Warming => p > 0.02 * sizes.seconds && p < 5.0 * sizes.seconds,
            Law::Fatigued => p > 0.02 * sizes.travel && p < 20.0 * sizes.travel,
            Law::Worn => {
                (1e-3 * x..=0.9 * x).contains(&p)
                    && (0.1 * sizes.travel..=30.0 * sizes.travel).contains(&q)
            }
            Law::Pinched => (1e-3 * x..=0.9 * x).contains(&p) && (0.03 * x..=x).contains(&q),
            // A gap to both sides is no narrower than nothing; a contact on one side stands anywhere.
            Law::Beyond => p.abs() < 1e12 && (q != 0.0 || p >= 0.0),
            Law::Away | Law::Square | Law::SizeOfSpeed => true,
        }
    }
}

/// The way gone since the file's first sample, mm; what a span is put before itself with is no way.
fn ways(t: &Track) -> Vec<f64> {
    let ways = way(&t.v, t.interval_s, t.travel_before_mm);
    ways.map(|w| w.max(0.0)).collect()
}

/// From 0 at the file's first moment towards 1.
fn settling(t: &Track, time_constant_s: f64) -> Vec<f64> {
    let from = t.time_s[0] - t.interval_s * t.first as f64;
    let time = (0..t.x.len()).map(|i| from + t.interval_s * i as f64);
    time.map(|t| 1.0 - (-t.max(0.0) / time_constant_s).exp())
        .collect()
}

/// Half ranges over which the growth of a stiffening loop is judged.
const MOST_GROWTH: f64 = 1.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_is_no_narrower_than_nothing() {
        let sizes = MotionScales {
            x: 4.0,
            ..MotionScales::default()
        };
        let is_sound = |p, side| Element::new(Law::Beyond, [p, side]).is_sound(&sizes);
        assert!(is_sound(0.5, 0.0) && is_sound(0.0, 0.0) && !is_sound(-0.5, 0.0));
        assert!(is_sound(-0.5, 1.0) && is_sound(-0.5, -1.0));
    }

    #[test]
    fn what_a_spring_has_lost_stays_lost() {
        let sizes = MotionScales {
            x: 4.0,
            ..MotionScales::default()
        };
        let lessened = Element::new(Law::Lessened, [2.0]);
        let force = lessened.over(&[1.0, 4.0, 2.0, -2.0, -8.0, 4.0], &sizes);
        // -x (largest / 4)^2.
        assert_eq!(force, [-0.0625, -4.0, -2.0, 2.0, 32.0, -16.0]);
    }

    #[test]
    fn a_spring_tires_along_the_way_and_not_at_rest() {
        let track = Track {
            interval_s: 0.5,
            fine: 1,
            x: vec![0.0, 2.0, 2.0, 0.0, -2.0],
            largest_before_mm: 0.0,
            travel_before_mm: 3.0,
            v: vec![0.0, 4.0, 0.0, -4.0, -4.0],
            a: Vec::new(),
            first: 0,
            time_s: Vec::new(),
            force: Vec::new(),
        };
        let force = Element::new(Law::Fatigued, [5.0]).force(&track, &MotionScales::default());
        // 3 mm before the record, then 5, 5, 7 and 9: half is lost after 5.
        assert_eq!(force, [0.0, -1.0, -1.0, 0.0, 2.0 * 9.0 / 14.0]);
    }

    #[test]
    fn what_a_span_is_put_before_itself_with_wears_nothing_off() {
        let track = |travel_before_mm| Track {
            interval_s: 0.5,
            fine: 1,
            x: vec![0.0, 2.0, 4.0, 6.0],
            largest_before_mm: 0.0,
            travel_before_mm,
            v: vec![0.0, 4.0, 4.0, 4.0],
            a: Vec::new(),
            first: 1,
            time_s: Vec::new(),
            force: Vec::new(),
        };
        assert_eq!(ways(&track(-2.0)), [0.0, 0.0, 2.0, 4.0]);
        let worn = Element::new(Law::Worn, [1.0, 10.0]);
        let force = |before| worn.force(&track(before), &MotionScales::default());
        // The first 2 mm are a copy: nothing is worn off at the span's first sample.
        assert_eq!(force(-2.0)[1..], [1.0, (-0.2_f64).exp(), (-0.4_f64).exp()]);
        // A file that has gone 10 mm before: 1/e of it is left.
        assert_eq!(force(8.0)[1], (-1.0_f64).exp());
    }
}
