//! The contents of each image for a chip.

/// An image: the interrupt of its control period, its board, the number of actuators if not one, and its own methods if
/// there are any, as in `stm32_image!(ADC, WithInternal; own METHODS)`.
#[cfg(feature = "stm32")]
#[macro_export]
macro_rules! stm32_image {
    ($interrupt:ident, $board:ty $(, $actuators:literal)? $(; own $own:expr)?) => {
        #[cfg(target_os = "none")]
        mod image {
            use embassy_stm32::interrupt;
            use $crate::chip::stm32::board::Board;
            use $crate::chip::stm32::{boot, control::ControlCell, fatal};

            static CONTROL: ControlCell<<$board as Board$(<$actuators>)?>::Converters $(, $actuators)?> =
                ControlCell::new();

            #[cortex_m_rt::entry]
            fn main() -> ! {
                // The first registration wins.
                $(let _ = $own.register();)?
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

/// The image for QEMU, with its own methods if there are any: `qemu_image!(own METHODS)`.
#[cfg(all(target_os = "none", feature = "qemu"))]
#[macro_export]
macro_rules! qemu_image {
    ($(own $own:expr)?) => {
        #[cortex_m_rt::entry]
        fn main() -> ! {
            // Declared first: `entry` hands it out once, as a reference.
            static mut POINTS: [f32; $crate::board::qemu::image::MAX_POINTS] =
                [0.0; $crate::board::qemu::image::MAX_POINTS];
            $(let _ = $own.register();)?
            $crate::board::qemu::image::main(POINTS)
        }

        #[panic_handler]
        fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
            $crate::board::qemu::exit(2)
        }

        #[cortex_m_rt::exception]
        unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
            $crate::board::qemu::exit(3)
        }
    };
}
