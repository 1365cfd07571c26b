//! Comparison with an independent f64 study: eps_rms of Table 1's structure with a bilinear specimen (30 mm, 5 %) and a
//! second-order actuator, the worse of Kobe and Tabas, 40 s, by delay.

use host_tests::{Scenario, Shaking, data, eps, table1};
use outerloop_core::config::Compensation;
use outerloop_core::{Method, Prediction};

const DELAYS_MS: [f64; 5] = [4.0, 8.0, 16.0, 33.5, 60.0];

/// A line of the study, and its equivalent here.
struct Line {
    name: &'static str,
    study: [f64; 5],
    /// Declared fraction of the actuator's delay.
    told: f64,
    set: fn(&mut Compensation),
    /// If both are the same method: how far our error may be from the study's, as a fraction and as an absolute error, and up to
    /// which delay, ms. `None`: ours may only be better, except for `paper`, which is not compared.
    same: Option<(f64, f64, f64)>,
    why: &'static str,
}

fn lines() -> [Line; 9] {
    fn kind(c: &mut Compensation, method: Method) {
        c.kind = method;
    }
    let none = |c: &mut Compensation| kind(c, Method::None);
    let lagrange = |c: &mut Compensation| kind(c, Method::Lagrange);
    [
        Line {
            name: "none",
            study: [0.118, 0.15, 0.23, 0.30, 0.45],
            told: 1.0,
            set: none,
            same: Some((0.15, 1e-3, 60.0)),
            why: "the same",
        },
        Line {
            name: "eq14",
            study: [0.0026, 0.0099, 0.022, 0.18, 0.18],
            told: 1.0,
            set: |c| kind(c, Method::Eq14),
            same: Some((0.15, 1e-3, 16.0)),
            why: "`paper` of the study is Eq 14; beyond 16 ms the guards differ: here the clamp is 2 K tau of the delay told",
        },
        Line {
            name: "eq14-unguarded",
            study: [0.0026, 0.0099, 0.022, 0.18, 0.18],
            told: 1.0,
            set: |c| kind(c, Method::Eq14Unguarded),
            same: Some((0.1, 1e-3, 8.0)),
            why: "the same without guards",
        },
        Line {
            name: "paper",
            study: [0.0026, 0.0099, 0.022, 0.18, 0.18],
            told: 1.0,
            set: |c| kind(c, Method::Paper),
            same: None,
            why: "Eq 20: the study's line has no sech gain, which takes a yielded specimen's offset for motion",
        },
        Line {
            name: "lagrange",
            study: [0.0, 0.0004, 0.0039, 0.050, 0.28],
            told: 1.0,
            set: lagrange,
            same: Some((0.1, 1e-3, 60.0)),
            why: "the same",
        },
        Line {
            name: "lagrange, told half",
            study: [0.039, 0.12, 0.15, 0.24, 0.30],
            told: 0.5,
            set: lagrange,
            same: Some((0.15, 1e-3, 60.0)),
            why: "the same",
        },
        Line {
            name: "afp, told half",
            study: [0.0004, 0.0012, 0.0048, 0.017, 0.025],
            told: 0.5,
            set: |c| kind(c, Method::Afp),
            same: None,
            why: "other pace, gain learnt as well",
        },
        Line {
            name: "tangent force alone",
            study: [0.0006, 0.0022, 0.0090, 0.048, 0.086],
            told: 1.0,
            set: |c| kind(c, Method::Tangent.behind(Prediction::None)),
            same: Some((0.15, 1e-3, 60.0)),
            why: "the same but for the way back at a turning point and a shorter secant",
        },
        Line {
            name: "tangent, told half",
            study: [0.0002, 0.0006, 0.0026, 0.0042, 0.0098],
            told: 0.5,
            set: |c| kind(c, Method::Tangent),
            same: None,
            why: "as these two",
        },
    ]
}

/// A second-order lag of the held command is half a control period shorter than its nominal delay, ms.
const HELD_MS: f64 = 0.25;

fn scenario(delay_ms: f64, told: f64, set: fn(&mut Compensation)) -> Scenario {
    let mut s = Scenario::delayed(table1(), delay_ms);
    s.actuator = format!("kind = 'second_order'\ndelay_ms = {delay_ms:?}");
    s.specimen = "kind = 'bilinear'\nhardening_ratio = 0.05\nyield_mm = 30.0".into();
    s.config.compensation.delay_ms = (told * (delay_ms - HELD_MS)).into();
    set(&mut s.config.compensation);
    s
}

