//! Least-squares fit of a signal path to records, by simulated displacement, and its performance on left-out data.

use crate::criteria::REACH;
use crate::engine::score::{BLOCKS, edges};
use crate::laws::drivetrain::part::{ActuatorScales, Part, PartKind};
use crate::laws::drivetrain::signal_path::{Run, SignalPath};
use crate::model::base::Base;
use crate::numbers::linear::{Bound, Factor, Normal, dot, gram, solve, stacked};
use crate::numbers::signals::{add_columns, clear, difference, difference_quotient};
use nalgebra::DVector;

/// The declared parameters: gain, delay, lag, offset.
pub const DECLARED: usize = 4;
/// Delay and lag.
const TIMING: [usize; 2] = [1, 2];
/// Largest number of linear steps of a fit.
const STEPS: usize = 10;
/// Relative decrease of the squares that is not worth another step.
const SETTLED: f64 = 1e-3;
/// Fraction of a column's squares in a block from which no other block shows it: a stop that is reached once.
const ONLY_HERE: f64 = 0.999;
/// Longest free delay or lag, s; at most a fifth of the record.
const LONGEST_S: f64 = 0.5;

/// Records, with their declared model.
#[derive(Debug)]
pub struct ActuatorData<'a> {
    pub runs: Vec<Run>,
    pub interval_s: f64,
    pub sizes: ActuatorScales,
    pub base: &'a Base,
    /// First sample of each block, and the end, over all segments.
    edges: Vec<usize>,
    /// Measured displacement, segment after segment.
    pub target: Vec<f64>,
    /// Its unmeasured samples.
    unmeasured: Vec<usize>,
}

/// A model: parts, and which declared parameters may leave their tolerances.
#[derive(Clone, Debug, PartialEq)]
pub struct PartSet {
    pub parts: Vec<Part>,
    pub moved: [bool; DECLARED],
}

impl PartSet {
    /// Only the declared parameters, within their tolerances.
    pub const fn held() -> Self {
        Self {
            parts: Vec::new(),
            moved: [false; DECLARED],
        }
    }

    /// Number of parts, and of parameters that may leave their tolerances.
    pub fn size(&self) -> usize {
        self.parts.len() + self.moved.iter().filter(|m| **m).count()
    }

    /// The models with one higher-order feature less: a second lag, an oil column, a freed delay or lag.
    pub fn without_each_of_order(&self) -> Vec<Self> {
        let mut all = Vec::new();
        for i in 0..self.parts.len() {
            if self.parts[i].kind.is_order() {
                let mut fewer = self.clone();
                fewer.parts.remove(i);
                all.push(fewer);
            }
        }
        for i in TIMING {
            if self.moved[i] {
                let mut fewer = self.clone();
                fewer.moved[i] = false;
                all.push(fewer);
            }
        }
        all
    }
}

/// A fitted model.
#[derive(Clone, Debug)]
pub struct ActuatorFit {
    pub model: PartSet,
    /// Gain, delay s, lag s, offset mm.
    pub declared: [f64; DECLARED],
    /// One for each part with an amplitude, in their order.
    pub amplitudes: Vec<f64>,
    /// Residual sum of squares.
    pub cost: f64,
    /// Measured minus modelled.
    pub residual: Vec<f64>,
    /// Change of the response with everything that is not at a bound.
    pub slopes: Vec<Vec<f64>>,
}

/// The present values of what a fit moves.
#[derive(Clone, Debug)]
struct Place {
    declared: [f64; DECLARED],
    amplitudes: Vec<f64>,
    parts: Vec<Part>,
}

impl Place {
    fn path(&self) -> SignalPath {
        SignalPath {
            delay_s: self.declared[1],
            lag_s: self.declared[2],
            parts: self.parts.clone(),
        }
    }

    /// After a step of declared parameters, amplitudes and shapes.
    fn moved_by(&self, step: &DVector<f64>) -> Self {
        let mut next = self.clone();
        let unknowns = next.declared.iter_mut().chain(&mut next.amplitudes);
        let shapes = next.parts.iter_mut().flat_map(|p| {
            let own = p.kind.shapes();
            p.shapes.iter_mut().take(own)
        });
        for (unknown, step) in unknowns.chain(shapes).zip(step.iter()) {
            *unknown += step;
        }
        next
    }
}

