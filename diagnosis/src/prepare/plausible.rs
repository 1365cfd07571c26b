//! Checks that records can be what their headers say, before anything is fitted.

use crate::criteria::records::{
    FEWEST_IN_ALL, GIVES, GOES_FAR, GOES_ON, HEAVY, OVER, SLIP, STOP, STOPS,
};
use crate::model::Model;
use crate::record::recording::{Recording, correlation, range};
use crate::record::refusal::Refusal;
use crate::record::spectrum::motion_band_hz;
use std::ops::Range;

/// Checks records against each other and against the model.
///
/// # Errors
/// Overlapping training and test data, a rest that moves, channels that look swapped, an implausible unit.
pub fn check(
    model: &Model,
    train: &[Recording],
    test: &[Recording],
    rest: &[Recording],
) -> Result<(), Refusal> {
    for (what, set) in [("training", train), ("test", test)] {
        if set.is_empty() {
            return Err(Refusal::new(format!(
                "there is no {what} record: accepted is one and more"
            )));
        }
    }
    for r in train.iter().chain(test).chain(rest) {
        r.check()?;
    }
    for (what, set) in [("training", train), ("test", test)] {
        let samples: usize = set.iter().map(|r| r.time_s.len()).sum();
        if samples < FEWEST_IN_ALL {
            return Err(Refusal::new(format!(
                "{}: {samples} samples of {what} data are too few: accepted are {FEWEST_IN_ALL} and more",
                set[0].name
            )));
        }
    }
    for (a, b) in train.iter().flat_map(|a| test.iter().map(move |b| (a, b))) {
        if overlap(a, b) {
            return Err(Refusal::new(format!(
                "{}: training and test data overlap in time: accepted are spans that do not, or two records",
                a.name
            )));
        }
        if a.displacement_mm == b.displacement_mm && a.force_n == b.force_n {
            return Err(Refusal::new(format!(
                "{} and {} hold the same samples: accepted is test data that was not trained with",
                a.name, b.name
            )));
        }
    }
    let largest = |of: fn(&Recording) -> Option<&Vec<f64>>| {
        train
            .iter()
            .filter_map(of)
            .map(|x| range(x))
            .fold(0.0, f64::max)
    };
    for r in rest {
        for (what, of) in [
            (
                "command",
                (|r| r.command_mm.as_ref()) as fn(&Recording) -> Option<&Vec<f64>>,
            ),
            ("displacement", |r| r.displacement_mm.as_ref()),
        ] {
            if let Some(x) = of(r) {
                let (here, whole) = (range(x), largest(of));
                if here > 0.1 * whole {
                    return Err(Refusal::new(format!(
                        "{}: {what} moves by {here:.4} mm from {} s to {} s: accepted as rest is less than a tenth of \
                         the {whole:.4} mm of the training data",
                        r.name,
                        r.time_s[0],
                        r.time_s[r.time_s.len() - 1]
                    )));
                }
            }
        }
    }
    train
        .iter()
        .chain(test)
        .try_for_each(|r| proportions(model, r))
}

fn overlap(a: &Recording, b: &Recording) -> bool {
    let end = |r: &Recording| r.time_s[r.time_s.len() - 1];
    a.name == b.name && a.time_s[0] <= end(b) && b.time_s[0] <= end(a)
}

/// Compares slopes between the channels with those of the model.
fn proportions(model: &Model, r: &Recording) -> Result<(), Refusal> {
    motion_per_command(model, r)?;
    force_per_motion(model, r)?;
    drives(model, r)
}

/// Largest correlation of two channels, the second up to a tenth of a second late: a delay does not change what it is.
fn late(r: &Recording, a: &[f64], b: &[f64]) -> f64 {
    let most = (0.1 / r.interval_s()) as usize;
    (0..=most.min(a.len() / 4))
        .step_by((most / 25).max(1))
        .map(|lag| correlation(&a[..a.len() - lag], &b[lag..]))
        .fold(0.0_f64, |m, c| if c.abs() > m.abs() { c } else { m })
}

