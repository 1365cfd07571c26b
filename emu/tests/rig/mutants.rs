//! Images with one register wrong: each is seen, each by its own register, and where the metal would do nothing, nothing is
//! done. The write goes wrong on its way from the image to the chip, as if the image had it wrong.

use crate::desk::{Bench, Desk};
use emu::Mutant;
use emu::registers::*;
use std::time::{Duration, Instant};

/// What a mutant does to the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Does {
    /// No sample is taken: not one control step.
    SamplesNothing,
    /// The output pin never leaves where the start has put it, or floats.
    ShowsNothing,
    /// It runs, and the registers alone show what is wrong.
    Runs,
}
use Does::{Runs, SamplesNothing, ShowsNothing};

type Case = (&'static str, u64, u64, u64, Does);

/// The demand that is not met, the register, bits cleared and set in it, and what follows.
const CASES: [Case; 20] = [
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
    ("GPIOE_PUPDR.PE11", GPIOE_PUPDR, 3 << 22, 0, Runs),
    ("PWR_CR.PLS and PVDE", PWR_CR, 1 << 4, 0, Runs),
    ("EXTI_IMR.MR16", EXTI_IMR, 1 << 16, 0, Runs),
];

#[test]
fn the_image_itself_meets_every_demand() {
    let desk = Desk::new(None);
    wait(&desk, 50);
    let log = desk.log();
    let found: Vec<String> = log.violations.iter().map(ToString::to_string).collect();
    assert_eq!(found, [""; 0]);
    assert!(log.triggers_ns.len() > 40);
}

#[test]
fn each_wrong_register_is_seen_for_what_it_is() {
    let wrong: Vec<String> = CASES.iter().filter_map(|case| run(case).err()).collect();
    assert_eq!(wrong, [""; 0]);
}

/// What is not as the case says.
fn run(&(name, address, clear, set, does): &Case) -> Result<(), String> {
    let desk = Desk::with(Bench {
        mutant: Some(Mutant {
            address,
            clear,
            set,
        }),
        ..Bench::default()
    });
    wait(&desk, 60);
    let log = desk.log();
    let found: Vec<&str> = log.violations.iter().map(|v| v.demand.name).collect();
    if found != [name] {
        return Err(format!("{name}: seen is {found:?}"));
    }
    println!("{}", log.violations[0]);
    let samples = log.triggers_ns.len();
    let commands = log.step_instructions.len();
    // What the pin shows while it does not float; the start shows the position, and a working output follows it.
    let shown: Vec<_> = log.pin.iter().flatten().collect();
    let stands = shown.windows(2).skip(2).all(|w| w[0] == w[1]);
    let as_said = match does {
        SamplesNothing => samples == 0 && commands == 0,
        ShowsNothing => samples > 40 && commands > 40 && stands,
        Runs => samples > 40 && commands > 40,
    };
    as_said.then_some(()).ok_or(format!(
        "{name}: {samples} samples, {commands} commands, the pin stands: {stands}"
    ))
}

/// Until the laboratory has seen so many periods of a running timer.
fn wait(desk: &Desk, periods: usize) {
    let began = Instant::now();
    // Before the timer runs the laboratory takes some hundred turns.
    loop {
        let log = desk.log();
        let since = log.periods;
        if since >= periods {
            return;
        }
        assert!(
            began.elapsed() < Duration::from_secs(60),
            "the board does not start"
        );
        std::thread::sleep(Duration::from_millis(20));
    }
}
