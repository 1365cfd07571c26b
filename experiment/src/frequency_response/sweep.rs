//! Distortion of a sweep: the displacement as multiples of the command's own phase, block by block.

use super::distortion::{Distortion, DistortionLine, Excitation};
use fourier::Complex;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::ops::Range;

/// Cycles of a block.
const CYCLES: f64 = 8.0;
/// The command's own frequency within a block departs from a line over time by at most this share, in the median block:
/// noise of a band does so by half and more.
const STEADY: f64 = 0.1;
/// Fewest blocks that are a sweep.
const FEWEST: usize = 4;
/// A line that has less than this share of the power of the command's largest line is none of its own.
const LEAST_POWER: f64 = 1e-5;
/// Orders of even distortion, of odd distortion, and multiples at which nothing but noise is.
const EVEN: [f64; 2] = [2.0, 4.0];
const ODD: [f64; 2] = [3.0, 5.0];
const BETWEEN: [f64; 4] = [1.5, 2.5, 3.5, 4.5];

/// `None` of a command that is no sweep.
pub fn distortion(command: &[f64], displacement: &[f64], interval_s: f64) -> Option<Distortion> {
    // Roughly, for the borders of the blocks.
    let rough = phase(&analytic(command, [0.0, 1.5 * top(command)]));
    let blocks: Vec<(Range<usize>, Vec<Complex<f64>>)> = blocks(&rough)
        .into_iter()
        .map(|block| {
            let cycles = (rough[block.end] - rough[block.start]) / TAU;
            let own = of_this_block(command, &block, cycles / block.len() as f64);
            (block, own)
        })
        .collect();
    let mut departures: Vec<f64> = blocks
        .iter()
        .map(|(_, own)| departure(&phase(own)))
        .collect();
    departures.sort_by(f64::total_cmp);
    if blocks.len() < FEWEST || *departures.get(departures.len() / 2)? > STEADY {
        return None;
    }
    let mut lines: Vec<DistortionLine> = blocks
        .iter()
        .filter_map(|(block, own)| of_block(own, &displacement[block.clone()], interval_s))
        .collect();
    lines.sort_by(|a, b| a.hz.total_cmp(&b.hz));
    Some(Distortion {
        excitation: Excitation::Sweep,
        lines,
    })
}

/// The command's analytic signal: the command itself and, as its imaginary part, the same a quarter of a cycle later. Of the
/// lines of its transform those within `band`, in cycles a sample, are kept.
fn analytic(command: &[f64], band: [f64; 2]) -> Vec<Complex<f64>> {
    let n = command.len();
    let mean = command.iter().sum::<f64>() / n as f64;
    let mut bins: Vec<Complex<f64>> = command
        .iter()
        .map(|x| Complex::new(x - mean, 0.0))
        .collect();
    fourier::forward(n).process(&mut bins);
    for (k, bin) in bins.iter_mut().enumerate() {
        let at = k as f64 / n as f64;
        if k == 0 || at > 0.5 || !(band[0]..=band[1]).contains(&at) {
            *bin = Complex::default();
        }
    }
    fourier::inverse(n).process(&mut bins);
    bins.iter().map(|b| b * (2.0 / n as f64)).collect()
}

/// Up to where the command moves, in cycles a sample: above it there is a converter's noise, whose phase is nobody's.
fn top(command: &[f64]) -> f64 {
    let n = command.len();
    let mut bins: Vec<Complex<f64>> = command.iter().map(|x| Complex::new(*x, 0.0)).collect();
    fourier::forward(n).process(&mut bins);
    let power = |k: usize| bins[k].norm_sqr();
    let largest = (1..n / 2).map(power).fold(0.0, f64::max);
    let last = (1..n / 2).rev().find(|k| power(*k) > LEAST_POWER * largest);
    last.unwrap_or(0) as f64 / n as f64
}

