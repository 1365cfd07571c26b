//! A test on a ground motion: its strength, its length, its bench, and the ideal response for comparison.

use crate::bench::ideal;
use crate::bench::interface::{Bench, Ending, PreparedTest};
use crate::coupled::ideal::response as coupled_response;
use crate::coupled::part::CoupledPart;
use crate::coupled::settings;
use crate::failure::Failure;
use crate::files::ground_motion::GroundMotionFile;
use crate::files::test::{Excitation, TestFile};
use crate::floors::with_floors;
use crate::memory;
use crate::numbers::{percent, si, three};
use crate::rig::improvement::remark_on_lateness;
use crate::stability::variation::Variation;
use crate::trace::{Response, TestObserver};
use outerloop_core::{Config, Design, GroundMotion, Method, Rig, config::Filter};
use plant::RigSpec;
use plant::coupled::CoupledRigSpec;
use std::f64::consts::TAU;

/// A test and its ground motion.
///
/// ```
/// use experiment::Experiment;
/// use experiment::files::near_fault::near_fault;
/// use experiment::files::test::TestFile;
/// use std::path::Path;
///
/// let file = "[structure]\nmass_kg = 1000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.02\n\
///             [excitation]\npeak_response_mm = 20\n\
///             [plant.actuator]\nkind = 'delay'\ndelay_ms = 4\n";
/// let test = TestFile::parse(file, "frame.toml", Path::new(""), &[])?;
/// let method = test.config.compensation.kind;
/// let experiment = Experiment::new(test, &near_fault(), Some(6.0))?;
/// let ideal = experiment.ideal()?;
/// // Seed 1; the trace is not kept, and there is no observer.
/// let run = experiment.run(method, &ideal, 1, false, ())?;
/// assert!(run.summary.eps_rms < 0.05, "{}", run.summary.sentence());
/// # Ok::<(), experiment::failure::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct Experiment {
    /// The test file.
    pub test: TestFile,
    /// Name of the ground motion.
    pub record: String,
    /// Length including the rest, s of model time.
    pub seconds: f64,
    /// Factor on the ground motion.
    pub scale: f64,
    /// Length of the ground motion itself, s of model time.
    shaken_s: f64,
    acc_m_per_s2: Vec<f32>,
    interval_s: f64,
}

/// The points of the ground motion as the test uses them: with the rest before it, times the factor.
#[derive(Clone, Copy, Debug)]
pub struct Shaking<'a> {
    /// Ground acceleration, m/s^2.
    pub acc_m_per_s2: &'a [f32],
    /// Interval of the points, s of model time.
    pub interval_s: f64,
}

/// Range of natural frequencies of structures, Hz.
const USUAL_HZ: std::ops::RangeInclusive<f64> = 0.1..=50.0;

/// Largest damping ratio of a structure.
const USUAL_DAMPING: f64 = 0.2;
/// Largest mean of an earthquake, as a fraction of its peak.
const MOST_OFFSET: f64 = 0.1;

/// Longest test, s of model time; a longer duration is refused as a typing error.
const LONGEST_S: f64 = 3600.0;

/// A ground motion at the intervals of a test, before its factor.
#[derive(Clone, Debug)]
pub struct LaidOutShaking {
    /// Ground acceleration, m/s^2.
    pub acc_m_per_s2: Vec<f32>,
    /// Interval of the points, s of model time.
    pub interval_s: f64,
    /// Length of the test including the rest, s of model time.
    pub seconds: f64,
    /// Length of the ground motion itself, s of model time.
    pub shaken_s: f64,
}

/// Resamples `shaking`, all of it or its first seconds, and puts the rest that the excitation asks for before it.
///
/// # Errors
/// A duration that is no positive number.
pub fn shaken(
    excitation: &Excitation,
    shaking: &GroundMotionFile,
    duration_s: Option<f64>,
) -> Result<LaidOutShaking, Failure> {
    let whole = (shaking.acc_m_per_s2.len() - 1) as f64 * shaking.interval_s;
    let seconds = match duration_s.or(excitation.duration_s) {
        None => whole,
        Some(s) if s > 0.0 && s <= LONGEST_S => s,
        Some(s) => {
            return Err(Failure::input(format!(
                "a duration of {s} s (excitation.duration_s, or --duration) is refused: accepted are seconds above 0, up to {LONGEST_S}"
            )));
        }
    };
    // The rest is a whole number of intervals, so that the points of the record do not change.
    let still = (excitation.rest_s / shaking.interval_s).round() as usize;
    let seconds = seconds + still as f64 * shaking.interval_s;
    let mut acc_m_per_s2 = vec![0.0; still];
    acc_m_per_s2.extend_from_slice(&shaking.acc_m_per_s2);
    let points = (seconds / shaking.interval_s).ceil() as usize + 1;
    acc_m_per_s2.resize(points.max(acc_m_per_s2.len()), 0.0);
    Ok(LaidOutShaking {
        acc_m_per_s2,
        interval_s: shaking.interval_s,
        seconds,
        shaken_s: whole,
    })
}

