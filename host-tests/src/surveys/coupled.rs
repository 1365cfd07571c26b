//! Tests of two coupled actuators, drawn for the verdicts: frames with different frequencies and coupling; actuators with
//! different poles, delays and cross terms; specimens that yield; and a rig that differs slightly from the declared one.

use super::verdicts::UniformDraws;
use experiment::coupled::table::CoupledCompensation;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Mass, kg, and moment of inertia, kg m^2, of the frame's corner.
const MASS: [f64; 2] = [1000.0, 60.0];
/// Largest relative deviation of the rig's poles, zeros and delays, and of its gains, from the declared ones.
const TIMES_OFF: f64 = 0.10;
const GAINS_OFF: f64 = 0.02;

/// This many test files, with the compensations in turn.
pub fn draw(rigs: usize, seed: u64) -> Vec<String> {
    let mut rng = UniformDraws::new(seed);
    let kinds = CoupledCompensation::ALL.into_iter().cycle();
    kinds
        .take(rigs)
        .map(|kind| test_file(kind, &mut rng))
        .collect()
}

fn test_file(kind: CoupledCompensation, rng: &mut UniformDraws) -> String {
    let hz = [rng.between(1.0, 4.0), rng.between(6.0, 12.0)];
    let [k, turn] = [0, 1].map(|i| MASS[i] * (TAU * hz[i]).powi(2));
    let cross = rng.between(0.0, 0.4) * (k * turn).sqrt();
    let share = rng.between(0.2, 0.8);
    let damping = rng.between(0.02, 0.06);
    let peak_mm = rng.between(5.0, 25.0);
    let noise_mm = rng.between(0.01, 0.04);
    let (x_m, stroke_m) = (3e-3 * peak_mm, 8e-3 * peak_mm);
    let mut text = format!(
        "[coupled]\ncompensation = '{}'\nnoise_mm = {noise_mm}\n\
         [coupled.coupler]\npin_x_m = [0.267, 0.267]\npin_y_m = [-0.127, 0.127]\n\
         [coupled.structure]\nmass = [[{}, 0], [0, {}]]\nstiffness = [[{k}, {cross}], [{cross}, {turn}]]\n\
         damping_ratio = {damping}\n\
         [coupled.specimen]\nstiffness = [[{}, {}], [{}, {}]]\n\
         [coupled.spread]\nslow_pole_ratio = 0.06\nfast_pole_ratio = 0.06\ngain_ratio = 0.03\n\
         [coupled.limits]\nstroke_m = {stroke_m}\nvelocity_m_per_s = 5\nforce_n = 1e6\ntracking_m = {stroke_m}\n\
         x_m = {x_m}\nx_velocity_m_per_s = 2\nx_force_n = 1e6\nx_tracking_m = {x_m}\nrotation_rad = 0.1\n\
         rotation_velocity_rad_per_s = 5\nmoment_n_m = 1e6\nrotation_tracking_rad = 0.1\n\
         [loop]\nrate_hz = 1000\n[excitation]\npeak_response_mm = {peak_mm}\nduration_s = 8\n\
         [plant.sensors]\ndisplacement_noise_mm = {noise_mm}\nforce_noise_n = {}\n",
        kind.name(),
        MASS[0],
        MASS[1],
        share * k,
        share * cross,
        share * cross,
        share * turn,
        rng.between(1.0, 10.0),
    );
    let declared = Actuators::drawn(rng);
    let rig = declared.differing(rng);
    let _ = write!(
        text,
        "[coupled.actuators]\n{}damping_ratio = 0.62\n[plant.coupled.actuators]\n{}",
        declared.text(),
        rig.text()
    );
    if rng.with_probability(0.5) {
        let brace = rng.between(0.02, 0.15) * share * k;
        let yields_mm = peak_mm * rng.between(0.2, 0.8);
        let _ = writeln!(
            text,
            "[plant.coupled.specimen]\nsprings = [{{ arm_m = 0.1, stiffness_n_per_m = {brace}, yield_mm = {yields_mm}, \
             hardening_ratio = 0.05 }}]"
        );
    }
    text
}

/// Two actuators; rows are strokes, columns commands.
struct Actuators {
    gain: [[f64; 2]; 2],
    slow_pole_hz: [f64; 2],
    fast_pole_hz: [f64; 2],
    path_lead_ms: [f64; 2],
    natural_hz: f64,
    delay_ms: [f64; 2],
}

impl Actuators {
    fn drawn(rng: &mut UniformDraws) -> Self {
        let cross = rng.between(0.0, 0.17);
        Self {
            gain: [[0.87, cross], [cross, 0.92]],
            slow_pole_hz: [rng.between(2.0, 8.0), rng.between(2.0, 8.0)],
            fast_pole_hz: [rng.between(15.0, 60.0), rng.between(15.0, 60.0)],
            // With a smaller second lead, the cross terms would have a zero in the right half plane.
            path_lead_ms: [rng.between(0.0, 60.0), rng.between(5.0, 60.0)],
            natural_hz: rng.between(50.0, 100.0),
            delay_ms: [rng.between(0.0, 5.0), rng.between(0.0, 5.0)],
        }
    }

    fn differing(&self, rng: &mut UniformDraws) -> Self {
        let mut off = |x: f64, most: f64| x * rng.between(1.0 - most, 1.0 + most);
        Self {
            gain: self.gain.map(|row| row.map(|g| off(g, GAINS_OFF))),
            slow_pole_hz: self.slow_pole_hz.map(|x| off(x, TIMES_OFF)),
            fast_pole_hz: self.fast_pole_hz.map(|x| off(x, TIMES_OFF)),
            path_lead_ms: self.path_lead_ms.map(|x| off(x, TIMES_OFF)),
            natural_hz: off(self.natural_hz, TIMES_OFF),
            delay_ms: self.delay_ms.map(|x| off(x, TIMES_OFF)),
        }
    }

    fn text(&self) -> String {
        let [first, second] = self.path_lead_ms;
        format!(
            "gain = {:?}\nslow_pole_hz = {:?}\nfast_pole_hz = {:?}\npath_lead_ms = [[0, {first}], [0, {second}]]\n\
             natural_hz = {}\ndelay_ms = {:?}\n",
            self.gain, self.slow_pole_hz, self.fast_pole_hz, self.natural_hz, self.delay_ms
        )
    }
}
