//! Forces of real devices along a motion, each by equations of its own: mm, s, N.

use std::f64::consts::TAU;

/// Between two samples of a force, s.
pub const FINE: f64 = 5e-4;
/// Rests before and after, s.
const RESTS: [f64; 2] = [3.0, 2.0];
/// One size of the cycles lasts, s.
const EACH: f64 = 3.0;
const SIZES: [f64; 12] = [
    0.2, 0.35, 0.5, 0.7, 0.85, 1.0, 0.6, 0.3, 0.45, 0.8, 1.0, 0.5,
];

/// A motion on the fine grid, with rests at both ends.
pub struct Moved {
    pub x: Vec<f64>,
    pub v: Vec<f64>,
}

/// From 0 to 1 and with no speed at either end.
fn smooth(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

impl Moved {
    fn of(seconds: f64, peak: f64, place: impl Fn(f64) -> f64) -> Self {
        let [before, after] = RESTS;
        let n = ((before + seconds + after) / FINE) as usize;
        let at = |i: usize| {
            let t = i as f64 * FINE - before;
            let inside = (0.0..seconds).contains(&t);
            if inside { place(t) } else { 0.0 }
        };
        let raw: Vec<f64> = (0..n).map(at).collect();
        let most = raw.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let x: Vec<f64> = raw.iter().map(|x| peak / most * x).collect();
        let v = (0..n).map(|i| (x[(i + 1).min(n - 1)] - x[i.saturating_sub(1)]) / (2.0 * FINE));
        Self { v: v.collect(), x }
    }

    /// Cycles that grow, and some of other sizes, at two rates.
    pub fn cycles(peak: f64, hz: f64) -> Self {
        let whole = EACH * SIZES.len() as f64;
        let rate = |i: usize| if i % 4 < 2 { hz } else { 1.6 * hz };
        Self::of(whole, peak, |t| {
            let i = (t / EACH) as usize;
            let begun: f64 = (0..i).map(|k| EACH * rate(k)).sum();
            let into = t - EACH * i as f64;
            let before = if i == 0 { 0.0 } else { SIZES[i - 1] };
            let size = before + (SIZES[i] - before) * smooth(into);
            size * smooth(whole - t) * (TAU * (begun + rate(i) * into)).sin()
        })
    }

    /// As in an earthquake: sines that come and go.
    pub fn shaken(peak: f64, hz: f64) -> Self {
        Self::of(36.0, peak, |t| {
            let u = t / 36.0;
            let envelope =
                smooth((10.0 * u).min(5.0 * (1.0 - u))) * (0.6 + 0.4 * (TAU * 2.3 * u).sin());
            let sines = (1..=14).map(|k| {
                let of_hz = 0.35 + 0.12 * f64::from(k);
                (TAU * of_hz * hz * t + 2.3 * f64::from(k * k)).sin() / (1.0 + (of_hz - 1.0).abs())
            });
            envelope * sines.sum::<f64>()
        })
    }

    /// A law that goes step by step: of displacement and its step.
    fn along(&self, mut law: impl FnMut(f64, f64) -> f64) -> Vec<f64> {
        let mut last = self.x[0];
        let step = |x: &f64| {
            let f = law(*x, *x - last);
            last = *x;
            f
        };
        self.x.iter().map(step).collect()
    }
}

/// A spring behind Coulomb friction.
pub fn slides(m: &Moved, k: f64, level: f64) -> Vec<f64> {
    let mut f = 0.0_f64;
    m.along(|_, dx| {
        f = (f + k * dx).clamp(-level, level);
        f
    })
}

/// Two of them: a device that yields at two levels.
pub fn yields_twice(m: &Moved, first: [f64; 2], second: [f64; 2]) -> Vec<f64> {
    let [one, two] = [first, second].map(|[k, level]| slides(m, k, level));
    one.iter().zip(two).map(|(a, b)| a + b).collect()
}

/// Bouc and Wen's loop; `strength` is what is left of its level after a largest displacement and some work, N mm.
pub fn smooth_loop(
    m: &Moved,
    yields: f64,
    level: f64,
    strength: impl Fn(f64, f64) -> f64,
) -> Vec<f64> {
    let (mut z, mut work, mut most) = (0.0_f64, 0.0, 0.0_f64);
    m.along(|x, dx| {
        let on = if z * dx > 0.0 { 1.0 } else { 0.1 };
        z += dx / yields * (1.0 - on * z.abs().powf(1.6));
        most = most.max(x.abs());
        let f = level * strength(most, work) * z;
        work += (f * dx).max(0.0);
        f
    })
}

/// The same with lost motion where it is weak (Baber and Noori, J. Eng. Mech. 111(8), 1985).
pub fn slip_lock(m: &Moved, yields: f64, level: f64, slip: f64) -> Vec<f64> {
    let mut z = 0.0_f64;
    m.along(|_, dx| {
        let on = f64::from(u8::from(z * dx > 0.0));
        let rate = 1.0 - on * z.abs().powf(1.6);
        let slips = slip / yields * (-(z / 0.25).powi(2)).exp() * on;
        z += dx / yields * rate / (1.0 + slips * rate);
        level * z
    })
}

/// A brace: in tension it yields, in compression it buckles, carries less the farther it bends, and is soft until it is straight again.
pub fn buckles(m: &Moved, k: f64, yields: f64, buckles: f64) -> Vec<f64> {
    const BENDS_MM: f64 = 10.0;
    let (mut f, mut bent) = (0.0_f64, 0.0_f64);
    m.along(|_, dx| {
        f += k * dx / (1.0 + 6.0 * bent / BENDS_MM);
        let carries = buckles * (0.35 + 0.65 * (-bent / BENDS_MM).exp());
        if f < -carries {
            f = -carries;
            bent -= dx.min(0.0);
        }
        if f > 0.8 * yields {
            bent = (bent - 2.0 * dx.max(0.0)).max(0.0);
        }
        f = f.min(yields);
        f
    })
}

/// Peak-oriented and pinched: reloading stays at a share `low` of the peak's force up to half of the peak, and then aims at it.
pub fn pinched(m: &Moved, k: f64, level: f64, low: f64) -> Vec<f64> {
    let yields = level / k;
    let backbone = |d: f64| (k * d).min(level + 0.03 * k * (d - yields));
    let (mut peaks, mut f, mut zero) = ([yields; 2], 0.0_f64, 0.0_f64);
    m.along(|x, dx| {
        let way = if dx < 0.0 { -1.0 } else { 1.0 };
        let peak = &mut peaks[usize::from(way > 0.0)];
        let d = way * x;
        f += k * dx;
        if way * f < 0.0 {
            zero = d + f.abs() / k;
            return f;
        }
        let (knee, aim) = (0.5 * *peak, backbone(*peak));
        let reloads = if *peak <= yields {
            aim
        } else if d < knee {
            low * aim * ((d - zero) / (knee - zero)).max(0.0)
        } else {
            low * aim + (1.0 - low) * aim * (d - knee) / (*peak - knee)
        };
        let most = if d > *peak { backbone(d) } else { reloads };
        *peak = peak.max(d);
        f = way * (way * f).min(most);
        f
    })
}

/// A flag: it yields at `up`, and on the way back at `down`.
pub fn flag(m: &Moved, k: f64, [up, down]: [f64; 2], hardening: f64) -> Vec<f64> {
    let mut plastic = 0.0_f64;
    m.along(|x, _| {
        let d = x.abs();
        let same_side = (plastic * x.signum()).max(0.0);
        let most = ((d - down / k).max(0.0), (d - up / k).max(0.0));
        plastic = same_side.clamp(most.1, most.0) * x.signum();
        k * (x - plastic) + hardening * k * plastic
    })
}

/// A bumper on one side: spring and dashpot beyond a gap, which push and never pull.
pub fn bumper(m: &Moved, k: f64, c: f64, gap: f64) -> Vec<f64> {
    let pushes = |(x, v): (&f64, &f64)| match x - gap {
        into if into > 0.0 => (k * into + c * v).max(0.0),
        _ => 0.0,
    };
    m.x.iter().zip(&m.v).map(pushes).collect()
}

/// Filled rubber: yields of many sizes about a spring that stiffens, softer below the largest strain so far (Mullins).
pub fn rubber(m: &Moved, k: f64, reference: f64, softer: f64) -> Vec<f64> {
    let spring = |x: &f64| 0.5 * k * x * (1.0 + 0.35 * (x / reference).powi(2));
    let mut all: Vec<f64> = m.x.iter().map(spring).collect();
    for yields in [0.01_f64, 0.02, 0.04, 0.08, 0.16, 0.32] {
        let own = 0.35 * k * (0.04 / yields).powf(0.6);
        let slides = slides(m, own, own * yields * reference);
        all.iter_mut().zip(slides).for_each(|(f, s)| *f += s);
    }
    let mut most = 1e-9_f64;
    let each = all.iter().zip(&m.x).map(|(f, x)| {
        most = most.max(x.abs());
        f * (1.0 - softer * (most / reference).min(1.0) * (1.0 - x.abs() / most))
    });
    each.collect()
}

/// A magnetorheological damper at a voltage (Spencer et al., J. Eng. Mech. 123(3), 1997; cm there): Bouc-Wen and a dashpot, behind
/// another dashpot.
pub fn magnetic(m: &Moved, volts: f64) -> Vec<f64> {
    let (alpha, c0, c1) = (
        140.0 + 695.0 * volts,
        21.0 + 3.5 * volts,
        283.0 + 2.95 * volts,
    );
    let (mut y, mut z) = (0.0_f64, 0.0_f64);
    let step = |(x, v): (&f64, &f64)| {
        let (x, v) = (0.1 * x, 0.1 * v);
        let mut rate = 0.0;
        for _ in 0..20 {
            rate = (alpha * z + c0 * v + 46.9 * (x - y)) / (c0 + c1);
            let w: f64 = v - rate;
            z += FINE / 20.0 * (301.0 * w - 363.0 * (w.abs() * z.abs() * z + w * z * z));
            y += FINE / 20.0 * rate;
        }
        c1 * rate + 5.0 * x
    };
    m.x.iter().zip(&m.v).map(step).collect()
}
