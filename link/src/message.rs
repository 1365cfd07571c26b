//! Commands and replies as frames, coded with postcard.

use crate::command::Command;
use crate::frame::{Frame, FrameKind, MAX_BODY, MAX_WIRE, TooLong};
use crate::reply::NumberedReply;
use heapless::Vec;
use serde::{Serialize, de::DeserializeOwned};

/// The body of a frame of its kind.
pub trait Message: Serialize + DeserializeOwned {
    /// The kind of its frames.
    const KIND: FrameKind;

    /// As a frame on the wire.
    ///
    /// # Errors
    /// It is longer than [`MAX_BODY`]; no command or reply of this crate is.
    fn encode(&self, sequence: u16) -> Result<Vec<u8, MAX_WIRE>, TooLong> {
        let mut body = [0; MAX_BODY];
        let body = postcard::to_slice(self, &mut body).map_err(|_| TooLong)?;
        let frame = Frame {
            kind: Self::KIND,
            sequence,
            body,
        };
        frame.encode()
    }

    /// From a frame; `None` if it is of another kind, is none of the messages, or has bytes left over.
    fn decode(frame: &Frame<'_>) -> Option<Self> {
        if frame.kind != Self::KIND {
            return None;
        }
        match postcard::take_from_bytes(frame.body) {
            Ok((message, [])) => Some(message),
            _ => None,
        }
    }
}

impl Message for Command {
    const KIND: FrameKind = FrameKind::Command;
}

impl Message for NumberedReply {
    const KIND: FrameKind = FrameKind::Reply;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agreed::MAX_ACTUATORS;
    use crate::channel::{Calibration, TWELVE_BITS};
    use crate::command::{CHUNK, Channel, CommissioningSignal, SignalShape};
    use crate::frame::{Decoder, DecoderCounts};
    use crate::reply::{Identity, Obstacle, RefusedParameter, Reply, cut};
    use crate::status::{CrashCause, CrashReport, StartCause, Status, Timing};
    use crate::telemetry::{Input, MAX_INPUTS};
    use core::fmt::Debug;
    use outerloop_core::{
        Config, Event, Fault, Mode, Pace, Trip,
        config::{
            ActuatorTimes, Hydraulic, Limits, PerActuator, PerFloor, RigConfig, StructureConfig,
        },
    };
    use proptest::prelude::*;

    fn there_and_back<M: Message + PartialEq + Debug>(message: &M) -> usize {
        let wire = message.encode(321).expect("fits");
        let mut decoder = Decoder::new();
        let mut arrived = None;
        for &byte in &wire {
            if let Some(frame) = decoder.push(byte) {
                assert_eq!(frame.sequence, 321);
                arrived = M::decode(&frame);
            }
        }
        assert_eq!(arrived.as_ref(), Some(message));
        wire.len()
    }

    /// What an image can run at most: every number that can be left out is written, and with the longest code.
    fn largest_config() -> Config {
        let floors: PerFloor = [f64::MAX; 3].into_iter().collect();
        let actuators: PerActuator = [f64::MAX; MAX_ACTUATORS].into_iter().collect();
        let limit = Some(f64::MAX);
        let mut config = Config {
            structure: StructureConfig {
                mass_kg: floors.clone(),
                stiffness_n_per_m: floors.clone(),
                damping_ratio: floors.clone(),
                physical_storeys: Some(u8::MAX),
                physical_mass_kg: floors,
            },
            timing: Default::default(),
            compensation: Default::default(),
            estimation: Default::default(),
            limits: Limits {
                displacement_m: limit,
                increment_m: limit,
                velocity_m_per_s: limit,
                force_n: limit,
                tracking_m: limit,
                energy_warning: limit,
                energy_trip: limit,
                energy_floor_j: limit,
                stale_steps: Some(u16::MAX),
                frozen_m: limit,
                locked_damping_ratio: limit,
            },
            rig: RigConfig {
                command_gain: actuators.clone(),
                command_offset_m: actuators.clone(),
                displacement_gain: actuators.clone(),
                displacement_offset_m: actuators.clone(),
                force_gain: actuators.clone(),
                force_offset_n: actuators.clone(),
                force_late_ms: actuators.clone(),
                bearing_friction_n: actuators.clone(),
                bearing_presliding_m: actuators,
            },
        };
        let times = ActuatorTimes::each(&[f64::MAX; MAX_ACTUATORS]).unwrap();
        let c = &mut config.compensation;
        c.delay_ms = times.clone();
        (c.inverse, c.clamp_below) = (Some([f64::MAX; 3]), limit);
        c.hydraulic = Some(Hydraulic::of_delay(0.01, 1e6));
        (config.estimation.delay_ms, config.estimation.lag_ms) = (times.clone(), times);
        config.timing.substeps = u16::MAX;
        config.timing.late_limit_steps = u16::MAX;
        config
    }

