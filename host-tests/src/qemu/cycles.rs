//! Cycles of a step on the Cortex-M4F of the board, from the instructions that ran in the emulator.
//!
//! Two clocks run along the trace: the core's, by ARM's table of instruction timings (Cortex-M4 Technical Reference
//! Manual, section 3.3, and 7.2.3 for the floating-point unit), and that of the flash of an STM32F42x behind its
//! accelerator (RM0090, section 3.5.2) at 168 MHz: 5 wait states, lines of 16 bytes, a cache of 64 lines of instructions and
//! 8 of constants, the next line prefetched. Every step starts with an empty cache, since other code has run between two
//! control interrupts.
//!
//! # Limitations
//! Not calibrated against a chip; +-15 % is a guess. Data are in memory without wait states; DMA takes no bus cycles.

use crate::call_graph::CallGraph;
use std::collections::{BTreeSet, VecDeque};
use std::io::{BufRead, BufReader, Read, Result};
use std::ops::Range;

/// Wait states of the flash at 168 MHz and 3.3 V.
const WAIT_STATES: u64 = 5;

/// Lines of instructions and of constants in the accelerator's caches.
const LINES: [usize; 2] = [64, 8];

/// Cost of one step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Instructions.
    pub instructions: u64,
    /// Cycles from memory without wait states.
    pub without_waiting: u64,
    /// Cycles from the flash.
    pub cycles: u64,
}

/// Cost of one instruction of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spent {
    /// Its address.
    pub at: u32,
    /// Cycles, including those in which the core waited for the flash.
    pub cycles: u32,
    /// Those in which it waited.
    pub waited: u32,
}

/// One step, instruction by instruction.
#[derive(Clone, Debug)]
pub struct Course {
    /// Its cost.
    pub cost: Cost,
    /// Its instructions.
    pub spent: Vec<Spent>,
}

/// The code of an image, and the functions of the measured part of a control period.
pub struct Code {
    begin: u32,
    bytes: Vec<u8>,
    /// The function of this part, for a loop of each size.
    steps: Vec<Range<u32>>,
    /// The functions that they can reach.
    ranges: Vec<Range<u32>>,
}

impl Code {
    /// Of an ELF image: the control step, from the sample to the command.
    ///
    /// # Errors
    /// It is not an ELF image, or has no loop.
    pub fn new(image: &[u8]) -> std::result::Result<Self, String> {
        Self::of(image, "OuterLoop", "4step17")
    }

    /// The rig watch's part of every control period after the command, in an ELF image.
    ///
    /// # Errors
    /// As [`Code::new`].
    pub fn behind_command(image: &[u8]) -> std::result::Result<Self, String> {
        Self::of(image, "watchers", "9hand_over17")
    }

    /// What follows that if the watch's orders change, in an ELF image.
    ///
    /// # Errors
    /// As [`Code::new`].
    pub fn other_orders(image: &[u8]) -> std::result::Result<Self, String> {
        Self::of(image, "watchers", "6answer17")
    }

    /// The functions with both in their names.
    fn of(image: &[u8], place: &str, name: &str) -> std::result::Result<Self, String> {
        let graph = CallGraph::new(image)?;
        let names = graph.names(place).filter(|n| n.contains(name));
        let names: BTreeSet<_> = names.map(str::to_owned).collect();
        if names.is_empty() {
            return Err(format!("there is no {name} of {place}"));
        }
        let mut reach = BTreeSet::new();
        for name in &names {
            reach.extend(graph.reach(name, "rust_begin_unwind")?.functions);
        }
        let (begin, bytes) = graph.code();
        Ok(Self {
            begin,
            bytes: bytes.to_vec(),
            steps: graph.ranges(&names),
            ranges: graph.ranges(&reach),
        })
    }

    /// The addresses that the emulator is to trace: only those of the step.
    pub fn filter(&self) -> String {
        let ranges = self.ranges.iter();
        let ranges = ranges.map(|r| format!("{:#x}..{:#x}", r.start, r.end - 1));
        ranges.collect::<Vec<_>>().join(",")
    }

