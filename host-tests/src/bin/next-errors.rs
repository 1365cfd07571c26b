//! The table of predicted and actual errors.

use comfy_table::{Table, presets};
use exam::Class;
use host_tests::foresight::{Pair, of_case, of_rig};
use host_tests::outside::cases;
use rayon::prelude::*;

/// Rigs of each class, from the tuning range.
const RIGS: u64 = 12;

fn main() {
    let open: Vec<Pair> = cases()
        .unwrap_or_default()
        .par_iter()
        .flat_map(of_case)
        .collect();
    print("open records", &open);
    let classes = [Class::Unseen, Class::Outside, Class::Two];
    let rigs: Vec<(Class, u64)> = classes
        .into_iter()
        .flat_map(|c| (0..RIGS).map(move |seed| (c, seed)))
        .collect();
    let simulated: Vec<Pair> = rigs.par_iter().flat_map(|&(c, s)| of_rig(c, s)).collect();
    print(
        "simulated rigs, other equations than the search has",
        &simulated,
    );
}

fn print(what: &str, pairs: &[Pair]) {
    let mut table = Table::new();
    table.load_preset(presets::ASCII_MARKDOWN).set_header([
        "trained on",
        "predicted, rms",
        "came",
        "holds",
    ]);
    for p in pairs {
        let [low, high] = p.foretold;
        table.add_row([
            p.name.clone(),
            format!("{low:.4} to {high:.4}"),
            format!("{:.4}", p.came),
            if p.holds() {
                "yes".into()
            } else {
                "no".to_owned()
            },
        ]);
    }
    let held = pairs.iter().filter(|p| p.holds()).count();
    let share = 100.0 * held as f64 / pairs.len().max(1) as f64;
    println!(
        "{what}\n{table}\n{held} of {} intervals hold ({share:.0} %)\n",
        pairs.len()
    );
}
