//! What gets a name, and what passes in silence.

use crate::effects::EACH;
use crate::{holds, named, watched};

#[test]
fn a_sound_test_and_a_specimen_that_yields_pass_in_silence() {
    for specimen in [
        "",
        "[plant.specimen]\nkind = 'bilinear'\nyield_mm = 12\n",
        "[plant.specimen]\nkind = 'bouc_wen'\nyield_mm = 15\n",
    ] {
        let report = watched(specimen);
        assert!(
            report.events.iter().all(|e| e.set.is_empty()),
            "{specimen}: {report:?}"
        );
        assert!(report.not_watched.is_empty(), "{report:?}");
    }
}

#[test]
fn a_specimen_that_hardens_softens_or_degrades_passes_in_silence() {
    for effect in [
        // Of its stiffness at 40 mm: 4 to 44 % more.
        "name = 'hardening'\nreference_mm = 200",
        "name = 'hardening'\nreference_mm = 160",
        "name = 'hardening'\nreference_mm = 100",
        "name = 'hardening'\nreference_mm = 60",
        // 9 to 29 % less.
        "name = 'softening'\nreference_mm = 400",
        "name = 'softening'\nreference_mm = 200",
        "name = 'softening'\nreference_mm = 100",
        // Less than 30 % of it, and slowly: by the way.
        "name = 'degradation'\ntravel_mm = 1000\nlost_share = 0.3",
        "name = 'degradation'\ntravel_mm = 300\nlost_share = 0.5",
        // 7 to 29 % of it, by the largest motion.
        "name = 'degradation'\nreference_mm = 500",
        "name = 'degradation'\nreference_mm = 320",
        "name = 'degradation'\nreference_mm = 200",
        "name = 'degradation'\nreference_mm = 100",
    ] {
        let report = watched(&format!("[[plant.effects]]\n{effect}\n"));
        assert!(
            report.events.iter().all(|e| e.set.is_empty()),
            "{effect}: {report:?}"
        );
    }
}

#[test]
fn a_delay_that_jumps_is_named_within_two_cycles_on_its_side_and_by_its_size() {
    let report = watched("[[plant.effects]]\nname = 'delay_error'\ndelay_ms = 12\nfrom_s = 8\n");
    let first = named(&report);
    assert!(first.t_s > 8.0 && first.t_s < 10.0, "{report:?}");
    assert!(holds(first, "delay_error", "actuator"), "{report:?}");
    let last = report.events.last().unwrap();
    let late = last.set.iter().find(|c| c.name == "delay_error").unwrap();
    assert!(
        (late.value - 12.0).abs() < 3.0 && late.unit == "ms",
        "{report:?}"
    );
}

#[test]
fn each_cause_of_the_list_is_named_on_its_side() {
    let mut wrong = Vec::new();
    for (effect, [name, side]) in EACH {
        let report = watched(&format!("[[plant.effects]]\n{effect}\nfrom_s = 8\n"));
        if !report.events.iter().any(|e| holds(e, name, side)) {
            wrong.push((name, side, report.sentence()));
        }
    }
    assert_eq!(wrong, []);
}

#[test]
fn an_offset_that_moves_on_is_a_drift_with_its_rate_and_one_that_jumps_is_none() {
    for (place, side, mm_or_n, jumps, moves) in [
        ("channel = 'actuator'", "actuator", "mm", 2.0, 0.3),
        ("sensor = 'displacement'", "displacement", "mm", 2.0, 0.3),
        ("sensor = 'force'", "force", "n", 500.0, 80.0),
    ] {
        let effect = |name: &str, key: &str, value: f64| {
            watched(&format!(
                "[[plant.effects]]\nname = '{name}'\n{place}\n{key} = {value}\nfrom_s = 8\n"
            ))
        };
        let jumped = effect("offset", &format!("offset_{mm_or_n}"), jumps);
        assert!(jumped.events.iter().any(|e| holds(e, "offset", side)));
        let drifts = jumped.events.iter().any(|e| holds(e, "drift", side));
        assert!(!drifts, "{}", jumped.sentence());
        let moved = effect("drift", &format!("rate_{mm_or_n}_per_s"), moves);
        let last = moved.events.last().expect("it is named");
        let drift = last
            .set
            .iter()
            .find(|c| (c.name, c.side) == ("drift", side));
        let rate = drift
            .unwrap_or_else(|| panic!("{}", moved.sentence()))
            .value;
        assert!((rate / moves - 1.0).abs() < 0.2, "{side}: {rate}");
    }
}
