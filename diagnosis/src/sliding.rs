//! Friction is read where it slides for certain.
//!
//! After a reversal friction is still building up, by a law that nobody knows (a spring that slips, bristles, a film of
//! grease): a fit over all samples takes what the assumed law is off there for less friction and more damping, by some
//! percent and with narrow intervals. Near a reversal the noise of the displacement decides the sign of the speed, too.
//! So strengths are those of the samples that are far enough from any reversal, and how far that is, is seen from the
//! strength of the friction itself: it no longer changes when more of the travel is left out.

use crate::base::Base;
use crate::fit::{Solution, settle};
use crate::interval;
use crate::noise::Noise;
use plant::{Channel, Effect};

/// The shortest travel after a reversal that is left out, in yield displacements: a slider that is turned round slides after two.
const SHORTEST: f64 = 4.0;
/// Each is so many times the one before.
const LONGER: f64 = 1.5;
/// Share of the travel after a reversal that is left out before one, too: noise moves where it is seen.
const BEFORE: f64 = 0.25;
/// Share of the samples that stay at least.
pub const STAYS: f64 = 0.5;

/// What was read of a strength with some of the samples.
#[derive(Debug)]
pub struct Reading<T> {
    /// What was fitted.
    pub fit: T,
    /// The travel after a reversal that was left out, mm.
    pub travel_mm: f64,
    /// The strength.
    pub strength: f64,
    /// Its standard error.
    pub error: f64,
}

/// The first reading, of those that leave out more and more of the travel, that agrees with all later ones within the scatter of
/// what lies between; `read` gives a fit, its strength and its error, and `None` where too little is left.
pub fn agreeing<T>(
    yield_mm: f64,
    read: impl Fn(f64) -> Option<(T, f64, f64)>,
) -> Option<Reading<T>> {
    let travels = std::iter::successors(Some(SHORTEST * yield_mm), |travel| Some(LONGER * travel));
    let reading = |travel_mm| {
        let (fit, strength, error) = read(travel_mm)?;
        Some(Reading {
            fit,
            travel_mm,
            strength,
            error,
        })
    };
    let mut all: Vec<Reading<T>> = travels.map_while(reading).take(MOST).collect();
    let agrees = |i: &usize| {
        let later = &all[i + 1..];
        later.iter().all(|l| {
            // What comes from a part of the samples scatters about what comes from all by the root of the difference.
            let more = (l.error.powi(2) - all[*i].error.powi(2)).max(0.0).sqrt();
            (all[*i].strength - l.strength).abs() <= more.max(LEAST * l.error)
        })
    };
    let first = (0..all.len()).find(agrees)?;
    Some(all.swap_remove(first))
}

/// Share of a standard error that is no difference.
const LEAST: f64 = 0.3;
/// Readings at most: from a thousandth of the motion to all of it.
const MOST: usize = 20;

/// 1 where a motion is within a travel after a reversal, or a part of it before one.
pub fn near(x: &[f64], travel_mm: f64) -> Vec<f64> {
    let mut near = vec![0.0; x.len()];
    for (forth, travel_mm) in [(true, travel_mm), (false, BEFORE * travel_mm)] {
        let (mut since, mut speed) = (0.0, 0.0_f64);
        let mut visit = |i: usize, last: usize| {
            let step = x[i] - x[last];
            if step * speed <= 0.0 {
                since = 0.0;
                near[last] = 1.0;
            }
            speed = step;
            since += step.abs();
            if since <= travel_mm {
                near[i] = 1.0;
            }
        };
        if forth {
            (1..x.len()).for_each(|i| visit(i, i - 1));
        } else {
            (0..x.len() - 1).rev().for_each(|i| visit(i, i + 1));
        }
    }
    near
}

/// A solution with Coulomb friction, its amplitudes and declared parameters from where that slides; `None` without, and where too
/// little of the motion is far from a reversal.
pub fn read(solution: &Solution, base: &Base, noise: &Noise) -> Option<Solution> {
    let own = |s: &Solution| {
        let mut effects = s.effects.iter();
        effects.position(|e| e.candidate.effect == Effect::CoulombFriction)
    };
    let at = own(solution).filter(|_| base.channel == Channel::Specimen)?;
    let shaped: Vec<_> = solution
        .effects
        .iter()
        .map(|e| (e.candidate, e.shapes.clone()))
        .collect();
    let reading = agreeing(solution.effects[at].shapes[0], |travel_mm| {
        let mut problem = solution.problem.clone();
        let (mut stay, mut all) = (0.0, 0.0);
        for segment in &mut problem.segments {
            let near = near(&segment.signals.x, travel_mm);
            let judged = &near[segment.from..];
            all += judged.len() as f64;
            stay += judged.iter().filter(|n| **n == 0.0).count() as f64;
            let more = (0..near.len()).filter(|i| near[*i] > 0.0);
            segment.corners.extend(more);
        }
        if stay < STAYS * all {
            return None;
        }
        let part = settle(&problem, base, noise, &shaped)?;
        let figures = interval::parameters(&part, base, noise);
        let (_, _, strength, [low, high]) = *figures.get(at)?.first()?;
        Some((part, strength, (high - low) / (2.0 * interval::NINETY)))
    })?;
    let whole = Some(Box::new(solution.clone()));
    Some(Solution {
        whole,
        ..reading.fit
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_after_a_reversal_is_near_and_a_part_of_it_before() {
        // Up by 10 steps of 1, down again.
        let x: Vec<f64> = (0..21)
            .map(|i| 10.0 - f64::from(i - 10_i32).abs())
            .collect();
        let near = near(&x, 4.0);
        let at: Vec<usize> = (5..20).filter(|i| near[*i] > 0.0).collect();
        assert_eq!(at, [9, 10, 11, 12, 13, 14, 19]);
    }

    #[test]
    fn a_strength_that_settles_is_read_where_it_has_settled() {
        let read =
            |travel: f64| (travel < 60.0).then(|| ((), 300.0 - 20.0 * (-travel / 6.0).exp(), 0.5));
        let reading = agreeing(1.0, read).unwrap();
        assert!((reading.strength - 300.0).abs() <= 0.5, "{reading:?}");
        assert!(reading.travel_mm < 40.0, "{reading:?}");
        assert!(agreeing(20.0, read).is_none());
    }
}
