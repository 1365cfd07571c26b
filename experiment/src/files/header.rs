//! Column names as laboratories write them: `Time (s)`, `Cmd [mm]`, `Force/kN`, `displacement_mm`.

/// A column's name, and its unit if it states one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    /// The cell as written in the file.
    pub text: String,
    /// The name without its unit, in lower case, with `_` between its words.
    pub base: String,
    /// The unit as this program writes it; empty if none is stated.
    pub unit: String,
}

/// Units as this program writes them, and as others do.
const UNITS: &[(&str, &[&str])] = &[
    ("s", &["s", "sec", "secs", "second", "seconds", "sek"]),
    ("ms", &["ms", "msec", "millisecond", "milliseconds"]),
    // The micro sign and the Greek letter are different characters.
    (
        "us",
        &[
            "us",
            "\u{b5}s",
            "\u{3bc}s",
            "usec",
            "microsecond",
            "microseconds",
        ],
    ),
    ("min", &["min", "mins", "minute", "minutes"]),
    ("m", &["m", "meter", "metre", "meters", "metres"]),
    (
        "mm",
        &[
            "mm",
            "millimeter",
            "millimetre",
            "millimeters",
            "millimetres",
        ],
    ),
    (
        "um",
        &[
            "um",
            "\u{b5}m",
            "\u{3bc}m",
            "micron",
            "microns",
            "micrometer",
            "micrometre",
        ],
    ),
    ("cm", &["cm"]),
    ("in", &["in", "inch", "inches"]),
    ("n", &["n", "newton", "newtons"]),
    ("kn", &["kn", "kilonewton", "kilonewtons"]),
    ("mn", &["mn", "meganewton"]),
    ("lbf", &["lbf", "lb"]),
    ("kip", &["kip", "kips"]),
    ("rad", &["rad", "radian", "radians"]),
    ("n_m", &["n_m", "nm", "n m", "n*m"]),
    ("m_per_s", &["m_per_s", "m/s"]),
    ("mm_per_s", &["mm_per_s", "mm/s"]),
    ("rad_per_s", &["rad_per_s", "rad/s"]),
    ("rad_per_s2", &["rad_per_s2", "rad/s2", "rad/s^2"]),
    ("g", &["g"]),
    (
        "gal",
        &[
            "gal",
            "cm/s2",
            "cm/s^2",
            "cm/s²",
            "cm/s/s",
            "cm/sec2",
            "cm/sec^2",
            "cm/sec/sec",
        ],
    ),
    (
        "m_per_s2",
        &[
            "m_per_s2",
            "m/s2",
            "m/s^2",
            "m/s²",
            "m/s/s",
            "m/sec2",
            "m/sec/sec",
        ],
    ),
    ("1", &["1", "-", "volt", "v"]),
];

/// Names as this program writes them, and as laboratories do.
const ALIASES: &[(&str, &[&str])] = &[
    (
        "time",
        &[
            "time",
            "t",
            "elapsed_time",
            "running_time",
            "test_time",
            "zeit",
            "temps",
        ],
    ),
    (
        "command",
        &[
            "command",
            "cmd",
            "reference",
            "ref",
            "setpoint",
            "set_point",
            "desired",
            "demand",
            "soll",
            "axial_command",
            "sollweg",
            "weg_soll",
        ],
    ),
    (
        "displacement",
        &[
            "displacement",
            "disp",
            "displ",
            "position",
            "pos",
            "stroke",
            "lvdt",
            "weg",
            "axial_displacement",
            "measured_displacement",
            "istweg",
            "weg_ist",
        ],
    ),
    (
        "force",
        &[
            "force",
            "load",
            "load_cell",
            "kraft",
            "axial_force",
            "measured_force",
        ],
    ),
    (
        "acc",
        &[
            "acc",
            "acceleration",
            "ground_acceleration",
            "acc_x",
            "accel",
            "ag",
            "a_g",
            "beschleunigung",
        ],
    ),
];

/// Words that suggest a quantity, the stronger first: a displacement command is a command.
const WORDS: &[(&str, &[&str])] = &[
    (
        "command",
        &[
            "command",
            "cmd",
            "setpoint",
            "reference",
            "demand",
            "desired",
            "soll",
        ],
    ),
    (
        "displacement",
        &["disp", "position", "stroke", "lvdt", "weg"],
    ),
    ("force", &["force", "load", "kraft"]),
];

impl Header {
    /// From a cell of the header, with the cell beneath it if there is a row of units.
    pub fn of(text: &str, beneath: Option<&str>) -> Self {
        let text = text.trim();
        let (base, mut unit) = split(text);
        if unit.is_empty() {
            unit = beneath.and_then(unit_named).unwrap_or("").to_owned();
        }
        Self {
            text: text.to_owned(),
            base: words(base),
            unit,
        }
    }

