//! The same closed loop, once with core in this process and once with the image in QEMU.

use super::machine::{Clock, Machine, Test};
use crate::{Scenario, Shaking};
use firmware::session::SessionAccount;
use link::Command;
use link::reply::RefusedParameter;
use outerloop_core::watch::{Actions, Declared, DeclaredActuator, Instructions, Watch, judge};
use outerloop_core::{
    Config, Design, Event, Fault, GroundMotion, InPlace, Mode, OuterLoop, Record, Sample, flag,
};
use plant::Rig;
use std::io::{Error, Result};
use std::path::Path;

/// A ground motion that needs no file: two sines, one modulated, up to 5 m/s^2, faded out in the last second.
pub fn shaking(seconds: f64) -> Shaking {
    let interval_s = 0.01;
    let point = |i: usize| {
        let t = i as f64 * interval_s;
        let fade = (seconds - t).clamp(0.0, 1.0);
        let a = 3.0 * (11.0 * t).sin() * (0.7 * t).sin() + 2.0 * (4.0 * t).sin();
        (fade * a) as f32
    };
    Shaking {
        acc_m_per_s2: (0..=(seconds / interval_s) as usize).map(point).collect(),
        interval_s,
    }
}

/// The rig of a scenario, as a loop with `N` degrees of freedom sees it.
///
/// # Panics
/// The rig is refused.
pub fn rig<const N: usize>(scenario: &Scenario, seed: u64) -> impl FnMut(&[f32; N]) -> Sample<N> {
    let config = &scenario.config;
    let physical = config.physical_storeys();
    let storeys = &config.structure.stiffness_n_per_m[..physical];
    let mut rig = Rig::new(&scenario.rig(), storeys, config.timing.rate_hz, seed)
        .unwrap_or_else(|refusal| panic!("{refusal}"));
    move |command_m| {
        let command: Vec<f64> = command_m[..physical]
            .iter()
            .map(|&u| f64::from(u))
            .collect();
        let reading = rig.step(&command);
        let mut sample = Sample::new([0.0; N], [0.0; N]);
        for j in 0..physical {
            sample.displacement_m[j] = reading.displacement_m[j] as f32;
            sample.force_n[j] = reading.force_n[j] as f32;
        }
        sample
    }
}

/// The records of all control periods from power-up on, as words.
pub type Records = Vec<Vec<u32>>;

/// What the operator does, and which fault the board reports, in a control period, by its number and the mode.
pub type Script<'a> = &'a dyn Fn(u32, Mode) -> (Option<Event>, Option<Fault>);

/// Idles for 200 periods, arms, and starts as soon as possible.
pub fn plain(tick: u32, mode: Mode) -> (Option<Event>, Option<Fault>) {
    let event = match mode {
        Mode::Idle if tick >= 200 => Some(Event::Arm),
        Mode::Armed => Some(Event::Start),
        _ => None,
    };
    (event, None)
}

/// The watch's instructions for each actuator of a test: a delay of `late_s`, specimens as in the structure, and a first
/// frequency of `omega_rad_per_s`.
pub fn told(
    config: &Config,
    (omega_rad_per_s, peak_m, late_s): (f64, f64, f64),
    actions: Actions,
) -> Vec<Instructions> {
    let storeys = config.physical_storeys();
    let stiffness = &config.structure.stiffness_n_per_m;
    let declared = |j: usize| Declared {
        rate_hz: config.timing.rate_hz,
        omega_rad_per_s,
        peak_m,
        stiffness_n_per_m: stiffness[j] + stiffness.get(j + 1).copied().unwrap_or(0.0),
        stiffness_tolerance: 0.02,
        actuator: DeclaredActuator {
            gain: 1.0,
            delay_s: late_s,
            lag_s: 0.0,
            offset_m: 0.0,
            tolerances: [0.005, 5e-4, 0.0],
        },
        alone: config.degrees_of_freedom() == 1,
        has_actuator: true,
        has_specimen: config.degrees_of_freedom() == 1,
        elastic: true,
        damping_n_s_per_m: 0.0,
        mass_kg: 0.0,
        specimen_tolerances: [0.0; 3],
        force_gain: 1.0,
        force_offset_n: 0.0,
        noise: [0.0; 2],
    };
    let each = (0..storeys).map(|j| Instructions {
        declared: declared(j),
        actions,
    });
    each.collect()
}

