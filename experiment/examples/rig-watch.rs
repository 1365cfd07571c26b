//! The rig watch on rigs that no tuning has seen, in simulation: sound tests with every declared value off inside its
//! tolerance, and tests in which something goes wrong.
//!
//! `cargo run --release -p experiment --example rig-watch -- SOUND FAULTS SEED` draws so many of each and prints the table.

use experiment::Experiment;
use experiment::files::ground_motion::GroundMotionFile;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::summary::{POOR_EPS_RMS, TestVerdict};
use experiment::watch::WatchEvent;
use plant::random::{Normal, Purpose};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

/// What a rig is drawn with.
struct Draw(Normal);

impl Draw {
    fn new(seed: u64) -> Self {
        Self(Normal::new(seed, Purpose::DrawnPlant, 26))
    }

    /// Evenly between two bounds.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        0.5 * (low + high) + self.0.even(0.5 * (high - low))
    }

    /// Evenly in the logarithm.
    fn ratio(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn of<'a, T: ?Sized>(&mut self, list: &[&'a T]) -> &'a T {
        let at = self.between(0.0, list.len() as f64) as usize;
        list[at.min(list.len() - 1)]
    }

    fn sign(&mut self) -> f64 {
        self.0.even(1.0).signum()
    }
}

/// Drawn quantities that the faults are measured in.
struct Rig {
    text: String,
    late_ms: f64,
    peak_mm: f64,
    force_n: f64,
    omega: f64,
    mass_kg: f64,
    seconds: f64,
    yields: bool,
    noise: f64,
    kind: String,
    shaking: GroundMotionFile,
}

