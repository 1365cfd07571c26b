//! What each of the NUCLEO-F429ZI's images consists of.

/// An image: the interrupt in which its control period runs, the converters that it works on, how many actuators if not one.
#[macro_export]
macro_rules! nucleo_f429zi_image {
    ($interrupt:ident, $converters:ty $(, $actuators:literal)?) => {
        #[cfg(target_os = "none")]
        mod image {
            use embassy_stm32::interrupt;
            use $crate::board::nucleo_f429zi::{boot, control::ControlCell, fatal};

            static CONTROL: ControlCell<$converters $(, $actuators)?> = ControlCell::new();

            #[cortex_m_rt::entry]
            fn main() -> ! {
                boot::run(&CONTROL)
            }

            #[interrupt]
            fn $interrupt() {
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
            let name = env!("CARGO_BIN_NAME");
            eprintln!("{name} is a board's image: build it with scripts/cross");
            std::process::exit(2);
        }
    };
}
