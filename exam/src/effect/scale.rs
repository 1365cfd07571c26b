//! Wrong scale factors and wrong zeros.

use super::physics::{Channel, Physics, Scale, plus};
use crate::draws::Draws;
use crate::fine::DT;

pub(super) fn draw(
    name: &str,
    channel: Channel,
    unseen: bool,
    scale: &Scale,
    rng: &mut Draws,
) -> Option<Physics> {
    let actuator = channel == Channel::Actuator;
    let sign = rng.sign();
    let unit = if actuator { scale.x } else { scale.x * scale.k };
    Some(match name {
        "gain_error" if unseen => Physics::new(
            "a calibration that is off, and by 6 % more at the end of the range",
            (1e-3, 0.4),
            move |s, _, y| {
                y.iter()
                    .map(|y| y + sign * s * y * (1.0 + 0.06 * (y / unit).powi(2)))
                    .collect()
            },
        ),
        "gain_error" => Physics::new("(1 + e) y", (1e-3, 0.4), move |s, _, y| {
            y.iter().map(|y| (1.0 + sign * s) * y).collect()
        })
        .with(move |s| vec![("error", sign * s)]),
        "offset" => {
            let tau = rng.between(0.1, 0.3) * scale.seconds;
            let settling = if unseen { 0.08 } else { 0.0 };
            let parameter = if actuator { "offset_mm" } else { "offset_n" };
            let physics = Physics::new(
                if unseen {
                    "a wrong zero, of which a twelfth settles"
                } else {
                    "y + c"
                },
                (1e-4 * unit, 0.5 * unit),
                move |s, _, y| {
                    let time = (0..y.len()).map(|i| i as f64 * DT);
                    plus(
                        y,
                        time.map(|t| sign * s * (1.0 + settling * (-t / tau).exp())),
                    )
                },
            );
            if unseen {
                physics
            } else {
                physics.with(move |s| vec![(parameter, sign * s)])
            }
        }
        "rig_compliance" if unseen => Physics::new(
            "the frame gives way, and by a tenth more while its joints close",
            (1e-3, 0.6),
            move |s, _, y| {
                let left = |y: f64| y / (1.0 + s * (1.0 + 0.1 * (-(6.0 * y / unit).abs()).exp()));
                y.iter().map(|y| left(*y)).collect()
            },
        ),
        "rig_compliance" => {
            let k = scale.k;
            Physics::new("y / (1 + k / k_frame)", (1e-3, 0.6), move |s, _, y| {
                y.iter().map(|y| y / (1.0 + s)).collect()
            })
            .with(move |s| vec![("stiffness_n_per_mm", k / s)])
        }
        _ => return None,
    })
}