    /// `quantity_unit`, as this program writes it. `known`: true if a name already has that form.
    pub fn name(&self, known: impl Fn(&str) -> bool) -> String {
        let plain = words(&self.text);
        if self.unit.is_empty() || known(&plain) {
            return plain;
        }
        let base = alias(&self.base).unwrap_or(&self.base);
        format!("{base}_{}", self.unit)
    }

    /// What a column without a unit probably is, by its name.
    pub fn likely(&self) -> Option<&'static str> {
        alias(&self.base)
    }

    /// The quantity suggested by a word in the name, as in `Ch 1 Displacement Command`: reason to ask, not to use it.
    pub fn suggested(&self) -> Option<&'static str> {
        let found = WORDS
            .iter()
            .find(|(_, words)| words.iter().any(|w| self.base.contains(w)));
        found.map(|(quantity, _)| *quantity)
    }

    /// True if its unit is one of acceleration.
    pub fn is_acceleration(&self) -> bool {
        ["g", "m_per_s2", "gal"].contains(&self.unit.as_str())
    }
}

/// The unit named in a text, if any.
pub fn unit_named(text: &str) -> Option<&'static str> {
    let bare = text.trim().trim_matches(|c| "()[]{}".contains(c)).trim();
    let lower = bare.to_lowercase();
    let found = UNITS
        .iter()
        .find(|(_, names)| names.contains(&lower.as_str()));
    found.map(|(unit, _)| *unit)
}

fn alias(base: &str) -> Option<&'static str> {
    let found = ALIASES.iter().find(|(_, names)| names.contains(&base));
    found.map(|(name, _)| *name)
}

/// The name and the unit after it, in brackets or after a slash.
fn split(text: &str) -> (&str, String) {
    let brackets = [('(', ')'), ('[', ']'), ('{', '}')];
    for (open, close) in brackets {
        if let Some((base, rest)) = text.split_once(open)
            && let Some((unit, _)) = rest.split_once(close)
            && let Some(unit) = unit_named(unit)
        {
            return (base.trim_end_matches('_'), unit.to_owned());
        }
    }
    for mark in [" in ", "/", ",", " ", "_"] {
        for (at, _) in text.match_indices(mark) {
            if let Some(unit) = unit_named(&text[at + mark.len()..]) {
                return (&text[..at], unit.to_owned());
            }
        }
    }
    (text, String::new())
}

/// In lower case, with `_` between words.
fn words(text: &str) -> String {
    let letters = text.trim().chars().map(|c| {
        if c.is_whitespace() || "-.".contains(c) {
            ' '
        } else {
            c
        }
    });
    let text: String = letters.collect::<String>().to_lowercase();
    text.split_whitespace().collect::<Vec<_>>().join("_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_laboratories_write_has_one_name() {
        let known = |name: &str| name == "force2_kn";
        for (text, beneath, name) in [
            ("time_s", None, "time_s"),
            ("Time (s)", None, "time_s"),
            ("Time", Some("[sec]"), "time_s"),
            ("Cmd [mm]", None, "command_mm"),
            ("Axial Command", Some("mm"), "command_mm"),
            ("Disp. (m)", None, "displacement_m"),
            ("Position in mm", None, "displacement_mm"),
            ("Force/kN", None, "force_kn"),
            ("Load kN", None, "force_kn"),
            ("force2_kn", None, "force2_kn"),
            ("acc_m/s2", None, "acc_m_per_s2"),
            ("Acceleration (cm/s²)", None, "acc_gal"),
            ("Oil temperature", None, "oil_temperature"),
            ("oil_c", None, "oil_c"),
            ("energy_error_hsem_j", None, "energy_error_hsem_j"),
            ("acc_x_g", None, "acc_g"),
            ("Beschleunigung [m/s²]", None, "acc_m_per_s2"),
            ("Sollweg [mm]", None, "command_mm"),
            ("Time_[s]", None, "time_s"),
            ("Time (\u{b5}s)", None, "time_us"),
            ("Time", Some("min"), "time_min"),
            ("Disp [\u{3bc}m]", None, "displacement_um"),
        ] {
            assert_eq!(Header::of(text, beneath).name(known), name, "{text}");
        }
        assert_eq!(Header::of("Cmd", None).likely(), Some("command"));
        assert_eq!(Header::of("Oil", None).likely(), None);
        for (text, quantity) in [
            ("Ch 1 Displacement Command (mm)", Some("command")),
            ("LVDT 2 Displacement (mm)", Some("displacement")),
            ("Ch 1 Force (kN)", Some("force")),
            ("Oil (C)", None),
        ] {
            assert_eq!(Header::of(text, None).suggested(), quantity, "{text}");
        }
    }
}
