//! The way from command to displacement, simulated: delay, valve and lag, second lag or oil column, dead band, play, stops.

use super::part::{Kind, Part};
use crate::library::operators::{dead_zone, friction, play};
use crate::signals::{delayed, lagged, resonant};

/// A record as the search sees it; what comes before its first judged sample only sets the state.
#[derive(Clone, Debug)]
pub struct Run {
    /// Command, mm, with its run-up.
    pub command: Vec<f64>,
    /// Samples of run-up.
    pub lead: usize,
    /// So many of them are the record's own first ones.
    pub skipped: usize,
    /// Measured displacement behind the run-up, mm.
    pub target: Vec<f64>,
    /// Measured force, N, as long as the command; empty where there is none.
    pub force: Vec<f64>,
    /// Time of the first judged sample since the record began, s.
    pub from_s: f64,
}

/// The nonlinear parameters of a way.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// Transport delay, s.
    pub delay_s: f64,
    /// First-order time constant, s.
    pub lag_s: f64,
    /// What else is on it.
    pub parts: Vec<Part>,
}

/// Substeps of a valve's equation are no longer than this share of its time constant.
const SUBSTEP: f64 = 0.25;
/// No more substeps than these: a faster valve is over within a sample.
const MOST_SUBSTEPS: f64 = 16.0;

impl Way {
    /// Columns of the displacement behind the run-up: the answer at gain 1, then one of amplitude 1 for each part that has
    /// an amplitude.
    pub fn columns(&self, run: &Run, interval_s: f64) -> Vec<Vec<f64>> {
        let late = delayed(&run.command, self.delay_s, interval_s);
        let mut y = self.valve(&late, interval_s);
        for part in &self.parts {
            let [a, b, ..] = part.shapes;
            match part.kind {
                Kind::SecondLag => y = lagged(&y, a, interval_s),
                Kind::OilColumn => y = resonant(&y, a, b, interval_s),
                _ => {}
            }
        }
        // What acts at standstill comes last, in the order of a drive.
        for part in &self.parts {
            match part.kind {
                Kind::DeadBand => y = dead_zone(&y, part.shapes[0]).collect(),
                Kind::Play => y = play(&y, part.shapes[0]),
                _ => {}
            }
        }
        for part in self.parts.iter().filter(|p| p.kind == Kind::Stops) {
            let [low, high, ..] = part.shapes;
            y.iter_mut().for_each(|y| *y = y.min(high).max(low));
        }
        let own = |part: &Part| -> Option<Vec<f64>> {
            let a = part.shapes[0];
            let growth = |i: usize| 1.0 - (-(run.from_s + i as f64 * interval_s) / a).exp();
            let judged = &y[run.lead..];
            Some(match part.kind {
                Kind::Friction => friction(&y, a)[run.lead..].iter().map(|z| -z).collect(),
                Kind::Compliance if run.force.is_empty() => vec![0.0; judged.len()],
                Kind::Compliance => run.force[run.lead..].iter().map(|f| -f).collect(),
                Kind::SideGain => judged.iter().map(|y| 0.5 * y.abs()).collect(),
                Kind::Drift => (0..judged.len()).map(growth).collect(),
                Kind::GainDrift => judged
                    .iter()
                    .enumerate()
                    .map(|(i, y)| y * growth(i))
                    .collect(),
                _ => return None,
            })
        };
        let more: Vec<Vec<f64>> = self.parts.iter().filter_map(own).collect();
        let mut columns = vec![y[run.lead..].to_vec()];
        columns.extend(more);
        columns
    }

    /// The oil that a valve lets in, w' = flow(u - x) / T, and the ram x behind it; begins settled.
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
        // A valve without a lag of its own would follow within the sample.
        let lag_s = self.lag_s.max(0.3 * h);
        let speed = |e: f64| flow(&inside, e, lag_s);
        let substeps = (h / (SUBSTEP * lag_s)).ceil().clamp(1.0, MOST_SUBSTEPS);
        let dt = h / substeps;
        let mut ram = Ram::new(&inside, input[0]);
        let mut oil = input[0];
        let mut out = Vec::with_capacity(input.len());
        out.push(ram.at);
        for pair in input.windows(2) {
            let rise = (pair[1] - pair[0]) / substeps;
            for k in 0..substeps as usize {
                let u = pair[0] + rise * k as f64;
                // Midpoint rule.
                let mut half = ram;
                half.follow(oil + 0.5 * dt * speed(u - ram.at), 0.5 * dt);
                oil += dt * speed(u + 0.5 * rise - half.at);
                ram.follow(oil, dt);
            }
            out.push(ram.at);
        }
        out
    }
}

/// A ram on the spring of its oil, held by the friction of its seals: what the oil is ahead of it is what friction bends
/// the oil by.
#[derive(Clone, Copy, Debug)]
struct Ram {
    /// Place, mm.
    at: f64,
    /// Friction over its level in motion: elastic over the give, then it slides.
    stick: f64,
    speed: f64,
    /// What friction in motion bends the oil by, mm.
    bend: f64,
    give: f64,
    /// Friction at rest over that in motion, less 1, and the speed at which it falls, mm/s.
    falls: [f64; 2],
}

