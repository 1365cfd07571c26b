//! Play and slip: motion that is lost between input and output.

/// Backlash: the output rests until the input has crossed the play, then follows at its edge.
#[derive(Clone, Debug)]
pub struct Play {
    half_m: f64,
    at_m: f64,
}

impl Play {
    /// A play of `width_m` in total, with the output in its middle.
    pub fn new(width_m: f64) -> Self {
        Self {
            half_m: 0.5 * width_m,
            at_m: 0.0,
        }
    }

    /// Input and output at `x_m`, in the middle of the play.
    pub(crate) fn move_to(&mut self, x_m: f64) {
        self.at_m = x_m;
    }

    /// The output at the input `x_m`.
    #[inline]
    pub fn step(&mut self, x_m: f64) -> f64 {
        self.at_m = self.at_m.max(x_m - self.half_m).min(x_m + self.half_m);
        self.at_m
    }
}

/// A bolted joint in series: it holds by friction up to a slip force, slips through the clearance of its hole, and bears.
#[derive(Clone, Debug)]
pub struct SlipGap {
    /// Deformation of the spring after it at which the joint slips.
    holds_m: f64,
    half_gap_m: f64,
    slipped_m: f64,
}

impl SlipGap {
    /// Held in the middle of a clearance of `gap_m` in total; slips at the deformation `holds_m` of its spring.
    pub fn new(holds_m: f64, gap_m: f64) -> Self {
        Self {
            holds_m,
            half_gap_m: 0.5 * gap_m,
            slipped_m: 0.0,
        }
    }

    /// The remaining deformation of the spring after the joint, at the drift `x_m`.
    #[inline]
    pub fn step(&mut self, x_m: f64) -> f64 {
        self.slipped_m = self
            .slipped_m
            .max(x_m - self.holds_m)
            .min(x_m + self.holds_m)
            .max(-self.half_gap_m)
            .min(self.half_gap_m);
        x_m - self.slipped_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backlash_falls_behind_by_half_its_play_either_way() {
        let mut play = Play::new(0.002);
        assert_eq!(play.step(0.0009), 0.0);
        assert!((play.step(0.005) - 0.004).abs() < 1e-15);
        assert!((play.step(0.0031) - 0.004).abs() < 1e-15);
        assert!((play.step(-0.005) + 0.004).abs() < 1e-15);
    }

    #[test]
    fn a_bolt_holds_slips_and_bears() {
        let mut joint = SlipGap::new(0.001, 0.004);
        let force = |x: f64, joint: &mut SlipGap| joint.step(x);
        assert!((force(0.0008, &mut joint) - 0.0008).abs() < 1e-15); // holds
        assert!((force(0.0025, &mut joint) - 0.001).abs() < 1e-15); // slips
        assert!((force(0.0050, &mut joint) - 0.003).abs() < 1e-15); // bears: 2 mm slipped
        assert!((force(0.0020, &mut joint) - 0.000).abs() < 1e-15); // unloads
        assert!((force(-0.0050, &mut joint) + 0.003).abs() < 1e-15); // slips to the other side and bears
    }

    #[test]
    fn a_cycle_of_slip_dissipates_the_slip_force_over_the_clearance() {
        let (k, holds, gap) = (1e6, 0.001, 0.004);
        let mut joint = SlipGap::new(holds, gap);
        let (mut work, mut last) = (0.0, (0.0, 0.0));
        for i in 0..=40_000 {
            let x = 0.006 * (std::f64::consts::TAU * f64::from(i) / 20_000.0).sin();
            let r = k * joint.step(x);
            if i > 20_000 {
                work += 0.5 * (r + last.1) * (x - last.0);
            }
            last = (x, r);
        }
        let exact = 2.0 * k * holds * gap;
        assert!((work / exact - 1.0).abs() < 1e-4, "{work} J, {exact} J");
    }
}
