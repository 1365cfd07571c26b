//! The quantities of recorded data, and the units that each may have.

/// A unit, and its value in SI.
pub type UnitOf = (&'static str, f64);

/// A rotation's displacement is an angle.
const LENGTH: &[UnitOf] = &[
    ("m", 1.0),
    ("mm", 1e-3),
    ("cm", 1e-2),
    ("um", 1e-6),
    ("in", 0.0254),
    (ANGLE, 1.0),
];
/// The unit of a rotation.
pub const ANGLE: &str = "rad";
/// The unit of a moment.
pub const MOMENT: &str = "n_m";
/// Pounds according to NIST SP 811.
const FORCE: &[UnitOf] = &[
    ("n", 1.0),
    ("kn", 1e3),
    ("mn", 1e6),
    ("lbf", 4.448_222),
    ("kip", 4448.222),
    (MOMENT, 1.0),
    ("1", 1.0),
];
/// For a rotation as well, like the next.
const SPEED: &[UnitOf] = &[("m_per_s", 1.0), ("mm_per_s", 1e-3), ("rad_per_s", 1.0)];
const ACCELERATION: &[UnitOf] = &[("m_per_s2", 1.0), ("g", 9.80665), ("rad_per_s2", 1.0)];
const ENERGY: &[UnitOf] = &[("j", 1.0)];
/// Dimensionless.
pub const PLAIN: &[UnitOf] = &[("1", 1.0)];

/// The known quantities, and the units that each may have; the first is the one written.
pub const QUANTITIES: &[(&str, &[UnitOf])] = &[
    (
        "time",
        &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("min", 60.0)],
    ),
    ("command", LENGTH),
    ("target", LENGTH),
    ("displacement", LENGTH),
    ("force", FORCE),
    ("estimated_displacement", LENGTH),
    ("estimated_force", FORCE),
    ("velocity", SPEED),
    ("acceleration", ACCELERATION),
    ("ground_acceleration", &[("m_per_s2", 1.0), ("g", 9.80665)]),
    ("added_damping", &[("n_s_per_m", 1.0)]),
    ("gain", PLAIN),
    ("energy_error", ENERGY),
    ("energy_error_hsem", ENERGY),
    ("energy_error_stiffness", ENERGY),
    ("energy_input", ENERGY),
    ("energy_ratio", PLAIN),
    ("step", PLAIN),
    ("flags", PLAIN),
];

/// The quantity that a name begins with; its axis and unit if the rest of the name gives both.
pub type Known<'a> = (&'static str, &'static [UnitOf], Option<(usize, &'a str)>);

/// The number of an axis in a name, from its index: none for the first.
pub fn axis_number(index: usize) -> String {
    match index {
        0 => String::new(),
        index => (index + 1).to_string(),
    }
}

/// The units that a quantity may have.
pub fn units_of(quantity: &str) -> &'static [UnitOf] {
    let found = QUANTITIES.iter().find(|(name, _)| *name == quantity);
    found.map_or(PLAIN, |(_, units)| units)
}

/// The meaning of a name in a header.
pub fn known(name: &str) -> Option<Known<'_>> {
    // The longest matching quantity: `energy_error_hsem_j` is not `energy_error` in `hsem_j`.
    let (quantity, units, rest) = QUANTITIES
        .iter()
        .filter_map(|(quantity, units)| Some((*quantity, *units, name.strip_prefix(quantity)?)))
        .max_by_key(|(quantity, ..)| quantity.len())?;
    let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let axis = match &rest[..digits] {
        "" => Some(1),
        number => number.parse().ok().filter(|n| *n >= 1),
    };
    let unit = rest[digits..].strip_prefix('_');
    let says = axis
        .zip(unit)
        .filter(|(_, unit)| units.iter().any(|(text, _)| text == unit));
    Some((quantity, units, says))
}
