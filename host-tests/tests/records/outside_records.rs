//! The diagnosis on third-party records with known causes (`outside/cases.toml` gives the correct names).
#![cfg(not(debug_assertions))] // Minutes without optimisation.

use diagnosis::{ChannelAnswer, Verdict};
use host_tests::outside::{Case, cases};
use std::sync::LazyLock;

/// The specimens of the open records, each diagnosed once for all tests.
fn specimens() -> &'static [(Case, ChannelAnswer)] {
    static ANSWERED: LazyLock<Vec<(Case, ChannelAnswer)>> = LazyLock::new(|| {
        let all = cases().unwrap_or_default().into_iter();
        let specimens = all.filter(|c| c.channel == "specimen");
        specimens
            .map(|case| {
                let answer = case.diagnose();
                let (answer, _) = answer.unwrap_or_else(|why| panic!("{}: {why}", case.id));
                (case, answer)
            })
            .collect()
    });
    &ANSWERED
}

#[test]
fn specimens_are_answered_as_their_causes_say() {
    for (case, a) in specimens() {
        let named: Vec<&str> = a.effects.iter().map(|e| e.name.name()).collect();
        println!(
            "{} {:?} {named:?} {:.3}",
            case.id, a.verdict, a.error_after.test_nrmse
        );
        // Correct names or a set that contains one, none that is always wrong, an error near a textbook fit's.
        assert_eq!(
            case.points(a),
            1.0,
            "{}: {:?} {named:?}",
            case.id,
            a.verdict
        );
        match a.verdict {
            Verdict::Ambiguous => {
                assert!((2..=5).contains(&a.members.len()));
                // One of them is probably in the rig, and so may be two.
                let whole: f64 = a.members.iter().map(|m| m.probability).sum();
                let each = a.members.iter().all(|m| m.probability <= 1.0);
                assert!(whole > 0.85 && each, "{}: {whole}", case.id);
            }
            // More likely right than wrong, but less certain than a law of the table that leaves only noise.
            _ => assert!(
                a.effects
                    .iter()
                    .all(|e| e.q.is_some_and(|q| (0.02..0.5).contains(&q)))
            ),
        }
        assert!(a.noise_floor_rms <= a.error_after.test_rms * (1.0 + 1e-9));
    }
}

#[test]
fn the_robot_axis_has_its_published_parameters() {
    let Some((case, a)) = specimens().iter().find(|(c, _)| c.id == "emps") else {
        return;
    };
    let refitted = |name: &str| a.refitted.iter().find(|r| r.name == name).map(|r| r.value);
    let found = a.effects[0].parameters.iter();
    let force = found.clone().find(|p| p.name == "force_n").map(|p| p.value);
    for (name, value) in [
        ("mass_kg", refitted("mass_kg")),
        ("damping_n_s_per_mm", refitted("damping_n_s_per_mm")),
        ("offset_n", refitted("offset_n")),
        ("coulomb_force_n", force),
    ] {
        let published = case.published[name];
        let value = value.unwrap_or_else(|| panic!("{name} is missing"));
        let off = (value - published.value).abs();
        assert!(
            off <= published.tolerance,
            "{name} = {value}, published {published:?}"
        );
    }
}
