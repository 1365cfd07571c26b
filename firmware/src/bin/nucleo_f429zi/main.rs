//! The image for the NUCLEO-F429ZI with its own converters of 12 bits.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use embassy_stm32::interrupt;
    use firmware::board::nucleo_f429zi::control::Owned;
    use firmware::board::nucleo_f429zi::internal::Internal;
    use firmware::board::nucleo_f429zi::{boot, fatal};

    static CONTROL: Owned<Internal> = Owned::new();

    #[cortex_m_rt::entry]
    fn main() -> ! {
        boot::run(&CONTROL)
    }

    /// End of the four conversions.
    #[interrupt]
    fn ADC() {
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
    eprintln!("nucleo_f429zi is a board's image: build it with scripts/cross");
    std::process::exit(2);
}
