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

/// Asks the diagnosis of `record`, the test's own, what the watch has named. `time_scale`: s of the laboratory in one of the
/// model. `None` where nothing was named.
pub fn agreement(
    model: &Model,
    record: &Recording,
    report: &WatchReport,
    time_scale: f64,
) -> Option<Agreement> {
    let first = report.events.iter().find(|e| !e.set.is_empty())?;
    let set = &report.events.last()?.set;
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
        Ok(found) => judged(&found, set, from_s),
    })
}

fn judged(found: &Diagnosis, set: &[NamedCause], from_s: f64) -> Agreement {
    let here = format!("diagnosis of the record from {from_s:.1} s on");
    let all: Vec<&str> = found.channels.iter().flat_map(names).collect();
    let same = |name: &str| {
        all.iter()
            .any(|n| *n == name || (LATE.contains(n) && LATE.contains(&name)))
    };
    let shared: Vec<&str> = set.iter().map(|c| c.name).filter(|n| same(n)).collect();
    if let Some(one) = shared.first() {
        return Agreement {
            agrees: Some(true),
            sentence: format!("The {here} agrees: it names {one}, too."),
        };
    }
    let asked = |c: &&ChannelAnswer| {
        set.iter().any(|cause| match cause.side {
            "actuator" => c.channel == Channel::Actuator,
            "displacement" => true,
            _ => c.channel == Channel::Specimen,
        })
    };
    let why: Vec<String> = found.channels.iter().filter(asked).map(why_not).collect();
    Agreement {
        agrees: Some(false),
        sentence: match &why[..] {
            [] => format!("The {here} does not agree: the channel is not declared."),
            several => format!("The {here} does not agree: {}.", several.join("; ")),
        },
    }
}

/// Everything that an answer holds for possible: effects, their rivals, and declared values that are off by two tolerances.
fn names(c: &ChannelAnswer) -> Vec<&'static str> {
    let effects = c.effects.iter().map(|e| e.name.name());
    let rivals = c.alternatives.iter().map(|e| e.name());
    let off = c.refitted.iter().filter(|r| r.tolerances().abs() > 2.0);
    let rows = c.channel.parameters();
    let off = off.filter_map(|r| rows.iter().find(|row| row.name == r.name));
    effects
        .chain(rivals)
        .chain(off.map(|row| row.error.name()))
        .collect()
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
