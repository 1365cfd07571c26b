//! What the figures of a solution say themselves: that an effect is a simpler one, or that none is told.

use crate::answer::ParameterEstimate;
use crate::base::Base;
use crate::criteria::single::{CLASS, FAR, PASS};
use crate::fit::{Solution, settle};
use crate::interval;
use crate::library::candidates;
use crate::noise::Noise;
use crate::polish::{Shaped, polish};
use crate::problem::FittedEffect;
use plant::Effect;

/// Fitted again with other effects.
fn again(s: &Solution, base: &Base, noise: &Noise, effects: &[Shaped]) -> Option<Solution> {
    let settled = settle(&s.problem, base, noise, effects)?;
    Some(polish(settled, base, noise))
}

fn shaped(effects: &[FittedEffect]) -> Vec<Shaped> {
    let own = effects.iter();
    own.map(|e| (e.candidate, e.shapes.clone())).collect()
}

/// Friction that falls with speed, where the interval of its level at rest over that in motion holds 1, is friction;
/// `None` where there is no such thing.
pub fn plain_friction(s: &Solution, base: &Base, noise: &Noise) -> Option<Solution> {
    let falls = |e: &FittedEffect| e.candidate.effect == Effect::StribeckFriction;
    let at = s.effects.iter().position(falls)?;
    let figures = interval::parameters(s, base, noise);
    let ratio = figures[at].iter().find(|f| f.0 == "rest_ratio")?;
    if ratio.3[0] > 1.0 {
        return None;
    }
    let mut all = candidates(base.channel).into_iter();
    let plain = all.find(|c| c.effect == Effect::CoulombFriction)?;
    let mut effects = shaped(&s.effects);
    effects[at] = (plain, vec![effects[at].1[0]]);
    again(s, base, noise, &effects)
}

/// Of several effects those whose strength these samples tell; `None` where they tell all, or none.
pub fn told(s: &Solution, base: &Base, noise: &Noise) -> Option<Solution> {
    let figures = interval::parameters(s, base, noise);
    let tells = |figures: &Vec<ParameterEstimate>| {
        let [low, high] = figures.first().map_or([1.0; 2], |f| f.3);
        low > 0.0 || high < 0.0
    };
    let pairs = s.effects.iter().zip(&figures);
    let stay = pairs.filter(|p| tells(p.1)).map(|p| p.0.clone());
    let stay: Vec<FittedEffect> = stay.collect();
    if stay.is_empty() || stay.len() == s.effects.len() {
        return None;
    }
    again(s, base, noise, &shaped(&stay))
}

/// Whether readings lie beyond a limit of this solution, where nothing passes: it is none.
pub fn is_passed(s: &Solution, noise: &Noise) -> bool {
    let limits = |e: &&FittedEffect| e.candidate.effect == Effect::Saturation;
    let Some(limit) = s.effects.iter().find(limits).map(|e| e.shapes[0]) else {
        return false;
    };
    let offset = s.problem.theta[3].abs();
    let beyond = limit + offset + (FAR * noise.rms).max(CLASS * limit);
    let count = |of: &dyn Fn(&crate::segment::Segment) -> Vec<f64>, at: f64| {
        let all = s.problem.segments.iter().flat_map(of);
        all.filter(|y| y.abs() > at).count() as f64
    };
    let measured = count(&|s| s.judged(&s.target), beyond);
    measured > PASS * count(&|s| s.judged(&s.signals.base), limit)
}
