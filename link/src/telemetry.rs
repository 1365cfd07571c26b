//! The record of a control step on the link: 24 bytes, plus four for each further actuator and two for each further
//! input, fixed layout, little-endian.
//!
//! | bytes | what |
//! |---|---|
//! | 0..4 | mode, latched fault and flags: [`Record::flags`] |
//! | 4..6, 6..8 | codes of displacement and force of the first actuator, as sampled |
//! | 8..12 | its command in force, m; while a commissioning signal is set, that of the actuator which it moves |
//! | 12..16 | its C_cor, N s/m |
//! | 16..20 | energy error since the start, Eq 12, J |
//! | 20..24 | digest of the whole record |
//! | 24..28, .. | codes of displacement and force of each further actuator |
//! | after them, two each | codes of the board's further inputs, in the order of its identity |
//!
//! A frame holds [`STEPS`] successive steps, preceded by the tick of the first and a byte with the number of further
//! inputs in its low half and of further actuators in its high half. The outer loop computes the same bits on the PC as
//! on the board, so the PC, fed with the codes, recomputes every other word of the record, including the other
//! actuators' commands; the digest proves it.

use crate::agreed::MAX_ACTUATORS;
use crate::frame::wire_bytes;
use heapless::Vec;
use outerloop_core::{Fault, Mode, Record};

/// Steps in a full frame: 4 ms at 2 kHz. The last frame before a pause may hold fewer.
pub const STEPS: usize = 8;

/// Bytes of a step for one actuator without further inputs.
pub const STEP_BYTES: usize = 24;

/// Largest number of further inputs of a board.
pub const MAX_INPUTS: usize = 5;

/// Tick of the first step, numbers of further inputs and actuators.
const HEAD: usize = 5;

/// Bytes in the body of the longest frame.
pub const BODY_BYTES: usize = HEAD + STEPS * step_bytes(MAX_ACTUATORS, MAX_INPUTS);

/// Bytes of a step with this many actuators and further inputs.
const fn step_bytes(actuators: usize, inputs: usize) -> usize {
    STEP_BYTES + 4 * (actuators - 1) + 2 * inputs
}

/// Bytes of a full frame on the wire, of a board with this many actuators (at least one) and further inputs.
pub const fn frame_bytes(actuators: usize, inputs: usize) -> usize {
    wire_bytes(HEAD + STEPS * step_bytes(actuators, inputs))
}

/// What a board records beside displacement and force, in every control step. The test does not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Input {
    /// An actuator's command where it leaves the board, by codes of the command: distinguishes a dead output converter from a dead
    /// valve. The actuator counts from 0.
    CommandReadBack(u8),
    /// A second displacement, by codes of the sensors.
    SecondDisplacement,
    /// Acceleration of the actuator's head, by codes of the sensors.
    HeadAcceleration,
}

impl Input {
    /// Volts at an input whose codes run from 0 at the lower end of `span_v` to `top` at the upper end.
    pub fn volts(code: u16, top: u16, [low_v, high_v]: [f32; 2]) -> f64 {
        let (low_v, high_v) = (f64::from(low_v), f64::from(high_v));
        low_v + (high_v - low_v) * f64::from(code) / f64::from(top)
    }
}

/// One control step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepReport {
    /// Mode, fault and flags of the record.
    pub flags: u32,
    /// Displacement of the first actuator as sampled, a code of the board's [`CodeRange`](crate::CodeRange).
    pub displacement: u16,
    /// Its force as sampled.
    pub force: u16,
    /// Displacement and force of the others; zero for those that the board does not have.
    pub others: [[u16; 2]; MAX_ACTUATORS - 1],
    /// The first actuator's command in force while the sample was taken, m; while a commissioning signal is set, that
    /// of the actuator which it moves.
    pub command_m: f32,
    /// C_cor of axis 1, N s/m.
    pub added_damping_n_s_per_m: f32,
    /// Energy error since the start, Eq 12, J.
    pub energy_j: f32,
    /// Digest of the record.
    pub digest: u32,
    /// Codes of the board's further inputs; zero for those that it does not have.
    pub inputs: [u16; MAX_INPUTS],
}

/// A 32-bit hash of all words of a record.
pub fn digest<const N: usize>(record: &Record<N>) -> u32 {
    let hash = record.hash(Record::<N>::HASH_START);
    (hash ^ (hash >> 32)) as u32
}

