//! A rig whose true values differ from the declared ones within tolerance, and a test on it.

use super::draw::Draw;
use experiment::files::ground_motion::GroundMotionFile;
use experiment::files::near_fault::near_fault;
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// A drawn rig with its test, and the scales of its effects.
pub(super) struct DrawnRig {
    /// The test file.
    pub(super) text: String,
    pub(super) peak_mm: f64,
    pub(super) omega: f64,
    pub(super) mass_kg: f64,
    pub(super) seconds: f64,
    pub(super) storeys: usize,
    /// It yields, and it is declared elastic.
    pub(super) yields: bool,
    pub(super) declared_elastic: bool,
    /// How it hardens, softens or degrades though declared linear: the end of `text`, or empty.
    pub(super) bend: String,
    /// Its description, for the analysis of a false name.
    pub(super) kind: String,
    pub(super) shaking: GroundMotionFile,
}

/// Scales for the parts of a rig.
struct Scales {
    omega: f64,
    stiffness: f64,
    peak_mm: f64,
    force_n: f64,
}

/// All compensations drawn: not `amb`, whose gains are for one size of motion, nor `none` and Eq 14, which leave the
/// actuator late.
const COMPENSATIONS: [&str; 16] = [
    "paper",
    "inverse",
    "phase-lead",
    "lagrange",
    "ats",
    "afp",
    "hydraulic",
    "adaptive-inverse",
    "ahmadizadeh+afp",
    "darby",
    "feedforward-feedback",
    "mcs",
    "model-prediction",
    "paper+inverse",
    "paper+lagrange",
    "tangent+afp",
];
/// Standard tolerances: of the gain, and of the offset as a fraction of the peak displacement.
const GAIN: f64 = 0.003;
const OFFSET: f64 = 0.002;

impl DrawnRig {
    pub(super) fn new(seed: u64) -> Self {
        let mut draw = Draw::new(seed);
        let hz = draw.ratio(0.5, 4.0);
        let (omega, mass_kg) = (TAU * hz, draw.ratio(300.0, 20_000.0));
        // One in eight has two actuators, one at each floor, with the same first frequency.
        let (storeys, first) = match draw.between(0.0, 8.0) {
            x if x < 1.0 => (2, 0.381_966),
            _ => (1, 1.0),
        };
        let stiffness = mass_kg * omega * omega / first;
        let peak_mm = draw.ratio(5.0, 100.0);
        let scales = Scales {
            omega,
            stiffness,
            peak_mm,
            force_n: stiffness * peak_mm * 1e-3,
        };
        let (actuator, late_ms) = actuator(&mut draw, &scales);
        let (specimen, yields) = specimen(&mut draw, &scales);
        let compensation = draw.of(&COMPENSATIONS);
        let each = |x: f64| match storeys {
            1 => format!("{x}"),
            _ => format!("[{x}, {x}]"),
        };
        let mut text = format!(
            "[structure]\nmass_kg = {}\nstiffness_n_per_m = {}\ndamping_ratio = {}\n[compensation]\nkind = '{compensation}'\n\
             [excitation]\npeak_response_mm = {peak_mm}\n[plant.actuator]\ngain = {}\n{}[plant.specimen]\n\
             stiffness_n_per_m = {}\n{specimen}",
            each(mass_kg),
            each(stiffness),
            each(draw.between(0.02, 0.06)),
            1.0 + draw.off(GAIN),
            actuator.plant,
            each(stiffness * (1.0 + draw.off(0.025))),
        );
        let noise = sensors(&mut draw, &scales, &mut text);
        text += &actuator.declared;
        // A lag has no finite acceleration: its velocity jumps with each command.
        let has_mass = storeys == 1 && actuator.name != "lag_delay";
        let mass = has_mass.then(|| specimens_mass(seed, mass_kg));
        let (declared_mass, true_mass) = mass.unwrap_or_default();
        let _ = write!(
            text,
            "offset_mm = {{ value = 0, tolerance = {} }}\n[declared.specimen]\n{declared_mass}\
             stiffness_n_per_mm = {{ value = {}, tolerance = {} }}\n",
            OFFSET * peak_mm,
            1e-3 * stiffness,
            0.025e-3 * stiffness,
        );
        // A specimen that yields is declared so in two of three tests.
        let declared_elastic = !yields || draw.between(0.0, 1.0) > 0.67;
        if !declared_elastic {
            let _ = write!(
                text,
                "[[declared.specimen.effects]]\nname = 'bilinear_hysteresis'\nyield_mm = {peak_mm}\n"
            );
        }
        always_there(&mut draw, &scales, yields, &mut text);
        text += &true_mass;
        let seconds = (14.0 / hz).clamp(8.0, 20.0);
        let shaking = shaking(&mut draw, hz, seconds);
        let (bends, bend) = match yields {
            true => ("", String::new()),
            false => bent(&mut draw, peak_mm),
        };
        text += &bend;
        Self {
            text,
            peak_mm,
            omega,
            mass_kg,
            seconds,
            storeys,
            yields,
            declared_elastic,
            bend,
            kind: format!(
                "{storeys} {} {compensation}, {late_ms:.1} ms, {hz:.2} Hz, noise {noise:.4}{}{}{}",
                actuator.name,
                if yields { ", yields" } else { "" },
                if yields && declared_elastic {
                    " though declared elastic"
                } else {
                    ""
                },
                bends
            ),
            shaking,
        }
    }
}