    fn half(&self, at: u32) -> u16 {
        let i = at.wrapping_sub(self.begin) as usize;
        match self.bytes.get(i..i + 2) {
            Some(b) => u16::from_le_bytes([b[0], b[1]]),
            None => 0,
        }
    }

    /// True if `pc` is in the measured function, or in the tail call that returns for it.
    fn is_own(&self, pc: u32, run: &Run) -> bool {
        let mut own = self.steps.iter().chain(&run.tail);
        own.any(|range| range.contains(&pc))
    }

    /// Reads a trace to its end; one entry for each control period.
    ///
    /// # Errors
    /// The trace cannot be read.
    pub fn steps(&self, trace: impl Read) -> Result<Vec<Course>> {
        let mut reader = BufReader::with_capacity(1 << 20, trace);
        let (mut steps, mut line) = (Vec::new(), Vec::new());
        let mut run: Option<Run> = None;
        let mut last: Option<u32> = None;
        loop {
            line.clear();
            let pc = match reader.read_until(b'\n', &mut line)? {
                0 => None,
                _ => match program_counter(&line) {
                    None => continue,
                    pc => pc,
                },
            };
            // The next instruction shows whether it has returned, since a return may be conditional.
            if let (Some(active), Some(at)) = (&mut run, last)
                && self.has_returned(at, pc, active)
            {
                active.execute(self, at, None);
                steps.extend(run.take().map(Run::course));
            }
            let Some(pc) = pc else {
                return Ok(steps);
            };
            if self.steps.iter().any(|s| s.start == pc) {
                run = Some(Run::new());
                last = None;
            }
            let Some(active) = &mut run else { continue };
            if let Some(last) = last {
                active.execute(self, last, Some(pc));
                let called = is_call(self.half(last), self.half(last + 2));
                if self.is_own(last, active) && !self.is_own(pc, active) && !called {
                    // A tail call, which returns for it.
                    active.tail = self.ranges.iter().find(|r| r.contains(&pc)).cloned();
                }
            }
            last = Some(pc);
        }
    }

    /// True if the measured function has returned by its instruction `at`; `next` is the next one traced.
    fn has_returned(&self, at: u32, next: Option<u32>, run: &Run) -> bool {
        let (first, second) = (self.half(at), self.half(at + 2));
        self.is_own(at, run) && returns(first, second) && next != Some(at + size(first))
    }
}

/// `Trace 0: 0x7f.. [cs/pc/flags/cflags] symbol`.
fn program_counter(line: &[u8]) -> Option<u32> {
    let text = line.strip_prefix(b"Trace")?;
    let text = text.split(|&b| b == b'/').nth(1)?;
    u32::from_str_radix(std::str::from_utf8(text).ok()?, 16).ok()
}

/// Bytes of an instruction.
fn size(first: u16) -> u32 {
    if first >> 11 < 0b11101 { 2 } else { 4 }
}

/// Whether it loads the program counter from the stack or the link register.
fn returns(first: u16, second: u16) -> bool {
    first & 0xff00 == 0xbd00 || first == 0x4770 || (first == 0xe8bd && second & 0x8000 != 0)
}

/// Whether it is a call that returns.
fn is_call(first: u16, second: u16) -> bool {
    let by_offset = first & 0xf800 == 0xf000 && second & 0xd000 == 0xd000;
    by_offset || first & 0xff80 == 0x4780
}

/// How an instruction is timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// This many cycles.
    Takes(u64),
    /// One load or store; another directly after it is pipelined. The address is that of a constant in the flash.
    Transfer(Option<u32>),
    /// Load or store of this many words.
    Transfers(u64),
    /// Arithmetic of the floating-point unit: cycles, result, operands.
    Float(u64, u8, [u8; 3]),
}