/// Noise under an envelope, with a spectrum around the structure's frequency.
fn shaking(draw: &mut Draw, hz: f64, seconds: f64) -> GroundMotionFile {
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
            v += interval_s * (draw.0.sample() - 2.0 * zeta * w * v - w * w * x);
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

fn rig(seed: u64) -> Rig {
    let mut draw = Draw::new(seed);
    let hz = draw.ratio(0.5, 4.0);
    let omega = TAU * hz;
    let mass_kg = draw.ratio(300.0, 20_000.0);
    let stiffness = mass_kg * omega * omega;
    let peak_mm = draw.ratio(5.0, 100.0);
    let force_n = stiffness * peak_mm * 1e-3;
    let late_ms = draw.ratio(3.0, 30.0_f64.min(0.12e3 / omega));
    let (late_tolerance, gain_tolerance) = (0.08 * late_ms + 0.2, 0.003);
    let off = |draw: &mut Draw, tolerance: f64| draw.between(-tolerance, tolerance);
    let true_late = late_ms + off(&mut draw, late_tolerance);
    let share = draw.between(0.2, 0.8);
    let actuator = match draw.of(&["lag_delay", "lag_delay", "second_order", "servo_hydraulic"]) {
        "lag_delay" => format!(
            "kind = 'lag_delay'\ndelay_ms = {}\nlag_ms = {}\n",
            true_late * share,
            true_late * (1.0 - share)
        ),
        "second_order" => format!(
            "kind = 'second_order'\ndelay_ms = {true_late}\nzeta = {}\n",
            draw.between(0.6, 1.0)
        ),
        // Faster than this its control loop is unstable.
        _ => format!(
            "kind = 'servo_hydraulic'\ndelay_ms = {}\n[plant.actuator.servo]\nforce_limit_n = {}\n\
             velocity_limit_mm_per_s = {}\npiston_mass_kg = {}\noil_column_hz = 300\noil_column_zeta = 0.05\nvalve_hz = 300\n",
            true_late.max(8.0),
            6.0 * force_n,
            4.0 * peak_mm * omega,
            // An oil column 20 times as stiff as the specimen: its friction is then no load.
            (20.0 * stiffness / (TAU * 300.0 * TAU * 300.0)).max(0.1)
        ),
    };
    let servo = actuator.contains("servo");
    let actuator_kind = actuator.split('\'').nth(1).unwrap_or_default().to_owned();
    let late_ms = if servo {
        late_ms.max(8.0 - 0.5 * late_tolerance)
    } else {
        late_ms
    };
    let specimen = match draw.of(&["linear", "bilinear", "bouc_wen"]) {
        "linear" => String::new(),
        kind => format!(
            "kind = '{kind}'\nyield_mm = {}\nhardening_ratio = {}\n{}",
            peak_mm / draw.between(1.3, 6.0),
            draw.between(0.02, 0.2),
            if kind == "bouc_wen" {
                format!("sharpness = {}\n", draw.of(&["1", "2", "4"]))
            } else {
                String::new()
            }
        ),
    };
    let yields = !specimen.is_empty();
    let noise = draw.ratio(1e-4, 5e-3);
    let bits = draw.of(&["", "bits = 12\n", "bits = 16\n", "bits = 16\n"]);
    let range = if bits.is_empty() {
        String::new()
    } else {
        format!(
            "displacement_range_mm = {}\nforce_range_n = {}\n",
            2.0 * peak_mm,
            2.0 * force_n
        )
    };
    let mut text = format!(
        "[structure]\nmass_kg = {mass_kg}\nstiffness_n_per_m = {stiffness}\ndamping_ratio = {}\n",
        draw.between(0.02, 0.06)
    );
    let compensation = draw.of(&["paper", "inverse", "phase-lead", "lagrange"]);
    let _ = write!(
        text,
        "[compensation]\nkind = '{}'\n[excitation]\npeak_response_mm = {peak_mm}\n\
         [plant.actuator]\ngain = {}\n{actuator}[plant.specimen]\nstiffness_n_per_m = {}\n{specimen}\
         [plant.sensors]\ndisplacement_noise_mm = {}\nforce_noise_n = {}\ndisplacement_gain = {}\nforce_gain = {}\n\
         displacement_offset_mm = {}\nforce_offset_n = {}\nskew_ms = {}\n{bits}{range}",
        compensation,
        1.0 + off(&mut draw, gain_tolerance),
        stiffness * (1.0 + off(&mut draw, 0.025)),
        noise * peak_mm,
        noise * draw.ratio(0.5, 2.0) * force_n,
        1.0 + off(&mut draw, 0.0025),
        1.0 + off(&mut draw, 0.004),
        off(&mut draw, 0.0015) * peak_mm,
        off(&mut draw, 0.0015) * force_n,
        off(&mut draw, 0.15),
    );
    let declared = format!(
        "[declared.actuator]\ngain = {{ value = 1, tolerance = {gain_tolerance} }}\n\
         delay_ms = {{ value = {}, tolerance = {late_tolerance} }}\nlag_ms = {{ value = {}, tolerance = 0 }}\n\
         offset_mm = {{ value = 0, tolerance = {} }}\n[declared.specimen]\n\
         stiffness_n_per_mm = {{ value = {}, tolerance = {} }}\n",
        late_ms * share,
        late_ms * (1.0 - share),
        0.002 * peak_mm,
        1e-3 * stiffness,
        0.025e-3 * stiffness,
    );
    // A yielding specimen is declared so in two of three tests.
    let hysteresis = if yields && draw.between(0.0, 1.0) < 0.67 {
        format!(
            "[[declared.specimen.effects]]\nname = 'bilinear_hysteresis'\nyield_mm = {peak_mm}\n"
        )
    } else {
        String::new()
    };
    text += &declared;
    text += &hysteresis;
    let friction = draw.between(0.0, 0.004) * force_n;
    let _ = write!(
        text,
        "[[plant.effects]]\nname = 'coulomb_friction'\nforce_n = {}\npresliding_mm = {}\n",
        friction.max(1e-3),
        0.004 * peak_mm
    );
    let seconds = (14.0 / hz).clamp(8.0, 20.0);
    let shaking = shaking(&mut draw, hz, seconds);
    Rig {
        text,
        late_ms,
        peak_mm,
        force_n,
        omega,
        mass_kg,
        seconds,
        yields,
        noise,
        kind: format!("{actuator_kind} {compensation}"),
        shaking,
    }
}

fn run(rig: &Rig, more: &str, seed: u64) -> Option<JudgedRun> {
    let text = format!("{}{more}", rig.text);
    let test = TestFile::parse(&text, "drawn", Path::new(""), &[])
        .map_err(|e| eprintln!("{e}"))
        .ok()?;
    let method = test.config.compensation.kind;
    let judged = Experiment::new(test, &rig.shaking, None).and_then(|experiment| {
        let ideal = experiment.ideal()?;
        experiment.run(method, &ideal, seed, false, ())
    });
    judged.map_err(|e| eprintln!("seed {seed}: {e}")).ok()
}

/// An effect that begins in mid-test, and the names that are right: name and side.
type Fault = (
    &'static str,
    String,
    &'static [(&'static str, &'static str)],
);

fn fault(rig: &Rig, draw: &mut Draw) -> Fault {
    let at = draw.between(0.25, 0.5) * rig.seconds;
    let entry = |body: String| format!("[[plant.effects]]\nfrom_s = {at}\n{body}\n");
    let (sign, p, f) = (draw.sign(), rig.peak_mm, rig.force_n);
    match draw.between(0.0, 13.0) as usize {
        0 | 1 => {
            let more = draw.ratio(3.0, 20.0).min(120.0 / rig.omega);
            (
                "actuator late",
                entry(format!("name = 'delay_error'\ndelay_ms = {more}")),
                &[("delay_error", "actuator")],
            )
        }
        2 => {
            let error = sign * draw.between(0.02, 0.1);
            let body = format!("name = 'gain_error'\nchannel = 'actuator'\nerror = {error}");
            ("actuator gain", entry(body), &[("gain_error", "actuator")])
        }
        3 => {
            let error = sign * draw.between(0.02, 0.1);
            let body = format!("name = 'gain_error'\nsensor = 'displacement'\nerror = {error}");
            ("LVDT gain", entry(body), &[("gain_error", "displacement")])
        }
        4 => {
            let offset = sign * draw.between(0.02, 0.06) * p;
            let body = format!("name = 'offset'\nsensor = 'displacement'\noffset_mm = {offset}");
            ("LVDT offset", entry(body), &[("offset", "displacement")])
        }
        5 => {
            let body = format!(
                "name = 'channel_skew'\nskew_ms = {}",
                -draw.ratio(3.0, 10.0)
            );
            (
                "LVDT late",
                entry(body),
                &[
                    ("channel_skew", "displacement"),
                    ("delay_error", "actuator"),
                ],
            )
        }
        6 => {
            let error = sign * draw.between(0.05, 0.2);
            let body = format!("name = 'gain_error'\nsensor = 'force'\nerror = {error}");
            ("load cell gain", entry(body), &[("gain_error", "force")])
        }
        7 => {
            let body = format!("name = 'channel_skew'\nskew_ms = {}", draw.ratio(3.0, 10.0));
            ("load cell late", entry(body), &[("channel_skew", "force")])
        }
        8 => {
            let body = format!(
                "name = 'saturation'\nchannel = 'actuator'\nlimit_mm = {}",
                draw.between(0.3, 0.7) * p
            );
            ("stroke limit", entry(body), &[("saturation", "actuator")])
        }
        9 => {
            let most = draw.between(0.3, 0.7) * p * rig.omega;
            (
                "rate limit",
                entry(format!("name = 'rate_limit'\nrate_mm_per_s = {most}")),
                &[("rate_limit", "actuator")],
            )
        }
        10 => {
            let sensor = draw.of(&["displacement", "force"]);
            let right: &[_] = match sensor {
                "force" => &[("frozen_sensor", "force")],
                _ => &[("frozen_sensor", "displacement")],
            };
            (
                "frozen with noise",
                entry(format!("sensor = '{sensor}'\nfrozen = true")),
                right,
            )
        }
        11 => {
            let body = format!(
                "name = 'dead_band'\nchannel = 'specimen'\nwidth_mm = {}",
                draw.between(0.02, 0.06) * p
            );
            ("play", entry(body), &[("dead_band", "specimen")])
        }
        _ => {
            let mass = draw.between(0.02, 0.1) * rig.mass_kg;
            let lost = draw.between(0.15, 0.6);
            if draw.sign() > 0.0 {
                (
                    "mass on the load cell",
                    entry(format!("name = 'inertia_force'\nmass_kg = {mass}")),
                    &[("inertia_force", "force")],
                )
            } else {
                let body = format!("name = 'degradation'\ntravel_mm = 1e-3\nlost_share = {lost}");
                let right = &[("degradation", "specimen"), ("gain_error", "force")];
                let _ = f;
                ("specimen breaks", entry(body), right)
            }
        }
    }
}

#[derive(Default)]
struct Row {
    tests: usize,
    matter: usize,
    named: usize,
    first_right: usize,
    settled_right: usize,
    one: usize,
    cycles: Vec<f64>,
    /// Error without the effect, with it, and corrected, sums over those that matter.
    eps: [f64; 3],
    worse: usize,
}

/// What the loop may correct for.
const CORRECT: &str = "[watch]\ncorrect = ['lateness', 'gain', 'late_sensor']\n";
/// A correction that makes the error larger by more than this has made it worse, of the peak.
const WORSE: f64 = 0.01;

fn holds(event: &WatchEvent, right: &[(&str, &str)]) -> bool {
    event.set.iter().any(|c| right.contains(&(c.name, c.side)))
}

fn main() {
    let arguments: Vec<u64> = std::env::args()
        .skip(1)
        .filter_map(|a| a.parse().ok())
        .collect();
    let [sound, faults, seed] = arguments[..] else {
        eprintln!("rig-watch: accepted is SOUND FAULTS SEED, three whole numbers");
        std::process::exit(2);
    };
    let (mut ran, mut yielding, mut unsound, mut wrong) = (0, 0, 0, Vec::new());
    for i in 0..sound {
        let rig = rig(seed + i);
        let Some(run) = run(&rig, "", seed + i) else {
            continue;
        };
        let summary = run.summary;
        let eps_rms = summary.eps_rms;
        if summary.verdict != TestVerdict::Completed || eps_rms > POOR_EPS_RMS {
            // Its compensation does not fit its rig: nothing of it is sound.
            unsound += 1;
            continue;
        }
        let Some(watch) = summary.watch else {
            continue;
        };
        ran += 1;
        yielding += usize::from(rig.yields);
        if let Some(event) = watch.events.iter().find(|e| !e.set.is_empty()) {
            let names: Vec<String> = event.set.iter().map(|c| c.in_words()).collect();
            wrong.push(format!(
                "seed {} {} {:.1} ms {:.2} Hz noise {:.4} eps {eps_rms:.3}{}: {:.2} s {}",
                seed + i,
                rig.kind,
                rig.late_ms,
                rig.omega / TAU,
                rig.noise,
                if rig.yields { " yields" } else { "" },
                event.t_s,
                names.join(" | ")
            ));
        }
    }
    println!(
        "sound tests: {ran}, of which {yielding} yield (beside them {unsound} whose compensation fails); false names: {}",
        wrong.len()
    );
    wrong.iter().for_each(|w| println!("  {w}"));
    let mut rows: BTreeMap<&str, Row> = BTreeMap::new();
    for i in 0..faults {
        let seed = seed + 1_000_000 + i;
        let rig = rig(seed);
        let (name, effect, right) = fault(&rig, &mut Draw::new(seed ^ 0xf0));
        let (Some(sound), Some(faulty)) = (run(&rig, "", seed), run(&rig, &effect, seed)) else {
            continue;
        };
        let Some(corrected) = run(&rig, &format!("{effect}{CORRECT}"), seed) else {
            continue;
        };
        let row = rows.entry(name).or_default();
        row.tests += 1;
        let frozen = name.starts_with("frozen");
        if sound.summary.eps_rms > POOR_EPS_RMS {
            continue;
        }
        if !frozen && faulty.summary.eps_rms - sound.summary.eps_rms < 0.01 {
            continue;
        }
        row.matter += 1;
        let eps = [&sound, &faulty, &corrected].map(|r| r.summary.eps_rms.min(1.0));
        row.eps.iter_mut().zip(eps).for_each(|(sum, e)| *sum += e);
        row.worse += usize::from(eps[2] > eps[1] + WORSE);
        if eps[2] > eps[1] + WORSE {
            println!(
                "worse by its correction: {name} seed {seed}: {:.3} to {:.3}",
                eps[1], eps[2]
            );
        }
        let Some(watch) = faulty.summary.watch else {
            continue;
        };
        let Some(first) = watch.events.iter().find(|e| !e.set.is_empty()) else {
            continue;
        };
        row.named += 1;
        row.first_right += usize::from(holds(first, right));
        if let Some(last) = watch.events.last() {
            row.settled_right += usize::from(holds(last, right));
            row.one += usize::from(holds(last, right) && last.set.len() == 1);
        }
        if let Some(event) = watch.events.iter().find(|e| holds(e, right)) {
            let from: f64 = effect
                .split("from_s = ")
                .nth(1)
                .and_then(|t| t.lines().next()?.parse().ok())
                .unwrap_or(0.0);
            row.cycles.push((event.t_s - from) * rig.omega / TAU);
        }
        if std::env::var_os("WATCH_SAY").is_some() {
            let said: Vec<String> = first.set.iter().map(|c| c.in_words()).collect();
            println!(
                "{name} seed {seed} late {:.1} yields {}: {:.2} s {}",
                rig.late_ms,
                rig.yields,
                first.t_s,
                said.join(" | ")
            );
        }
    }
    println!(
        "{:22} tests matter named first settled one cycles p90  eps % without, with, corrected; worse",
        "effect from mid-test"
    );
    for (name, mut row) in rows {
        row.cycles.sort_by(f64::total_cmp);
        let mean = |sum: f64| 100.0 * sum / row.matter as f64;
        let at = |share: f64| {
            row.cycles
                .get((share * row.cycles.len() as f64) as usize)
                .copied()
                .unwrap_or(f64::NAN)
        };
        println!(
            "{name:22} {:5} {:6} {:5} {:5} {:7} {:3} {:6.1} {:3.1} {:14.1} {:5.1} {:10.1} {:6}",
            row.tests,
            row.matter,
            row.named,
            row.first_right,
            row.settled_right,
            row.one,
            at(0.5),
            at(0.9),
            mean(row.eps[0]),
            mean(row.eps[1]),
            mean(row.eps[2]),
            row.worse
        );
    }
}
