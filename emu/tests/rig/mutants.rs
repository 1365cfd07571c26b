//! Images with one register wrong: each is detected by its own register, and where the hardware would do nothing, nothing is
//! done. The write is corrupted between the image and the chip, as if the image had it wrong.

use crate::desk::{Bench, Desk};
use crate::mutant::Does::{Runs, SamplesNothing, ShowsNothing};
use crate::mutant::{Case, each_is_seen};
use emu::Mutant;
use emu::registers::*;
use link::Command;
use link::reply::{Obstacle, Reply};
use link::telemetry::StepReport;
use outerloop_core::{Event, Mode};

const CASES: [Case; 24] = [
    (
        "ADC1_CR2.JEXTSEL",
        ADC1_CR2,
        15 << 16,
        1 << 16,
        SamplesNothing,
    ),
    ("TIM2_CR2.MMS", TIM2_CR2, 7 << 4, 0, SamplesNothing),
    ("TIM4_SMCR.SMS", TIM4_SMCR, 7, 0, ShowsNothing),
    ("DAC_CR.EN1", DAC_CR, 1, 0, ShowsNothing),
    ("DAC_CR.TEN1", DAC_CR, 1 << 2, 0, Runs),
    ("DAC_CR.TSEL1", DAC_CR, 7 << 3, 4 << 3, ShowsNothing),
    ("GPIOA_MODER.PA4", GPIOA_MODER, 3 << 8, 0, ShowsNothing),
    ("ADC1_CR2.JEXTEN", ADC1_CR2, 3 << 20, 0, SamplesNothing),
    ("ADC1_JSQR", ADC1_JSQR, 31 << 10, 3 << 10, SamplesNothing),
    ("ADC1_SMPR2.SMP3", ADC1_SMPR2, 7 << 9, 0, SamplesNothing),
    ("ADC_CCR.ADCPRE", ADC_CCR, 3 << 16, 3 << 16, SamplesNothing),
    ("ADC1_SMPR1.SMP10", ADC1_SMPR1, 7, 0, SamplesNothing),
    ("TIM4_SMCR.TS", TIM4_SMCR, 7 << 4, 0, ShowsNothing),
    ("TIM4_CR1.OPM", TIM4_CR1, 1 << 3, 0, ShowsNothing),
    ("TIM4_CCMR1.OC1M", TIM4_CCMR1, 7 << 4, 6 << 4, ShowsNothing),
    ("TIM4_CCR1", TIM4_CCR1, 0xffff, 1680, Runs),
    ("TIM4_CR2.MMS", TIM4_CR2, 7 << 4, 2 << 4, ShowsNothing),
    // Recorded outside the control path: the test does not depend on it.
    ("ADC2_CR2.JEXTSEL", ADC2_CR2, 15 << 16, 1 << 16, Runs),
    ("ADC2_JSQR", ADC2_JSQR, 31 << 10, 12 << 10, Runs),
    ("ADC2_SMPR1.SMP12", ADC2_SMPR1, 7 << 6, 0, Runs),
    ("GPIOC_MODER.PC3", GPIOC_MODER, 3 << 6, 0, Runs),
    ("GPIOE_PUPDR.PE11", GPIOE_PUPDR, 3 << 22, 0, Runs),
    ("PWR_CR.PLS and PVDE", PWR_CR, 1 << 4, 0, Runs),
    ("EXTI_IMR.MR16", EXTI_IMR, 1 << 16, 0, Runs),
];

#[test]
fn further_inputs_of_a_converter_that_is_started_follow_the_output() {
    let mut desk = Desk::with(Bench::default());
    desk.start();
    desk.until(Mode::Finished);
    let running = |s: &StepReport| s.mode() == Some(Mode::Running);
    let steps: Vec<_> = desk.steps.iter().filter(|(_, s)| running(s)).collect();
    for input in 0..3 {
        let mut pairs = steps.windows(2);
        let moves = pairs.any(|w| w[0].1.inputs[input] != w[1].1.inputs[input]);
        assert!(moves, "input {input}");
    }
}

// proves: obstacle.converters by ADC2_CR2
#[test]
fn a_board_whose_further_converter_nothing_starts_cannot_be_armed() {
    let mut desk = Desk::with(Bench {
        mutant: Some(Mutant {
            address: ADC2_CR2,
            clear: 3 << 20,
            set: 0,
        }),
        ..Bench::default()
    });
    desk.load();
    let reply = desk.ask(Command::Event(Event::Arm));
    let converters = Some(Obstacle::Converters);
    assert!(
        matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == converters),
        "{reply:?}"
    );
}

#[test]
fn each_wrong_register_is_seen_for_what_it_is() {
    each_is_seen(&CASES);
}
