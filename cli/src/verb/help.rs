//! What `--help` lists beside the options: every compensation and every effect, a line each.

use plant::effect::catalogue;

/// The compensations, from the one list that `core` makes its methods from.
pub fn compensations() -> String {
    let mut lines = vec![
        "Compensations, for --compensation and compensation.kind; force law and predictor may be joined, as tangent+ats:"
            .to_owned(),
    ];
    for (name, meaning) in listed(include_str!("../../../core/src/method.rs")) {
        lines.push(format!("  {name:21}{meaning}"));
    }
    lines.join("\n")
}

/// The effects that a diagnosis names and a simulated rig can have.
pub fn effects() -> String {
    let mut lines = vec!["Effects, for plant.effects and as a diagnosis names them; `outerloop effects` lists their parameters:".to_owned()];
    for e in catalogue() {
        lines.push(format!("  {:21}{}", e.effect.name(), e.physics));
    }
    lines.join("\n")
}

/// Names with the sentence that stands above each: `/// Sentence.` and below it `Variant "name" ...;`.
fn listed(source: &str) -> Vec<(&str, String)> {
    let mut sentence = String::new();
    let mut all = Vec::new();
    for line in source.lines().map(str::trim) {
        if let Some(text) = line.strip_prefix("/// ") {
            sentence = if sentence.is_empty() {
                text.to_owned()
            } else {
                format!("{sentence} {text}")
            };
            continue;
        }
        if let Some((variant, rest)) = line.split_once(" \"")
            && variant.chars().all(char::is_alphanumeric)
            && let Some((name, _)) = rest.split_once('"')
            && line.ends_with(';')
        {
            all.push((name, sentence.clone()));
        }
        sentence.clear();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use outerloop_core::Method;

    #[test]
    fn every_method_and_effect_has_its_line() {
        let help = compensations();
        for method in Method::ALL {
            let line = help
                .lines()
                .find(|l| l.trim_start().split(' ').next() == Some(method.name()));
            assert!(
                line.is_some_and(|l| l.len() > 35),
                "{}: {help}",
                method.name()
            );
        }
        assert_eq!(help.lines().count(), Method::ALL.len() + 1);
        assert_eq!(effects().lines().count(), catalogue().len() + 1);
    }
}