impl StepReport {
    /// The report of `record`, with the codes of its sample: displacement and force of each actuator. `moves`: the
    /// actuator whose command is reported, from 0.
    #[inline]
    pub fn of<const A: usize, const N: usize>(
        record: &Record<N>,
        codes: &[[u16; 2]; A],
        inputs: [u16; MAX_INPUTS],
        moves: usize,
    ) -> Self {
        let (first, rest) = codes.split_first().unwrap_or((&[0; 2], &[]));
        let mut others = [[0; 2]; MAX_ACTUATORS - 1];
        for (place, codes) in others.iter_mut().zip(rest) {
            *place = *codes;
        }
        Self {
            flags: record.flags,
            displacement: first[0],
            force: first[1],
            others,
            command_m: record.command_m.get(moves).copied().unwrap_or(0.0),
            added_damping_n_s_per_m: record
                .added_damping_n_s_per_m
                .first()
                .copied()
                .unwrap_or(0.0),
            energy_j: record.energy_sum.modified_j,
            digest: digest(record),
            inputs,
        }
    }

    /// The mode of the test; `None` if the flags hold no mode.
    pub fn mode(&self) -> Option<Mode> {
        Mode::from_code(self.flags & 0xf)
    }

    /// The latched fault.
    pub fn fault(&self) -> Option<Fault> {
        Fault::from_code((self.flags >> 8) as u8)
    }

    /// The codes of displacement and force of an actuator, from 0; `None` if it exceeds what any board has.
    pub fn codes(&self, actuator: usize) -> Option<[u16; 2]> {
        match actuator.checked_sub(1) {
            None => Some([self.displacement, self.force]),
            Some(other) => self.others.get(other).copied(),
        }
    }

    /// As bytes, without further actuators and inputs.
    pub fn to_bytes(&self) -> [u8; STEP_BYTES] {
        let mut bytes = [0; STEP_BYTES];
        let codes = u32::from(self.displacement) | u32::from(self.force) << 16;
        let words = [
            self.flags,
            codes,
            self.command_m.to_bits(),
            self.added_damping_n_s_per_m.to_bits(),
            self.energy_j.to_bits(),
            self.digest,
        ];
        for (place, word) in bytes.chunks_exact_mut(4).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }

    /// From bytes, without further actuators and inputs.
    pub fn from_bytes(bytes: &[u8; STEP_BYTES]) -> Option<Self> {
        let (words, _) = bytes.as_chunks::<4>();
        let &[flags, codes, command, damping, energy, digest] = words else {
            return None;
        };
        let codes = u32::from_le_bytes(codes);
        Some(Self {
            flags: u32::from_le_bytes(flags),
            displacement: codes as u16,
            force: (codes >> 16) as u16,
            others: Default::default(),
            command_m: f32::from_le_bytes(command),
            added_damping_n_s_per_m: f32::from_le_bytes(damping),
            energy_j: f32::from_le_bytes(energy),
            digest: u32::from_le_bytes(digest),
            inputs: [0; MAX_INPUTS],
        })
    }
}

/// Successive steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Telemetry {
    /// Tick of the first step.
    pub first_tick: u32,
    /// The steps.
    pub steps: Vec<StepReport, STEPS>,
}

impl Telemetry {
    /// Encodes it as the body of a frame, for a board with this many actuators, 1 to [`MAX_ACTUATORS`], and further
    /// inputs, at most [`MAX_INPUTS`].
    pub fn encode(&self, actuators: usize, inputs: usize) -> Vec<u8, BODY_BYTES> {
        let inputs = inputs.min(MAX_INPUTS);
        let others = actuators.saturating_sub(1).min(MAX_ACTUATORS - 1);
        let mut body = Vec::new();
        // The type guarantees enough room.
        let _ = body.extend_from_slice(&self.first_tick.to_le_bytes());
        let _ = body.push((others << 4 | inputs) as u8);
        for step in &self.steps {
            let _ = body.extend_from_slice(&step.to_bytes());
            let codes = step.others.iter().take(others).flatten();
            for code in codes.chain(step.inputs.iter().take(inputs)) {
                let _ = body.extend_from_slice(&code.to_le_bytes());
            }
        }
        body
    }

    /// Decodes the body of a frame; `None` if it is not telemetry.
    pub fn decode(body: &[u8]) -> Option<Self> {
        let (tick, rest) = body.split_first_chunk::<4>()?;
        let (&further, steps) = rest.split_first()?;
        let (others, inputs) = (usize::from(further >> 4), usize::from(further & 0xf));
        if others >= MAX_ACTUATORS || inputs > MAX_INPUTS {
            return None;
        }
        let steps = steps.chunks_exact(step_bytes(others + 1, inputs));
        if !steps.remainder().is_empty() || steps.len() > STEPS {
            return None;
        }
        Some(Self {
            first_tick: u32::from_le_bytes(*tick),
            steps: steps
                .map(|step| step_of(step, others))
                .collect::<Option<_>>()?,
        })
    }
}

