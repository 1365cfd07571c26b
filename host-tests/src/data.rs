//! Ground motions by other people, where they are at hand: see the crate `test-data`.

use crate::Shaking;

/// A ground motion by its file name without ending; `None`, and a line that says so, where the data are missing.
pub fn ground_motion(name: &str) -> Option<Shaking> {
    let path = test_data::file(&format!("ground-motion/{name}.csv"))?;
    let text = std::fs::read_to_string(&path).ok()?;
    let rows: Vec<(f64, f64)> = text
        .lines()
        .skip(1)
        .filter_map(|line| {
            let (t, a) = line.split_once(',')?;
            Some((t.trim().parse().ok()?, a.trim().parse().ok()?))
        })
        .collect();
    Some(Shaking {
        acc_m_per_s2: rows.iter().map(|r| (r.1 * 9.80665) as f32).collect(),
        interval_s: rows.get(1)?.0 - rows.first()?.0,
    })
}

/// The two records of the paper: Kobe and Tabas.
pub fn kobe_and_tabas() -> Option<[(&'static str, Shaking); 2]> {
    Some([
        ("Kobe", ground_motion("KJMA_NS_1995_NGAW2")?),
        ("Tabas", ground_motion("TABAS_TR_1978_PEERold")?),
    ])
}
