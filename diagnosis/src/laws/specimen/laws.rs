//! Forces with memory, over a whole motion. Each starts relaxed.

use crate::numbers::operators::{power, slider};
use crate::numbers::signals::add_scaled;

/// Yield displacements and forces of seven sliders, relative to their sums. After a reversal they build up as
/// `1 - 2 exp(-travel / yield_at)`, to 1.4 % of the force: straight lines between points of that curve that are close where it
/// bends, weighted by least squares.
const BRISTLES: [[f64; 2]; 7] = [
    [0.143, 0.0751],
    [0.310, 0.1173],
    [0.511, 0.1645],
    [0.762, 0.1904],
    [1.099, 0.1918],
    [1.609, 0.1794],
    [2.708, 0.0815],
];

/// Bristles that slip in turn. After a reversal they act like Dahl's (A solid friction model, 1968); unlike his they
/// hold at rest, where noise would take his to zero (Dupont et al., Single state elastoplastic friction models, 2002).
pub fn bristles(x: &[f64], yield_at: f64) -> Vec<f64> {
    let mut sum = vec![0.0; x.len()];
    for [of_mean, share] in BRISTLES {
        add_scaled(&mut sum, &slider(x, of_mean * yield_at), share);
    }
    sum
}

/// Five sliders of equal force whose yield displacements are evenly spaced between `begins` of `most`, where there is none, and
/// `most` (Iwan's parallel elements, J. Appl. Mech. 33, 1966).
pub fn distributed(x: &[f64], most: f64, begins: f64) -> Vec<f64> {
    let mut sum = vec![0.0; x.len()];
    for i in 1..=5 {
        let of_most = begins + (1.0 - begins) * f64::from(i) / 5.0;
        add_scaled(&mut sum, &slider(x, most * of_most), 0.2);
    }
    sum
}

/// The size of `x`, rounded within `width`: its slope passes from -1 to 1 as `tanh(x / width)`.
pub fn rounded(x: f64, width: f64) -> f64 {
    let way = x.abs();
    if width == 0.0 {
        return way;
    }
    way + width * ((-2.0 * way / width).exp().ln_1p() - std::f64::consts::LN_2)
}

/// Largest force of an element whose rates let it grow, in its own unit.
const MOST: f64 = 50.0;

/// Bouc-Wen: `z' = x' (1 - load |z|^n) / yield_at` on the way out, `x' (1 + unload |z|^n) / yield_at` on the way back.
pub fn bouc_wen(x: &[f64], yield_at: f64, n: f64, load: f64, unload: f64) -> Vec<f64> {
    let (mut z, mut last) = (0.0_f64, x[0]);
    let rate = |z: f64, dx: f64| {
        let sign = if dx * z >= 0.0 { -load } else { unload };
        dx / yield_at * (1.0 + sign * power(z.abs(), n))
    };
    let step = |&x: &f64| {
        let dx = x - last;
        // Midpoint rule: an explicit step is off by a sample's motion.
        let there = z + 0.5 * rate(z, dx);
        z = (z + rate(there, dx)).clamp(-MOST, MOST);
        last = x;
        z
    };
    x.iter().map(step).collect()
}

/// Relative step of Newton's method whose square is below the numbers' resolution.
const CLOSE: f64 = 1e-9;

