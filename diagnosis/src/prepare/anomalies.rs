//! Oddities of records that can still be judged: units, a dead transducer, a copied column.

use crate::criteria::records::{BACK, DEAD_S, FAR, FEWEST_OUTLIERS, FOLLOWS, LEAVES, MOVES, NEAR};
use crate::model::Model;
use crate::numbers::signals::{deviation, mean};
use crate::record::identify::USUAL_GAINS;
use crate::record::recording::{Recording, correlation, range};

/// Factors between units that are easily confused, what they are of, and their names.
const UNITS: &[(f64, Quantity, &str)] = &[
    (25.4, Quantity::Length, "an inch has 25.4 mm"),
    (10.0, Quantity::Length, "a centimetre has 10 mm"),
    (1000.0, Quantity::Length, "a metre has 1000 mm"),
    (1000.0, Quantity::Force, "a kN has 1000 N"),
    (9.80665, Quantity::Force, "a kilogram-force has 9.807 N"),
    (4.44822, Quantity::Force, "a pound-force has 4.448 N"),
];

/// What a channel measures.
#[derive(Clone, Copy, PartialEq)]
enum Quantity {
    Length,
    Force,
}

/// Questions about the records, one sentence each.
pub fn remarks(model: &Model, records: &[Recording]) -> Vec<String> {
    records.iter().flat_map(|r| of(model, r)).collect()
}

fn of(model: &Model, r: &Recording) -> Vec<String> {
    let mut all = Vec::new();
    for (what, unit, x) in [
        ("displacement", "mm", &r.displacement_mm),
        ("force", "N", &r.force_n),
    ] {
        all.extend(x.as_ref().and_then(|x| spikes(r, what, unit, x)));
    }
    if let (Some(a), Some(u), Some(x)) = (&model.actuator, &r.command_mm, &r.displacement_mm) {
        if u == x {
            all.push(format!(
                "{}: displacement is the command, bit for bit: it is a copy and no reading.",
                r.name
            ));
        }
        let gain = a.gain.map_or(1.0, |g| g.value);
        all.extend(unit(
            r,
            "displacement per command",
            (u, x),
            gain,
            Quantity::Length,
        ));
        all.extend(dead(r, "displacement", "mm", (u, x)));
    }
    if let (Some(s), Some(x), Some(f)) = (&model.specimen, &r.displacement_mm, &r.force_n) {
        let stiffness = s.stiffness_n_per_mm.map_or(0.0, |k| k.value);
        let of = Quantity::Force;
        all.extend(unit(r, "force per displacement", (x, f), stiffness, of));
        all.extend(dead(r, "force", "N", (x, f)));
    }
    all
}

/// A ratio of an output of this quantity to a length that is a conversion factor between two units.
fn unit(
    r: &Recording,
    what: &str,
    (input, output): (&[f64], &[f64]),
    declared: f64,
    of: Quantity,
) -> Option<String> {
    let ratio = range(output) / (range(input) * declared.abs());
    if !ratio.is_finite() || correlation(input, output).abs() < FOLLOWS {
        return None;
    }
    // A wrong unit also holds for small motions: a specimen that cracked or yielded started as declared.
    let early = early_slope(input, output) / declared.abs();
    let near =
        |factor: f64| (ratio / factor - 1.0).abs() < NEAR && (early / factor - 1.0).abs() < EARLY;
    let off = |factor: f64| (ratio.ln().abs() - factor.ln()).abs();
    let own = UNITS
        .iter()
        .filter(|u| u.1 == Quantity::Length || u.1 == of);
    let known: Vec<_> = own.filter(|u| near(u.0) || near(1.0 / u.0)).collect();
    let nearest = known.iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
    let why = match nearest {
        Some(nearest) => {
            let alike = known.iter().filter(|u| u.0 == nearest.0).map(|u| u.2);
            alike.collect::<Vec<&str>>().join(" and ")
        }
        None if of == Quantity::Length && !USUAL_GAINS.contains(&ratio) => {
            "no actuator goes so far off".into()
        }
        None => return None,
    };
    Some(format!(
        "{}: {what} is {ratio:.4} times what the model says, and {why}. Are the columns in the units of their headers?",
        r.name
    ))
}

/// Fraction of its range that counts as the beginning of a motion.
const BEGINNING: f64 = 0.1;
/// Tolerance of the slope there relative to a conversion factor: it includes noise and friction.
const EARLY: f64 = 0.3;

/// Slope of output over input until the input has covered the first tenth of its range.
fn early_slope(input: &[f64], output: &[f64]) -> f64 {
    let far = BEGINNING * range(input);
    let end = input.iter().position(|x| (x - input[0]).abs() > far);
    let end = end.unwrap_or(input.len()).max(3);
    let about = |x: &[f64]| {
        let mean = mean(x);
        x.iter().map(|x| x - mean).collect::<Vec<f64>>()
    };
    let [x, y] = [input, output].map(|s| about(&s[..end.min(s.len())]));
    let square: f64 = x.iter().map(|x| x * x).sum();
    let both: f64 = x.iter().zip(&y).map(|(x, y)| x * y).sum();
    both.abs() / square.max(f64::MIN_POSITIVE)
}

