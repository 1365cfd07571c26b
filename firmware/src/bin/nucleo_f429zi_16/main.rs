//! The image for the NUCLEO-F429ZI with external converters of 16 bits.
#![cfg_attr(target_os = "none", no_std, no_main)]

// The conversion is over: a compare of the sampling timer.
firmware::stm32_image!(TIM2, firmware::board::nucleo_f429zi::WithExternal);
