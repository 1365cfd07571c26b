//! What records bring along that the rig's model does not lack: a beginning in mid-motion, another zero, a pump.
#![allow(missing_docs)]

mod rig;

use diagnosis::{ChannelAnswer, Recording, Verdict, diagnose};
use plant::{Channel, Effect, EffectSpec};
use std::f64::consts::TAU;

/// Noise of the rig, mm and N: 10 N of the load cell and 0.01 mm times 1000 N/mm.
const NOISE: [f64; 2] = [0.01, 14.1];

fn asked(train: Recording, test: Recording) -> Vec<ChannelAnswer> {
    let answers = diagnose(&rig::model(), &[train], &[test], &[])
        .unwrap()
        .channels;
    for a in &answers {
        println!(
            "{} {:?} {:?}: held out {:.4} -> {:.4}, noise {:.4} {}; {:?}",
            a.channel.name(),
            a.verdict,
            a.effects,
            a.error_before.test_rms,
            a.error_after.test_rms,
            a.noise_floor_rms,
            a.unit,
            a.notes
        );
    }
    answers
}

/// One record in two: the second part begins where the rig moves fast.
#[test]
fn a_span_that_begins_in_mid_motion_is_not_charged_with_its_beginning() {
    let whole = rig::record(&[], [1003.0, 5.2, 21.6], 11);
    let speed = |i: &usize| {
        let u = whole.command_mm.as_ref().unwrap();
        (u[i + 1] - u[*i]).abs()
    };
    let fastest = (11_000..14_000).max_by(|a, b| speed(a).total_cmp(&speed(b)));
    let at_s = whole.time_s[fastest.unwrap()];
    let answers = asked(whole.span(0.0, at_s), whole.span(at_s, 22.0));
    for (a, noise) in answers.iter().zip(NOISE) {
        assert_eq!(a.verdict, Verdict::None);
        assert!(a.error_after.test_rms < 1.15 * noise);
    }
}

/// Nothing before the record is in the file, and no rest.
#[test]
fn nothing_is_missing_in_a_clean_rig_that_is_cut_out_of_its_motion() {
    let moving = |seed| {
        let mut r = rig::record(&[], [1003.0, 5.2, 21.6], seed).span(4.0, 18.0);
        r.before = None;
        r
    };
    let answers = asked(moving(3), moving(4));
    for a in answers {
        assert_eq!(a.verdict, Verdict::None, "{:?}", a.notes);
    }
}

/// The force's zero was set anew before the second record.
#[test]
fn a_zero_that_jumps_between_the_records_is_said() {
    let [train, mut test] = rig::pair(&[], 5);
    test.force_n.iter_mut().flatten().for_each(|f| *f += 400.0);
    let answers = asked(train, test);
    let zero = |a: &ChannelAnswer| a.notes.iter().any(|n| n.contains("a zero was set anew"));
    assert_eq!(answers.iter().map(zero).collect::<Vec<_>>(), [false, true]);
}

/// A pump shakes the load cell at rest as in motion.
#[test]
fn a_line_in_the_rest_is_a_disturbance_and_no_noise() {
    let shaken = |mut r: Recording, phase: f64| {
        for (f, t) in r.force_n.iter_mut().flatten().zip(&r.time_s) {
            *f += 60.0 * (TAU * 24.0 * t + phase + 0.4 * (1.3 * t).sin()).sin();
        }
        r
    };
    let [train, test] = rig::pair(&[], 7);
    let answers = asked(shaken(train, 0.3), shaken(test, 1.9));
    assert_eq!(answers[0].verdict, Verdict::None);
    assert_eq!(answers[1].verdict, Verdict::Unknown);
    let named = |n: &String| n.contains("That is no noise");
    assert!(answers[1].notes.iter().any(named), "{:?}", answers[1].notes);
}

/// The same without some of its rows.
fn without_rows(r: &Recording, lost: impl Fn(usize) -> bool) -> Recording {
    let kept = |x: &[f64]| -> Vec<f64> {
        let all = x.iter().enumerate();
        all.filter_map(|(i, x)| (!lost(i)).then_some(*x)).collect()
    };
    let column = |x: &Option<Vec<f64>>| x.as_deref().map(kept);
    let rows = Recording {
        time_s: kept(&r.time_s),
        command_mm: column(&r.command_mm),
        displacement_mm: column(&r.displacement_mm),
        force_n: column(&r.force_n),
        ..r.clone()
    };
    rows.made_even().unwrap()
}

/// A logger loses one row in a hundred, and now and then five or twenty.
#[test]
fn rows_that_nobody_measured_leave_no_residual_and_change_no_answer() {
    let play = EffectSpec::new(Effect::Backlash, &[("width_mm", 0.4)]);
    let friction = [("force_n", 300.0), ("presliding_mm", 0.05)];
    let effects = [
        play.in_channel(Channel::Actuator),
        EffectSpec::new(Effect::CoulombFriction, &friction),
    ];
    let [train, test] = rig::pair(&effects, 33);
    // Here and there: evenly lost rows are those of a slower clock.
    let one_in_a_hundred = |i: usize| {
        let mixed = (i as u32).wrapping_mul(0x9e37_79b9);
        (mixed ^ (mixed >> 15)).wrapping_mul(0x85eb_ca6b) >> 8 < (1 << 24) / 100
    };
    let lost = |i: usize| {
        matches!(i, 9000..9005 | 12_000..12_020)
            || ((50..21_900).contains(&i) && one_in_a_hundred(i))
    };
    let [short, held] = [&train, &test].map(|r| without_rows(r, lost));
    let count = (0..test.time_s.len()).filter(|i| lost(*i)).count();
    assert_eq!(held.time_s.len(), test.time_s.len());
    assert_eq!(held.unmeasured().len(), count);
    assert!(count > 200);
    let (whole, other) = (asked(train, test), asked(short, held.clone()));
    for (a, b) in whole.iter().zip(&other) {
        assert_eq!(a.verdict, b.verdict);
        let left = |a: &ChannelAnswer, t: &f64| {
            let place = a
                .traces
                .time_s
                .iter()
                .position(|own| (own - t).abs() < 1e-6);
            place.map(|i| a.traces.measured[i] - a.traces.after[i])
        };
        let of = |a: &ChannelAnswer| -> Vec<f64> {
            held.unmeasured_s
                .iter()
                .filter_map(|t| left(a, t))
                .collect()
        };
        let (with, without) = (of(a), of(b));
        assert!(without.len() > count / 2, "{}", without.len());
        assert!(without.iter().all(|x| x.abs() < 1e-12));
        assert!(
            with.iter().any(|x| x.abs() > 1e-3),
            "they are judged where they were measured"
        );
        let close = (a.error_after.test_rms / b.error_after.test_rms - 1.0).abs();
        assert!(close < 0.02, "{close}");
        let named = |a: &ChannelAnswer| a.effects.iter().map(|e| e.name).collect::<Vec<_>>();
        assert_eq!(named(a), named(b));
        assert!(!a.effects.is_empty(), "{:?}", a.notes);
        for (p, q) in a.effects.iter().zip(&b.effects) {
            for (p, q) in p.parameters.iter().zip(&q.parameters) {
                let width = p.ci90[1] - p.ci90[0];
                assert!((p.value - q.value).abs() < 0.5 * width, "{p:?} {q:?}");
            }
        }
    }
}