/// eps_rms on Kobe and on Tabas; none without the records.
fn errors(s: &Scenario) -> Vec<f64> {
    let records = data::kobe_and_tabas().into_iter().flatten();
    records.map(|(_, shaking)| error(s, &shaking)).collect()
}

fn error(s: &Scenario, shaking: &Shaking) -> f64 {
    let ideal = s.ideal::<1>(shaking, 40.0);
    eps(&s.run::<1>(shaking, 40.0, 1), &ideal, 0).1
}

fn worse(s: &Scenario) -> Option<f64> {
    errors(s).into_iter().reduce(f64::max)
}

#[test]
fn the_study_is_reproduced_where_the_method_is_the_same() {
    println!("eps_rms (the study's); {DELAYS_MS:?} ms");
    let mut off = Vec::new();
    for line in lines() {
        print!("{:20}", line.name);
        for (delay_ms, study) in DELAYS_MS.into_iter().zip(line.study) {
            let Some(rms) = worse(&scenario(delay_ms, line.told, line.set)) else {
                return;
            };
            print!("  {rms:.5} ({study})");
            let good = match line.same {
                Some((share, error, up_to_ms)) if delay_ms <= up_to_ms => {
                    (rms - study).abs() <= share * study + error
                }
                Some(_) => true,
                None => line.name == "paper" || rms <= study,
            };
            if !good {
                off.push(format!("{} at {delay_ms} ms: {rms} ({study})", line.name));
            }
        }
        println!("  {}", line.why);
    }
    assert_eq!(off, Vec::<String>::new());
}

/// Without the study's records: what is five times better in the study is better on a drawn motion, too.
#[test]
fn on_a_drawn_motion_the_methods_stand_in_the_studys_order() {
    let drawn = data::drawn();
    // `paper` is another method than the study's.
    let lines = lines().into_iter().filter(|line| line.name != "paper");
    let all: Vec<(&str, f64, f64)> = lines
        .map(|line| {
            let rms = error(&scenario(DELAYS_MS[1], line.told, line.set), &drawn);
            println!("{:20} {rms:.5} ({})", line.name, line.study[1]);
            (line.name, line.study[1], rms)
        })
        .collect();
    let mut pairs = 0;
    for (better, study, rms) in &all {
        for (worse, of_worse, its_rms) in &all {
            if *of_worse > 5.0 * study {
                pairs += 1;
                assert!(rms < its_rms, "{better} {rms}, {worse} {its_rms}");
            }
        }
    }
    assert!(pairs > 10, "{pairs}");
}

/// What distinguishes `paper` from the study's line: the sech gain uses the displacement from the start of the test. When a
/// yielded specimen vibrates about an offset, the gain treats that offset as motion and removes the damping; the smaller its
/// exponent, the less.
#[test]
fn the_sech_gain_is_what_sets_eq_20_apart_on_a_specimen_that_yields() {
    let rms = |gamma: Option<f64>, shaking: &Shaking| {
        let set: fn(&mut Compensation) = match gamma {
            Some(_) => |c| c.kind = Method::Paper,
            None => |c| c.kind = Method::Eq14,
        };
        let mut s = scenario(4.0, 1.0, set);
        s.config.compensation.gamma = gamma.unwrap_or(0.05);
        error(&s, shaking)
    };
    // Kobe leaves a larger offset than Tabas; a drawn motion does so with a push.
    let mut motions = data::motions();
    motions.retain(|(name, _)| *name != "Tabas");
    motions[0].1.acc_m_per_s2[1600..1650].fill(8.0);
    for (name, shaking) in &motions {
        let [without, small, published] =
            [None, Some(0.005), Some(0.05)].map(|gamma| rms(gamma, shaking));
        println!(
            "{name}, 4 ms: Eq 14 {without:.5}, Eq 20 with gamma .005 {small:.5}, .05 {published:.5}"
        );
        // A push leaves more of an offset than Kobe.
        let most = if *name == "drawn" { 4.0 } else { 1.2 };
        assert!(published > 4.0 * without.max(small) && small < most * without);
    }
}
