//! What a key accepts: the code that reads it is given a wrong value, and its refusal says it.

use super::value::ValueKind;
use experiment::files::test::TestFile;
use std::path::Path;

/// A valid test file.
const PLAIN: &str = "[structure]\nmass_kg = 1000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.02\n\
                     [plant.actuator]\nkind = \"ideal\"\n";
/// A valid test of coupled actuators.
const COUPLED: &str = include_str!("../../../examples/coupled-frame.toml");
/// Kinds with which a key of the rig is probed, since another kind would refuse it for being present at all.
const KINDS: [&str; 15] = [
    "",
    "compensation.kind=\"lagrange\"",
    "compensation.kind=\"amb\"",
    "compensation.kind=\"hydraulic\";compensation.hydraulic={a1_b0=1,a2=1,a3=1,b1=1,b2=1,mass_kg=1,damping_n_s_per_m=1,stiffness_n_per_m=1,spread=[0,0,0,0],noise_m=1}",
    "estimation.kind=\"low_pass\"",
    "compensation.kind=\"ats\"",
    "plant.actuator.kind=\"lag_delay\"",
    "plant.actuator.kind=\"second_order\"",
    "plant.actuator.kind=\"random_multiplier\"",
    "plant.actuator.kind=\"servo_hydraulic\";plant.actuator.delay_ms=20",
    "plant.specimen.kind=\"bilinear\";plant.specimen.yield_mm=5",
    "plant.specimen.kind=\"bouc_wen\";plant.specimen.yield_mm=5",
    "plant.actuator.delay_jump={at_s=1,delay_ms=1}",
    "declared.actuator.remainder={depends_on=\"time\",range={x_mm=[-1,1],v_mm_per_s=[-1,1],other=[0,0],seconds=1},strengths=[1]}",
    "declared.specimen.remainder={depends_on=\"time\",range={x_mm=[-1,1],v_mm_per_s=[-1,1],other=[0,0],seconds=1},strengths=[1]}",
];

/// The accepted values in words.
pub fn accepted(path: &str, kind: &ValueKind, meaning: &str) -> String {
    let list;
    let wrong: &[&str] = match kind {
        ValueKind::Number | ValueKind::Numbers => &["nan", "-1e30", "1e30"],
        ValueKind::List(count) => {
            list = format!("[{}]", vec!["nan"; count.unwrap_or(1)].join(","));
            &[&list]
        }
        ValueKind::Matrix(Some(rows)) => {
            return format!("{rows} rows of {rows} numbers");
        }
        ValueKind::Matrix(None) => return "rows of numbers, as many as coordinates".into(),
        ValueKind::DeclaredMatrix => {
            return "rows of { value = , tolerance = }, as many as coordinates".into();
        }
        ValueKind::Texts => return "a list of texts".into(),
        ValueKind::Integer => &["0", "255", "65535"],
        ValueKind::Name => &["\"no such name\""],
        ValueKind::Text => return "a text".into(),
        ValueKind::Flag => return "true, false".into(),
        ValueKind::Tables if path.ends_with(".springs") => return "tables".into(),
        ValueKind::Tables => return "tables; `outerloop effects` lists what stands in them".into(),
        ValueKind::Declared => {
            return "{ value = , tolerance = }, the tolerance at least 0".into();
        }
        ValueKind::Table => return String::new(),
    };
    for value in wrong {
        for kind in KINDS {
            if let Some(said) =
                refusal(&[kind, &format!("{path}={value}")]).and_then(|e| said(&e, path))
            {
                return said;
            }
        }
    }
    match kind {
        ValueKind::Integer => "whole numbers from 0".into(),
        ValueKind::Name => "a name".into(),
        _ => range(meaning).unwrap_or("finite numbers").to_owned(),
    }
}

/// The part of a meaning that is a range, such as `0 to 1`.
fn range(meaning: &str) -> Option<&str> {
    let parts = meaning
        .trim_end_matches('.')
        .split([',', ';'])
        .map(str::trim);
    parts
        .into_iter()
        .find(|part| part.contains(" to ") && part.ends_with(|c: char| c.is_ascii_digit()))
}

/// The refusal of a test file with these values.
fn refusal(overrides: &[&str]) -> Option<String> {
    let overrides: Vec<String> = overrides
        .iter()
        .flat_map(|o| o.split(';'))
        .filter(|o| !o.is_empty())
        .map(|o| (*o).to_owned())
        .collect();
    let coupled = |o: &&String| o.starts_with("coupled") || o.starts_with("plant.coupled");
    let refused = if overrides.iter().any(|o| coupled(&o)) {
        TestFile::parse(COUPLED, "test", Path::new(""), &overrides).err()
    } else {
        TestFile::parse(PLAIN, "test", Path::new(""), &overrides).err()
    };
    let said = refused?.to_string();
    // The settings come first: a key in them is not the one that is refused.
    let set = format!("test with --set {}: ", overrides.join(" --set "));
    Some(said.strip_prefix(&set).unwrap_or(&said).to_owned())
}

/// The accepted values in a refusal of `path`.
fn said(refusal: &str, path: &str) -> Option<String> {
    let key = path.rsplit('.').next()?;
    let (before, after) = refusal
        .rsplit_once("accepted are ")
        .or_else(|| refusal.rsplit_once("accepted is "))
        .or_else(|| refusal.rsplit_once("expected one of "))
        .or_else(|| refusal.rsplit_once(", expected "))?;
    // The refusal must be of this key's value, not of another key that contradicts it, and not of the key whatever its value.
    let is_of_value = before.contains(key) && !before.ends_with(" is given, ");
    is_of_value.then(|| {
        after
            .trim_end_matches('.')
            .replace("` or `", ", ")
            .replace('`', "")
    })
}
