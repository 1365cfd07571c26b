//! How every actuator responded while one of them was moved: the specimen's stiffness, one column per moved actuator, and
//! wires that are exchanged.
//!
//! Forces are fitted with `force = constant + stiffness * displacement + mass * acceleration` of the actuator that moves,
//! since its head and what it carries have a mass, which in a fast signal looks like a negative stiffness.

use link::reply::Identity;
use link::telemetry::StepReport;

/// Half the time over which an acceleration is computed, s.
const ACCELERATION_S: f64 = 8e-3;
/// A force of which the fit explains less than this share has not responded.
const EXPLAINED: f64 = 0.8;
/// A stiffness below this share of the declared one means that no specimen is connected.
const CONNECTED: f64 = 0.1;
/// Steps searched back for a sensor at its rail.
const LATEST: usize = 4;

/// The readings of all actuators while one moved.
#[derive(Clone, Debug)]
pub struct CrossReadings {
    moved: usize,
    rate_hz: f64,
    /// Motion below this counts as none, m.
    least_m: f64,
    command_m: Vec<f64>,
    /// Of each actuator, m and N.
    displacement_m: Vec<Vec<f64>>,
    force_n: Vec<Vec<f64>>,
    /// Sensors at their rails, step by step: the actuator, from 0, and the sensor's name.
    railed: Vec<Option<(usize, &'static str)>>,
}

impl CrossReadings {
    /// No readings yet, from the board `identity`; the actuator `moved`, from 0, is moved.
    pub fn new(identity: &Identity, moved: usize, rate_hz: f64, least_m: f64) -> Self {
        let each = || vec![Vec::new(); identity.actuators()];
        Self {
            moved,
            rate_hz,
            least_m,
            command_m: Vec::new(),
            displacement_m: each(),
            force_n: each(),
            railed: Vec::new(),
        }
    }

    /// A control step of the signal.
    pub fn add_step(&mut self, identity: &Identity, step: &StepReport) {
        self.command_m.push(f64::from(step.command_m));
        for (actuator, lines) in identity.calibrations().enumerate() {
            let codes = step.codes(actuator).unwrap_or_default();
            let [displacement_m, force_n] = lines.readings(codes).map(f64::from);
            self.displacement_m[actuator].push(displacement_m);
            self.force_n[actuator].push(force_n);
        }
    }

    /// Notes whether a sensor is at its rail in this step.
    pub fn look_for_rails(&mut self, identity: &Identity, step: &StepReport) {
        let sensors = (0..identity.actuators()).flat_map(|actuator| {
            let [displacement, force] = step.codes(actuator).unwrap_or_default();
            [
                (actuator, "displacement", displacement),
                (actuator, "force", force),
            ]
        });
        let mut at_rail = sensors.filter(|(.., code)| identity.codes.at_rail(*code));
        self.railed
            .push(at_rail.next().map(|(actuator, name, _)| (actuator, name)));
    }

    /// The last sensor at its rail, in words.
    pub fn rail(&self) -> Option<String> {
        let mut latest = self.railed.iter().rev().take(LATEST).flatten();
        latest.next().map(|(actuator, name)| {
            format!(
                "the {name} of actuator {} stood at the end of its converter's range: look at its wire and its supply",
                actuator + 1
            )
        })
    }

    /// Force on each actuator over the displacement of the one that moves, N/m; `None` where no force responded.
    pub fn stiffness_n_per_m(&self) -> Vec<Option<f64>> {
        let wing = ((ACCELERATION_S * self.rate_hz).round() as usize).max(1);
        let u = &self.displacement_m[self.moved];
        if u.len() < 20 * wing || range(u) < self.least_m {
            return vec![None; self.force_n.len()];
        }
        let h2 = (wing as f64 / self.rate_hz).powi(2);
        let a = (wing..u.len() - wing).map(|i| (u[i + wing] - 2.0 * u[i] + u[i - wing]) / h2);
        let (u, a) = (centred(&smoothed(u, wing)), centred(&a.collect::<Vec<_>>()));
        let forces = self.force_n.iter();
        forces
            .map(|f| stiffness(&u, &a, &centred(&smoothed(f, wing))))
            .collect()
    }

    /// What looks wrongly wired, given the declared stiffnesses of the storeys, from the ground up, N/m.
    pub fn wiring_mistake(&self, storeys_n_per_m: &[f64]) -> Option<String> {
        self.exchanged_motion()
            .or_else(|| self.exchanged_forces(storeys_n_per_m))
    }

    fn exchanged_motion(&self) -> Option<String> {
        let (moved, sent_m) = (self.moved, range(&self.command_m));
        let own = &self.displacement_m[moved];
        if sent_m < self.least_m {
            return None;
        }
        if 2.0 * range(own) < sent_m {
            let others = (0..self.displacement_m.len()).filter(|j| *j != moved);
            let far = others.map(|j| (j, range(&self.displacement_m[j])));
            let (other, went_m) = far.max_by(|a, b| a.1.total_cmp(&b.1))?;
            return (2.0 * went_m > sent_m && went_m > self.least_m).then(|| {
                format!(
                    "actuator {} was sent over {:.2} mm and moved by {:.2}, while actuator {} was to stand and moved by {:.2}: \
                     their commands or their displacement transducers look exchanged",
                    moved + 1,
                    sent_m * 1e3,
                    range(own) * 1e3,
                    other + 1,
                    went_m * 1e3
                )
            });
        }
        let (sent, went) = (centred(&self.command_m), centred(own));
        let together = dot(&sent, &went);
        (together < -0.5 * (dot(&sent, &sent) * dot(&went, &went)).sqrt()).then(|| {
            format!(
                "the displacement of actuator {} moves against its command: one of the two has the wrong polarity",
                moved + 1
            )
        })
    }