fn slip(r: &Recording, what: &str, ratio: f64) -> Refusal {
    Refusal::new(format!(
        "{}: {what} is {ratio:.3e} times what the model says: accepted is data in the units of its header",
        r.name
    ))
}

fn motion_per_command(model: &Model, r: &Recording) -> Result<(), Refusal> {
    let (Some(actuator), Some(u), Some(x)) = (&model.actuator, &r.command_mm, &r.displacement_mm)
    else {
        return Ok(());
    };
    let (moves, answers) = (range(u), range(x));
    if let Some(f) = &r.force_n
        && moves > 0.0
        && late(r, u, f).abs() > 0.95
        && late(r, u, x).abs() < 0.5
    {
        return Err(Refusal::new(format!(
            "{}: force follows the command and displacement does not: the columns look swapped; accepted is each \
             under its own header",
            r.name
        )));
    }
    if let Some(lead_s) = lead_s(model, u, x, r.interval_s()) {
        return Err(Refusal::new(format!(
            "{}: displacement goes before the command by {:.1} ms: the columns look swapped; accepted is each \
             under its own header",
            r.name,
            1e3 * lead_s
        )));
    }
    if let Some(slow_s) = slower_than_declared(model, r.interval_s()) {
        return Err(Refusal::new(format!(
            "{}: samples lie {:.4} s apart, and the declared delay and lag are over after {:.4} s: is the time in \
             milliseconds? Accepted is its column as time_ms then, or a record with more samples",
            r.name,
            r.interval_s(),
            slow_s
        )));
    }
    let gain = actuator.gain.map_or(1.0, |g| g.value);
    let ratio = answers / (moves * gain.abs()).max(f64::MIN_POSITIVE);
    if moves > 0.0
        && answers > 0.0
        && late(r, u, x).abs() > 0.8
        && !(1.0 / SLIP..SLIP).contains(&ratio)
    {
        return Err(slip(r, "displacement per command", ratio));
    }
    Ok(())
}

fn force_per_motion(model: &Model, r: &Recording) -> Result<(), Refusal> {
    let (Some(s), Some(x), Some(f)) = (&model.specimen, &r.displacement_mm, &r.force_n) else {
        return Ok(());
    };
    let stiffness = s.stiffness_n_per_mm.map(|k| k.value.abs());
    let Some(k) = stiffness.filter(|k| *k > 0.0) else {
        return Ok(());
    };
    let ratio = range(f) / (k * range(x)).max(f64::MIN_POSITIVE);
    // A force of the spring's size with the opposite sign; that of a mass alone would be of any size.
    if s.stiffness_n_per_mm.is_some_and(|k| k.value > 0.0)
        && (0.5..2.0).contains(&ratio)
        && correlation(x, f) < -0.9
        && !may_be_inertia(s, x, r.interval_s())
    {
        return Err(Refusal::new(format!(
            "{}: force falls where displacement rises: accepted is a force with the sign of the displacement, as \
             the declared stiffness has it; turn the sign of one of the two columns round",
            r.name
        )));
    }
    if range(x) > 0.0
        && range(f) > 0.0
        && correlation(x, f).abs() > 0.8
        && !(1.0 / SLIP..SLIP).contains(&ratio)
    {
        return Err(slip(r, "force per displacement", ratio));
    }
    Ok(())
}

/// Refuses a declared damper whose force drives the motion instead of resisting it.
fn drives(model: &Model, r: &Recording) -> Result<(), Refusal> {
    let (Some(s), Some(x), Some(f)) = (&model.specimen, &r.displacement_mm, &r.force_n) else {
        return Ok(());
    };
    let resists = s.damping_n_s_per_mm.is_some_and(|c| c.value > 0.0);
    if !resists || taken(x, f, r.interval_s()) > GIVES {
        return Ok(());
    }
    Err(Refusal::new(format!(
        "{}: force pushes the way that the displacement goes, so the specimen would give work: accepted is a force that \
         resists the motion, as the declared damping does; turn the sign of one of the two columns round",
        r.name
    )))
}

