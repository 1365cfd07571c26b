//! What a ram's fault leaves that no sound ram can explain. Below the noise it cannot be found, however much is known about rams.

use super::ram::Ram;
use crate::fine::{FINE_HZ, rms};

/// Parameters of a sound ram that are refitted: delay and lag, s; valve and oil, Hz; load, N/m. Gain and offset follow them.
const NUMBERS: usize = 5;
const ALL: usize = NUMBERS + 2;
/// Gauss-Newton steps.
const STEPS: usize = 5;
/// Rate at which samples are compared, Hz.
const COMPARED_HZ: f64 = 250.0;

/// What the best-fitting sound ram leaves of another ram's displacement, mm rms. Its parameters stay within those that sound
/// rams may have.
pub(super) fn beyond_sound(ram: &Ram, sound: &Ram, command_mm: &[f64]) -> f64 {
    let every = (FINE_HZ / COMPARED_HZ) as usize;
    let sparse = |x: Vec<f64>| x.into_iter().step_by(every).collect::<Vec<f64>>();
    let target = sparse(ram.displacement(command_mm));
    let ranges = sound.sound_ranges();
    let mut at = sound.numbers();
    let mut least = f64::INFINITY;
    for _ in 0..STEPS {
        let answer = |numbers: [f64; NUMBERS]| sparse(sound.with(numbers).displacement(command_mm));
        let here = answer(at);
        let slope = |i: usize| {
            let mut there = at;
            let [low, high] = ranges[i];
            let step = 0.02 * (high - low);
            there[i] += step;
            let moved = answer(there);
            moved
                .iter()
                .zip(&here)
                .map(|(a, b)| (a - b) / step)
                .collect()
        };
        let mut columns: Vec<Vec<f64>> = (0..NUMBERS).map(slope).collect();
        columns.extend([here.clone(), vec![1.0; here.len()]]);
        let left: Vec<f64> = target.iter().zip(&here).map(|(a, b)| a - b).collect();
        let (step, rest) = regressed(&columns, &left);
        // A sound ram's parameters stay within their ranges, so what the step would leave counts only if it does not leave them.
        let goes = |i: usize| at[i] + step[i];
        let stays = (0..NUMBERS).all(|i| (ranges[i][0]..=ranges[i][1]).contains(&goes(i)));
        let level = regressed(&columns[NUMBERS..], &left).1;
        least = least.min(if stays { rest } else { level });
        at = std::array::from_fn(|i| goes(i).clamp(ranges[i][0], ranges[i][1]));
    }
    least
}

/// Coefficients of the columns and the rms that they leave, by Gram-Schmidt.
fn regressed(columns: &[Vec<f64>], y: &[f64]) -> ([f64; ALL], f64) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut basis: Vec<(Vec<f64>, [f64; ALL])> = Vec::new();
    let mut left = y.to_vec();
    let mut found = [0.0; ALL];
    for (i, column) in columns.iter().enumerate() {
        let mut own = column.clone();
        let mut of = [0.0; ALL];
        of[i] = 1.0;
        for (before, made) in &basis {
            let share = dot(&own, before);
            own.iter_mut()
                .zip(before)
                .for_each(|(o, b)| *o -= share * b);
            of.iter_mut().zip(made).for_each(|(o, m)| *o -= share * m);
        }
        let size = dot(&own, &own).sqrt();
        if size <= 1e-6 * dot(column, column).sqrt() {
            continue;
        }
        own.iter_mut().for_each(|o| *o /= size);
        of.iter_mut().for_each(|o| *o /= size);
        let share = dot(&left, &own);
        left.iter_mut().zip(&own).for_each(|(l, o)| *l -= share * o);
        found.iter_mut().zip(&of).for_each(|(f, o)| *f += share * o);
        basis.push((own, of));
    }
    (found, rms(&left))
}
