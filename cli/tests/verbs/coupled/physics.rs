//! Exact solutions, symmetry, energies, a hold.

use super::{EXACT, experiment, interface, run};
use experiment::trace::{AnyRecord, TestObserver};
use experiment::{Experiment, Shaking};
use nalgebra::{SMatrix, SVector};
use outerloop_core::{Event, Mode};
use plant::linear::Linear;

#[test]
fn without_actuator_error_it_is_the_exact_solution() {
    let (e, ideal, record, summary) = run(&EXACT);
    assert!(summary.eps_max < 1e-5, "{}", summary.eps_max);
    // u'' = M^-1 (-K u - C u') - iota a_g, with the ground acceleration linear between samples.
    let s = &e.test.coupled_part().unwrap().declared.structure;
    let square = |m: &[Vec<f64>]| SMatrix::<f64, 2, 2>::from_fn(|i, j| m[i][j]);
    let (mass, stiffness) = (square(&s.mass), square(&s.stiffness));
    // The same damping ratio in both modes: C = 2 zeta M sqrt(M^-1 K).
    let root_m = SMatrix::<f64, 2, 2>::from_diagonal(&mass.diagonal().map(f64::sqrt));
    let per_root = SMatrix::<f64, 2, 2>::from_diagonal(&mass.diagonal().map(|x| 1.0 / x.sqrt()));
    let modes = (per_root * stiffness * per_root).symmetric_eigen();
    let w = SMatrix::<f64, 2, 2>::from_diagonal(&modes.eigenvalues.map(f64::sqrt));
    let c = root_m * modes.eigenvectors * w * modes.eigenvectors.transpose() * root_m * 0.08;
    let inverse = mass.try_inverse().unwrap();
    let mut a = SMatrix::<f64, 4, 4>::zeros();
    a.fixed_view_mut::<2, 2>(0, 2).fill_with_identity();
    a.fixed_view_mut::<2, 2>(2, 0)
        .copy_from(&(-inverse * stiffness));
    a.fixed_view_mut::<2, 2>(2, 2).copy_from(&(-inverse * c));
    let mut b = SMatrix::<f64, 4, 1>::zeros();
    b[2] = -1.0;
    let mut exact = Linear::new(&a, &b, e.test.config.model_step_s());
    let peaks = ideal.peaks_m();
    for n in 0..record.len() {
        for j in 0..2 {
            let off = (exact.state[j] - f64::from(record.floors[j].command_m[n])).abs();
            assert!(off < 4e-3 * peaks[j], "{n} {j}: {off}");
        }
        let at = |n: usize| SVector::from([f64::from(record.ground_m_per_s2[n])]);
        let next = (n + 1).min(record.len() - 1);
        exact.step(&at(n), &at(next));
    }
}

#[test]
fn with_a_coupling_that_vanishes_x_moves_as_one_degree_of_freedom() {
    let stiffness = [
        "coupled.structure.stiffness=[[208e3,1],[1,192e3]]",
        "coupled.specimen.stiffness=[[104e3,0],[0,96e3]]",
    ];
    let overrides = [&EXACT[..], &stiffness[..]].concat();
    let (e, ideal, record, _) = run(&overrides);
    let peaks = ideal.peaks_m();
    assert!(peaks[1] < 1e-3 * peaks[0]);
    let w: f64 = 208.0_f64.sqrt();
    let a = SMatrix::<f64, 2, 2>::new(0.0, 1.0, -w * w, -0.08 * w);
    let b = SMatrix::<f64, 2, 1>::new(0.0, -1.0);
    let mut exact = Linear::new(&a, &b, e.test.config.model_step_s());
    for n in 0..record.len() - 1 {
        let off = (exact.state[0] - f64::from(record.floors[0].command_m[n])).abs();
        assert!(off < 2e-3 * peaks[0], "{n}: {off}");
        let at = |n: usize| SVector::from([f64::from(record.ground_m_per_s2[n])]);
        exact.step(&at(n), &at(n + 1));
    }
}

