//! A live view in the browser while a test runs, with a few buttons. It is not the emergency stop.
//!
//! ```text
//!  control steps ─► see ─► decimate ─► every 20 ms to each browser (server, WebSocket)
//!                   ▲                                   │
//!                   └─────── event ◄──── Hold, Stop, Resume, Clear
//! ```
//!
//! A browser sees every peak: for all steps of a point the smallest and largest value are sent. It does not disturb the
//! test: a step is handed over in memory, and a browser that reads too slowly is dropped.

mod decimate;
mod server;

use decimate::{Band, StepColumns};
use experiment::failure::Failure;
use experiment::trace::{AnyRecord, TestObserver};
use outerloop_core::{Event, Mode};
use server::Shared;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Steps between two checks of the clock, if the scope sets the pace.
const PACE_STEPS: u64 = 16;

/// A page that is being served.
pub struct Scope {
    shared: Arc<Shared>,
    /// If the simulated rig runs by the wall clock, as in a laboratory: its start, and its steps.
    clock: Option<(Instant, u64)>,
    rate_hz: f64,
}

impl Scope {
    /// Opens the page and prints its address. `real_time`: the test runs by the wall clock.
    ///
    /// # Errors
    /// An address that cannot be bound.
    pub fn open(
        address: SocketAddr,
        title: &str,
        rate_hz: f64,
        real_time: bool,
    ) -> Result<Self, Failure> {
        let shared = server::open(address, title, rate_hz)?;
        eprintln!("outerloop: the scope is at {}", shared.url());
        Ok(Self {
            shared,
            clock: real_time.then(|| (Instant::now(), 0)),
            rate_hz,
        })
    }

    fn show(&mut self, record: &AnyRecord<'_>) {
        self.shared.take(
            record.mode().unwrap_or(Mode::Idle),
            &Band::of(record),
            &StepColumns::of(record),
        );
        if let Some((began, steps)) = &mut self.clock {
            *steps += 1;
            if *steps % PACE_STEPS == 0 {
                let due = Duration::from_secs_f64(*steps as f64 / self.rate_hz);
                std::thread::sleep(due.saturating_sub(began.elapsed()));
            }
        }
    }
}

impl TestObserver for Scope {
    fn on_step(&mut self, record: &AnyRecord<'_>) {
        self.show(record);
    }

    fn on_idle_step(&mut self, record: &AnyRecord<'_>) {
        self.show(record);
    }

    fn requested_event(&mut self) -> Option<Event> {
        self.shared.requested_event()
    }

    fn on_watch(&mut self, said: &str) {
        self.shared.take_watch(said);
    }
}

impl Drop for Scope {
    fn drop(&mut self) {
        self.shared.end();
    }
}

/// `--scope`: a page in the browser with what happens.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub struct Scoped {
    /// Show the running test in a browser, at this address; left out: 127.0.0.1 and a free port
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = "127.0.0.1:0")]
    scope: Option<SocketAddr>,
}

impl Scoped {
    /// True if one was requested.
    pub fn is_wanted(&self) -> bool {
        self.scope.is_some()
    }

    /// The scope, if requested.
    ///
    /// # Errors
    /// As [`Scope::open`].
    pub fn open(
        &self,
        title: &str,
        rate_hz: f64,
        real_time: bool,
    ) -> Result<Option<Scope>, Failure> {
        let open = |address| Scope::open(address, title, rate_hz, real_time);
        self.scope.map(open).transpose()
    }
}