    fn exchanged_forces(&self, storeys_n_per_m: &[f64]) -> Option<String> {
        let storey = |floor: usize| storeys_n_per_m.get(floor).copied().unwrap_or(0.0);
        let declared = storey(self.moved) + storey(self.moved + 1);
        let answered = self.stiffness_n_per_m();
        let at = |j: usize| answered.get(j).copied().flatten().unwrap_or(0.0);
        let own = at(self.moved);
        let others = (0..answered.len()).filter(|j| *j != self.moved);
        let strongest = others.max_by(|a, b| at(*a).total_cmp(&at(*b)));
        if let Some(other) = strongest.filter(|j| at(*j) > (2.0 * own).max(CONNECTED * declared)) {
            return Some(format!(
                "while actuator {} was moved, its own force answered with {:.3} kN/mm and that of actuator {} with {:.3}: the \
                 load cells of the two look exchanged",
                self.moved + 1,
                own * 1e-6,
                other + 1,
                at(other) * 1e-6
            ));
        }
        (own < -CONNECTED * declared).then(|| {
            format!(
                "the force of actuator {} falls by {:.3} kN/mm where its displacement grows: one of the two has the wrong \
                 polarity, and a test would pump energy in",
                self.moved + 1,
                -own * 1e-6
            )
        })
    }
}

/// Least squares of a force on displacement and acceleration, all without their means.
fn stiffness(u: &[f64], a: &[f64], f: &[f64]) -> Option<f64> {
    let (uu, aa, ua) = (dot(u, u), dot(a, a), dot(u, a));
    let (uf, af, ff) = (dot(u, f), dot(a, f), dot(f, f));
    let determinant = uu * aa - ua * ua;
    // In a sine, acceleration is proportional to displacement: the fit then gives the stiffness less the inertia.
    let (k, m) = if determinant > 1e-3 * uu * aa {
        let k = (uf * aa - af * ua) / determinant;
        (k, (af * uu - uf * ua) / determinant)
    } else {
        (uf / uu, 0.0)
    };
    (k * uf + m * af > EXPLAINED * ff).then_some(k)
}

/// Weighted by the triangle that a second difference over `wing` steps applies to an acceleration: a relation between
/// displacement, acceleration and force also holds between all three when so smoothed.
fn smoothed(x: &[f64], wing: usize) -> Vec<f64> {
    let w = wing as isize;
    let weight = |j: isize| (w - j.abs()) as f64 / (w * w) as f64;
    let weights: Vec<f64> = (1 - w..w).map(weight).collect();
    (wing..x.len() - wing)
        .map(|i| dot(&x[i + 1 - wing..i + wing], &weights))
        .collect()
}

fn centred(x: &[f64]) -> Vec<f64> {
    let mean = x.iter().sum::<f64>() / x.len().max(1) as f64;
    x.iter().map(|x| x - mean).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn range(x: &[f64]) -> f64 {
    let ends = x.iter().fold((f64::MAX, f64::MIN), |(low, high), x| {
        (low.min(*x), high.max(*x))
    });
    (ends.1 - ends.0).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chirp of 5 mm from 0.5 to 10 Hz on a specimen of `k` N/m and `m` kg, with some noise.
    fn fitted(k: f64, m: f64, noise_n: f64) -> Option<f64> {
        let rate_hz = 2000.0;
        let phase = |t: f64| std::f64::consts::TAU * (0.5 * t + 9.5 * t * t / 20.0);
        let u: Vec<f64> = (0..20_000)
            .map(|i| 0.005 * phase(f64::from(i) / rate_hz).sin())
            .collect();
        let a = |i: usize| (u[i + 1] - 2.0 * u[i] + u[i - 1]) * rate_hz * rate_hz;
        let mut random = 1_u32;
        let mut noise = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            noise_n * (f64::from(random) / f64::from(u32::MAX) - 0.5)
        };
        let all = 1..u.len() - 1;
        let f = all.map(|i| k * u[i] + m * a(i) + noise()).collect();
        let readings = CrossReadings {
            moved: 0,
            rate_hz,
            least_m: 1e-4,
            command_m: u.clone(),
            displacement_m: vec![u[1..u.len() - 1].to_vec()],
            force_n: vec![f],
            railed: Vec::new(),
        };
        readings.stiffness_n_per_m()[0]
    }

    #[test]
    fn a_mass_on_the_head_is_no_negative_stiffness() {
        // Above 2 Hz the inertia is larger than the spring.
        for (k, m) in [(158e3, 1000.0), (158e3, 0.0), (-158e3, 0.0)] {
            let found = fitted(k, m, 20.0).unwrap();
            assert!((found / k - 1.0).abs() < 0.02, "{k} {m}: {found}");
        }
    }

    #[test]
    fn a_cell_on_which_nothing_hangs_has_not_answered() {
        assert_eq!(fitted(0.0, 0.0, 20.0), None);
    }
}
