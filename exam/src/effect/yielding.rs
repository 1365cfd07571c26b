//! Specimens that yield.

use super::physics::{Channel, Physics, Scale, plus};
use crate::draws::Draws;

pub(super) fn draw(
    name: &str,
    channel: Channel,
    unseen: bool,
    scale: &Scale,
    rng: &mut Draws,
) -> Option<Physics> {
    if channel == Channel::Actuator {
        return None;
    }
    let left = rng.between(0.05, 0.6);
    let largest = scale.x;
    // The strength is the largest drift over the yield drift.
    let range = (1.0, 8.0);
    let yields = move |s: f64| largest / s;
    Some(match name {
        "bilinear_hysteresis" if unseen => Physics::new(
            "Iwan: ten sliders in parallel that yield within 20 % of each other",
            range,
            move |s, scene, y| {
                let m = scene.motion();
                let change = iwan(&m.x, yields(s), 1.2);
                plus(y, change.map(|c| (1.0 - left) * m.k * c))
            },
        ),
        "bilinear_hysteresis" => {
            Physics::new("a slider beside a spring", range, move |s, scene, y| {
                let m = scene.motion();
                let change = iwan(&m.x, yields(s), 1.0);
                plus(y, change.map(|c| (1.0 - left) * m.k * c))
            })
            .with(move |s| vec![("yield_mm", yields(s)), ("hardening_ratio", left)])
        }
        "bouc_wen_hysteresis" if unseen => Physics::new(
            "Iwan: ten sliders in parallel whose yields spread over a factor of nine",
            range,
            move |s, scene, y| {
                let m = scene.motion();
                let change = iwan(&m.x, yields(s), 3.0);
                plus(y, change.map(|c| (1.0 - left) * m.k * c))
            },
        ),
        "bouc_wen_hysteresis" => {
            let sharpness = rng.between(1.0, 3.0);
            Physics::new("Bouc and Wen, beta = gamma", range, move |s, scene, y| {
                let m = scene.motion();
                let d = yields(s);
                let (mut z, mut before) = (0.0_f64, m.x[0]);
                plus(
                    y,
                    m.x.iter().map(|x| {
                        let way = x - before;
                        before = *x;
                        // dz/dx = 1 - |z/d|^n (1 + sign(v z)) / 2, by the midpoint rule.
                        let slope = |z: f64| {
                            1.0 - (z / d).abs().powf(sharpness)
                                * if z * way > 0.0 { 1.0 } else { 0.0 }
                        };
                        let middle = z + 0.5 * way * slope(z);
                        z += way * slope(middle);
                        (1.0 - left) * m.k * (z - x)
                    }),
                )
            })
            .with(move |s| {
                vec![
                    ("yield_mm", yields(s)),
                    ("hardening_ratio", left),
                    ("sharpness", sharpness),
                ]
            })
        }
        _ => return None,
    })
}

/// Mean elastic deformation of a parallel group of sliders, minus the drift. The yields go from `yield_mm / spread` to
/// `yield_mm * spread` in geometric steps; with a spread of 1 there is one slider.
fn iwan(x: &[f64], yield_mm: f64, spread: f64) -> impl Iterator<Item = f64> {
    let n = if spread > 1.0 { 10 } else { 1 };
    let mut sliders: Vec<(f64, f64)> = (0..n)
        .map(|i| {
            let part = if n > 1 {
                2.0 * f64::from(i) / f64::from(n - 1) - 1.0
            } else {
                0.0
            };
            (yield_mm * spread.powf(part), 0.0)
        })
        .collect();
    let mut before = x[0];
    x.iter().map(move |x| {
        let way = x - before;
        before = *x;
        let mut sum = 0.0;
        for (limit, z) in &mut sliders {
            *z = (*z + way).clamp(-*limit, *limit);
            sum += *z;
        }
        sum / f64::from(n) - x
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unloading_follows_masing() {
        // The unloading branch is the first loading, twice as large: f(x) after the turn at X is f(X) - 2 f0((X - x) / 2).
        let up: Vec<f64> = (0..=1000).map(|i| 0.01 * f64::from(i)).collect();
        let mut path = up.clone();
        path.extend(up.iter().rev().skip(1));
        let f: Vec<f64> = iwan(&path, 3.0, 3.0)
            .zip(&path)
            .map(|(c, x)| c + x)
            .collect();
        for back in (100..1000).step_by(100) {
            let half = f[back / 2];
            assert!((f[1000 + back] - (f[1000] - 2.0 * half)).abs() < 1e-9);
        }
    }
}
