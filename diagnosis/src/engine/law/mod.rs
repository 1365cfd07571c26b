//! The one table of what a specimen's channel may have beside its declared parameters: one row a law, one file a family.
//!
//! A row says what the law is computed by, over which shapes the search looks, and what it costs, in nats: how rarely such a cause
//! is met, and a little for each number that it brings. Several rows may have one name: the name is read off the shape at the end.

mod damping;
mod friction;
mod gap;
mod hysteresis;
mod reading;
mod spring;

use super::row::{Form, Row, Sizes};
use crate::laws::specimen::element::Law;

/// Every law for a motion of these sizes. What depends on time alone is asked about only where records have a rest. `dashpot`: one is
/// declared, and none is outside its tolerances.
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
    // At one speed a force that builds up in time is friction that builds up along the way, and that is commoner; but not where it
    // takes the place of a dashpot that is declared.
    let takes_time = |r: &Row| {
        matches!(r.form, Form::Element(Law::Relaxing | Law::InSeries))
            && !(dashpot && r.frees == Some(1))
    };
    all.retain(|r| !(r.grid.is_empty() || sizes.one_speed && takes_time(r)));
    all
}
