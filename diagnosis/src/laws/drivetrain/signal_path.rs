//! The signal path from command to displacement, simulated: delay, valve and lag, second lag or oil column, dead band, play; and
//! the stops of the reading.

use super::part::{Part, PartKind};
use crate::numbers::operators::{dahl, dead_zone, heated, play, slew, stopped, stopped_slope};
use crate::numbers::signals::{delayed, lagged, resonant};

/// A record as used by the search; what precedes its first judged sample only sets the state.
#[derive(Clone, Debug)]
pub struct Run {
    /// Command, mm, with its run-up.
    pub command: Vec<f64>,
    /// Number of run-up samples.
    pub lead: usize,
    /// Measured displacement after the run-up, mm.
    pub target: Vec<f64>,
    /// Its unmeasured samples.
    pub unmeasured: Vec<usize>,
    /// Measured force, N, as long as the command; empty if there is none.
    pub force: Vec<f64>,
    /// Time of the first judged sample since the record began, s.
    pub from_s: f64,
}

/// The nonlinear parameters of a signal path.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalPath {
    /// Transport delay, s.
    pub delay_s: f64,
    /// First-order time constant, s.
    pub lag_s: f64,
    /// Its other parts.
    pub parts: Vec<Part>,
}

/// Least lag of a valve, in samples: one without lag would follow within the sample.
pub const LEAST_LAG: f64 = 0.3;
/// Largest substep of a valve's equation, as a fraction of its time constant.
const SUBSTEP: f64 = 0.25;
/// Largest number of substeps: a faster valve settles within a sample.
const MOST_SUBSTEPS: f64 = 16.0;

impl SignalPath {
    /// Columns of the displacement after the run-up: the response at gain 1, then one of amplitude 1 for each part that
    /// has an amplitude.
    pub fn columns(&self, run: &Run, interval_s: f64) -> Vec<Vec<f64>> {
        let late = delayed(&run.command, self.delay_s, interval_s);
        let mut y = self.valve(&late, interval_s);
        for part in &self.parts {
            let [a, b, c, _] = part.shapes;
            match part.kind {
                PartKind::SecondLag => y = lagged(&y, a, interval_s),
                PartKind::OilColumn => y = resonant(&y, a, [b, c], interval_s),
                _ => {}
            }
        }
        for part in self.parts.iter().filter(|p| p.kind == PartKind::Slew) {
            y = slew(&y, part.shapes[0] * interval_s);
        }
        // Parts that act at standstill come last, in the order of a drive.
        for part in &self.parts {
            match part.kind {
                PartKind::DeadBand => {
                    let [width, middle, ..] = part.shapes;
                    y = dead_zone(&y, [width, 0.0, middle]).collect();
                }
                PartKind::Play => y = play(&y, part.shapes[0]),
                _ => {}
            }
        }
        let own = |part: &Part| -> Option<Vec<f64>> {
            let [a, b, ..] = part.shapes;
            let growth = |i: usize| 1.0 - (-(run.from_s + i as f64 * interval_s) / a).exp();
            let judged = &y[run.lead..];
            Some(match part.kind {
                PartKind::Friction => dahl(&y, a, b)[run.lead..].iter().map(|z| -z).collect(),
                PartKind::Compliance if run.force.is_empty() => vec![0.0; judged.len()],
                PartKind::Compliance => run.force[run.lead..].iter().map(|f| -f).collect(),
                PartKind::SideGain => judged.iter().map(|y| 0.5 * y.abs()).collect(),
                PartKind::Drift => (0..judged.len()).map(growth).collect(),
                PartKind::GainDrift => {
                    let heat = heated(&y, a, interval_s).skip(run.lead);
                    let warms = judged.iter().zip(heat).enumerate();
                    warms
                        .map(|(i, (y, heat))| y * (growth(i) + b * heat))
                        .collect()
                }
                _ => return None,
            })
        };
        let more: Vec<Vec<f64>> = self.parts.iter().filter_map(own).collect();
        let mut columns = vec![y[run.lead..].to_vec()];
        columns.extend(more);
        columns
    }

