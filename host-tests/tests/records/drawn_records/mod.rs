//! The figures of third-party records, bounded on records drawn here, so that a fork without the data still holds each
//! (`docs/validation.md` has the list). They are files of the same kinds, asked by the same calls. Their laws share nothing with
//! the diagnosis: friction is bristles (Dahl), in steps of an eighth of a sample.
#![cfg(not(debug_assertions))] // Minutes without optimisation.

mod actuators;
mod foresight;
mod friction;
mod specimens;

use diagnosis::{ChannelAnswer, Verdict};
use host_tests::outside::{Case, cases_in};
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Steps of a law to one of a record.
const STEPS: usize = 8;

const FRICTION: [&str; 2] = ["coulomb_friction", "stribeck_friction"];

const ANY: [&str; 3] = ["effect", "partial", "ambiguous"];

const LATE: [&str; 3] = ["delay_error", "lag_error", "second_lag"];

/// A folder of a record, its declared model and its answer, as a folder of third-party records.
struct Drawn {
    folder: PathBuf,
    random: Xoshiro256PlusPlus,
}

impl Drawn {
    fn new(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
            .join("drawn-records")
            .join(name);
        std::fs::create_dir_all(&folder).unwrap();
        let random = Xoshiro256PlusPlus::seed_from_u64(7);
        Self { folder, random }
    }

    fn noise(&mut self, rms: f64) -> f64 {
        rms * Distribution::<f64>::sample(&StandardNormal, &mut self.random)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder.join(name), text).unwrap();
    }

    /// A file of a record; `row` is called every `1 / (STEPS rate_hz)` from `before_s` on, and its last before each sample counts.
    fn record<const N: usize>(
        &mut self,
        [name, columns]: [&str; 2],
        rate_hz: f64,
        [before_s, seconds]: [f64; 2],
        noise: [f64; N],
        mut row: impl FnMut(f64, f64) -> [f64; N],
    ) {
        let mut text = format!("# drawn\ntime_s,{columns}\n");
        let dt = 1.0 / (STEPS as f64 * rate_hz);
        for i in (-before_s * rate_hz) as i64..(seconds * rate_hz) as i64 {
            let step = |k: usize| (i as f64 - (STEPS - 1 - k) as f64 / STEPS as f64) / rate_hz;
            let read = (0..STEPS).map(|k| row(step(k), dt)).last().unwrap();
            if i < 0 {
                continue;
            }
            let _ = write!(text, "{:.7}", i as f64 / rate_hz);
            for (signal, rms) in read.into_iter().zip(noise) {
                let _ = write!(text, ",{:.7}", signal + self.noise(rms));
            }
            text.push('\n');
        }
        self.write(name, &text);
    }

    /// The case of these spans: declared values with their tolerances, right names, and the error that is right.
    fn case(
        &self,
        channel: &str,
        declared: &[(&str, [f64; 2])],
        [train, test]: [&[&str]; 2],
        [verdicts, names]: [&[&str]; 2],
        after_nrmse: f64,
    ) -> Case {
        let mut model = format!("[{channel}]\n");
        for (key, [value, tolerance]) in declared {
            let _ = writeln!(
                model,
                "{key} = {{ value = {value:?}, tolerance = {tolerance:?} }}"
            );
        }
        self.write("model.toml", &model);
        self.write(
            "cases.toml",
            &format!(
                "[[case]]\nid = \"drawn\"\nchannel = {channel:?}\nmodel = \"model.toml\"\ntrain = {train:?}\ntest = {test:?}\n\
                 rest = []\nverdicts = {verdicts:?}\nnames = {names:?}\nhalf = []\nset_must_hold_one_of = {names:?}\nnever = []\n\
                 cause = \"drawn\"\nreference = {{ before_nrmse = 1.0, after_nrmse = {after_nrmse:?} }}\n"
            ),
        );
        cases_in(&self.folder).unwrap().remove(0)
    }
}

/// The answer, which must be right by the rules of third-party records, and without a wrong name.
#[track_caller]
fn right(case: &Case) -> ChannelAnswer {
    let (answer, _) = case.diagnose().unwrap();
    println!("{}", said(&answer));
    assert_eq!(case.points(&answer), 1.0, "{}", said(&answer));
    let of_case = |name: &str| case.names.iter().any(|n| n == name);
    let is_set = answer.verdict == Verdict::Ambiguous;
    let no_other = is_set || answer.effects.iter().all(|e| of_case(e.name.name()));
    assert!(no_other, "{}", said(&answer));
    answer
}

fn said(a: &ChannelAnswer) -> String {
    let effects = a.effects.iter();
    let named: Vec<_> = effects
        .map(|e| {
            (
                e.name,
                e.q,
                e.parameters
                    .iter()
                    .map(|p| (p.name.as_str(), p.value))
                    .collect::<Vec<_>>(),
            )
        })
        .collect();
    let set: Vec<_> = a.members.iter().map(|m| m.name).collect();
    let refitted: Vec<_> = a
        .refitted
        .iter()
        .map(|r| (r.name.as_str(), r.value))
        .collect();
    format!(
        "{:?} {named:?}, set {set:?}, nearest {:?}; refitted {refitted:?}; {:.5} -> {:.5}, noise {:.5}; {:?}",
        a.verdict,
        a.nearest,
        a.error_before.test_nrmse,
        a.error_after.test_nrmse,
        a.noise_floor_rms,
        a.notes
    )
}

/// A figure of the first name, or a refitted one, within a share.
#[track_caller]
fn assert_has(a: &ChannelAnswer, figure: &str, value: f64, within: f64) {
    let own = a.effects.iter().flat_map(|e| &e.parameters);
    let own = own.filter(|p| p.name == figure).map(|p| p.value);
    let refitted = a
        .refitted
        .iter()
        .filter(|r| r.name == figure)
        .map(|r| r.value);
    let is = own.chain(refitted).next();
    let close = is.is_some_and(|is| (is / value - 1.0).abs() < within);
    assert!(close, "{figure} {value}: {}", said(a));
}

/// Sines of an amplitude that falls with their frequency: place, mm, and its first two derivatives.
fn tones(hz: &[f64], size_mm: f64, t: f64) -> [f64; 3] {
    let (mut sum, lowest) = ([0.0; 3], hz[0]);
    for (k, hz) in hz.iter().enumerate() {
        let (w, size) = (TAU * hz, size_mm / (1.0 + hz / lowest));
        let phase = w * t + 1.7 * (k * k) as f64;
        sum[0] += size * phase.sin();
        sum[1] += size * w * phase.cos();
        sum[2] -= size * w * w * phase.sin();
    }
    sum
}

/// Bristles that give by a way before they slide: from -1 to 1.
struct Bristles {
    bent: f64,
    give_mm: f64,
}

impl Bristles {
    fn new(give_mm: f64) -> Self {
        Self { bent: 0.0, give_mm }
    }

    fn after(&self, way: f64) -> f64 {
        way.signum() + (self.bent - way.signum()) * (-way.abs() / self.give_mm).exp()
    }

    fn slide(&mut self, way: f64) -> f64 {
        self.bent = self.after(way);
        self.bent
    }
}
