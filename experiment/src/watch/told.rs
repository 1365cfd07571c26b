//! What the watch of an actuator is told: what a test file declares of it, and what it may do.

use super::place::Place;
use crate::failure::Failure;
use crate::files::test::TestFile;
use crate::rig::{Departures, Quantity, noise_rms};
use diagnosis::Model;
use outerloop_core::watch::{Actions, Declared, DeclaredActuator, ErrorLimit};

/// What the watch of `test` may do about the actuator of a floor that is planned to move by so much.
pub(super) fn actions(
    test: &TestFile,
    place: &Place<'_>,
    (floor, peak_m): (usize, f64),
) -> Result<Actions, Failure> {
    let (settings, config) = (&test.watch, &test.config);
    let correct = settings.corrections().map_err(Failure::input)?;
    let method = config.compensation.kind;
    if (correct.lateness || correct.gain) && method.predictor.learns() {
        return Err(Failure::input(format!(
            "watch.correct = {:?} is refused with the compensation {method}, which learns lateness and gain itself: accepted with \
             it is [\"late_sensor\"]",
            settings.correct
        )));
    }
    let ratio = config.structure.damping_ratio.first().copied();
    Ok(Actions {
        hold: settings.guard,
        trip: true,
        correct,
        error_limit: settings.trip_eps.map(|largest| ErrorLimit {
            largest,
            damping_ratio: ratio.unwrap_or(0.0),
            duration_s: place.seconds * config.timing.time_scale,
            planned_rms: place.ideal.rms_m(floor).map(|rms| rms / peak_m),
        }),
    })
}

/// What is known of a motion besides the declared model.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    pub(super) rate_hz: f64,
    /// Of the laboratory's time.
    pub(super) omega_rad_per_s: f64,
    pub(super) peak_m: f64,
    /// What holds the actuator, where no stiffness of the specimen is declared.
    pub(super) stiffness_n_per_m: f64,
    /// One actuator, and a force that is of its displacement alone.
    pub(super) alone: bool,
    /// Lateness that the compensation takes the actuator to have.
    pub(super) expected_ms: f64,
    /// Of displacement, m, and force, N, rms; 0 where it is learned.
    pub(super) noise: [f64; 2],
}

/// What the watch of actuator `j` is told.
pub(super) fn declared(test: &TestFile, j: usize, peak_m: f64, omega_rad_per_s: f64) -> Declared {
    let config = &test.config;
    let stiffness = &config.structure.stiffness_n_per_m;
    // Nobody has declared a noise where no filter is told of one: it is learned.
    let noise = match config.estimation.kind {
        outerloop_core::config::Filter::Off => [0.0; 2],
        _ => noise_rms(config, &test.plant),
    };
    let scales = Scales {
        rate_hz: config.timing.rate_hz,
        omega_rad_per_s,
        peak_m,
        stiffness_n_per_m: stiffness[j] + stiffness.get(j + 1).copied().unwrap_or(0.0),
        alone: config.physical_storeys() == 1 && config.degrees_of_freedom() == 1,
        expected_ms: config.compensation.delay_ms.at(0),
        noise,
    };
    of_model(&test.declared.clone().unwrap_or_default(), &scales)
}

/// What a model declares of a motion.
pub(super) fn of_model(model: &Model, scales: &Scales) -> Declared {
    let actuator = model.actuator.clone().unwrap_or_default();
    let specimen = model.specimen.clone().unwrap_or_default();
    let known = Departures::of_model(model, scales.expected_ms);
    let tolerance = |d: Option<diagnosis::Declared>| d.map_or(0.0, |d| d.tolerance);
    let late_ms = tolerance(actuator.delay_ms).hypot(tolerance(actuator.lag_ms));
    let [delay_ms, lag_ms] = known.late_ms();
    let stiffness = specimen
        .stiffness_n_per_mm
        .filter(|k| scales.alone && k.value > 0.0);
    let stiffness_n_per_m = stiffness.map_or(scales.stiffness_n_per_m, |k| 1e3 * k.value);
    let value = |d: Option<diagnosis::Declared>| d.map_or(0.0, |d| d.value);
    Declared {
        rate_hz: scales.rate_hz,
        omega_rad_per_s: scales.omega_rad_per_s,
        peak_m: scales.peak_m,
        stiffness_n_per_m,
        stiffness_tolerance: 1e3 * tolerance(specimen.stiffness_n_per_mm) / stiffness_n_per_m,
        actuator: DeclaredActuator {
            gain: known[Quantity::CommandGain],
            delay_s: 1e-3 * delay_ms,
            lag_s: 1e-3 * lag_ms,
            offset_m: 1e-3 * known[Quantity::CommandOffset],
            tolerances: [
                tolerance(actuator.gain),
                1e-3 * late_ms,
                1e-3 * tolerance(actuator.offset_mm),
            ],
        },
        alone: scales.alone,
        has_actuator: model.actuator.is_some() && can_be_told(model, true),
        has_specimen: stiffness.is_some() && can_be_told(model, false),
        elastic: !specimen.effects.iter().any(|e| e.enabled)
            && !specimen.elements.iter().any(|e| e.enabled),
        damping_n_s_per_m: 1e3 * value(specimen.damping_n_s_per_mm),
        mass_kg: value(specimen.mass_kg),
        specimen_tolerances: [
            1e3 * tolerance(specimen.damping_n_s_per_mm),
            tolerance(specimen.mass_kg),
            tolerance(specimen.offset_n),
        ],
        force_gain: known[Quantity::ForceGain],
        force_offset_n: value(specimen.offset_n),
        noise: scales.noise,
    }
}