impl Experiment {
    /// A test on `shaking`, all of it or the first `duration_s`; after its end the ground is at rest.
    ///
    /// # Errors
    /// A duration that is no positive number; a ground motion that cannot be resampled or, where its factor is sought,
    /// that moves nothing.
    pub fn new(
        test: TestFile,
        shaking: &GroundMotionFile,
        duration_s: Option<f64>,
    ) -> Result<Self, Failure> {
        let laid = shaken(&test.excitation, shaking, duration_s)?;
        let mut experiment = Self {
            test,
            record: shaking.name.clone(),
            seconds: laid.seconds,
            scale: 1.0,
            shaken_s: laid.shaken_s,
            acc_m_per_s2: laid.acc_m_per_s2,
            interval_s: laid.interval_s,
        };
        experiment.scale = experiment.wanted_scale()?;
        let factor = experiment.scale as f32;
        experiment
            .acc_m_per_s2
            .iter_mut()
            .for_each(|a| *a *= factor);
        Ok(experiment)
    }

    /// A test whose `shaking` has been resampled before.
    pub fn with_shaking(
        test: TestFile,
        record: String,
        seconds: f64,
        scale: f64,
        shaking: &Shaking<'_>,
    ) -> Self {
        let points = shaking.acc_m_per_s2;
        Self {
            test,
            record,
            seconds,
            scale,
            shaken_s: points.len() as f64 * shaking.interval_s,
            acc_m_per_s2: points.to_vec(),
            interval_s: shaking.interval_s,
        }
    }

