//! The emulator's processor, and its translations of the image.
//!
//! Two thirds of the time of a short scenario went into translating the image's instructions, because the emulator discards its
//! translations at each reset and when the memory protection is switched on. So one processor runs until the image has closed
//! its stack guard, and a second one from then on. A reset goes back to the first and leaves the second alone. At the end of a
//! board the second one is kept too, and the program's next board with the same image uses it. State is passed between the two
//! by saving and loading a snapshot.

use crate::flash::Mapped;
use crate::registers::MPU_CTRL;
use rigless::emulator::{Error, Processor, Queued};
use rigless::soc::Width;
use rigless::time::VirtualNanos;
use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hasher};
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The bit of [`MPU_CTRL`] that switches the memory protection on.
const ENABLE: u64 = 1;

/// Addresses of the image.
const FIRST_BANK: Range<u64> = 0x0800_0000..0x0810_0000;

/// Largest number of processors kept for later boards: three threads run boards at the same time, and some images are used only
/// once.
const MOST_KEPT: usize = 6;

static KEPT: Mutex<Vec<Kept>> = Mutex::new(Vec::new());

fn kept() -> MutexGuard<'static, Vec<Kept>> {
    KEPT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A processor without a board.
struct Kept {
    image: u64,
    /// Its memory: start, length and whether it is writable. All of it is mapped anew before it runs.
    ranges: Vec<(u64, u64, bool)>,
    processor: Box<dyn Processor>,
}

/// Memory of this process that represents the chip's.
#[derive(Clone, Copy, Debug)]
struct Mapping {
    start: u64,
    length: u64,
    host: usize,
    writable: bool,
}

type Make = Box<dyn Fn() -> Result<Box<dyn Processor>, Error> + Send>;

/// The processor of a board.
pub(crate) struct Cores {
    make: Make,
    unguarded: Box<dyn Processor>,
    guarded: Option<Box<dyn Processor>>,
    /// Whether the second one runs.
    is_guarded: bool,
    mapped: Vec<Mapping>,
    /// Requested by the run, and not part of the processor's state; so are the breakpoints.
    routed: BTreeSet<u64>,
    breakpoints: Vec<u64>,
    /// Ranges of memory that is not writable (the flash) that have changed since the image was hashed.
    changed: Vec<Range<u64>>,
    image: u64,
}

impl std::fmt::Debug for Cores {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.now().fmt(formatter)
    }
}

impl Cores {
    /// A new processor, made by `make`.
    pub(crate) fn new(make: Make) -> Result<Self, Error> {
        Ok(Self {
            unguarded: make()?,
            make,
            guarded: None,
            is_guarded: false,
            mapped: Vec::new(),
            routed: BTreeSet::new(),
            breakpoints: Vec::new(),
            changed: Vec::new(),
            image: 0,
        })
    }

    /// The processor that runs.
    pub(crate) fn now(&self) -> &dyn Processor {
        match &self.guarded {
            Some(guarded) if self.is_guarded => guarded.as_ref(),
            _ => self.unguarded.as_ref(),
        }
    }

    /// The processor that runs.
    pub(crate) fn now_mut(&mut self) -> &mut dyn Processor {
        match &mut self.guarded {
            Some(guarded) if self.is_guarded => guarded.as_mut(),
            _ => self.unguarded.as_mut(),
        }
    }

    /// Calls `tell` with each processor.
    pub(crate) fn each(&mut self, mut tell: impl FnMut(&mut dyn Processor)) {
        tell(self.unguarded.as_mut());
        if let Some(guarded) = &mut self.guarded {
            tell(guarded.as_mut());
        }
    }

    /// See [`Processor::map`].
    ///
    /// # Safety
    /// The same as for that function.
    pub(crate) unsafe fn map(&mut self, start: u64, length: u64, host: *mut u8, writable: bool) {
        self.mapped.push(Mapping {
            start,
            length,
            host: host as usize,
            writable,
        });
        // SAFETY: the caller's guarantee is passed on.
        unsafe { self.unguarded.map(start, length, host, writable) };
    }

    /// See [`Processor::ask`].
    pub(crate) fn ask(&mut self, queued: Queued) {
        match queued {
            Queued::Route(address) => {
                self.routed.insert(address);
            }
            Queued::Unroute(address) => {
                self.routed.remove(&address);
            }
            Queued::Invalidate(start, end) => self.changed(start..end),
            Queued::Line(..) | Queued::Return => {}
        }
        self.now_mut().ask(queued);
    }

