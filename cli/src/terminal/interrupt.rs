//! Ctrl-C, SIGTERM (`kill`, a service that is stopped) and SIGHUP (a terminal that is closed) end work early: a rig that moves
//! is brought to rest on the deceleration ramp, and what is done is kept.

use experiment::trace::{AnyRecord, TestObserver};
use outerloop_core::Event;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::{Once, OnceLock};
use std::time::{Duration, Instant};

static ASKED: AtomicBool = AtomicBool::new(false);
static MOVES: AtomicBool = AtomicBool::new(false);
static FIRST: OnceLock<Instant> = OnceLock::new();

/// Signals that come together are one wish: a closed terminal is told by the shell and by the system.
const TOGETHER: Duration = Duration::from_secs(1);

/// From now on the first signal lets the work end early, and a later one ends the program.
pub fn watch() {
    static CAUGHT: Once = Once::new();
    CAUGHT.call_once(|| {
        if let Err(e) = ctrlc::set_handler(asked_again) {
            eprintln!("outerloop: note: Ctrl-C cannot be caught ({e}): it ends the program, and a board trips by itself");
        }
    });
}

/// The same where a rig moves.
pub fn watch_rig() {
    MOVES.store(true, SeqCst);
    watch();
}

fn asked_again() {
    let first = *FIRST.get_or_init(Instant::now);
    if ASKED.swap(true, SeqCst) {
        if first.elapsed() > TOGETHER {
            std::process::exit(130);
        }
        return;
    }
    if MOVES.load(SeqCst) {
        eprintln!(
            "\nouterloop: ends, and a rig that moves comes to rest on the deceleration ramp first; Ctrl-C again gives up the \
             link, and a board that moves trips"
        );
    } else {
        eprintln!("\nouterloop: ends after the tests that run now; Ctrl-C again ends at once");
    }
}

/// True if the work is to end early.
pub fn asked() -> bool {
    ASKED.load(SeqCst)
}

/// An observer that stops a simulated test then.
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
