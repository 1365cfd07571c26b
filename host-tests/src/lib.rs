//! Scenarios across crates: core's loop on plant's rig, judged by the paper's errors.
//!
//! The driver here is independent of the PC tool's, so that a figure printed by both has been computed twice.

pub mod call_graph;
pub mod compensations;
pub mod data;
pub mod exam;
pub mod foresight;
pub mod frame;
pub mod loopback;
pub mod outside;
pub mod proof;
pub mod qemu;
pub mod simulated;
pub mod surveys;
pub mod targets;

use outerloop_core::{
    Config, Design, Event, GroundMotion, Method, Mode, OuterLoop, Record, Sample, config::Filter,
};
use plant::{Rig, RigSpec};

/// A test and its rig, as a few lines of a test file: the tables of `[plant]` without their headers.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The test.
    pub config: Config,
    /// `plant.actuator`.
    pub actuator: String,
    /// `plant.specimen`.
    pub specimen: String,
    /// `plant.sensors`.
    pub sensors: String,
}

impl Scenario {
    /// A linear specimen behind a pure delay, without noise.
    pub fn delayed(config: Config, delay_ms: f64) -> Self {
        Self {
            config,
            actuator: format!("kind = 'delay'\ndelay_ms = {delay_ms:?}"),
            specimen: "kind = 'linear'".into(),
            sensors: String::new(),
        }
    }

    /// The same with another compensation.
    pub fn with(&self, method: Method) -> Self {
        let mut other = self.clone();
        other.config.compensation.kind = method;
        other
    }

    /// The rig that the tables describe.
    ///
    /// # Panics
    /// They cannot be read.
    pub fn rig(&self) -> RigSpec {
        let text = format!(
            "[actuator]\n{}\n[specimen]\n{}\n[sensors]\n{}",
            self.actuator, self.specimen, self.sensors
        );
        toml::from_str(&text).expect("a readable rig")
    }

    /// Runs `seconds` of model time.
    ///
    /// # Panics
    /// The configuration or the rig is refused: a scenario is expected to be possible.
    pub fn run<const N: usize>(&self, shaking: &Shaking, seconds: f64, seed: u64) -> Trace<N> {
        run(&self.config, &self.rig(), shaking, seconds, seed)
    }

    /// The same integration with an ideal actuator and ideal sensors, without compensation or filter.
    pub fn ideal<const N: usize>(&self, shaking: &Shaking, seconds: f64) -> Trace<N> {
        let mut ideal = self.with(Method::None);
        ideal.config.estimation.kind = Filter::Off;
        ideal.actuator = "kind = 'ideal'".into();
        ideal.sensors.clear();
        ideal.run(shaking, seconds, 0)
    }
}

/// Table 1 of the paper.
pub fn table1() -> Config {
    Config::shear_frame([1000.0], [158e3], [0.02])
}

/// The same test with everything on: two-stage filter, every interlock, noise on both sensors.
pub fn whole_pipeline(mut scenario: Scenario) -> Scenario {
    let config = &mut scenario.config;
    config.estimation.kind = Filter::Kalman;
    config.estimation.delay_ms = 3.7.into();
    config.estimation.lag_ms = 0.5.into();
    config.limits.displacement_m = Some(0.5);
    config.limits.increment_m = Some(2e-3);
    config.limits.velocity_m_per_s = Some(3.0);
    config.limits.force_n = Some(1e5);
    config.limits.tracking_m = Some(0.05);
    config.limits.energy_warning = Some(1.0);
    config.limits.energy_trip = Some(10.0);
    config.limits.stale_steps = Some(5);
    scenario.sensors = "displacement_noise_mm = 0.02\nforce_noise_n = 10.0".into();
    scenario
}

/// A recorded or generated ground motion.
#[derive(Clone, Debug)]
pub struct Shaking {
    /// Acceleration, m/s^2.
    pub acc_m_per_s2: Vec<f32>,
    /// Interval between points, s.
    pub interval_s: f64,
}

impl Shaking {
    /// The same with zeros after it, so that it lasts `seconds`.
    pub fn followed_by_rest(mut self, seconds: f64) -> Self {
        let points = (seconds / self.interval_s).ceil() as usize + 1;
        self.acc_m_per_s2
            .resize(points.max(self.acc_m_per_s2.len()), 0.0);
        self
    }
}

/// The part of a test that counts: one record a control step from the start to the end.
#[derive(Clone, Debug)]
pub struct Trace<const N: usize> {
    /// Records of the running test.
    pub records: Vec<Record<N>>,
    /// The loop's mode at the end.
    pub mode: Mode,
    /// Hash over all records.
    pub hash: u64,
}

/// The closed loop; idles, arms and approaches before the part that is kept.
fn run<const N: usize>(
    config: &Config,
    rig: &RigSpec,
    shaking: &Shaking,
    seconds: f64,
    seed: u64,
) -> Trace<N> {
    let steps = (seconds * config.timing.time_scale * config.timing.rate_hz).round() as usize;
    let physical = config.physical_storeys();
    let storeys = &config.structure.stiffness_n_per_m[..physical];
    let mut rig = Rig::new(rig, storeys, config.timing.rate_hz, seed).expect("a possible rig");
    let mut outer = OuterLoop::<N>::new(Design::new(config).expect("a possible test"));
    let ground = GroundMotion::new(
        &shaking.acc_m_per_s2,
        shaking.interval_s,
        config.model_step_s(),
    )
    .expect("a possible record");
    let mut command = vec![0.0; physical];
    let mut trace = Trace {
        records: Vec::with_capacity(steps),
        mode: Mode::Idle,
        hash: Record::<N>::HASH_START,
    };
    for tick in 0.. {
        let reading = rig.step(&command);
        let mut sample = Sample::new([0.0; N], [0.0; N]);
        for j in 0..physical {
            sample.displacement_m[j] = reading.displacement_m[j] as f32;
            sample.force_n[j] = reading.force_n[j] as f32;
        }
        let before = outer.mode();
        let step = outer.step(&sample, &ground);
        for j in 0..physical {
            command[j] = f64::from(step.command_m[j]);
        }
        match before {
            Mode::Idle if tick >= 200 => {
                outer
                    .handle(Event::Arm)
                    .expect("nothing stands against arming");
            }
            Mode::Armed => {
                let _ = outer.handle(Event::Start);
            }
            now if now.integrates() => {
                trace.hash = step.record.hash(trace.hash);
                trace.records.push(*step.record);
            }
            _ => {}
        }
        trace.mode = outer.mode();
        let over = matches!(trace.mode, Mode::Finished | Mode::Tripped);
        if trace.records.len() == steps || over {
            break;
        }
    }
    trace
}

/// Eqs 17 and 18 for one floor: largest and rms error, relative to the largest ideal displacement.
pub fn eps<const N: usize>(trace: &Trace<N>, ideal: &Trace<N>, floor: usize) -> (f64, f64) {
    let u = |r: &Record<N>| f64::from(r.command_m[floor]);
    let peak = ideal.records.iter().fold(0.0_f64, |p, r| p.max(u(r).abs()));
    let (mut largest, mut square) = (0.0_f64, 0.0);
    for (a, b) in trace.records.iter().zip(&ideal.records) {
        let e = (u(a) - u(b)) / peak;
        largest = largest.max(e.abs());
        square += e * e;
    }
    (largest, (square / trace.records.len() as f64).sqrt())
}
