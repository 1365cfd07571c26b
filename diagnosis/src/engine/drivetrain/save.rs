//! Results as figures with their scatter, and as part of a model.

use super::fit::{ActuatorData, ActuatorFit, DECLARED};
use crate::laws::drivetrain::part::{Part, PartKind};
use crate::laws::drivetrain::signal_path::LEAST_LAG;
use crate::model::{Declared, Model};
use crate::numbers::linear::scatter;
use plant::{Channel, Effect, EffectSpec};

/// A parameter by the catalogue: name, unit, value, standard deviation.
pub type Figure = (&'static str, &'static str, f64, f64);

/// Numbers of segments whose pulls give the scatter of a fit: fewer segments capture longer correlations.
const SEGMENTS: [usize; 3] = [12, 24, 48];

/// Factor from a parameter's declared unit to the unit here, where times are in s.
fn unit(which: usize) -> f64 {
    match Channel::Actuator.parameters()[which].unit {
        "ms" => 1e-3,
        _ => 1.0,
    }
}

impl ActuatorData<'_> {
    /// Standard deviations of declared parameters, amplitudes and shapes, from how far segments of the record pull the
    /// fit apart.
    pub fn spread(&self, fit: &ActuatorFit) -> Vec<f64> {
        let mut widest = vec![0.0_f64; fit.slopes.len()];
        for segments in SEGMENTS {
            let own = scatter(&fit.slopes, &fit.residual, segments);
            for (widest, own) in widest.iter_mut().zip(own) {
                *widest = widest.max(own);
            }
        }
        widest
    }

    /// The parameters of a name in a fit, whose `spread` is given.
    pub fn figures(&self, fit: &ActuatorFit, name: Effect, spread: &[f64]) -> Vec<Figure> {
        if let Some(i) = Channel::Actuator.parameter_of_error(name) {
            let p = &Channel::Actuator.parameters()[i];
            let had = self.base.values[i];
            let error = p.error(fit.declared[i] / unit(i), had);
            // The true value is only known to its tolerance.
            let known = self.base.tolerance(i);
            let scatter = (spread[i] / unit(i)).hypot(known) / p.per_error(had).abs();
            return vec![(p.error_parameter, p.error_unit(), error, scatter)];
        }
        let mut declared = fit.declared;
        // As the valve is simulated.
        declared[2] = declared[2].max(LEAST_LAG * self.interval_s);
        let mut amplitude_at = DECLARED;
        let mut shape_at = DECLARED + fit.amplitudes.len();
        let mut out = Vec::new();
        for part in &fit.model.parts {
            let mut scatter = [0.0; 4];
            let own = part.kind.shapes();
            scatter[..own].copy_from_slice(&spread[shape_at..shape_at + own]);
            shape_at += own;
            let (strength, ss) = if part.kind.is_column() {
                amplitude_at += 1;
                (
                    fit.amplitudes[amplitude_at - 1 - DECLARED],
                    spread[amplitude_at - 1],
                )
            } else {
                (0.0, 0.0)
            };
            if part.effect() != Some(name) {
                continue;
            }
            out.extend(part_figures(part, [strength, ss], scatter, &declared));
        }
        out
    }

    /// Writes a fit into the actuator's model: declared parameters with their previous tolerances, but at least their
    /// scatter, and parts as effects.
    pub fn save(&self, fit: &ActuatorFit, spread: &[f64], model: &mut Model) {
        let Some((places, effects)) = model.channel_mut(Channel::Actuator) else {
            return;
        };
        for (i, field) in places.into_iter().enumerate() {
            let unit = 1.0 / unit(i);
            let (value, scatter) = (unit * fit.declared[i], unit * spread[i]);
            let tolerance = field.map_or(0.0, |d| d.tolerance);
            let had = field.map_or(self.base.values[i], |d| d.value);
            if field.is_some() && tolerance > 0.0 || (value - had).abs() > 1e-12 {
                let least = if scatter.is_finite() { scatter } else { 0.0 };
                *field = Some(Declared {
                    value,
                    tolerance: tolerance.max(least),
                });
            }
        }
        let mut amplitudes = fit.amplitudes.iter();
        let strength = |p: &Part| p.kind.is_column().then(|| amplitudes.next()).flatten();
        let strengths: Vec<Option<&f64>> = fit.model.parts.iter().map(strength).collect();
        let mut parts: Vec<_> = fit.model.parts.iter().zip(strengths).collect();
        // Those of a file act one after the other.
        parts.sort_by_key(|(p, _)| PartKind::ALL.iter().position(|k| *k == p.kind));
        for (part, strength) in parts {
            let strength = strength.copied().unwrap_or(0.0);
            let parameters = saved(part, strength, &fit.declared);
            effects.extend(part.kind.effect().map(|e| EffectSpec::new(e, &parameters)));
        }
    }
}

