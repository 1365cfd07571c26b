//! One channel of the rig: records in its terms, the declared parameters, and the model's response.

use crate::laws::library;
use crate::laws::library::saved::fit_of;
use crate::model::base::{Base, FreeParameter};
use crate::numbers::reflected::Motion;
use crate::numbers::signals::{
    Scales, Signals, Transfer, add_columns, add_scaled, derivative, difference, lagged, peak,
};
use crate::prepare::noise::hum::without_hum;
use crate::prepare::segment::{Segment, settling};
use crate::record::recording::Recording;
use crate::record::spectrum;
use crate::record::travel;
use plant::Channel;

/// Records of one channel.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The records.
    pub segments: Vec<Segment>,
    /// The parameters with which `signals.base` was computed.
    pub theta: [f64; 4],
    /// Reference sizes for shapes.
    pub scales: Scales,
}

/// A channel's view of a recording; `motion_mm` is its displacement if known better than by its reading.
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
        // The motion is only known from the record's beginning.
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
                Some(x) => Motion::of(&x[x.len() - whole.time_s.len()..], h),
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
    let low_passed = |f: &Vec<f64>| spectrum::low_passed(f, h, cutoff_hz);
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
            force: whole.force_n.as_ref().map_or_else(none, low_passed),
            reading,
            command,
        },
        target,
        unmeasured: r.unmeasured().iter().map(|i| lead + i).collect(),
        lead,
        from: lead + settling(base, r, lead),
    })
}

impl Problem {
    /// The channel's view of `recordings`; `None` if a signal is missing. `cutoff_hz` separates the displacement from
    /// its noise (specimen only); `motions` are displacements, mm, where a model of the actuator gives them better than
    /// low-passed readings.
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
        // Known effects are relative to the size of the motion, now better known from the actuator's response.
        problem.measure(base);
        problem.set(base, base.values);
        problem.measure(base);
        Some(problem)
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

    /// Recomputes the model's response for other parameters.
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
        // Effects given relative to the stiffness refer to the true one.
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

    /// Adds what the model already knows beyond its parameters.
    fn add_known(&mut self, base: &Base) {
        for element in &base.elements {
            for segment in &mut self.segments {
                let s = &mut segment.signals;
                let force = element.force(s);
                add_scaled(&mut s.base, &force, 1.0);
            }
        }
        for known in &base.known {
            let Some(effect) = library::known(base.channel, known) else {
                continue;
            };
            let scales = self.scales;
            let (amplitudes, shapes) = fit_of(base.channel, known, &scales);
            for segment in &mut self.segments {
                if let Some(stage) = effect.stage {
                    segment.signals.base = stage(&segment.signals.base, &shapes, &scales);
                }
                let columns = (effect.columns)(&segment.signals, &shapes, &scales);
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

    /// Change of the response with the free parameters, a column each, segment by segment.
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

    /// Measured minus modelled, by segment, from the first sample considered; 0 where nothing was measured.
    pub fn residuals(&self) -> Vec<Vec<f64>> {
        let residual = |s: &Segment| {
            let left = difference(s.seen(&s.target), s.seen(&s.signals.base));
            s.measured(left)
        };
        self.segments.iter().map(residual).collect()
    }
}
