//! An element in a model file.

use crate::laws::specimen::BEGINS;
use crate::laws::specimen::element::{Element, Law};
use crate::laws::specimen::track::{MotionScales, Track};
use crate::numbers::signals::Signals;
use crate::record::refusal::Refusal;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An element beside the declared specimen that an earlier diagnosis added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SavedElement {
    /// What it was named.
    pub name: plant::Effect,
    /// Its law.
    pub law: Law,
    /// Its force at full strength, N; of springs N/mm.
    pub strength: f64,
    /// Shapes, in the order that the law's description gives, mm, mm/s, s.
    pub shape: [f64; 4],
    /// Half range of the motion that it was found in, mm: what powers of displacement are relative to.
    pub reference_mm: f64,
    /// Top speed of that motion, mm/s: what powers of speed are relative to.
    pub reference_mm_per_s: f64,
    /// Where the displacement was cut off as it was found, Hz: in a record the element acts on the motion below it, since
    /// a force that is steep at rest makes much of the noise of a speed; or on the whole band of one that moves faster. A motion
    /// without noise needs none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cutoff_hz: Option<f64>,
    /// Whether it acts; what comes nearest where nothing can be vouched for is saved switched off.
    #[serde(default = "enabled", skip_serializing_if = "Clone::clone")]
    pub enabled: bool,
}

const fn enabled() -> bool {
    true
}

impl SavedElement {
    /// The places of its shapes that a fit moves.
    pub(crate) fn free_shapes(&self) -> Vec<usize> {
        self.element().movable().iter().map(|m| m.0).collect()
    }

    const fn element(&self) -> Element {
        Element {
            law: self.law,
            shape: self.shape,
        }
    }

    /// Its force where it slides, N, and the way in which that builds up, mm; `None` for what does not slide at one force.
    pub fn sliding(&self) -> Option<[f64; 2]> {
        let element = self.element();
        let level = element.level(self.reference_mm_per_s);
        let way = match self.law {
            // The part in series gives way at this force.
            Law::InSeries => level * self.shape[0],
            _ => element.yields_at(),
        };
        (self.law.slides() && level > 0.0).then_some([self.strength * level, way])
    }

    /// Whether its numbers can be what they stand for.
    ///
    /// # Errors
    /// A number that is not finite, references that are not above 0, a shape that its law cannot have.
    pub fn check(&self) -> Result<(), Refusal> {
        let place = format!("specimen.elements: {}", self.name);
        let finite = self.strength.is_finite() && self.shape.iter().all(|s| s.is_finite());
        let above = |x: f64| x.is_finite() && x > 0.0;
        let first = match self.law {
            Law::Away | Law::Square | Law::Beyond | Law::SizeOfSpeed => true,
            _ => self.shape[0] > 0.0,
        };
        if let Some(hz) = self.cutoff_hz.filter(|hz| !above(*hz)) {
            return Err(Refusal::new(format!(
                "{place}: cutoff_hz = {hz} is refused: accepted is a finite number above 0"
            )));
        }
        if self.law == Law::Distributed && !BEGINS.contains(&self.shape[1]) {
            return Err(Refusal::new(format!(
                "{place}: shape = {:?} is refused: where its sliders begin, the second number, is from {} up to {} of the largest \
                 yield displacement",
                self.shape, BEGINS.start, BEGINS.end
            )));
        }
        if finite && first && above(self.reference_mm) && above(self.reference_mm_per_s) {
            return Ok(());
        }
        Err(Refusal::new(format!(
            "{place} is refused: strength = {}, shape = {:?}, reference_mm = {}, reference_mm_per_s = {}: accepted are \
             finite numbers, and references and the first shape above 0",
            self.strength, self.shape, self.reference_mm, self.reference_mm_per_s
        )))
    }

    /// Its force over a motion, N; of what was before it only the largest displacement counts.
    pub fn force(&self, s: &Signals) -> Vec<f64> {
        if let Some(hz) = self.cutoff_hz {
            let track = Track::below(s, hz);
            let force = self.along(&track);
            return force.into_iter().step_by(track.fine).collect();
        }
        let track = Track {
            interval_s: s.interval_s,
            fine: 1,
            x: s.x.clone(),
            largest_before_mm: s.largest_before_mm,
            travel_before_mm: s.travel_before_mm,
            v: s.v.clone(),
            a: Vec::new(),
            first: 0,
            time_s: s.time_s.clone(),
            force: Vec::new(),
            unmeasured: Vec::new(),
        };
        self.along(&track)
    }

    /// Its force over a track, N.
    pub fn along(&self, track: &Track) -> Vec<f64> {
        let sizes = MotionScales {
            x: self.reference_mm,
            v: self.reference_mm_per_s,
            ..MotionScales::default()
        };
        let mut force = self.element().force(track, &sizes);
        force.iter_mut().for_each(|f| *f *= self.strength);
        force
    }
}
