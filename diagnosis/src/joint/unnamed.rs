//! What elements still explain beside an unnamed remainder of all other kinds: hat functions of displacement and speed, memory,
//! filters and time.

use super::blocks::Blocks;
use super::element::{Element, Law};
use super::kind::ElementKind;
use super::set::{DECLARED, Library, column};
use crate::criteria::BLOCKS;

/// Hats over a range, memory, filters and time of the unnamed rest.
const HATS: usize = 9;
/// Ridge of the unnamed rest.
const RIDGE: f64 = 1e-4;

/// Columns of an unnamed rest, with the kind that each stands for.
fn rest_columns(library: &Library) -> Vec<(ElementKind, Vec<f64>)> {
    let s = library.sizes;
    let t = library.tracks;
    let mut all = Vec::new();
    for i in 0..HATS {
        let at = -1.0 + 2.0 * i as f64 / (HATS - 1) as f64;
        let width = 2.0 / (HATS - 1) as f64;
        let hat = |u: f64| (1.0 - (u - at).abs() / width).max(0.0);
        let in_x = |x: &f64| hat((x - s.middle) / s.x);
        let in_v = |v: &f64| hat((v / s.v).clamp(-1.0, 1.0));
        all.push((
            ElementKind::Displacement,
            column(t, library.every, |t| t.x.iter().map(in_x).collect()),
        ));
        all.push((
            ElementKind::Velocity,
            column(t, library.every, |t| t.v.iter().map(in_v).collect()),
        ));
    }
    for i in 0..library.elements.len() {
        let e: &Element = &library.elements[i];
        let kind = match e.law {
            Law::Slider => ElementKind::Memory,
            Law::Relaxing => ElementKind::Linear,
            Law::Settling => ElementKind::Time,
            Law::Lessened => ElementKind::Damage,
            _ => continue,
        };
        all.push((kind, library.columns[DECLARED + i].clone()));
    }
    all
}

/// Logarithm of the squares with elements over those without, beside an unnamed rest of all other kinds.
pub fn share_beside_unnamed(library: &Library, kind: ElementKind, elements: &[usize]) -> f64 {
    // What a play takes off a spring is a slider that pulls; and sliders of many gives and either sign remember the largest
    // displacement (a Preisach model keeps the extremes that nothing later has wiped out), so they draw any damage.
    let sliders = matches!(kind, ElementKind::Play | ElementKind::Damage);
    let own = |k: ElementKind| k == kind || (sliders && k == ElementKind::Memory);
    let rest = rest_columns(library).into_iter().filter(|r| !own(r.0));
    let mut columns: Vec<Vec<f64>> = library.columns[..DECLARED].to_vec();
    columns.extend(rest.map(|r| r.1));
    let without = ridge_costs(&columns, &library.force);
    columns.extend(
        elements
            .iter()
            .map(|e| library.columns[DECLARED + e].clone()),
    );
    let with = ridge_costs(&columns, &library.force);
    match (without, with) {
        (Some(without), Some(with)) => library.log_ratio(&with) - library.log_ratio(&without),
        _ => f64::NEG_INFINITY,
    }
}

/// Cross-validated squares of many columns with a ridge.
fn ridge_costs(columns: &[Vec<f64>], force: &[f64]) -> Option<[f64; BLOCKS]> {
    let blocks = Blocks::new(columns, force);
    let costs = blocks.ridge_cross_validated(|_, own| RIDGE * own.max(1e-12))?;
    Some(std::array::from_fn(|b| costs[b].max(0.0)))
}
