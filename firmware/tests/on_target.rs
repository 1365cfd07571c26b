//! On the NUCLEO-F429ZI itself, with PA4 (the DAC) wired to PA3 and PC0 (the ADC) and nothing else connected:
//!
//! ```text
//! scripts/cross test -p firmware --release --test on_target --features on-target
//! ```
//!
//! What no emulator shows: the converters, the hardware triggers between the timers and them, the flash.
#![cfg_attr(target_os = "none", no_std, no_main)]
// The macro of the tests asks for a configuration that only rust-analyzer sets.
#![allow(unexpected_cfgs)]

/// The host has no such board.
#[cfg(not(target_os = "none"))]
fn main() {
    println!("not run: on_target needs the board; see its first lines");
}

#[cfg(all(target_os = "none", test))]
#[embedded_test::tests]
mod tests {
    use cortex_m::peripheral::DWT;
    use defmt_rtt as _;
    use embassy_stm32::flash::Flash;
    use embassy_stm32::gpio::{Level, Output, Speed};
    use embassy_stm32::{Peripherals, pac};
    use firmware::board::nucleo_f429zi::{CODES, Internal, Irqs, lower_priorities};
    use firmware::chip::stm32::converters::Converters;
    use firmware::chip::stm32::metal::start_cycle_counter;
    use firmware::chip::this::adc::Sensors;
    use firmware::chip::this::clocks;
    use firmware::chip::this::dac::DacOutput;
    use firmware::chip::this::period::Period;
    use firmware::chip::this::store::{Memory, Store};
    use firmware::station::Wiring;
    use link::channel::Calibration;
    use outerloop_core::Config;

    /// 2 kHz, in ticks of the timer.
    const PERIOD_TICKS: u32 = 42_000;

    const OUTPUT_DELAY_US: u32 = Internal::OUTPUT_DELAY_US;

    /// The lowest and the highest code that the DAC's buffer reaches.
    const SPAN: core::ops::RangeInclusive<u16> = 300..=3800;

    struct Bench {
        external_clock: bool,
        p: Peripherals,
    }

    #[init]
    fn init() -> Bench {
        let mut core = cortex_m::Peripherals::take().unwrap();
        start_cycle_counter(&mut core);
        let external_clock = clocks::external_clock_is_right();
        lower_priorities();
        let p = embassy_stm32::init(clocks::tree(external_clock));
        clocks::finish(external_clock);
        Bench { external_clock, p }
    }

    fn feed() {
        pac::IWDG
            .kr()
            .write(|w| w.set_key(pac::iwdg::vals::Key::RESET));
    }

    /// The next sample that the timer has asked for, and when it was there.
    fn next(sensors: &mut Sensors) -> (u16, u16, u32) {
        loop {
            if let Some([displacement, force]) = sensors.codes() {
                feed();
                return (displacement, force, DWT::cycle_count());
            }
        }
    }

    #[test]
    fn the_st_link_gives_8_mhz(bench: Bench) {
        assert!(bench.external_clock);
    }

    #[test]
    #[timeout(20)]
    fn what_the_dac_shows_both_channels_read(bench: Bench) {
        let p = bench.p;
        let mut sensors = Sensors::new(p.ADC1, p.PA3, p.PC0);
        let command = DacOutput::new(p.DAC1, p.PA4, *SPAN.start());
        let mut period = Period::new(p.TIM2, p.TIM4, PERIOD_TICKS, OUTPUT_DELAY_US);
        period.start();
        let mut last = 0;
        for shown in SPAN.step_by(100) {
            command.write(shown);
            // One period until the DAC takes it over, one until it is sampled, one to be sure.
            let (mut d, mut f, _) = next(&mut sensors);
            for _ in 0..3 {
                (d, f, _) = next(&mut sensors);
            }
            // Offset, gain and noise of both converters: 1 % of the range.
            for read in [d, f] {
                assert!(read.abs_diff(2 * shown) < 82, "{shown}: {read}");
            }
            assert!(d > last, "{shown}: {d} after {last}");
            last = d;
        }
    }

    #[test]
    fn samples_come_every_period_to_the_cycle(bench: Bench) {
        let p = bench.p;
        let mut sensors = Sensors::new(p.ADC1, p.PA3, p.PC0);
        let mut period = Period::new(p.TIM2, p.TIM4, PERIOD_TICKS, OUTPUT_DELAY_US);
        period.start();
        let (_, _, mut before) = next(&mut sensors);
        for _ in 0..2000 {
            let (_, _, now) = next(&mut sensors);
            // The polling loop itself takes some cycles to see it.
            let off = now.wrapping_sub(before).abs_diff(2 * PERIOD_TICKS);
            assert!(off < 100, "{off}");
            before = now;
        }
    }

    #[test]
    fn the_dac_takes_a_command_over_at_its_instant(bench: Bench) {
        let p = bench.p;
        let command = DacOutput::new(p.DAC1, p.PA4, 1000);
        let mut period = Period::new(p.TIM2, p.TIM4, PERIOD_TICKS, OUTPUT_DELAY_US);
        let ticks_per_us = clocks::TIMER_HZ / 1_000_000;
        period.start();
        for shown in [2000, 1000, 3000] {
            feed();
            while pac::TIM2.cnt().read() < PERIOD_TICKS - 1000 {}
            command.write(shown);
            while pac::TIM2.cnt().read() > PERIOD_TICKS / 2 {}
            while pac::DAC1.dor(0).read().dor() != shown {
                assert!(pac::TIM2.cnt().read() < 100 * ticks_per_us);
            }
            let at = pac::TIM2.cnt().read();
            let expected = OUTPUT_DELAY_US * ticks_per_us;
            assert!(at >= expected && at < expected + ticks_per_us, "{at}");
        }
    }

    #[test]
    fn permit_follows(bench: Bench) {
        let mut permit = Output::new(bench.p.PE9, Level::Low, Speed::Low);
        for level in [true, false, true, false] {
            permit.set_level(Level::from(level));
            cortex_m::asm::delay(1000);
            let pin = pac::GPIOE.idr().read().idr(9);
            assert_eq!(pin == pac::gpio::vals::Idr::HIGH, level);
        }
    }

    /// What is there is written again; where nothing is, a test and a calibration of converters that no board has, which no
    /// start takes for one: a board that nobody has calibrated stays so.
    #[test]
    fn saved_settings_come_back(bench: Bench) {
        let mut store = Store::new(Flash::new(bench.p.FLASH, Irqs));
        let nothing = Config::shear_frame([1000.0], [158e3], [0.02]);
        let test = Memory.test().unwrap_or_else(|| nothing.into());
        let of_no_board = Wiring {
            calibration: Calibration::placeholder(&CODES),
            tops: [1, 1],
            actuators: 1,
        };
        let before = Memory.calibration(0);
        let was_calibrated = before.and_then(|wiring| wiring.of(&CODES, 1)).is_some();
        let wiring = before.unwrap_or(of_no_board);
        feed();
        let wirings = [Some(wiring)];
        let saving = store.save(Some(&test), &wirings);
        assert!(embassy_futures::block_on(saving));
        let after = Memory.calibration(0);
        assert!(Memory.test() == Some(test) && after == Some(wiring));
        let is_calibrated = after.and_then(|wiring| wiring.of(&CODES, 1)).is_some();
        assert_eq!(is_calibrated, was_calibrated);
    }
}
