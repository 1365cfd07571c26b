//! Cycles of a step on the board, by a model of its core and its flash, against the deadline.
#![allow(missing_docs)]

use host_tests::qemu::bench::{drive, rig, solved};
use host_tests::qemu::cycles::{Code, Cost};
use host_tests::qemu::image::image;
use host_tests::qemu::machine::{Clock, Machine, Test};
use host_tests::{Scenario, Shaking, table1, whole_pipeline};
use outerloop_core::{Config, Event, Method, Mode, Prediction};
use std::path::Path;

/// From the sample to the command, 25 us at 168 MHz.
const DEADLINE: u64 = 4200;

/// What three storeys should take at most.
const AIM: u64 = 3400;

/// Control periods from power-up on: idle, armed, then strong motion.
const PERIODS: u32 = 90;

/// Five metres a second squared from the first point on, so that predictors learn and dampings act after some steps.
fn shaking() -> Shaking {
    let point = |i: usize| (5.0 * (18.0 * i as f64 * 0.01).cos()) as f32;
    Shaking {
        acc_m_per_s2: (0..200).map(point).collect(),
        interval_s: 0.01,
    }
}

fn script(tick: u32, mode: Mode) -> (Option<Event>, Option<outerloop_core::Fault>) {
    let event = match mode {
        Mode::Idle if tick >= 2 => Some(Event::Arm),
        Mode::Armed => Some(Event::Start),
        _ => None,
    };
    (event, None)
}

/// The whole pipeline on `N` storeys, the lowest of which stands in the laboratory and yields.
fn scenario<const N: usize>(method: Method) -> Scenario {
    let mut config = table1();
    if N > 1 {
        config = Config::shear_frame([1000.0; N], [797.3e3; N], [0.02; N]);
        config.structure.physical_storeys = Some(1);
    }
    let mut scenario = whole_pipeline(Scenario::delayed(config, 4.0)).with(method);
    scenario.specimen = "kind = 'bilinear'\nyield_mm = 2.0\nhardening_ratio = 0.05".into();
    // What is measured has noise from the first step on.
    scenario.config.limits.increment_m = Some(1.0);
    scenario.config.limits.velocity_m_per_s = Some(100.0);
    scenario
}

/// The dearest step.
fn worst<const N: usize>(image: &Path, code: &Code, method: Method) -> Cost {
    let scenario = scenario::<N>(method);
    let shaking = shaking();
    let filter = code.filter();
    let mut machine = Machine::<N>::start_filtered(image, Clock::Tracing, Some(&filter)).unwrap();
    let trace = machine.trace().unwrap();
    let test = Test {
        config: &scenario.config,
        shaking: &shaking,
    };
    let (costs, records) = std::thread::scope(|scope| {
        let reader = scope.spawn(|| code.steps(trace).unwrap());
        machine.begin(&test).unwrap();
        let records = drive::<N>(PERIODS, &script, rig(&scenario, 1), |event, sample| {
            let (answer, words) = machine.period(event, sample)?;
            Ok((answer.command_m, words))
        });
        machine.end().unwrap();
        (reader.join().unwrap(), records.unwrap())
    });
    assert_eq!(costs.len(), records.len(), "a step each period");
    let costs = costs.iter().zip(&records);
    let costs: Vec<_> = costs.filter(|(_, words)| solved(words)).collect();
    assert!(costs.len() > 60, "{method}: {} steps solved", costs.len());
    let dearest = costs.iter().max_by_key(|(cost, _)| cost.cycles);
    dearest.map(|(cost, _)| **cost).unwrap_or_default()
}

#[test]
fn cycles_of_a_step_with_every_method() {
    let Some(image) = image("qemu", "qemu") else {
        return;
    };
    let code = Code::new(&std::fs::read(&image).unwrap()).unwrap();
    println!(
        "worst step, one storey in the laboratory   1 storey             2 storeys            3 storeys"
    );
    println!("instructions, cycles without waiting, cycles from the flash at 168 MHz");
    let (mut too_long, mut beyond_aim) = (Vec::new(), Vec::new());
    let behind = Prediction::ALL[1..]
        .iter()
        .map(|&p| Method::Paper.behind(p));
    for method in Method::ALL.into_iter().chain(behind) {
        let costs = [
            worst::<1>(&image, &code, method),
            worst::<2>(&image, &code, method),
            worst::<3>(&image, &code, method),
        ];
        print!("{:28}", method.name());
        for c in costs {
            print!(
                "  {:5} {:5} {:5}",
                c.instructions, c.without_waiting, c.cycles
            );
        }
        let late = costs.iter().any(|c| c.cycles > DEADLINE);
        println!(
            "{}",
            if late {
                "  later than the deadline"
            } else {
                ""
            }
        );
        if late {
            too_long.push(method.name());
        }
        if costs[2].cycles > AIM && Method::ALL.contains(&method) {
            beyond_aim.push(method.name());
        }
    }
    // A board refuses at `Configure` what it has timed as too long.
    assert!(too_long.is_empty(), "more than {DEADLINE}: {too_long:?}");
    let known = ["hydraulic", "ahmadizadeh", "tangent"];
    assert_eq!(beyond_aim, known, "more than {AIM} cycles");
}