    /// The stops of the reading: lower, upper, and how far their corners are rounded, mm.
    fn stops(&self) -> Option<[f64; 3]> {
        let stops = self.parts.iter().find(|p| p.kind == PartKind::Stops)?;
        let [low, high, round, _] = stops.shapes;
        Some([low, high, round])
    }

    /// A reading with everything before its stops, mm, as they let it pass.
    pub fn read(&self, mm: Vec<f64>) -> Vec<f64> {
        match self.stops() {
            Some(stops) => stopped(&mm, stops),
            None => mm,
        }
    }

    /// The fraction of a change that the stops let pass at each reading before them; `None` without stops.
    pub fn passes(&self, mm: &[f64]) -> Option<Vec<f64>> {
        Some(stopped_slope(mm, self.stops()?))
    }

    /// The oil that a valve lets in, w' = flow(u - x) / T, and the ram x driven by it; begins settled.
    pub fn valve(&self, input: &[f64], h: f64) -> Vec<f64> {
        let inside: Vec<Part> = self
            .parts
            .iter()
            .filter(|p| p.kind.is_inside())
            .copied()
            .collect();
        if inside.is_empty() {
            return lagged(input, self.lag_s, h);
        }
        let lag_s = self.lag_s.max(LEAST_LAG * h);
        let flow = Flow::new(&inside, lag_s);
        let seal = Seal::new(&inside);
        let substeps = (h / (SUBSTEP * lag_s)).ceil().clamp(1.0, MOST_SUBSTEPS);
        let dt = h / substeps;
        let mut ram = Ram::at(input[0]);
        let mut oil = input[0];
        let mut drawn = 0.0;
        let [sags, sag_s] = flow.sag;
        let mut out = Vec::with_capacity(input.len());
        out.push(ram.at_mm);
        for pair in input.windows(2) {
            let rise = (pair[1] - pair[0]) / substeps;
            for k in 0..substeps as usize {
                let u = pair[0] + rise * k as f64;
                // Midpoint rule.
                let begins = flow.at(u - ram.at_mm, ram.at_mm, sags * drawn);
                let half = seal.hold(ram, oil + 0.5 * dt * begins, 2.0 / dt);
                let speed = flow.at(u + 0.5 * rise - half.at_mm, half.at_mm, sags * drawn);
                oil += dt * speed;
                if sags > 0.0 {
                    drawn += dt / sag_s * (speed.abs() - drawn);
                }
                ram = seal.hold(ram, oil, 1.0 / dt);
            }
            out.push(ram.at_mm);
        }
        out
    }
}

/// A ram on the spring of its oil: the oil's lead over it is the compression by its seals' friction.
#[derive(Clone, Copy, Debug)]
struct Ram {
    at_mm: f64,
    mm_per_s: f64,
    /// Friction relative to its level in motion: elastic over the give, then sliding.
    stick: f64,
}

impl Ram {
    const fn at(at_mm: f64) -> Self {
        Self {
            at_mm,
            mm_per_s: 0.0,
            stick: 0.0,
        }
    }
}

/// Friction of a ram's seals.
#[derive(Clone, Copy, Debug)]
struct Seal {
    /// Compression of the oil by friction in motion, mm.
    bend_mm: f64,
    /// Increase of friction per lead of the oil while the seals stick, 1/mm.
    sticks_per_mm: f64,
    /// Friction at rest over that in motion, less 1, and one over the speed at which it falls, s/mm.
    falls: [f64; 2],
}

impl Seal {
    fn new(parts: &[Part]) -> Self {
        let seal = parts
            .iter()
            .find(|p| matches!(p.kind, PartKind::Seal | PartKind::StickySeal));
        let [bend_mm, yield_mm, at_rest, speed] = seal.map_or([0.0; 4], |p| p.shapes);
        Self {
            bend_mm,
            sticks_per_mm: 1.0 / (yield_mm + bend_mm).max(f64::MIN_POSITIVE),
            falls: [(at_rest - 1.0).max(0.0), 1.0 / speed.max(f64::MIN_POSITIVE)],
        }
    }

