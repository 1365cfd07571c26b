//! A specimen's channel for the engine: its training data as columns, and a fitted model of it.

use super::cutoff;
use super::gram::{Grams, Tie};
use super::law::table;
use super::motion::{Motion, sizes};
use super::row::{Form, PointOfAction, Row, Sizes};
use super::score::{Evidence, Score, edges};
use super::search::{Atom, DECLARED, Search};
use crate::criteria::CUTOFF_ROOM;
use crate::laws::library::candidate::NamedValue;
use crate::laws::specimen::track::{MotionScales, Track, UnfilteredSpan, thinning};
use crate::model::base::Base;
use crate::numbers::bounded::Equations;
use crate::numbers::linear::{Bound, dot};
use crate::numbers::signals::{add_columns, add_scaled, averaged, difference_quotient, peak};
use crate::prepare::{input, noise};
use crate::record::recording::Recording;
use crate::record::rest;
use plant::Effect;
use rayon::prelude::*;

/// Noise of this size added to its like doubles it.
const ROOT_3: f64 = 1.732;

/// The end of a reading's range, as a fraction of the largest force read: with noise that is a little more.
const REACHED: f64 = 0.985;
/// Sharpness of a limit above which it ends in a corner; of a spring that softens as `tanh` it would be 2.5.
const A_CORNER: f64 = 10.0;

/// A reading within this fraction of the largest of a limit sits at it, and there it does not move by more than the second.
const AT_A_LIMIT: f64 = 0.003;
const STANDS: f64 = 0.02;

/// Step for the slope of what a range lets pass, as a fraction of the largest force.
const PASSES_STEP: f64 = 1e-6;

/// A law with its shape values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// The row of the law table.
    pub row: usize,
    /// Its shape values.
    pub shape: [f64; 4],
}

impl Term {
    /// The term of a search's atom.
    pub fn of(atom: &Atom) -> Self {
        Self {
            row: atom.row,
            shape: atom.shape,
        }
    }
}

/// What the effects of a model act on: the declared parameters and, if an effect acts on the whole force, each term's strengths.
#[derive(Clone, Debug, Default)]
pub struct ActsOn {
    /// Stiffness, damping, mass, offset.
    pub declared: [f64; DECLARED],
    /// The strengths of each term; none: a specimen of these parameters alone.
    pub strengths: Vec<Vec<f64>>,
}

/// A fitted model of a specimen.
#[derive(Clone, Debug)]
pub struct SpecimenModelFit {
    /// Its terms.
    pub terms: Vec<Term>,
    /// Stiffness, damping, mass, offset.
    pub declared: [f64; DECLARED],
    /// The strengths of each term.
    pub strengths: Vec<Vec<f64>>,
    /// The name of each term.
    pub names: Vec<Effect>,
    /// The evidence for it.
    pub evidence: Evidence,
    /// What its effects act on; `None`: the values above, as in a model file.
    pub acts_on: Option<ActsOn>,
    /// Its strengths come from samples at least this far from any reversal, mm; `None`: from all.
    pub left_out_mm: Option<f64>,
}

impl SpecimenModelFit {
    /// What its effects act on.
    pub fn acts_on(&self) -> ActsOn {
        let own = || ActsOn {
            declared: self.declared,
            strengths: self.strengths.clone(),
        };
        self.acts_on.clone().unwrap_or_else(own)
    }
}

/// Training data of a specimen.
#[derive(Debug)]
pub struct SpecimenData<'a> {
    /// The declared model.
    pub base: &'a Base,
    /// The records without their rests.
    pub moving: Vec<Recording>,
    motions: Vec<Motion>,
    /// Whether each record has a rest, and whether the motion has one speed.
    pub motion_has: [bool; 2],
    /// Reference sizes for all quantities.
    pub sizes: Sizes,
    /// The law table.
    pub rows: Vec<Row>,
    /// Number of samples averaged into one.
    pub every: usize,
    /// Cut-off of the displacement, Hz.
    pub cutoff_hz: f64,
    pub target: Vec<f64>,
    edges: Vec<usize>,
    /// The score's measure.
    pub score: Score,
}

impl<'a> SpecimenData<'a> {
    /// From records without effects already in the model; `None` if a signal is missing or the equations are singular.
    pub fn new(base: &'a Base, train: &[Recording]) -> Option<Self> {
        let rests = train.iter().all(|r| !rest::spans(r).is_empty());
        let one_speed = input::has_one_speed(train);
        let moving: Vec<Recording> = train.iter().map(rest::without).collect();
        let ladder = cutoff::ladder(base, &spans(&moving)?, |_| Vec::new());
        let cutoff_hz = ladder.lowest(CUTOFF_ROOM)?;
        Self::below(cutoff_hz, base, moving, [rests, one_speed])
    }

