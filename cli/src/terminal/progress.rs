//! Progress shown while waiting.

use super::output;
use experiment::trace::{AnyRecord, TestObserver};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Steps between two checks of the clock.
const STEPS_A_TELL: u64 = 1 << 14;
/// Work that is done by then shows no bar.
const TIMEOUT: Duration = Duration::from_secs(1);

/// A bar on standard error for work that takes longer than a second; only on a terminal.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    began: Mutex<Option<Instant>>,
}

impl Progress {
    /// A bar over `steps` steps of work.
    pub fn over(what: &str, steps: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps), ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {percent} %, {eta} left")
        {
            bar.set_style(style);
        }
        bar.set_message(what.to_owned());
        Self {
            bar,
            began: Mutex::new(Some(Instant::now())),
        }
    }

    /// Reports `steps` more.
    pub fn add(&self, steps: u64) {
        self.bar.inc(steps);
        if let Ok(mut began) = self.began.lock()
            && began.is_some_and(|t| t.elapsed() > TIMEOUT)
            && !output::is_quiet()
        {
            *began = None;
            // indicatif itself stays silent if standard error is no terminal.
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }

    /// An observer that counts the steps of a test.
    pub fn observer(&self) -> Steps<'_> {
        Steps {
            progress: self,
            untold: 0,
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Does work of unknown length; after a second a spinner says what is being done, only on a terminal.
pub fn while_waiting<T>(what: &str, work: impl FnOnce() -> T) -> T {
    if output::is_quiet() {
        return work();
    }
    let spinner = ProgressBar::new_spinner().with_message(what.to_owned());
    spinner.enable_steady_tick(TIMEOUT);
    let done = work();
    spinner.finish_and_clear();
    done
}

/// Counts the steps of a test.
#[derive(Debug)]
pub struct Steps<'a> {
    progress: &'a Progress,
    untold: u64,
}

impl TestObserver for Steps<'_> {
    #[inline]
    fn on_step(&mut self, _: &AnyRecord<'_>) {
        self.untold += 1;
        if self.untold == STEPS_A_TELL {
            self.progress.add(self.untold);
            self.untold = 0;
        }
    }
}
