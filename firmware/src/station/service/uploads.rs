//! Points sent by the PC before a test: announced, taken in pieces, handed to the interrupt when complete.

use super::{CommandResult, Pending, Service};
use crate::station::order::Order;
use crate::station::upload::{Upload, Uploaded};
use link::reply::{RefusedParameter, Reply};

impl Service {
    pub(super) fn begin_motion(
        &mut self,
        points: u32,
        interval_s: f64,
        checksum: u32,
    ) -> CommandResult {
        self.uploaded_most = None;
        match Upload::new(points, interval_s, checksum) {
            Ok(upload) => self.order(Order::Unload, Pending::Upload(upload)),
            Err(refusal) => self.reply(refusal.into()),
        }
    }

    pub(super) fn take_points(&mut self, first: u32, points: &[f32]) -> CommandResult {
        // The memory is taken only for an announced upload: otherwise it would be lost.
        let Some(mut upload) = self.upload.take() else {
            return self.reply(Reply::Expected(0));
        };
        let Some(mut writable) = self.writable.take() else {
            return self.reply(Reply::Expected(0));
        };
        let uploaded = upload.take(writable.points(), first, points);
        match uploaded {
            Uploaded::Whole => {
                let points = writable.points().iter().take(upload.count());
                self.uploaded_most = Some(points.fold(0.0, |m: f32, p| m.max(p.abs())));
                match writable.load(upload.count(), upload.interval_s(), self.model_step_s) {
                    Ok(loaded) => self.order(Order::Load(loaded), Pending::Done),
                    Err(writable) => {
                        self.writable = Some(writable);
                        self.reply(Reply::Refused(RefusedParameter::new(
                            "motion.interval_s",
                            upload.interval_s(),
                            "at least a thousandth of the integration step",
                        )))
                    }
                }
            }
            uploaded => {
                self.writable = Some(writable);
                // Only a wrong sum ends the upload: everything else can be sent again.
                let reply = match uploaded {
                    Uploaded::WrongSum { received } => Reply::WrongSum { received },
                    other => {
                        self.upload = Some(upload);
                        other.reply(self.tick, self.mode)
                    }
                };
                self.reply(reply)
            }
        }
    }
}
