//! One channel of the rig: records in its terms, the declared parameters, and what the model answers.

use crate::base::{Base, FreeParameter};
use crate::library::candidate::Candidate;
use crate::library::form;
use crate::library::saved::fit_of;
use crate::noise::hum::without_hum;
use crate::recording::Recording;
use crate::segment::{Segment, corners, settling};
use crate::signals::{
    Scales, Signals, Transfer, add_columns, add_scaled, averaged, derivative, difference,
    difference_quotient, lagged, peak,
};
use crate::spectrum;
use crate::travel;
use plant::Channel;
use std::borrow::Cow;

/// Records of one channel.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The records.
    pub segments: Vec<Segment>,
    /// The parameters that `signals.base` was computed with.
    pub theta: [f64; 4],
    /// What shapes are measured by.
    pub scales: Scales,
}

/// An effect as it was fitted.
#[derive(Clone, Debug)]
pub struct FittedEffect {
    /// Which.
    pub candidate: Candidate,
    /// Its shape parameters.
    pub shapes: Vec<f64>,
    /// Its amplitudes.
    pub amplitudes: Vec<f64>,
}

/// A channel's view of one recording; `motion_mm` is its displacement where that is known better than by its reading.
fn segment(
    base: &Base,
    r: &Recording,
    cutoff_hz: f64,
    motion_mm: Option<&Vec<f64>>,
) -> Option<Segment> {
    let h = r.interval_s();
    let (mut whole, mut lead) = r.behind_its_past();
    if let Some(x) = motion_mm
        && x.len() < whole.time_s.len()
    {
        // The motion is known from the record's beginning on only.
        (whole, lead) = (r.clone(), 0);
    }
    let displacement = whole.displacement_mm.as_ref()?;
    let none = || vec![0.0; displacement.len()];
    let (motion, reading, command, target) = match base.channel {
        Channel::Actuator => (
            None,
            Vec::new(),
            whole.command_mm.as_ref()?.clone(),
            displacement.clone(),
        ),
        Channel::Specimen => {
            let clean = without_hum(displacement, &whole);
            let motion = match motion_mm {
                Some(x) => spectrum::Motion::of(&x[x.len() - whole.time_s.len()..], h),
                None => spectrum::smooth(&clean, h, cutoff_hz),
            };
            (
                Some(motion),
                clean,
                Vec::new(),
                whole.force_n.as_ref()?.clone(),
            )
        }
    };
    // Only damping and mass feel a corner more than the reading shows it.
    let feels = base.values[1] != 0.0 || base.values[2] != 0.0;
    let corners = match &motion {
        Some(m) if feels && motion_mm.is_some() => corners(&m.a),
        _ => Vec::new(),
    };
    let smooth = |f: &Vec<f64>| spectrum::smooth(f, h, cutoff_hz).x;
    let (x, v, a) = motion.map_or((none(), none(), none()), |m| (m.x, m.v, m.a));
    Some(Segment {
        signals: Signals {
            interval_s: h,
            time_s: whole.time_s.clone(),
            x,
            largest_before_mm: r.largest_before_mm(),
            travel_before_mm: travel::before_mm(r, lead),
            v,
            a,
            base: none(),
            force: whole.force_n.as_ref().map_or_else(none, smooth),
            reading,
            command,
        },
        target,
        corners,
        unmeasured: r.unmeasured().iter().map(|i| lead + i).collect(),
        lead,
        from: lead + settling(base, r, lead),
    })
}

impl Problem {
    /// The channel's view of `recordings`; `None` where a signal is missing. `cutoff_hz` is where displacement ends
    /// and noise begins (specimen only); `motions` are the displacements, mm, where a model of the actuator tells them
    /// better than a low-pass of their readings.
    pub fn new(
        base: &Base,
        recordings: &[Recording],
        cutoff_hz: f64,
        motions: &[Option<Vec<f64>>],
    ) -> Option<Self> {
        let of = |(i, r)| {
            let motion = motions.get(i).and_then(Option::as_ref);
            segment(base, r, cutoff_hz, motion)
        };
        let segments = recordings.iter().enumerate().map(of);
        let segments: Vec<Segment> = segments.collect::<Option<_>>()?;
        let first = segments.first()?;
        let unit = Transfer {
            gain: 1.0,
            ..Transfer::default()
        };
        let scales = Scales {
            stiffness: 1.0,
            seconds: first.signals.interval_s * first.seen(&first.target).len() as f64,
            interval_s: first.signals.interval_s,
            step_s: first.signals.interval_s,
            actuator: unit,
            declared: unit,
            ..Scales::default()
        };
        let mut problem = Self {
            segments,
            theta: base.values,
            scales,
        };
        // Known effects are relative to the size of the motion, which the actuator's answer then says better.
        problem.measure(base);
        problem.set(base, base.values);
        problem.measure(base);
        Some(problem)
    }