impl<'a> ActuatorData<'a> {
    pub fn new(runs: Vec<Run>, interval_s: f64, base: &'a Base) -> Self {
        let target: Vec<f64> = runs.iter().flat_map(|r| r.target.clone()).collect();
        let n = target.len();
        let mut unmeasured = Vec::new();
        let mut from = 0;
        for run in &runs {
            unmeasured.extend(run.unmeasured.iter().map(|i| from + i));
            from += run.target.len();
        }
        let ends = target
            .iter()
            .fold([f64::MAX, f64::MIN], |[l, h], x| [l.min(*x), h.max(*x)]);
        let apart = |r: &Run, i: usize| {
            let last = r.target.len() - 1;
            let (from, to) = (i.saturating_sub(2), (i + 2).min(last));
            (r.target[to] - r.target[from]).abs() / ((to - from).max(1) as f64 * interval_s)
        };
        let speeds = runs
            .iter()
            .flat_map(|r| (0..r.target.len()).map(|i| apart(r, i)));
        let speeds: Vec<f64> = speeds.collect();
        let openings = runs.iter().flat_map(|r| {
            let command = r.command[r.lead..].iter();
            command.zip(&r.target).map(|(u, x)| base.values[0] * u - x)
        });
        let mut openings: Vec<f64> = openings.collect();
        let mean = openings.iter().sum::<f64>() / n as f64;
        openings.iter_mut().for_each(|e| *e = (*e - mean).abs());
        openings.sort_by(f64::total_cmp);
        let tiny = 1e-9 * (ends[1] - ends[0]).max(f64::MIN_POSITIVE);
        let sizes = ActuatorScales {
            x_mm: 0.5 * (ends[1] - ends[0]),
            speed_mm_per_s: speeds.iter().copied().fold(tiny, f64::max),
            opening_mm: openings[(n as f64 * 0.98) as usize].max(tiny),
            interval_s,
            seconds: n as f64 * interval_s / runs.len() as f64,
            ends_mm: ends,
        };
        Self {
            runs,
            interval_s,
            sizes,
            base,
            edges: edges(&speeds),
            target,
            unmeasured,
        }
    }

    /// True if all records have a force, to which the rig may give way.
    pub fn has_force(&self) -> bool {
        self.runs.iter().all(|r| !r.force.is_empty())
    }

    /// All columns, segment by segment: the response at gain 1, then one per amplitude.
    fn columns(&self, path: &SignalPath) -> Vec<Vec<f64>> {
        stacked(
            self.runs
                .iter()
                .map(|run| path.columns(run, self.interval_s)),
        )
    }

    /// Bounds of a declared parameter, in its unit here (s, mm).
    fn bound(&self, which: usize, moved: bool) -> [f64; 2] {
        let unit = if matches!(which, 1 | 2) { 1e-3 } else { 1.0 };
        let value = self.base.values[which] * unit;
        if moved {
            return match which {
                1 | 2 => [0.0, LONGEST_S.min(0.2 * self.sizes.seconds)],
                _ => [f64::NEG_INFINITY, f64::INFINITY],
            };
        }
        let free = self.base.free.iter().find(|f| f.index == which);
        let reach = free.map_or(0.0, |f| REACH * f.tolerance * unit);
        let low = value - reach;
        [
            if matches!(which, 1 | 2) {
                low.max(0.0)
            } else {
                low
            },
            value + reach,
        ]
    }

    /// Gain, delay s, lag s and offset as declared.
    pub fn declared_values(&self) -> [f64; DECLARED] {
        let v = self.base.values;
        [v[0], 1e-3 * v[1], 1e-3 * v[2], v[3]]
    }

    /// Number of samples of each block.
    pub fn block_samples(&self) -> [f64; BLOCKS] {
        std::array::from_fn(|b| (self.edges[b + 1] - self.edges[b]) as f64)
    }

    /// Squares on each block.
    pub fn squares(&self, residual: &[f64]) -> [f64; BLOCKS] {
        std::array::from_fn(|b| {
            let part = &residual[self.edges[b]..self.edges[b + 1]];
            dot(part, part)
        })
    }

