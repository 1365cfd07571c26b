//! Mains hum in an actuator's reading: it is present at rest and hides other causes, so it is removed first.

use super::by_engine::without_mains;
use super::channel::{ChannelDiagnosis, Hum};
use super::heard::Heard;
use crate::criteria::FALSE_LINES;
use crate::criteria::LINES;
use crate::model::Model;
use crate::model::answer::{ChannelAnswer, FoundEffect, Verdict};
use crate::numbers::signals::{difference, rms};
use crate::prepare::noise::hum::lines_at_rest;
use plant::{Channel, Effect};

impl ChannelDiagnosis<'_> {
    /// The answer without the hum of the displacement's reading, with the hum named, if hum is much of what an answer leaves.
    pub(super) fn beside_hum(&self, with: &ChannelAnswer, model: &Model) -> Option<Heard> {
        let is_open = !matches!(with.verdict, Verdict::None | Verdict::NotAssessed);
        if self.base.channel != Channel::Actuator || !is_open {
            return None;
        }
        let [clean_train, clean_test, clean_rest] =
            [self.train, self.test, self.rest].map(without_mains);
        // Held-out data choose no name.
        let both = self.train.iter().zip(&clean_train);
        let longest = both.max_by_key(|(r, _)| r.time_s.len())?;
        let (x, clean) = (
            longest.0.displacement_mm.as_ref()?,
            longest.1.displacement_mm.as_ref()?,
        );
        let hum_mm = rms(&[difference(x, clean)]);
        let left_mm = rms(&with.residuals[0]);
        if hum_mm * hum_mm < LINES * left_mm * left_mm {
            return None;
        }
        let frequency_hz = *lines_at_rest(x, longest.0).first()?;
        let amplitude_mm = std::f64::consts::SQRT_2 * hum_mm;
        // Hum varies with other loads on the mains: by a tenth.
        let about = |x: f64, by: f64| [x - by, x + by];
        let bin_hz = 1.0 / (x.len() as f64 * longest.0.interval_s());
        let parameters = [
            (
                "amplitude_mm",
                "mm",
                amplitude_mm,
                about(amplitude_mm, 0.1 * amplitude_mm),
            ),
            (
                "frequency_hz",
                "Hz",
                frequency_hz,
                about(frequency_hz, bin_hz),
            ),
        ];
        let effect = FoundEffect {
            q: Some(FALSE_LINES),
            ..FoundEffect::new(Effect::MainsHum, parameters)
        };
        let quiet = ChannelDiagnosis {
            base: self.base.clone(),
            train: &clean_train,
            test: &clean_test,
            rest: &clean_rest,
            whole: None,
            hum: Some(Hum { effect, with }),
        };
        let mut beside = quiet.assess(model);
        if beside.found == Verdict::NotAssessed {
            return None;
        }
        beside.answer.notes.push(format!(
            "The displacement's reading has the mains, {frequency_hz:.2} Hz, at rest as in motion: another cable, a screen, a ground. \
             It is taken off before the rest is judged, and is not in the improved model: its phase is that of its own record."
        ));
        Some(beside)
    }
}