    /// The same with every signal averaged over `n` samples: for a search, where a small error of a fast effect does
    /// not matter. The answer stays that of the full rate; [`Problem::set`] would compute it at the low one.
    pub fn thinned(&self, n: usize) -> Self {
        let thin = |x: &Vec<f64>| averaged(x, n);
        let segments = self.segments.iter().map(|segment| {
            let s = &segment.signals;
            let target = thin(&segment.target);
            let fewer = |samples: &[usize]| {
                let mut samples: Vec<usize> = samples.iter().map(|i| i / n).collect();
                samples.dedup();
                samples.retain(|i| *i < target.len());
                samples
            };
            let (corners, unmeasured) = (fewer(&segment.corners), fewer(&segment.unmeasured));
            Segment {
                signals: Signals {
                    interval_s: s.interval_s * n as f64,
                    time_s: thin(&s.time_s),
                    x: thin(&s.x),
                    largest_before_mm: s.largest_before_mm,
                    travel_before_mm: s.travel_before_mm,
                    v: thin(&s.v),
                    a: thin(&s.a),
                    base: thin(&s.base),
                    reading: thin(&s.reading),
                    force: thin(&s.force),
                    command: thin(&s.command),
                },
                target,
                corners,
                unmeasured,
                lead: segment.lead / n,
                from: segment.from.div_ceil(n),
            }
        });
        Self {
            segments: segments.collect(),
            theta: self.theta,
            scales: Scales {
                step_s: self.scales.step_s * n as f64,
                ..self.scales
            },
        }
    }

    /// Sizes of the motion.
    fn measure(&mut self, base: &Base) {
        let largest = |of: fn(&Signals) -> &Vec<f64>| {
            peak(self.segments.iter().flat_map(|s| s.seen(of(&s.signals)))).max(1e-9)
        };
        let (x, v, answer) = (largest(|s| &s.x), largest(|s| &s.v), largest(|s| &s.base));
        (self.scales.x, self.scales.v, self.scales.base) = (x, v, answer);
        if base.channel == Channel::Specimen && base.values[0] == 0.0 {
            // A specimen without a stiffness of its own: forces are compared with the largest.
            let force = peak(self.segments.iter().flat_map(|s| s.seen(&s.target)));
            self.scales.stiffness = (force / x).max(1e-12);
        }
    }

    /// Computes the model's answer anew for other parameters.
    pub fn set(&mut self, base: &Base, theta: [f64; 4]) {
        self.theta = theta;
        let transfer = Transfer {
            gain: theta[0],
            delay_s: 1e-3 * theta[1],
            lag_s: 1e-3 * theta[2],
            offset_mm: theta[3],
        };
        if base.channel == Channel::Actuator {
            self.scales.actuator = transfer;
            self.scales.declared.delay_s = 1e-3 * base.values[1];
            self.scales.declared.lag_s = 1e-3 * base.values[2];
        }
        // What effects say relative to the stiffness is meant relative to the true one.
        if base.channel == Channel::Specimen && theta[0] > 0.0 {
            self.scales.stiffness = theta[0];
        }
        for segment in &mut self.segments {
            let s = &mut segment.signals;
            match base.channel {
                Channel::Actuator => {
                    s.base = transfer.answer(&s.command, s.interval_s);
                    s.x.clone_from(&s.base);
                    s.v = derivative(&s.x, s.interval_s);
                    s.a = derivative(&s.v, s.interval_s);
                }
                Channel::Specimen => {
                    let force = |i: usize| {
                        theta[0] * s.reading[i]
                            + theta[1] * s.v[i]
                            + theta[2] * 1e-3 * s.a[i]
                            + theta[3]
                    };
                    s.base = (0..s.x.len()).map(force).collect();
                }
            }
        }
        self.add_known(base);
    }

