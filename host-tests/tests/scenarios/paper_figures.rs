//! The figures of the paper and of its audit, on the records of Kobe and Tabas. Bounds: 5 %, growth 3 %.

use host_tests::{Scenario, Shaking, Trace, data, eps, table1};
use outerloop_core::{Method, Mode};

const WHOLE_S: f64 = 40.0;
const TABAS_S: f64 = 32.8;

fn seconds(name: &str) -> f64 {
    if name == "Tabas" { TABAS_S } else { WHOLE_S }
}

fn errors(s: &Scenario, shaking: &Shaking, seconds: f64) -> (f64, f64, Trace<1>) {
    let trace = s.run::<1>(shaking, seconds, 1);
    let (largest, rms) = eps(&trace, &s.ideal(shaking, seconds), 0);
    println!(
        "{:14} {seconds:4} s: eps_max {largest:.4}, eps_rms {rms:.5}",
        s.config.compensation.kind.name()
    );
    (largest, rms, trace)
}

#[track_caller]
fn within(value: f64, published: f64, share: f64) {
    assert!(
        (value / published - 1.0).abs() <= share,
        "{value} against {published}"
    );
}

#[test]
fn uncompensated_the_structure_runs_away() {
    let Some(records) = data::kobe_and_tabas() else {
        return;
    };
    let none = Scenario::delayed(table1(), 4.0).with(Method::None);
    let [(_, kobe), (_, tabas)] = &records;
    let (max20, rms20, _) = errors(&none, kobe, 20.0);
    within(max20, 1.05, 0.05);
    within(rms20, 0.462, 0.05);
    let (max40, rms40, _) = errors(&none, kobe, 40.0);
    within(max40, 4.14, 0.05);
    within(rms40, 1.29, 0.05);
    let (max, rms, _) = errors(&none, tabas, 20.0);
    within(max, 1.96, 0.05);
    within(rms, 0.625, 0.05);
}

/// After the shaking the envelope grows as `exp((omega^2 tau / 2 - zeta omega) t)`.
#[test]
fn the_growth_of_the_uncompensated_test_is_the_published_one() {
    for (_, shaking) in data::motions() {
        let shaking = shaking.followed_by_rest(120.0);
        let trace = Scenario::delayed(table1(), 4.0)
            .with(Method::None)
            .run::<1>(&shaking, 120.0, 1);
        let peak = |from: f64| {
            let range = (from * 2000.0) as usize..((from + 1.0) * 2000.0) as usize;
            trace.records[range]
                .iter()
                .fold(0.0_f64, |p, r| p.max(f64::from(r.command_m[0]).abs()))
        };
        let growth = (peak(115.0) / peak(75.0)).powf(1.0 / 40.0) - 1.0;
        println!("growth {:.3} % a second", growth * 100.0);
        within(growth, 0.0665, 0.03);
    }
}

#[test]
fn three_milliseconds_are_stable_and_four_are_not() {
    for (_, shaking) in data::motions() {
        let shaking = shaking.followed_by_rest(120.0);
        let late = |delay_ms| {
            let trace = Scenario::delayed(table1(), delay_ms)
                .with(Method::None)
                .run::<1>(&shaking, 120.0, 1);
            let peak = |from: usize, to: usize| {
                trace.records[from * 2000..to * 2000]
                    .iter()
                    .fold(0.0_f64, |p, r| p.max(f64::from(r.command_m[0]).abs()))
            };
            peak(110, 120) / peak(80, 90)
        };
        let (three, four) = (late(3.0), late(4.0));
        println!("envelope over 30 s: {three:.3} at 3 ms, {four:.3} at 4 ms");
        assert!(three < 0.95 && four > 1.5);
    }
}

#[test]
fn eq_14_with_eqs_12_and_16_reaches_the_published_errors() {
    let Some(records) = data::kobe_and_tabas() else {
        return;
    };
    let paper = [(0.023, 0.0072, 0.0054), (0.025, 0.0095, 0.0080)];
    let s = Scenario::delayed(table1(), 4.0).with(Method::Eq14Unguarded);
    for ((name, shaking), (max, rms20, rms)) in records.iter().zip(paper) {
        let (m, r, _) = errors(&s, shaking, 20.0);
        within(m, max, 0.05);
        within(r, rms20, 0.05);
        let (m, r, trace) = errors(&s, shaking, seconds(name));
        within(m, max, 0.05);
        within(r, rms, 0.05);
        assert_eq!(trace.mode, Mode::Running);
    }
}

