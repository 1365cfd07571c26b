//! Whether the diagnosis of the same record finds what the watch has named.

use super::report::{Agreement, NamedCause, WatchReport};
use diagnosis::{ChannelAnswer, Diagnosis, Model, Recording, Verdict};
use plant::Channel;

/// Share of the record behind the first name in which the diagnosis searches; the rest judges.
const SEARCHED: f64 = 0.6;
/// The least of it that can be asked, s.
const LEAST_S: f64 = 2.0;
/// Names of one thing: a motion tells lateness from lag only where it is fast.
const LATE: [&str; 4] = ["delay_error", "lag_error", "second_lag", "channel_skew"];

/// Asks the diagnosis of `record`, the test's own, for what the watch has named: any cause of any of its sets. `time_scale`: s of the
/// laboratory in one of the model. `None` where nothing was named.
pub fn agreement(
    model: &Model,
    record: &Recording,
    report: &WatchReport,
    time_scale: f64,
) -> Option<Agreement> {
    let first = report.events.iter().find(|e| !e.set.is_empty())?;
    let end_s = record.time_s.last().copied()?;
    let from_s = record.time_s.first()? + first.t_s * time_scale;
    if end_s - from_s < LEAST_S {
        return Some(Agreement {
            agrees: None,
            sentence: format!(
                "The diagnosis was not asked: {:.1} s of record are left behind the name, and it takes {LEAST_S}.",
                (end_s - from_s).max(0.0)
            ),
        });
    }
    let between_s = from_s + SEARCHED * (end_s - from_s);
    let [train, test] = [
        record.span(from_s, between_s),
        record.span(between_s, end_s),
    ];
    Some(match diagnosis::diagnose(model, &[train], &[test], &[]) {
        Err(why) => Agreement {
            agrees: None,
            sentence: format!(
                "The diagnosis of the record from {from_s:.1} s on is refused: {why}."
            ),
        },
        Ok(found) => judged(&found, report, from_s),
    })
}

fn judged(found: &Diagnosis, report: &WatchReport, from_s: f64) -> Agreement {
    let here = format!("diagnosis of the record from {from_s:.1} s on");
    let named = ever_named(report);
    let channels = found.channels.iter();
    let said: Vec<_> = channels.map(|c| (c.channel, names(c))).collect();
    if let Some(both) = named_by_both(&said, &named) {
        return Agreement {
            agrees: Some(true),
            sentence: format!("The {here} agrees: {both}."),
        };
    }
    let asked = |c: &&ChannelAnswer| named.iter().any(|n| shows_in(n.cause.side, c.channel));
    let why: Vec<String> = found.channels.iter().filter(asked).map(why_not).collect();
    Agreement {
        agrees: Some(false),
        sentence: match &why[..] {
            [] => format!("The {here} does not agree: the channel is not declared."),
            several => format!("The {here} does not agree: {}.", several.join("; ")),
        },
    }
}

/// A cause that was in a set, and whether it was in the last one.
struct Named<'a> {
    cause: &'a NamedCause,
    stands: bool,
}

/// Every cause of every set, once: those of the last set before those that were dropped. A set that settles to a wrong name may have
/// held the right one before.
fn ever_named(report: &WatchReport) -> Vec<Named<'_>> {
    let of = |cause: &NamedCause| (cause.name, cause.side);
    let mut all: Vec<Named<'_>> = Vec::new();
    let last = report.events.last().into_iter();
    for (i, event) in last.chain(&report.events).enumerate() {
        for cause in &event.set {
            if !all.iter().any(|known| of(known.cause) == of(cause)) {
                let stands = i == 0;
                all.push(Named { cause, stands });
            }
        }
    }
    all
}

/// True if what the watch finds on `side` shows in a channel of the diagnosis. Two have a displacement.
fn shows_in(side: &str, channel: Channel) -> bool {
    match side {
        "actuator" => channel == Channel::Actuator,
        "displacement" => true,
        _ => channel == Channel::Specimen,
    }
}

fn is_late(name: &str) -> bool {
    LATE.contains(&name)
}

