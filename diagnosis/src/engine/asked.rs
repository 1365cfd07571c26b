//! What an answer needs from a channel of either kind.

use super::posterior::{Candidate, Posterior};
use super::verdict;
use crate::model::Model;
use crate::model::answer::ParameterEstimate;
use crate::record::recording::Recording;
use plant::Effect;

/// A channel's training data with the fits of models to them.
pub trait Asked {
    /// A fitted model.
    type Fit: Clone;

    /// Measured minus modelled, per record; the records may differ from the fit's. `None` if a signal is missing.
    fn residuals(&self, fit: &Self::Fit, records: &[Recording]) -> Option<Vec<Vec<f64>>>;

    /// A chosen fit, fully optimised.
    fn settled(&self, fit: &Self::Fit) -> Self::Fit;

    /// Each name with its parameters and their 90 % intervals.
    fn figures(&self, fit: &Self::Fit) -> Vec<(Effect, Vec<ParameterEstimate>)>;

    /// The declared parameters, in the order and units of the channel's table.
    fn declared(&self, fit: &Self::Fit) -> [f64; 4];

    /// Writes a fit into a model.
    fn save(&self, fit: &Self::Fit, model: &mut Model);

    /// True if an unnamed model has parts that any device of its kind has; false for a channel without such parts.
    fn is_of_higher_order(&self, _: &Self::Fit) -> bool {
        false
    }
}

/// The findings about a channel.
#[derive(Debug)]
pub struct Found<F> {
    /// The verdict.
    pub said: verdict::Said<F>,
    /// The declared model with its parameters within their tolerances.
    pub declared: F,
    /// The likeliest model without a name.
    pub nothing: F,
    /// Probability that something without a name is present; `None` if no unnamed rival was tried.
    pub unnamed: Option<f64>,
}

impl<F: Clone> Found<F> {
    /// Findings from a channel's scored models, which include the declared one. `told`: a rest determines the noise.
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

    /// The model of what is named or in a set.
    pub fn leading(&self) -> Option<&F> {
        let unknown = matches!(self.said, verdict::Said::Unknown(_));
        let named = self.said.model().filter(|_| !unknown);
        named.map(|candidate| &candidate.model)
    }
}

/// A model with one name.
#[derive(Clone, Debug)]
pub struct OfOneName {
    /// Its name, in addition to the declared parameters.
    pub name: Effect,
    /// The whole model.
    pub model: Model,
    /// Its rms residual on the training data.
    pub left_rms: f64,
    /// The name's parameters.
    pub parameters: Vec<ParameterEstimate>,
    /// The declared parameters with it, in the order and units of the channel's table.
    pub declared: [f64; 4],
}

impl OfOneName {
    /// From a fit, fully optimised.
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