/// True if all that is declared of actuator or specimen is what the watch knows.
fn can_be_told(model: &Model, actuator: bool) -> bool {
    use plant::Effect;
    if actuator {
        let own = model.actuator.iter();
        own.flat_map(|a| &a.effects)
            .all(|e| matches!(e.name, Effect::SecondLag))
            && model.actuator.iter().all(|a| a.remainder.is_none())
    } else {
        let own = model.specimen.iter();
        own.flat_map(|s| &s.effects).all(|e| {
            matches!(
                e.name,
                Effect::GainError | Effect::BilinearHysteresis | Effect::BoucWenHysteresis
            )
        }) && model.specimen.iter().all(|s| s.remainder.is_none())
    }
}

/// A force that shakes with the motion tells nothing of its sensor's noise.
const HEAVY: &str = "Noise and hum of the load cell are not watched: the mass that is declared on it shakes with the motion.";

/// What is not watched, what is for all that, and what it would take: one sentence, since every run of a rig that nobody declared
/// says it.
pub(super) fn gaps(d: &Declared) -> Vec<String> {
    const ACTUATOR: &str = "[declared.actuator] with gain, delay, lags and offset alone";
    let said = match (d.has_actuator, d.has_specimen, d.alone) {
        (true, true, _) if d.mass_kg > 0.0 => return vec![HEAVY.to_owned()],
        (true, true, _) => return Vec::new(),
        (true, false, true) => "Between displacement and force only noise, hum, play and a load cell that stands are watched: more takes \
             declared.specimen.stiffness_n_per_mm with no effects but gain_error and yielding."
            .to_owned(),
        (true, false, false) => "Of the forces only noise and hum are watched, not play or a load cell that stands: the force of a floor \
             depends on its neighbours."
            .to_owned(),
        (false, true, _) => format!(
            "Between command and displacement only noise and hum are watched, not a displacement transducer that stands: that takes \
             {ACTUATOR}."
        ),
        (false, false, true) => "[declared] has nothing that the watch can use: only noise, hum, play and a load cell that stands are \
             watched, not a displacement transducer that stands."
            .to_owned(),
        (false, false, false) => format!(
            "Only noise and hum are watched, not play or a sensor that stands: the actuators take {ACTUATOR}, and the force of a floor \
             depends on its neighbours."
        ),
    };
    vec![said]
}

#[cfg(test)]
mod tests {
    use super::{Scales, gaps, of_model};
    use diagnosis::Model;
    use outerloop_core::watch::Declared;

    /// What is said where so much is declared; `alone`: of a structure of one floor.
    fn said([has_actuator, has_specimen]: [bool; 2], alone: bool) -> String {
        let scales = Scales {
            rate_hz: 2000.0,
            omega_rad_per_s: 6.0,
            peak_m: 0.04,
            stiffness_n_per_m: 158e3,
            alone,
            expected_ms: 0.0,
            noise: [0.0; 2],
        };
        let declared = Declared {
            has_actuator,
            has_specimen,
            ..of_model(&Model::default(), &scales)
        };
        gaps(&declared).join(" ")
    }

    #[test]
    fn what_is_watched_for_all_that_stands_beside_what_is_not() {
        assert_eq!(said([true; 2], true), "");
        for (declared, alone) in [
            ([true, false], true),
            ([true, false], false),
            ([false, true], true),
            ([false; 2], true),
            ([false; 2], false),
        ] {
            let said = said(declared, alone);
            // Neither takes a model.
            assert!(said.contains("noise") && said.contains("hum"), "{said}");
            // Nor do these, where an actuator moves its specimen alone.
            let of_force = alone && !declared[1];
            let watched = "hum, play and a load cell that stands are";
            assert_eq!(said.contains(watched), of_force, "{said}");
            // A reading that stands is told from an actuator that does by what the actuator should do.
            let none = "not a displacement transducer that stands";
            let neither = "not play or a sensor that stands";
            let stands_unseen = said.contains(none) || said.contains(neither);
            assert_eq!(stands_unseen, !declared[0], "{said}");
        }
    }
}
