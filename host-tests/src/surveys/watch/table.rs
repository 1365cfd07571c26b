//! Targets, results, and by how much they are missed.

use super::effect::Kind;
use super::trial::{FaultTrial, Learning, SoundTrial, Unwatched};
use experiment::summary::POOR_EPS_RMS;
use serde::Serialize;

/// What an effect must add to the error to count, as a fraction of the peak.
const MATTERS: f64 = 0.01;
/// What it must add to count in the fraction that is named.
const CLEARLY: f64 = 0.05;
/// The method for which the study judges the guard.
const ATS: &str = "ats";
/// A test is worse than another if its error is larger by more than this, as a fraction of the peak.
const WORSE: f64 = 0.01;

impl FaultTrial {
    /// Whether the correction has made it worse. If it was stopped sooner without it, the errors are of different durations.
    pub fn is_made_worse(&self) -> bool {
        self.counts && !self.longer && self.eps[2] > self.eps[1] + WORSE
    }
}

/// A row of the table of targets.
#[derive(Clone, Debug, Serialize)]
pub struct Target {
    /// The quantity.
    pub target: &'static str,
    /// The target value, in words.
    pub aim: &'static str,
    /// The result, in words.
    pub found: String,
    /// By how much the target is missed; empty if it is reached.
    pub missed: String,
    /// False if it is worse than on the page (docs/rig-watch-validation.md) by more than chance.
    pub holds: bool,
}

/// A number of tests out of all.
#[derive(Clone, Copy)]
struct Share {
    n: usize,
    of: usize,
}

impl Share {
    fn among<T>(all: &[&T], has: impl Fn(&T) -> bool) -> Self {
        Self {
            n: all.iter().filter(|t| has(t)).count(),
            of: all.len(),
        }
    }

    fn percent(self) -> f64 {
        100.0 * self.share()
    }

    fn in_words(self) -> String {
        format!("{:.0} % ({} of {})", self.percent(), self.n, self.of)
    }

    fn share(self) -> f64 {
        self.n as f64 / self.of.max(1) as f64
    }

    /// Four standard deviations of a fraction of this many: the figure on the page is also from a draw.
    fn chance(self, share: f64) -> f64 {
        4.0 * (share * (1.0 - share) / self.of.max(1) as f64).sqrt()
    }

    /// Whether it is not below the figure on the page by more than chance.
    fn holds_at_least(self, share: f64) -> bool {
        self.of == 0 || self.share() >= share - self.chance(share)
    }

    /// Whether it is not above the figure on the page by more than chance plus one test.
    fn holds_at_most(self, share: f64) -> bool {
        self.n <= 1 || self.share() <= share + self.chance(share) + 1.0 / self.of as f64
    }

    /// By how many points it is below the target.
    fn below(self, aim: f64) -> String {
        let points = aim - self.percent();
        match points > 0.0 {
            true if self.of > 0 => in_points(points),
            _ => String::new(),
        }
    }

    /// Number of tests of which there should be none, in words.
    fn too_many(self) -> String {
        match self.n {
            0 => String::new(),
            1 => "1 test".into(),
            more => format!("{more} tests"),
        }
    }
}

/// By how many points a target is missed, never written as zero.
fn in_points(missed: f64) -> String {
    match missed {
        x if x < 0.1 => "less than 0.1 points".into(),
        x if x < 10.0 => format!("{x:.1} points"),
        x => format!("{x:.0} points"),
    }
}

/// Every row of the table; `recorded`: sound tests with recorded ground motions; `of_any_kind`: tests with an effect of any kind,
/// from the start or in mid-test.
pub fn targets(
    [sound, recorded]: [&[SoundTrial]; 2],
    faulty: &[FaultTrial],
    of_any_kind: &[FaultTrial],
) -> Vec<Target> {
    let one: Vec<&FaultTrial> = faulty.iter().filter(|t| t.beside.is_none()).collect();
    let mut rows = false_names(sound, recorded);
    rows.extend(names(&one));
    rows.extend(corrections(&one));
    let all: Vec<&FaultTrial> = faulty.iter().chain(of_any_kind).collect();
    rows.extend(harm(sound, &all));
    rows.extend(guards(faulty));
    rows.extend(of_any(of_any_kind));
    rows.extend(beside(sound, faulty));
    rows
}

/// Harm done by corrections.
fn harm(sound: &[SoundTrial], faulty: &[&FaultTrial]) -> Vec<Target> {
    let counts = faulty.iter().filter(|t| t.counts);
    let allowed: Vec<&FaultTrial> = counts.copied().collect();
    let sound: Vec<&SoundTrial> = sound.iter().filter(|t| t.counts).collect();
    let is_worse = |t: &SoundTrial| t.corrected_eps > t.eps + WORSE;
    vec![
        count(
            "correction worse by more than 1 % of peak",
            "0 of 5000",
            Share::among(&allowed, FaultTrial::is_made_worse),
            1.8e-3,
        ),
        count(
            "the same, sound tests",
            "0",
            Share::among(&sound, is_worse),
            3e-4,
        ),
        count(
            "unstable with the correction alone",
            "0 of 5000",
            Share::among(&allowed, |t| t.unstable),
            1e-3,
        ),
    ]
}

