//! What is kept across a reset: why the program died, in memory that the start does not touch.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU8, Ordering::Relaxed};
use link::frame::checksum;
use link::status::{CrashCause, CrashReport, StartCause};
use outerloop_core::Mode;

/// Bytes of a coded crash report, at most.
const ROOM: usize = 160;

#[repr(C)]
struct Kept {
    length: u32,
    sum: u32,
    bytes: [u8; ROOM],
}

/// Untouched by the start: it holds what the program before the reset has left, or the noise of power-up.
#[unsafe(link_section = ".uninit.kept")]
static mut KEPT: MaybeUninit<Kept> = MaybeUninit::uninit();

static MODE: AtomicU8 = AtomicU8::new(Mode::Idle as u8);

/// The control interrupt's mode after a step, for a crash report.
#[inline]
pub fn note_mode(mode: Mode) {
    MODE.store(mode as u8, Relaxed);
}

/// The last noted mode.
pub fn noted_mode() -> Mode {
    let code = MODE.load(Relaxed);
    Mode::ALL
        .into_iter()
        .find(|&s| s as u8 == code)
        .unwrap_or(Mode::Idle)
}

/// Keeps `words` until [`take`]. For the control interrupt and for the end of the program, which nothing interrupts.
pub fn keep(words: &CrashReport) {
    let mut kept = Kept {
        length: 0,
        sum: 0,
        bytes: [0; ROOM],
    };
    if let Ok(coded) = postcard::to_slice(words, &mut kept.bytes) {
        kept.length = coded.len() as u32;
        kept.sum = checksum(coded.iter().copied());
        // SAFETY: a plain store to memory of this type, by the only one who is running.
        unsafe { (&raw mut KEPT).cast::<Kept>().write_volatile(kept) };
    }
}

/// Forgets what was kept: it has not come to the end that was announced.
#[cold]
pub fn forget() {
    // SAFETY: a plain store, by the control interrupt, which nobody interrupts.
    unsafe { (&raw mut (*(&raw mut KEPT).cast::<Kept>()).length).write_volatile(0) };
}

/// What was kept; it is forgotten. To be called once, before the control interrupt runs.
pub fn take() -> Option<CrashReport> {
    let place = (&raw mut KEPT).cast::<Kept>();
    // SAFETY: plain numbers, every pattern of bits is one; nobody else runs yet.
    let kept = unsafe { place.read_volatile() };
    // SAFETY: as above.
    unsafe { (&raw mut (*place).length).write_volatile(0) };
    let coded = kept.bytes.get(..kept.length as usize)?;
    if coded.is_empty() || checksum(coded.iter().copied()) != kept.sum {
        return None;
    }
    postcard::from_bytes(coded).ok()
}

/// The crash report that belongs to such a start. A watchdog that nobody has announced is news too.
pub fn crash_before(start: StartCause) -> Option<CrashReport> {
    match (start, take()) {
        (StartCause::Power | StartCause::BrownOut, _) => None,
        (StartCause::Watchdog, None) => Some(CrashReport {
            cause: CrashCause::Silent,
            tick: 0,
            mode: Mode::Idle,
            text: link::reply::cut("the control interrupt stopped"),
        }),
        (_, words) => words,
    }
}
