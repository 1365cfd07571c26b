//! Laws between two names: a frame or a stiffer spring, a damper's own oil or its brace.

use super::spring::STIFFNESS_N_PER_MM;
use super::{H, asked, between_rests, is_held_possible, said, shaken, speed};
use diagnosis::{ChannelAnswer, Verdict};
use plant::Effect;

fn moved() -> Vec<f64> {
    shaken(24.0, |u| between_rests(u, 0.05))
}

/// Its joints close with the force: 25 % of the stiffness is lost, and a sixth of that more near zero.
#[test]
fn a_frame_that_gives_way_more_at_first_is_not_only_said_to_be_a_spring_that_stiffens() {
    let x = moved();
    let left = |x: f64| 1.0 / (1.0 + 0.25 * (1.0 + 0.17 / (1.0 + (x / 1.5).powi(2))));
    let lost: Vec<f64> = x
        .iter()
        .map(|x| STIFFNESS_N_PER_MM * x * (left(*x) - 1.0))
        .collect();
    let a = asked(&x, &lost);
    for name in [Effect::RigCompliance, Effect::GainError] {
        assert!(is_held_possible(&a, name), "{}", said(&a));
    }
    assert_eq!(a.verdict, Verdict::Ambiguous, "{}", said(&a));
    // One that stiffens as much as its declared stiffness is off has no scale to blame.
    let stiffens: Vec<f64> = x.iter().map(|x| 2.0 * x.powi(3)).collect();
    let a = asked(&x, &stiffens);
    assert!(is_held_possible(&a, Effect::Hardening), "{}", said(&a));
    assert!(!is_held_possible(&a, Effect::RigCompliance), "{}", said(&a));
}

/// A dashpot that relaxes: `f' = k (v - f / c)`.
fn relaxing(x: &[f64], relaxes_s: f64) -> Vec<f64> {
    let mut f = 0.0;
    let force = |i: usize| {
        let end = 8.0 * speed(x, i);
        f = end + (f - end) * (-H / relaxes_s).exp();
        f
    };
    (0..x.len()).map(force).collect()
}

#[test]
fn a_dashpot_behind_a_soft_brace_is_no_dashpot_and_one_with_its_own_oil_may_be() {
    let x = moved();
    let of = |relaxes_s: f64| -> ChannelAnswer { asked(&x, &relaxing(&x, relaxes_s)) };
    let brace = of(0.03);
    assert!(
        is_held_possible(&brace, Effect::MaxwellDamper),
        "{}",
        said(&brace)
    );
    assert!(
        !is_held_possible(&brace, Effect::ViscousDamping),
        "{}",
        said(&brace)
    );
    let own = of(0.008);
    assert!(
        is_held_possible(&own, Effect::ViscousDamping),
        "{}",
        said(&own)
    );
}
