//! The one engine on rigs whose causes are known: nothing, two at once, and held-out data that do not choose.
#![allow(missing_docs)]

mod rig;

use diagnosis::{ChannelAnswer, Recording, Verdict, diagnose};
use plant::{Channel, Effect, EffectSpec};

/// Noise of the rig's force, N: 10 N of the load cell and 0.01 mm times 1000 N/mm.
const NOISE_N: f64 = 14.1;

fn specimen(train: &Recording, test: &Recording) -> ChannelAnswer {
    let [train, test] = [train, test].map(std::slice::from_ref);
    let found = diagnose(&rig::model(), train, test, &[]).unwrap();
    let own = |a: &ChannelAnswer| a.channel == Channel::Specimen;
    let answer = found.channels.into_iter().find(own).unwrap();
    println!(
        "{:?} {:?} or {:?}: {:.2} -> {:.2} N",
        answer.verdict,
        answer.effects,
        answer.members,
        answer.error_before.test_rms,
        answer.error_after.test_rms
    );
    answer
}

fn names(a: &ChannelAnswer) -> Vec<Effect> {
    let mut all: Vec<Effect> = a.effects.iter().map(|e| e.name).collect();
    all.sort_by_key(|n| *n as usize);
    all
}

/// What is left while the rig moves, N rms: in the rests friction holds any force up to its own.
fn left_in_motion(a: &ChannelAnswer) -> f64 {
    let t = &a.traces;
    let all = t.time_s.iter().zip(&t.measured).zip(&t.after);
    let moves = all.filter(|((time, _), _)| (3.0..19.0).contains(*time));
    let squares: Vec<f64> = moves.map(|((_, y), model)| (y - model).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

fn two_causes() -> [EffectSpec; 2] {
    let friction = [("force_n", 150.0), ("presliding_mm", 0.05)];
    [
        EffectSpec::new(Effect::CoulombFriction, &friction),
        EffectSpec::new(
            Effect::Hardening,
            &[("reference_mm", 30.0), ("exponent", 2.0)],
        ),
    ]
}

#[test]
fn nothing_is_missing_in_a_clean_rig() {
    let [train, test] = rig::pair(&[], 21);
    let answer = specimen(&train, &test);
    assert_eq!(answer.verdict, Verdict::None);
    assert!(answer.error_after.test_rms < 1.15 * NOISE_N);
}

#[test]
fn two_causes_of_like_size_are_both_named_and_leave_the_noise() {
    let [train, test] = rig::pair(&two_causes(), 22);
    let answer = specimen(&train, &test);
    assert_eq!(answer.verdict, Verdict::Effect);
    assert_eq!(names(&answer), [Effect::CoulombFriction, Effect::Hardening]);
    // A spring that stiffens passes on more of the displacement's noise.
    let left = left_in_motion(&answer);
    assert!(left < 1.2 * NOISE_N, "{left}");
    let force = answer
        .effects
        .iter()
        .find(|e| e.name == Effect::CoulombFriction);
    let force = &force.unwrap().parameters[0];
    assert!((force.value - 150.0).abs() < 5.0, "{force:?}");
    assert!(force.ci90[0] < force.value && force.value < force.ci90[1]);
}

/// A third one is no law of the specimen: the force is read late.
#[test]
fn three_causes_in_one_channel_are_all_named_and_leave_the_noise() {
    let late = EffectSpec::new(Effect::ChannelSkew, &[("skew_ms", 3.0)]);
    let [train, test] = rig::pair(&[&two_causes()[..], &[late]].concat(), 24);
    let answer = specimen(&train, &test);
    assert_eq!(answer.verdict, Verdict::Effect, "{:?}", answer.notes);
    let mut three = [
        Effect::CoulombFriction,
        Effect::Hardening,
        Effect::ChannelSkew,
    ];
    three.sort_by_key(|n| *n as usize);
    assert_eq!(names(&answer), three);
    let left = left_in_motion(&answer);
    assert!(left < 1.2 * NOISE_N, "{left}");
    let skew = answer
        .effects
        .iter()
        .find(|e| e.name == Effect::ChannelSkew);
    let skew = &skew.unwrap().parameters[0];
    assert!((skew.value - 3.0).abs() < 0.2, "{skew:?}");
}

/// What a record holds between two instants.
fn part(r: &Recording, seconds: std::ops::Range<f64>) -> Recording {
    let of = |x: &Vec<f64>| -> Vec<f64> {
        let own = r.time_s.iter().zip(x);
        own.filter(|(t, _)| seconds.contains(t))
            .map(|(_, x)| *x)
            .collect()
    };
    Recording {
        time_s: of(&r.time_s),
        command_mm: r.command_mm.as_ref().map(of),
        displacement_mm: r.displacement_mm.as_ref().map(of),
        force_n: r.force_n.as_ref().map(of),
        ..r.clone()
    }
}

#[test]
fn other_held_out_data_change_the_error_and_not_the_names() {
    let [train, test] = rig::pair(&two_causes(), 23);
    let [other, _] = rig::pair(&two_causes(), 24);
    let one = specimen(&train, &test);
    assert_eq!(names(&one).len(), 2);
    // Another motion, a piece of it, and its end.
    for held_out in [other, part(&test, 8.0..10.0), part(&test, 19.4..22.0)] {
        let two = specimen(&train, &held_out);
        assert_eq!(names(&one), names(&two));
        assert_eq!(one.verdict, two.verdict);
        assert_ne!(one.error_after, two.error_after);
    }
}

/// A record of a rig that is so many times as large in all that it moves and holds.
fn enlarged(r: &Recording, times: f64) -> Recording {
    let of = |x: &Vec<f64>| x.iter().map(|x| times * x).collect();
    Recording {
        command_mm: r.command_mm.as_ref().map(of),
        displacement_mm: r.displacement_mm.as_ref().map(of),
        force_n: r.force_n.as_ref().map(of),
        ..r.clone()
    }
}

/// The same friction in fifteen times the motion is two thousandths of the force, which no load cell would show.
#[test]
fn what_shows_in_the_training_record_is_named_whatever_share_of_a_held_out_one_it_is() {
    let rubs = |force_n, presliding_mm| {
        let own = [("force_n", force_n), ("presliding_mm", presliding_mm)];
        [EffectSpec::new(Effect::CoulombFriction, &own)]
    };
    let truth = [1003.0, 5.1, 22.2];
    // Without their rests: these would tell the noise, and a sure name stands beside that.
    let train = part(&rig::record(&rubs(150.0, 0.05), truth, 51), 3.0..19.0);
    let large = part(&rig::record(&rubs(10.0, 0.0033), truth, 52), 3.0..19.0);
    let answer = specimen(&train, &enlarged(&large, 15.0));
    assert!(answer.error_before.train_nrmse > 0.01);
    assert!(answer.error_before.test_nrmse < 0.005);
    let set = answer.members.iter().map(|m| m.name);
    let all: Vec<Effect> = names(&answer).into_iter().chain(set).collect();
    assert!(all.contains(&Effect::CoulombFriction), "{all:?}");
}

#[test]
fn held_out_data_that_have_died_down_to_the_noise_take_no_name_back() {
    let hardening = EffectSpec::new(
        Effect::Hardening,
        &[("reference_mm", 30.0), ("exponent", 2.0)],
    );
    let hardening = [hardening.in_channel(Channel::Specimen)];
    let [train, _] = rig::pair(&hardening, 25);
    for seed in 30..36 {
        let [_, test] = rig::pair(&hardening, seed);
        let end = specimen(&train, &part(&test, 20.2..22.0));
        assert!(end.error_before.test_rms < 1.1 * NOISE_N);
        assert_eq!(names(&end), [Effect::Hardening]);
        assert_eq!(end.verdict, Verdict::Effect);
    }
}

/// A spring that stiffens by next to nothing, or yields far away, would do nearly as well on every block.
#[test]
fn a_gain_has_no_rival_where_every_sample_speaks() {
    let gain = EffectSpec::new(Effect::GainError, &[("error", 0.06)]).in_channel(Channel::Specimen);
    let [train, test] = rig::pair(&[gain], 6);
    let answer = specimen(&train, &test);
    assert_eq!(answer.verdict, Verdict::Effect, "{:?}", answer.members);
    assert_eq!(names(&answer), [Effect::GainError]);
}
