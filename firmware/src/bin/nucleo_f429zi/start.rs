//! From the reset to the first control step.

use crate::control::{self, Control};
use crate::{lights, listen, report};
use core::cell::RefCell;
use cortex_m::Peripherals;
use defmt_rtt as _;
use embassy_executor::Executor;
use embassy_stm32::flash::Flash;
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::usart::{Config as Serial, Uart};
use embassy_stm32::wdg::IndependentWatchdog;
use firmware::board::nucleo_f429zi::metal::{Metal, WATCHDOG_US, cycles};
use firmware::board::nucleo_f429zi::sampling::{CODES, Command, OUTPUT_DELAY_US, Period, Sensors};
use firmware::board::nucleo_f429zi::store::{Memory, Store};
use firmware::board::nucleo_f429zi::{Irqs, clocks, fatal, guard_supply, kept, lower_priorities};
use firmware::board::stack::HighWater;
use firmware::station::{
    Board, Clock, Ends, Evidence, Order, Outcome, Parts, Points, Report, Service, Setup, Station,
};
use heapless::spsc::Queue;
use link::channel::{Calibration, ErrorFeedback};
use outerloop_core::{Config, Refusal};
use static_cell::{ConstStaticCell, StaticCell};

/// What the board's clocks allow. A step has to be ready when the DAC takes its command over; the four conversions take
/// 13 us of that time.
const CLOCK: Clock = Clock {
    timer_hz: clocks::TIMER_HZ,
    // A period of 10 ms; the watchdog's shortest time is 17 ms.
    slowest_rate_hz: 100,
    fastest_rate_hz: link::fastest_rate_hz(link::BAUD),
    deadline_ticks: (OUTPUT_DELAY_US - 15) * (clocks::CORE_HZ / 1_000_000),
    // Some 110 instructions and two divisions, from a flash that is not in the cache.
    around_step_ticks: 400,
    stopwatch_hz: clocks::CORE_HZ,
};

defmt::timestamp!("{=u64:us}", embassy_time::Instant::now().as_micros());