impl Ram {
    fn new(parts: &[Part], at: f64) -> Self {
        let seal = parts
            .iter()
            .find(|p| matches!(p.kind, Kind::Seal | Kind::StickySeal));
        let [bend, give, at_rest, speed] = seal.map_or([0.0; 4], |p| p.shapes);
        Self {
            at,
            stick: 0.0,
            speed: 0.0,
            bend,
            give,
            falls: [(at_rest - 1.0).max(0.0), speed.max(f64::MIN_POSITIVE)],
        }
    }

    /// Moves until its friction holds the spring of the oil, which is at a place after a time.
    fn follow(&mut self, oil: f64, dt: f64) {
        if self.bend <= 0.0 {
            self.at = oil;
            return;
        }
        let pull = oil - self.at - self.bend * self.stick;
        let sticks = pull / (1.0 + self.bend / self.give);
        let [falls, speed] = self.falls;
        let most = 1.0 + falls * (-(self.speed / speed).powi(2)).exp();
        let stick = (self.stick + sticks / self.give).clamp(-most, most);
        let at = oil - self.bend * stick;
        self.speed = (at - self.at) / dt;
        (self.at, self.stick) = (at, stick);
    }
}

/// Speed of a cylinder behind a valve that is open by `e`, mm/s.
fn flow(parts: &[Part], e: f64, lag_s: f64) -> f64 {
    let mut e = e;
    let mut most = f64::INFINITY;
    for part in parts {
        let a = part.shapes[0];
        match part.kind {
            Kind::Overlap => e -= e.clamp(-a, a),
            Kind::UnequalAreas => e *= (1.0 + a * e).max(0.1),
            Kind::FlowLimit => e = a * (e / a).tanh(),
            Kind::RateLimit => most = a,
            _ => {}
        }
    }
    (e / lag_s).clamp(-most, most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drivetrain::part::shapes;

    fn run(command: Vec<f64>) -> Run {
        Run {
            target: command.clone(),
            command,
            lead: 0,
            skipped: 0,
            force: Vec::new(),
            from_s: 0.0,
        }
    }

    fn answer(parts: &[(Kind, f64)], command: Vec<f64>) -> Vec<f64> {
        let parts = parts
            .iter()
            .map(|&(kind, shape)| Part {
                kind,
                shapes: shapes([shape]),
            })
            .collect();
        let way = Way {
            delay_s: 0.0,
            lag_s: 0.02,
            parts,
        };
        way.columns(&run(command), 1e-3).swap_remove(0)
    }

    #[test]
    fn a_step_through_each_valve_is_what_its_equation_says() {
        let step: Vec<f64> = (0..400).map(|i| if i == 0 { 0.0 } else { 1.0 }).collect();
        // Unequal areas: e' = -(e + b e^2) / T is solved by e = c / (1 - b c) with c = C exp(-t/T), here from the fifth
        // sample on.
        let b = 0.5;
        let y = answer(&[(Kind::UnequalAreas, b)], step.clone());
        let from = (1.0 - y[5]) / (1.0 + b * (1.0 - y[5]));
        for (i, y) in y.iter().enumerate().skip(5).step_by(10) {
            let c = from * (-(i as f64 - 5.0) * 1e-3 / 0.02).exp();
            assert!((1.0 - y - c / (1.0 - b * c)).abs() < 1e-3, "{i}");
        }
        // An overlap leaves its width; a largest speed is kept.
        let y = answer(&[(Kind::Overlap, 0.2)], step.clone());
        assert!((y[399] - 0.8).abs() < 1e-3);
        let y = answer(&[(Kind::RateLimit, 5.0)], step);
        assert!((y[100] - y[50] - 0.25).abs() < 1e-9);
    }

    #[test]
    fn a_ram_waits_until_the_oil_is_bent_by_its_friction_and_then_follows_as_without() {
        let way = |kind, all| Way {
            delay_s: 0.0,
            lag_s: 0.02,
            parts: vec![Part { kind, shapes: all }],
        };
        let step = vec![1.0; 400];
        let x = |way: Way| {
            let mut input = step.clone();
            input[0] = 0.0;
            way.valve(&input, 1e-3)
        };
        // The oil is let in at 1 mm in T: bent by b after b T.
        let b = 0.2;
        let y = x(way(Kind::Seal, shapes([b, 1e-4])));
        let begins_s = 0.5e-3 + b * 0.02;
        for (i, y) in y.iter().enumerate().skip(10).step_by(10) {
            let exact = 1.0 - (-(1e-3 * i as f64 - begins_s) / 0.02).exp();
            assert!((y - exact).abs() < 4e-3, "{i}: {y} {exact}");
        }
        // What sticks at rest waits longer.
        let sticky = x(way(Kind::StickySeal, shapes([b, 1e-4, 2.0, 10.0])));
        assert!(sticky[7] < 0.01 && y[7] > 0.1);
    }

    #[test]
    fn a_valve_without_any_part_is_a_lag() {
        let wave: Vec<f64> = (0..2000).map(|i| (0.02 * f64::from(i)).sin()).collect();
        let plain = answer(&[], wave.clone());
        let wide = answer(&[(Kind::FlowLimit, 1e4)], wave);
        // The midpoint rule is off by (h / T)^2 / 6 of the opening, of 0.4 mm here.
        for (a, b) in plain.iter().zip(&wide) {
            assert!((a - b).abs() < 0.4 * (1e-3_f64 / 0.02).powi(2) / 6.0);
        }
    }
}