    /// Position of a ram whose oil has moved: held until the friction gives way.
    #[inline]
    fn hold(&self, ram: Ram, oil_mm: f64, per_s: f64) -> Ram {
        if self.bend_mm <= 0.0 {
            return Ram::at(oil_mm);
        }
        let lead = oil_mm - ram.at_mm - self.bend_mm * ram.stick;
        let [falls, per_speed] = self.falls;
        let most = if falls > 0.0 {
            1.0 + falls * (-(ram.mm_per_s * per_speed).powi(2)).exp()
        } else {
            1.0
        };
        let stick = (ram.stick + lead * self.sticks_per_mm).clamp(-most, most);
        let at_mm = oil_mm - self.bend_mm * stick;
        Ram {
            at_mm,
            mm_per_s: (at_mm - ram.at_mm) * per_s,
            stick,
        }
    }
}

/// The hyperbolic tangent of half of this is 1.
const MOST_EXPONENT: f64 = 100.0;

/// The flow through a valve.
#[derive(Clone, Copy, Debug)]
struct Flow {
    /// Closed up to this opening, mm.
    overlap_mm: f64,
    /// 1/mm.
    unequal_areas: f64,
    /// Speed one way over the mean speed, less 1.
    two_speeds: f64,
    /// Opening at which it saturates, mm; infinite if it does not.
    saturates_mm: f64,
    /// mm/s.
    most: f64,
    /// 1/mm.
    load: f64,
    /// Fraction of the supply taken per speed, s/mm, and its recovery time, s.
    sag: [f64; 2],
    per_lag: f64,
}

impl Flow {
    fn new(parts: &[Part], lag_s: f64) -> Self {
        let of = |kind, none: f64| {
            let part = parts.iter().find(|p| p.kind == kind);
            part.map_or(none, |p| p.shapes[0])
        };
        Self {
            overlap_mm: of(PartKind::Overlap, 0.0),
            unequal_areas: of(PartKind::UnequalAreas, 0.0),
            two_speeds: of(PartKind::TwoSpeeds, 0.0),
            saturates_mm: of(PartKind::FlowLimit, f64::INFINITY),
            most: of(PartKind::RateLimit, f64::INFINITY),
            load: of(PartKind::Load, 0.0),
            sag: parts
                .iter()
                .find(|p| p.kind == PartKind::Sag)
                .map_or([0.0, 1.0], |p| [p.shapes[0], p.shapes[1]]),
            per_lag: 1.0 / lag_s,
        }
    }

