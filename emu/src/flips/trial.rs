//! A test on the emulated board, which forks a process at each flip.

use super::outcome::{Outcome, Reference, Watch};
use super::pc::{Pc, STIFFNESS_N_PER_M};
use super::table::Table;
use super::target::{Flip, Memory, Place, Target};
use crate::chain::Converters;
use crate::core_bits::{CoreBit, CoreBits};
use crate::image::Firmware;
use crate::laboratory::Laboratory;
use crate::log::Log;
use crate::nucleo::{Nucleo, RIGHT_CRYSTAL_HZ, USUAL_LSI_HZ};
use crate::wire::Wire;
use nix::sys::resource::{Resource, setrlimit};
use nix::sys::wait::waitpid;
use nix::unistd::{ForkResult, Pid, fork, pipe};
use plant::{Rig, RigSpec};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rigless::emulator::{Driver, Host, Settled, Stop};
use rigless::session::Session;
use rigless::time::VirtualNanos;
use std::collections::VecDeque;
use std::fs::File;
use std::io::{Read, Write};
use std::sync::{Arc, Mutex, PoisonError};

/// The converters of the image for hydraulic rigs.
const CONVERTERS: Converters = Converters::External;

/// How long after the start of the test bits flip, and how long the test without a flip runs, ns.
const FLIPS_NS: u64 = 700_000_000;
const TEST_NS: u64 = 1_150_000_000;

/// Where the control step is in its period, ns after the sample; half of the flips are drawn in it.
const STEP_NS: (u64, u64) = (5_000, 60_000);
const PERIOD_NS: u64 = 500_000;

/// Largest velocity that the valve allows, m/s.
const VALVE_M_PER_S: f64 = 2.0;

/// Processor time after which a copy counts as hung, s; it does not depend on how busy the machine is.
const HUNG_S: u64 = 300;

/// How many flips, which, and in how many simultaneous processes.
#[derive(Clone, Copy, Debug)]
pub struct Trials {
    /// Number of flips.
    pub flips: usize,
    /// Seed of the random draw.
    pub seed: u64,
    /// Copies that run at once.
    pub jobs: usize,
    /// Only the flip of this number, from 0 in order of time.
    pub number: Option<usize>,
}

/// Runs them on an image. `tell` receives a line for each, with the bit that flipped.
///
/// # Errors
/// A sentence: the image cannot be run, the board refused the test, or a process could not be created.
pub fn run(
    firmware: &Firmware,
    trials: &Trials,
    tell: impl FnMut(&str) + Send + 'static,
) -> Result<Table, String> {
    let memory = Memory::of(firmware)?;
    let plan = Arc::new(Mutex::new(Reference::default()));
    trial(firmware, Role::Reference(Arc::clone(&plan)))?;
    let plan = Arc::new(std::mem::take(
        &mut *plan.lock().unwrap_or_else(PoisonError::into_inner),
    ));
    let ended = Arc::new(Mutex::new(Ok(Table::default())));
    let original = Original {
        flips: drawn(trials, &plan, &memory),
        memory,
        plan,
        jobs: trials.jobs.max(1),
        number: trials.number.unwrap_or(0),
        copies: VecDeque::new(),
        table: Table::default(),
        tell: Box::new(tell),
        ended: Arc::clone(&ended),
    };
    trial(firmware, Role::Original(original))?;
    let mut ended = ended.lock().unwrap_or_else(PoisonError::into_inner);
    std::mem::replace(&mut *ended, Ok(Table::default()))
}

/// Which bits flip, and when: equally many of each target; half of them are drawn while the step runs.
fn drawn(trials: &Trials, plan: &Reference, memory: &Memory) -> VecDeque<Flip> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(trials.seed);
    let window = plan.started_ns..plan.started_ns + FLIPS_NS;
    let triggers = plan.log.triggers_ns.iter();
    let triggers: Vec<u64> = triggers.copied().filter(|at| window.contains(at)).collect();
    let mut flips: Vec<Flip> = (0..trials.flips)
        .map(|number| {
            let trigger = triggers[rng.next_u64() as usize % triggers.len().max(1)];
            let (from, to) = match rng.next_u32() % 2 {
                0 => STEP_NS,
                _ => (1, PERIOD_NS),
            };
            let target = Target::ALL[number % Target::ALL.len()];
            Flip {
                at_ns: trigger + from + rng.next_u64() % (to - from),
                target,
                place: Place::draw(target, memory, &mut rng),
            }
        })
        .collect();
    flips.sort_by_key(|flip| flip.at_ns);
    if let Some(number) = trials.number {
        flips = flips.get(number).copied().into_iter().collect();
    }
    flips.into()
}

