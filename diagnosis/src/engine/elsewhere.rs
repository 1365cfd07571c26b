//! Another cut-off, judged with the model that was found: what is missing hides how fast a rig moves.

use super::cutoff;
use super::motion::Motion;
use super::search::DECLARED;
use super::specimen::{SpecimenData, SpecimenModelFit, model_columns, spans};
use super::unknowns::{Freedom, Unknown};
use crate::criteria::CUTOFF_ROOM;
use crate::laws::specimen::track::Track;
use crate::numbers::signals::{add_columns, difference_quotient};

/// Ratio of cut-offs that is worth another search.
const ELSEWHERE: f64 = 1.3;
/// What a cut-off leaves over what the best leaves, as squares, if it cuts off motion.
const MOTION_CUT: f64 = 1.3;

impl SpecimenData<'_> {
    /// The same data below another cut-off, if this model puts the limit between motion and noise clearly elsewhere.
    pub fn cut_off_elsewhere(&self, fit: &SpecimenModelFit) -> Option<Self> {
        // A delay of the force is judged at every cut-off by the declared columns, which the ladder has without it.
        if self.late_s(fit).is_some() {
            return None;
        }
        let is_shape = |f: &Freedom| matches!(f.unknown, Unknown::Shape(..));
        let shapes: Vec<(SpecimenModelFit, f64)> =
            (self.freedoms(fit).iter().filter(|f| is_shape(f)))
                .map(|f| f.moved(fit))
                .collect();
        let own = |t: &Track| {
            let m = Motion::new(t.clone(), self.base);
            let answer = |fit: &SpecimenModelFit| {
                let own = model_columns(&m, &self.rows, &fit.terms, &self.sizes, &fit.acts_on());
                let mut y = vec![0.0; t.x.len()];
                add_columns(&mut y, &own[DECLARED..], &fit.strengths.concat(), 1.0);
                (own, y)
            };
            let (mut all, here) = answer(fit);
            all.drain(..DECLARED);
            // Shapes were fitted at the present cut-off, and would speak for it.
            let slope = |(moved, step): &(SpecimenModelFit, f64)| {
                difference_quotient(&answer(moved).1, &here, *step)
            };
            all.extend(shapes.iter().map(slope));
            all
        };
        let ladder = cutoff::ladder(self.base, &spans(&self.moving)?, own);
        let cutoff_hz = ladder.lowest(CUTOFF_ROOM)?;
        let cut = ladder.lowest(MOTION_CUT)? > ELSEWHERE * self.cutoff_hz;
        let noisy = cutoff_hz * ELSEWHERE < self.cutoff_hz;
        let again = || Self::below(cutoff_hz, self.base, self.moving.clone(), self.motion_has);
        // A term is a place in the table of laws.
        let same_laws = |other: &Self| other.rows.len() == self.rows.len();
        (cut || noisy).then(again).flatten().filter(same_laws)
    }
}
