//! The unit of a key.

use super::value::ValueKind;
use experiment::files::units;

/// Units of keys whose names do not end with them, by the end of the path. Several: those of a list's numbers, in their order.
const UNITS: [(&str, &str); 21] = [
    ("loop.substeps", "steps"),
    ("loop.solve_substeps", "steps"),
    ("compensation.inverse", "s, s², s³"),
    ("compensation.own", VARIES),
    ("compensation.amb.gains", "1/(m² s), s/m², s³/m², s⁵/m²"),
    ("compensation.hydraulic.a1_b0", "N/(m s³)"),
    ("compensation.hydraulic.a2", "N/m"),
    ("compensation.hydraulic.a3", "rad/s"),
    ("compensation.hydraulic.b1", "rad/s"),
    ("compensation.hydraulic.b2", "rad²/s²"),
    (
        "compensation.hydraulic.spread",
        "N/m, rad/s, rad/s, rad²/s²",
    ),
    ("sensors.bits", "bit"),
    ("remainder.strengths", VARIES),
    ("remainder.range.seconds", "s"),
    ("actuator.remainder.range.other", "N"),
    ("specimen.remainder.range.other", "mm"),
    ("coupled.structure.influence", "1, rad/m"),
    ("coupled.observer.process", "m/s², rad/s²"),
    (".stiffness", VARIES),
    (".damping", VARIES),
    (".mass", VARIES),
];

/// It differs from number to number, or from method to method: the meaning says which.
pub(super) const VARIES: &str = "varies";

/// The unit: `1` for a plain number, empty where the key holds no numbers of its own.
pub(super) fn of(path: &str, kind: &ValueKind) -> &'static str {
    match kind {
        ValueKind::Text
        | ValueKind::Texts
        | ValueKind::Flag
        | ValueKind::Name
        | ValueKind::Table
        | ValueKind::Tables => return "",
        ValueKind::Number
        | ValueKind::Integer
        | ValueKind::Numbers
        | ValueKind::List(_)
        | ValueKind::Matrix(_)
        | ValueKind::DeclaredMatrix
        | ValueKind::Declared => {}
    }
    let own = UNITS.iter().find(|(end, _)| path.ends_with(end));
    let own = own.map(|(_, unit)| *unit);
    own.or_else(|| units::of_key(path)).unwrap_or("1")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_of_the_list_belongs_to_a_key() {
        let groups = super::super::all();
        for (end, unit) in UNITS {
            let mut keys = groups.iter().flat_map(|group| &group.keys);
            assert!(
                keys.any(|key| key.path.ends_with(end) && key.unit == unit),
                "{end}"
            );
        }
    }
}
