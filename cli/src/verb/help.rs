//! The lists in `--help` besides the options: every compensation and every effect, one per line.

use outerloop_core::Method;
use plant::effect::catalogue;

/// The compensations, from the list in `core` that defines the methods.
pub fn compensations() -> String {
    let mut lines = vec![
        "Compensations, for --compensation and compensation.kind; force law and predictor may be joined, as tangent+ats:"
            .to_owned(),
    ];
    for method in Method::ALL {
        lines.push(format!("  {method:21}{}", method.meaning()));
    }
    lines.join("\n")
}

/// The effects that a diagnosis can name and a simulated rig can have.
pub fn effects() -> String {
    let mut lines = vec!["Effects, for plant.effects and as a diagnosis names them; `outerloop effects` lists their parameters:".to_owned()];
    for e in catalogue() {
        lines.push(format!("  {:21}{}", e.effect.name(), e.physics));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

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
