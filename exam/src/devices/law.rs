//! Forces of these devices for a displacement: N for mm, on the 8 kHz grid.

use crate::fine::{DT, derivative};

/// The Bouc-Wen variable, -1 to 1, with exponent `n` and `beta = gamma`.
pub(super) fn bouc_wen(x: &[f64], yield_mm: f64, n: i32) -> Vec<f64> {
    let mut z = 0.0_f64;
    along(x, |_, dx| {
        let step = dx / yield_mm;
        let opposes = f64::from(step * z > 0.0);
        z = (z + step * (1.0 - z.abs().powi(n) * opposes)).clamp(-1.0, 1.0);
        z
    })
}

/// A spring in series with a slider.
pub(super) fn slider(x: &[f64], stiffness: f64, slip: f64) -> Vec<f64> {
    let mut f = 0.0_f64;
    along(x, |_, dx| {
        f = (f + stiffness * dx).clamp(-slip, slip);
        f
    })
}

/// A fluid damper `C |v|^power`, v in m/s, in series with a brace of stiffness `k` in N/m if it has one.
pub(super) fn fluid_damper(x: &[f64], c: f64, power: f64, brace: Option<f64>) -> Vec<f64> {
    const PARTS: u32 = 8;
    let v: Vec<f64> = derivative(x).iter().map(|v| 1e-3 * v).collect();
    let Some(k) = brace else {
        return v
            .iter()
            .map(|v| c * v.abs().powf(power).copysign(*v))
            .collect();
    };
    let (mut f, h) = (0.0_f64, DT / f64::from(PARTS));
    v.iter()
        .map(|v| {
            for _ in 0..PARTS {
                // Implicit, with the dashpot's slope: near zero force it is stiff.
                let over = f.abs() / c;
                let flow = over.powf(1.0 / power).copysign(f);
                let slope = over.powf(1.0 / power - 1.0) / (power * c);
                f += h * k * (v - flow) / (1.0 + h * k * slope);
            }
            f
        })
        .collect()
}

/// Rubber around a lead core that heats up: hysteresis whose strength falls with its temperature.
/// Kalpakidis and Constantinou, J. Struct. Eng. 135(12), 2009, 1440.
pub(super) fn lead_rubber(x: &[f64], k: f64, strength: f64, yield_mm: f64) -> Vec<f64> {
    let z = bouc_wen(x, yield_mm, 2);
    // Heat capacity in J/K of a core 220 mm high whose strength is 10 MPa times its area.
    let radius_m = 0.07 * (strength / 1.54e5).sqrt();
    let capacity = 11_200.0 * 130.0 * std::f64::consts::PI * radius_m.powi(2) * 0.22;
    let mut warm = 0.0_f64;
    let mut at = 0;
    along(x, |x, dx| {
        let now = strength * (-0.0069 * warm).exp() * z[at];
        at += 1;
        warm += (now * dx).abs() * 1e-3 / capacity - warm * DT / 1500.0;
        k * x + now
    })
}

/// High-damping rubber of height `height_mm`: it stiffens, has sliders of many sizes (Payne), and is softer below the largest
/// strain so far (Mullins).
pub(super) fn rubber(x: &[f64], height_mm: f64, k: f64, softer: f64) -> Vec<f64> {
    let strain: Vec<f64> = x.iter().map(|x| x / height_mm).collect();
    let yields: Vec<f64> = (0..14)
        .map(|i| 0.004 * 200.0_f64.powf(f64::from(i) / 13.0))
        .collect();
    let weights: Vec<f64> = yields.iter().map(|y| y.powf(-0.55)).collect();
    let sum: f64 = weights.iter().sum();
    let mut f: Vec<f64> = strain
        .iter()
        .map(|g| 0.45 * g + 0.035 * g.powi(3))
        .collect();
    for (y, w) in yields.iter().zip(&weights) {
        for (f, s) in f.iter_mut().zip(slider(&strain, 1.0, *y)) {
            *f += 0.55 * w / sum * s;
        }
    }
    let mut most = 0.0_f64;
    let each = f.iter().zip(&strain).map(|(f, g)| {
        most = most.max(g.abs());
        let back = if most > 1e-9 {
            1.0 - g.abs() / most
        } else {
            0.0
        };
        k * height_mm * f * (1.0 - softer * back * (most / 1.5).min(1.0))
    });
    each.collect()
}

/// A friction pendulum: gravity on a dish of radius 2.24 m, and friction that grows with speed from 4 to 8 % of the weight.
pub(super) fn pendulum(x: &[f64], weight: f64, per_speed_s_per_m: f64) -> Vec<f64> {
    let z = bouc_wen(x, 0.3, 2);
    let v = derivative(x);
    let friction = |v: f64| 0.08 - 0.04 * (-per_speed_s_per_m * 1e-3 * v.abs()).exp();
    let each = x.iter().zip(&z).zip(&v);
    each.map(|((x, z), v)| weight * (x / 2240.0 + friction(*v) * z))
        .collect()
}