#[cortex_m_rt::entry]
fn main() -> ! {
    static EVIDENCE: Evidence = Evidence::new();
    static ORDERS: StaticCell<Queue<Order, 4>> = StaticCell::new();
    static OUTCOMES: StaticCell<Queue<Outcome, 4>> = StaticCell::new();
    static REPORTS: StaticCell<Queue<Report, 128>> = StaticCell::new();
    static POINTS: ConstStaticCell<Points> = ConstStaticCell::new(Points::new());
    static SERVICE: StaticCell<RefCell<Service>> = StaticCell::new();
    static ANSWERS: StaticCell<report::Answers> = StaticCell::new();
    static RECEIVED: ConstStaticCell<[u8; 2048]> = ConstStaticCell::new([0; 2048]);
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();

    let stack = HighWater::paint();
    fatal::note_evidence(&EVIDENCE);
    let started = kept::start();
    let last_words = kept::last_words(started);
    if let Some(mut core) = Peripherals::take() {
        clocks::start_cycle_counter(&mut core);
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

    let (setup, config, saved) = settings();
    let calibration = saved.unwrap_or(Calibration::placeholder(&CODES));
    let mut sensors = Sensors::new(p.ADC1, p.PA3, p.PC0);
    let first = sensors.first().unwrap_or_else(middle);
    let command = Command::new(p.DAC1, p.PA4, standing(&calibration, first[0]));
    let mut period = Period::new(p.TIM2, p.TIM4, setup.period_ticks);

    let (orders_in, orders_out) = ORDERS.init(Queue::new()).split();
    let (outcomes_in, outcomes_out) = OUTCOMES.init(Queue::new()).split();
    let (reports_in, reports_out) = REPORTS.init(Queue::new()).split();
    let in_force = (setup.rate_hz, setup.model_step_s);
    let board = Board {
        name: "NUCLEO-F429ZI",
        commit: env!("OUTERLOOP_COMMIT"),
        clock: CLOCK,
        now: cycles,
        codes: CODES,
        output_delay_us: OUTPUT_DELAY_US as f32,
        crystal_ok,
        started,
        last_words,
    };
    let crashed = board.last_words.is_some();
    let parts = Parts {
        orders: orders_in,
        spare: spare(),
        writable: POINTS.take().claim(),
        config,
        calibration: saved,
    };
    let service: &'static RefCell<Service> =
        SERVICE.init(RefCell::new(Service::new(board, parts, in_force)));
    let ends = Ends {
        orders: orders_out,
        outcomes: outcomes_in,
        reports: reports_in,
    };
    let per_tick = clocks::CORE_HZ / clocks::TIMER_HZ;
    let station = Station::new(setup, calibration, first, &EVIDENCE, ends, per_tick);

    let serial = uart(p.USART3, p.PD9, p.PD8, p.DMA1_CH3, p.DMA1_CH1);
    let (tx, rx) = serial.split();
    let rx = rx.into_ring_buffered(RECEIVED.take());
    let answers: &'static report::Answers = ANSWERS.init(report::Answers::new());
    let store = Store::new(Flash::new(p.FLASH, Irqs));

    let mut watchdog = IndependentWatchdog::new(p.IWDG, WATCHDOG_US);
    watchdog.unleash();
    watchdog.pet();
    period.start();
    control::begin(Control {
        station,
        metal: Metal {
            sensors,
            command,
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
        evidence: &EVIDENCE,
        store,
        stack,
    };
    let reporter = report::Reporter {
        reports: reports_out,
        service,
        answers,
        evidence: &EVIDENCE,
    };
    EXECUTOR.init(Executor::new()).run(|spawner| {
        spawner.spawn(defmt::unwrap!(listen::task(listener, rx)));
        spawner.spawn(defmt::unwrap!(report::task(reporter, tx)));
        spawner.spawn(defmt::unwrap!(lights::task(lamps, crystal_ok, crashed)));
    })
}

/// The test to begin with: the saved one, else one that cannot be armed.
#[inline(never)]
fn settings() -> (&'static mut Setup, Option<Config>, Option<Calibration>) {
    static FIRST: StaticCell<Setup> = StaticCell::new();
    let calibration = Memory.calibration().and_then(|wiring| wiring.of(&CODES));
    let Some(config) = Memory.test() else {
        return (unconfigured(&FIRST), None, calibration);
    };
    match place(&FIRST, Some(&config)) {
        Ok(setup) => (setup, Some(config), calibration),
        Err(refusal) => {
            defmt::warn!("the saved test is refused now: {=str}", refusal.name);
            (unconfigured(&FIRST), None, calibration)
        }
    }
}

/// The place for the next test.
fn spare() -> &'static mut Setup {
    static SPARE: StaticCell<Setup> = StaticCell::new();
    unconfigured(&SPARE)
}

fn unconfigured(cell: &'static StaticCell<Setup>) -> &'static mut Setup {
    // The clock's constants allow 2 kHz; a test on the host says so too.
    defmt::unwrap!(place(cell, None).ok())
}

/// Works a test out where it stays. A test is a quarter of the stack: what it passes through must not add up.
#[inline(never)]
fn place(
    cell: &'static StaticCell<Setup>,
    config: Option<&Config>,
) -> Result<&'static mut Setup, Refusal> {
    let setup = config.map_or_else(
        || Setup::unconfigured(&CLOCK),
        |config| Setup::new(config, &CLOCK),
    );
    setup.map(|setup| cell.init(setup))
}

/// Codes of a converter that does not answer: the first step will find its samples stale.
fn middle() -> [u16; 2] {
    [CODES.sensor_top / 2; 2]
}

/// The command's code that holds the actuator where the displacement says that it is; at the end of the DAC's range if
/// that is further out, and there PERMIT cannot be given.
fn standing(calibration: &Calibration, displacement: u16) -> u16 {
    let position_m = calibration.displacement.quantity(displacement);
    let line = &calibration.command;
    ErrorFeedback::new()
        .code(calibration, CODES.command_top, position_m)
        .unwrap_or_else(|| {
            let above = position_m / line.per_code + line.zero_code > 0.0;
            if above { CODES.command_top } else { 0 }
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

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    fatal::panicked(info)
}
