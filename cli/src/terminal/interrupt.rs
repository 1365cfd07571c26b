//! Ctrl-C, SIGTERM (`kill`, a service that is stopped) and SIGHUP (a terminal that is closed) end work early: a moving
//! rig is brought to rest on the deceleration ramp, and completed work is kept.

use experiment::trace::{AnyRecord, TestObserver};
use outerloop_core::Event;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering::SeqCst};
use std::sync::{Once, OnceLock};
use std::time::{Duration, Instant};

static ASKED: AtomicBool = AtomicBool::new(false);
static WORK: AtomicU8 = AtomicU8::new(TESTS);
static CAUGHT: Once = Once::new();
static FIRST: OnceLock<Instant> = OnceLock::new();

/// What a signal ends: a series of tests, a test whose rig does not move yet, a moving rig.
const TESTS: u8 = 0;
const BEFORE_ARMING: u8 = 1;
const RIG: u8 = 2;

/// Signals this close together count as one: the shell and the system both report a closed terminal.
const TOGETHER: Duration = Duration::from_secs(1);

/// From now on the first signal ends the work early, and a later one ends the program.
pub fn watch() {
    CAUGHT.call_once(|| {
        if let Err(e) = ctrlc::set_handler(asked_again) {
            eprintln!("outerloop: note: Ctrl-C cannot be caught ({e}): it ends the program, and a board trips by itself");
        }
    });
}

/// The same while a rig moves.
pub fn watch_rig() {
    WORK.store(RIG, SeqCst);
    watch();
}

/// Until [`watch_rig`] is called, a signal ends the program at once and reports that nothing has moved: an image is being
/// built, a board searched for, a ground motion sent. Does nothing if signals are already watched, so that in a series
/// the completed tests are kept.
pub fn watch_before_arming() {
    if !CAUGHT.is_completed() {
        WORK.store(BEFORE_ARMING, SeqCst);
        watch();
    }
}

fn asked_again() {
    if WORK.load(SeqCst) == BEFORE_ARMING {
        eprintln!(
            "\nouterloop: ended by hand before the board was armed: nothing has moved, and nothing is recorded"
        );
        std::process::exit(1);
    }
    let first = *FIRST.get_or_init(Instant::now);
    if ASKED.swap(true, SeqCst) {
        if first.elapsed() > TOGETHER {
            std::process::exit(130);
        }
        return;
    }
    if WORK.load(SeqCst) == RIG {
        eprintln!(
            "\nouterloop: ends, and a rig that moves comes to rest on the deceleration ramp first; Ctrl-C again gives up the \
             link, and a board that moves trips"
        );
    } else {
        eprintln!("\nouterloop: ends after the tests that run now; Ctrl-C again ends at once");
    }
}

/// True if the work should end early.
pub fn asked() -> bool {
    ASKED.load(SeqCst)
}

/// An observer that then stops a simulated test.
#[derive(Clone, Copy, Debug)]
pub struct StopBySignal;

impl TestObserver for StopBySignal {
    #[inline]
    fn on_step(&mut self, _: &AnyRecord<'_>) {}

    #[inline]
    fn requested_event(&mut self) -> Option<Event> {
        asked().then_some(Event::Stop)
    }
}
