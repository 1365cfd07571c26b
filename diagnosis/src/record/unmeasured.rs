//! Unmeasured samples of a record: nothing is judged by them.

use crate::numbers::signals::{clear, difference};
use crate::record::recording::Recording;

impl Recording {
    /// The unmeasured samples.
    pub fn unmeasured(&self) -> Vec<usize> {
        let room = 0.5 * self.interval_s();
        let at = |t: &f64| {
            let i = self.time_s.partition_point(|own| own + room <= *t);
            let own = self.time_s.get(i)?;
            ((own - t).abs() < room).then_some(i)
        };
        self.unmeasured_s.iter().filter_map(at).collect()
    }

    /// Measured minus modelled, both over all samples: 0 where nothing was measured.
    pub(crate) fn residual(&self, measured: &[f64], modelled: &[f64]) -> Vec<f64> {
        let mut left = difference(measured, modelled);
        clear(&mut left, &self.unmeasured());
        left
    }
}