/// The parameters of a part in a model file: its figures, except where a file is asked for more, or has another measure. From its
/// strength and shapes, after a declared gain, lag and offset.
fn saved(part: &Part, strength: f64, declared: &[f64; DECLARED]) -> Vec<(&'static str, f64)> {
    let [gain, _, lag_s, offset] = *declared;
    let [a, b, c, d] = part.shapes;
    let lag = ("valve_lag_ms", 1e3 * lag_s);
    let figures = part_figures(part, [strength, 0.0], [0.0; 4], declared);
    let mut all: Vec<_> = figures.iter().map(|f| (f.0, f.2)).collect();
    match part.kind {
        PartKind::Overlap => vec![("overlap_mm", a), lag],
        PartKind::FlowLimit => vec![("opening_mm", a), lag],
        PartKind::RateLimit => vec![("valve_rate_mm_per_s", a)],
        PartKind::Seal => vec![("oil_bend_mm", a), ("presliding_mm", b), lag],
        PartKind::StickySeal => vec![
            ("oil_bend_mm", a),
            ("presliding_mm", b),
            ("rest_ratio", c),
            ("stribeck_mm_per_s", d),
            lag,
        ],
        PartKind::Stops => {
            let mut all = vec![("lower_mm", a), ("upper_mm", b)];
            if c > 0.0 {
                all.push(("rounding_mm", c));
            }
            all
        }
        // After gain and offset, as in a model file.
        PartKind::DeadBand => {
            all.push(("middle_mm", b * gain + offset));
            all
        }
        PartKind::Friction if b > 0.0 => {
            all.push(("roundness", b));
            all
        }
        // A file counts half of a difference of the sides in the gain, and has no separate lag for the return.
        _ => all,
    }
}

/// The figures of a part: from its strength and shapes with their scatter, beside the declared parameters.
fn part_figures(
    part: &Part,
    [strength, ss]: [f64; 2],
    [sa, sb, sc, sd]: [f64; 4],
    declared: &[f64; DECLARED],
) -> Vec<Figure> {
    let [a, b, c, d] = part.shapes;
    let (gain, lag_s) = (declared[0].abs(), declared[2]);
    match part.kind {
        PartKind::SecondLag => vec![("lag_ms", "ms", 1e3 * a, 1e3 * sa)],
        PartKind::OilColumn => {
            let mut all = vec![("frequency_hz", "Hz", a, sa), ("damping_ratio", "", b, sb)];
            if c > 0.0 {
                all.push(("damping_s_per_mm", "s/mm", c / gain, sc / gain));
            }
            all
        }
        // Of the command's lead, as in a model file.
        PartKind::UnequalAreas => vec![("unequal_areas_per_mm", "1/mm", a, sa)],
        PartKind::TwoSpeeds => vec![("flow_difference", "", a, sa)],
        PartKind::Overlap => vec![("width_mm", "mm", 2.0 * a * gain, 2.0 * sa * gain)],
        PartKind::FlowLimit => {
            let per_s = gain / lag_s;
            vec![("rate_mm_per_s", "mm/s", a * per_s, sa * per_s)]
        }
        PartKind::RateLimit | PartKind::Slew => {
            vec![("rate_mm_per_s", "mm/s", a * gain, sa * gain)]
        }
        PartKind::Load | PartKind::Sag => Vec::new(),
        PartKind::Play | PartKind::DeadBand => {
            vec![("width_mm", "mm", a * gain, sa * gain)]
        }
        PartKind::Stops => {
            // A stop that the motion does not reach has no scatter.
            let both = [(a.abs(), sa), (b.abs(), sb)];
            let reached = both.into_iter().filter(|s| s.1 > 0.0);
            let nearest = reached.min_by(|s, t| s.0.total_cmp(&t.0));
            let (limit, scatter) = nearest.unwrap_or(both[0]);
            vec![("limit_mm", "mm", limit, scatter)]
        }
        PartKind::Friction => vec![
            ("error_mm", "mm", strength, ss),
            ("presliding_mm", "mm", a * gain, sa * gain),
        ],
        PartKind::Seal | PartKind::StickySeal => {
            let mut all = vec![("error_mm", "mm", a * gain, sa * gain)];
            if part.kind == PartKind::StickySeal {
                all.push(("rest_ratio", "", c, sc));
                all.push(("stribeck_mm_per_s", "mm/s", d * gain, sd * gain));
            }
            all.push(("presliding_mm", "mm", b * gain, sb * gain));
            all
        }
        PartKind::Compliance => {
            let stiffness = 1.0 / strength.max(1e-12);
            vec![(
                "stiffness_n_per_mm",
                "N/mm",
                stiffness,
                stiffness * stiffness * ss,
            )]
        }
        PartKind::SideGain => vec![("difference", "", strength / declared[0], ss / gain)],
        PartKind::Drift => vec![
            ("rate_mm_per_s", "mm/s", strength / a, ss / a),
            ("time_constant_s", "s", a, sa),
        ],
        PartKind::GainDrift => {
            let mut all = vec![
                ("change", "", strength / declared[0], ss / gain),
                ("time_constant_s", "s", a, sa),
            ];
            if b > 0.0 {
                let own = 1.0 / gain.powi(2);
                all.push(("own_heat_per_mm2", "1/mm2", b * own, sb * own));
            }
            all
        }
    }
}
