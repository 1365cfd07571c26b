//! Data kept across a reset: why the program died, in memory that the start leaves untouched.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU8, Ordering::Relaxed};
use link::frame::checksum;
use link::status::{CrashCause, CrashReport, StartCause};
use outerloop_core::Mode;

/// Largest encoded crash report, bytes.
const ROOM: usize = 160;

#[repr(C)]
struct Kept {
    length: u32,
    sum: u32,
    bytes: [u8; ROOM],
}

/// Untouched by the start: it holds what the program before the reset has left, or power-up noise.
#[unsafe(link_section = ".uninit.kept")]
static mut KEPT: MaybeUninit<Kept> = MaybeUninit::uninit();

static MODE: AtomicU8 = AtomicU8::new(Mode::Idle as u8);

/// Notes the control interrupt's mode after a step, for a crash report.
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
        // SAFETY: a plain store to memory of this type, by the only running code.
        unsafe { (&raw mut KEPT).cast::<Kept>().write_volatile(kept) };
    }
}

/// Discards what was kept: the announced end did not happen.
#[cold]
pub fn forget() {
    // SAFETY: a plain store, by the control interrupt, which nothing interrupts.
    unsafe { (&raw mut (*(&raw mut KEPT).cast::<Kept>()).length).write_volatile(0) };
}

/// Returns and discards what was kept. Must be called once, before the control interrupt runs.
pub fn take() -> Option<CrashReport> {
    let place = (&raw mut KEPT).cast::<Kept>();
    // SAFETY: plain numbers, for which every bit pattern is valid; nothing else runs yet.
    let kept = unsafe { place.read_volatile() };
    // SAFETY: as above.
    unsafe { (&raw mut (*place).length).write_volatile(0) };
    let coded = kept.bytes.get(..kept.length as usize)?;
    if coded.is_empty() || checksum(coded.iter().copied()) != kept.sum {
        return None;
    }
    postcard::from_bytes(coded).ok()
}

/// The crash report for this kind of start. A watchdog reset without an announcement is reported, too.
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
