//! Distance between the beginnings of control steps, in stopwatch ticks.

/// Shortest and longest distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spacing {
    last: Option<u32>,
    shortest: Option<u32>,
    longest: u32,
}

impl Spacing {
    /// Nothing recorded yet.
    pub const fn new() -> Self {
        Self {
            last: None,
            shortest: None,
            longest: 0,
        }
    }

    /// A step begins at `now`; the counter may wrap. Returns whether it begins more than an eighth of a `period` early
    /// or late by this clock: the source of the period cannot notice that it has changed.
    #[inline]
    pub fn begin(&mut self, now: u32, period: u32) -> bool {
        let distance = self.last.map(|last| now.wrapping_sub(last));
        if let Some(distance) = distance {
            self.shortest = Some(self.shortest.unwrap_or(distance).min(distance));
            self.longest = self.longest.max(distance);
        }
        self.last = Some(now);
        distance.is_some_and(|distance| distance.abs_diff(period) > period / 8)
    }

    /// Shortest distance; 0 before the second step.
    pub fn shortest(&self) -> u32 {
        self.shortest.unwrap_or(0)
    }

    /// Longest distance.
    pub const fn longest(&self) -> u32 {
        self.longest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_the_shortest_and_the_longest() {
        let mut spacing = Spacing::new();
        for now in [u32::MAX - 50, 49, 150, 249] {
            assert!(!spacing.begin(now, 100));
        }
        assert_eq!((spacing.shortest(), spacing.longest()), (99, 101));
    }

    #[test]
    fn a_period_that_has_become_another_one_is_seen_by_another_clock() {
        let mut spacing = Spacing::new();
        assert!(!spacing.begin(u32::MAX, 100), "nothing was before it");
        for (now, is_wrong) in [
            (99, false),
            (211, false),
            (324, true),
            (412, false),
            (499, true),
        ] {
            assert_eq!(spacing.begin(now, 100), is_wrong, "{now}");
        }
    }
}