/// The rows of tests with an effect of any kind, from the start or in mid-test.
fn of_any(all: &[FaultTrial]) -> Vec<Target> {
    let that = |has: &dyn Fn(&FaultTrial) -> bool| -> Vec<&FaultTrial> {
        all.iter().filter(|t| has(t)).collect()
    };
    let clearly = that(&|t| t.adds(CLEARLY));
    let named = that(&|t| t.adds(MATTERS) && t.named.is_some());
    vec![
        share(
            "any kind, from the start or in mid-test: named, of those that add more than 5 %",
            "85 %",
            Share::among(&clearly, |t| t.named.is_some()),
            [85.0, 62.0],
        ),
        share(
            "any kind: first name or set right",
            "90 %",
            Share::among(&named, |t| t.right[0]),
            [90.0, 92.0],
        ),
        share(
            "any kind: after it settled",
            "97 %",
            Share::among(&named, |t| t.right[1]),
            [97.0, 95.0],
        ),
    ]
}

/// A figure that should be small: by how much it exceeds the target and the figure on the page; `found` in words.
fn at_most(
    target: &'static str,
    aim: &'static str,
    found: String,
    [missed, beyond]: [f64; 2],
    unit: &str,
) -> Target {
    Target {
        holds: beyond.is_nan() || beyond <= 0.0,
        ..row(
            target,
            aim,
            found,
            match missed > 0.0 {
                true => format!("{missed:.1} {unit}"),
                false => String::new(),
            },
        )
    }
}

fn row(target: &'static str, aim: &'static str, found: String, missed: String) -> Target {
    Target {
        target,
        aim,
        found,
        missed,
        holds: true,
    }
}

/// A number of tests of which there should be none; `held`: the fraction on the page.
fn count(target: &'static str, aim: &'static str, share: Share, held: f64) -> Target {
    let found = format!("{} of {}", share.n, share.of);
    Target {
        holds: share.holds_at_most(held),
        ..row(target, aim, found, share.too_many())
    }
}

/// A fraction that should be large; `held`: the percentage on the page.
fn share(target: &'static str, aim: &'static str, share: Share, [least, held]: [f64; 2]) -> Target {
    Target {
        holds: share.holds_at_least(0.01 * held),
        ..row(target, aim, share.in_words(), share.below(least))
    }
}

fn false_names(sound: &[SoundTrial], recorded: &[SoundTrial]) -> Vec<Target> {
    let counts: Vec<&SoundTrial> = sound.iter().filter(|t| t.counts).collect();
    let hidden = |t: &&&SoundTrial| t.yields && t.declared_elastic;
    let elastic: Vec<&SoundTrial> = counts.iter().filter(hidden).copied().collect();
    let bent: Vec<&SoundTrial> = counts.iter().filter(|t| t.bends).copied().collect();
    let named = |t: &SoundTrial| t.named.is_some();
    vec![
        count(
            "false names in sound tests",
            "0 of 10 000",
            Share::among(&counts, named),
            3e-4,
        ),
        count(
            "the same, yields though declared elastic",
            "0 of 2000",
            Share::among(&elastic, named),
            3e-4,
        ),
        count(
            "the same, hardens, softens or degrades though declared linear",
            "0",
            Share::among(&bent, named),
            1e-3,
        ),
        count(
            "the same, recorded ground motions",
            "0",
            Share::among(
                &recorded.iter().filter(|t| t.counts).collect::<Vec<_>>(),
                named,
            ),
            1e-3,
        ),
    ]
}

