//! What each image for a chip consists of.

/// An image: the interrupt in which its control period runs, its board, and how many actuators it has if not one.
#[macro_export]
macro_rules! stm32_image {
    ($interrupt:ident, $board:ty $(, $actuators:literal)?) => {
        #[cfg(target_os = "none")]
        mod image {
            use embassy_stm32::interrupt;
            use $crate::chip::stm32::board::Board;
            use $crate::chip::stm32::{boot, control::ControlCell, fatal};

            static CONTROL: ControlCell<<$board as Board$(<$actuators>)?>::Converters $(, $actuators)?> =
                ControlCell::new();

            #[cortex_m_rt::entry]
            fn main() -> ! {
                boot::run::<$board, _>(&CONTROL)
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