    /// The signal path of a fit.
    pub fn path(&self, fit: &ActuatorFit) -> SignalPath {
        SignalPath {
            delay_s: fit.declared[1],
            lag_s: fit.declared[2],
            parts: fit.model.parts.clone(),
        }
    }

    /// Change of a fit's response if a part is added: the column of a step towards it.
    pub fn change(&self, fit: &ActuatorFit, more: Part) -> Vec<f64> {
        let mut path = self.path(fit);
        path.parts.push(more);
        let mut columns = self.columns(&path);
        if more.kind.is_column() {
            let mut own = columns.pop().unwrap_or_default();
            if let Some(passes) =
                path.passes(&self.combined(&columns, &fit.declared, &fit.amplitudes))
            {
                own.iter_mut().zip(passes).for_each(|(x, p)| *x *= p);
            }
            clear(&mut own, &self.unmeasured);
            return own;
        }
        let mut y = path.read(self.combined(&columns, &fit.declared, &fit.amplitudes));
        for ((y, t), r) in y.iter_mut().zip(&self.target).zip(&fit.residual) {
            *y -= t - r;
        }
        clear(&mut y, &self.unmeasured);
        y
    }

    fn combined(
        &self,
        columns: &[Vec<f64>],
        declared: &[f64; DECLARED],
        amplitudes: &[f64],
    ) -> Vec<f64> {
        let mut y: Vec<f64> = columns[0]
            .iter()
            .map(|c| declared[0] * c + declared[3])
            .collect();
        add_columns(&mut y, &columns[1..], amplitudes, 1.0);
        y
    }

    /// Measured minus modelled; 0 where nothing was measured.
    fn left(&self, modelled: &[f64]) -> Vec<f64> {
        let mut left = difference(&self.target, modelled);
        clear(&mut left, &self.unmeasured);
        left
    }

    /// Residual of a fit on these records, which may differ from those that it was fitted to.
    pub fn residual(&self, fit: &ActuatorFit) -> Vec<f64> {
        let path = self.path(fit);
        let y = self.combined(&self.columns(&path), &fit.declared, &fit.amplitudes);
        self.left(&path.read(y))
    }

    /// Splits a residual of all records by record.
    pub fn by_record(&self, residual: &[f64]) -> Vec<Vec<f64>> {
        let mut from = 0;
        let part = |run: &Run| {
            from += run.target.len();
            residual[from - run.target.len()..from].to_vec()
        };
        self.runs.iter().map(part).collect()
    }

    /// Fits the model from `start`, which may have fewer parts; `None` if the equations have no solution.
    pub fn fit(&self, model: &PartSet, start: [f64; DECLARED]) -> Option<ActuatorFit> {
        let within = |i: usize| {
            let [low, high] = self.bound(i, model.moved[i]);
            start[i].clamp(low, high)
        };
        let columned = model.parts.iter().filter(|p| p.kind.is_column());
        let mut at = Place {
            declared: std::array::from_fn(within),
            amplitudes: vec![0.0; columned.count()],
            parts: model.parts.clone(),
        };
        let mut damping = 1e-6;
        let mut last: Option<ActuatorFit> = None;
        let mut columns = self.columns(&at.path());
        for _ in 0..STEPS {
            let here = self.linearized(model, &at, &columns);
            let (cost, bounds) = (here.cost, self.room(model, &at));
            let normal = Normal {
                matrix: gram(&here.slopes),
                right: DVector::from_fn(here.slopes.len(), |i, _| {
                    dot(&here.slopes[i], &here.residual)
                }),
                square: cost,
            };
            last = Some(here);
            let mut moved = false;
            for _ in 0..5 {
                let mut damped = normal.clone();
                for i in 0..damped.right.len() {
                    damped.matrix[(i, i)] *= 1.0 + damping;
                    damped.matrix[(i, i)] += f64::MIN_POSITIVE;
                }
                let (step, _) = solve(&damped, &bounds)?;
                let next = at.moved_by(&step);
                let path = next.path();
                let there = self.columns(&path);
                let y = self.combined(&there, &next.declared, &next.amplitudes);
                let left = self.left(&path.read(y));
                let square = dot(&left, &left);
                if square < cost {
                    (at, columns) = (next, there);
                    moved = cost - square > SETTLED * cost;
                    damping = (damping * 0.1).max(1e-9);
                    break;
                }
                damping = (damping * 30.0).max(1e-4);
            }
            if !moved {
                break;
            }
        }
        let mut fit = last.filter(|f| f.cost.is_finite())?;
        fit.model
            .parts
            .iter_mut()
            .for_each(|p| self.mirror_a_stop(p));
        Some(fit)
    }

