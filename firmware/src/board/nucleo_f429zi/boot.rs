//! From the reset to the first control step, the same for every kind of converters.
//!
//! Nothing may move the actuator: PERMIT is low, the position is read, the output gets it before it is enabled, and the
//! sampling timer starts last.

use super::control::{Control, ControlCell};
use super::converters::{Converters, Resources, StartedConverters};
use super::core_coupled::CoreCoupled;
use super::metal::{Metal, WATCHDOG_US, cycles};
use super::store::{Memory, Store};
use super::tasks::{lights, listen, report};
use super::{Irqs, clocks, core_coupled, fatal, guard_supply, kept, lower_priorities, stack_guard};
use crate::board::stack::HighWater;
use crate::station::{
    Board, Clock, Heartbeats, Order, Outcome, Parts, Points, QueueEnds, Service, Setup, Station,
    WatchParts,
};
use core::cell::RefCell;
use cortex_m::Peripherals;
use defmt_rtt as _;
use embassy_executor::Executor;
use embassy_stm32::flash::Flash;
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::usart::{Config as Serial, Uart};
use embassy_stm32::wdg::IndependentWatchdog;
use heapless::spsc::Queue;
use link::CodeRange;
use link::channel::{Calibration, ErrorFeedback};
use outerloop_core::{Config, Refusal};
use static_cell::{ConstStaticCell, StaticCell};

/// What the board's clocks allow. A step has to be ready when the output takes its command over.
const fn clock<C: Converters<A>, const A: usize>() -> Clock {
    let per_us = clocks::CORE_HZ / 1_000_000;
    Clock {
        timer_hz: clocks::TIMER_HZ,
        // A period of 10 ms; the watchdog's shortest time is 17 ms.
        slowest_rate_hz: 100,
        fastest_rate_hz: link::fastest_rate_hz(link::BAUD, A, C::INPUTS.len()),
        deadline_ticks: (C::OUTPUT_DELAY_US - C::BEGINS_US) * per_us,
        around_step_ticks: C::AROUND_STEP_CYCLES,
        stopwatch_hz: clocks::CORE_HZ,
    }
}

defmt::timestamp!("{=u64:us}", embassy_time::Instant::now().as_micros());

