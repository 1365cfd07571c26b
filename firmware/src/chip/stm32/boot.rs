//! From reset to the first control step, the same for every chip, board and kind of converters.
//!
//! Nothing may move the actuator: PERMIT is low, the position is read, the output is set to it before it is enabled,
//! and the sampling timer starts last.

use super::board::Board;
use super::control::{Control, ControlCell};
use super::converters::{Converters, StartedConverters};
use super::metal::{Metal, WATCHDOG_US, cycles, no_fault_halts_the_core, start_cycle_counter};
use super::tasks::report::{self, SharedService, Waiting};
use super::tasks::{lights, listen};
use super::{fatal, kept, stack_guard};
use crate::board::this as wiring;
use crate::chip::stack::HighWater;
use crate::chip::this::core_coupled::{self, CoreCoupled};
use crate::chip::this::store::{Memory, Store};
use crate::chip::this::{clocks, reset, supply};
use crate::station::{
    Board as Facts, Clock, FromWatch, Heartbeats, Judged, Order, Outcome, Parts, Points, QueueEnds,
    Report, Service, Setup, Station, WatchParts, Writable,
};
use crate::step_time::CORRECTION_CYCLES;
use core::cell::RefCell;
use defmt_rtt as _;
use embassy_executor::{Executor, Spawner};
use embassy_stm32::Peri;
use embassy_stm32::flash::Flash;
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use heapless::spsc::{Consumer, Producer, Queue};
use link::CodeRange;
use link::channel::{Calibration, ErrorFeedback};
use link::command::BoardTest;
use link::status::{CrashReport, StartCause};
use outerloop_core::Refusal;
use static_cell::{ConstStaticCell, StaticCell};

/// The limits of the board's clocks. A step must be ready when the output takes its command over.
const fn clock<C: Converters<A>, const A: usize>() -> Clock {
    let per_us = clocks::CORE_HZ / 1_000_000;
    Clock {
        timer_hz: clocks::TIMER_HZ,
        // A period of 10 ms; the watchdog's shortest time is 17 ms.
        slowest_rate_hz: 100,
        fastest_rate_hz: link::fastest_rate_hz(link::BAUD, A, C::INPUTS.len()),
        deadline_ticks: (C::OUTPUT_DELAY_US - C::BEGINS_US) * per_us,
        late_deadline_ticks: (C::LATE_OUTPUT_DELAY_US - C::BEGINS_US) * per_us,
        around_step_ticks: C::AROUND_STEP_CYCLES,
        correction_ticks: CORRECTION_CYCLES,
        stopwatch_hz: clocks::CORE_HZ,
    }
}

defmt::timestamp!("{=u64:us}", embassy_time::Instant::now().as_micros());

static HEARTBEATS: Heartbeats = Heartbeats::new();