/// The work that a force absorbs, relative to that of the same force if it always resisted.
fn taken(x: &[f64], f: &[f64], interval_s: f64) -> f64 {
    let mean = f.iter().sum::<f64>() / f.len() as f64;
    // Steps of the motion, longer than its noise.
    let step = motion_band_hz(x, interval_s).map_or(1.0, |hz| (0.05 / (hz * interval_s)).floor());
    let step = (step as usize).clamp(1, x.len() / 4);
    let work = |i: usize| (f[i + step / 2] - mean) * (x[i + step] - x[i]);
    let all = || (0..x.len() - step).step_by(step).map(work);
    all().sum::<f64>() / all().map(f64::abs).sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Largest correlation of `a` with `b` some samples later, and the number of samples.
fn later(a: &[f64], b: &[f64], most: usize) -> (usize, f64) {
    let most = most.min(a.len() / 4);
    (0..=most)
        .step_by((most / 60).max(1))
        .map(|lag| (lag, correlation(&a[..a.len() - lag], &b[lag..])))
        .fold(
            (0, -1.0),
            |best, next| if next.1 > best.1 { next } else { best },
        )
}

/// Lead of the displacement over its command, if it clearly leads although the model says that it lags.
fn lead_s(model: &Model, u: &[f64], x: &[f64], interval_s: f64) -> Option<f64> {
    let actuator = model.actuator.as_ref()?;
    let value = |d: Option<crate::model::declared::Declared>| d.map_or(0.0, |d| d.value);
    let late_s = 1e-3 * (value(actuator.delay_ms) + value(actuator.lag_ms));
    let most = |s: f64| (s / interval_s).ceil() as usize;
    if late_s < 1e-3 {
        return None;
    }
    let [longest_lead, longest_lag] = [2.0 * late_s, 0.1_f64.max(2.0 * late_s)].map(most);
    let (lead, with_lead) = later(x, u, longest_lead);
    let (_, with_lag) = later(u, x, longest_lag);
    let unlike = |c: f64| 1.0 - c * c;
    let clearly = with_lead > 0.8 && unlike(with_lead) < 0.5 * unlike(with_lag);
    // Two clocks that run apart make a lead that grows; columns that are swapped have the same from first to last.
    let (early, late) = (..u.len() / 2, u.len() / 2..);
    let grows = || {
        let [a, b] = [
            led(&x[early], &u[early], [longest_lead, longest_lag])?,
            led(&x[late.clone()], &u[late], [longest_lead, longest_lag])?,
        ];
        Some((a - b).abs() > 2.0_f64.max(DRIFTS * late_s / interval_s))
    };
    (lead > 0 && clearly && !grows().unwrap_or(false)).then_some(lead as f64 * interval_s)
}

/// Change of a lead from one half of a record to the other, as a share of the declared delay and lag, from which on it drifts.
const DRIFTS: f64 = 0.25;

/// Samples by which `x` goes before `u`, negative if it goes after; `None` if they are not alike.
fn led(x: &[f64], u: &[f64], [longest_lead, longest_lag]: [usize; 2]) -> Option<f64> {
    let (lead, with_lead) = later(x, u, longest_lead);
    let (lag, with_lag) = later(u, x, longest_lag);
    let best = if with_lead > with_lag {
        (lead as f64, with_lead)
    } else {
        (-(lag as f64), with_lag)
    };
    (best.1 > 0.8).then_some(best.0)
}

/// The declared delay and lag plus three tolerances, s, if they are over long before the next sample.
fn slower_than_declared(model: &Model, interval_s: f64) -> Option<f64> {
    let a = model.actuator.as_ref()?;
    let declared = [a.delay_ms, a.lag_ms].into_iter().flatten();
    let longest_s: f64 = declared.map(|d| 1e-3 * (d.value + 3.0 * d.tolerance)).sum();
    (longest_s > 0.0 && longest_s < OVER * interval_s).then_some(longest_s)
}

/// The longest stop of `x` if it repeatedly sits at a rail: at its largest or smallest value while its drive goes on in
/// the same direction and comes back. A part that stopped because its drive reversed (a play, a hold) is not at a rail.
pub fn clipped(x: &[f64], drive: Option<&[f64]>) -> Option<Range<usize>> {
    let (low, high) = x
        .iter()
        .fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
    let mut stops: Vec<(usize, usize)> = Vec::new();
    let mut first = None;
    for i in 0..=x.len() {
        let at_end = i < x.len() && (x[i] == low || x[i] == high);
        match (at_end, first) {
            (true, None) => first = Some(i),
            (false, Some(from)) => {
                if i - from >= STOP && !is_a_step(x, from..i) {
                    stops.push((from, i));
                }
                first = None;
            }
            _ => {}
        }
    }
    let longest = stops.iter().max_by_key(|s| s.1 - s.0).map(|s| s.0..s.1);
    if stops.len() < STOPS {
        return None;
    }
    let Some(drive) = drive else {
        return longest;
    };
    // Upward, like x at the upper rail; reversed if the drive has the opposite sign.
    let sign = if correlation(x, drive) < 0.0 {
        -1.0
    } else {
        1.0
    };
    let least = GOES_FAR * crate::record::recording::range(drive);
    let on = |&(from, end): &(usize, usize)| {
        let out = if x[from] == high { sign } else { -sign };
        let inside: Vec<f64> = drive[from..end].iter().map(|u| out * u).collect();
        let farthest = inside.iter().fold(f64::MIN, |m, u| m.max(*u));
        let turn = farthest - inside[inside.len() - 1];
        farthest - inside[0] > (GOES_ON * turn).max(least)
    };
    let most = 2 * stops.iter().filter(|s| on(s)).count() >= stops.len();
    longest.filter(|_| most)
}

/// True if a stop is a converter's step at a smooth turn, where it is up to 2.4 times as long as those beside it together.
fn is_a_step(x: &[f64], stop: Range<usize>) -> bool {
    fn run<'a>(mut samples: impl Iterator<Item = &'a f64>) -> usize {
        let first = samples.next();
        samples.take_while(|v| Some(*v) == first).count()
    }
    let beside = run(x[..stop.start].iter().rev()) + run(x[stop.end..].iter());
    stop.len() <= STEPS_AT_A_TURN * beside
}