/// One test, until `role` ends it.
fn trial(firmware: &Firmware, role: Role) -> Result<(), String> {
    let text =
        "[actuator]\nkind = 'delay'\ndelay_ms = 3.0\n[specimen]\nkind = 'linear'\n[sensors]\n";
    let spec: RigSpec = toml::from_str(text).map_err(|e| e.to_string())?;
    let rate_hz = 1e9 / PERIOD_NS as f64;
    let rig = Rig::new(&spec, &[STIFFNESS_N_PER_M], rate_hz, 1).map_err(|e| e.to_string())?;
    let (wire, bits) = (Wire::default(), CoreBits::default());
    let laboratory = Laboratory::new(wire.clone(), rig, firmware.symbol("DRILL")?)
        .with_converters(CONVERTERS)
        .with_valves(VALVE_M_PER_S)
        .with_pc_inside();
    let board = Nucleo::new(RIGHT_CRYSTAL_HZ, USUAL_LSI_HZ, wire.clone())
        .map_err(|e| e.to_string())?
        .with_converters(CONVERTERS)
        .with_core_bits(bits.clone());
    let refused = Arc::new(Mutex::new(None));
    let trial = Trial {
        log: laboratory.log(),
        laboratory,
        pc: Pc::new(wire, CONVERTERS),
        bits,
        role,
        next_ns: 0,
        refused: Arc::clone(&refused),
    };
    crate::run(board, &firmware.images, trial)?;
    let mut refused = refused.lock().unwrap_or_else(PoisonError::into_inner);
    refused.take().map_or(Ok(()), Err)
}

/// What a test is run for.
enum Role {
    /// The reference for the comparison.
    Reference(Arc<Mutex<Reference>>),
    /// The test that is copied at each flip.
    Original(Original),
    /// A copy that shows what becomes of a flip.
    Copy {
        watch: Watch,
        plan: Arc<Reference>,
        /// Where it writes the outcome.
        told: File,
    },
}

/// The process that is forked.
struct Original {
    flips: VecDeque<Flip>,
    memory: Memory,
    plan: Arc<Reference>,
    jobs: usize,
    /// Number of the first flip.
    number: usize,
    copies: VecDeque<Running>,
    table: Table,
    tell: Box<dyn FnMut(&str) + Send>,
    ended: Arc<Mutex<Result<Table, String>>>,
}

/// A copy that runs.
struct Running {
    process: Pid,
    flip: Flip,
    told: File,
}

/// The laboratory, a PC, and what the test is run for.
struct Trial {
    laboratory: Laboratory,
    log: Arc<Mutex<Log>>,
    pc: Pc,
    bits: CoreBits,
    role: Role,
    /// The laboratory's next turn, ns.
    next_ns: u64,
    refused: Arc<Mutex<Option<String>>>,
}

impl Original {
    /// Waits for the copy that has run for longest.
    fn wait(&mut self) -> Result<(), String> {
        let Some(mut copy) = self.copies.pop_front() else {
            return Ok(());
        };
        let mut text = String::new();
        copy.told
            .read_to_string(&mut text)
            .map_err(|e| e.to_string())?;
        waitpid(copy.process, None).map_err(|e| e.to_string())?;
        let mut words = text.split_whitespace();
        let place = words.next().and_then(|word| word.parse::<usize>().ok());
        let outcome = place.and_then(|place| Outcome::ALL.get(place).copied());
        let outcome = outcome.unwrap_or(Outcome::Unknown);
        let apart_m = words.next().and_then(|word| word.parse().ok());
        let apart_m: f64 = apart_m.unwrap_or(0.0);
        let Flip {
            at_ns,
            target,
            place,
        } = copy.flip;
        let (after_ms, apart_mm) = ((at_ns - self.plan.started_ns) as f64 * 1e-6, apart_m * 1e3);
        let number = self.number + self.table.flips.len();
        (self.tell)(&format!(
            "{number}: {after_ms:.4} ms {place:x?}: {}, {apart_mm:.2} mm from the plan",
            outcome.name()
        ));
        self.table.flips.push((target, outcome, apart_m));
        Ok(())
    }

    /// No flips are left.
    fn end(&mut self) {
        while !self.copies.is_empty() {
            if let Err(sentence) = self.wait() {
                return self.fail(sentence);
            }
        }
        *self.ended.lock().unwrap_or_else(PoisonError::into_inner) =
            Ok(std::mem::take(&mut self.table));
    }

    fn fail(&mut self, sentence: String) {
        self.flips.clear();
        *self.ended.lock().unwrap_or_else(PoisonError::into_inner) = Err(sentence);
    }
}

/// Forks this process, with a pipe between the two. `None` in the copy.
fn copy() -> Result<(Option<Pid>, File), String> {
    let (from, to) = pipe().map_err(|e| e.to_string())?;
    // SAFETY: of this process's threads the copy has only the emulator's. The others wait for it and hold no lock.
    match unsafe { fork() }.map_err(|e| e.to_string())? {
        ForkResult::Parent { child } => Ok((Some(child), File::from(from))),
        ForkResult::Child => Ok((None, File::from(to))),
    }
}

