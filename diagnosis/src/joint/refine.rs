//! A second search where a declared parameter stands at an end of its tolerances: it wants to go further, and next to a large
//! element what it would take does not show. Squares are then measured by what the best model leaves, no longer by what the
//! declared one did.

use super::polish::Polished;
use super::set::{DECLARED, Library};
use crate::criteria::CERTAIN;

/// Searches again, if freeing what stands at an end takes as much off as a name must; the library measures by the finer scale
/// from then on. `None` where it does not.
pub fn refine(
    library: &mut Library,
    best: &Polished,
    search: impl Fn(&Library) -> Option<Polished>,
) -> Option<Polished> {
    let set = library.add_polished(best);
    let ends = at_their_ends(library, &set.moved, &library.strengths(&set)?);
    if !ends.contains(&true) {
        return None;
    }
    let freed = super::set::ElementSet {
        moved: std::array::from_fn(|i| set.moved[i] || ends[i]),
        ..set.clone()
    };
    let (held, loose) = (
        library.cross_validated(&set)?,
        library.cross_validated(&freed)?,
    );
    let before = library.measure_by(&held);
    if library.log_ratio(&loose) > library.log_ratio(&held) - CERTAIN.ln() {
        library.measure(before);
        return None;
    }
    search(library)
}

/// Room at the end of a tolerance, as a share of it.
const ROOM: f64 = 1e-3;

/// Which of the held parameters that have a tolerance stand at an end of it.
fn at_their_ends(
    library: &Library,
    moved: &[bool; DECLARED],
    strengths: &[f64],
) -> [bool; DECLARED] {
    std::array::from_fn(|i| {
        let bound = library.parameter(i, false);
        let room = ROOM * (bound.high - bound.low);
        let at = |end: f64| (strengths[i] - end).abs() <= room;
        // Nothing is less than no damping and no mass.
        let least = library.parameter(i, true).low;
        !moved[i] && room > 0.0 && (at(bound.high) || at(bound.low) && bound.low > least)
    })
}