/// A brace that cannot buckle: kinematic and isotropic hardening, a tenth stronger in compression.
pub(super) fn restrained_brace(x: &[f64], k: f64, strength: f64) -> Vec<f64> {
    let hardening = 0.02 * k / 0.98;
    let (mut plastic, mut centre, mut way) = (0.0, 0.0, 0.0_f64);
    along(x, |x, _| {
        let f = k * (x - plastic);
        let over: f64 = f - centre;
        let grown = strength * (1.0 + 0.2 * (1.0 - (-4e-3 * way).exp()));
        let limit = if over > 0.0 { grown } else { 1.1 * grown };
        if over.abs() <= limit {
            return f;
        }
        let more = (over.abs() - limit) / (k + hardening);
        plastic += more.copysign(over);
        centre += (hardening * more).copysign(over);
        way += more;
        k * (x - plastic)
    })
}

/// A brace that yields at 800 kN and buckles at `buckles`, at a lower force each time; straightening from a bow is soft.
pub(super) fn brace(x: &[f64], buckles: f64) -> Vec<f64> {
    const STIFFNESS: f64 = 1.5e5;
    const YIELDS: f64 = 8e5;
    const RESIDUAL: f64 = 0.3;
    const LENGTH_MM: f64 = 12.0;
    let (mut f, mut longer, mut damage, mut bow) = (0.0_f64, 0.0, 0.0_f64, 0.0_f64);
    along(x, |x, dx| {
        let now = x - longer;
        let capacity = buckles * (RESIDUAL + (1.0 - RESIDUAL) * (-damage / LENGTH_MM).exp());
        let past = now + capacity / STIFFNESS;
        let falls = RESIDUAL + (1.0 - RESIDUAL) * (past.min(0.0) / LENGTH_MM).exp();
        let least = -capacity * if past < 0.0 { falls } else { 1.0 };
        let soft = if f < 0.15 * YIELDS {
            4.0 * bow / LENGTH_MM
        } else {
            0.3 * bow / LENGTH_MM
        };
        f = (f + STIFFNESS / (1.0 + soft) * dx).max(least);
        if past < 0.0 {
            bow = bow.max(-now);
            damage += (-dx).max(0.0);
        }
        if now > 0.0 && f >= 0.0 {
            bow = (bow - 2.0 * dx.abs()).max(0.0);
        }
        if f > YIELDS {
            f = YIELDS;
            longer = f64::max(longer, x - YIELDS / STIFFNESS);
            bow = 0.0;
        }
        f
    })
}

/// A nailed timber wall: a curved backbone, and pinched reloading towards the largest drift so far.
/// After Folz and Filiatrault, J. Struct. Eng. 127(4), 2001, 361.
pub(super) fn timber_wall(x: &[f64], size: f64) -> Vec<f64> {
    let (k, level, pinch) = (1200.0 * size, 1.8e4 * size, 3.5e3 * size);
    let backbone = |x: f64| {
        let at = x.min(60.0);
        let rising = (level + 0.06 * k * at) * (1.0 - (-k * at / level).exp());
        (rising - 0.05 * k * (x - at)).max(0.0)
    };
    let yields = level / k;
    let (mut f, mut most) = (0.0_f64, 0.0_f64);
    along(x, |x, dx| {
        let way = if dx < 0.0 { -1.0 } else { 1.0 };
        if most < yields && x.abs() >= most && way * x > 0.0 {
            most = x.abs();
            f = way * backbone(x.abs());
            return f;
        }
        let goal = 1.1 * most;
        let reload = k * (yields / goal.max(yields)).powf(0.75);
        let pinched = pinch + 0.03 * k * way * x;
        let aimed = backbone(goal) - reload * (goal - way * x);
        let bound = if most > yields {
            pinched.max(aimed)
        } else {
            f64::INFINITY
        };
        let bound = bound.min(backbone((way * x).max(1e-6)));
        f += k * dx;
        if way * f > bound {
            f = way * bound;
        }
        if way * x > 0.0 {
            most = most.max(x.abs());
        }
        f
    })
}