/// Largest length of a step at a turn, in steps beside it.
const STEPS_AT_A_TURN: usize = 4;

/// True if the declared mass moves so fast that its force, opposite to the displacement, may dominate.
fn may_be_inertia(model: &crate::model::SpecimenModel, x: &[f64], interval_s: f64) -> bool {
    let (Some(k), Some(m)) = (model.stiffness_n_per_mm, model.mass_kg) else {
        return false;
    };
    motion_band_hz(x, interval_s).is_some_and(|hz| {
        1e-3 * m.value * (std::f64::consts::TAU * hz).powi(2) > HEAVY * k.value.abs()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rail_is_one_and_a_part_that_waits_for_its_drive_to_come_back_is_none() {
        let drive: Vec<f64> = (0..6000).map(|i| (0.01 * f64::from(i)).sin()).collect();
        let rail: Vec<f64> = drive.iter().map(|u| u.clamp(-0.8, 0.8)).collect();
        assert!(clipped(&rail, Some(&drive)).is_some() && clipped(&rail, None).is_some());
        let late = crate::numbers::signals::delayed(&drive, 0.02, 1e-3);
        let rail: Vec<f64> = late.iter().map(|u| u.clamp(-0.8, 0.8)).collect();
        let stop = clipped(&rail, Some(&drive)).unwrap();
        assert!(rail[stop].iter().all(|x| x.abs() == 0.8));
        // A converter's step at the turn of a motion that comes before its drive is no rail.
        let early = |i: i32| ((0.01 * f64::from(i + 20)).sin() * 60.0).round() / 60.0;
        let coarse: Vec<f64> = (0..6000).map(early).collect();
        assert!(clipped(&coarse, Some(&drive)).is_none());
        let rail: Vec<f64> = coarse.iter().map(|u| u.clamp(-0.8, 0.8)).collect();
        assert!(clipped(&rail, Some(&drive)).is_some());
        // A play stops where its drive turns; its values at the turns agree to the last written digit.
        let mut at = 0.0_f64;
        let play = |u: &f64| {
            at = at.clamp(u - 0.1, u + 0.1);
            (at * 1e3).round() / 1e3
        };
        let waits: Vec<f64> = drive.iter().map(play).collect();
        assert!(clipped(&waits, None).is_some() && clipped(&waits, Some(&drive)).is_none());
    }

    #[test]
    fn swapped_columns_have_one_lead_and_two_clocks_one_that_grows() {
        let moves = |t: f64| (5.0 * t).sin() + 0.6 * (13.7 * t).cos();
        let of = |at: &dyn Fn(f64) -> f64| -> Vec<f64> {
            (0..60_000)
                .map(|i| moves(at(1e-3 * f64::from(i))))
                .collect()
        };
        let declared = |value| {
            Some(crate::model::Declared {
                value,
                tolerance: 0.5,
            })
        };
        let model = Model {
            actuator: Some(crate::model::ActuatorModel {
                delay_ms: declared(4.0),
                ..Default::default()
            }),
            ..Default::default()
        };
        let command = of(&|t| t);
        let swapped = of(&|t| t + 4e-3);
        let lead = lead_s(&model, &command, &swapped, 1e-3).unwrap();
        assert!((lead - 4e-3).abs() < 1e-3, "{lead}");
        let stretched = of(&|t| (1.0 + 2.5e-4) * t - 4e-3);
        assert_eq!(lead_s(&model, &command, &stretched, 1e-3), None);
    }

    #[test]
    fn a_damper_resists_the_motion_and_a_mass_neither_takes_nor_gives() {
        let h = 1e-3;
        let t = |i: usize| h * i as f64;
        let x: Vec<f64> = (0..8000)
            .map(|i| 20.0 * (3.0 * t(i)).sin() + 0.01 * ((i * 7919) % 101) as f64 / 50.0)
            .collect();
        let force = |of: &dyn Fn(f64) -> f64| (0..8000).map(|i| of(t(i))).collect::<Vec<f64>>();
        let damper = force(&|t| 30.0 * (3.0 * t).cos());
        let turned: Vec<f64> = damper.iter().map(|f| -f).collect();
        let mass = force(&|t| -50.0 * (3.0 * t).sin());
        assert!(taken(&x, &damper, h) > 0.9, "{}", taken(&x, &damper, h));
        assert!(taken(&x, &turned, h) < GIVES);
        assert!(taken(&x, &mass, h).abs() < 0.1);
        let declared = Some(crate::model::declared::Declared {
            value: 0.5,
            tolerance: 0.1,
        });
        let model = Model {
            specimen: Some(crate::model::SpecimenModel {
                damping_n_s_per_mm: declared,
                ..crate::model::SpecimenModel::default()
            }),
            ..Model::default()
        };
        let record = |force: &[f64]| Recording {
            time_s: (0..8000).map(t).collect(),
            displacement_mm: Some(x.clone()),
            force_n: Some(force.to_vec()),
            ..Recording::default()
        };
        assert!(proportions(&model, &record(&damper)).is_ok());
        let refused = proportions(&model, &record(&turned))
            .unwrap_err()
            .to_string();
        assert!(
            refused.contains("turn the sign of one of the two columns"),
            "{refused}"
        );
    }

    #[test]
    fn an_actuator_that_is_over_before_the_next_sample_is_asked_about() {
        let declared = |value| {
            Some(crate::model::declared::Declared {
                value,
                tolerance: 1.0,
            })
        };
        let model = Model {
            actuator: Some(crate::model::ActuatorModel {
                delay_ms: declared(5.0),
                lag_ms: declared(20.0),
                ..crate::model::ActuatorModel::default()
            }),
            specimen: None,
            ..Model::default()
        };
        assert_eq!(slower_than_declared(&model, 1.0), Some(0.031));
        assert_eq!(slower_than_declared(&model, 1e-3), None);
    }
}