    /// From records without their rests.
    pub fn below(
        cutoff_hz: f64,
        base: &'a Base,
        moving: Vec<Recording>,
        motion_has @ [rests, one_speed]: [bool; 2],
    ) -> Option<Self> {
        let sources = spans(&moving)?;
        let tracks: Vec<Track> = sources.iter().map(|s| s.track(cutoff_hz)).collect();
        let every = thinning(&tracks, cutoff_hz);
        let scales = MotionScales::of(&tracks);
        let motions: Vec<Motion> = tracks.into_iter().map(|t| Motion::new(t, base)).collect();
        let line_hz = motions.iter().max_by_key(|m| m.track.force.len());
        let line_hz = line_hz.and_then(Motion::line_hz);
        let sizes = sizes(scales, &motions, base, line_hz, one_speed);
        let own = |m: &Motion| averaged(&m.track.force, every);
        let target: Vec<f64> = motions.iter().flat_map(own).collect();
        let speeds = motions
            .iter()
            .flat_map(|m| m.track.column_of(&m.track.v, every));
        let edges = edges(&speeds.collect::<Vec<f64>>());
        let samples = std::array::from_fn(|b| (edges[b + 1] - edges[b]) as f64);
        let score = Score::new(1.0, samples);
        Some(Self {
            rows: table(&sizes, rests, base.within_tolerances(1).low > 0.0),
            base,
            moving,
            motions,
            motion_has,
            sizes,
            every,
            cutoff_hz,
            target,
            edges,
            score,
        })
    }

    /// A column over all records, averaged.
    pub fn stacked(&self, of: impl Fn(&Motion) -> Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        stacked(&self.motions, self.every, of)
    }

    /// Bounds of the declared parameters: within their tolerances, and freed from them.
    pub fn declared(&self) -> [[Bound; 2]; DECLARED] {
        std::array::from_fn(|i| {
            let within = self.base.within_tolerances(i);
            // A mass adds to the declared one: less is noise in a derivative. Another law may replace a dashpot.
            let low = match i {
                1 => self.base.least(1).min(within.low),
                2 => within.low,
                _ => f64::NEG_INFINITY,
            };
            let free = Bound {
                low,
                high: f64::INFINITY,
            };
            [within, free]
        })
    }

    /// The atoms, and what `run` finds by their products.
    pub fn searched<T>(&self, run: impl Fn(&Search) -> T) -> (Vec<Atom>, T) {
        let places: Vec<(usize, [f64; 4])> = self
            .rows
            .iter()
            .enumerate()
            .flat_map(|(i, row)| row.grid.iter().map(move |shape| (i, *shape)))
            .collect();
        // A row that frees a parameter has the same columns as the row that does not.
        let twin = |(row, shape): (usize, [f64; 4])| {
            let own = |other: &Row| match (&other.form, &self.rows[row].form) {
                (Form::Element(a), Form::Element(b)) => a == b,
                _ => false,
            };
            places
                .iter()
                .position(|&(r, s)| s == shape && (r == row || own(&self.rows[r])))
        };
        let first: Vec<Option<usize>> = places.iter().map(|p| twin(*p)).collect();
        let columns: Vec<Vec<Vec<f64>>> = places
            .par_iter()
            .enumerate()
            .map(|(i, (row, shape))| {
                if first[i] != Some(i) {
                    return Vec::new();
                }
                let on = &self.base.values;
                self.stacked(|m| m.columns(&self.rows[*row], *shape, &self.sizes, on, None))
            })
            .collect();
        let mut all = self.stacked(Motion::declared);
        let mut at = vec![0; places.len()];
        for (i, own) in columns.into_iter().enumerate() {
            at[i] = all.len();
            all.extend(own);
        }
        let atoms: Vec<Atom> = places
            .iter()
            .enumerate()
            .map(|(i, &(row, shape))| {
                let from = at[first[i].unwrap_or(i)];
                let law = &self.rows[row];
                let bounds = law.bounds(&self.sizes, shape).into_iter().enumerate();
                let parameter = match law.form {
                    Form::Parameter(which) => Some(which),
                    _ => law.frees,
                };
                Atom {
                    row,
                    shape,
                    terms: bounds.map(|(k, bound)| (from + k, bound)).collect(),
                    frees: parameter,
                    price: law.price,
                    family: law.family(shape, &self.sizes),
                }
            })
            .collect();
        let grams = Grams::new(&all, &self.target, &self.edges);
        let search = Search {
            grams: &grams,
            atoms: &atoms,
            declared: self.declared(),
            ties: self.ties(|_| false),
            score: &self.score,
        };
        let found = run(&search);
        (atoms, found)
    }