/// Starts the board and runs its tasks forever. `control` is where the image's control interrupt finds its state.
#[inline(always)] // Into the image's entry: the start's frame is at the bottom of the stack anyway.
pub fn run<B: Board<A>, const A: usize>(control: &'static ControlCell<B::Converters, A>) -> ! {
    static ANSWERS: StaticCell<report::ReplyQueue> = StaticCell::new();
    static RECEIVED: ConstStaticCell<[u8; 2048]> = ConstStaticCell::new([0; 2048]);

    let stack = HighWater::paint();
    let (mut about, p) = start_chip();
    let wired = B::wire(p);
    defmt::info!(
        "started: {}, external clock right: {}",
        defmt::Debug2Format(&about.started),
        about.crystal_ok
    );
    let clock = const { clock::<B::Converters, A>() };
    let (setup, test) = settings(&clock, A);
    let saved = saved_calibrations::<A>(&B::Converters::CODES);
    let placeholder = Calibration::placeholder(&B::Converters::CODES);
    let calibrations = saved.map(|saved| saved.unwrap_or(placeholder));
    let StartedConverters {
        converters,
        period,
        first,
        answered,
    } = B::Converters::new(
        wired.converters,
        setup.period_ticks,
        |actuator, displacement| {
            let calibration = calibrations.get(actuator).unwrap_or(&placeholder);
            code_at_standstill(calibration, &B::Converters::CODES, displacement)
        },
    );

    let (ends, tasks) = queues();
    let (crystal_ok, crashed) = (about.crystal_ok, about.last_crash.is_some());
    let in_force = (setup.rate_hz, setup.model_step_s);
    let leaves_late = setup.leaves_late;
    let parts = Parts {
        orders: tasks.orders,
        spare: spare(&clock, A),
        writable: tasks.writable,
        test,
        calibrations: saved.into_iter().collect(),
        watch: tasks.watch,
    };
    let service = service(facts::<B, A>(&mut about, answered), parts, in_force);
    let per_tick = clocks::CORE_HZ / clocks::TIMER_HZ;
    let station = Station::new(setup, calibrations, first, &HEARTBEATS, ends, per_tick);
    let (tx, rx) = wired.serial.open().split();
    let rx = rx.into_ring_buffered(RECEIVED.take());
    let answers: &'static report::ReplyQueue = ANSWERS.init(report::ReplyQueue::new());
    let listener = listen::Listener {
        service,
        outcomes: tasks.outcomes,
        answers,
        heartbeats: &HEARTBEATS,
        store: Store::new(Flash::new(wired.flash, wiring::Irqs)),
        stack,
    };
    let reporter = report::Reporter {
        reports: tasks.reports,
        waiting: tasks.waiting,
        service,
        answers,
        heartbeats: &HEARTBEATS,
        channels: (A, B::Converters::INPUTS.len()),
    };
    let watchdog = started_watchdog(wired.watchdog);
    let mut metal = Metal::new(converters, period, wired.pins, watchdog);
    metal.start(leaves_late);
    control.begin(Control { station, metal });
    run_tasks(|spawner| {
        spawner.spawn(defmt::unwrap!(listen::task(listener, rx)));
        spawner.spawn(defmt::unwrap!(report::task(reporter, tx)));
        spawner.spawn(defmt::unwrap!(lights::task(
            wired.lamps,
            crystal_ok,
            crashed
        )));
    })
}

/// The watchdog, running from here on.
fn started_watchdog(watchdog: Peri<'static, IWDG>) -> IndependentWatchdog<'static, IWDG> {
    let mut watchdog = IndependentWatchdog::new(watchdog, WATCHDOG_US);
    watchdog.unleash();
    watchdog.pet();
    watchdog
}

/// Runs what `spawn` starts, forever.
#[inline(always)]
fn run_tasks(spawn: impl FnOnce(Spawner)) -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    EXECUTOR.init(Executor::new()).run(spawn)
}

/// Facts known once the chip runs.
struct About {
    started: StartCause,
    last_crash: Option<CrashReport>,
    crystal_ok: bool,
}

/// The cause of the start and data kept from before; then the clocks, and the guards of stack, clock and supply.
#[inline(always)]
fn start_chip() -> (About, embassy_stm32::Peripherals) {
    fatal::note_heartbeats(&HEARTBEATS);
    let started = reset::cause();
    let last_crash = kept::crash_before(started);
    if let Some(mut core) = cortex_m::Peripherals::take() {
        start_cycle_counter(&mut core);
        no_fault_halts_the_core();
        stack_guard::close(&mut core.MPU);
    }
    let crystal_ok = clocks::external_clock_is_right();
    wiring::lower_priorities();
    let p = embassy_stm32::init(clocks::tree(crystal_ok));
    clocks::finish(crystal_ok);
    supply::guard();
    let about = About {
        started,
        last_crash,
        crystal_ok,
    };
    (about, p)
}

/// The tasks' ends of the queues, and the memory of the ground motion.
struct TaskEnds {
    orders: Producer<'static, Order>,
    outcomes: Consumer<'static, Outcome>,
    reports: Consumer<'static, Report>,
    waiting: &'static mut Waiting,
    writable: Writable,
    watch: WatchParts<'static>,
}