/// The first cause that the diagnosis names, too, in words. `said`: what it names in each channel.
fn named_by_both(said: &[(Channel, Vec<&'static str>)], named: &[Named<'_>]) -> Option<String> {
    named.iter().find_map(|&Named { cause, stands }| {
        let own = cause.name;
        let here = said.iter().filter(|(c, _)| shows_in(cause.side, *c));
        let here: Vec<&'static str> = here.flat_map(|(_, names)| names).copied().collect();
        let is_of_it = |name: &&&str| is_late(name) && is_late(own);
        let name = here.iter().find(|name| **name == own);
        let name = name.or_else(|| here.iter().find(is_of_it))?;
        let too = match *name == own {
            true => "too".to_owned(),
            false => format!("a lateness as {own} is"),
        };
        let dropped = match stands {
            true => "",
            false => ", which the watch had held for possible before",
        };
        Some(format!("it names {name}, {too}{dropped}"))
    })
}

/// Everything that an answer holds for possible, each name once: effects, their rivals, and declared values that are off by two
/// tolerances.
fn names(c: &ChannelAnswer) -> Vec<&'static str> {
    let effects = c.effects.iter().map(|e| e.name.name());
    let rivals = c.alternatives.iter().map(|e| e.name());
    let off = c.refitted.iter().filter(|r| r.tolerances().abs() > 2.0);
    let rows = c.channel.parameters();
    let off = off.filter_map(|r| rows.iter().find(|row| row.name == r.name));
    let off = off.map(|row| row.error.name());
    let mut all = Vec::new();
    // An effect may be its own rival in another place.
    for name in effects.chain(rivals).chain(off) {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all
}

fn why_not(c: &ChannelAnswer) -> String {
    let channel = match c.channel {
        Channel::Actuator => "between command and displacement",
        Channel::Specimen => "between displacement and force",
    };
    let says = match c.verdict {
        Verdict::None => {
            "the declared model explains that part down to its noise: what was named has gone, or is small beside the noise"
                .to_owned()
        }
        Verdict::Unknown => "something is missing that none of its effects explains".to_owned(),
        Verdict::NotAssessed => {
            let why = c.notes.first().map_or("the data do not allow a verdict", String::as_str);
            format!("it gives no verdict, {}", why.trim_end_matches('.'))
        }
        Verdict::Effect | Verdict::Ambiguous | Verdict::Partial => {
            format!("it names {}, on all of that part and not on a few cycles", names(c).join(", "))
        }
    };
    format!("{channel} {says}")
}

#[cfg(test)]
mod tests {
    use super::{ever_named, named_by_both};
    use crate::watch::{NamedCause, WatchEvent, WatchReport};
    use plant::Channel;

    fn report(sets: &[&[(&'static str, &'static str)]]) -> WatchReport {
        let cause = |&(name, side): &(&'static str, &'static str)| NamedCause {
            name,
            side,
            actuator: None,
            value: 1.0,
            unit: "",
            ci90: [0.5, 1.5],
            beside: false,
            corrected: None,
        };
        let event = |set: &&[(&'static str, &'static str)]| WatchEvent {
            t_s: 8.0,
            state: "named",
            set: set.iter().map(cause).collect(),
            corrected: false,
            held: false,
        };
        WatchReport {
            state: "named",
            events: sets.iter().map(event).collect(),
            corrections: Vec::new(),
            diagnosis: None,
            watchable: Vec::new(),
            not_watched: Vec::new(),
        }
    }

    const GAIN: (&str, &str) = ("gain_error", "actuator");
    const LATE: (&str, &str) = ("delay_error", "actuator");
    const FRICTION: (&str, &str) = ("coulomb_friction", "actuator");

    #[test]
    fn each_set_is_looked_at_and_what_stands_goes_first() {
        let report = report(&[&[], &[GAIN, FRICTION], &[LATE, GAIN], &[FRICTION]]);
        let all: Vec<_> = ever_named(&report)
            .iter()
            .map(|n| (n.cause.name, n.stands))
            .collect();
        let expected = [
            ("coulomb_friction", true),
            ("gain_error", false),
            ("delay_error", false),
        ];
        assert_eq!(all, expected);
    }

    #[test]
    fn the_name_that_agrees_is_said_and_of_which_set_it_was() {
        let settled = report(&[&[GAIN, FRICTION], &[FRICTION]]);
        let both = |report: &WatchReport, channel, names: &[&'static str]| {
            named_by_both(&[(channel, names.to_vec())], &ever_named(report))
        };
        let in_actuator = |names: &[&'static str]| both(&settled, Channel::Actuator, names);
        let said = in_actuator(&["gain_error", "coulomb_friction"]);
        assert_eq!(said.as_deref(), Some("it names coulomb_friction, too"));
        let said = in_actuator(&["lag_error", "gain_error"]).expect("of the first set");
        assert!(
            said.starts_with("it names gain_error, too, which"),
            "{said}"
        );
        assert_eq!(in_actuator(&["asymmetric_actuator"]), None);
        // A gain of the load cell is no gain of the actuator.
        assert_eq!(both(&settled, Channel::Specimen, &["gain_error"]), None);
        let late = report(&[&[LATE]]);
        let said = both(&late, Channel::Actuator, &["lag_error"]);
        let as_it_is = "it names lag_error, a lateness as delay_error is";
        assert_eq!(said.as_deref(), Some(as_it_is));
    }
}
