//! An element beside the declared specimen: a law, its shape, and its force for a motion at strength 1.

use super::laws;
use super::track::{MotionScales, Track};
use crate::numbers::linear::Bound;
use crate::numbers::operators::{heated, power, relaxed, returned, slider, slipped, travel};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The law of an element; what its shape holds is in brackets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Law {
    /// Elastic, then it slides [yield displacement mm].
    Slider,
    /// Bristles: friction that builds up smoothly [yield displacement mm].
    Bristles,
    /// Bouc-Wen [yield displacement mm, exponent, load, unload].
    BoucWen,
    /// Five sliders [largest yield displacement mm, where they begin as a share of it].
    Distributed,
    /// Friction in series with a spring [yield displacement mm, creep mm/s, exponent].
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
    /// What a spring loses with travel: `-travel / (travel + half) x` [half mm].
    Fatigued,
    /// A spring that changes while something warms up: `(1 - exp(-t / T)) x` [time constant s, and how much it warms by its own
    /// motion, were that always at its end, over how much with time].
    Warming,
    /// `|x - place|`, rounded within a width if that is not 0 [place mm, width mm].
    Away,
    /// `x^2`.
    Square,
    /// Spring beyond a place on one side [place mm, side, 0, time constant s of a dashpot beside it: together they push and never
    /// pull], or on both of a middle [gap mm, 0, middle mm].
    Beyond,
    /// What a play takes from a spring [half width mm].
    Lost,
    /// A slider whose force grows with the distance from a place [yield displacement mm, place mm].
    SliderAway,
    /// A slider whose force grows with travel [yield displacement mm, place mm].
    SliderAlong,
    /// `|v|`.
    SizeOfSpeed,
    /// A slider whose force is worn away [yield displacement mm, travel mm].
    Worn,
    /// A slider that is weak around a place [yield displacement mm, width mm, place mm].
    Pinched,
    /// What a spring loses behind a joint that slips and comes back, a flag [slip mm, share of it at which it is back].
    Recentring,
    /// A spring behind a joint that slips and then bears [slip mm, clearance in all mm].
    SlippingJoint,
}

/// An element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// Its law.
    pub law: Law,
    /// Its shape, in the law's own meaning.
    pub shape: [f64; 4],
}

impl Law {
    /// True if it first gives and then slides, with the same force anywhere and at any time.
    pub fn slides(self) -> bool {
        use Law::{BoucWen, Bristles, Distributed, InSeries, Slider};
        matches!(self, Slider | Bristles | BoucWen | Distributed | InSeries)
    }
}