    /// Columns of a model whose effects act on these values, declared ones first, all passed through a delay if its terms have
    /// one.
    pub fn columns_on(&self, terms: &[Term], on: &ActsOn) -> Vec<Vec<f64>> {
        self.stacked(|m| model_columns(m, &self.rows, terms, &self.sizes, on))
    }

    /// The samples of each block.
    pub fn blocks(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        self.edges.windows(2).map(|e| e[0]..e[1])
    }

    /// The declared tolerance of a parameter.
    pub fn tolerance(&self, parameter: usize) -> f64 {
        self.base.tolerance(parameter)
    }

    /// Sizes for the effects of a fit.
    pub fn sizes_of(&self, fit: &SpecimenModelFit) -> Sizes {
        self.sizes.on(&fit.acts_on().declared)
    }

    /// Bounds of a model's strengths, declared parameters first.
    pub fn bounds(&self, terms: &[Term]) -> Vec<Bound> {
        let declared = self.declared();
        let mut all: Vec<Bound> = (0..DECLARED)
            .map(|i| declared[i][usize::from(self.frees(terms, i))])
            .collect();
        for t in terms.iter().filter(|t| !self.rows[t.row].is_delay()) {
            all.extend(self.rows[t.row].bounds(&self.sizes, t.shape));
        }
        all
    }

    /// Ties of a model's declared parameters that may not leave their tolerances.
    pub fn ties(&self, freed: impl Fn(usize) -> bool) -> Vec<Tie> {
        let held = (0..DECLARED).filter(|i| !freed(*i));
        held.filter(|i| self.base.tolerance(*i) > 0.0)
            .map(|unknown| Tie {
                unknown,
                value: self.base.values[unknown],
                weight: self.score.tie(self.base.tolerance(unknown)),
            })
            .collect()
    }

    /// True if a model lets a declared parameter leave its tolerances.
    pub fn frees(&self, terms: &[Term], parameter: usize) -> bool {
        terms.iter().any(|t| {
            let row = &self.rows[t.row];
            matches!(row.form, Form::Parameter(p) if p == parameter) || row.frees == Some(parameter)
        })
    }

    /// Products of columns, block by block.
    pub fn parts(&self, columns: &[Vec<f64>], target: &[f64]) -> Vec<Equations> {
        let each = self.blocks().map(|b| Equations::of(columns, target, b));
        each.collect()
    }

    /// A model's force for a record, N; `None` if a signal is missing.
    pub fn answer(&self, fit: &SpecimenModelFit, record: &Recording) -> Option<Vec<f64>> {
        let span = UnfilteredSpan::new(record)?;
        let track = span.track(span.past_band_hz(self.cutoff_hz));
        let motion = Motion::new(track, self.base);
        let on = fit.acts_on();
        let columns = model_columns(&motion, &self.rows, &fit.terms, &self.sizes, &on);
        let mut strengths = fit.declared.to_vec();
        strengths.extend(fit.strengths.iter().flatten());
        let mut y = vec![0.0; motion.track.x.len()];
        add_columns(&mut y, &columns, &strengths, 1.0);
        Some(motion.track.span_of(&y))
    }

    /// A model's force for the training data as searched.
    pub fn answered(&self, fit: &SpecimenModelFit) -> Vec<f64> {
        self.answered_along(&self.motions, fit)
    }

    /// The same with as much noise of the displacement added as doubles it, and with its negative.
    pub fn answered_at_twice_the_noise(&self, fit: &SpecimenModelFit) -> [Vec<f64>; 2] {
        // A short record does not show its noise.
        let longest = self.moving.iter().max_by_key(|r| r.time_s.len());
        let noise = |samples: usize| {
            let r = longest?;
            noise::like(r.displacement_mm.as_deref()?, r.interval_s(), samples)
        };
        [ROOT_3, -ROOT_3].map(|times| {
            let shaken = self.motions.iter().map(|m| {
                let mut track = m.track.clone();
                if let Some(noise) = noise(track.samples()) {
                    track.shake(&noise, times, self.cutoff_hz);
                }
                Motion::new(track, self.base)
            });
            self.answered_along(&shaken.collect::<Vec<Motion>>(), fit)
        })
    }