/// Starts the board and runs its tasks for good. `control` is where the image's control interrupt finds what it owns.
#[inline(always)] // Into the image's entry: the frame of the start is at the bottom of the stack anyway.
pub fn run<C: Converters<A>, const A: usize>(control: &'static ControlCell<C, A>) -> ! {
    static HEARTBEATS: Heartbeats = Heartbeats::new();
    static ORDERS: StaticCell<Queue<Order, 4>> = StaticCell::new();
    static OUTCOMES: StaticCell<Queue<Outcome, 4>> = StaticCell::new();
    static POINTS: ConstStaticCell<Points> = ConstStaticCell::new(Points::new());
    static ANSWERS: StaticCell<report::ReplyQueue> = StaticCell::new();
    static RECEIVED: ConstStaticCell<[u8; 2048]> = ConstStaticCell::new([0; 2048]);
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();

    let stack = HighWater::paint();
    fatal::note_heartbeats(&HEARTBEATS);
    let started = kept::start();
    let last_crash = kept::crash_before(started);
    if let Some(mut core) = Peripherals::take() {
        clocks::start_cycle_counter(&mut core);
        stack_guard::close(&mut core.MPU);
    }
    let crystal_ok = clocks::external_clock_is_right();
    lower_priorities();
    let p = embassy_stm32::init(clocks::tree(crystal_ok));
    clocks::finish(crystal_ok);

    guard_supply();

    let permit = Output::new(p.PE9, Level::Low, Speed::Low);
    let pulse = Output::new(p.PE14, Level::Low, Speed::Low);
    let chain = Input::new(p.PE15, Pull::Down);
    let button = Input::new(p.PC13, Pull::Down);
    let stop = Input::new(p.PE11, Pull::Up);
    let step = Output::new(p.PE13, Level::Low, Speed::Medium);
    // See the wiring: what reading the second bank of the flash needs on early chips.
    core::mem::forget(Output::new(p.PA12, Level::Low, Speed::Low));
    let lamps = lights::Lamps::new(p.PB0, p.PB7, p.PB14);
    defmt::info!(
        "started: {}, external clock right: {}",
        defmt::Debug2Format(&started),
        crystal_ok
    );

    let clock = const { clock::<C, A>() };
    let (setup, config) = settings(&clock, A);
    let saved: [Option<Calibration>; A] = core::array::from_fn(|actuator| {
        let wiring = Memory.calibration(actuator);
        wiring.and_then(|wiring| wiring.of(&C::CODES))
    });
    let placeholder = Calibration::placeholder(&C::CODES);
    let calibrations = saved.map(|saved| saved.unwrap_or(placeholder));
    let resources = Resources {
        adc1: p.ADC1,
        adc2: p.ADC2,
        dac1: p.DAC1,
        spi1: p.SPI1,
        spi3: p.SPI3,
        tim2: p.TIM2,
        tim4: p.TIM4,
        pa3: p.PA3,
        pa4: p.PA4,
        pa5: p.PA5,
        pa6: p.PA6,
        pb10: p.PB10,
        pb11: p.PB11,
        pc0: p.PC0,
        pc2: p.PC2,
        pc3: p.PC3,
        pc10: p.PC10,
        pc11: p.PC11,
        pc12: p.PC12,
        pd2: p.PD2,
        pd12: p.PD12,
        pd14: p.PD14,
        pf12: p.PF12,
    };
    let StartedConverters {
        converters,
        mut period,
        first,
        answered,
    } = C::new(resources, setup.period_ticks, |actuator, displacement| {
        let calibration = calibrations.get(actuator).unwrap_or(&placeholder);
        code_at_standstill(calibration, &C::CODES, displacement)
    });

    let (orders_in, orders_out) = ORDERS.init(Queue::new()).split();
    let (outcomes_in, outcomes_out) = OUTCOMES.init(Queue::new()).split();
    // The start comes here once.
    let CoreCoupled {
        reports,
        blocks,
        answers,
        watches,
    } = defmt::unwrap!(core_coupled::claim());
    let (reports_in, reports_out) = reports.split();
    let (blocks_in, blocks_out) = blocks.split();
    let (answers_in, answers_out) = answers.split();
    let in_force = (setup.rate_hz, setup.model_step_s);
    let board = Board {
        name: C::NAME,
        commit: env!("OUTERLOOP_COMMIT"),
        clock,
        now: cycles,
        codes: C::CODES,
        actuators: A,
        inputs: C::INPUTS,
        input_span_v: C::INPUT_SPAN_V,
        output_delay_us: C::OUTPUT_DELAY_US as f32,
        crystal_ok,
        converters_ok: answered,
        started,
        last_crash,
    };
    let crashed = board.last_crash.is_some();
    let parts = Parts {
        orders: orders_in,
        spare: spare(&clock, A),
        writable: POINTS.take().claim(),
        config,
        calibrations: saved.into_iter().collect(),
        watch: WatchParts {
            watches,
            blocks: blocks_out,
            answers: answers_in,
        },
    };
    let service = service(board, parts, in_force);
    let ends = QueueEnds {
        orders: orders_out,
        outcomes: outcomes_in,
        reports: reports_in,
        blocks: blocks_in,
        answers: answers_out,
    };
    let per_tick = clocks::CORE_HZ / clocks::TIMER_HZ;
    let station = Station::new(setup, calibrations, first, &HEARTBEATS, ends, per_tick);

    let serial = uart(p.USART3, p.PD9, p.PD8, p.DMA1_CH3, p.DMA1_CH1);
    let (tx, rx) = serial.split();
    let rx = rx.into_ring_buffered(RECEIVED.take());
    let answers: &'static report::ReplyQueue = ANSWERS.init(report::ReplyQueue::new());
    let store = Store::new(Flash::new(p.FLASH, Irqs));

    let mut watchdog = IndependentWatchdog::new(p.IWDG, WATCHDOG_US);
    watchdog.unleash();
    watchdog.pet();
    period.start();
    control.begin(Control {
        station,
        metal: Metal {
            converters,
            period,
            permit,
            pulse,
            chain,
            button,
            stop,
            step,
            watchdog,
            starving: false,
        },
    });
    let listener = listen::Listener {
        service,
        outcomes: outcomes_out,
        answers,
        heartbeats: &HEARTBEATS,
        store,
        stack,
    };
    let reporter = report::Reporter {
        reports: reports_out,
        service,
        answers,
        heartbeats: &HEARTBEATS,
        channels: (A, C::INPUTS.len()),
    };
    EXECUTOR.init(Executor::new()).run(|spawner| {
        spawner.spawn(defmt::unwrap!(listen::task(listener, rx)));
        spawner.spawn(defmt::unwrap!(report::task(reporter, tx)));
        spawner.spawn(defmt::unwrap!(lights::task(lamps, crystal_ok, crashed)));
    })
}

