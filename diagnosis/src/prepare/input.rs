//! What the motion can tell apart, before anything is fitted: in a record of one frequency, one speed or one side
//! different causes give the same force, whatever fits.

use crate::criteria::specimen::TOGETHER;
use crate::criteria::{LARGEST_SET, ONE_FREQUENCY, ONE_SIDE, ONE_SPEED, ONE_WAY, SAME_SPEED, SLOW};
use crate::model::answer::{FoundEffect, Member};
use crate::model::base::Base;
use crate::prepare::noise::{between_bins, without_trend};
use crate::record::recording::{Recording, range};
use crate::record::spectrum::{Density, motion_band_hz, smooth};
use plant::{Channel, Effect, Family};
use std::f64::consts::TAU;

/// Something that a motion lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct Deficiency {
    /// The sentence for the answer.
    pub sentence: String,
    /// Causes that are indistinguishable without it, the most common first.
    pub alike: Vec<Vec<Effect>>,
}

/// What a channel's input lacks in all its training records.
pub fn deficiencies(base: &Base, train: &[Recording]) -> Vec<Deficiency> {
    let column = |r: &Recording| match base.channel {
        Channel::Actuator => r.command_mm.clone(),
        Channel::Specimen => r.displacement_mm.clone(),
    };
    let inputs: Option<Vec<(Vec<f64>, f64)>> = train
        .iter()
        .map(|r| Some((column(r)?, r.interval_s())))
        .collect();
    let Some(inputs) = inputs else {
        return Vec::new();
    };
    let mut deficiencies = Vec::new();
    let lines: Option<Vec<f64>> = inputs.iter().map(|(x, h)| only_line_hz(x, *h)).collect();
    if let Some(hz) = lines.and_then(|l| same(&l)) {
        deficiencies.push(one_frequency(base.channel, hz));
    } else if base.channel == Channel::Actuator
        && let Some(deficiency) = slow(base, &inputs)
    {
        deficiencies.push(deficiency);
    }
    if base.channel == Channel::Specimen {
        let speeds: Option<Vec<Speeds>> = inputs.iter().map(|(x, h)| Speeds::of(x, *h)).collect();
        deficiencies.extend(speeds.and_then(|s| one_speed(&s)));
        deficiencies.extend(one_side(&inputs));
    }
    deficiencies
}

/// The mean of values that agree within some percent.
fn same(values: &[f64]) -> Option<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let alike = |v: &f64| (v / mean - 1.0).abs() < SAME_SPEED;
    values.iter().all(alike).then_some(mean)
}

/// The frequency that holds nearly all of the power of a motion's velocity.
fn only_line_hz(x: &[f64], interval_s: f64) -> Option<f64> {
    let density = Density::of(x, interval_s)?;
    let mut upper = density.power[density.power.len() / 2..].to_vec();
    upper.sort_by(f64::total_cmp);
    // Power above six times the reading's floor is motion.
    let floor = 6.0 * upper[upper.len() / 2];
    let long = crate::record::spectrum::periodogram(x);
    let bin_hz = 1.0 / (x.len() as f64 * interval_s);
    let motion = |k: usize| {
        let bin = ((k as f64 * bin_hz / density.bin_hz) as usize).min(density.power.len() - 1);
        density.power[bin] > floor
    };
    let speed: Vec<f64> = long
        .iter()
        .enumerate()
        .map(|(k, p)| if motion(k) { p * (k * k) as f64 } else { 0.0 })
        .collect();
    let whole: f64 = speed.iter().sum();
    let at = (0..speed.len()).max_by(|a, b| speed[*a].total_cmp(&speed[*b]))?;
    // A Hann window spreads a line, and a growing amplitude adds a bin or two; a resonance is wider.
    let room = 3 + at / 50;
    let own: f64 = speed[at.saturating_sub(room)..(at + room + 1).min(speed.len())]
        .iter()
        .sum();
    (at >= 3 && own > ONE_FREQUENCY * whole)
        .then(|| between_bins(&without_trend(x), interval_s, at as f64 * bin_hz))
}

