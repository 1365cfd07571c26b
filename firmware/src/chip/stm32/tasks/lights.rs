//! The lamps. What they mean is in `docs/wiring.md`.

use crate::chip::stm32::drill;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use embassy_stm32::gpio::{Level, Output};
use embassy_time::{Duration, Ticker};
use outerloop_core::Mode;

/// Mode and fault of the last step sent.
static FLAGS: AtomicU32 = AtomicU32::new(0);

/// Shows a control step's record.
pub fn show(flags: u32) {
    FLAGS.store(flags, Relaxed);
}

/// The three lamps.
#[expect(missing_docs, reason = "named by their colours")]
pub struct Lamps {
    pub green: Output<'static>,
    pub blue: Output<'static>,
    pub red: Output<'static>,
}

/// The common beat of all patterns.
const BEAT: Duration = Duration::from_millis(100);

/// Beats of a flash and the pause after it.
const FLASH: u32 = 4;

/// The task.
#[embassy_executor::task]
pub async fn task(mut lamps: Lamps, crystal_ok: bool, crashed: bool) {
    let mut beat = Ticker::every(BEAT);
    // Beats since the red pattern began.
    let (mut red, mut last_fault) = (0_u32, 0);
    for count in 0_u32.. {
        drill::background();
        let flags = FLAGS.load(Relaxed);
        let fault = flags >> 8 & 0xff;
        let mode = Mode::from_code(flags & 0xf);
        let moving = mode.is_some_and(Mode::permits_motion);
        lamps.green.set_level(Level::from(match mode {
            Some(Mode::Running | Mode::Resuming | Mode::Commissioning) => true,
            Some(_) => count % 10 == 0,
            None => false,
        }));
        lamps.blue.set_level(Level::from(moving));
        if fault != last_fault {
            (red, last_fault) = (0, fault);
        }
        lamps.red.set_level(Level::from(match (crystal_ok, fault) {
            (false, _) => count % 2 == 0,
            // As many flashes as the fault's number, then a pause as long as three.
            (true, 1..) => red / FLASH < fault && red % FLASH < FLASH / 2,
            (true, 0) => crashed,
        }));
        red = (red + 1) % (FLASH * (fault + 3));
        beat.next().await;
    }
}