/// A reinforced-concrete column: unloading softens with the largest drift, and reloading aims at it.
/// Clough and Johnston, Proc. Japan Earthq. Eng. Symp., 1966, 227; unloading after Takeda et al., 1970.
pub(super) fn concrete_column(x: &[f64], k: f64, strength: f64, unloading: f64) -> Vec<f64> {
    const HARDENING: f64 = 0.04;
    let yields = strength / k;
    let backbone = |x: f64| {
        if x < yields {
            k * x
        } else {
            strength + HARDENING * k * (x - yields)
        }
    };
    let (mut f, mut peaks) = (0.0_f64, [yields; 2]);
    along(x, |x, dx| {
        if dx == 0.0 {
            return f;
        }
        let way = dx.signum();
        let side = usize::from(way > 0.0);
        let unload = k * (yields / peaks[0].max(peaks[1])).powf(unloading);
        let mut rest = dx;
        if way * f < 0.0 {
            if way * (f + unload * dx) <= 0.0 {
                f += unload * dx;
                return f;
            }
            rest = dx + f / unload;
            f = 0.0;
        }
        let to_go = way * (way * peaks[side] - (x - rest));
        let towards = if to_go > 1e-9 {
            ((backbone(peaks[side]) - way * f) / to_go).clamp(0.0, unload)
        } else {
            HARDENING * k
        };
        f += towards * rest;
        if way * x >= peaks[side] {
            peaks[side] = way * x;
            f = way * backbone(way * x);
        }
        f
    })
}

/// Shape-memory wires: a flag-shaped loop that yields at `up` going out and returns at `down`.
pub(super) fn flag(x: &[f64], k: f64, [up, down]: [f64; 2]) -> Vec<f64> {
    let bound = |x: f64, level: f64| (k * x).min(level + 0.06 * k * (x - level / k));
    let mut f = 0.0_f64;
    along(x, |x, dx| {
        let (out, back) = (bound(x.abs(), up), bound(x.abs(), down));
        let [low, high] = if x < 0.0 { [-out, -back] } else { [back, out] };
        f = (f + k * dx).clamp(low, high);
        f
    })
}

/// A rocking wall: elastic up to the force `lifts` and soft beyond it, with bars that yield at the force `bars` (0: no bars).
pub(super) fn rocking_wall(x: &[f64], k: f64, lifts: f64, bars: f64) -> Vec<f64> {
    let wall = |x: f64| 0.05 * k * x + 0.95 * lifts * (k * x / lifts).tanh();
    let yields = if bars > 0.0 {
        bouc_wen(x, bars / k, 4)
    } else {
        vec![0.0; x.len()]
    };
    x.iter()
        .zip(yields)
        .map(|(x, z)| wall(*x) + bars * z)
        .collect()
}

/// A spring in series with a bolted joint that slips at the force `slips` until its bolts bear, `gap` mm to each side.
pub(super) fn bolted_joint(x: &[f64], k: f64, slips: f64, gap: f64) -> Vec<f64> {
    let mut slipped = 0.0_f64;
    along(x, |x, _| {
        let f = k * (x - slipped);
        let over = (f.abs() - slips).max(0.0) / k;
        slipped = (slipped + over.copysign(f)).clamp(-gap, gap);
        k * (x - slipped)
    })
}

/// A magnetorheological damper at a voltage, with the published parameters (in cm):
/// Spencer et al., J. Eng. Mech. 123(3), 1997, 230, table 2.
pub(super) fn mr_damper(x: &[f64], volts: f64) -> Vec<f64> {
    const PARTS: u32 = 6;
    let (alpha, c0, c1) = (
        140.0 + 695.0 * volts,
        21.0 + 3.5 * volts,
        283.0 + 2.95 * volts,
    );
    let (k0, k1, gamma, beta, a) = (46.9, 5.0, 363.0, 363.0, 301.0);
    let h = DT / f64::from(PARTS);
    let (mut y, mut z) = (0.0_f64, 0.0_f64);
    let v = derivative(x);
    x.iter()
        .zip(v)
        .map(|(x, v)| {
            let (x, v) = (0.1 * x, 0.1 * v);
            let mut rate = 0.0;
            for _ in 0..PARTS {
                rate = (alpha * z + c0 * v + k0 * (x - y)) / (c0 + c1);
                let w: f64 = v - rate;
                z += h * (-gamma * w.abs() * z * z.abs() - beta * w * z * z + a * w);
                y += h * rate;
            }
            // Zeroing the load cell removes the accumulator's preload.
            c1 * rate + k1 * x
        })
        .collect()
}

/// A frame with a cubic spring whose force at `peak_mm` is larger by the share `more`; `[k, c, m]` in N/mm, N s/mm, kg.
pub(super) fn stiffening_frame(
    x: &[f64],
    [k, c, m]: [f64; 3],
    more: f64,
    peak_mm: f64,
) -> Vec<f64> {
    let v = derivative(x);
    let a = derivative(&v);
    let force =
        |i: usize| k * x[i] * (1.0 + more * (x[i] / peak_mm).powi(2)) + c * v[i] + 1e-3 * m * a[i];
    (0..x.len()).map(force).collect()
}