    #[test]
    fn every_command_comes_back_as_it_was() {
        let signal = |shape| {
            Some(CommissioningSignal {
                actuator: 2,
                shape,
                amplitude_m: 0.01,
                seconds: 20.0,
            })
        };
        let mut commands = std::vec![
            Command::Identify,
            Command::Status,
            Command::Configure(largest_config()),
            Command::Calibrate(2, Calibration::placeholder(&TWELVE_BITS)),
            Command::Zero {
                actuator: 2,
                channel: Channel::Force,
                value: -1.5
            },
            Command::Save,
            Command::Motion {
                points: 16_384,
                interval_s: 0.005,
                checksum: u32::MAX
            },
            Command::Points {
                first: 16_000,
                points: [f32::MIN; CHUNK].into_iter().collect()
            },
            Command::Signal(None),
            Command::Signal(signal(SignalShape::Constant)),
            Command::Signal(signal(SignalShape::Sine { frequency_hz: 1.0 })),
            Command::Signal(signal(SignalShape::Chirp {
                from_hz: 0.1,
                to_hz: 20.0
            })),
            Command::History(15),
            Command::Pace(None),
            Command::Pace(Some(Pace::Continuous)),
            Command::Target([f32::MIN; crate::MAX_ACTUATORS].into_iter().collect()),
        ];
        commands.extend(Event::ALL.map(Command::Event));
        let longest = commands.iter().map(there_and_back).max();
        assert!(longest <= Some(MAX_WIRE), "{longest:?}");
    }

    #[test]
    fn every_reply_comes_back_as_it_was() {
        let long = "ä".repeat(200);
        let replies = std::vec![
            Reply::Identity(Identity {
                board: cut(&long),
                version: cut(&long),
                commit: cut(&long),
                clock_hz: 168_000_000,
                timer_hz: 84_000_000,
                rate_hz: 2000,
                fastest_rate_hz: 3000,
                output_delay_us: 50.0,
                max_points: 16_384,
                max_dof: 3,
                deadline_cycles: 4200,
                codes: TWELVE_BITS,
                calibration: Calibration::placeholder(&TWELVE_BITS),
                others: [Calibration::placeholder(&TWELVE_BITS); 2]
                    .into_iter()
                    .collect(),
                inputs: [Input::CommandReadBack(2); MAX_INPUTS]
                    .into_iter()
                    .collect(),
                input_span_v: [-10.0, 10.0],
            }),
            Reply::Status(Status {
                tick: u32::MAX,
                state: Mode::Tripped,
                trip: Some(Trip {
                    fault: Fault::Force,
                    axis: 0,
                    value: 1.0,
                    limit: 0.5,
                    tick: 9
                }),
                permit: true,
                configured: true,
                calibrated: true,
                points: 16_384,
                crystal_ok: true,
                converters_ok: true,
                codes: [8190; 2],
                other_codes: [[8190; 2]; 2].into_iter().collect(),
                timing: Timing::default(),
                link: DecoderCounts::default(),
                dropped_steps: 3,
                stack_bytes: 4096,
                started: StartCause::Watchdog,
                last_crash: Some(CrashReport {
                    cause: CrashCause::Panic,
                    tick: 77,
                    state: Mode::Running,
                    text: cut(&long),
                }),
            }),
            Reply::Done {
                tick: 1,
                state: Mode::Armed
            },
            Reply::Refused(RefusedParameter::new(&long, 1.5, &long)),
            Reply::Rejected {
                state: Mode::Idle,
                event: Some(Event::Arm),
                obstacle: Some(Obstacle::Fault(Fault::AdcRail))
            },
            Reply::Zeroed {
                code: 4095.5,
                spread: 3
            },
            Reply::Record([u32::MAX; crate::reply::MAX_RECORD].into_iter().collect()),
            Reply::Expected(128),
            Reply::WrongSum { received: 5 },
            Reply::Unknown,
        ];
        for reply in replies {
            there_and_back(&NumberedReply { request: 9, reply });
        }
    }

    #[test]
    fn bytes_left_over_are_no_message() {
        let frame = |kind, body| Frame {
            kind,
            sequence: 0,
            body,
        };
        assert!(Command::decode(&frame(FrameKind::Command, &[0])).is_some());
        assert!(Command::decode(&frame(FrameKind::Command, &[0, 0])).is_none());
        assert!(Command::decode(&frame(FrameKind::Reply, &[0])).is_none());
        assert!(Command::decode(&frame(FrameKind::Command, &[200])).is_none());
    }

    proptest! {
        #[test]
        fn no_body_is_too_much(body in proptest::collection::vec(any::<u8>(), 0..MAX_BODY)) {
            for kind in [FrameKind::Command, FrameKind::Reply] {
                let frame = Frame { kind, sequence: 0, body: &body };
                // Whatever is read is a message that can be sent again.
                if let Some(command) = Command::decode(&frame) {
                    prop_assert!(command.encode(0).is_ok());
                }
                if let Some(answer) = NumberedReply::decode(&frame) {
                    prop_assert!(answer.encode(0).is_ok());
                }
            }
        }
    }
}
