//! The effects that can be hidden: every name of the effect list, in every channel where it shows, in two sets of equations.

mod contact;
mod elastic;
mod interference;
mod limit;
mod physics;
mod scale;
mod slow;
mod timing;
mod viscous;
mod yielding;

pub(crate) use physics::{Acts, Physics, Scale, plus};
pub use physics::{Channel, Equations};

use crate::draws::Draws;

/// Name, family and channel of each effect that can be hidden.
pub const LIST: &[(&str, &str, Channel)] = {
    use Channel::{Actuator as A, Specimen as S};
    &[
        ("delay_error", "timing", A),
        ("lag_error", "timing", A),
        ("second_lag", "timing", A),
        ("oil_column", "timing", A),
        ("channel_skew", "timing", S),
        ("gain_error", "calibration", A),
        ("gain_error", "calibration", S),
        ("offset", "calibration", A),
        ("offset", "calibration", S),
        ("rig_compliance", "calibration", A),
        ("rig_compliance", "calibration", S),
        ("drift", "slow", A),
        ("drift", "slow", S),
        ("temperature_gain", "slow", A),
        ("temperature_gain", "slow", S),
        ("coulomb_friction", "friction", A),
        ("coulomb_friction", "friction", S),
        ("stribeck_friction", "friction", S),
        ("bilinear_hysteresis", "hysteresis", S),
        ("bouc_wen_hysteresis", "hysteresis", S),
        ("backlash", "gap", A),
        ("backlash", "gap", S),
        ("dead_band", "gap", A),
        ("dead_band", "gap", S),
        ("slip_gap", "gap", S),
        ("saturation", "limit", A),
        ("saturation", "limit", S),
        ("rate_limit", "limit", A),
        ("viscous_damping", "damping", S),
        ("quadratic_damping", "damping", S),
        ("maxwell_damper", "damping", S),
        ("hardening", "stiffness", S),
        ("softening", "stiffness", S),
        ("asymmetric_actuator", "asymmetry", A),
        ("asymmetric_stiffness", "asymmetry", S),
        ("inertia_force", "inertia", S),
        ("mains_hum", "interference", A),
        ("mains_hum", "interference", S),
        ("quantisation", "interference", A),
        ("quantisation", "interference", S),
    ]
};

/// The family of a name; none if the name is not in the list.
pub fn family(name: &str) -> Option<&'static str> {
    LIST.iter().find(|e| e.0 == name).map(|e| e.1)
}

/// Names that leave the same traces in the record of a rig whose specimen is otherwise linear, so that no analysis can
/// tell them from `name`.
pub fn indistinguishable(name: &str, channel: Channel) -> &'static [&'static str] {
    match (name, channel) {
        // A constant share of the displacement or the force is lost, whatever the reason.
        ("gain_error", _) => &["rig_compliance"],
        ("rig_compliance", _) => &["gain_error"],
        // F(t + d) is F + k d v.
        ("viscous_damping", _) => &["channel_skew"],
        // Holding a controlled actuator back by a constant distance looks like play.
        ("backlash", Channel::Actuator) => &["coulomb_friction"],
        ("coulomb_friction", Channel::Actuator) => &["backlash"],
        _ => &[],
    }
}

/// A force that is early or a displacement that is late; on a spring it looks like damping.
pub(crate) fn early_force() -> Physics {
    Physics {
        name: "channel_skew",
        channel: Channel::Specimen,
        ..timing::early_force()
    }
}

/// Draws the shape of an effect; none if the list has no such effect in that channel.
pub(crate) fn draw(
    name: &'static str,
    channel: Channel,
    equations: Equations,
    scale: &Scale,
    rng: &mut Draws,
) -> Option<Physics> {
    let unseen = equations == Equations::Unseen;
    let makers = [
        timing::draw,
        scale::draw,
        slow::draw,
        contact::draw,
        yielding::draw,
        limit::draw,
        viscous::draw,
        elastic::draw,
        interference::draw,
    ];
    let mut physics = makers
        .iter()
        .find_map(|make| make(name, channel, unseen, scale, rng))?;
    physics.name = name;
    physics.channel = channel;
    Some(physics)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_list_can_be_drawn_in_both_sets_of_equations() {
        let scale = Scale {
            x: 10.0,
            v: 60.0,
            k: 300.0,
            seconds: 22.0,
            high_hz: 8.0,
        };
        for (name, _, channel) in LIST {
            for equations in [Equations::Matched, Equations::Unseen] {
                let drawn = draw(name, *channel, equations, &scale, &mut Draws::new(1));
                let physics = drawn.unwrap_or_else(|| panic!("{name} {channel:?} {equations:?}"));
                assert!(0.0 < physics.range.0 && physics.range.0 < physics.range.1);
            }
        }
    }
}
