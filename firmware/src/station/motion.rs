//! The ground motion's memory, either written by the service or read by the loop, never both.
//!
//! 64 KiB are too much to have twice. The holder of a [`Writable`] may write, the holder of a [`Loaded`] may read; each
//! turns into the other, and there is only one.

use super::twice::Twice;
use core::cell::UnsafeCell;
use link::command::MAX_POINTS;
use outerloop_core::GroundMotion;

/// The memory.
pub struct Points(UnsafeCell<[f32; MAX_POINTS]>);

// SAFETY: the memory is accessed only through the one `Writable` or `Loaded` that came from `Points::claim`, and those
// follow the borrow rules.
unsafe impl Sync for Points {}

impl Points {
    /// Unclaimed memory.
    pub const fn new() -> Self {
        Self(UnsafeCell::new([0.0; MAX_POINTS]))
    }

    /// Claims the memory, permanently.
    pub fn claim(&'static mut self) -> Writable {
        Writable(self)
    }
}

impl Default for Points {
    fn default() -> Self {
        Self::new()
    }
}

/// The right to write.
pub struct Writable(&'static Points);

impl Writable {
    /// The memory.
    pub fn points(&mut self) -> &mut [f32; MAX_POINTS] {
        // SAFETY: this is the only handle to the memory, and it is borrowed mutably.
        unsafe { &mut *self.0.0.get() }
    }

    /// The first `count` points as a ground motion.
    ///
    /// # Errors
    /// There are too few points, or the times cannot be mapped; returns the right to write.
    pub fn load(self, count: usize, interval_s: f64, model_step_s: f64) -> Result<Loaded, Self> {
        // SAFETY: as above; nobody writes until `Loaded::unload` returns the right to write, and the reference leaves
        // `Loaded` only with its lifetime.
        let points: &'static [f32; MAX_POINTS] = unsafe { &*self.0.0.get() };
        let motion = points
            .get(..count)
            .and_then(|p| GroundMotion::new(p, interval_s, model_step_s));
        match motion {
            Some(motion) => Ok(Loaded {
                memory: self.0,
                motion: Twice::new(Laid(motion)),
                count,
                interval_s,
            }),
            None => Err(self),
        }
    }
}

/// A ground motion mapped onto the steps.
#[derive(Clone, Copy)]
struct Laid(GroundMotion<'static>);

impl PartialEq for Laid {
    fn eq(&self, other: &Self) -> bool {
        self.0.is(&other.0)
    }
}

/// The right to read a whole ground motion. Its mapping is kept twice: one wrong bit of its pace is another earthquake.
pub struct Loaded {
    memory: &'static Points,
    motion: Twice<Laid>,
    count: usize,
    interval_s: f64,
}

impl Loaded {
    /// The ground motion.
    pub const fn motion(&self) -> &GroundMotion<'_> {
        &self.motion.first().0
    }

    /// True if both copies agree.
    pub fn is_remembered(&self) -> bool {
        self.motion.agreed().is_some()
    }

    /// Corrupts one of the copies: it then describes no ground motion.
    #[cfg(not(target_os = "none"))]
    pub fn spoil(&mut self, copy: usize) {
        if let Some(laid) = self.motion.both().get_mut(copy) {
            laid.0 = GroundMotion::none();
        }
    }

    /// Number of points.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Interval of the points, s.
    pub fn interval_s(&self) -> f64 {
        self.interval_s
    }

    /// Exchanges the right to read for the right to write.
    pub fn unload(self) -> Writable {
        Writable(self.memory)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_and_can_be_written_again() {
        let mut writable = Box::leak(Box::new(Points::new())).claim();
        writable.points()[..3].copy_from_slice(&[0.0, 4.0, -4.0]);
        let loaded = writable.load(3, 0.02, 0.0005).ok().unwrap();
        assert_eq!(loaded.motion().steps(), 80);
        assert!((loaded.motion().at(40) - 4.0).abs() < 1e-5);
        let mut writable = loaded.unload();
        writable.points()[1] = 8.0;
        let loaded = writable.load(3, 0.02, 0.0005).ok().unwrap();
        assert!((loaded.motion().at(40) - 8.0).abs() < 1e-5);
    }

    #[test]
    fn more_points_than_there_are_or_no_time_between_them_is_refused() {
        let writable = Box::leak(Box::new(Points::new())).claim();
        let writable = writable.load(MAX_POINTS + 1, 0.02, 0.0005).err().unwrap();
        assert!(writable.load(3, 0.0, 0.0005).is_err());
    }
}
