//! The only table of what a specimen may have besides its declared parameters: a row per law, a file per family.
//!
//! A row gives the law's equation, the shapes to search, and its price in nats: how rare such a cause is, and a little
//! for each additional number. Several rows may share a name: the name is read from the final shape.

mod damping;
mod friction;
mod gap;
mod hysteresis;
mod reading;
mod spring;

use super::row::{Form, Row, Sizes};
use crate::laws::specimen::element::Law;

/// All laws for a motion of these sizes. Laws of time alone are included only if the records have a rest. `dashpot`:
/// one is declared, and none is outside its tolerances.
pub fn table(sizes: &Sizes, rests: bool, dashpot: bool) -> Vec<Row> {
    let mut all = friction::rows(sizes);
    all.extend(hysteresis::rows(sizes));
    all.extend(gap::rows(sizes));
    all.extend(spring::rows(sizes));
    all.extend(damping::rows(sizes));
    all.extend(reading::rows(sizes, rests));
    for row in &mut all {
        let form = row.form;
        let kept = Row {
            grid: Vec::new(),
            ..row.clone()
        };
        if matches!(form, Form::Element(_)) {
            row.grid.retain(|shape| kept.is_sound(*shape, sizes));
        }
    }
    // At one speed, a force that builds up in time cannot be told from friction that builds up along the travel, which
    // is more common; but it remains if it replaces a declared dashpot.
    let takes_time = |r: &Row| {
        matches!(r.form, Form::Element(Law::Relaxing | Law::InSeries))
            && !(dashpot && r.frees == Some(1))
    };
    all.retain(|r| !(r.grid.is_empty() || sizes.one_speed && takes_time(r)));
    all
}
