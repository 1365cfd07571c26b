//! The image for the NUCLEO-F429ZI with three actuators on external 16-bit converters.
#![cfg_attr(target_os = "none", no_std, no_main)]

// End of the conversion: a compare of the sampling timer.
firmware::stm32_image!(TIM2, firmware::board::nucleo_f429zi::WithExternalThree, 3);
