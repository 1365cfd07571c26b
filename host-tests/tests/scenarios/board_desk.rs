//! A simulated board on the desk: a slow probe, and saves until a sector of its flash is erased.

use crate::board_link::{QUICK, loopback, test};
use experiment::failure::Failure;
use firmware::sim::CODES;
use firmware::station::{Flash, Ring, TEST_BYTES};
use host_tests::loopback::{FaultInjection, Loopback};
use link::command::BoardTest;
use link::status::StartCause;
use outerloop_cli::board::desk::incident::{self, Incident, Leaves};
use outerloop_cli::board::desk::{self, DeskRow, RowVerdict};
use outerloop_cli::board::{BoardConnection, Connection, Port, Timeouts, status};
use std::cell::RefCell;
use std::pin::pin;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

#[test]
fn a_board_does_not_give_the_pc_up_while_a_probe_takes_its_time() {
    let mut loopback = loopback(&test(&["plant.actuator.delay_ms=0.5"]));
    loopback.board.hardware.board.wired = [desk::calibration(&CODES)];
    let port: Box<dyn Port> = Box::new(loopback);
    let mut board: BoardConnection = Connection::new(port, QUICK);
    let expected = (
        Incident::Reset,
        "a reset",
        Leaves::Start(StartCause::Pin, None),
    );
    let row = incident::row(&mut board, expected, |_, board| {
        // 300 reads of 20 steps, 3 s: the board gives up after half a second.
        for _ in 0..300 {
            board.listen()?;
        }
        let now = status(board)?;
        Err(Failure::test(now.mode.name()))
    });
    assert_eq!(row.found, "running");
}

/// A control period at 2 kHz, in cycles.
const PERIOD_CYCLES: u32 = 84_000;

/// Size of a sector, and where the chip keeps tests: in two of them.
const SECTOR: u32 = 128 * 1024;
const TESTS: Ring<TEST_BYTES> = Ring {
    sectors: [0, SECTOR],
    sector_bytes: SECTOR,
    slot_bytes: 2048,
};

/// Simulated flash, and how often a sector of it was erased.
struct Sectors {
    bytes: Vec<u8>,
    erased: u32,
}

impl Flash for Sectors {
    fn read(&self, offset: u32, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> bool {
        let places = &mut self.bytes[offset as usize..][..bytes.len()];
        // A write only clears bits; an erase sets them.
        for (place, new) in places.iter_mut().zip(bytes) {
            *place &= new;
        }
        true
    }

    async fn erase(&mut self, offset: u32, bytes: u32) -> bool {
        self.bytes[offset as usize..][..bytes as usize].fill(0xff);
        self.erased += 1;
        true
    }
}

/// A flash, which the simulated board lacks.
struct Chip {
    flash: Sectors,
    kept: BoardTest,
    /// Cycles by which an erase delays the next control step.
    held_up_cycles: u32,
}

impl Chip {
    /// After each control step: writes what the board has just been told to save.
    fn go_on(&mut self, loopback: &mut Loopback) {
        let erased = self.flash.erased;
        let [test, _] = std::mem::take(&mut loopback.board.saved);
        if test.is_some() {
            self.write();
        }
        let held_up = self.held_up_cycles * (self.flash.erased - erased);
        let ticks = &mut loopback.board.hardware.board.ticks;
        *ticks = ticks.wrapping_add(held_up);
    }

    fn write(&mut self) {
        let mut saving = pin!(TESTS.save(&mut self.flash, &self.kept));
        let mut context = Context::from_waker(Waker::noop());
        // Nothing here ever waits.
        let saved = saving.as_mut().poll(&mut context);
        assert_eq!(saved, Poll::Ready(true));
    }
}

/// Runs after each step, as long as the board runs.
fn after_each_step(chip: Rc<RefCell<Chip>>) -> FaultInjection {
    Box::new(move |loopback: &mut Loopback| {
        chip.borrow_mut().go_on(loopback);
        let next = after_each_step(Rc::clone(&chip));
        loopback.incidents.push_back((0, next));
    })
}

/// The desk's result, and how many sectors were erased.
fn saves(held_up_cycles: u32) -> (DeskRow, u32) {
    let test = test(&[]);
    let flash = Sectors {
        bytes: vec![0xff; 2 * SECTOR as usize],
        erased: 0,
    };
    let chip = Rc::new(RefCell::new(Chip {
        flash,
        kept: test.config.clone().into(),
        held_up_cycles,
    }));
    let mut loopback = loopback(&test);
    let happens = after_each_step(Rc::clone(&chip));
    loopback.incidents.push_back((0, happens));
    let port: Box<dyn Port> = Box::new(loopback);
    let mut connection: BoardConnection = Connection::new(port, Timeouts::BOARD);
    let row = desk::saves(&mut connection);
    let erased = chip.borrow().flash.erased;
    (row, erased)
}

#[test]
fn the_saves_of_the_desk_erase_a_sector_while_the_longest_period_is_watched() {
    for (held_up_cycles, verdict) in [(0, RowVerdict::Good), (5000, RowVerdict::Bad)] {
        let (row, erased) = saves(held_up_cycles);
        println!("{}: {}", row.what, row.found);
        assert_eq!(erased, 1, "{}", row.what);
        let longest = PERIOD_CYCLES + held_up_cycles;
        let said = format!("period {PERIOD_CYCLES} to {longest} cycles of {PERIOD_CYCLES};");
        assert!(row.found.starts_with(&said), "{}", row.found);
        assert_eq!(row.verdict, verdict, "{}", row.found);
    }
}
