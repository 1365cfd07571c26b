//! A proof by the linker: this image can only be linked if nothing in a control period can panic.
//!
//! Its panic handler calls a function that does not exist. As long as no path leads to a panic, the handler is
//! discarded and the function is never missed. It is not meant to run: its loops lie in uninitialised memory.

#![no_std]
#![no_main]

use core::hint::black_box;
use core::mem::MaybeUninit;
use firmware as _;
use outerloop_core::coupled::CoupledRig;
use outerloop_core::watch::Orders;
use outerloop_core::{Event, GroundMotion, OuterLoop, Rig, Sample};

unsafe extern "C" {
    /// Does not exist.
    fn a_control_period_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: never called; otherwise there would be no image.
    unsafe { a_control_period_can_panic() }
}

#[inline(never)]
fn period<const N: usize, R: Rig<N>>(outer: &mut OuterLoop<N, R>) {
    let _ = black_box(outer.handle(black_box(Event::Start)));
    outer.set_commissioning_command(black_box(None));
    outer.watch(black_box(true));
    if black_box(outer.count_watched()).is_some() {
        outer.obey(|in_force| *in_force = black_box(Orders::NONE));
        outer.end_watch();
    }
    let sample = black_box(Sample::new([0.0; N], [0.0; N]));
    black_box(outer.step(&sample, &black_box(GroundMotion::none())));
}

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut ONE: MaybeUninit<OuterLoop<1>> = MaybeUninit::uninit();
    static mut THREE: MaybeUninit<OuterLoop<3>> = MaybeUninit::uninit();
    static mut COUPLED: MaybeUninit<OuterLoop<3, CoupledRig>> = MaybeUninit::uninit();
    static mut EIGHT: MaybeUninit<OuterLoop<8>> = MaybeUninit::uninit();
    loop {
        // SAFETY: none is claimed: the image is linked and inspected, not run.
        unsafe {
            period(black_box(&mut *ONE).assume_init_mut());
            period(black_box(&mut *THREE).assume_init_mut());
            period(black_box(&mut *EIGHT).assume_init_mut());
            period(black_box(&mut *COUPLED).assume_init_mut());
        }
        #[cfg(feature = "planted-panic")]
        black_box([0_u8; 4][black_box(1_usize)]);
    }
}