/// A force below this fraction of its rms counts as near zero.
const NEAR_ZERO: f64 = 0.2;

/// Single samples that jump away and back: a loose contact or a lost packet; if the force passes zero there, an impact.
fn spikes(r: &Recording, what: &str, unit: &str, x: &[f64]) -> Option<String> {
    let off = |i: usize| (x[i] - 0.5 * (x[i - 1] + x[i + 1])).abs();
    let mut usual: Vec<f64> = (1..x.len() - 1).map(off).collect();
    let at = usual.len() * 9 / 10;
    let usual = *usual.select_nth_unstable_by(at, f64::total_cmp).1;
    let least = (LEAVES * usual).max(FAR * range(x));
    // Both neighbours lie on the same side: a sample next to a spike does not count.
    let alone = |i: &usize| {
        let [before, after] = [x[*i] - x[i - 1], x[*i] - x[i + 1]];
        off(*i) > least && before * after > 0.0 && (x[i + 1] - x[i - 1]).abs() < BACK * off(*i)
    };
    let found: Vec<usize> = (1..x.len() - 1).filter(alone).collect();
    if found.len() < FEWEST_OUTLIERS {
        return None;
    }
    let first = found[0];
    let whole = deviation(x);
    let mut sides: Vec<f64> = found
        .iter()
        .map(|i| 0.5 * (x[i - 1] + x[i + 1]).abs())
        .collect();
    let middle = sides.len() / 2;
    let beside = *sides.select_nth_unstable_by(middle, f64::total_cmp).1;
    let passes_zero = |i: &usize| x[i - 1].abs().min(x[i + 1].abs()) < NEAR_ZERO * whole;
    let often = found.iter().filter(|i| passes_zero(i)).count();
    if what == "force" && beside < NEAR_ZERO * whole && 4 * often > 3 * found.len() {
        return Some(format!(
            "{}: the force jumps for one sample {} times, each time where it passes zero, the first at {:.3} s: that is where lost \
             motion is crossed and a loose clevis, pin or joint hits. It is no dropout, and those samples are the evidence of it.",
            r.name,
            found.len(),
            r.time_s[first]
        ));
    }
    let same = found.iter().all(|i| x[*i] == x[first]);
    let reads = if same {
        format!("read {} {unit}", x[first])
    } else {
        "jump away from both of their neighbours".into()
    };
    Some(format!(
        "{}: {} single samples of the {what} {reads}, the first at {:.3} s: dropouts, of a loose contact or of lost packets. They \
         are judged as if the rig had moved so. Keep the file; a copy without their rows marks them as not measured. Mend the cause \
         before the next record.",
        r.name,
        found.len(),
        r.time_s[first]
    ))
}

