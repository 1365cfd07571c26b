//! The image for the NUCLEO-F429ZI with three actuators behind external converters of 16 bits.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use embassy_stm32::interrupt;
    use firmware::board::nucleo_f429zi::control::Owned;
    use firmware::board::nucleo_f429zi::{boot, fatal};
    use firmware::board::nucleo_f429zi_3::Three;

    static CONTROL: Owned<Three, 3> = Owned::new();

    #[cortex_m_rt::entry]
    fn main() -> ! {
        boot::run(&CONTROL)
    }

    /// The conversion is over: a compare of the sampling timer.
    #[interrupt]
    fn TIM2() {
        // SAFETY: this is the control interrupt.
        unsafe { CONTROL.period() };
    }

    #[panic_handler]
    fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
        fatal::panicked(info)
    }
}

/// The host has no such board.
#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("nucleo_f429zi_3 is a board's image: build it with scripts/cross");
    std::process::exit(2);
}
