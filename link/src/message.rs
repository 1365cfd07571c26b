//! Commands and replies as frames, coded with postcard.

use crate::command::Command;
use crate::frame::{Frame, FrameKind, MAX_BODY, MAX_WIRE, TooLong};
use crate::reply::{NumberedReply, RefusedParameter, Reply};
use heapless::Vec;
use outerloop_core::config::{StructureConfig, Timing};
use outerloop_core::{Force, Prediction};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// The body of a frame of some kind.
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

    /// Decodes a frame; `None` if it is of another kind, is none of the messages, or has bytes left over.
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

impl Command {
    /// A board's reading of a frame of commands.
    ///
    /// # Errors
    /// Why it holds no command of this build; also the answer to send.
    pub fn received(frame: &Frame<'_>) -> Result<Self, NotUnderstood> {
        Self::decode(frame).ok_or_else(|| NotUnderstood::by(frame))
    }
}

/// Why a good frame holds no command of this build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotUnderstood {
    /// A test asks for a force law with this number, unknown to this build.
    Force(u8),
    /// A test asks for a predictor with this number, unknown to this build.
    Predictor(u8),
    /// Anything else: another version of this crate.
    Other,
}

impl NotUnderstood {
    /// Parses a [`Command::Configure`] up to its compensation.
    fn by(frame: &Frame<'_>) -> Self {
        let Ok((head, _)) = postcard::take_from_bytes::<ConfigureHead>(frame.body) else {
            return Self::Other;
        };
        let (force, predictor) = head.method;
        if head.command != CONFIGURE {
            Self::Other
        } else if Force::from_code(force).is_none() {
            Self::Force(force)
        } else if Prediction::from_code(predictor).is_none() {
            Self::Predictor(predictor)
        } else {
            Self::Other
        }
    }
}

impl From<NotUnderstood> for Reply {
    fn from(why: NotUnderstood) -> Self {
        let (name, code, accepted) = match why {
            NotUnderstood::Force(code) => (
                "force law of compensation.kind, by number",
                code,
                "the force laws of its own firmware; flash that of the program",
            ),
            NotUnderstood::Predictor(code) => (
                "predictor of compensation.kind, by number",
                code,
                "the predictors of its own firmware; flash that of the program",
            ),
            NotUnderstood::Other => return Self::Unknown,
        };
        Self::Refused(RefusedParameter::new(name, code.into(), accepted))
    }
}

/// The number of [`Command::Configure`] on the link.
const CONFIGURE: u8 = 2;

/// How a [`Command::Configure`] begins: the [`Config`](outerloop_core::Config) up to the first of its compensation.
#[derive(Deserialize)]
struct ConfigureHead {
    command: u8,
    _structure: StructureConfig,
    _timing: Timing,
    method: (u8, u8),
}

impl Message for NumberedReply {
    const KIND: FrameKind = FrameKind::Reply;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::agreed::MAX_ACTUATORS;
    use crate::channel::{Calibration, TWELVE_BITS};
    use crate::command::{BoardTest, CHUNK, Channel, CommissioningSignal, SignalShape};
    use crate::frame::{Decoder, DecoderCounts};
    use crate::reply::{Identity, Obstacle, cut};
    use crate::status::{
        CrashCause, CrashReport, MAX_NAMED, NamedCause, StartCause, Status, Timing, WatchStatus,
    };
    use crate::telemetry::{Input, MAX_INPUTS};
    use core::fmt::Debug;
    use outerloop_core::coupled::{
        Bounds, CoupledSettings, Coupler, EstimatorSettings, MAX_PARAMETERS, Parameter, Plant,
        SteadyObserver, TrackerSettings, VibrationMode,
    };
    use outerloop_core::watch::{Cause, State};
    use outerloop_core::{
        Config, Event, Fault, Method, Mode, Pace, Structure, Trip,
        config::{ActuatorTimes, Hydraulic, Limits, PerActuator, PerFloor, RigConfig},
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

    /// The largest test that an image can run: every optional number is present and has its longest encoding.
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
                disagree_m: limit,
                force_stands_m: limit,
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
        c.own = [f64::MAX; 8].into_iter().collect();
        (config.estimation.delay_ms, config.estimation.lag_ms) = (times.clone(), times);
        config.timing.substeps = u16::MAX;
        config.timing.late_limit_steps = u16::MAX;
        config
    }