impl Trial {
    /// A flip is due: forks a copy for it.
    fn flip(&mut self, session: &mut Session<Nucleo>, host: &mut dyn Host, stop: Stop) {
        let Role::Original(original) = &mut self.role else {
            return;
        };
        let Some(flip) = original.flips.pop_front() else {
            return;
        };
        let waited = match original.copies.len() >= original.jobs {
            true => original.wait(),
            false => Ok(()),
        };
        let (process, told) = match waited.and_then(|()| copy()) {
            Ok(made) => made,
            Err(sentence) => return original.fail(sentence),
        };
        if let Some(process) = process {
            original.copies.push_back(Running {
                process,
                flip,
                told,
            });
            return;
        }
        // If the limit cannot be set, a copy that hangs is waited for.
        let _ = setrlimit(Resource::RLIMIT_CPU, HUNG_S, HUNG_S);
        let (plan, stack_top) = (Arc::clone(&original.plan), original.memory.stack_top);
        let log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        let watch = Watch::new(&log, stop.at.0);
        drop(log);
        self.role = Role::Copy { watch, plan, told };
        self.turn_over(session, host, stop, flip.place, stack_top);
    }

    fn turn_over(
        &mut self,
        session: &mut Session<Nucleo>,
        host: &mut dyn Host,
        stop: Stop,
        place: Place,
        stack_top: u64,
    ) {
        match place {
            Place::Core(number) => self.bits.turn_over(CoreBit::Register(number)),
            Place::Stack(number) => {
                let pointer = self.bits.stack_pointer();
                let bits = 8 * stack_top.saturating_sub(pointer);
                let bit = u64::from(number) % bits.max(1);
                self.bits.turn_over(CoreBit::Memory {
                    address: pointer + bit / 8,
                    bit: (bit % 8) as u32,
                });
            }
            Place::Memory(address, bit) => self.bits.turn_over(CoreBit::Memory { address, bit }),
            Place::Peripheral(address, bit) => {
                self.laboratory
                    .turn_over_register(session, host, stop, address, bit);
            }
            Place::System(address, bit) => self.bits.turn_over(CoreBit::System {
                address,
                bit,
                at: stop.at,
            }),
            Place::Input(bit) => self.laboratory.turn_over_input(session, bit),
            Place::Output(bit) => self.laboratory.turn_over_output(session, bit),
        }
    }

    /// Whether the run is over.
    fn is_over(&mut self, at_ns: u64) -> bool {
        let log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        match &mut self.role {
            Role::Reference(plan) => {
                let mut plan = plan.lock().unwrap_or_else(PoisonError::into_inner);
                plan.heard_by
                    .resize(log.position_m.len(), self.pc.heard.len());
                let started_ns = self.pc.started_ns.unwrap_or(u64::MAX - TEST_NS);
                if at_ns < started_ns + TEST_NS {
                    return false;
                }
                plan.started_ns = started_ns;
                (plan.log, plan.heard) = (log.clone(), self.pc.heard.clone());
                true
            }
            Role::Original(original) => {
                let over = original.flips.is_empty();
                drop(log);
                if over {
                    original.end();
                }
                over
            }
            Role::Copy { watch, plan, told } => {
                if watch.look(&log, at_ns) {
                    let (outcome, apart_m) = watch.outcome(&log, &self.pc.heard, plan);
                    let place = Outcome::ALL.iter().position(|o| *o == outcome);
                    // If it cannot be written, the outcome is unknown.
                    let _ = writeln!(told, "{} {apart_m}", place.unwrap_or(usize::MAX));
                    std::process::exit(0);
                }
                false
            }
        }
    }
}

impl Driver<Nucleo> for Trial {
    fn on_settled(&mut self, session: &mut Session<Nucleo>, host: &mut dyn Host, settled: Settled) {
        self.laboratory.on_settled(session, host, settled);
    }

    fn on_stop(
        &mut self,
        session: &mut Session<Nucleo>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        let due = |role: &Role| match role {
            Role::Original(original) => original.flips.front().map(|flip| flip.at_ns),
            Role::Reference(_) | Role::Copy { .. } => None,
        };
        // A flip gives neither laboratory nor PC a turn, since they would have none without it.
        let mut flips = false;
        while due(&self.role).is_some_and(|at_ns| at_ns <= stop.at.0) {
            self.flip(session, host, stop);
            flips = true;
        }
        if !flips || stop.at.0 >= self.next_ns {
            let next = self.laboratory.on_stop(session, stop, host)?;
            self.next_ns = next.0;
            self.pc.turn(stop.at.0);
            if self.pc.refused.is_some() {
                *self.refused.lock().unwrap_or_else(PoisonError::into_inner) =
                    self.pc.refused.take();
                return None;
            }
        }
        if self.is_over(stop.at.0) {
            return None;
        }
        let next_ns = due(&self.role).map_or(self.next_ns, |at_ns| at_ns.min(self.next_ns));
        Some(VirtualNanos(next_ns))
    }
}