struct DrawnActuator {
    name: &'static str,
    plant: String,
    declared: String,
}

/// From a delay with a lag to a servo-hydraulic one, and its declared total delay, ms.
fn actuator(draw: &mut Draw, s: &Scales) -> (DrawnActuator, f64) {
    let late_ms = draw.ratio(3.0, 30.0_f64.min(0.12e3 / s.omega));
    let tolerance = 0.08 * late_ms + 0.2;
    let true_ms = late_ms + draw.off(tolerance);
    let share = draw.between(0.2, 0.8);
    let (name, plant, late_ms) = match draw.of(&[
        "lag_delay",
        "lag_delay",
        "second_order",
        "servo_hydraulic",
    ]) {
        "lag_delay" => (
            "lag_delay",
            format!(
                "kind = 'lag_delay'\ndelay_ms = {}\nlag_ms = {}\n",
                true_ms * share,
                true_ms * (1.0 - share)
            ),
            late_ms,
        ),
        "second_order" => (
            "second_order",
            format!(
                "kind = 'second_order'\ndelay_ms = {true_ms}\nzeta = {}\n",
                draw.between(0.6, 1.0)
            ),
            late_ms,
        ),
        // Faster than 8 ms its control loop is unstable. The oil column is 20 times as stiff as the specimen, so that the
        // specimen's friction is not a significant load.
        _ => (
            "servo_hydraulic",
            format!(
                "kind = 'servo_hydraulic'\ndelay_ms = {}\n[plant.actuator.servo]\nforce_limit_n = {}\n\
                     velocity_limit_mm_per_s = {}\npiston_mass_kg = {}\noil_column_hz = 300\noil_column_zeta = 0.05\nvalve_hz = 300\n",
                true_ms.max(8.0),
                6.0 * s.force_n,
                4.0 * s.peak_mm * s.omega,
                (20.0 * s.stiffness / (TAU * 300.0 * TAU * 300.0)).max(0.1)
            ),
            late_ms.max(8.0 - 0.5 * tolerance),
        ),
    };
    let declared = format!(
        "[declared.actuator]\ngain = {{ value = 1, tolerance = {GAIN} }}\n\
         delay_ms = {{ value = {}, tolerance = {tolerance} }}\nlag_ms = {{ value = {}, tolerance = 0 }}\n",
        late_ms * share,
        late_ms * (1.0 - share),
    );
    let drawn = DrawnActuator {
        name,
        plant,
        declared,
    };
    (drawn, late_ms)
}

/// Mass between specimen and load cell, declared and true.
fn specimens_mass(seed: u64, mass_kg: f64) -> (String, String) {
    // A separate draw, so that the others stay what they were before there was a mass.
    let mut draw = Draw::new(seed ^ 0xa0);
    let declared = draw.between(0.0, 0.005) * mass_kg;
    let tolerance = 0.2 * declared;
    let own = declared + draw.off(tolerance);
    (
        format!("mass_kg = {{ value = {declared}, tolerance = {tolerance} }}\n"),
        format!("[[plant.effects]]\nname = 'inertia_force'\nmass_kg = {own}\n"),
    )
}

/// Linear or yielding, and whether it yields.
fn specimen(draw: &mut Draw, s: &Scales) -> (String, bool) {
    let kind = draw.of(&["linear", "bilinear", "bouc_wen"]);
    if kind == "linear" {
        return (String::new(), false);
    }
    let mut text = format!(
        "kind = '{kind}'\nyield_mm = {}\nhardening_ratio = {}\n",
        s.peak_mm / draw.between(1.3, 6.0),
        draw.between(0.02, 0.2),
    );
    if kind == "bouc_wen" {
        let _ = writeln!(text, "sharpness = {}", draw.of(&["1", "2", "4"]));
    }
    (text, true)
}

