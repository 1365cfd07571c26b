//! A specimen's record as seen by the laws: a motion without its noise, and a law's columns over it.

use super::row::{Form, Row, Sizes};
use crate::laws::specimen::element::Element;
use crate::laws::specimen::track::{MotionScales, Track};
use crate::model::base::Base;
use crate::numbers::signals::{
    Scales, Signals, Transfer, add_columns, clear, delayed, difference, peak,
};
use crate::prepare::noise::hum::MAINS_HZ;
use crate::record::spectrum;

/// A record's motion.
#[derive(Debug)]
pub struct Motion {
    /// Starts before the record, with enough samples a cycle for laws with memory.
    pub track: Track,
    signals: Signals,
    declared: [Vec<f64>; 4],
    /// Parameters of the specimen whose response is in `signals`.
    acted_on: [f64; 4],
}

impl Motion {
    /// From a track, with the declared specimen's response to it.
    pub fn new(track: Track, base: &Base) -> Self {
        let declared = track.declared_columns();
        let mut answer = vec![0.0; track.x.len()];
        add_columns(&mut answer, &declared, &base.values, 1.0);
        let from = track.time_s[0] - track.interval_s * track.first as f64;
        let signals = Signals {
            interval_s: track.interval_s,
            time_s: (0..track.x.len())
                .map(|i| (from + track.interval_s * i as f64).max(0.0))
                .collect(),
            x: track.x.clone(),
            largest_before_mm: track.largest_before_mm,
            travel_before_mm: track.travel_before_mm,
            v: track.v.clone(),
            a: track.a.clone(),
            base: answer,
            reading: track.x.clone(),
            force: Vec::new(),
            command: Vec::new(),
        };
        Self {
            track,
            signals,
            declared,
            acted_on: base.values,
        }
    }

    /// The declared parameters' columns, from before the record on.
    pub fn declared(&self) -> Vec<Vec<f64>> {
        self.declared.to_vec()
    }

    /// A law's columns, from before the record on, for effects on a specimen of these parameters and on the force of `others`
    /// beside it. A stage's column is what it makes of that response, minus that response.
    pub fn columns(
        &self,
        row: &Row,
        shape: [f64; 4],
        sizes: &Sizes,
        on: &[f64; 4],
        others: Option<&[f64]>,
    ) -> Vec<Vec<f64>> {
        match row.form {
            Form::Parameter(_) => Vec::new(),
            Form::Element(law) => vec![Element { law, shape }.force(&self.track, &sizes.motion)],
            Form::Effect(c) => {
                let scales = Scales {
                    step_s: self.track.interval_s,
                    ..sizes.on(on).scales
                };
                let refitted;
                let signals = if *on == self.acted_on && others.is_none() {
                    &self.signals
                } else {
                    let mut base =
                        others.map_or_else(|| vec![0.0; self.track.x.len()], <[f64]>::to_vec);
                    add_columns(&mut base, &self.declared, on, 1.0);
                    refitted = Signals {
                        base,
                        ..self.signals.clone()
                    };
                    &refitted
                };
                let Some(stage) = c.stage else {
                    return (c.columns)(signals, &shape, &scales);
                };
                let after = stage(&signals.base, &shape, &scales);
                vec![difference(&after, &signals.base)]
            }
        }
    }

    /// Strongest line near the mains frequency in the declared model's residual, Hz.
    pub fn line_hz(&self) -> Option<f64> {
        let mut left = difference(&self.track.force, &self.track.span_of(&self.signals.base));
        clear(&mut left, &self.track.unmeasured);
        let interval_s = self.track.interval_s * self.track.fine as f64;
        spectrum::line_hz(&left, interval_s, MAINS_HZ[0], MAINS_HZ[1]).map(|l| l.0)
    }

    /// A delayed signal.
    pub fn late(&self, x: &[f64], late_s: f64) -> Vec<f64> {
        delayed(x, late_s, self.track.interval_s)
    }
}

/// Sizes of training records, the reference for every record.
pub fn sizes(
    motion: MotionScales,
    motions: &[Motion],
    base: &Base,
    line_hz: Option<f64>,
    one_speed: bool,
) -> Sizes {
    let seen = |m: &Motion| m.signals.base[m.track.first..].to_vec();
    let answers: Vec<f64> = motions.iter().flat_map(seen).collect();
    let force = peak(motions.iter().flat_map(|m| &m.track.force)).max(1e-12);
    let largest = peak(motions.iter().flat_map(|m| &m.track.x[m.track.first..])).max(1e-12);
    let answer = peak(&answers);
    let stiffness = if base.values[0] == 0.0 {
        force / largest
    } else {
        base.values[0]
    };
    let unit = Transfer {
        gain: 1.0,
        ..Transfer::default()
    };
    Sizes {
        motion,
        one_speed,
        scales: Scales {
            x: largest,
            v: motion.v,
            base: if answer > 0.0 { answer } else { force },
            stiffness,
            seconds: motion.seconds,
            interval_s: motion.interval_s,
            step_s: motion.interval_s,
            actuator: unit,
            declared: unit,
            line_hz,
        },
    }
}
