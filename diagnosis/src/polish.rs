//! The shapes of a solution's effects, moved together to their best.

use crate::base::Base;
use crate::fit::{Solution, settle};
use crate::library::Candidate;
use crate::noise::Noise;
use crate::sensitivity;

/// An effect with its shapes.
pub type Shaped = (Candidate, Vec<f64>);

/// How often a solution is made linear around itself at most.
const STEPS: usize = 6;
/// A fall of the cost that is not worth another step.
const POLISHED: f64 = 0.2;

/// Moves the shapes of all effects together to their best.
pub fn polish(solution: Solution, base: &Base, noise: &Noise) -> Solution {
    let mut best = solution;
    for _ in 0..STEPS {
        let Some(step) = sensitivity::step(&best, base, noise) else {
            break;
        };
        if step.iter().all(Vec::is_empty) {
            break;
        }
        let next = [1.0, 0.4, 0.1].into_iter().find_map(|share| {
            let moved = best.effects.iter().zip(&step).map(|(e, step)| {
                let shapes = e.shapes.iter().zip(step).map(|(v, d)| v + share * d);
                (e.candidate, shapes.collect())
            });
            let moved: Vec<Shaped> = moved.collect();
            settle(&best.problem, base, noise, &moved).filter(|next| next.cost < best.cost)
        });
        let Some(next) = next else { break };
        let fall = best.cost - next.cost;
        best = next;
        if fall < POLISHED {
            break;
        }
    }
    best
}
