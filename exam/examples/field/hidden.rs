//! How large the faults of rams are compared with the noise: what the best-fitting sound ram leaves unexplained.

use exam::field::{SOUND_RAM, faults, hidden_by_a_sound_ram, set_ram};
use rayon::prelude::*;

/// Bounds of the table's columns, as multiples of the noise.
const CLASSES: [f64; 5] = [0.0, 0.42, 1.0, 3.0, f64::INFINITY];

/// Prints, for each fault, how many rams fall into each column.
pub fn all(seeds: Vec<u64>, list: bool) {
    let of = |seed: u64| (set_ram(seed), hidden_by_a_sound_ram(seed));
    let all: Vec<_> = seeds.into_par_iter().map(of).collect();
    if list {
        for (ram, hidden) in &all {
            println!("{hidden:8.3} {}", ram.id);
        }
    }
    println!("| over the noise | rams | to 0.42 | to 1 | to 3 | more |\n|---|---|---|---|---|---|");
    for fault in faults().filter(|f| *f != SOUND_RAM) {
        let own = all.iter().filter(|a| a.0.truth.cause == fault);
        let own: Vec<f64> = own.map(|a| a.1).collect();
        let counts = CLASSES.windows(2).map(|ends| {
            let in_it = own.iter().filter(|h| (ends[0]..ends[1]).contains(*h));
            in_it.count().to_string()
        });
        let counts: Vec<String> = counts.collect();
        println!("| {fault} | {} | {} |", own.len(), counts.join(" | "));
    }
}
