//! A proof by the linker: this image can only be linked if nothing in a control period can panic.
//!
//! Its panic handler calls a function that does not exist. As long as no path leads to a panic the handler is thrown
//! away and nobody misses the function. It is not meant to run: the loops it ticks lie in memory nobody has filled.

#![no_std]
#![no_main]

use core::hint::black_box;
use core::mem::MaybeUninit;
use firmware::control_loop::ControlLoop;
use firmware::converters::{Converters, Stopwatch};
use outerloop_core::{Event, GroundMotion, Sample};

unsafe extern "C" {
    /// Does not exist.
    fn a_control_period_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: never called; if it could be, there would be no image.
    unsafe { a_control_period_can_panic() }
}

/// A board of which the compiler knows nothing.
struct Unknown;

impl<const N: usize> Converters<N> for Unknown {
    fn sample(&mut self) -> Sample<N> {
        black_box(Sample::new([0.0; N], [0.0; N]))
    }

    fn command(&mut self, command_m: &[f32; N], permit: bool) {
        black_box((command_m, permit));
    }
}

impl Stopwatch for Unknown {
    fn between(earlier: u32, later: u32) -> u32 {
        later.wrapping_sub(earlier)
    }

    fn now(&self) -> u32 {
        black_box(0)
    }
}

#[inline(never)]
fn period<const N: usize>(control: &mut ControlLoop<N>) {
    let _ = black_box(control.handle(black_box(Event::Start)));
    black_box(control.tick(&mut Unknown, &Unknown, &black_box(GroundMotion::none())));
}

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut ONE: MaybeUninit<ControlLoop<1>> = MaybeUninit::uninit();
    static mut THREE: MaybeUninit<ControlLoop<3>> = MaybeUninit::uninit();
    static mut EIGHT: MaybeUninit<ControlLoop<8>> = MaybeUninit::uninit();
    loop {
        // SAFETY: none is claimed: the image is linked and looked at, not run.
        unsafe {
            period(black_box(&mut *ONE).assume_init_mut());
            period(black_box(&mut *THREE).assume_init_mut());
            period(black_box(&mut *EIGHT).assume_init_mut());
        }
        #[cfg(feature = "planted-panic")]
        black_box([0_u8; 4][black_box(1_usize)]);
    }
}
