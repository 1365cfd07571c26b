//! Third-party records, read where they are: `OUTERLOOP_DATA`, or `../shared/data` beside the repository.

use crate::Shaking;
use std::path::PathBuf;

/// The folder of the data, where there is one.
pub fn folder() -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data");
    let folder = std::env::var_os("OUTERLOOP_DATA").map_or_else(|| beside.into(), PathBuf::from);
    folder.is_dir().then_some(folder)
}

/// A ground motion by its file name without ending; `None`, and a line that says so, where the data are missing.
pub fn ground_motion(name: &str) -> Option<Shaking> {
    let Some(folder) = folder() else {
        println!("not run: {name} needs the folder of ground motions (set OUTERLOOP_DATA)");
        return None;
    };
    let path = folder
        .join("ground-motion")
        .join(name)
        .with_extension("csv");
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