    /// What the model already knows beyond its parameters.
    fn add_known(&mut self, base: &Base) {
        for element in &base.elements {
            for segment in &mut self.segments {
                let s = &mut segment.signals;
                let force = element.force(s);
                add_scaled(&mut s.base, &force, 1.0);
            }
        }
        for known in &base.known {
            let Some(candidate) = form(base.channel, known) else {
                continue;
            };
            let scales = self.scales;
            let (amplitudes, shapes) = fit_of(&candidate, known, &scales);
            for segment in &mut self.segments {
                if let Some(stage) = candidate.stage {
                    segment.signals.base = stage(&segment.signals.base, &shapes, &scales);
                }
                let columns = (candidate.columns)(&segment.signals, &shapes, &scales);
                add_columns(&mut segment.signals.base, &columns, &amplitudes, 1.0);
            }
            if base.channel == Channel::Actuator {
                for segment in &mut self.segments {
                    let s = &mut segment.signals;
                    s.x.clone_from(&s.base);
                }
            }
        }
    }

    /// How the answer changes with the free parameters: a column each, segment by segment.
    pub fn base_columns(&self, base: &Base, segment: &Segment) -> Vec<Vec<f64>> {
        let s = &segment.signals;
        let scaled = |x: &[f64], factor: f64| x.iter().map(|x| factor * x).collect::<Vec<f64>>();
        let column = |f: &FreeParameter| match (base.channel, f.index) {
            (_, 3) => vec![1.0; s.base.len()],
            (Channel::Specimen, 0) => s.reading.clone(),
            (Channel::Specimen, 1) => s.v.clone(),
            (Channel::Specimen, _) => scaled(&s.a, 1e-3),
            (Channel::Actuator, 0) => s
                .base
                .iter()
                .map(|y| (y - self.theta[3]) / self.theta[0])
                .collect(),
            (Channel::Actuator, 1) => scaled(&s.v, -1e-3),
            (Channel::Actuator, _) => {
                scaled(&lagged(&s.v, 1e-3 * self.theta[2], s.interval_s), -1e-3)
            }
        };
        base.free.iter().map(column).collect()
    }