/// The queues between the control interrupt and the tasks. Must be called only once.
#[inline(always)]
fn queues() -> (QueueEnds, TaskEnds) {
    static ORDERS: StaticCell<Queue<Order, 4>> = StaticCell::new();
    static OUTCOMES: StaticCell<Queue<Outcome, 4>> = StaticCell::new();
    static POINTS: ConstStaticCell<Points> = ConstStaticCell::new(Points::new());
    let (orders_in, orders_out) = ORDERS.init(Queue::new()).split();
    let (outcomes_in, outcomes_out) = OUTCOMES.init(Queue::new()).split();
    // The start gets here only once.
    let CoreCoupled {
        reports,
        waiting,
        judged,
        orders,
        watches,
    } = defmt::unwrap!(core_coupled::claim());
    let (reports_in, reports_out) = reports.split();
    let judged: &'static Judged = judged;
    let (watch_in, watch_out) = orders.split();
    let interrupt = QueueEnds {
        orders: orders_out,
        outcomes: outcomes_in,
        reports: reports_in,
        watch: FromWatch {
            judged,
            orders: watch_out,
        },
    };
    let tasks = TaskEnds {
        orders: orders_in,
        outcomes: outcomes_out,
        reports: reports_out,
        waiting,
        writable: POINTS.take().claim(),
        watch: WatchParts {
            watches,
            judged,
            orders: watch_in,
        },
    };
    (interrupt, tasks)
}

/// The answers to the PC's questions about the board; `answered`: its converters have answered.
fn facts<B: Board<A>, const A: usize>(about: &mut About, answered: bool) -> Facts {
    Facts {
        name: B::NAME,
        commit: env!("OUTERLOOP_COMMIT"),
        clock: const { clock::<B::Converters, A>() },
        now: cycles,
        codes: B::Converters::CODES,
        actuators: A,
        inputs: B::Converters::INPUTS,
        input_span_v: B::Converters::INPUT_SPAN_V,
        output_delay_us: B::Converters::OUTPUT_DELAY_US as f32,
        crystal_ok: about.crystal_ok,
        converters_ok: answered,
        started: about.started,
        last_crash: about.last_crash.take(),
    }
}

/// The saved calibration of each actuator, if it belongs to these converters.
fn saved_calibrations<const A: usize>(codes: &CodeRange) -> [Option<Calibration>; A] {
    core::array::from_fn(|actuator| {
        let wiring = Memory.calibration(actuator);
        wiring.and_then(|wiring| wiring.of(codes, A))
    })
}

/// The test to start with: the saved one, or else one that cannot be armed.
#[inline(never)]
fn settings(clock: &Clock, actuators: usize) -> (&'static mut Setup, Option<BoardTest>) {
    static FIRST: Place = Place::new();
    let setup = unconfigured(&FIRST, clock, actuators);
    let Some(test) = Memory.test() else {
        return (setup, None);
    };
    match setup.replace(&test, clock, actuators) {
        Ok(()) => (setup, Some(test)),
        Err(refusal) => {
            defmt::warn!("the saved test is refused now: {=str}", refusal.name);
            (setup, None)
        }
    }
}

/// Builds the service in its final place: its temporaries are off the stack before the tasks stack up on the start.
#[inline(never)]
fn service(board: Facts, parts: Parts, in_force: (f32, f64)) -> &'static SharedService {
    static SERVICE: StaticCell<Service> = StaticCell::new();
    static SHARED: StaticCell<SharedService> = StaticCell::new();
    let service = SERVICE.init_with(|| Service::new(board, parts, in_force));
    SHARED.init(RefCell::new(service))
}

/// The place for the next test.
fn spare(clock: &Clock, actuators: usize) -> &'static mut Setup {
    static SPARE: Place = Place::new();
    unconfigured(&SPARE, clock, actuators)
}

/// The storage of a test.
type Place = StaticCell<Result<Setup, Refusal>>;

/// A test that cannot be armed, computed in place. A test is a sixth of the stack: its temporaries must not add up.
#[inline(never)]
fn unconfigured(place: &'static Place, clock: &Clock, actuators: usize) -> &'static mut Setup {
    let first = place.init_with(|| Setup::unconfigured(clock, actuators));
    // The clock's constants allow 2 kHz; a test on the host confirms it.
    defmt::unwrap!(first.as_mut().ok())
}

/// The command code that holds the actuator at its measured displacement; the end of the DAC's range if that is further
/// out, in which case PERMIT cannot be given.
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