/// The analytic signal of a block, from the block and half of it on either side, faded: over the whole record the tails of
/// large slow motion reach into small fast ones, and turn their phase.
fn of_this_block(command: &[f64], block: &Range<usize>, cycles_a_sample: f64) -> Vec<Complex<f64>> {
    let margin = block.len() / 2;
    let around = block.start.saturating_sub(margin)..(block.end + margin).min(command.len());
    let (before, behind) = (block.start - around.start, around.end - block.end);
    let piece = &command[around];
    let mean = piece.iter().sum::<f64>() / piece.len() as f64;
    let fade = |i: usize, of: usize| match i < of {
        true => 0.5 - 0.5 * (std::f64::consts::PI * (i as f64 + 0.5) / of as f64).cos(),
        false => 1.0,
    };
    let last = piece.len() - 1;
    let faded: Vec<f64> = piece
        .iter()
        .enumerate()
        .map(|(i, x)| (x - mean) * fade(i, before) * fade(last - i, behind))
        .collect();
    let band = [0.25 * cycles_a_sample, 4.0 * cycles_a_sample];
    analytic(&faded, band)[before..before + block.len()].to_vec()
}

/// The phase, rad, without steps.
fn phase(analytic: &[Complex<f64>]) -> Vec<f64> {
    let mut phase = 0.0;
    let mut before = analytic[0];
    let turned = |now: &Complex<f64>| {
        phase += (now * before.conj()).arg();
        before = *now;
        phase
    };
    analytic.iter().map(turned).collect()
}

/// Blocks of [`CYCLES`] cycles each.
fn blocks(phase: &[f64]) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut start = 0;
    for i in 0..phase.len() {
        if phase[i] - phase[start] >= CYCLES * TAU {
            found.push(start..i);
            start = i;
        }
    }
    // The first and the last hold the signal's ends, where the phase of its analytic signal is not its own.
    found.pop();
    found.drain(..1.min(found.len()));
    found
}

/// By how much the frequency departs from a straight line over time, of its mean: a parabola is fitted to the phase and what
/// it leaves is compared with a cycle.
fn departure(phase: &[f64]) -> f64 {
    let n = phase.len();
    let at = |i: usize| 2.0 * i as f64 / n as f64 - 1.0;
    let columns = DMatrix::from_fn(n, 3, |i, k| at(i).powi(k as i32));
    let values = DVector::from_column_slice(phase);
    let Some(fit) = (columns.transpose() * &columns).cholesky() else {
        return f64::INFINITY;
    };
    let rest = &values - &columns * fit.solve(&(columns.transpose() * &values));
    rest.norm() / (n as f64).sqrt() / TAU * 2.0
}

fn of_block(
    analytic: &[Complex<f64>],
    displacement: &[f64],
    interval_s: f64,
) -> Option<DistortionLine> {
    let phase = phase(analytic);
    let n = phase.len();
    let multiples: Vec<f64> = EVEN.into_iter().chain(ODD).chain(BETWEEN).collect();
    // Mean, slope, curvature; the linear answer, which is the command and its quarter with factors that move along the block;
    // then each multiple of the phase.
    let head = 3 + 6;
    let width = head + 2 * multiples.len();
    if n < 4 * width {
        return None;
    }
    let columns = DMatrix::from_fn(n, width, |i, k| {
        let t = 2.0 * i as f64 / n as f64 - 1.0;
        let part = |value: Complex<f64>, quarter: usize| match quarter {
            0 => value.re,
            _ => value.im,
        };
        match k {
            0..3 => t.powi(k as i32),
            3..9 => t.powi((k as i32 - 3) / 2) * part(analytic[i], (k - 3) % 2),
            k => {
                let turn = multiples[(k - head) / 2] * phase[i];
                part(Complex::from_polar(1.0, turn), (k - head) % 2)
            }
        }
    });
    let values = DVector::from_column_slice(displacement);
    let fit = (columns.transpose() * &columns)
        .cholesky()?
        .solve(&(columns.transpose() * values));
    let power = |place: usize| 0.5 * (fit[place].powi(2) + fit[place + 1].powi(2));
    let of = |orders: &[f64]| {
        let places = orders
            .iter()
            .filter_map(|o| multiples.iter().position(|m| m == o));
        places.map(|p| power(head + 2 * p)).sum::<f64>()
    };
    Some(DistortionLine {
        hz: (phase[n - 1] - phase[0]) / TAU / ((n - 1) as f64 * interval_s),
        linear_mm: (power(3) * analytic.iter().map(|a| a.norm_sqr()).sum::<f64>() / n as f64)
            .sqrt(),
        even_mm: Some(of(&EVEN).sqrt()),
        odd_mm: Some(of(&ODD).sqrt()),
        // Of four multiples for the two of each order.
        noise_mm: (0.5 * of(&BETWEEN)).sqrt(),
    })
}