/// Runs `ticks` control periods with core in this process; also returns the hash of the records and the watches.
///
/// # Errors
/// The test is refused.
pub fn here<const N: usize>(
    test: &Test<'_>,
    ticks: u32,
    script: Script<'_>,
    rig: impl FnMut(&[f32; N]) -> Sample<N>,
) -> Result<(Records, u64, Vec<Watch>)> {
    let design = Design::new(test.config)
        .map_err(|refusal| Error::other(RefusedParameter::from(refusal).to_string()))?;
    let mut outer = OuterLoop::<N>::new(design);
    let mut in_place = InPlace::beside(&outer);
    let Shaking {
        acc_m_per_s2,
        interval_s,
    } = test.shaking;
    let ground = GroundMotion::new(acc_m_per_s2, *interval_s, test.config.model_step_s())
        .ok_or_else(|| Error::other("the ground motion is refused"))?;
    let mut hash = Record::<N>::HASH_START;
    let mut watches = Vec::new();
    let records = drive(test, ticks, script, rig, |command, sample| {
        match command {
            // Refused if it is not valid yet, here as in the image.
            Some(Command::Event(event)) => drop(outer.handle(*event)),
            Some(Command::Watch(_, told)) => {
                let watch =
                    Watch::new(told).map_err(|refusal| Error::other(refusal.to_string()))?;
                watches.push(watch);
                outer.watch(told.corrects());
            }
            _ => {}
        }
        let step = outer.step(&sample, &ground);
        hash = step.record.hash(hash);
        let mut words = Vec::with_capacity(Record::<N>::WORDS);
        step.record.for_each_word(|w| words.push(w));
        let command_m = step.command_m;
        in_place.judge(&mut outer, |blocks, orders| {
            judge(watches.iter_mut(), blocks, orders)
        });
        Ok((command_m, words))
    })?;
    Ok((records, hash, watches))
}

/// Runs `ticks` control periods with the image in QEMU.
///
/// # Errors
/// The test is refused, or the image ends.
pub fn emulated<const N: usize>(
    image: &Path,
    clock: Clock,
    test: &Test<'_>,
    ticks: u32,
    script: Script<'_>,
    rig: impl FnMut(&[f32; N]) -> Sample<N>,
) -> Result<(Records, SessionAccount)> {
    let mut machine = Machine::start(image, clock)?;
    machine.begin(test)?;
    let records = drive(test, ticks, script, rig, |command, sample| {
        let (answer, words) = machine.period(command, sample)?;
        Ok((answer.command_m, words))
    })?;
    Ok((records, machine.end()?))
}

/// The closed loop: the rig moves and is sampled, and the loop answers with the next command. The first periods send the watch
/// its instructions; the operator's event in one of these is ignored.
///
/// # Errors
/// Those of `period`.
pub fn drive<const N: usize>(
    test: &Test<'_>,
    ticks: u32,
    script: Script<'_>,
    mut rig: impl FnMut(&[f32; N]) -> Sample<N>,
    mut period: impl FnMut(Option<&Command>, Sample<N>) -> Result<([f32; N], Vec<u32>)>,
) -> Result<Records> {
    let mut records = Records::with_capacity(ticks as usize);
    let mut command_m = [0.0; N];
    let mut mode = Mode::Idle;
    for tick in 0..ticks {
        let mut sample = rig(&command_m);
        let (event, fault) = script(tick, mode);
        sample.fault = fault;
        let words;
        let command = test.told(tick).or(event.map(Command::Event));
        (command_m, words) = period(command.as_ref(), sample)?;
        mode = mode_of(&words)?;
        records.push(words);
    }
    Ok(records)
}

/// The mode in a record: bits 0 to 3 of its third word.
fn mode_of(words: &[u32]) -> Result<Mode> {
    let flags = words.get(2).copied().unwrap_or(u32::MAX);
    let mode = Mode::from_code(flags & 0xf);
    mode.ok_or_else(|| Error::other("a record without a mode"))
}

/// True if an integration step was solved in this control period.
pub fn solved(words: &[u32]) -> bool {
    words.get(2).is_some_and(|flags| flags & flag::SOLVED != 0)
}

/// The first control period and word in which two traces differ.
pub fn first_difference(a: &Records, b: &Records) -> Option<(usize, usize)> {
    let tick = a.iter().zip(b).position(|(x, y)| x != y)?;
    let word = a[tick].iter().zip(&b[tick]).position(|(x, y)| x != y);
    Some((tick, word.unwrap_or(usize::MAX)))
}
