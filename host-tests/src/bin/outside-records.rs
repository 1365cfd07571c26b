//! The table of all open records from outside: verdict, truth, error before and after, textbook fit, floor.
//!
//! ```text
//! cargo run --release -p host-tests --bin outside-records -- [CASE]...
//! ```

use comfy_table::{Table, presets};
use diagnosis::ChannelAnswer;
use host_tests::outside::{Case, lot};

fn main() {
    let mut only: Vec<String> = std::env::args().skip(1).collect();
    only.retain(|a| !a.starts_with("--"));
    let lots = ["outside", "outside2"].into_iter().filter_map(lot);
    let cases: Vec<Case> = lots.flatten().collect();
    let mut table = Table::new();
    table.load_preset(presets::ASCII_MARKDOWN).set_header([
        "record",
        "verdict",
        "names (q) or set (probability)",
        "before",
        "after",
        "textbook",
        "floor",
        "points",
        "s",
    ]);
    let (mut points, mut of) = (0.0, 0.0);
    for case in cases
        .iter()
        .filter(|c| only.is_empty() || only.contains(&c.id))
    {
        eprintln!("{}", case.id);
        let (row, got) = row(case);
        table.add_row(row);
        points += got;
        of += 1.0;
    }
    println!("{table}\n{points} of {of} points");
}

/// What others reach on the benchmark's multisine, simulated from its force.
const LITERATURE: &str = "a linear model 1.6e-4 m, the best black boxes 7.5e-6 m";

/// Error of the simulation with what was found, m, where that is a mass on a Bouc-Wen element.
fn simulated(case: &Case, a: &ChannelAnswer) -> Option<f64> {
    let (record, from_s) = case.held_out().ok()?;
    host_tests::simulated::displacement_error_m(a, &record, from_s)
}

fn row(case: &Case) -> (Vec<String>, f64) {
    let percent = |x: f64| format!("{:.1} %", 100.0 * x);
    match case.diagnose() {
        Err(why) => {
            let mut row = vec![case.id.clone(), "refused".into(), why];
            row.resize(9, String::new());
            (row, 0.0)
        }
        Ok((a, seconds)) => {
            for note in &a.notes {
                eprintln!("    {note}");
            }
            for e in &a.effects {
                for p in &e.parameters {
                    eprintln!(
                        "    {} {} = {:.5} [{:.5}, {:.5}] {}",
                        e.name, p.name, p.value, p.ci90[0], p.ci90[1], p.unit
                    );
                }
            }
            eprintln!("    {:?}", a.refitted);
            if let Some(error) = simulated(case, &a) {
                println!(
                    "{}: driven by its force, the named law's displacement is off by {error:.2e} m rms; {LITERATURE}",
                    case.id
                );
            }
            let got = case.points(&a);
            let spread = a.error_before.test_rms / a.error_before.test_nrmse.max(f64::MIN_POSITIVE);
            let row = vec![
                case.id.clone(),
                format!("{:?}", a.verdict).to_lowercase(),
                named(&a),
                percent(a.error_before.test_nrmse),
                percent(a.error_after.test_nrmse),
                percent(case.reference.after_nrmse),
                if a.noise_floor_rms > 0.0 {
                    percent(a.noise_floor_rms / spread)
                } else {
                    "?".into()
                },
                format!("{got}"),
                format!("{seconds:.2}"),
            ];
            (row, got)
        }
    }
}

fn named(a: &ChannelAnswer) -> String {
    let mut names: Vec<String> = Vec::new();
    if a.members.is_empty() {
        for e in &a.effects {
            let q = e.q.map_or(String::new(), |q| format!(" ({q})"));
            names.push(format!("{}{q}", e.name));
        }
        names.extend(a.alternatives.iter().map(|e| format!("or {e}")));
    }
    for m in &a.members {
        names.push(format!("{} ({:.2})", m.name, m.probability));
    }
    if let Some(n) = &a.nearest {
        names.push(format!("nearest {} ({:.2})", n.name, n.explained));
    }
    names.join(", ")
}