    /// The same for two coupled actuators, whose test has none of the lists and methods.
    fn largest_coupled() -> BoardTest {
        let (pair, single) = ([f64::MAX; 2], [f32::MAX; 2]);
        let limit = Some(f64::MAX);
        let mut config = Config::shear_frame(pair, pair, pair);
        config.structure.physical_storeys = Some(2);
        config.limits = Limits {
            stale_steps: Some(u16::MAX),
            displacement_m: limit,
            velocity_m_per_s: limit,
            force_n: limit,
            tracking_m: limit,
            frozen_m: limit,
            energy_trip: limit,
            force_stands_m: limit,
            ..Limits::default()
        };
        let mode = VibrationMode {
            omega_rad_per_s: f64::MAX,
            damping_ratio: f64::MAX,
            participation: f64::MAX,
        };
        let observer = SteadyObserver {
            modes: [(mode, pair); 2].into_iter().collect(),
        };
        let bounds = Bounds {
            position: f64::MAX,
            speed_per_s: f64::MAX,
            force: f64::MAX,
            tracking: f64::MAX,
        };
        let coupled = CoupledSettings {
            structure: Structure {
                mass: [pair; 2],
                damping: [pair; 2],
                stiffness: [pair; 2],
                numerical_stiffness: [pair; 2],
                influence: pair,
                physical: 2,
                physical_mass_kg: pair,
            },
            tracker: TrackerSettings {
                coupler: Coupler {
                    pin_x_m: single,
                    pin_y_m: single,
                },
                estimate: EstimatorSettings {
                    plant: Plant {
                        gain: [single; 2],
                        slow_pole_rad_per_s: single,
                        fast_pole_rad_per_s: single,
                        lead_s: [single; 2],
                        path_lead_s: [single; 2],
                        natural_rad_per_s: f32::MAX,
                        damping_ratio: f32::MAX,
                        delay_s: single,
                    },
                    spreads: [(Parameter::PathLead(1, 1), f32::MAX); MAX_PARAMETERS]
                        .into_iter()
                        .collect(),
                    noise_m: f32::MAX,
                    period_s: f32::MAX,
                },
                inverse: true,
                target: [observer.clone(), observer],
                ahead_s: f32::MAX,
                trust_reading_hz: f32::MAX,
            },
            interface: [bounds; 2],
        };
        BoardTest {
            config,
            coupled: Some(coupled),
        }
    }

    /// The body of a test with method numbers of force law and predictor that only another build knows.
    fn configure_by_number(force: u8, predictor: u8) -> std::vec::Vec<u8> {
        let known = |kind| {
            let mut config = largest_config();
            config.compensation.kind = kind;
            let mut body = [0; MAX_BODY];
            postcard::to_slice(&Command::Configure(config.into()), &mut body)
                .unwrap()
                .to_vec()
        };
        // The numbers are where the bodies of two methods differ.
        let (mut body, other) = (
            known(Method::Lagrange),
            known(Method::Tangent.behind(Prediction::Ats)),
        );
        let places: std::vec::Vec<_> = (0..body.len()).filter(|&i| body[i] != other[i]).collect();
        assert_eq!(places.len(), 2);
        (body[places[0]], body[places[1]]) = (force, predictor);
        body
    }

    #[test]
    fn a_method_that_a_board_does_not_have_is_refused_in_a_sentence() {
        let answer = |body: &[u8]| {
            let frame = Frame {
                kind: FrameKind::Command,
                sequence: 1,
                body,
            };
            Command::received(&frame)
        };
        let (law, predictor) = (Force::Paper.code(), Prediction::Ats.code());
        assert!(answer(&configure_by_number(law, predictor)).is_ok());
        for (force, behind, wrong) in [(law, 200, "predictor"), (100, predictor, "force law")] {
            let why = answer(&configure_by_number(force, behind)).unwrap_err();
            let Reply::Refused(refused) = Reply::from(why) else {
                panic!("{force} {behind} is not refused");
            };
            let said = std::format!("{refused}");
            let number = if force == law { behind } else { force };
            assert!(
                said.contains(wrong)
                    && said.contains(&std::format!("= {number} "))
                    && said.ends_with("of the program"),
                "{said}"
            );
        }
        // A malformed test is not refused because of its compensation.
        let mut cut_short = configure_by_number(law, 200);
        cut_short[0] = 200;
        assert_eq!(answer(&cut_short), Err(NotUnderstood::Other));
        assert_eq!(Reply::from(NotUnderstood::Other), Reply::Unknown);
        assert_eq!(
            answer(&configure_by_number(law, predictor)[..20]),
            Err(NotUnderstood::Other)
        );
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
            Command::Configure(largest_config().into()),
            Command::Configure(largest_coupled()),
            Command::Calibrate(2, Calibration::nominal(&TWELVE_BITS)),
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
        let found = NamedCause {
            actuator: 3,
            cause: Cause::ForceHum,
            value: f32::MAX,
            sd: f32::MAX,
            corrected: f32::MAX,
        };
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
                calibration: Calibration::nominal(&TWELVE_BITS),
                others: [Calibration::nominal(&TWELVE_BITS); 2]
                    .into_iter()
                    .collect(),
                inputs: [Input::CommandReadBack(2); MAX_INPUTS]
                    .into_iter()
                    .collect(),
                input_span_v: [-10.0, 10.0],
            }),
            Reply::Status(Status {
                tick: u32::MAX,
                mode: Mode::Tripped,
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
                watch: Some(WatchStatus {
                    state: State::Trip,
                    since_step: u32::MAX,
                    named: [found; MAX_NAMED].into_iter().collect(),
                    held: true,
                    blocks: u32::MAX,
                    worst_cycles: u32::MAX,
                    mean_cycles: u32::MAX,
                }),
                started: StartCause::Watchdog,
                last_crash: Some(CrashReport {
                    cause: CrashCause::Panic,
                    tick: 77,
                    mode: Mode::Running,
                    text: cut(&long),
                }),
            }),
            Reply::Done {
                tick: 1,
                mode: Mode::Armed
            },
            Reply::Refused(RefusedParameter::new(&long, 1.5, &long)),
            Reply::Rejected {
                mode: Mode::Idle,
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
                // Anything that decodes is a message that can be sent again.
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
