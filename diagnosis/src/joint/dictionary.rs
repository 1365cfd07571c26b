//! The elements that a search begins with: every law over a grid of shapes, relative to the motion.

use super::element::{Element, Law};
use super::track::MotionScales;

/// All of them, for a motion of these sizes.
pub fn elements(sizes: &MotionScales) -> Vec<Element> {
    let (x, v, c) = (sizes.x, sizes.v, sizes.middle);
    let mut all = Vec::new();
    let mut add = |law, shape: [f64; 4]| all.push(Element { law, shape });
    for yield_at in [
        0.0007, 0.0015, 0.003, 0.006, 0.012, 0.025, 0.05, 0.09, 0.16, 0.27, 0.42, 0.6, 0.75, 0.9,
    ] {
        add(Law::Slider, [yield_at * x, 0.0, 0.0, 0.0]);
    }
    for yield_at in [0.0007, 0.002, 0.006, 0.018] {
        add(Law::Bristles, [yield_at * x, 0.0, 0.0, 0.0]);
    }
    for yield_at in [0.0015, 0.006, 0.025] {
        for speed in [0.02, 0.05, 0.12, 0.25, 0.5] {
            add(Law::Stribeck, [yield_at * x, speed * v, 0.0, 0.0]);
        }
    }
    for yield_at in [0.02, 0.05, 0.1, 0.2, 0.35, 0.55, 0.8] {
        for n in [1.0, 2.0] {
            for unload in [-0.5, 0.0, 0.6] {
                add(Law::BoucWen, [yield_at * x, n, 1.0, unload]);
            }
        }
    }
    // In their own rates: these grow on the way out, or hardly yield.
    for load in [-0.8, -0.4, -0.15, 0.0, 0.3] {
        for unload in [0.4, 1.0, 2.0, 4.0] {
            for n in [1.0, 2.0] {
                add(Law::BoucWen, [x, n, load, unload]);
            }
        }
    }
    for most in [0.02, 0.06, 0.15, 0.3, 0.6] {
        add(Law::Distributed, [most * x, 0.0, 0.0, 0.0]);
    }
    for yield_at in [0.005, 0.02, 0.08, 0.25] {
        for creep in [0.05, 0.2, 0.5, 1.0] {
            for n in [3.0, 8.0] {
                add(Law::InSeries, [yield_at * x, creep * v, n, 0.0]);
            }
        }
    }
    // A dashpot of nearly its speed behind a spring.
    for yield_at in [0.08, 0.2, 0.4] {
        for creep in [0.5, 1.0] {
            add(Law::InSeries, [yield_at * x, creep * v, 1.4, 0.0]);
        }
    }
    for exponent in [0.2, 0.35, 0.5, 0.7, 0.85, 1.2, 1.5, 2.0, 2.5, 3.0] {
        add(Law::PowerOfSpeed, [exponent, 0.0, 0.0, 0.0]);
    }
    for speed in [0.01, 0.03, 0.06, 0.12, 0.25, 0.5, 1.0] {
        add(Law::Saturating, [speed * v, 0.0, 0.0, 0.0]);
    }
    let (short, long): (f64, f64) = (3.0 * sizes.interval_s, 0.25 * sizes.seconds);
    for i in 0..10 {
        let tau = short * (long / short).powf(f64::from(i) / 9.0);
        add(Law::Relaxing, [tau, 0.0, 0.0, 0.0]);
    }
    for exponent in [0.5, 1.0, 2.0, 3.0, 5.0] {
        add(Law::PowerOfPlace, [exponent, 0.0, 0.0, 0.0]);
    }
    for exponent in [0.15, 0.4, 0.8, 1.4, 2.5] {
        add(Law::Lessened, [exponent, 0.0, 0.0, 0.0]);
    }
    for share in [0.2, 1.0] {
        add(Law::Fatigued, [share * sizes.travel, 0.0, 0.0, 0.0]);
    }
    for place in [-0.5, -0.25, 0.0, 0.25, 0.5] {
        add(Law::Away, [c + place * x, 0.0, 0.0, 0.0]);
        for side in [-1.0, 1.0] {
            add(Law::Beyond, [c + 1.5 * place * x, side, 0.0, 0.0]);
        }
    }
    for gap in [0.1, 0.25, 0.45, 0.65, 0.85] {
        add(Law::Beyond, [gap * x, 0.0, c, 0.0]);
    }
    add(Law::Square, [0.0; 4]);
    add(Law::SizeOfSpeed, [0.0; 4]);
    for half in [0.015, 0.04, 0.1, 0.2, 0.35, 0.6, 0.85] {
        add(Law::Lost, [half * x, 0.0, 0.0, 0.0]);
    }
    for yield_at in [0.003, 0.015, 0.06, 0.2] {
        add(Law::SliderAway, [yield_at * x, c, 0.0, 0.0]);
        add(Law::SliderAlong, [yield_at * x, c, 0.0, 0.0]);
    }
    for share in [0.05, 0.15, 0.5, 2.0] {
        add(Law::Settling, [share * sizes.seconds, 0.0, 0.0, 0.0]);
    }
    for yield_at in [0.04, 0.12, 0.35] {
        for travel in [0.5, 1.5] {
            add(Law::Worn, [yield_at * x, travel * sizes.travel, 0.0, 0.0]);
        }
        for width in [0.15, 0.4] {
            add(Law::Pinched, [yield_at * x, width * x, c, 0.0]);
        }
    }
    all.retain(|e| e.is_sound(sizes));
    all
}

/// Springs that change while something warms up: rivals of what the way takes. In the search itself one would follow what the
/// beginning of any record leaves.
pub fn warming(sizes: &MotionScales) -> Vec<Element> {
    let shares = [0.07, 0.12, 0.2, 0.35, 0.6, 1.0, 1.7, 3.0];
    let all = shares.map(|s| Element::new(Law::Warming, [s * sizes.seconds]));
    all.to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_law_is_in_it() {
        let sizes = MotionScales {
            x: 10.0,
            middle: 2.0,
            v: 100.0,
            seconds: 20.0,
            interval_s: 1e-3,
            travel: 800.0,
        };
        let all = elements(&sizes);
        assert!((200..300).contains(&all.len()), "{}", all.len());
        let laws: std::collections::HashSet<String> =
            all.iter().map(|e| format!("{:?}", e.law)).collect();
        assert_eq!(laws.len(), 22, "{laws:?}");
    }
}