    /// Notes that these bytes have changed, of which the processor has already been told.
    pub(crate) fn changed(&mut self, range: Range<u64>) {
        let is_written =
            |m: &Mapping| m.writable && (m.start..m.start + m.length).contains(&range.start);
        if !self.mapped.iter().any(is_written) && !self.changed.contains(&range) {
            self.changed.push(range);
        }
    }

    /// See [`Processor::add_breakpoint`].
    pub(crate) fn add_breakpoint(&mut self, address: u64) -> bool {
        let can = self.now_mut().add_breakpoint(address);
        if can {
            self.breakpoints.push(address);
        }
        can
    }

    /// See [`Processor::remove_breakpoint`].
    pub(crate) fn remove_breakpoint(&mut self, address: u64) {
        if let Some(place) = self.breakpoints.iter().position(|kept| *kept == address) {
            self.breakpoints.swap_remove(place);
        }
        self.now_mut().remove_breakpoint(address);
    }

    /// After a run of instructions: the second processor takes over once the stack guard is closed.
    pub(crate) fn after_a_stretch(&mut self, memory: &Mapped) {
        if self.is_guarded {
            return;
        }
        let control = (self.unguarded).debugger_access(None, MPU_CTRL, Width::W32, VirtualNanos(0));
        if control.is_none_or(|control| control & ENABLE == 0) {
            return;
        }
        if self.guarded.is_none() {
            self.image = image(memory);
            self.changed.clear();
            let Some(mut guarded) = self.taken().or_else(|| (self.make)().ok()) else {
                return;
            };
            for m in &self.mapped {
                let host = m.host as *mut u8;
                // SAFETY: the run has mapped it for the life of this board; after that its pages are not accessed until all of
                // them have been mapped anew.
                unsafe { guarded.map(m.start, m.length, host, m.writable) };
            }
            self.guarded = Some(guarded);
        }
        self.hand_over(true);
    }

    /// See [`Processor::reset`].
    pub(crate) fn reset(&mut self) {
        if self.is_guarded {
            self.hand_over(false);
        }
        self.now_mut().reset();
    }

    /// Lets the other processor continue from the state of this one; if it refuses the state, this one continues.
    fn hand_over(&mut self, to_guarded: bool) {
        let state = self.now().save();
        self.told(false);
        self.is_guarded = to_guarded;
        if self.now_mut().load(&state).is_err() {
            self.is_guarded = !to_guarded;
        }
        self.told(true);
    }

    /// Puts the run's requests that are not part of the processor's state into force, or out of it.
    fn told(&mut self, in_force: bool) {
        let (routed, breakpoints) = (self.routed.clone(), self.breakpoints.clone());
        let now = self.now_mut();
        for address in routed {
            now.ask(if in_force {
                Queued::Route(address)
            } else {
                Queued::Unroute(address)
            });
        }
        for address in breakpoints {
            if in_force {
                now.add_breakpoint(address);
            } else {
                now.remove_breakpoint(address);
            }
        }
    }

    fn ranges(&self) -> Vec<(u64, u64, bool)> {
        let of = |m: &Mapping| (m.start, m.length, m.writable);
        self.mapped.iter().map(of).collect()
    }

    /// A kept processor that has run this image.
    fn taken(&self) -> Option<Box<dyn Processor>> {
        let ranges = self.ranges();
        let mut kept = kept();
        let fits = |kept: &Kept| kept.image == self.image && kept.ranges == ranges;
        let place = kept.iter().position(fits)?;
        Some(kept.remove(place).processor)
    }
}

/// At the end of a board the second processor is kept, with its translations of the image but nothing that this board has written.
impl Drop for Cores {
    fn drop(&mut self) {
        if self.is_guarded {
            self.told(false);
        }
        // A panic may have left a translation half made.
        if std::thread::panicking() {
            return;
        }
        let ranges = self.ranges();
        let Some(mut processor) = self.guarded.take() else {
            return;
        };
        let written = ranges.iter().filter(|(.., writable)| *writable);
        let written = written.map(|(start, length, _)| *start..start + length);
        for range in written.chain(self.changed.drain(..)) {
            processor.ask(Queued::Invalidate(range.start, range.end));
        }
        let mut kept = kept();
        if kept.len() == MOST_KEPT {
            kept.remove(0);
        }
        kept.push(Kept {
            image: self.image,
            ranges,
            processor,
        });
    }
}

/// A hash of the first bank's contents.
fn image(memory: &Mapped) -> u64 {
    let mut hasher = DefaultHasher::new();
    for byte in FIRST_BANK.map_while(|address| memory.byte(address)) {
        hasher.write_u8(byte);
    }
    hasher.finish()
}