fn kind(pc: u32, first: u16, second: u16) -> Kind {
    let (f, s) = (u32::from(first), u32::from(second));
    let pool = (pc & !3) + 4;
    if f >> 11 < 0b11101 {
        return match f >> 12 {
            0x4 if f >> 11 == 0b01001 => Kind::Transfer(Some(pool + (f & 0xff) * 4)),
            0x5..=0x9 => Kind::Transfer(None),
            0xb if f & 0xf600 == 0xb400 => Kind::Transfers(u64::from((f & 0x1ff).count_ones())),
            0xc => Kind::Transfers(u64::from((f & 0xff).count_ones())),
            _ => Kind::Takes(1),
        };
    }
    let offset = |words: u32| {
        if f & 0x80 != 0 {
            pool + words
        } else {
            pool.wrapping_sub(words)
        }
    };
    let constant = |words: u32| (f & 0xf == 0xf).then(|| offset(words));
    if f & 0xfe40 == 0xe800 {
        Kind::Transfers(u64::from(s.count_ones()))
    } else if f & 0xfe40 == 0xe840 {
        // LDRD and STRD; also a table branch, which reads one.
        Kind::Transfers(2)
    } else if f & 0xfe00 == 0xf800 {
        Kind::Transfer(constant(s & 0xfff))
    } else if f & 0xff20 == 0xed00 {
        Kind::Transfer(constant((s & 0xff) * 4))
    } else if f & 0xffe0 == 0xec40 {
        Kind::Takes(2)
    } else if f & 0xfe00 == 0xec00 {
        Kind::Transfers(u64::from(s & 0xff))
    } else if f & 0xff00 == 0xee00 && s & 0x10 == 0 {
        float(f, s)
    } else if f & 0xffd0 == 0xfb90 {
        Kind::Takes(12)
    } else {
        Kind::Takes(1)
    }
}

fn float(f: u32, s: u32) -> Kind {
    let register = |high: u32, low: u32| ((high & 0xf) << 1 | low & 1) as u8;
    let (d, n, m) = (
        register(s >> 12, f >> 6),
        register(f, s >> 7),
        register(s, s >> 5),
    );
    let none = u8::MAX;
    match (f >> 7 & 1, f >> 4 & 3) {
        // VMLA, VFMA and their relatives.
        (0, 0 | 1) | (1, 1 | 2) => Kind::Float(3, d, [n, m, d]),
        (0, _) => Kind::Float(1, d, [n, m, none]),
        (_, 0) => Kind::Float(14, d, [n, m, none]),
        // VSQRT; the others are moves, comparisons and conversions.
        _ if f & 0xf == 1 && s & 0xc0 == 0xc0 => Kind::Float(14, d, [m, none, none]),
        _ => Kind::Float(1, d, [m, none, none]),
    }
}

/// A step being traced.
struct Run {
    cost: Cost,
    /// Cycles in which the core waited for the flash.
    waited: u64,
    flash: Flash,
    last: Kind,
    spent: Vec<Spent>,
    /// The tail call that returns for the function.
    tail: Option<Range<u32>>,
}

impl Run {
    fn new() -> Self {
        Self {
            cost: Cost::default(),
            waited: 0,
            flash: Flash::default(),
            last: Kind::Takes(1),
            spent: Vec::new(),
            tail: None,
        }
    }

    fn now(&self) -> u64 {
        self.cost.without_waiting + self.waited
    }

    /// Times the instruction at `pc`; that at `next` runs after it.
    fn execute(&mut self, code: &Code, pc: u32, next: Option<u32>) {
        let (first, second) = (code.half(pc), code.half(pc + 2));
        let size = size(first);
        let (began, waited) = (self.now(), self.waited);
        self.waited += self.flash.instruction(pc, self.now());
        if size == 4 {
            self.waited += self.flash.instruction(pc + 2, self.now());
        }
        let kind = kind(pc, first, second);
        let mut cycles = match kind {
            Kind::Takes(cycles) => cycles,
            Kind::Transfer(_) if matches!(self.last, Kind::Transfer(_)) => 1,
            Kind::Transfer(_) => 2,
            Kind::Transfers(words) => 1 + words,
            Kind::Float(cycles, ..) => cycles,
        };
        if let (Kind::Float(_, result, _), Kind::Float(_, _, operands)) = (self.last, kind)
            && operands.contains(&result)
        {
            cycles += 1;
        }
        if let Kind::Transfer(Some(constant)) = kind {
            self.waited += self.flash.constant(constant, self.now());
        }
        if next != Some(pc + size) {
            // The pipeline is refilled.
            cycles += 2;
        }
        self.cost.without_waiting += cycles;
        self.cost.instructions += 1;
        self.last = kind;
        self.spent.push(Spent {
            at: pc,
            cycles: (self.now() - began) as u32,
            waited: (self.waited - waited) as u32,
        });
    }

