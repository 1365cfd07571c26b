//! The image for the NUCLEO-F429ZI with its own converters of 12 bits, and our method.
#![cfg_attr(target_os = "none", no_std, no_main)]

firmware::stm32_image!(ADC, firmware::board::nucleo_f429zi::WithInternal; own lab::METHODS);