    /// Its ground motion.
    pub fn shaking(&self) -> Shaking<'_> {
        Shaking {
            acc_m_per_s2: &self.acc_m_per_s2,
            interval_s: self.interval_s,
        }
    }

    /// The test file's factor, or the factor at which the elastic structure reaches the peak that the file asks for.
    fn wanted_scale(&self) -> Result<f64, Failure> {
        let wanted = &self.test.excitation;
        let Some(peak_mm) = wanted.peak_response_mm else {
            return Ok(wanted.scale);
        };
        let peak_m = match &self.test.coupled {
            None => {
                let mut rig = self.test.plant.ideal();
                rig.specimen = rig.specimen.elastic();
                let peaks = self.response(&rig)?.peaks_m();
                peaks.into_iter().fold(0.0, f64::max)
            }
            // Of x: the others have units of their own.
            Some(part) => {
                let mut rig = part.rig.clone();
                rig.specimen.springs.clear();
                self.on_coupled_rig(rig)?.ideal()?.peaks_m()[0]
            }
        };
        // Linear, without noise: the peak is proportional to the factor.
        Ok(peak_mm * 1e-3 / peak_m)
    }

    /// The same integration with an ideal actuator and ideal sensors, without compensation, filter or limits: the
    /// reference of Eqs 17 and 18.
    ///
    /// # Errors
    /// A parameter that is refused, with its name and value.
    pub fn ideal(&self) -> Result<Response, Failure> {
        let Some(part) = &self.test.coupled else {
            return self.response(&self.test.plant.ideal());
        };
        self.check_memory(self.response_bytes())?;
        let config = &self.test.config;
        let ground = self.ground(config)?;
        let ideal = with_floors!(part.coordinates(), N => {
            coupled_response::<N>(part, config, &ground, self.control_steps())
        })?;
        self.require_motion(&ideal)?;
        Ok(ideal)
    }

    /// The same test of two coupled actuators on another rig.
    ///
    /// # Errors
    /// A test of another kind.
    pub fn on_coupled_rig(&self, rig: CoupledRigSpec) -> Result<Self, Failure> {
        let declared = self.test.coupled_part()?.declared.clone();
        let mut own = self.clone();
        own.test.coupled = Some(Box::new(CoupledPart { declared, rig }));
        Ok(own)
    }

    /// The ideal responses of tests that differ from this one only in their rigs: computed together, faster than one by
    /// one, with the same bits. Those of coupled actuators are computed one by one.
    ///
    /// # Errors
    /// As of [`Experiment::ideal`].
    pub fn ideals(&self, tests: &[&Self]) -> Result<Vec<Response>, Failure> {
        if self.test.coupled.is_some() {
            return tests.iter().map(|own| own.ideal()).collect();
        }
        let rigs: Vec<RigSpec> = tests.iter().map(|own| own.test.plant.ideal()).collect();
        self.responses(&rigs)
    }

    /// The response of `rig` without compensation, filter or limits; every floor moves in it.
    fn response(&self, rig: &RigSpec) -> Result<Response, Failure> {
        let mut one = self.responses(std::slice::from_ref(rig))?;
        Ok(one.remove(0))
    }

    fn responses(&self, rigs: &[RigSpec]) -> Result<Vec<Response>, Failure> {
        let mut config = self.test.config.clone();
        config.compensation.kind = Method::None;
        config.estimation.kind = Filter::Off;
        config.limits = Default::default();
        config.structure.physical_mass_kg.clear();
        config.rig = Default::default();
        let ground = self.ground(&config)?;
        self.check_memory(self.response_bytes() * rigs.len() as u64)?;
        let responses = with_floors!(config.degrees_of_freedom(), N => {
            let design = Design::<N>::new(&config).map_err(Failure::input)?;
            ideal::responses(rigs, &config, &design, &ground, self.control_steps())
        })?;
        for response in &responses {
            self.require_motion(response)?;
        }
        Ok(responses)
    }

    /// Checks that every floor, or coordinate, moves by a finite displacement.
    fn require_motion(&self, ideal: &Response) -> Result<(), Failure> {
        let peaks = ideal.peaks_m();
        let Some(still) = peaks.iter().position(|p| !(*p > 0.0 && p.is_finite())) else {
            return Ok(());
        };
        let (peak, seconds, record) = (peaks[still], self.seconds, &self.record);
        let said = match &self.test.coupled {
            None => format!(
                "floor {} of the ideal structure moves by {peak} m in {seconds} s: accepted are tests in which every floor \
                 moves",
                still + 1
            ),
            Some(part) => format!(
                "coordinate {} of the ideal structure moves by {peak} in {seconds} s: accepted are tests in which every \
                 coordinate moves",
                part.declared.structure.coordinates[still]
            ),
        };
        Err(Failure::input(format!(
            "{record}: {said}, by a finite displacement"
        )))
    }

    /// Runs `config` on any bench.
    ///
    /// # Errors
    /// A parameter that is refused, with its name and value; a bench that cannot be set up.
    pub fn run_config(
        &self,
        bench: &impl Bench,
        config: &Config,
        observer: &mut dyn TestObserver,
    ) -> Result<Ending, Failure> {
        let ground = self.ground(config)?;
        let steps = self.control_steps();
        with_floors!(config.degrees_of_freedom(), N => {
            let Some(part) = &self.test.coupled else {
                let design = Design::<N>::new(config).map_err(Failure::input)?;
                return bench.run(&self.prepared(config, design, ground, steps), observer);
            };
            let kind = part.declared.compensation;
            let design = settings::design::<N>(&part.declared, config, kind)?;
            bench.run_coupled(part, &self.prepared(config, design, ground, steps), observer)
        })
    }

    fn prepared<'a, const N: usize, R: Rig<N>>(
        &'a self,
        config: &'a Config,
        design: Design<N, R>,
        ground: GroundMotion<'a>,
        steps: usize,
    ) -> PreparedTest<'a, N, R> {
        PreparedTest {
            config,
            design,
            ground,
            points_m_per_s2: &self.acc_m_per_s2,
            interval_s: self.interval_s,
            steps,
        }
    }

    /// The ground motion, step by step.
    pub(crate) fn ground(&self, config: &Config) -> Result<GroundMotion<'_>, Failure> {
        let step_s = config.model_step_s();
        GroundMotion::new(&self.acc_m_per_s2, self.interval_s, step_s).ok_or_else(|| {
            Failure::input(format!(
                "{}: an interval of {} s cannot be laid over integration steps of {step_s} s",
                self.record, self.interval_s
            ))
        })
    }

    /// The same on a rig that differs by `vary`, which is not declared to the loop.
    pub fn on_rig(&self, vary: &Variation) -> Self {
        let mut own = self.clone();
        match &mut own.test.coupled {
            None => own.test.plant = vary.of(&own.test.plant, &own.test.config),
            Some(part) => part.rig = vary.of_coupled(&part.rig),
        }
        own
    }

    /// Control steps of the running test.
    pub fn control_steps(&self) -> usize {
        let timing = &self.test.config.timing;
        (self.seconds * timing.time_scale * timing.rate_hz).round() as usize
    }

    /// Of the displacements of all floors at all integration steps, in single precision.
    fn response_bytes(&self) -> u64 {
        let config = &self.test.config;
        let steps = self.control_steps() / usize::from(config.timing.substeps);
        4 * (steps * config.degrees_of_freedom()) as u64
    }

    /// Memory for the test and its ideal response, bytes. `keep`: every control step is kept and written.
    pub fn memory_bytes(&self, keep: bool) -> u64 {
        let floors = self.test.config.degrees_of_freedom() as u64;
        // Numbers of a control step that a trace holds, and that HDF5 holds once more; in CSV each takes 11 letters.
        let numbers = 9 + 10 * floors;
        let kept = if keep { numbers * (4 + 4 + 11) } else { 0 };
        2 * self.response_bytes() + kept * self.control_steps() as u64
    }

    /// Checks that so much memory is available.
    ///
    /// # Errors
    /// Less.
    pub fn check_memory(&self, bytes: u64) -> Result<(), Failure> {
        let accepted = "shorter tests (excitation.duration_s), a smaller loop.time_scale, a lower loop.rate_hz";
        memory::check(&self.size_in_words(), bytes, accepted)
    }

    /// What a test says before it takes much of the machine; `keep`: every control step is kept.
    pub fn note_of_size(&self, keep: bool) -> Option<String> {
        let bytes = memory::worth_saying(self.memory_bytes(keep))?;
        Some(format!(
            "{} take about {bytes} of memory",
            self.size_in_words()
        ))
    }

    fn size_in_words(&self) -> String {
        let steps = self.control_steps() as f64;
        let hours = steps / self.test.config.timing.rate_hz / 3600.0;
        format!(
            "{} million control steps, {} h in the laboratory,",
            three(1e-6 * steps),
            three(hours)
        )
    }

    /// How many of the coordinates, from the first, are displacements that can be compared: of two coupled actuators x alone.
    pub fn floors_in_m(&self) -> usize {
        match self.test.coupled {
            None => self.test.config.degrees_of_freedom(),
            Some(_) => 1,
        }
    }

    /// 1 / (2 M_1 omega_1): turns the C_cor of the first floor into a ratio of critical.
    pub fn per_critical(&self) -> f64 {
        // A configuration that was refused never comes here.
        let lowest_hz = self.natural_frequencies_hz().first().copied();
        0.5 / (self.test.config.structure.mass_kg[0] * TAU * lowest_hz.unwrap_or(f64::NAN))
    }

    /// Natural frequencies of the structure as it is declared, Hz, from the lowest; empty for a structure that is
    /// refused.
    pub fn natural_frequencies_hz(&self) -> Vec<f64> {
        if let Some(part) = &self.test.coupled {
            return settings::natural_frequencies_hz(&part.declared).unwrap_or_default();
        }
        let config = &self.test.config;
        let rad_per_s = with_floors!(config.degrees_of_freedom(), N => {
            let own = config.frame::<N>().and_then(|frame| frame.natural_frequencies_rad_per_s());
            own.map(Vec::from).map_err(Failure::input)
        });
        let rad_per_s = rad_per_s.unwrap_or_default();
        rad_per_s.iter().map(|w| w / TAU).collect()
    }

    /// The structure and the test in a line.
    pub fn in_words(&self) -> String {
        let hz: Vec<String> = self
            .natural_frequencies_hz()
            .into_iter()
            .map(three)
            .collect();
        format!(
            "{} of {}, on a structure of {} Hz{}.",
            si(self.seconds, "s"),
            self.record,
            hz.join(", "),
            match self.test.coupled {
                None => "",
                Some(_) => " that two coupled actuators move in x and in rotation",
            }
        )
    }

    /// Warnings before the test runs, where a value looks like a typing error or the compensation leaves a lateness.
    pub fn remarks(&self) -> Vec<String> {
        let late = remark_on_lateness(&self.test.config);
        let mut remarks: Vec<String> = late.into_iter().collect();
        if let Some(hz) = self.natural_frequencies_hz().first()
            && !USUAL_HZ.contains(hz)
        {
            remarks.push(format!(
                "The structure's natural period is {}: structures have 0.02 to 10 s; is the stiffness in N/m and the mass \
                 in kg?",
                si(1.0 / hz, "s")
            ));
        }
        let damping = &self.test.config.structure.damping_ratio;
        if let Some(ratio) = damping.iter().find(|ratio| **ratio > USUAL_DAMPING) {
            remarks.push(format!(
                "A damping ratio of {} is {} of critical: structures have 0.5 to 10 %; is it a fraction of critical?",
                three(*ratio),
                percent(*ratio)
            ));
        }
        let acc = &self.acc_m_per_s2;
        let mean = acc.iter().map(|a| f64::from(*a)).sum::<f64>() / acc.len().max(1) as f64;
        let peak = acc.iter().fold(0.0_f64, |p, a| p.max(f64::from(a.abs())));
        if mean.abs() > MOST_OFFSET * peak {
            remarks.push(format!(
                "The ground motion {} has a mean of {}, {} of its peak: is its zero right? A structure stands aside by it.",
                self.record,
                si(mean, "m/s²"),
                percent(mean.abs() / peak)
            ));
        }
        let shaken_s = self.shaken_s;
        if shaken_s < 0.5 * self.seconds {
            remarks.push(format!(
                "The ground motion {} is {} long and the test {}: what follows it is rest.",
                self.record,
                si(shaken_s, "s"),
                si(self.seconds, "s")
            ));
        }
        remarks
    }
}