    fn course(self) -> Course {
        let cycles = self.now();
        Course {
            cost: Cost {
                cycles,
                ..self.cost
            },
            spent: self.spent,
        }
    }
}

/// The flash behind its accelerator.
#[derive(Default)]
struct Flash {
    /// Cached lines, most recently used first: of instructions and of constants.
    kept: [VecDeque<u32>; 2],
    current: Option<u32>,
    /// The line being prefetched, and when it will be available.
    ahead: Option<(u32, u64)>,
    free_at: u64,
}

impl Flash {
    /// Cycles of waiting for the instruction at `pc`.
    fn instruction(&mut self, pc: u32, now: u64) -> u64 {
        let line = pc >> 4;
        if self.current == Some(line) {
            return 0;
        }
        self.current = Some(line);
        let waited = match self.ahead.take() {
            Some((ahead, there)) if ahead == line => there.saturating_sub(now),
            _ if self.kept[0].contains(&line) => 0,
            _ => self.read(now),
        };
        self.keep(0, line);
        if !self.kept[0].contains(&(line + 1)) {
            let begin = self.free_at.max(now + waited);
            self.free_at = begin + WAIT_STATES + 1;
            self.ahead = Some((line + 1, self.free_at));
        }
        waited
    }

    /// Cycles of waiting for the constant at `address`.
    fn constant(&mut self, address: u32, now: u64) -> u64 {
        let line = address >> 4;
        let waited = if self.kept[1].contains(&line) {
            0
        } else {
            self.read(now)
        };
        self.keep(1, line);
        waited
    }

    /// Reads a line that is not cached: after what is being read, plus the wait states.
    fn read(&mut self, now: u64) -> u64 {
        let begin = self.free_at.max(now);
        self.free_at = begin + WAIT_STATES;
        self.free_at - now
    }

    fn keep(&mut self, which: usize, line: u32) {
        let kept = &mut self.kept[which];
        kept.retain(|&l| l != line);
        kept.push_front(line);
        kept.truncate(LINES[which]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instructions_are_timed_by_the_table() {
        // vdiv.f32 s0, s1, s2; vfma.f32 s0, s1, s2; vadd.f32 s4, s0, s1; vsqrt.f32 s0, s0
        let timed = [
            ((0xee80, 0x0a81), 14),
            ((0xeea0, 0x0a81), 3),
            ((0xee30, 0x2a20), 1),
            ((0xeeb1, 0x0ac0), 14),
        ];
        for ((first, second), cycles) in timed {
            assert!(
                matches!(kind(0, first, second), Kind::Float(c, ..) if c == cycles),
                "{first:x} {second:x}"
            );
        }
        // push {r4, r5, r6, r7, lr}; vpush {d8-d9}; ldr r0, [pc, #8]; vldr s0, [pc, #16]; add r0, r1
        assert_eq!(kind(0, 0xb5f0, 0), Kind::Transfers(5));
        assert_eq!(kind(0, 0xed2d, 0x8b04), Kind::Transfers(4));
        assert_eq!(kind(0x102, 0x4802, 0), Kind::Transfer(Some(0x10c)));
        assert_eq!(kind(0x100, 0xed9f, 0x0a04), Kind::Transfer(Some(0x114)));
        assert_eq!(kind(0, 0x4408, 0), Kind::Takes(1));
    }

    #[test]
    fn straight_code_runs_ahead_of_the_flash_and_a_loop_comes_from_the_cache() {
        // Eight instructions of 2 bytes a line: a line is read while the one before it runs.
        let mut flash = Flash::default();
        let (mut now, mut waited) = (0, 0);
        for i in 0..800_u32 {
            let wait = flash.instruction(2 * i, now);
            (now, waited) = (now + wait + 1, waited + wait);
        }
        assert!(waited <= WAIT_STATES, "{waited}");
        let before = waited;
        for _ in 0..10 {
            for i in 700..720_u32 {
                waited += flash.instruction(2 * i, now);
                now += 1;
            }
        }
        assert_eq!(waited, before, "kept");
    }
}