fn names(one: &[&FaultTrial]) -> Vec<Target> {
    let that = |has: &dyn Fn(&FaultTrial) -> bool| -> Vec<&FaultTrial> {
        one.iter().filter(|t| has(t)).copied().collect()
    };
    let clearly = that(&|t| t.adds(CLEARLY));
    let elastic = that(&|t| t.adds(CLEARLY) && t.elastic);
    let named = that(&|t| t.adds(MATTERS) && t.named.is_some());
    let mut cycles: Vec<f64> = named.iter().filter_map(|t| t.cycles).collect();
    cycles.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let i = (share * cycles.len() as f64) as usize;
        cycles
            .get(i.min(cycles.len().saturating_sub(1)))
            .copied()
            .unwrap_or(f64::NAN)
    };
    let (median, late) = (at(0.5), at(0.9));
    let mut rows = vec![
        share(
            "named, of effects that add more than 5 % of peak",
            "85 %",
            Share::among(&clearly, |t| t.named.is_some()),
            [85.0, 52.0],
        ),
        share(
            "the same, specimen declared elastic",
            "90 %",
            Share::among(&elastic, |t| t.named.is_some()),
            [90.0, 64.0],
        ),
        share(
            "first name or set right",
            "90 %",
            Share::among(&named, |t| t.right[0]),
            [90.0, 87.0],
        ),
        share(
            "after it settled",
            "97 %",
            Share::among(&named, |t| t.right[1]),
            [97.0, 91.0],
        ),
        at_most(
            "first right name, cycles of the structure: median",
            "1",
            format!("{median:.1}"),
            [median - 1.0, median - 1.5],
            "cycles",
        ),
        at_most(
            "the same, 90 % of them",
            "4",
            format!("{late:.1}"),
            [late - 4.0, late - 5.5],
            "cycles",
        ),
    ];
    for (target, kinds, held) in [
        (
            "settled to one name: late actuator",
            &[Kind::ActuatorLate][..],
            77.0,
        ),
        (
            "settled to one name: limits of stroke and rate",
            &[Kind::StrokeLimit, Kind::RateLimit],
            83.0,
        ),
        ("settled to one name: frozen sensor", &[Kind::Frozen], 91.0),
        ("settled to one name: play", &[Kind::Play], 96.0),
    ] {
        let own: Vec<&FaultTrial> = named
            .iter()
            .filter(|t| kinds.contains(&t.kind))
            .copied()
            .collect();
        rows.push(share(
            target,
            "90 %",
            Share::among(&own, |t| t.right[2]),
            [90.0, held],
        ));
    }
    rows
}

fn corrections(one: &[&FaultTrial]) -> Vec<Target> {
    let counts: Vec<&FaultTrial> = one.iter().filter(|t| t.counts).copied().collect();
    let late = |t: &&&FaultTrial| t.kind == Kind::ActuatorLate && t.adds(MATTERS);
    let late: Vec<&FaultTrial> = counts.iter().filter(late).copied().collect();
    let corrected: Vec<&FaultTrial> = late.iter().filter(|t| !t.learns).copied().collect();
    let mean = |of: &dyn Fn(&FaultTrial) -> f64| {
        100.0 * corrected.iter().map(|t| of(t)).sum::<f64>() / corrected.len().max(1) as f64
    };
    let halved = Share::among(&corrected, |t| t.eps[2] - t.eps[0] <= 0.5 * t.added());
    let ats: Vec<f64> = late
        .iter()
        .filter_map(|t| t.adaptive.as_ref())
        .filter(|own| own.method == ATS)
        .map(|own| own.guarded)
        .collect();
    let ats = 100.0 * ats.iter().sum::<f64>() / ats.len().max(1) as f64;
    let of_errors = format!(
        "; {:.1} % without it, {:.1} with it, {:.1} corrected",
        mean(&|t| t.eps[0]),
        mean(&|t| t.eps[1]),
        mean(&|t| t.eps[2])
    );
    let mut halves = share(
        "error that a late actuator adds, halved by the correction",
        "in 90 %",
        halved,
        [90.0, 60.0],
    );
    halves.found += &of_errors;
    vec![
        halves,
        at_most(
            "eps_rms with a late actuator under guarded ats",
            "2 %",
            format!("{ats:.1} %"),
            [ats - 2.0, ats - 12.0],
            "points",
        ),
    ]
}

/// How often a wrong transducer adds more error to a test with an adaptive method, by over 1 % of the peak, than to the same
/// test with the rig's own compensation.
fn guards(faulty: &[FaultTrial]) -> Vec<Target> {
    let of = |is_ats: bool, eps: fn(&Learning) -> f64| {
        let lies = faulty
            .iter()
            .filter(|t| t.counts && t.beside.is_none() && t.kind.lies());
        let tests = lies.filter_map(|t| Some((t, t.adaptive.as_ref()?)));
        // A method that does not fit the sound rig cannot be misled.
        let fits = |own: &Learning| (own.method == ATS) == is_ats && own.sound <= POOR_EPS_RMS;
        let tests: Vec<_> = tests.filter(|(_, own)| fits(own)).collect();
        let worse =
            |(t, own): &(&FaultTrial, &Learning)| eps(own) - own.sound > t.added().max(0.0) + WORSE;
        Share::among(&tests.iter().collect::<Vec<_>>(), worse)
    };
    let guarded = |target, is_ats, held: f64| {
        let found = of(is_ats, |own| own.guarded);
        // At most 10 of 1068.
        let missed = found.percent() - 0.94;
        let beyond = if found.holds_at_most(0.01 * held) {
            0.0
        } else {
            1.0
        };
        at_most(
            target,
            "at most 1 %",
            found.in_words(),
            [missed, beyond],
            "points",
        )
    };
    let not_guarded = |target, is_ats| {
        row(
            target,
            "",
            of(is_ats, |own| own.unguarded).in_words(),
            String::new(),
        )
    };
    vec![
        guarded("ats worse by a lying transducer, guarded", true, 10.0),
        not_guarded("the same, not guarded", true),
        guarded(
            "others that learn worse by a lying transducer, guarded",
            false,
            10.0,
        ),
        not_guarded("the same, not guarded", false),
    ]
}