/// The test to begin with: the saved one, else one that cannot be armed.
#[inline(never)]
fn settings(clock: &Clock, actuators: usize) -> (&'static mut Setup, Option<Config>) {
    static FIRST: Place = Place::new();
    let setup = unconfigured(&FIRST, clock, actuators);
    let Some(config) = Memory.test() else {
        return (setup, None);
    };
    match setup.replace(&config, clock, actuators) {
        Ok(()) => (setup, Some(config)),
        Err(refusal) => {
            defmt::warn!("the saved test is refused now: {=str}", refusal.name);
            (setup, None)
        }
    }
}

/// The service where it stays: what it passes through is not on the stack any more when the tasks stand on the start.
#[inline(never)]
fn service(board: Board, parts: Parts, in_force: (f32, f64)) -> &'static RefCell<Service> {
    static SERVICE: StaticCell<RefCell<Service>> = StaticCell::new();
    SERVICE.init_with(|| RefCell::new(Service::new(board, parts, in_force)))
}

/// The place for the next test.
fn spare(clock: &Clock, actuators: usize) -> &'static mut Setup {
    static SPARE: Place = Place::new();
    unconfigured(&SPARE, clock, actuators)
}

/// Where a test stays.
type Place = StaticCell<Result<Setup, Refusal>>;

/// A test that cannot be armed, worked out where it stays. A test is a sixth of the stack: what it passes through must not
/// add up.
#[inline(never)]
fn unconfigured(place: &'static Place, clock: &Clock, actuators: usize) -> &'static mut Setup {
    let first = place.init_with(|| Setup::unconfigured(clock, actuators));
    // The clock's constants allow 2 kHz; a test on the host says so too.
    defmt::unwrap!(first.as_mut().ok())
}

/// The command's code that holds the actuator where the displacement says that it is; at the end of the DAC's range if
/// that is further out, and there PERMIT cannot be given.
fn code_at_standstill(calibration: &Calibration, codes: &CodeRange, displacement: u16) -> u16 {
    let position_m = calibration.displacement.quantity(displacement);
    let line = &calibration.command;
    ErrorFeedback::new()
        .code(calibration, codes.command_top, position_m)
        .unwrap_or_else(|| {
            let above = position_m / line.per_code + line.zero_code > 0.0;
            if above { codes.command_top } else { 0 }
        })
}

use embassy_stm32::Peri;
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH1, DMA1_CH3, PD8, PD9, USART3};

fn uart(
    usart: Peri<'static, USART3>,
    rx: Peri<'static, PD9>,
    tx: Peri<'static, PD8>,
    tx_dma: Peri<'static, DMA1_CH3>,
    rx_dma: Peri<'static, DMA1_CH1>,
) -> Uart<'static, Async> {
    let mut config = Serial::default();
    config.baudrate = link::BAUD;
    defmt::unwrap!(Uart::new(usart, rx, tx, tx_dma, rx_dma, Irqs, config))
}
