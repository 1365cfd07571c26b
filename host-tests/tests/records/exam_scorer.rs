//! Test of the exam itself: an examinee that knows the key must pass, and one that knows nothing must fail.

use exam::{Class, Key, set};
use host_tests::exam::answer::{Effect, Error, Value};
use host_tests::exam::plan::{Item, TUNING};
use host_tests::exam::run::run_exam;
use host_tests::exam::{Answer, ChannelAnswer, Plan, Report};
use rayon::prelude::*;
use std::sync::LazyLock;

fn plan() -> Vec<Item> {
    Plan::quick(TUNING).at_most(4).items
}

/// The keys of the plan, computed once for all tests.
fn keys() -> &'static [(Item, Key)] {
    static KEYS: LazyLock<Vec<(Item, Key)>> = LazyLock::new(|| {
        let with_key = |item: Item| (item, set(item.class, item.seed, &item.options()).key);
        plan().into_par_iter().map(with_key).collect()
    });
    &KEYS
}

/// Answers made from the key by `verdict`, one channel at a time.
fn answers(verdict: impl Fn(&Item, &exam::ChannelKey) -> ChannelAnswer + Sync) -> Vec<Option<f64>> {
    let keys = keys();
    let all = run_exam(
        &plan(),
        |item, _| {
            let key = keys.iter().find(|(of, _)| of == item);
            let (_, key) = key.expect("a record of the plan");
            let channels = key.channels.iter().map(|k| ChannelAnswer {
                channel: k.channel.name().into(),
                ..verdict(item, k)
            });
            Ok(Answer {
                seconds: 0.0,
                channels: channels.collect(),
            })
        },
        |_| (),
    )
    .unwrap();
    let report = Report::new(&all);
    println!("{}\n{}", report.target_table(), report.aim_table());
    assert_eq!(
        report.to_json()["records"].as_array().unwrap().len(),
        all.len()
    );
    report
        .targets
        .iter()
        .map(|t| t.met().map(|met| if met { 1.0 } else { 0.0 }))
        .collect()
}

fn naming(names: &[&str]) -> ChannelAnswer {
    ChannelAnswer {
        verdict: if names.is_empty() { "none" } else { "effect" }.into(),
        effects: names
            .iter()
            .map(|n| Effect {
                name: (*n).into(),
                parameters: vec![],
                p: None,
            })
            .collect(),
        ..Default::default()
    }
}

#[test]
fn who_knows_the_key_meets_every_target() {
    let met = answers(|_, key| {
        let mut answer = naming(&key.hidden.iter().map(|h| h.name).collect::<Vec<_>>());
        for (effect, hidden) in answer.effects.iter_mut().zip(&key.hidden) {
            effect.parameters = hidden
                .parameters
                .iter()
                .enumerate()
                .map(|(i, (name, truth))| Value {
                    name: (*name).into(),
                    value: *truth,
                    // An interval that holds nine times in ten.
                    ci90: Some(
                        if (i + key.floor_rms.to_bits() as usize).is_multiple_of(10) {
                            [truth + 1.0, truth + 2.0]
                        } else {
                            [truth - 1.0, truth + 1.0]
                        },
                    ),
                })
                .collect();
        }
        if key.outside.is_some() {
            answer.verdict = "unknown".into();
        }
        answer.error_before = Some(Error {
            test_rms: 9.0 * key.floor_rms,
        });
        answer.error_after = Some(Error {
            test_rms: 1.01 * key.floor_rms,
        });
        answer
    });
    // Coverage over a dozen intervals and the speed of this machine are not tested here.
    for (i, met) in met
        .iter()
        .enumerate()
        .filter(|(i, _)| ![10, 12].contains(i))
    {
        assert_eq!(*met, Some(1.0), "target {i}");
    }
    assert!(met[10].is_some(), "intervals were counted");
}

#[test]
fn who_always_says_none_finds_nothing_and_raises_no_alarm() {
    let met = answers(|_, key| ChannelAnswer {
        error_before: Some(Error {
            test_rms: 9.0 * key.floor_rms,
        }),
        error_after: Some(Error {
            test_rms: 9.0 * key.floor_rms,
        }),
        ..naming(&[])
    });
    let [exact, right, wrong, abstains, false_positives, both, ..] = met[..] else {
        panic!("six targets at least");
    };
    assert_eq!([exact, right, abstains, both], [Some(0.0); 4]);
    assert_eq!([wrong, false_positives], [Some(1.0); 2]);
    assert_eq!([met[8], met[9]], [Some(0.0); 2], "the error stays");
}

#[test]
fn who_always_says_unknown_abstains_and_is_a_false_alarm() {
    let met = answers(|_, _| ChannelAnswer {
        verdict: "unknown".into(),
        ..Default::default()
    });
    // Abstaining also in the other channel is an alarm there.
    assert_eq!([met[0], met[1], met[3], met[4], met[5]], [Some(0.0); 5]);
}

#[test]
fn who_guesses_is_caught_being_wrong() {
    let met = answers(|item, _| {
        let turn = (item.seed * 7 + item.class as u64 * 3 + 1) as usize;
        naming(&[exam::effect::LIST[turn % exam::effect::LIST.len()].0])
    });
    assert_eq!(met[..6], [Some(0.0); 6], "no target of the first six");
    assert_eq!(met[7], Some(0.0), "wrong in the confounded ones as well");
}

#[test]
fn an_examinee_that_makes_a_record_worse_is_seen() {
    let met = answers(|_, key| ChannelAnswer {
        error_before: Some(Error {
            test_rms: 2.0 * key.floor_rms,
        }),
        error_after: Some(Error {
            test_rms: 2.1 * key.floor_rms,
        }),
        ..naming(&["drift"])
    });
    assert_eq!(met[11], Some(0.0));
}

#[test]
fn exported_questions_hold_the_paper_and_nothing_of_the_key() {
    let folder = std::env::temp_dir().join(format!("exam-export-{}", std::process::id()));
    let items = [Item {
        class: Class::Unseen,
        seed: 15,
        detection: None,
    }];
    assert_eq!(
        host_tests::exam::export::export(&folder, &items).unwrap(),
        1
    );
    let own = folder.join("unseen-15");
    let train = std::fs::read_to_string(own.join("train.csv")).unwrap();
    assert_eq!(train.lines().count(), 22_001);
    assert!(train.starts_with("time_s,command_mm,displacement_mm,force_n\n"));
    let model = std::fs::read_to_string(own.join("model.toml")).unwrap();
    let model: toml::Table = model.parse().unwrap();
    assert!(model["actuator"]["lag_ms"]["tolerance"].as_float().unwrap() > 0.0);
    let hidden = set(Class::Unseen, 15, &Default::default()).key.channels[0].hidden[0].name;
    for file in std::fs::read_dir(&own).unwrap() {
        let text = std::fs::read_to_string(file.unwrap().path()).unwrap();
        assert!(!text.contains(hidden));
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
