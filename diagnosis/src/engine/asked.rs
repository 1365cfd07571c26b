//! What an answer needs of a channel, whichever it is.

use super::posterior::{Candidate, Posterior};
use super::verdict;
use crate::model::Model;
use crate::model::answer::ParameterEstimate;
use crate::record::recording::Recording;
use plant::Effect;

/// A channel's training data with the fits of models to them.
pub trait Asked {
    /// A model at its best.
    type Fit: Clone;

    /// Measured less modelled, record by record, which may be others than those of the fit; `None` where a signal is missing.
    fn residuals(&self, fit: &Self::Fit, records: &[Recording]) -> Option<Vec<Vec<f64>>>;

    /// A fit that was chosen, at its best.
    fn settled(&self, fit: &Self::Fit) -> Self::Fit;

    /// Each name with its parameters and their 90 % intervals.
    fn figures(&self, fit: &Self::Fit) -> Vec<(Effect, Vec<ParameterEstimate>)>;

    /// The declared parameters, in the order and the units of the channel's table.
    fn declared(&self, fit: &Self::Fit) -> [f64; 4];

    /// Puts a fit into a model.
    fn save(&self, fit: &Self::Fit, model: &mut Model);

    /// Whether a model without a name has parts that any device of its kind has; of a channel that has none of these, never.
    fn is_of_higher_order(&self, _: &Self::Fit) -> bool {
        false
    }
}

/// What is found out about a channel.
#[derive(Debug)]
pub struct Found<F> {
    /// What can be said.
    pub said: verdict::Said<F>,
    /// The declared model, its parameters within their tolerances.
    pub declared: F,
    /// The likeliest model without a name.
    pub nothing: F,
    /// How probable it is that something without a name is there; `None` where no rival without a name was asked.
    pub unnamed: Option<f64>,
}

impl<F: Clone> Found<F> {
    /// What scored models of a channel come to; the declared one is among them. `told`: a rest tells the noise.
    pub fn of(models: Vec<Candidate<F>>, declared: F, told: bool) -> Self {
        let posterior = Posterior::of(models);
        let [sure, most] = verdict::NOTHING;
        let allowed = if told { [sure; 2] } else { [sure, most] };
        let said = verdict::verdict(&posterior, allowed);
        let nothing = posterior.declared().map(|c| c.model.clone());
        let asked = posterior.models.iter().any(|m| m.0.nameless);
        Self {
            nothing: nothing.unwrap_or_else(|| declared.clone()),
            unnamed: asked.then(|| posterior.unnamed()),
            said,
            declared,
        }
    }
}

/// A model with one name.
#[derive(Clone, Debug)]
pub struct OfOneName {
    /// What it has beside the declared parameters.
    pub name: Effect,
    /// The whole model.
    pub model: Model,
    /// What it leaves of the training data, rms.
    pub left_rms: f64,
    /// The name's parameters.
    pub parameters: Vec<ParameterEstimate>,
    /// The declared parameters beside it, in the order and the units of the channel's table.
    pub declared: [f64; 4],
}

impl OfOneName {
    /// A fit at its best.
    pub fn of<A: Asked>(
        data: &A,
        fit: &A::Fit,
        name: Effect,
        model: &Model,
        left_rms: f64,
    ) -> Self {
        let fit = data.settled(fit);
        let mut with = model.clone();
        data.save(&fit, &mut with);
        let own = data.figures(&fit).into_iter().find(|f| f.0 == name);
        Self {
            name,
            model: with,
            left_rms,
            parameters: own.map_or(Vec::new(), |f| f.1),
            declared: data.declared(&fit),
        }
    }
}