    /// A stop that the records do not reach is taken to be as far from zero as the other: an amplifier's range is.
    fn mirror_a_stop(&self, part: &mut Part) {
        let ([low, high, ..], [least, most]) = (part.shapes, self.sizes.ends_mm);
        if part.kind != PartKind::Stops {
            return;
        }
        if low < least && -high < least {
            part.shapes[0] = -high;
        }
        if high > most && -low > most {
            part.shapes[1] = -low;
        }
    }

    /// The model at these values and columns, with its slopes there.
    fn linearized(&self, model: &PartSet, at: &Place, columns: &[Vec<f64>]) -> ActuatorFit {
        let path = at.path();
        let before_stops = self.combined(columns, &at.declared, &at.amplitudes);
        let passes = path.passes(&before_stops);
        let y = path.read(before_stops);
        let residual = self.left(&y);
        ActuatorFit {
            slopes: self.slopes(&path, columns, [&y, &passes.unwrap_or_default()], at),
            model: PartSet {
                parts: at.parts.clone(),
                moved: model.moved,
            },
            declared: at.declared,
            amplitudes: at.amplitudes.clone(),
            cost: dot(&residual, &residual),
            residual,
        }
    }

    /// Range of each unknown from its present value.
    fn room(&self, model: &PartSet, at: &Place) -> Vec<Bound> {
        let declared = (0..DECLARED).map(|i| {
            let [low, high] = self.bound(i, model.moved[i]);
            Bound { low, high }.from(at.declared[i])
        });
        let columned = at.parts.iter().filter(|p| p.kind.is_column());
        let amplitudes = columned.zip(&at.amplitudes).map(|(p, a)| {
            let bound = match p.kind.is_positive() {
                true => Bound::POSITIVE,
                false => Bound::FREE,
            };
            bound.from(*a)
        });
        let shapes = at.parts.iter().flat_map(|p| {
            (0..p.kind.shapes()).map(|i| {
                let [low, high] = p.kind.bounds(i, &self.sizes);
                // Not all the way at once: the response to a shape is nonlinear.
                let least = 0.02 * (high - low).min(self.sizes.x_mm);
                let step = 0.5 * p.shapes[i].abs().max(least);
                step_within([low, high], p.shapes[i], step)
            })
        });
        declared.chain(amplitudes).chain(shapes).collect()
    }

    /// Change of the reading `y` with declared parameters, amplitudes and shapes; `passes`: the fraction of what changes before
    /// the stops that they let pass, empty without stops.
    fn slopes(
        &self,
        path: &SignalPath,
        columns: &[Vec<f64>],
        [y, passes]: [&[f64]; 2],
        at: &Place,
    ) -> Vec<Vec<f64>> {
        let apart = |path: &SignalPath, step: f64| -> Vec<f64> {
            let moved = self.combined(&self.columns(path), &at.declared, &at.amplitudes);
            difference_quotient(&path.read(moved), y, step)
        };
        // What is added before the stops passes them or not.
        let passed = |mut column: Vec<f64>| {
            column.iter_mut().zip(passes).for_each(|(x, p)| *x *= p);
            column
        };
        let timed = 0.05 * self.interval_s;
        let mut late = path.clone();
        late.delay_s += timed;
        let mut slow = path.clone();
        slow.lag_s += timed;
        let mut slopes = vec![
            passed(columns[0].clone()),
            apart(&late, timed),
            apart(&slow, timed),
            passed(vec![1.0; y.len()]),
        ];
        slopes.extend(columns[1..].iter().cloned().map(passed));
        for (p, part) in path.parts.iter().enumerate() {
            for i in 0..part.kind.shapes() {
                let step = part.kind.step(i, &self.sizes);
                let mut moved = path.clone();
                moved.parts[p].shapes[i] += step;
                slopes.push(apart(&moved, step));
            }
        }
        slopes.iter_mut().for_each(|s| clear(s, &self.unmeasured));
        slopes
    }

