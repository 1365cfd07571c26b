//! What each compensation is good for, in the case it is made for; the tangent force has its targets in `tangent_force.rs`.

use host_tests::{Scenario, Shaking, data, eps, table1};
use outerloop_cli::board::desk::{MODEL_CYCLES, methods};
use outerloop_core::Method;
use outerloop_core::Prediction;

/// A lag acts on the held command from the beginning of a control period, while the command is counted from its end: on a
/// continuous motion it is shorter than its nominal value by half a period, at 2 kHz, ms. A delay of whole periods is not.
const HALF_PERIOD_MS: f64 = 0.25;

/// An elastic or yielding Table 1 with an actuator of `kind`.
fn behind(kind: &str, delay_ms: f64, yields: bool) -> Scenario {
    let mut s = Scenario::delayed(table1(), delay_ms);
    s.actuator = format!("kind = '{kind}'\ndelay_ms = {delay_ms:?}");
    if yields {
        s.specimen = "kind = 'bilinear'\nyield_mm = 30.0\nhardening_ratio = 0.05".into();
    }
    let early_ms = if kind == "delay" { 0.0 } else { HALF_PERIOD_MS };
    s.config.compensation.delay_ms = (delay_ms - early_ms).into();
    s
}

/// eps_rms of the worst motion, 40 s.
fn worst(s: &Scenario) -> f64 {
    let rms = |(_, shaking): (_, Shaking)| {
        let ideal = s.ideal::<1>(&shaking, 40.0);
        eps(&s.run::<1>(&shaking, 40.0, 1), &ideal, 0).1
    };
    data::motions().into_iter().map(rms).fold(0.0, f64::max)
}

/// The error with `method` must be below `bound`, and smaller than that without compensation by a factor of `parts`.
#[track_caller]
fn removes(s: &Scenario, method: Method, bound: f64, parts: f64) {
    let (with, without) = (worst(&s.with(method)), worst(&s.with(Method::None)));
    println!(
        "{:22} {with:.5} (without {without:.3}): {}",
        method.name(),
        s.actuator.replace('\n', ", ")
    );
    assert!(
        with <= bound && with * parts <= without,
        "{with} of {without}"
    );
}

fn told(mut s: Scenario, share: f64) -> Scenario {
    let c = &mut s.config.compensation;
    c.delay_ms = (share * c.delay_ms.at(0)).into();
    s
}

#[test]
fn polynomial_extrapolation_removes_a_known_delay_and_higher_orders_remove_more() {
    removes(&behind("delay", 8.0, true), Method::Lagrange, 5e-4, 100.0);
    let mut last = f64::INFINITY;
    for order in 1..=3 {
        let mut s = behind("delay", 8.0, false).with(Method::Lagrange);
        s.config.compensation.order = order;
        let rms = worst(&s);
        println!("order {order}: {rms:.6}");
        assert!(rms < 0.5 * last);
        last = rms;
    }
}

#[test]
fn estimating_the_delay_repairs_what_extrapolation_was_told_wrong() {
    let wrong = told(behind("delay", 8.0, true), 0.5);
    removes(&wrong, Method::Darby, 2e-3, 50.0);
    let (fixed, learnt) = (
        worst(&wrong.with(Method::Lagrange)),
        worst(&wrong.with(Method::Darby)),
    );
    assert!(learnt < 0.1 * fixed, "{learnt} and {fixed}");
}

#[test]
fn a_model_predicts_an_elastic_structure() {
    removes(
        &behind("delay", 8.0, false),
        Method::ModelPrediction,
        2e-3,
        50.0,
    );
}

#[test]
fn the_fitted_force_takes_out_what_the_predictor_in_front_of_it_leaves() {
    let s = behind("second_order", 16.0, true);
    removes(&s, Method::Ahmadizadeh, 3e-3, 50.0);
    let (with, without) = (
        worst(&s.with(Method::Ahmadizadeh)),
        worst(&s.with(Method::Darby)),
    );
    assert!(with < without, "{with} and {without}");
}

