//! What the tests of whole rigs share.

use plant::{Rig, RigSpec};

pub const RATE_HZ: f64 = 2000.0;
pub const STIFFNESS: f64 = 158e3;

/// The `[plant]` table in `table`.
pub fn spec(table: &str) -> RigSpec {
    toml::from_str(table).unwrap_or_else(|e| panic!("{table}: {e}"))
}

/// One axis of Table 1's stiffness.
pub fn rig(spec: &RigSpec) -> Rig {
    Rig::new(spec, &[STIFFNESS], RATE_HZ, 1).unwrap_or_else(|e| panic!("{e}"))
}

/// Time, command, true displacement, true force, displacement, force of each step of one axis.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    pub t: f64,
    pub command: f64,
    pub true_displacement: f64,
    pub true_force: f64,
    pub displacement: f64,
    pub force: f64,
}

/// What one axis does under `command(t)` for `seconds`.
pub fn run(spec: &RigSpec, seconds: f64, command: impl Fn(f64) -> f64) -> Vec<Row> {
    let mut rig = rig(spec);
    (0..(seconds * RATE_HZ) as u32)
        .map(|i| {
            let t = f64::from(i) / RATE_HZ;
            let command = command(t);
            let reading = rig.step(&[command]);
            Row {
                t,
                command,
                true_displacement: reading.true_displacement_m[0],
                true_force: reading.true_force_n[0],
                displacement: reading.displacement_m[0],
                force: reading.force_n[0],
            }
        })
        .collect()
}

/// Gain and lag (s) of `output` behind a sine of `omega` over whole cycles at the end of `rows`.
pub fn gain_and_delay(
    rows: &[Row],
    omega: f64,
    amplitude: f64,
    output: impl Fn(&Row) -> f64,
) -> (f64, f64) {
    let cycles = (rows.len() as f64 / RATE_HZ * omega / std::f64::consts::TAU / 2.0 + 1e-9).floor();
    let n = (cycles * std::f64::consts::TAU / omega * RATE_HZ).round();
    let last = &rows[rows.len() - n as usize..];
    let (mut re, mut im) = (0.0, 0.0);
    for row in last {
        re += output(row) * (omega * row.t).sin();
        im -= output(row) * (omega * row.t).cos();
    }
    (re.hypot(im) * 2.0 / n / amplitude, im.atan2(re) / omega)
}

/// Mean and standard deviation.
pub fn moments(x: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = x.clone().count() as f64;
    let mean = x.clone().sum::<f64>() / n;
    (
        mean,
        (x.map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt(),
    )
}

/// Work done on the specimen, J, by the trapezoidal rule.
pub fn work(rows: &[Row]) -> f64 {
    rows.windows(2)
        .map(|w| {
            0.5 * (w[0].true_force + w[1].true_force)
                * (w[1].true_displacement - w[0].true_displacement)
        })
        .sum()
}
