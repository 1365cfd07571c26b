//! Whether designed tests settle what a first record leaves open, compared with tests by the fixed advice of the notes.

use crate::grading::{model, recording, recordings, said};
use diagnosis::{Diagnosis, Model, Recording, RigLimits, Verdict};
use exam::aims::{self, Figure};
use exam::field::{Field, Limits, Mark, Said, Stand, Truth, set_field};
use indicatif::ProgressBar;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Largest number of tests after the first record.
const TESTS: usize = 2;
/// Rigs that run at once: the same number on any machine, so that the output is the same.
const TOGETHER: usize = 8;

/// How a set ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum End {
    /// One right name and no wrong one.
    Settled,
    /// A wrong name.
    Wrong,
    /// Still a set, and every name in it is right: no single name describes the rig.
    AllRight,
    /// Still a set of friction and hysteresis, which only a motion beyond the rig's limits could tell apart.
    GivesWay,
    /// Still a set of timing effects, all of which are the same phase shift in a rig that moves slowly.
    OnePhase,
    /// Still a set with a right name.
    Open,
    /// Still a set, without a right name.
    WrongSet,
    /// Nothing is named anymore.
    Unnamed,
}

impl End {
    const ALL: [Self; 8] = [
        Self::Settled,
        Self::Wrong,
        Self::AllRight,
        Self::GivesWay,
        Self::OnePhase,
        Self::Open,
        Self::WrongSet,
        Self::Unnamed,
    ];

    /// Whether a test within the limits could have settled it.
    fn can_be_told(self) -> bool {
        !matches!(self, Self::AllRight | Self::GivesWay | Self::OnePhase)
    }
}

/// What chooses the next test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum By {
    Design,
    FixedAdvice,
}

/// A rig whose first record was ambiguous.
struct Played {
    id: String,
    first: Vec<String>,
    /// By design and by fixed advice: how it ended, after how many tests, and with which names.
    ends: [(End, usize, Vec<String>); 2],
}

fn names(d: &Diagnosis) -> Vec<String> {
    let Said { names, others, .. } = said(d);
    names.into_iter().chain(others).collect()
}

fn ask(model: &Model, train: &[Recording], test: &Recording) -> Option<Diagnosis> {
    diagnosis::diagnose(model, train, std::slice::from_ref(test), &[]).ok()
}

fn stand(field: &Field) -> &Stand {
    field.stand.as_ref().expect("a rig of the field plays")
}

/// The examinee's model with the rig's limits.
fn limited(field: &Field) -> Model {
    let Limits {
        displacement_mm,
        velocity_mm_per_s,
        force_n,
    } = stand(field).limits();
    Model {
        limits: RigLimits {
            displacement_mm: Some(displacement_mm),
            velocity_mm_per_s: Some(velocity_mm_per_s),
            force_n,
        },
        ..model(&field.believed)
    }
}

fn play(field: &Field, command: &[f64], interval_s: f64, test: usize) -> Recording {
    let record = stand(field).play(command, interval_s, 1 + test as u64);
    recording(&format!("test {test}"), &record, None)
}

/// What the notes of a set advise without knowing the rig: a chirp, or two amplitudes at two rates with stops at the
/// reversals. The first test is the one for the first name's family, the second is the other.
fn advised(limits: Limits, timing_first: bool, test: usize, interval_s: f64) -> Vec<f64> {
    let (x, v) = (limits.displacement_mm, limits.velocity_mm_per_s);
    // A tenth of the range stays free.
    let way = if (test == 0) == timing_first {
        let (a, seconds) = (0.3 * x, 20.0);
        let top = (0.9 * v / (TAU * a)).min(0.05 / interval_s);
        let phase = |t: f64| 0.05 * top * t + 0.5 * 0.95 * top * t * t / seconds;
        let grows = |t: f64| (t / 1.0).min(seconds - t).clamp(0.0, 1.0);
        let n = (seconds / interval_s) as usize;
        let at = |i: usize| i as f64 * interval_s;
        (0..n)
            .map(|i| a * grows(at(i)) * (TAU * phase(at(i))).sin())
            .collect()
    } else {
        let mut way = Vec::new();
        for (share, speed) in [(0.9, 0.6), (0.9, 0.15), (0.45, 0.6), (0.45, 0.15)] {
            for [from, to] in [
                [0.0, 1.0],
                [1.0, -1.0],
                [-1.0, 1.0],
                [1.0, -1.0],
                [-1.0, 0.0],
            ] {
                let [from, to] = [from, to].map(|s: f64| s * share * x);
                // The top speed of a half cosine is pi/2 times its mean speed.
                let seconds = 0.25 * TAU * (to - from).abs() / (speed * v);
                let n = (seconds / interval_s).ceil().max(1.0) as usize;
                let part = |i: usize| 0.5 - 0.5 * (0.5 * TAU * i as f64 / n as f64).cos();
                way.extend((1..=n).map(|i| from + (to - from) * part(i)));
                way.extend(std::iter::repeat_n(to, (0.5 / interval_s) as usize));
            }
        }
        way
    };
    let rest = vec![0.0; (2.0 / interval_s) as usize];
    [rest.clone(), way, rest].concat()
}