    /// Oil speed at an opening and a piston position, mm/s; `low`: missing fraction of the supply pressure.
    #[inline]
    fn at(&self, opening_mm: f64, at_mm: f64, low: f64) -> f64 {
        // What a valve does not have is skipped: this is called some ten million times for a record.
        let mut e = opening_mm;
        if self.overlap_mm > 0.0 {
            e -= e.clamp(-self.overlap_mm, self.overlap_mm);
        }
        if self.unequal_areas != 0.0 {
            e *= (1.0 + self.unequal_areas * e).max(0.1);
        }
        if self.two_speeds != 0.0 {
            e += self.two_speeds * e.abs();
        }
        if self.load > 0.0 || low > 0.0 {
            e *= (1.0 - low - self.load * at_mm * e.signum())
                .max(0.01)
                .sqrt();
        }
        if self.saturates_mm.is_finite() {
            // The hyperbolic tangent by one exponential, which dominates the computing time.
            let grown = (2.0 * e / self.saturates_mm).min(MOST_EXPONENT).exp();
            e = self.saturates_mm * (1.0 - 2.0 / (grown + 1.0));
        }
        (e * self.per_lag).clamp(-self.most, self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::drivetrain::part::shapes;

    fn run(command: Vec<f64>) -> Run {
        Run {
            target: command.clone(),
            unmeasured: Vec::new(),
            command,
            lead: 0,
            force: Vec::new(),
            from_s: 0.0,
        }
    }

    fn answer(parts: &[(PartKind, f64)], command: Vec<f64>) -> Vec<f64> {
        let parts = parts
            .iter()
            .map(|&(kind, shape)| Part {
                kind,
                shapes: shapes([shape]),
            })
            .collect();
        let path = SignalPath {
            delay_s: 0.0,
            lag_s: 0.02,
            parts,
        };
        path.columns(&run(command), 1e-3).swap_remove(0)
    }

    #[test]
    fn a_step_through_each_valve_is_what_its_equation_says() {
        let step: Vec<f64> = (0..400).map(|i| if i == 0 { 0.0 } else { 1.0 }).collect();
        // Unequal areas: e' = -(e + b e^2) / T is solved by e = c / (1 - b c) with c = C exp(-t/T), here from the fifth
        // sample on.
        let b = 0.5;
        let y = answer(&[(PartKind::UnequalAreas, b)], step.clone());
        let from = (1.0 - y[5]) / (1.0 + b * (1.0 - y[5]));
        for (i, y) in y.iter().enumerate().skip(5).step_by(10) {
            let c = from * (-(i as f64 - 5.0) * 1e-3 / 0.02).exp();
            assert!((1.0 - y - c / (1.0 - b * c)).abs() < 1e-3, "{i}");
        }
        // A single rod pushes faster than it pulls: 1 + r and 1 - r times the lag's rate.
        let back: Vec<f64> = step.iter().map(|u| -u).collect();
        for (input, sign, rate) in [(step.clone(), 1.0, 1.5), (back, -1.0, 0.5)] {
            let y = answer(&[(PartKind::TwoSpeeds, 0.5)], input);
            let left = |i: usize| 1.0 - sign * y[i];
            assert!((left(25) / left(5) - (-rate * 0.02_f64 / 0.02).exp()).abs() < 1e-3);
        }
        // An overlap leaves its width; a largest speed is kept.
        let y = answer(&[(PartKind::Overlap, 0.2)], step.clone());
        assert!((y[399] - 0.8).abs() < 1e-3);
        let y = answer(&[(PartKind::RateLimit, 5.0)], step);
        assert!((y[100] - y[50] - 0.25).abs() < 1e-9);
    }

    #[test]
    fn a_ram_waits_until_the_oil_is_bent_by_its_friction_and_then_follows_as_without() {
        let path = |kind, all| SignalPath {
            delay_s: 0.0,
            lag_s: 0.02,
            parts: vec![Part { kind, shapes: all }],
        };
        let step = vec![1.0; 400];
        let x = |path: SignalPath| {
            let mut input = step.clone();
            input[0] = 0.0;
            path.valve(&input, 1e-3)
        };
        // The oil is let in at 1 mm in T: bent by b after b T.
        let b = 0.2;
        let y = x(path(PartKind::Seal, shapes([b, 1e-4])));
        let begins_s = 0.5e-3 + b * 0.02;
        for (i, y) in y.iter().enumerate().skip(10).step_by(10) {
            let exact = 1.0 - (-(1e-3 * i as f64 - begins_s) / 0.02).exp();
            assert!((y - exact).abs() < 4e-3, "{i}: {y} {exact}");
        }
        // Stiction waits longer.
        let sticky = x(path(PartKind::StickySeal, shapes([b, 1e-4, 2.0, 10.0])));
        assert!(sticky[7] < 0.01 && y[7] > 0.1);
    }

    #[test]
    fn a_valve_without_any_part_is_a_lag() {
        let wave: Vec<f64> = (0..2000).map(|i| (0.02 * f64::from(i)).sin()).collect();
        let plain = answer(&[], wave.clone());
        let wide = answer(&[(PartKind::FlowLimit, 1e4)], wave);
        // The midpoint rule is off by (h / T)^2 / 6 of the opening, of 0.4 mm here.
        for (a, b) in plain.iter().zip(&wide) {
            assert!((a - b).abs() < 0.4 * (1e-3_f64 / 0.02).powi(2) / 6.0);
        }
    }
}
