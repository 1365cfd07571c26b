//! The page docs/proof-table.md, and what is missing from it.

use super::claims::{self, Claim, Place};
use super::ids::{self, Id, Kind};
use super::mutants::{self, Mutant};
use super::top;
use outerloop_core::{Event, Mode};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Smallest percentage of pairs of mode and event that must be proved on this machine, and on the image.
pub const PAIRS_PERCENT: usize = 95;

/// The contents of the table.
#[derive(Clone, Debug)]
pub struct Proofs {
    ids: Vec<Id>,
    claims: Vec<Claim>,
    mutants: Vec<Mutant>,
}

impl Proofs {
    /// Reads them from the repository.
    ///
    /// # Errors
    /// Claims and mutants that are false, a sentence each.
    pub fn read() -> Result<Self, Vec<String>> {
        let (top, ids) = (top(), ids::all());
        let claims = claims::all(&top, &ids)?;
        let mutants = mutants::all(&top, &ids).map_err(|e| vec![e])?;
        let misfits = mutants::misfits(&top, &mutants, &claims);
        if !misfits.is_empty() {
            return Err(misfits);
        }
        Ok(Self {
            ids,
            claims,
            mutants,
        })
    }

    fn proved(&self, id: &str, place: Place) -> bool {
        let mut there = self.claims.iter().filter(|c| c.place == place);
        there.any(|c| c.has(id))
    }

    /// What the targets require and is missing, a sentence each.
    pub fn gaps(&self) -> Vec<String> {
        let mut gaps = Vec::new();
        for id in &self.ids {
            for place in [Place::Host, Place::Image] {
                let asked = id.kind != Kind::Mode && exempt(id, place).is_none();
                if asked && !self.proved(&id.name, place) {
                    gaps.push(format!("{}: no test ({place:?})", id.name));
                }
            }
            if self.spoilt(&id.name).is_empty() {
                gaps.push(format!("{}: no mutant and nothing made to fail", id.name));
            }
        }
        let pairs = self.ids.iter().filter(|id| id.kind == Kind::Mode).count();
        for place in [Place::Host, Place::Image] {
            let proved = self.pairs(place);
            if proved * 100 < pairs * PAIRS_PERCENT {
                gaps.push(format!(
                    "{proved} of {pairs} pairs of mode and event ({place:?})"
                ));
            }
        }
        gaps
    }

    fn pairs(&self, place: Place) -> usize {
        let modes = self.ids.iter().filter(|id| id.kind == Kind::Mode);
        modes.filter(|id| self.proved(&id.name, place)).count()
    }

    /// Mutants by number, and what tests make fail, for an id.
    fn spoilt(&self, id: &str) -> String {
        let mutants = self.mutants.iter().enumerate();
        let mutants = mutants.filter(|(_, m)| m.ids.iter().any(|i| i == id));
        let mut names: Vec<String> = mutants.map(|(at, _)| format!("M{}", at + 1)).collect();
        let claimed = self.claims.iter().flat_map(|c| &c.ids);
        for by in claimed.filter(|(i, _)| i == id).flat_map(|(_, by)| by) {
            let by = format!("`{by}`");
            if !names.contains(&by) {
                names.push(by);
            }
        }
        names.join(", ")
    }

    /// Numbers of the tests of an id in a place.
    fn tests(&self, id: &str, place: Place) -> String {
        let here = self.claims.iter().filter(|c| c.place == place);
        let numbers: Vec<String> = here
            .enumerate()
            .filter(|(_, c)| c.has(id))
            .map(|(at, _)| format!("{}{}", place.letter(), at + 1))
            .collect();
        numbers.join(", ")
    }

    /// The page.
    pub fn page(&self) -> String {
        let mut page = String::from(HEAD);
        self.shares(&mut page);
        for kind in Kind::ALL.into_iter().filter(|k| *k != Kind::Mode) {
            self.rows(&mut page, kind);
        }
        self.matrix(&mut page);
        self.tests_by_number(&mut page);
        self.mutants_by_number(&mut page);
        page
    }

    /// Which percentage of each kind is proved where.
    fn shares(&self, page: &mut String) {
        page.push_str("\n| | there are | host | QEMU | image | a reason in place of the image |\n|---|---|---|---|---|---|\n");
        for kind in Kind::ALL {
            let ids: Vec<&Id> = self.ids.iter().filter(|id| id.kind == kind).collect();
            let share = |place: Place| {
                let proved = ids.iter().filter(|id| self.proved(&id.name, place));
                100.0 * proved.count() as f64 / ids.len() as f64
            };
            let reasons = ids.iter().filter(|id| exempt(id, Place::Image).is_some());
            let _ = writeln!(
                page,
                "| {} | {} | {:.0} % | {:.0} % | {:.0} % | {} |",
                title(kind),
                ids.len(),
                share(Place::Host),
                share(Place::Qemu),
                share(Place::Image),
                reasons.count()
            );
        }
    }