fn one_frequency(channel: Channel, hz: f64) -> Deficiency {
    use Effect::*;
    let (alike, which) = match channel {
        Channel::Actuator => (
            vec![vec![LagError, DelayError, SecondLag, OilColumn]],
            "a delay, a lag, a second lag and an oil column are one phase",
        ),
        Channel::Specimen => (
            vec![
                vec![ViscousDamping, CoulombFriction, MaxwellDamper, ChannelSkew],
                vec![GainError, InertiaForce, RigCompliance],
            ],
            "stiffness and mass are one force, and whether a loss grows with speed, as damping, or does not, as friction, is not asked",
        ),
    };
    Deficiency {
        sentence: format!(
            "The motion has one frequency, {hz:.3} Hz: by it {which}, whatever fits. A second frequency tells them apart."
        ),
        alike,
    }
}

/// An actuator driven far more slowly than would show its lag.
fn slow(base: &Base, inputs: &[(Vec<f64>, f64)]) -> Option<Deficiency> {
    use Effect::{DelayError, LagError, SecondLag};
    let bands = inputs.iter().map(|(x, h)| motion_band_hz(x, *h));
    let high_hz = bands
        .collect::<Option<Vec<f64>>>()?
        .into_iter()
        .fold(0.0, f64::max);
    let turn = TAU * high_hz * 1e-3 * base.values[2];
    (base.values[2] > 0.0 && turn < SLOW).then(|| Deficiency {
        sentence: format!(
            "The motion ends at {high_hz:.2} Hz, where the declared lag turns the phase by {turn:.2} rad: so slow, a delay, a \
             lag and a second lag are one, whatever fits. Excite up to {:.0} Hz.",
            1e3 / (TAU * base.values[2])
        ),
        alike: vec![vec![DelayError, LagError, SecondLag]],
    })
}

/// Speeds of a record: the usual one in each direction, mm/s, if there is one; and the fraction of the travel that goes
/// forward.
struct Speeds {
    usual: [f64; 2],
    forward: f64,
    one: bool,
}