    fn answered_along(&self, motions: &[Motion], fit: &SpecimenModelFit) -> Vec<f64> {
        let mut y = vec![0.0; self.target.len()];
        let mut strengths = fit.declared.to_vec();
        strengths.extend(fit.strengths.iter().flatten());
        let (rows, sizes, on) = (&self.rows, &self.sizes, fit.acts_on());
        let columns = stacked(motions, self.every, |m| {
            model_columns(m, rows, &fit.terms, sizes, &on)
        });
        add_columns(&mut y, &columns, &strengths, 1.0);
        y
    }

    /// The measured force as searched.
    pub fn target(&self) -> &[f64] {
        &self.target
    }

    /// Delay of a fit's force, s, if it has a term for it.
    pub fn late_s(&self, fit: &SpecimenModelFit) -> Option<f64> {
        late_s(&self.rows, &fit.terms)
    }

    /// True if, of the forces of a fit's spring, damping and mass, all but one together are within the noise.
    pub fn has_only(&self, fit: &SpecimenModelFit, own: usize) -> bool {
        let columns = self.stacked(Motion::declared);
        let mut other = vec![0.0; self.target.len()];
        for i in (0..3).filter(|i| *i != own) {
            add_scaled(&mut other, &columns[i], fit.declared[i]);
        }
        dot(&other, &other) <= self.score.noise * other.len() as f64
    }

    /// The terms of a fit with the end of the reading's range in place of a spring that softens: the search has a range's columns
    /// for the declared force alone, and what changes with time is read up to the same end.
    pub fn with_a_range(&self, fit: &SpecimenModelFit) -> Vec<Vec<Term>> {
        let end = REACHED * peak(&self.target);
        // Those that end equally far on both sides.
        let is_range = |r: &Row| {
            r.point_of_action() == PointOfAction::Range && r.grid.iter().all(|s| s[1] >= 0.0)
        };
        let rows = (0..self.rows.len()).filter(|i| is_range(&self.rows[*i]));
        let ranges = rows.filter_map(|row| {
            let mut shape = *self.rows[row].grid.last()?;
            shape[0] = end;
            Some(Term { row, shape })
        });
        let soft = (0..fit.terms.len()).filter(|i| fit.names[*i] == Effect::Softening);
        let of = |(i, range)| {
            let mut terms = fit.terms.clone();
            terms[i] = range;
            terms
        };
        let ranges: Vec<Term> = ranges.collect();
        let pairs = soft.flat_map(|i| ranges.iter().map(move |r| (i, *r)));
        pairs.map(of).collect()
    }

    /// Values of a term that is the end of the reading's range; `None` for another.
    fn range_of(&self, term: Term) -> Option<Vec<NamedValue>> {
        let row = &self.rows[term.row];
        match row.form {
            Form::Effect(candidate) if row.point_of_action() == PointOfAction::Range => Some(
                (candidate.parameters)(&[1.0], &term.shape, &self.sizes.scales),
            ),
            _ => None,
        }
    }

    /// True if a term is a range that ends in a corner, which no spring has.
    pub fn has_a_corner(&self, term: Term) -> bool {
        self.range_of(term).is_some_and(|own| {
            let sharpness = own.iter().find(|p| p.0 == "sharpness");
            sharpness.is_none_or(|p| p.2 > A_CORNER)
        })
    }

    /// True if a fit has a limit at which the reading still moves: what sits at the end of its range stands still.
    pub fn moves_at_a_limit(&self, fit: &SpecimenModelFit) -> bool {
        let sharp = fit.terms.iter().filter(|t| self.has_a_corner(**t));
        let ends = |t: &Term| {
            let own = self.range_of(*t).into_iter().flatten();
            let end = |p: NamedValue| match p.0 {
                "limit_n" => vec![-p.2, p.2],
                "lower_n" | "upper_n" => vec![p.2],
                _ => Vec::new(),
            };
            own.flat_map(end).collect::<Vec<f64>>()
        };
        let limits: Vec<f64> = sharp.flat_map(ends).collect();
        if limits.is_empty() {
            return false;
        }
        let whole = peak(&self.target);
        let near = |y: f64| limits.iter().any(|l| (y - l).abs() < AT_A_LIMIT * whole);
        let answered = self.answered(fit);
        let at_one = answered.iter().zip(&self.target).filter(|p| near(*p.0));
        let left: Vec<f64> = at_one.map(|(y, f)| f - y).collect();
        let still = (STANDS * whole).powi(2) + self.score.noise;
        dot(&left, &left) > still * left.len() as f64
    }

