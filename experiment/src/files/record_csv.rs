//! `record.csv`: every quantity of every control step, in the format of recorded data ([`super::recording`]).

use super::channels;
use crate::trace::Trace;
use std::fmt::Write as _;

/// The record as CSV. Values are in single precision, with as many digits as identify them, so that they read back to
/// the same bits; time is laboratory time.
pub fn to_csv(trace: &Trace) -> String {
    let columns = channels::of(trace);
    let mut text = String::with_capacity(trace.len() * 12 * (columns.len() + 3));
    text.push_str("time_s");
    for channel in &columns {
        let _ = write!(text, ",{}", channel.name);
    }
    text.push_str(",step_1,flags_1\n");
    for i in 0..trace.len() {
        let _ = write!(text, "{}", trace.time_s(i));
        for channel in &columns {
            let _ = write!(text, ",{:?}", channel.values[i]);
        }
        let _ = writeln!(text, ",{},{}", trace.step[i], trace.flags[i]);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::recording::SiRecording;
    use crate::trace::TestObserver;
    use outerloop_core::Record;

    #[test]
    fn reads_back_without_loss() {
        let mut trace = Trace::new(3, 2000.0);
        let mut word = 1_u32;
        let mut next = || {
            // Any finite bit pattern.
            word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let x = f32::from_bits(word);
            if x.is_finite() { x } else { 0.1 }
        };
        for i in 0..500 {
            let mut r = Record::<3>::EMPTY;
            (r.tick, r.step, r.flags) = (i + 7, i, u32::MAX - i);
            r.command_m = [next(), next(), next()];
            r.sent_m = [next(), next(), next()];
            r.force_n = [next(), next(), next()];
            r.gain = [next(), next(), next()];
            r.energy_sum.hsem_j = next();
            trace.on_step(&(&r).into());
        }
        let back = SiRecording::parse("record.csv", &to_csv(&trace)).unwrap();
        let same = |quantity: &str, axis: usize, values: &[f32]| {
            let read = &back.column(quantity, axis).unwrap().values;
            assert_eq!(read.len(), values.len());
            for (a, b) in read.iter().zip(values) {
                assert_eq!((*a as f32).to_bits(), b.to_bits(), "{quantity} {axis}");
            }
        };
        for j in 0..3 {
            same("command", j + 1, &trace.floors[j].sent_m);
            same("target", j + 1, &trace.floors[j].command_m);
            same("force", j + 1, &trace.floors[j].force_n);
            same("gain", j + 1, &trace.floors[j].gain);
        }
        same("energy_error_hsem", 1, &trace.energy_hsem_j);
        let flags = &back.column("flags", 1).unwrap().values;
        assert!(
            flags
                .iter()
                .zip(&trace.flags)
                .all(|(a, b)| *a == f64::from(*b))
        );
        assert!((0..500).all(|i| back.time_s[i] == trace.time_s(i)));
    }
}