    /// Squares on each block for the fit without that block, to first order; parameters at a bound stay there.
    pub fn cross_validated(&self, fit: &ActuatorFit) -> Option<[f64; BLOCKS]> {
        let columns = self.free_slopes(fit);
        if columns.is_empty() {
            return Some(self.squares(&fit.residual));
        }
        let whole = gram(&columns);
        let mut out = [0.0; BLOCKS];
        for (b, out) in out.iter_mut().enumerate() {
            let (from, end) = (self.edges[b], self.edges[b + 1]);
            let of_block = |s: &[f64]| dot(&s[from..end], &s[from..end]);
            // What only this block shows cannot be judged by the others.
            let shown = |i: &usize| of_block(&columns[*i]) < ONLY_HERE * whole[(*i, *i)];
            let shown: Vec<usize> = (0..columns.len()).filter(shown).collect();
            if shown.is_empty() {
                *out = dot(&fit.residual[from..end], &fit.residual[from..end]);
                continue;
            }
            let part: Vec<Vec<f64>> = shown
                .iter()
                .map(|i| columns[*i][from..end].to_vec())
                .collect();
            let whole = whole.select_rows(&shown).select_columns(&shown);
            let mut matrix = &whole - gram(&part);
            for i in 0..matrix.nrows() {
                matrix[(i, i)] += 1e-9 * whole[(i, i)];
            }
            // Without the block, the sum of slopes times residuals lacks the block's part.
            let mut left = fit.residual[from..end].to_vec();
            Factor::of(matrix)?.add_regression(&part, &mut left, 1.0);
            *out = dot(&left, &left);
        }
        Some(out)
    }

    /// Slopes of the free quantities: those neither at a bound nor held at one value.
    pub fn free_slopes(&self, fit: &ActuatorFit) -> Vec<Vec<f64>> {
        let inside = |value: f64, [low, high]: [f64; 2]| {
            let room = 1e-9 * (high - low).clamp(0.0, 1e6);
            value > low + room && value < high - room
        };
        let mut values: Vec<bool> = (0..DECLARED)
            .map(|i| inside(fit.declared[i], self.bound(i, fit.model.moved[i])))
            .collect();
        let columned = fit.model.parts.iter().filter(|p| p.kind.is_column());
        for (p, a) in columned.zip(&fit.amplitudes) {
            values.push(!p.kind.is_positive() || *a > 0.0);
        }
        for p in &fit.model.parts {
            values.extend(
                (0..p.kind.shapes()).map(|i| inside(p.shapes[i], p.kind.bounds(i, &self.sizes))),
            );
        }
        fit.slopes
            .iter()
            .zip(values)
            .filter(|(_, free)| *free)
            .map(|(s, _)| s.clone())
            .collect()
    }
}

/// Range of a step of a shape towards its bounds or within them: a search starts outside if a record is slower than its
/// grid covers.
fn step_within(bounds: [f64; 2], shape: f64, most: f64) -> Bound {
    let [low, high] = bounds.map(|edge| (edge - shape).clamp(-most, most));
    Bound {
        low: low.min(high),
        high,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shape_goes_towards_its_bounds_by_no_more_than_a_step() {
        let reach = |shape: f64, most: f64| {
            let Bound { low, high } = step_within([0.1, 0.5], shape, most);
            [low, high]
        };
        assert_eq!(reach(0.25, 1.0), [-0.15, 0.25]);
        assert_eq!(reach(0.25, 0.125), [-0.125, 0.125]);
        // From far outside it returns step by step.
        assert_eq!(reach(1.12, 0.25), [-0.25, -0.25]);
        assert_eq!(reach(-1.0, 0.25), [0.25, 0.25]);
        let inverted = step_within([0.5, 0.1], 0.3, 1.0);
        assert!(inverted.low <= inverted.high);
    }
}
