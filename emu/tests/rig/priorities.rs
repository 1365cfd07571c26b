//! Nothing delays the control interrupt: the priorities in the chip's interrupt controller while a test runs.

use crate::desk::Desk;
use outerloop_cli::board::Image;

/// Numbers of interrupts, RM0090: the supply's guard; then embassy's, the flash, two streams of DMA, TIM3, USART3.
const SUPPLY: u16 = 1;
const BACKGROUND: [u16; 5] = [4, 12, 14, 29, 39];

/// The interrupt of the control period: that of the chip's converters, or of TIM2.
const CONTROL: u16 = match crate::IMAGE {
    Image::Internal => 18,
    Image::External | Image::Three => 28,
};

/// The register with an interrupt's priority, one byte of it (ARMv7-M, B3.4.9).
fn priority_word(interrupt: u16) -> u64 {
    0xe000_e400 + u64::from(interrupt / 4 * 4)
}

#[test]
fn only_the_control_interrupt_and_the_supplys_are_above_what_critical_sections_mask() {
    let (mut desk, processor) = Desk::running_looked_into();
    let interrupts = [&BACKGROUND[..], &[CONTROL, SUPPLY]].concat();
    processor.look_at(interrupts.iter().map(|&i| priority_word(i)));
    for _ in 0..500 {
        desk.step();
    }
    let priority = |interrupt: u16| {
        let word = processor.found(priority_word(interrupt))?;
        Some(word >> (8 * (interrupt % 4)) & 0xff)
    };
    for interrupt in interrupts {
        println!("interrupt {interrupt}: priority {:?}", priority(interrupt));
    }
    for urgent in [CONTROL, SUPPLY] {
        assert_eq!(priority(urgent), Some(0x00), "interrupt {urgent}");
    }
    for background in BACKGROUND {
        assert_eq!(priority(background), Some(0x80), "interrupt {background}");
    }
    // All but priority 0 is masked, or nothing: 0 masks nothing, and a value above 0x80 would mask none of these.
    assert_eq!(
        processor.masks().into_iter().collect::<Vec<_>>(),
        [0x00, 0x10]
    );
}
