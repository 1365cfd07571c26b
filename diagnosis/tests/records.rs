//! What records bring along that the rig's model does not lack: a beginning in mid-motion, another zero, a pump.
#![allow(missing_docs)]

mod rig;

use diagnosis::{ChannelAnswer, Recording, Verdict, diagnose};
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