/// Applies a law step by step to the displacement and its increment, mm.
fn along(x: &[f64], mut law: impl FnMut(f64, f64) -> f64) -> Vec<f64> {
    let mut before = x.first().copied().unwrap_or_default();
    x.iter()
        .map(|&x| {
            let f = law(x, x - before);
            before = x;
            f
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cycles(peak_mm: f64, hz: f64, seconds: f64) -> Vec<f64> {
        let n = (seconds / DT) as usize;
        let omega = std::f64::consts::TAU * hz;
        (0..n)
            .map(|i| peak_mm * (omega * i as f64 * DT).sin())
            .collect()
    }

    /// Work done on the device, J.
    fn work(x: &[f64], f: &[f64]) -> f64 {
        let steps = x.windows(2).zip(f.windows(2));
        steps
            .map(|(x, f)| 5e-4 * (f[0] + f[1]) * (x[1] - x[0]))
            .sum()
    }

    #[test]
    fn a_slider_takes_four_times_slip_force_and_slipped_way_a_cycle() {
        let x = cycles(10.0, 1.0, 2.0);
        let f = slider(&x, 1000.0, 2000.0);
        let second = x.len() / 2;
        let took = work(&x[second..], &f[second..]);
        // The spring takes 2 of the 10 mm to each side.
        let exact = 4.0 * 2000.0 * (10.0 - 2.0) * 1e-3;
        assert!((took / exact - 1.0).abs() < 1e-3, "{took} J of {exact}");
    }

    #[test]
    fn a_linear_fluid_damper_takes_pi_times_c_omega_and_the_square_of_the_way() {
        let x = cycles(10.0, 1.0, 1.0);
        let f = fluid_damper(&x, 2e5, 1.0, None);
        let omega = std::f64::consts::TAU;
        let exact = std::f64::consts::PI * 2e5 * omega * 0.01_f64.powi(2);
        assert!((work(&x, &f) / exact - 1.0).abs() < 1e-3);
        // With a brace it is a Maxwell element: force over displacement is k i w tau / (1 + i w tau).
        let x = cycles(10.0, 1.0, 4.0);
        let f = fluid_damper(&x, 2e5, 1.0, Some(4e6));
        let turn = omega * 2e5 / 4e6;
        let peak = crate::fine::peak(&f[x.len() / 2..]);
        let exact = 4e6 * 0.01 * turn / (1.0 + turn * turn).sqrt();
        assert!((peak / exact - 1.0).abs() < 1e-3, "{peak} N of {exact}");
    }

    #[test]
    fn a_concrete_column_returns_to_its_largest_drift() {
        let x: Vec<f64> = [10.0, 20.0, 20.0]
            .iter()
            .flat_map(|a| cycles(*a, 1.0, 1.0))
            .collect();
        let f = concrete_column(&x, 20_000.0, 1e5, 0.4);
        let at_most = |cycle: usize| {
            let part = cycle * 8000..(cycle + 1) * 8000;
            crate::fine::peak(&f[part])
        };
        assert!(
            (at_most(1) / at_most(2) - 1.0).abs() < 1e-6,
            "no strength is lost"
        );
        let exact = 1e5 + 0.04 * 20_000.0 * (20.0 - 5.0);
        assert!((at_most(1) / exact - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_bolted_joint_slips_by_its_gap_and_bears() {
        let x = cycles(10.0, 1.0, 2.0);
        let f = bolted_joint(&x, 1000.0, 2000.0, 3.0);
        assert!((crate::fine::peak(&f) - 1000.0 * (10.0 - 3.0)).abs() < 1.0);
        let second = x.len() / 2;
        let exact = 4.0 * 2000.0 * 3.0 * 1e-3;
        let took = work(&x[second..], &f[second..]);
        assert!((took / exact - 1.0).abs() < 1e-2, "{took} J of {exact}");
    }

    #[test]
    fn a_flag_comes_back_to_zero_and_dissipates() {
        let x = cycles(20.0, 1.0, 1.0);
        let f = flag(&x, 8000.0, [4e4, 2e4]);
        assert!(work(&x, &f) > 0.0);
        let zero = x.len() / 2;
        assert!(f[zero].abs() < 10.0, "{}", f[zero]);
    }

    #[test]
    fn every_device_dissipates_over_a_closed_motion() {
        let x = cycles(20.0, 0.5, 4.0);
        let all = [
            lead_rubber(&x, 1000.0, 1.5e5, 8.0),
            rubber(&x, 20.0, 1500.0, 0.3),
            pendulum(&x, 8e5, 30.0),
            restrained_brace(&x, 2.5e5, 9e5),
            brace(&x, 4.5e5),
            timber_wall(&x, 1.0),
            rocking_wall(&x, 3e4, 1.5e5, 7e4),
            mr_damper(&x, 1.5),
        ];
        for (i, f) in all.iter().enumerate() {
            assert!(f.iter().all(|f| f.is_finite()), "{i}");
            assert!(work(&x, f) > 0.0, "{i}: {}", work(&x, f));
        }
    }
}