/// Other monitors, and cases for which the watch was not made; these rows have no target.
fn beside(sound: &[SoundTrial], faulty: &[FaultTrial]) -> Vec<Target> {
    let counts: Vec<&SoundTrial> = sound.iter().filter(|t| t.counts).collect();
    let matter: Vec<&FaultTrial> = faulty.iter().filter(|t| t.adds(MATTERS)).collect();
    let of = |has: &dyn Fn(&FaultTrial) -> bool| -> Vec<&FaultTrial> {
        matter.iter().filter(|t| has(t)).copied().collect()
    };
    let (one, two) = (of(&|t| t.beside.is_none()), of(&|t| t.beside.is_some()));
    let several = of(&|t| t.several);
    let stopped: Vec<(f64, &Unwatched)> = { faulty.iter() }
        .filter_map(|t| Some((t.eps[1], t.unwatched.as_ref()?)))
        .collect();
    let of_stopped = |of: &dyn Fn(&(f64, &Unwatched)) -> f64| {
        100.0 * stopped.iter().map(of).sum::<f64>() / stopped.len().max(1) as f64
    };
    let without = format!(
        "{} tests, at {:.1} % in the mean; without it {:.1} %, {:.0} % of them stopped by something else",
        stopped.len(),
        of_stopped(&|(eps, _)| *eps),
        of_stopped(&|(_, alone)| alone.eps),
        of_stopped(&|(_, alone)| f64::from(u8::from(alone.stopped))),
    );
    let named = |t: &FaultTrial| t.named.is_some();
    let told = |own: &[&FaultTrial]| {
        let right = Share::among(own, |t| t.right[0]);
        format!(
            "{}; first set right {}",
            Share::among(own, named).in_words(),
            right.in_words()
        )
    };
    let plain = |target, found| row(target, "", found, String::new());
    vec![
        plain("stopped by the watch: eps_rms by then", without),
        plain(
            "energy monitor: sound tests beyond its published 0.2 at their end",
            Share::among(&counts, |t| t.energy).in_words(),
        ),
        plain(
            "energy monitor: effects that add more than 1 % stopped at 3.0",
            Share::among(&one, |t| t.energy).in_words(),
        ),
        plain("named, of effects that add more than 1 %", told(&one)),
        plain("the same, two effects at once (one of them)", told(&two)),
        plain("the same, with two actuators", told(&several)),
    ]
}

/// A row for each effect of `kinds`: tests, those that matter, named, first right, settled right, one name, eps without, with and corrected.
pub fn by_effect(kinds: &[Kind], faulty: &[FaultTrial]) -> Vec<[String; 9]> {
    kinds
        .iter()
        .map(|&kind| {
            let own = faulty
                .iter()
                .filter(|t| t.kind == kind && t.beside.is_none());
            let all: Vec<&FaultTrial> = own.collect();
            let matter: Vec<&FaultTrial> =
                all.iter().filter(|t| t.adds(MATTERS)).copied().collect();
            let n = |has: &dyn Fn(&FaultTrial) -> bool| {
                matter.iter().filter(|t| has(t)).count().to_string()
            };
            let eps = |i: usize| {
                let sum: f64 = matter.iter().map(|t| t.eps[i]).sum();
                format!("{:.1}", 100.0 * sum / matter.len().max(1) as f64)
            };
            [
                kind.name().into(),
                matter.len().to_string(),
                n(&|t| t.named.is_some()),
                n(&|t| t.right[0]),
                n(&|t| t.right[1]),
                n(&|t| t.right[2]),
                eps(0),
                eps(1),
                eps(2),
            ]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_holds_where_it_is_no_worse_than_on_the_page_by_more_than_chance() {
        let at_least = |n| Share { n, of: 100 }.holds_at_least(0.9);
        // Four standard deviations of 90 of 100 are 12.
        assert_eq!([77, 78, 100].map(at_least), [false, true, true]);
        let at_most = |n| Share { n, of: 1000 }.holds_at_most(1e-3);
        // One, four standard deviations of nearly one each, and one more: just below six.
        assert_eq!([1, 5, 6].map(at_most), [true, true, false]);
        assert!(
            Share { n: 0, of: 0 }.holds_at_least(0.9),
            "nothing was asked"
        );
    }
}