    fn rows(&self, page: &mut String, kind: Kind) {
        let title = title(kind);
        let _ = write!(
            page,
            "\n## {title}\n\n| id | host | QEMU | image | seen by |\n|---|---|---|---|---|\n"
        );
        for id in self.ids.iter().filter(|id| id.kind == kind) {
            let [host, qemu, image] = Place::ALL.map(|place| {
                let tests = self.tests(&id.name, place);
                match exempt(id, place) {
                    Some(why) if tests.is_empty() => why.into(),
                    _ => tests,
                }
            });
            let (name, spoilt) = (&id.name, self.spoilt(&id.name));
            let _ = writeln!(page, "| `{name}` | {host} | {qemu} | {image} | {spoilt} |");
        }
    }

    /// The mode after each event in each mode, and where that is proved.
    fn matrix(&self, page: &mut String) {
        let pairs = Mode::ALL.len() * Event::ALL.len();
        let [host, qemu, image] = Place::ALL.map(|place| self.pairs(place));
        let _ = write!(
            page,
            "\n## Modes and events\n\nThe mode after each event, a dot where it is refused, and the places in which a test holds \
             it (H host, Q QEMU, I image).\nOf {pairs} pairs {host} are held on the host, {qemu} in QEMU, {image} on the image.\n\n| mode |"
        );
        for event in Event::ALL {
            let _ = write!(page, " {event:?} |");
        }
        let _ = writeln!(page, "\n|{}", "---|".repeat(Event::ALL.len() + 1));
        for mode in Mode::ALL {
            let _ = write!(page, "| {mode:?} |");
            for event in Event::ALL {
                let after = mode.after(event);
                let after = after.map_or(".".into(), |m| format!("{m:?}"));
                let id = ids::pair(mode, event);
                let places = Place::ALL.into_iter().filter(|p| self.proved(&id, *p));
                let letters: String = places.map(Place::letter).collect();
                let _ = write!(page, " {after} {letters} |");
            }
            page.push('\n');
        }
        page.push_str("\nTests of them: ");
        let tests: Vec<String> = Place::ALL
            .into_iter()
            .flat_map(|place| {
                let here = self.claims.iter().filter(move |c| c.place == place);
                let with = |c: &Claim| c.ids.iter().any(|(i, _)| i.starts_with("mode."));
                here.enumerate()
                    .filter(move |(_, c)| with(c))
                    .map(move |(at, _)| format!("{}{}", place.letter(), at + 1))
            })
            .collect();
        let modes = self.ids.iter().filter(|id| id.kind == Kind::Mode);
        let spoilt: BTreeSet<String> = modes.map(|id| self.spoilt(&id.name)).collect();
        let spoilt: Vec<String> = spoilt.into_iter().collect();
        let _ = writeln!(
            page,
            "{}; each pair is seen by {}.",
            tests.join(", "),
            spoilt.join(" or ")
        );
    }

    fn tests_by_number(&self, page: &mut String) {
        page.push_str("\n## Tests\n\n| | test | file |\n|---|---|---|\n");
        for place in Place::ALL {
            let here = self.claims.iter().filter(|c| c.place == place);
            for (at, claim) in here.enumerate() {
                let nightly = if claim.nightly { ", nightly" } else { "" };
                let _ = writeln!(
                    page,
                    "| {}{} | `{}`{nightly} | {} |",
                    place.letter(),
                    at + 1,
                    claim.test,
                    claim.file
                );
            }
        }
    }

    fn mutants_by_number(&self, page: &mut String) {
        page.push_str("\n## Mutants\n\n| | what is wrong | in | seen by |\n|---|---|---|---|\n");
        for (at, mutant) in self.mutants.iter().enumerate() {
            let Mutant {
                name, file, test, ..
            } = mutant;
            let ways = match mutant.ways {
                0 => String::new(),
                ways => format!(", in {ways} ways"),
            };
            let _ = writeln!(page, "| M{} | {name}{ways} | {file} | `{test}` |", at + 1);
        }
    }
}

fn title(kind: Kind) -> &'static str {
    match kind {
        Kind::Command => "Commands",
        Kind::Fault => "Faults",
        Kind::Obstacle => "What stands against arming or starting",
        Kind::Limit => "Limits",
        Kind::Mode => "Modes and events",
    }
}

/// Why an id needs no test in a place.
fn exempt(id: &Id, place: Place) -> Option<&'static str> {
    if place != Place::Image {
        return None;
    }
    match id.name.as_str() {
        "limit.energy_warning" | "limit.locked_damping_ratio" => Some("only tells"),
        "limit.energy_floor_j" => Some("part of another"),
        _ => None,
    }
}

const HEAD: &str = "# Proof table

What the board can be asked, what trips a test, what stands against arming or starting, every limit, every event in every mode: which
test holds it on this machine, in QEMU and on the flashed image, and what was made wrong to see that the test sees it: a mutant of the
code (M), or what the test itself makes to fail. Printed from the code's own lists and the claims above the tests, by

```sh
cargo run -p host-tests --bin proof-table -- --markdown
```

A test of the scenarios holds that this page is what is printed and that nothing is missing: every id has
something that was made to fail, every id but the pairs a test on the host and on the image; 95 of 100 pairs of mode and event have a
test on both. A mutant leads each pair to each of the modes that it does not lead to, and refuses each that is not refused.
What has a reason in place of a test: a limit that *only tells* changes no command; the least energy is *part of another* limit,
`energy_trip`.
`scripts/mutants` makes each mutant and runs its test, which has to fail (nightly).
[Images with a wrong register, and images that lack a safeguard](firmware-validation.md#wrong-registers) are on a page of their own.
";