/// A channel that stays constant to the bit while its input moves.
fn dead(
    r: &Recording,
    what: &str,
    unit: &str,
    (input, output): (&[f64], &[f64]),
) -> Option<String> {
    let least = (DEAD_S / r.interval_s()).ceil() as usize;
    let mut from = 0;
    let mut longest = 0..0;
    for i in 1..=output.len() {
        if i == output.len() || output[i] != output[from] {
            if i - from > longest.len() {
                longest = from..i;
            }
            from = i;
        }
    }
    let moved = range(&input[longest.clone()]);
    if longest.len() < least || moved < MOVES * range(input) {
        return None;
    }
    Some(format!(
        "{}: {what} stands at {} {unit} from {:.3} s to {:.3} s while its input moves by {moved:.4} mm: is the transducer dead there, \
         or at its rail? If so, keep the file and judge spans without that part (FILE@T0..T1).",
        r.name,
        output[longest.start],
        r.time_s[longest.start],
        r.time_s[longest.end - 1]
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::declared::Declared;
    use crate::model::{ActuatorModel, SpecimenModel};

    /// Remarks on an actuator that follows and a spring of 100 N/mm, after `change` was applied.
    fn said(change: impl Fn(&mut Recording)) -> Vec<String> {
        let time_s: Vec<f64> = (0..10_000).map(|i| f64::from(i) * 1e-3).collect();
        let moves = |late: f64| -> Vec<f64> {
            let x = |t: &f64| 10.0 * (2.0 * (t - late)).sin() + 4.0 * (5.3 * (t - late)).cos();
            time_s.iter().map(x).collect()
        };
        let mut r = Recording {
            name: "a".into(),
            command_mm: Some(moves(0.0)),
            displacement_mm: Some(moves(0.02)),
            force_n: Some(moves(0.02).iter().map(|x| 101.0 * x).collect()),
            time_s,
            ..Recording::default()
        };
        change(&mut r);
        let declared = |value| {
            Some(Declared {
                value,
                tolerance: 0.01 * value,
            })
        };
        let model = Model {
            actuator: Some(ActuatorModel {
                gain: declared(1.0),
                ..ActuatorModel::default()
            }),
            specimen: Some(SpecimenModel {
                stiffness_n_per_mm: declared(100.0),
                ..SpecimenModel::default()
            }),
            ..Model::default()
        };
        remarks(&model, &[r])
    }

    fn scale(x: &mut Option<Vec<f64>>, by: f64) {
        x.iter_mut().flatten().for_each(|x| *x *= by);
    }

    #[test]
    fn a_factor_between_two_units_is_asked_about() {
        assert_eq!(said(|_| {}), Vec::<String>::new());
        let cm = said(|r| scale(&mut r.displacement_mm, 0.1));
        assert!(
            cm.iter().all(|s| s.contains("centimetre")) && cm.len() == 2,
            "{cm:?}"
        );
        let four = said(|r| scale(&mut r.displacement_mm, 4.0));
        assert!(
            four.len() == 1 && four[0].contains("no actuator goes so far off"),
            "{four:?}"
        );
        let inch = said(|r| scale(&mut r.displacement_mm, 1.0 / 25.4));
        assert!(
            inch.iter().all(|s| s.contains("25.4 mm")) && inch.len() == 2,
            "{inch:?}"
        );
        let pound = said(|r| scale(&mut r.force_n, 1.0 / 4.448));
        assert!(pound.len() == 1 && pound[0].contains("pound"), "{pound:?}");
        // A column that cracked: less than the declared stiffness, but not from the beginning.
        let cracked = said(|r| {
            let mut largest = 0.0_f64;
            let x = r.displacement_mm.clone().unwrap();
            let force = x.iter().map(|x| {
                largest = largest.max((x - 4.0).abs());
                101.0 * (x - 4.0) / (1.0 + largest / 4.0)
            });
            r.force_n = Some(force.collect());
        });
        assert_eq!(cracked, Vec::<String>::new());
        // Another specimen, not another unit.
        assert_eq!(said(|r| scale(&mut r.force_n, 1.7)), Vec::<String>::new());
    }

    #[test]
    fn a_channel_that_freezes_is_named_with_its_time() {
        let frozen = said(|r| {
            let x = r.displacement_mm.as_mut().unwrap();
            let held = x[4000];
            x[4000..6000].fill(held);
        });
        assert!(frozen[0].contains("from 4.000 s to 5.999 s"), "{frozen:?}");
        let zeros = said(|r| r.force_n.as_mut().unwrap()[2000..4000].fill(0.0));
        assert!(
            zeros[0].contains("force stands at 0 N from 2.000 s"),
            "{zeros:?}"
        );
    }

    #[test]
    fn samples_that_drop_out_are_counted() {
        let dropped = said(|r| {
            let x = r.displacement_mm.as_mut().unwrap();
            (0..40).for_each(|i| x[517 + 211 * i] = 0.0);
        });
        let of =
            |s: &String| s.contains("single samples of the displacement read 0 mm, the first at");
        assert!(dropped.iter().any(of), "{dropped:?}");
        // A sample near 0 anyway does not count, nor does a sharp turn.
        let number: Vec<&str> = dropped[0].split(' ').collect();
        assert!(
            (35..=40).contains(&number[1].parse::<i32>().unwrap()),
            "{dropped:?}"
        );
        let turns = said(|r| {
            let saw = |i: usize| (i % 500) as f64 / 50.0;
            r.command_mm = Some((0..10_000).map(saw).collect());
            r.displacement_mm = Some((0..10_000).map(|i| 1.001 * saw(i)).collect());
            r.force_n = Some((0..10_000).map(|i| 101.0 * saw(i)).collect());
        });
        assert_eq!(turns, Vec::<String>::new());
    }

    #[test]
    fn a_loose_clevis_that_hits_is_no_dropout() {
        let hits = said(|r| {
            let f = r.force_n.as_mut().unwrap();
            let crossings: Vec<usize> = (1..f.len() - 1)
                .filter(|i| f[i - 1] < 0.0 && f[*i] >= 0.0)
                .collect();
            crossings.iter().for_each(|i| f[*i] += 700.0);
        });
        assert!(
            hits.len() == 1 && hits[0].contains("loose clevis"),
            "{hits:?}"
        );
        // Samples that drop out anywhere are dropouts.
        let dropped = said(|r| {
            let f = r.force_n.as_mut().unwrap();
            (0..40).for_each(|i| f[517 + 211 * i] += 700.0);
        });
        assert!(
            dropped
                .iter()
                .any(|s| s.contains("dropouts") && s.contains("Keep the file")),
            "{dropped:?}"
        );
    }

    #[test]
    fn a_displacement_that_is_a_copy_of_the_command_is_said() {
        let copy = said(|r| r.displacement_mm = r.command_mm.clone());
        assert!(copy[0].contains("bit for bit"), "{copy:?}");
    }
}