    /// True if the force of all terms before one of a fit's is within the noise.
    pub fn is_alone(&self, fit: &SpecimenModelFit, term: usize) -> bool {
        let mut strengths = vec![0.0; DECLARED];
        for (i, own) in fit.strengths.iter().enumerate() {
            let at = |i: usize| self.rows[fit.terms[i].row].point_of_action();
            let before = i != term && at(i) <= at(term);
            strengths.extend(own.iter().map(|s| if before { *s } else { 0.0 }));
        }
        let mut others = vec![0.0; self.target.len()];
        add_columns(
            &mut others,
            &self.columns_on(&fit.terms, &fit.acts_on()),
            &strengths,
            1.0,
        );
        dot(&others, &others) <= self.score.noise * others.len() as f64
    }

    /// The declared values.
    pub fn declared_values(&self) -> [f64; DECLARED] {
        self.base.values
    }
}

/// A column over all motions, averaged over `every` samples.
fn stacked(
    motions: &[Motion],
    every: usize,
    of: impl Fn(&Motion) -> Vec<Vec<f64>>,
) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = Vec::new();
    for motion in motions {
        for (i, column) in of(motion).iter().enumerate() {
            let own = motion.track.column_of(column, every);
            match all.get_mut(i) {
                Some(column) => column.extend(own),
                None => all.push(own),
            }
        }
    }
    all
}

/// Records as spans; `None` if a signal is missing.
pub fn spans(records: &[Recording]) -> Option<Vec<UnfilteredSpan<'_>>> {
    records.iter().map(UnfilteredSpan::new).collect()
}

/// Delay of the force, s, if a term gives one.
pub fn late_s(rows: &[Row], terms: &[Term]) -> Option<f64> {
    let delay = terms.iter().find(|t| rows[t.row].is_delay());
    delay.map(|t| t.shape[0])
}

/// Columns of a model over a motion, declared ones first; a delay has no column but all others pass through it.
pub fn model_columns(
    m: &Motion,
    rows: &[Row],
    terms: &[Term],
    sizes: &Sizes,
    on: &ActsOn,
) -> Vec<Vec<f64>> {
    // They act one after the other; the columns keep the order of the terms.
    let mut acting: Vec<(usize, &Term)> = terms.iter().enumerate().collect();
    acting.retain(|(_, t)| !rows[t.row].is_delay());
    acting.sort_by_key(|(_, t)| rows[t.row].point_of_action());
    let mut declared = m.declared();
    let mut own: Vec<Vec<Vec<f64>>> = vec![Vec::new(); terms.len()];
    let sums = acting
        .iter()
        .any(|(_, t)| rows[t.row].acts_on_the_whole_force());
    let mut others = sums.then(|| vec![0.0; m.track.x.len()]);
    for (i, t) in acting {
        let row = &rows[t.row];
        let of = |others: Option<&[f64]>| m.columns(row, t.shape, sizes, &on.declared, others);
        let mut columns = of(others.as_deref());
        let (Some(others), Some(strengths)) = (&mut others, on.strengths.get(i)) else {
            own[i] = columns;
            continue;
        };
        let mut before = others.clone();
        add_columns(others, &columns, strengths, 1.0);
        if row.point_of_action() == PointOfAction::Range {
            // What it lets pass of each force: the columns are the slopes of what is read.
            let step = PASSES_STEP * sizes.scales.base;
            let more: Vec<f64> = before.iter().map(|f| f + step).collect();
            let cut = difference_quotient(&of(Some(&more))[0], &columns[0], step);
            add_columns(&mut before, &declared, &on.declared, 1.0);
            let kept = |(c, (f, cut)): (&mut f64, (&f64, &f64))| *c -= f * cut;
            columns[0]
                .iter_mut()
                .zip(before.iter().zip(&cut))
                .for_each(kept);
            let passed = declared.iter_mut().chain(own.iter_mut().flatten());
            passed.for_each(|c| c.iter_mut().zip(&cut).for_each(|(c, cut)| *c += *c * cut));
        }
        own[i] = columns;
    }
    let mut all = declared;
    all.extend(own.into_iter().flatten());
    if let Some(late_s) = late_s(rows, terms) {
        all.iter_mut().for_each(|c| *c = m.late(c, late_s));
    }
    all
}