    /// What effects see behind the stages among them, which pass the base on changed.
    pub fn staged<'s>(
        &self,
        segment: &'s Segment,
        effects: &[(Candidate, &[f64])],
        scales: &Scales,
    ) -> Cow<'s, Signals> {
        let mut signals = Cow::Borrowed(&segment.signals);
        for (candidate, shapes) in effects {
            if let Some(stage) = candidate.stage {
                let s = signals.to_mut();
                if candidate.channel == Channel::Actuator {
                    s.base = stage(&s.base, shapes, scales);
                    s.x.clone_from(&s.base);
                    s.v = derivative(&s.x, s.interval_s);
                    s.a = derivative(&s.v, s.interval_s);
                } else {
                    // Between two samples a straight line averages the noise of both: a fit would see a gain in that.
                    let rough = s
                        .reading
                        .iter()
                        .zip(&s.x)
                        .map(|(r, x)| self.theta[0] * (r - x));
                    let rough: Vec<f64> = rough.collect();
                    add_scaled(&mut s.base, &rough, -1.0);
                    s.base = stage(&s.base, shapes, scales);
                    let whole = (shapes[0] / scales.step_s).round() * scales.step_s;
                    add_scaled(&mut s.base, &stage(&rough, &[whole], scales), 1.0);
                    // A reading that is late is late for every force in it.
                    for x in [&mut s.x, &mut s.v, &mut s.a] {
                        *x = stage(x, shapes, scales);
                    }
                }
            }
        }
        signals
    }

    /// How the answer behind the stages changes with the free parameters.
    pub fn staged_columns(
        &self,
        base: &Base,
        segment: &Segment,
        effects: &[(Candidate, &[f64])],
    ) -> Vec<Vec<f64>> {
        let mut columns = self.base_columns(base, segment);
        let mut here = segment.signals.base.clone();
        for (candidate, shapes) in effects {
            let Some(stage) = candidate.stage else {
                continue;
            };
            let after = stage(&here, shapes, &self.scales);
            for (free, column) in base.free.iter().zip(&mut columns) {
                let (moved, step) = if candidate.instead_of == Some(free.index) {
                    // The parameter and the effect's shape are one sum, in ms and in s.
                    let step = 1e-6;
                    let moved: Vec<f64> = shapes.iter().map(|s| s + step).collect();
                    (stage(&here, &moved, &self.scales), 1e3 * step)
                } else {
                    // A small step along the column, through the stage.
                    let step = 1e-3 * self.scales.base / peak(&*column).max(f64::MIN_POSITIVE);
                    let mut moved = here.clone();
                    add_scaled(&mut moved, column, step);
                    (stage(&moved, shapes, &self.scales), step)
                };
                *column = difference_quotient(&moved, &after, step);
            }
            here = after;
        }
        columns
    }

    /// The answer with effects: the base behind their stages, and their columns.
    pub fn answer(&self, segment: &Segment, effects: &[FittedEffect], scales: &Scales) -> Vec<f64> {
        let stages: Vec<(Candidate, &[f64])> = effects
            .iter()
            .map(|e| (e.candidate, e.shapes.as_slice()))
            .collect();
        let signals = self.staged(segment, &stages, scales);
        let mut y = signals.base.clone();
        for effect in effects {
            let columns = (effect.candidate.columns)(&signals, &effect.shapes, scales);
            add_columns(&mut y, &columns, &effect.amplitudes, 1.0);
        }
        y
    }

    /// Measured less modelled, segment by segment, from the first sample on that is looked at; 0 where nobody measured.
    pub fn residuals(&self, effects: &[FittedEffect], scales: &Scales) -> Vec<Vec<f64>> {
        let residual = |s: &Segment| {
            let y = self.answer(s, effects, scales);
            s.measured(difference(s.seen(&s.target), s.seen(&y)))
        };
        self.segments.iter().map(residual).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::library::candidates;
    use crate::model::{Declared, Model, SpecimenModel};
    use crate::signals::rms;
    use plant::Effect;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn a_skew_of_half_a_sample_does_not_quieten_the_reading() {
        let h = 1e-3;
        let mut rng =
            <rand_xoshiro::Xoshiro256PlusPlus as rand_core::SeedableRng>::seed_from_u64(5);
        let moves: Vec<f64> = (0..8000).map(|i| (0.02 * f64::from(i)).sin()).collect();
        let noise: Vec<f64> = (0..8000)
            .map(|_| 1e-3 * Distribution::<f64>::sample(&StandardNormal, &mut rng))
            .collect();
        let record = Recording {
            time_s: (0..8000).map(|i| f64::from(i) * h).collect(),
            displacement_mm: Some(moves.iter().zip(&noise).map(|(x, n)| x + n).collect()),
            force_n: Some(moves.iter().map(|x| 100.0 * x).collect()),
            ..Recording::default()
        };
        let stiffness = Declared {
            value: 100.0,
            tolerance: 1.0,
        };
        let model = Model {
            specimen: Some(SpecimenModel {
                stiffness_n_per_mm: Some(stiffness),
                ..SpecimenModel::default()
            }),
            ..Model::default()
        };
        let base = Base::of(&model, Channel::Specimen).unwrap();
        let problem = Problem::new(&base, &[record], 20.0, &[]).unwrap();
        let candidate = candidates(Channel::Specimen)
            .into_iter()
            .find(|c| c.effect == Effect::ChannelSkew)
            .unwrap();
        // What the motion makes of a skew is taken off: what is left is what becomes of the noise.
        let left = |skew_s: f64| {
            let skew = FittedEffect {
                candidate,
                shapes: vec![skew_s],
                amplitudes: Vec::new(),
            };
            let late = crate::signals::delayed(&moves, skew_s, h);
            let answer = problem.answer(&problem.segments[0], &[skew], &problem.scales);
            let noise = answer.iter().zip(late).map(|(y, x)| y - 100.0 * x);
            rms(&[noise.collect()])
        };
        let ratio = left(0.5 * h) / left(0.0);
        assert!((0.95..1.05).contains(&ratio), "{ratio}");
    }
}
