//! The image for the NUCLEO-F429ZI with its own 12-bit converters.
#![cfg_attr(target_os = "none", no_std, no_main)]

// End of the four conversions.
firmware::stm32_image!(ADC, firmware::board::nucleo_f429zi::WithInternal);
