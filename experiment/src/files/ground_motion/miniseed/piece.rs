//! A part of a recording.

/// Samples may come this share of an interval before or after their time.
const PUNCTUAL: f64 = 0.5;

/// Samples of one channel without a gap.
pub(super) struct Piece {
    /// Network, station, location and channel.
    pub(super) channel: String,
    pub(super) start_us: i64,
    pub(super) rate_hz: f64,
    pub(super) values: Vec<f64>,
    /// True if they are a converter's whole numbers.
    pub(super) counts: bool,
}

impl Piece {
    /// What comes right after.
    pub(super) fn append(&mut self, next: Self) -> Result<(), String> {
        if next.channel != self.channel {
            return Err(format!(
                "is of channel {} and those before it of {}: accepted is one channel; ObsPy selects it",
                next.channel, self.channel
            ));
        }
        if (next.rate_hz / self.rate_hz - 1.0).abs() > 1e-4 {
            return Err(format!(
                "has {} Hz, those before it {} Hz: accepted is one rate",
                next.rate_hz, self.rate_hz
            ));
        }
        let end_us = self.start_us as f64 + 1e6 * self.values.len() as f64 / self.rate_hz;
        let late_s = 1e-6 * (next.start_us as f64 - end_us);
        if late_s.abs() * self.rate_hz > PUNCTUAL {
            return Err(format!(
                "begins {late_s:.3} s after the end of what is before it: accepted are records without a gap"
            ));
        }
        self.values.extend(next.values);
        Ok(())
    }
}

/// What is said of a record that ends too early.
pub(super) fn cut() -> String {
    "is cut short: accepted are whole records".into()
}

/// Microseconds from the year 1 to the second that these name: year, day of the year from 1, hour, minute, second.
pub(super) fn seconds_us([year, day, hour, minute, second]: [i64; 5]) -> i64 {
    let years = year - 1;
    let days = 365 * years + years / 4 - years / 100 + years / 400 + day;
    (((days * 24 + hour) * 60 + minute) * 60 + second) * 1_000_000
}