impl Speeds {
    fn of(x: &[f64], interval_s: f64) -> Option<Self> {
        let band = motion_band_hz(x, interval_s)?;
        let v = smooth(x, interval_s, (6.0 * band).min(0.4 / interval_s)).v;
        let mut sizes: Vec<f64> = v.iter().map(|v| v.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let top = sizes[(0.98 * sizes.len() as f64) as usize];
        let mut usual = [0.0; 2];
        let (mut near, mut all) = (0.0, 0.0);
        let mut way = [0.0; 2];
        for (i, sign) in [1.0, -1.0].into_iter().enumerate() {
            let mut own: Vec<f64> = v
                .iter()
                .map(|v| v * sign)
                .filter(|v| *v > 0.1 * top)
                .collect();
            if own.is_empty() {
                continue;
            }
            own.sort_by(f64::total_cmp);
            usual[i] = own[own.len() / 2];
            all += own.len() as f64;
            let alike = |v: &&f64| (**v / usual[i] - 1.0).abs() < SAME_SPEED;
            near += own.iter().filter(alike).count() as f64;
            way[i] = own.iter().sum();
        }
        Some(Self {
            usual,
            forward: way[0] / (way[0] + way[1]).max(f64::MIN_POSITIVE),
            one: near > ONE_SPEED * all,
        })
    }
}

/// True if these records of a specimen move at one speed each way, or one way only: then time and travel are one.
pub fn has_one_speed(records: &[Recording]) -> bool {
    let of = |r: &Recording| Speeds::of(r.displacement_mm.as_ref()?, r.interval_s());
    let speeds: Option<Vec<Speeds>> = records.iter().map(of).collect();
    speeds.is_some_and(|all| one_speed(&all).is_some())
}

fn one_speed(all: &[Speeds]) -> Option<Deficiency> {
    use Effect::*;
    let usual = |i: usize| same(&all.iter().map(|s| s.usual[i]).collect::<Vec<_>>());
    let way = |s: &Speeds| s.forward.max(1.0 - s.forward) > ONE_WAY;
    let one_way = all.iter().all(way);
    if !all.iter().all(|s| s.one) {
        return None;
    }
    if one_way {
        let speed = all
            .iter()
            .map(|s| s.usual[0].max(s.usual[1]))
            .fold(0.0, f64::max);
        return Some(Deficiency {
            sentence: format!(
                "The motion goes one way at one speed, {speed:.3} mm/s: by it friction, viscous damping and an offset are one \
                 constant, whatever fits. A way back and a second speed tell them apart."
            ),
            alike: vec![vec![
                CoulombFriction,
                ViscousDamping,
                Offset,
                StribeckFriction,
                QuadraticDamping,
            ]],
        });
    }
    let (out, back) = (usual(0)?, usual(1)?);
    Some(Deficiency {
        sentence: format!(
            "The motion has one speed each way, {out:.3} and {back:.3} mm/s: by it friction and any damping are one, whatever \
             fits. A second speed tells them apart."
        ),
        alike: vec![vec![
            CoulombFriction,
            ViscousDamping,
            StribeckFriction,
            QuadraticDamping,
            MaxwellDamper,
        ]],
    })
}

fn one_side(inputs: &[(Vec<f64>, f64)]) -> Option<Deficiency> {
    use Effect::{AsymmetricStiffness, Hardening, Softening};
    let ends = |x: &[f64]| {
        let high = x.iter().fold(f64::MIN, |m, x| m.max(*x));
        (high - range(x), high)
    };
    let one = |(x, _): &(Vec<f64>, f64)| {
        let (low, high) = ends(x);
        low > -ONE_SIDE * (high - low) || high < ONE_SIDE * (high - low)
    };
    inputs.iter().all(one).then(|| Deficiency {
        sentence: "The motion stays on one side of zero: a spring that stiffens or softens cannot be told there from one that \
                   differs between the sides, whatever fits."
            .into(),
        alike: vec![
            vec![Hardening, AsymmetricStiffness],
            vec![Softening, AsymmetricStiffness],
        ],
    })
}

/// Warming with time and damage by the largest displacement so far are alike if that displacement grows with time:
/// above all in a protocol of growing cycles.
pub fn damages(
    channel: Channel,
    effects: &[FoundEffect],
    train: &[Recording],
) -> Option<Deficiency> {
    let name = Effect::TemperatureGain;
    let found = effects.iter().find(|e| e.name == name)?;
    let (change, time_s) = (found.value("change")?, found.value("time_constant_s")?);
    if channel != Channel::Specimen {
        return None;
    }
    let together = |r: &Recording| {
        let x = r.displacement_mm.as_ref()?;
        let mut largest = 0.0_f64;
        // Each moment is weighted by the force that a change of stiffness makes then.
        let moments = x.iter().zip(&r.time_s).map(|(x, t)| {
            let x = x - r.displacement_mm.as_ref().map_or(0.0, |x| x[0]);
            largest = largest.max(x.abs());
            let grown = 1.0 - (-(t - r.time_s[0]) / time_s).exp();
            (x * x, largest, grown)
        });
        Some(alike(&moments.collect::<Vec<_>>()))
    };
    let least = train.iter().map(together).collect::<Option<Vec<f64>>>()?;
    let least = least.into_iter().fold(1.0, f64::min);
    let others = if change < 0.0 {
        &[Effect::Degradation, Effect::Softening][..]
    } else {
        &[Effect::Hardening]
    };
    (least > TOGETHER).then(|| Deficiency {
        sentence: "The largest displacement so far grows as that change does: a stiffness that changes with time cannot be told \
                   from one that is changed by displacement, whatever fits. Smaller cycles after the largest tell them apart."
            .into(),
        alike: vec![[others, &[name]].concat()],
    })
}

/// The square of the weighted correlation of two values.
pub fn alike(moments: &[(f64, f64, f64)]) -> f64 {
    let sum =
        |of: &dyn Fn(f64, f64) -> f64| moments.iter().map(|(w, a, b)| w * of(*a, *b)).sum::<f64>();
    let whole = sum(&|_, _| 1.0).max(f64::MIN_POSITIVE);
    let (a, b) = (sum(&|a, _| a) / whole, sum(&|_, b| b) / whole);
    let both = sum(&|x, y| (x - a) * (y - b));
    let own = sum(&|x, _| (x - a) * (x - a)) * sum(&|_, y| (y - b) * (y - b));
    both * both / own.max(f64::MIN_POSITIVE)
}

/// How common a cause is among those that fit a specimen's record equally well, relative to friction: every machine has
/// friction; a filter or a change with time fits many records and is the cause of few.
fn commonness(name: Effect) -> f64 {
    match name.entry().family {
        Family::Friction => 1.0,
        Family::Hysteresis | Family::Calibration => 0.7,
        Family::Damping if name == Effect::MaxwellDamper => 0.25,
        Family::Damping => 1.0,
        Family::Slow => 0.1,
        _ => 0.5,
    }
}

/// Adds the names of a group that the motion cannot tell apart. The data give the group's probability, and `commonness` each
/// name's share of what the added names have with the likeliest; other names keep theirs.
pub fn share(all: &mut Vec<Member>, group: &[Effect], named: &[Effect]) {
    let inside = |m: &Member| group.contains(&m.name);
    let of_group = |all: &[Member]| -> Vec<f64> {
        let own = all.iter().filter(|m| inside(m));
        own.map(|m| m.probability).collect()
    };
    let before = of_group(all);
    let most = before.iter().copied().fold(0.0, f64::max);
    let named = named.iter().filter(|n| group.contains(n));
    let usual = named.map(|n| commonness(*n)).fold(0.0, f64::max);
    for &name in group {
        // At one speed, friction that falls with speed is friction.
        let friction = |n: Effect| n.entry().family == Family::Friction;
        let there = |m: &Member| m.name == name || friction(m.name) && friction(name);
        if all.len() < LARGEST_SET && !all.iter().any(there) {
            let probability = most * (commonness(name) / usual).min(1.0);
            all.push(Member { name, probability });
        }
    }
    let [before, after] = [before, of_group(all)].map(|own| own.iter().sum::<f64>());
    for m in all.iter_mut().filter(|m| inside(m)) {
        m.probability *= before / after.max(f64::MIN_POSITIVE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(x: impl Fn(f64) -> f64) -> Vec<(Vec<f64>, f64)> {
        vec![((0..6000).map(|i| x(f64::from(i) * 5e-3)).collect(), 5e-3)]
    }

    #[test]
    fn a_group_shares_its_probability_and_leaves_the_others_theirs() {
        let [friction, hysteresis, offset] = [
            Effect::CoulombFriction,
            Effect::BilinearHysteresis,
            Effect::Offset,
        ];
        let member = |(name, probability)| Member { name, probability };
        let mut all = [(friction, 0.9), (offset, 0.8)].map(member).to_vec();
        share(&mut all, &[friction, hysteresis], &[friction]);
        let p = |name| all.iter().find(|m| m.name == name).unwrap().probability;
        assert!((p(friction) + p(hysteresis) - 0.9).abs() < 1e-12, "{all:?}");
        assert!((p(hysteresis) / p(friction) - 0.7).abs() < 1e-12, "{all:?}");
        assert!((p(offset) - 0.8).abs() < 1e-12, "{all:?}");
    }

    #[test]
    fn one_frequency_is_found_also_where_the_amplitude_grows_and_not_in_a_sweep() {
        let sine = record(|t| 3.0 * (TAU * 0.7 * t).sin());
        assert!((only_line_hz(&sine[0].0, 5e-3).unwrap() - 0.7).abs() < 0.02);
        let grows = record(|t| 0.1 * t * (TAU * 0.7 * t).sin());
        assert!(only_line_hz(&grows[0].0, 5e-3).is_some());
        let sweep = record(|t| (TAU * (0.3 + 0.02 * t) * t).sin());
        assert_eq!(only_line_hz(&sweep[0].0, 5e-3), None);
        let two = record(|t| (TAU * 0.7 * t).sin() + 0.4 * (TAU * 1.1 * t).sin());
        assert_eq!(only_line_hz(&two[0].0, 5e-3), None);
    }

    #[test]
    fn one_speed_each_way_is_a_lack_and_a_sine_has_many() {
        let triangle = |t: f64| 4.0 * ((0.4 * t).fract() - 0.5).abs() - 1.0;
        let of = |all: Vec<(Vec<f64>, f64)>| one_speed(&[Speeds::of(&all[0].0, 5e-3).unwrap()]);
        assert!(of(record(triangle)).unwrap().sentence.contains("one speed"));
        assert_eq!(of(record(|t| (TAU * 0.4 * t).sin())), None);
        // Slow out, fast back.
        let saw = |t: f64| {
            let p = (0.4 * t).fract();
            if p < 0.7 { p / 0.7 } else { (1.0 - p) / 0.3 }
        };
        assert!(of(record(saw)).is_some());
        let way = of(record(|t| 2.0 * t)).unwrap();
        assert!(way.alike[0].contains(&Effect::Offset));
    }

    #[test]
    fn a_motion_that_stays_on_one_side_cannot_tell_the_sides_apart() {
        assert!(one_side(&record(|t| 1.0 + t.sin())).is_some());
        assert!(one_side(&record(|t| 0.5 + t.sin())).is_none());
    }
}