#[test]
fn first_order_methods_invert_a_first_order_actuator() {
    let s = behind("first_order", 8.0, true);
    removes(&s, Method::PhaseLead, 2e-3, 50.0);
    removes(&s, Method::Inverse, 2e-3, 50.0);
}

#[test]
fn the_adaptive_inverse_finds_the_delay() {
    let wrong = told(behind("first_order", 8.0, false), 0.5);
    removes(&wrong, Method::AdaptiveInverse, 5e-3, 20.0);
}

#[test]
fn minimal_control_synthesis_finds_a_gain() {
    let mut s = behind("first_order", 8.0, true);
    s.actuator += "\ngain = 0.95";
    removes(&s, Method::Mcs, 3.5e-3, 50.0);
}

#[test]
fn feedforward_knows_the_actuator_and_feedback_takes_a_part_of_the_rest() {
    let s = behind("second_order", 16.0, true);
    removes(&s, Method::FeedforwardFeedback, 1e-3, 100.0);
    let mut weak = behind("second_order", 16.0, false).with(Method::FeedforwardFeedback);
    weak.actuator += "\ngain = 0.95";
    let mut open = weak.clone();
    open.config.compensation.feedback = 0.0;
    let (with, without) = (worst(&weak), worst(&open));
    println!("gain 0.95: {with:.4} with feedback, {without:.4} without");
    assert!(with < without);
}

#[test]
fn adaptive_prediction_learns_delay_and_gain() {
    let mut wrong = told(behind("second_order", 16.0, true), 0.5);
    removes(&wrong, Method::Afp, 1.5e-3, 100.0);
    wrong.actuator += "\ngain = 0.95";
    removes(&wrong, Method::Afp, 2e-3, 100.0);
}

#[test]
fn the_time_series_learns_actuators_of_any_order_up_to_two() {
    for kind in ["delay", "first_order", "second_order"] {
        removes(&told(behind(kind, 8.0, true), 0.5), Method::Ats, 2e-3, 50.0);
    }
    // The measured rig is none of these.
    let mut rig = behind("lag_delay", 4.6, true);
    rig.actuator += "\nlag_ms = 22.2";
    rig.config.compensation.delay_ms = 26.8.into();
    removes(&rig, Method::Ats, 2e-3, 100.0);
}

/// The predictor does not know a third of the delay: the damping removes most of what it leaves.
#[test]
fn variable_damping_behind_a_predictor_takes_out_what_that_leaves() {
    let wrong = told(behind("delay", 8.0, true), 2.0 / 3.0);
    for predictor in [Prediction::Lagrange, Prediction::PhaseLead] {
        let rest = |method| {
            let mut s = wrong.with(method);
            s.config.compensation.kind = s.config.compensation.kind.behind(predictor);
            worst(&s)
        };
        let (with, without) = (rest(Method::Paper), rest(Method::None));
        println!(
            "behind {}: {with:.4}, without {without:.4}",
            predictor.name()
        );
        assert!(with < 0.2 * without);
    }
}

#[test]
fn the_desk_tells_the_models_cycles_as_the_page_has_them() {
    let page = std::fs::read_to_string(host_tests::proof::top().join("docs/methods-validation.md"));
    let page = page.unwrap();
    let (_, cost) = page.split_once("## Cost on a Cortex-M4F").unwrap();
    let on_page = cost.lines().filter_map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let name = cells.get(1)?.split(' ').next()?;
        let method = methods().into_iter().find(|m| m.name() == name)?;
        let [_, _, instructions, cycles, ..] = cells[..] else {
            return None;
        };
        instructions.parse::<u32>().ok()?;
        Some((method.name(), cycles.parse::<u32>().ok()?))
    });
    let mut on_page: Vec<(&str, u32)> = on_page.collect();
    let mut told = MODEL_CYCLES.to_vec();
    on_page.sort_unstable();
    told.sort_unstable();
    assert_eq!(told, on_page);
    assert_eq!(told.len(), methods().len());
}