/// A step with `others` further actuators, and inputs.
fn step_of(bytes: &[u8], others: usize) -> Option<StepReport> {
    let (step, further) = bytes.split_first_chunk::<STEP_BYTES>()?;
    let mut report = StepReport::from_bytes(step)?;
    let (codes, _) = further.as_chunks::<2>();
    let places = report.others.iter_mut().take(others).flatten();
    for (place, code) in places.chain(&mut report.inputs).zip(codes) {
        *place = u16::from_le_bytes(*code);
    }
    Some(report)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Frame, FrameKind};
    use proptest::prelude::*;

    fn step(seed: u32) -> StepReport {
        let mix = |k: u32| seed.wrapping_mul(0x9e37_79b9).wrapping_add(k);
        StepReport {
            flags: mix(1),
            displacement: mix(2) as u16,
            force: mix(3) as u16,
            others: Default::default(),
            command_m: mix(4) as f32,
            added_damping_n_s_per_m: mix(5) as f32,
            energy_j: mix(6) as f32,
            digest: mix(7),
            inputs: [0; MAX_INPUTS],
        }
    }

    #[test]
    fn a_full_frame_is_as_long_as_the_budget_says() {
        let t = Telemetry {
            first_tick: u32::MAX,
            steps: (0..STEPS as u32).map(step).collect(),
        };
        let frame = Frame {
            kind: FrameKind::Telemetry,
            sequence: u16::MAX,
            body: &t.encode(1, 0),
        };
        let wire = frame.encode().unwrap();
        assert_eq!(wire.len(), frame_bytes(1, 0));
        let share = wire.len() as f64 / STEPS as f64 * 2000.0 * 10.0 / f64::from(crate::BAUD);
        assert!(share < 0.53, "{share} of the port");
        for inputs in 0..=MAX_INPUTS {
            assert!(crate::fastest_rate_hz(crate::BAUD, 1, inputs) >= 2400);
        }
        // Three actuators and all inputs still travel at 2 kHz.
        assert!(crate::fastest_rate_hz(crate::BAUD, MAX_ACTUATORS, MAX_INPUTS) >= 2000);
    }

    #[test]
    fn a_record_is_known_by_its_digest() {
        let mut a = Record::<2>::EMPTY;
        a.tick = 5;
        let mut b = a;
        assert_eq!(digest(&a), digest(&b));
        b.innovation[1] = f32::from_bits(1);
        assert_ne!(digest(&a), digest(&b));
    }

    #[test]
    fn half_a_step_is_refused() {
        let body = Telemetry {
            first_tick: 1,
            steps: [step(3)].into_iter().collect(),
        }
        .encode(1, 0);
        assert!(Telemetry::decode(&body[..28]).is_none());
        assert!(Telemetry::decode(&[]).is_none());
        // More inputs than possible, in a body of matching length.
        let mut many = [0; 4 + 1 + STEP_BYTES + 2 * (MAX_INPUTS + 1)];
        many[4] = MAX_INPUTS as u8 + 1;
        assert!(Telemetry::decode(&many).is_none());
        // More actuators.
        let mut many = [0; 4 + 1 + STEP_BYTES + 4 * MAX_ACTUATORS];
        many[4] = (MAX_ACTUATORS as u8) << 4;
        assert!(Telemetry::decode(&many).is_none());
    }

    proptest! {
        #[test]
        fn comes_back_as_it_was(
            first_tick: u32,
            count in 0..=STEPS,
            actuators in 1..=MAX_ACTUATORS,
            inputs in 0..=MAX_INPUTS,
            seed: u32,
        ) {
            let with_inputs = |i: u32| {
                let mut step = step(seed.wrapping_add(i));
                for (k, code) in (0_u16..).zip(step.inputs.iter_mut().take(inputs)) {
                    *code = (seed as u16).wrapping_add(k);
                }
                let others = step.others.iter_mut().take(actuators - 1).flatten();
                for (k, code) in (7_u16..).zip(others) {
                    *code = (seed as u16).wrapping_add(k);
                }
                step
            };
            let t = Telemetry { first_tick, steps: (0..count as u32).map(with_inputs).collect() };
            prop_assert_eq!(Telemetry::decode(&t.encode(actuators, inputs)), Some(t));
        }
    }
}
