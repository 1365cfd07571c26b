//! An external output converter: what each kind implements, and its attachment to the bus.

use super::shift::Shift;
use rigless::chip::Timeline;
use rigless::chip::spi::Peer;
use rigless::snapshot::Store;
use std::fmt::Debug;

/// An output converter.
pub trait Output: Debug + Send {
    /// Executes a command of 24 bits. Returns the answer, which is shifted out with the next one; 0 if it asks for none.
    fn execute(&mut self, at_ns: u64, command: u32) -> u32;

    /// LDAC falls: the outputs take the codes that were in the input registers by then.
    fn take_over(&mut self, at_ns: u64);

    /// An output's voltage, V.
    fn volts(&self, output: usize) -> f64;

    /// Codes of the first output since the last call, with their times, ns.
    fn commands(&mut self) -> Vec<(u64, u16)>;

    /// Its supply fails and returns: as after power-up.
    fn lose_power(&mut self);

    /// From now on an output stays where it is.
    fn break_output(&mut self, output: usize);
}

/// An output converter on a serial interface.
#[derive(Debug)]
pub struct OnBus {
    /// The converter.
    pub chip: Box<dyn Output>,
    shift: Shift,
    /// Answer to the last command.
    answer: u32,
    /// The bit of the next command that flips in transfer.
    pub turned: Option<u32>,
}

impl OnBus {
    /// The state after power-up.
    pub fn new(chip: impl Output + 'static) -> Self {
        Self {
            chip: Box::new(chip),
            shift: Shift::default(),
            answer: 0,
            turned: None,
        }
    }
}

// Snapshots are not taken.
impl Store for OnBus {}

impl Peer for OnBus {
    fn transfer(&mut self, mosi: u32, bits: u8, _: &mut Timeline<'_, '_>) -> u32 {
        self.shift.transfer(mosi, bits)
    }

    fn select(&mut self, _: &mut Timeline<'_, '_>) {
        self.shift.begin(self.answer);
    }

    fn deselect(&mut self, context: &mut Timeline<'_, '_>) {
        if let Some(command) = self.shift.end() {
            let turned = self.turned.take().map_or(0, |bit| 1 << bit);
            self.answer = self.chip.execute(context.now().0, command ^ turned);
        }
    }
}
