//! The codes of the last samples, for zeroing a channel.

/// Samples in the window: 128 ms at 2 kHz, more than six periods of the mains.
pub const SAMPLES: usize = 256;

/// The last codes of one channel.
#[derive(Clone, Debug)]
pub struct Window {
    codes: [u16; SAMPLES],
    next: usize,
    full: bool,
}

impl Default for Window {
    fn default() -> Self {
        Self::new()
    }
}

impl Window {
    /// Empty.
    pub const fn new() -> Self {
        Self {
            codes: [0; SAMPLES],
            next: 0,
            full: false,
        }
    }

    /// Adds a code.
    pub fn add(&mut self, code: u16) {
        if let Some(place) = self.codes.get_mut(self.next) {
            *place = code;
        }
        self.next = (self.next + 1) % SAMPLES;
        self.full |= self.next == 0;
    }

    /// The last code.
    pub fn last(&self) -> u16 {
        let last = (self.next + SAMPLES - 1) % SAMPLES;
        self.codes.get(last).copied().unwrap_or(0)
    }

    /// Mean code, and largest minus smallest; `None` until the window is full.
    pub fn mean_and_spread(&self) -> Option<(f32, u16)> {
        let sum: u32 = self.codes.iter().map(|&c| u32::from(c)).sum();
        let largest = self.codes.iter().max()?;
        let smallest = self.codes.iter().min()?;
        self.full
            .then_some((sum as f32 / SAMPLES as f32, largest - smallest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_of_the_last_samples_only() {
        let mut window = Window::new();
        for _ in 0..SAMPLES - 1 {
            window.add(8000);
            assert_eq!(window.mean_and_spread(), None);
        }
        for i in 0..SAMPLES as u16 {
            window.add(100 + i % 2);
        }
        assert_eq!(window.mean_and_spread(), Some((100.5, 1)));
        assert_eq!(window.last(), 101);
    }
}