/// Plays up to two tests and returns how it ended.
fn settle(field: &Field, first: &Diagnosis, by: By) -> (End, usize, Vec<String>) {
    let [record, test] = recordings(field);
    let declared = limited(field);
    let interval_s = record.interval_s();
    let mut train = vec![record];
    let mut found = first.clone();
    let is_open = |d: &Diagnosis| {
        let open = [Verdict::Ambiguous, Verdict::Unknown];
        open.contains(&d.channels[0].verdict)
    };
    let named = first.channels[0].effects.first();
    let timing = named.is_some_and(|e| PHASE.contains(&e.name.name()));
    let mut played = 0;
    while played < TESTS && is_open(&found) {
        let next = match by {
            By::Design => {
                let one = std::slice::from_ref(&test);
                let Ok(next) = diagnosis::next(&declared, &found, &train, one) else {
                    break;
                };
                play(field, &next.command_mm, next.interval_s, played)
            }
            By::FixedAdvice => {
                let h = interval_s.max(2e-3);
                let command = advised(stand(field).limits(), timing, played, h);
                play(field, &command, h, played)
            }
        };
        train.push(next);
        played += 1;
        let Some(now) = ask(&declared, &train, &test) else {
            break;
        };
        found = now;
    }
    (end(&field.truth, &found), played, names(&found))
}

const SLIDES: [&str; 4] = [
    "coulomb_friction",
    "stribeck_friction",
    "bilinear_hysteresis",
    "bouc_wen_hysteresis",
];
const PHASE: [&str; 4] = ["delay_error", "lag_error", "second_lag", "oil_column"];

/// How a diagnosis settles an open set.
fn end(truth: &Truth, found: &Diagnosis) -> End {
    let said = said(found);
    // The tests were chosen so that the motion can tell the causes apart.
    let truth = Truth {
        inseparable: false,
        ..truth.clone()
    };
    let all = names(found);
    let within = |set: &[&str]| all.iter().all(|n| set.contains(&n.as_str()));
    match truth.mark(&said) {
        Mark::Right if said.names.is_empty() => End::Unnamed,
        Mark::Right => End::Settled,
        Mark::Wrong | Mark::Overclaimed => End::Wrong,
        Mark::Set if within(&truth.right) => End::AllRight,
        Mark::Set if within(&SLIDES) => End::GivesWay,
        Mark::Set if within(&PHASE) => End::OnePhase,
        Mark::Set => End::Open,
        Mark::WrongSet => End::WrongSet,
        Mark::Unknown | Mark::None | Mark::Alarm | Mark::Refused => End::Unnamed,
    }
}

/// Looks for `wanted` rigs among `seeds` whose first record is ambiguous, and tries to settle them.
/// False if they settle fewer than aimed at by more than chance.
pub fn all(seeds: Vec<u64>, wanted: usize, list: bool) -> bool {
    let bar = ProgressBar::new(wanted as u64);
    let mut rigs: Vec<Played> = Vec::new();
    let mut drawn = 0;
    // In chunks, so that few more than are wanted are played.
    for some in seeds.chunks(TOGETHER) {
        if rigs.len() >= wanted {
            break;
        }
        drawn += some.len();
        let more: Vec<Played> = some.par_iter().filter_map(|seed| one(*seed)).collect();
        bar.inc(more.len() as u64);
        rigs.extend(more);
    }
    rigs.truncate(wanted);
    if list {
        for r in &rigs {
            println!("[{}] {:?}", r.id, r.first);
            for ((end, tests, names), by) in r.ends.iter().zip([By::Design, By::FixedAdvice]) {
                println!("    {by:?}: {end:?} after {tests}: {names:?}");
            }
        }
    }
    println!(
        "{} rigs with an ambiguous first record among {drawn}\n",
        rigs.len()
    );
    println!("| after at most {TESTS} tests | by design | by fixed advice |\n|---|---|---|");
    for end in End::ALL {
        let count = [0, 1].map(|by| rigs.iter().filter(|r| r.ends[by].0 == end).count());
        println!("| {end:?} | {} | {} |", count[0], count[1]);
    }
    // Both columns count the same rigs: all of them, and those that neither way leaves open for a good reason.
    let all = |_: &&Played| true;
    let tellable = |r: &&Played| r.ends.iter().all(|e| e.0.can_be_told());
    let share = |by: usize, of: &dyn Fn(&&Played) -> bool| {
        let of: Vec<&Played> = rigs.iter().filter(of).collect();
        let settled = of.iter().filter(|r| r.ends[by].0 == End::Settled).count();
        let percent = 100.0 * settled as f64 / of.len().max(1) as f64;
        format!("{settled} of {} ({percent:.0} %)", of.len())
    };
    println!(
        "| **settled of all** | {} | {} |",
        share(0, &all),
        share(1, &all)
    );
    println!(
        "| **settled of those that can be told** | {} | {} |",
        share(0, &tellable),
        share(1, &tellable)
    );
    let by_design = || rigs.iter().filter(|r| r.ends[0].0 == End::Settled);
    let one = by_design().filter(|r| r.ends[0].1 == 1);
    println!(
        "\nof those that the design settled one test was enough for {}\n",
        one.count()
    );
    let count = by_design().count() as f64;
    let settled = Figure::share(count, rigs.len());
    println!("{}", aims::table(&[(&aims::SETTLED, &[settled])]));
    let (all, aim) = (rigs.len() as f64, aims::SHARE_SETTLED);
    let chance = 2.0 * (aim * (1.0 - aim) * all).sqrt();
    all > 0.0 && count >= aim * all - chance
}

fn one(seed: u64) -> Option<Played> {
    let field = set_field(seed);
    let [train, test] = recordings(&field);
    let first = ask(&limited(&field), std::slice::from_ref(&train), &test)?;
    if first.channels[0].verdict != Verdict::Ambiguous {
        return None;
    }
    Some(Played {
        first: names(&first),
        ends: [By::Design, By::FixedAdvice].map(|by| settle(&field, &first, by)),
        id: field.id,
    })
}