/// Friction in series with a spring: `z' = (x' - creep |z|^n sign z) / yield_at`, an implicit step.
pub fn in_series(x: &[f64], interval_s: f64, yield_at: f64, creep: f64, n: f64) -> Vec<f64> {
    let (mut z, mut last) = (0.0_f64, x[0]);
    let share = interval_s * creep / yield_at;
    let step = |&x: &f64| {
        let aim = z + (x - last) / yield_at;
        last = x;
        // z + share |z|^n sign z = aim, by Newton from outside, where the function is convex.
        let size = aim.abs();
        let mut y = size;
        // Where it creeps by more than it holds, the creep alone is nearer.
        if share * power(size, n - 1.0) > 1.0 {
            y = power(size / share, 1.0 / n);
        }
        for _ in 0..4 {
            let p = power(y, n - 1.0);
            let closer = (y - (y + share * p * y - size) / (1.0 + share * n * p)).max(0.0);
            let reached = (y - closer).abs() <= CLOSE * y;
            y = closer;
            if reached {
                break;
            }
        }
        z = y * aim.signum();
        z
    };
    x.iter().map(step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::operators::relaxed;

    #[test]
    fn a_rounded_size_is_a_parabola_inside_its_width_and_the_size_less_a_constant_outside() {
        let (width, step) = (0.5, 1e-4);
        let slope = |x: f64| (rounded(x + step, width) - rounded(x - step, width)) / (2.0 * step);
        assert!((slope(0.3) - (0.3f64 / width).tanh()).abs() < 1e-6);
        assert!((slope(-5.0) + 1.0).abs() < 1e-6 && rounded(0.0, width).abs() < 1e-15);
        assert_eq!(rounded(-2.0, 0.0), 2.0);
    }

    fn sine(n: usize) -> Vec<f64> {
        (0..n).map(|i| (i as f64 * 0.01).sin()).collect()
    }

    /// Work over closed cycles, from the second on.
    fn work(x: &[f64], f: &[f64]) -> f64 {
        let period = 628;
        (period..x.len() - 1)
            .map(|i| 0.5 * (f[i] + f[i + 1]) * (x[i + 1] - x[i]))
            .sum()
    }

    #[test]
    fn every_element_dissipates() {
        let x = sine(4 * 628);
        for f in [
            slider(&x, 0.1),
            bristles(&x, 0.1),
            distributed(&x, 0.5, 0.0),
            distributed(&x, 0.5, 0.7),
            bouc_wen(&x, 0.2, 2.0, 1.0, 1.0),
            bouc_wen(&x, 1.0, 1.0, -0.3, 1.9),
            in_series(&x, 0.01, 0.05, 0.5, 5.0),
            relaxed(&x, 0.3, 0.01),
        ] {
            assert!(work(&x, &f) > 0.05, "{}", work(&x, &f));
        }
    }

    #[test]
    fn a_slider_loses_four_times_its_force_times_the_way_that_it_slides() {
        let x = sine(3 * 628 + 1);
        let yield_at = 0.1;
        let cycle = 4.0 * (1.0 - yield_at);
        assert!((work(&x, &slider(&x, yield_at)) / (2.0 * cycle) - 1.0).abs() < 0.01);
        // Bristles with the same give lose the same, apart from incomplete bending at the turn.
        assert!((work(&x, &bristles(&x, yield_at)) / (2.0 * cycle) - 1.0).abs() < 0.01);
    }

    #[test]
    fn bristles_turned_round_build_up_exponentially_and_hold_at_rest() {
        let yield_at = 0.1_f64;
        let forth = (0..1000).map(|i| 1e-3 * f64::from(i));
        let back = (0..1000).map(|i| 1.0 - 1e-3 * f64::from(i));
        let f = bristles(&forth.chain(back).collect::<Vec<_>>(), yield_at);
        for way in [0.05, 0.1, 0.2, 0.3, 0.6] {
            let dahl = 2.0 * (-way / yield_at).exp() - 1.0;
            let own = f[1000 + (1e3 * way) as usize];
            assert!((own - dahl).abs() < 0.015, "{way}: {own} for {dahl}");
        }
        // At rest, with noise of a tenth of the give, they hold: Dahl's would drop to zero within a thousand samples.
        let rest = (0..11_000).map(|i| 0.5 + 0.01 * f64::from((i * 7919) % 11 - 5) / 5.0);
        let to_rest = (0..500).map(|i| 1e-3 * f64::from(i));
        let f = bristles(&to_rest.chain(rest).collect::<Vec<_>>(), yield_at);
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let (first, last) = (mean(&f[600..1700]), mean(&f[10_400..]));
        assert!(first > 0.8 && (last - first).abs() < 1e-6, "{first} {last}");
    }

    #[test]
    fn friction_in_series_slides_at_the_speed_of_its_creep() {
        // At a steady speed v the force is (v / creep)^(1/n).
        let x: Vec<f64> = (0..20_000).map(|i| 1e-3 * f64::from(i)).collect();
        let f = in_series(&x, 1e-3, 0.01, 8.0, 3.0);
        let last = f[f.len() - 1];
        assert!((last - 0.5).abs() < 1e-3, "{last}");
    }
}
