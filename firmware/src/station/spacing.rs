//! Distance between the beginnings of control steps, in ticks of the stopwatch.

/// Shortest and longest distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spacing {
    last: Option<u32>,
    shortest: Option<u32>,
    longest: u32,
}

impl Spacing {
    /// Nothing seen.
    pub const fn new() -> Self {
        Self {
            last: None,
            shortest: None,
            longest: 0,
        }
    }

    /// A step begins at `now`; the counter may turn over.
    #[inline]
    pub fn begin(&mut self, now: u32) {
        if let Some(last) = self.last {
            let distance = now.wrapping_sub(last);
            self.shortest = Some(self.shortest.unwrap_or(distance).min(distance));
            self.longest = self.longest.max(distance);
        }
        self.last = Some(now);
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
            spacing.begin(now);
        }
        assert_eq!((spacing.shortest(), spacing.longest()), (99, 101));
    }
}