/// Noise, gains, offsets and skew of the sensors within their tolerances, and converters; returns the noise as a fraction of the
/// peak.
fn sensors(draw: &mut Draw, s: &Scales, text: &mut String) -> f64 {
    let noise = draw.ratio(1e-4, 5e-3);
    let bits = draw.of(&["", "bits = 12\n", "bits = 16\n", "bits = 16\n"]);
    let _ = write!(
        text,
        "[plant.sensors]\ndisplacement_noise_mm = {}\nforce_noise_n = {}\ndisplacement_gain = {}\nforce_gain = {}\n\
         displacement_offset_mm = {}\nforce_offset_n = {}\nskew_ms = {}\n{bits}",
        noise * s.peak_mm,
        noise * draw.ratio(0.5, 2.0) * s.force_n,
        1.0 + draw.off(0.0025),
        1.0 + draw.off(0.004),
        draw.off(0.0015) * s.peak_mm,
        draw.off(0.0015) * s.force_n,
        draw.off(0.15),
    );
    if !bits.is_empty() {
        let _ = write!(
            text,
            "displacement_range_mm = {}\nforce_range_n = {}\n",
            2.0 * s.peak_mm,
            2.0 * s.force_n
        );
    }
    noise
}

/// What every rig has: a little bearing friction; one in four of the specimens that yield degrades with its travel.
fn always_there(draw: &mut Draw, s: &Scales, yields: bool, text: &mut String) {
    let friction = draw.between(0.0, 0.004) * s.force_n;
    let _ = write!(
        text,
        "[[plant.effects]]\nname = 'coulomb_friction'\nforce_n = {}\npresliding_mm = {}\n",
        friction.max(1e-3),
        0.004 * s.peak_mm
    );
    if yields && draw.between(0.0, 4.0) < 1.0 {
        let _ = write!(
            text,
            "[[plant.effects]]\nname = 'degradation'\ntravel_mm = {}\nlost_share = {}\n",
            draw.ratio(20.0, 100.0) * s.peak_mm,
            draw.between(0.05, 0.2)
        );
    }
}

/// How one in three of the specimens that do not yield departs from its declaration, by 4 to 30 % of its stiffness: in words, and
/// as tables of the test file.
fn bent(draw: &mut Draw, peak_mm: f64) -> (&'static str, String) {
    let (kind, name, exponent) = match draw.between(0.0, 12.0) {
        x if x < 1.0 => (", hardens", "hardening", 2.0),
        x if x < 2.0 => (", softens", "softening", 1.0),
        x if x < 3.0 => (", degrades with its largest motion", "degradation", 1.0),
        x if x < 4.0 => {
            let (travel_mm, lost) = (draw.ratio(20.0, 100.0) * peak_mm, draw.between(0.05, 0.3));
            let text = format!(
                "[[plant.effects]]\nname = 'degradation'\ntravel_mm = {travel_mm}\nlost_share = {lost}\n"
            );
            return (", degrades with its way", text);
        }
        _ => return ("", String::new()),
    };
    let at_peak: f64 = draw.ratio(0.04, 0.3);
    let reference_mm = peak_mm * at_peak.powf(-1.0 / exponent);
    let text = format!("[[plant.effects]]\nname = '{name}'\nreference_mm = {reference_mm}\n");
    (kind, text)
}

/// In two of three tests, noise with an envelope and a spectrum around the structure's frequency; otherwise the built-in
/// near-fault record, stretched to the test's duration.
fn shaking(draw: &mut Draw, hz: f64, seconds: f64) -> GroundMotionFile {
    if draw.between(0.0, 3.0) < 1.0 {
        let mut built_in = near_fault();
        let length_s = built_in.interval_s * built_in.acc_m_per_s2.len() as f64;
        built_in.interval_s *= seconds / length_s;
        return built_in;
    }
    let (interval_s, w) = (0.01, TAU * hz * draw.between(0.7, 1.5));
    let zeta = draw.between(0.3, 0.8);
    let (rise, fall) = (
        draw.between(0.08, 0.25) * seconds,
        draw.between(0.5, 0.8) * seconds,
    );
    let (mut x, mut v) = (0.0, 0.0);
    let acc_m_per_s2 = (0..(seconds / interval_s) as usize)
        .map(|i| {
            let t = i as f64 * interval_s;
            v += interval_s * (draw.normal() - 2.0 * zeta * w * v - w * w * x);
            x += interval_s * v;
            let envelope = (t / rise).min(1.0) * (-((t - fall).max(0.0)) / (0.15 * seconds)).exp();
            (envelope * 2.0 * zeta * w * v) as f32
        })
        .collect();
    GroundMotionFile {
        name: "noise".into(),
        acc_m_per_s2,
        interval_s,
    }
}