/// Eq 20 with the hold only on a change of sign, over 40 s of both records (Tabas ends after 33 s; the rest is free vibration),
/// which is evidently what the audit's row means. The default, which also holds below 5 % of the peak, must not be worse.
#[test]
fn eq_20_with_the_sech_gain_reaches_the_published_errors() {
    let Some([(_, kobe), (_, tabas)]) = data::kobe_and_tabas() else {
        return;
    };
    let guarded = Scenario::delayed(table1(), 4.0).with(Method::Paper);
    let mut sign_only = guarded.clone();
    sign_only.config.compensation.hold_share = 0.0;
    let tabas = tabas.followed_by_rest(WHOLE_S);
    within(errors(&sign_only, &kobe, WHOLE_S).1, 0.0048, 0.05);
    within(errors(&sign_only, &tabas, WHOLE_S).1, 0.0064, 0.05);
    assert!(errors(&guarded, &tabas, WHOLE_S).1 <= 0.0064);
    assert!(errors(&guarded, &kobe, WHOLE_S).1 <= 0.0048);
}

/// Without third-party records: bounds of the order of the published figures.
#[test]
fn a_drawn_motion_has_figures_of_the_published_order() {
    let (drawn, s) = (data::drawn(), Scenario::delayed(table1(), 4.0));
    let (_, none, _) = errors(&s.with(Method::None), &drawn, 20.0);
    let (max, eq_14, _) = errors(&s.with(Method::Eq14Unguarded), &drawn, WHOLE_S);
    let (_, eq_20, _) = errors(&s.with(Method::Paper), &drawn, WHOLE_S);
    assert!(none > 0.3, "{none}");
    assert!(
        max < 0.035 && eq_14 < 0.0105 && eq_20 < 0.0092,
        "{max} {eq_14} {eq_20}"
    );
}

/// A delay tau requires `C = K tau`, a damping ratio of `omega tau / 2` = 0.0251: Eq 14 adds this on average.
#[test]
fn the_mean_added_damping_is_that_of_the_delay() {
    for (_, shaking) in data::motions() {
        let s = Scenario::delayed(table1(), 4.0).with(Method::Eq14);
        let trace = s.run::<1>(&shaking, WHOLE_S, 1);
        let sum: f64 = trace
            .records
            .iter()
            .map(|r| f64::from(r.added_damping_n_s_per_m[0]))
            .sum();
        let ratio = sum / trace.records.len() as f64 / (2.0 * (158e3_f64 * 1000.0).sqrt());
        println!("mean added damping ratio {ratio:.4}");
        within(ratio, 0.0251, 0.05);
    }
}

/// Driving Eq 14 with Eq 6 needs a stiffness that is unknown in a test; the monitor of Eq 6 must still agree with the other
/// two, on which the audit's exact row relies.
#[test]
fn the_three_cumulative_energies_agree_on_a_linear_specimen() {
    for (name, shaking) in &data::motions() {
        let trace = Scenario::delayed(table1(), 4.0).run::<1>(shaking, seconds(name), 1);
        let e = trace.records.last().unwrap().energy_sum;
        println!(
            "{name}: Eq 6 {:.1} J, Eq 12 {:.1} J, HSEM {:.1} J",
            e.stiffness_j, e.modified_j, e.hsem_j
        );
        assert!((e.stiffness_j / e.modified_j - 1.0).abs() < 2e-3);
        assert!((e.hsem_j / e.modified_j - 1.0).abs() < 2e-3);
        assert!(e.modified_j < 0.0, "a late actuator puts energy in");
    }
}

/// `Eq 12 - HSEM = delta(R_m (u_m - u_c))`, step by step, on a specimen that yields.
#[test]
fn the_printed_sign_of_eq_7_is_a_misprint() {
    for (_, shaking) in data::motions() {
        let mut s = Scenario::delayed(table1(), 4.0);
        s.specimen = "kind = 'bilinear'\nyield_mm = 30.0\nhardening_ratio = 0.05".into();
        let trace = s.run::<1>(&shaking, 20.0, 1);
        let mut last = 0.0;
        let mut worst = 0.0_f64;
        for pair in trace.records.windows(2) {
            // The energies of a record belong to the sample of that record.
            let r = &pair[1];
            let product = f64::from(r.force_n[0])
                * (f64::from(r.displacement_m[0]) - f64::from(r.command_m[0]));
            if pair[0].step > 0 {
                let step = f64::from(r.energy_step.modified_j) - f64::from(r.energy_step.hsem_j);
                worst = worst.max((step - (product - last)).abs());
            }
            last = product;
        }
        assert!(worst < 1e-4, "identity off by {worst} J a step");
    }
}

#[test]
fn an_undershoot_and_the_random_multiplier_of_fig_6b_are_taken_out_too() {
    for (_, shaking) in data::motions() {
        let mut s = Scenario::delayed(table1(), 4.0);
        s.actuator = "kind = 'random_multiplier'\ndelay_ms = 4.0".into();
        let (_, none, _) = errors(&s.with(Method::None), &shaking, 20.0);
        let (_, paper, _) = errors(&s, &shaking, 20.0);
        assert!(none > 0.3 && paper < 0.02, "{none} {paper}");
    }
}