#[test]
fn a_shaking_turned_round_turns_everything_round() {
    // With both pins at the x of the interface point, rotations of either sign move them alike.
    let quiet = [
        "coupled.coupler.pin_x_m=[0,0]",
        "plant.sensors.displacement_noise_mm=0",
        "plant.sensors.force_noise_n=0",
    ];
    let plus = run(&quiet).2;
    let e = experiment(&quiet);
    let turned: Vec<f32> = e.shaking().acc_m_per_s2.iter().map(|a| -a).collect();
    let shaking = Shaking {
        acc_m_per_s2: &turned,
        ..e.shaking()
    };
    let e = Experiment::with_shaking(e.test.clone(), String::new(), e.seconds, e.scale, &shaking);
    let kind = e.test.compensation();
    let minus = e
        .run(kind, &e.ideal().unwrap(), 1, true, ())
        .unwrap()
        .trace
        .unwrap();
    let [first, second] = [0, 1].map(|i| (&plus.floors[i], &minus.floors[i]));
    for (a, b) in [
        (&first.0.command_m, &first.1.command_m),
        (&second.0.command_m, &second.1.command_m),
        (&second.0.sent_m, &second.1.sent_m),
        (&second.0.estimated_force_n, &second.1.estimated_force_n),
    ] {
        assert!(a.len() == 12_000 && a.len() == b.len());
        let peak = a.iter().fold(0.0_f32, |m, x| m.max(x.abs()));
        let off = a
            .iter()
            .zip(b)
            .fold(0.0_f32, |m, (x, y)| m.max((x + y).abs()));
        assert!(off < 1e-4 * peak, "{off} of {peak}");
    }
}

#[test]
fn energies_balance_over_the_interface() {
    let (_, _, record, summary) = run(&["coupled.compensation=coupled-fixed"]);
    let (of_interface, floors) = (interface(&record), &record.floors);
    // Eq 12 less HSEM is the final R (u_m - u_c), the sum of its increments.
    let last = record.len() - 1;
    let left: f64 = (0..2)
        .map(|i| {
            let (moved, floor) = (&of_interface.displacement[i], &floors[i]);
            let error = |n: usize| f64::from(moved[n]) - f64::from(floor.command_m[n]);
            let force = |n: usize| f64::from(floor.estimated_force_n[n]);
            force(last) * error(last) - force(0) * error(0)
        })
        .sum();
    let balance = summary.energy_error_j - summary.energy_error_hsem_j - left;
    assert!(
        balance.abs() < 1e-6 * summary.energy_error_j.abs(),
        "{balance}"
    );
    // The work of the actuators on their strokes is that of force and moment on x and rotation.
    let (mut strokes, mut interface, mut turned) = (0.0, 0.0, 0.0);
    for n in 1..record.len() {
        let work = |force: &[f32], at: &[f32]| {
            0.5 * (f64::from(force[n]) + f64::from(force[n - 1]))
                * (f64::from(at[n]) - f64::from(at[n - 1]))
        };
        for i in 0..2 {
            strokes += work(&floors[i].force_n, &of_interface.true_stroke_m[i]);
            interface += work(&floors[i].estimated_force_n, &of_interface.truth[i]);
            turned += work(&floors[i].estimated_force_n, &of_interface.truth[i]).abs();
        }
    }
    assert!(
        (strokes - interface).abs() < 2e-3 * turned,
        "{strokes} {interface} of {turned}"
    );
}

/// Holds a running test, and measures how far the interface is from its target.
#[derive(Default)]
struct Held {
    done: usize,
    steps: usize,
    target: [f32; 2],
    off: [f32; 2],
}

impl TestObserver for Held {
    fn on_step(&mut self, _: &AnyRecord<'_>) {
        self.done += 1;
    }

    fn on_idle_step(&mut self, r: &AnyRecord<'_>) {
        if r.mode() == Some(Mode::Holding) {
            self.steps += 1;
            self.target = [0, 1].map(|i| r.command_m[i]);
            self.off = [0, 1].map(|i| r.estimated_displacement_m[i] - r.command_m[i]);
        }
    }

    fn requested_event(&mut self) -> Option<Event> {
        match (self.done, self.steps) {
            (6350, 0) => Some(Event::Hold),
            (_, 1500) => Some(Event::Stop),
            _ => None,
        }
    }
}

/// The structure's modes, which a hold stops, would otherwise pull the interface towards zero.
#[test]
fn in_a_hold_the_interface_stands_where_it_is_held() {
    let e = experiment(&[]);
    let mut held = Held::default();
    let ideal = e.ideal().unwrap();
    e.run(e.test.compensation(), &ideal, 1, false, &mut held)
        .unwrap();
    let Held {
        steps, target, off, ..
    } = held;
    println!("off by {off:?} of {target:?}");
    assert!(
        steps >= 1500 && target[0].abs() > 5e-3,
        "{steps} {target:?}"
    );
    assert!(
        off[0].abs() < 5e-5 && off[1].abs() < 5e-4,
        "{off:?} of {target:?}"
    );
}
