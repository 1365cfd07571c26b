//! What is shown while one waits.

use super::output;
use experiment::trace::{AnyRecord, TestObserver};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Steps between two looks at the clock.
const STEPS_A_TELL: u64 = 1 << 14;
/// Work that is over by then shows no bar.
const TIMEOUT: Duration = Duration::from_secs(1);

/// A bar on standard error for work that takes longer than a second, where somebody looks at a terminal.
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

    /// Tells of `steps` more.
    pub fn add(&self, steps: u64) {
        self.bar.inc(steps);
        if let Ok(mut began) = self.began.lock()
            && began.is_some_and(|t| t.elapsed() > TIMEOUT)
            && !output::is_quiet()
        {
            *began = None;
            // indicatif itself stays silent where standard error is no terminal.
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
    }

    /// The observer that counts a test's steps.
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

/// Does work of unknown length; beyond a second a spinner says what is being done, where somebody looks at a terminal.
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