impl Element {
    /// With a shape; values that the law does not use are 0.
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
            Law::Slider => slider(x, p),
            Law::Bristles => laws::bristles(x, p),
            Law::BoucWen => laws::bouc_wen(x, p, q, r, s),
            Law::Distributed => laws::distributed(x, p, q),
            Law::InSeries => laws::in_series(x, h, p, q, r),
            Law::PowerOfSpeed => of_v(&|v| power((v / sizes.v).abs(), p).copysign(v)),
            Law::Saturating => of_v(&|v| (v / p).tanh()),
            Law::Relaxing => relaxed(x, p, h),
            Law::PowerOfPlace => of_x(&|x| x * power((x / sizes.x).abs(), p)),
            Law::Lessened => {
                let mut largest = t.largest_before_mm;
                let of = |largest: f64| power(largest / sizes.x, p);
                let mut share = of(largest);
                let lost = |x: &f64| {
                    if x.abs() > largest {
                        largest = x.abs();
                        share = of(largest);
                    }
                    -x * share
                };
                x.iter().map(lost).collect()
            }
            Law::Fatigued => {
                let lost = x.iter().zip(travels(t)).map(|(x, w)| -x * w / (w + p));
                lost.collect()
            }
            Law::Warming => {
                let own = heated(x, p, h).map(|heat| q * heat / sizes.x.powi(2));
                let warm = settling(t, p).into_iter().zip(own);
                let warm = warm.map(|(with_time, own)| with_time + own).collect();
                times(warm, x, &|x| x)
            }
            Law::Away => of_x(&|x| laws::rounded(x - p, q)),
            Law::Square => of_x(&|x| x * x / sizes.x),
            Law::Beyond if q == 0.0 => of_x(&|x| (x - r) - (x - r).clamp(-p, p)),
            Law::Beyond => {
                let pushes = |(x, v): (&f64, &f64)| match q * (x - p) {
                    into if into > 0.0 => q * (into + s * q * v).max(0.0),
                    _ => 0.0,
                };
                x.iter().zip(&t.v).map(pushes).collect()
            }
            Law::Lost => slider(x, p).into_iter().map(|z| -p * z).collect(),
            Law::SliderAway => times(slider(x, p), x, &|x| ((x - q) / sizes.x).abs()),
            Law::SliderAlong => times(slider(x, p), x, &|x| (x - q) / sizes.x),
            Law::SizeOfSpeed => of_v(&f64::abs),
            Law::Worn => times(slider(x, p), &travels(t), &|w| (-w / q).exp()),
            Law::SlippingJoint => {
                let slips = slipped(x, p, q);
                x.iter().zip(slips).map(|(x, s)| x - s).collect()
            }
            Law::Recentring => returned(x, p, q * p).into_iter().map(|s| -s).collect(),
            Law::Pinched => times(slider(x, p), x, &|x| 1.0 - (-((x - r) / q).powi(2)).exp()),
        }
    }

    /// Bounds of its strength.
    pub fn bound(&self) -> Bound {
        match self.law {
            Law::PowerOfPlace
            | Law::Away
            | Law::Square
            | Law::SizeOfSpeed
            | Law::Warming
            | Law::SliderAlong => Bound::FREE,
            // Softening beyond a gap is a spring that gives way; a damper pushes.
            Law::Beyond if self.shape[3] == 0.0 => Bound::FREE,
            _ => Bound::POSITIVE,
        }
    }
}

/// The travel since the file's first sample, mm; a copy of a span put before itself is no travel.
fn travels(t: &Track) -> Vec<f64> {
    let travels = travel(&t.v, t.interval_s, t.travel_before_mm);
    travels.map(|w| w.max(0.0)).collect()
}

/// Rises from 0 at the file's first moment towards 1.
fn settling(t: &Track, time_constant_s: f64) -> Vec<f64> {
    let from = t.time_s[0] - t.interval_s * t.first as f64;
    let time = (0..t.x.len()).map(|i| from + t.interval_s * i as f64);
    time.map(|t| 1.0 - (-t.max(0.0) / time_constant_s).exp())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The force of a spring at given places.
    fn over(spring: &Element, places: &[f64], sizes: &MotionScales) -> Vec<f64> {
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
            unmeasured: Vec::new(),
        };
        spring.force(&track, sizes)
    }

    #[test]
    fn what_a_spring_has_lost_stays_lost() {
        let sizes = MotionScales {
            x: 4.0,
            ..MotionScales::default()
        };
        let lessened = Element::new(Law::Lessened, [2.0]);
        let force = over(&lessened, &[1.0, 4.0, 2.0, -2.0, -8.0, 4.0], &sizes);
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
            unmeasured: Vec::new(),
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
            unmeasured: Vec::new(),
        };
        assert_eq!(travels(&track(-2.0)), [0.0, 0.0, 2.0, 4.0]);
        let worn = Element::new(Law::Worn, [1.0, 10.0]);
        let force = |before| worn.force(&track(before), &MotionScales::default());
        // The first 2 mm are a copy: nothing has worn off at the span's first sample.
        assert_eq!(force(-2.0)[1..], [1.0, (-0.2_f64).exp(), (-0.4_f64).exp()]);
        // A file with 10 mm of previous travel: 1/e of it is left.
        assert_eq!(force(8.0)[1], (-1.0_f64).exp());
    }
}
