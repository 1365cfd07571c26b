//! Bytes from the wire: noise, and the bodies of frames with the right checksum.
#![no_main]

use fuzz::begin_with;
use libfuzzer_sys::fuzz_target;
use link::frame::{Decoder, Frame, FrameKind, MAX_BODY, TooLong};
use link::message::Message;
use link::reply::NumberedReply;
use link::telemetry::{STEP_BYTES, StepReport};
use link::{Command, Telemetry};
use outerloop_core::{Config, Event};

fuzz_target!(
    init: begin_with(seeds()),
    |bytes: &[u8]| {
        // First the raw bytes: whatever they contain, the frame after them is found.
        let mut decoder = Decoder::new();
        for byte in bytes {
            if let Some(frame) = decoder.push(*byte) {
                understood(&frame);
            }
        }
        arrives(&mut decoder, FrameKind::Command, &[0]);
        let Some((kind, body)) = bytes.split_first() else {
            return;
        };
        let kinds = [FrameKind::Command, FrameKind::Reply, FrameKind::Telemetry];
        arrives(&mut decoder, kinds[usize::from(*kind) % 3], body);
    }
);

/// A frame with this body arrives, whether or not it can be decoded as a message.
fn arrives(decoder: &mut Decoder, kind: FrameKind, body: &[u8]) {
    let frame = Frame {
        kind,
        sequence: 7,
        body,
    };
    let wire = match frame.encode() {
        Ok(wire) => wire,
        Err(TooLong) => return assert!(body.len() > MAX_BODY),
    };
    // A zero byte ends whatever came before it.
    decoder.push(0);
    let mut came = false;
    for byte in &wire {
        if let Some(arrived) = decoder.push(*byte) {
            assert_eq!(arrived, frame);
            understood(&arrived);
            came = true;
        }
    }
    assert!(came);
}

/// A message that can be decoded is the same after encoding and decoding it again.
fn understood(frame: &Frame<'_>) {
    same_again(Command::decode(frame));
    same_again(NumberedReply::decode(frame));
    if frame.kind == FrameKind::Telemetry
        && let Some(telemetry) = Telemetry::decode(frame.body)
    {
        let further = frame.body[4];
        let (actuators, inputs) = (usize::from(further >> 4) + 1, usize::from(further & 0xf));
        assert_eq!(telemetry.encode(actuators, inputs), frame.body);
        for step in &telemetry.steps {
            let _ = (step.mode(), step.fault(), step.codes(2));
        }
    }
}

fn same_again<M: Message>(message: Option<M>) {
    let Some(message) = message else { return };
    let wire = message.encode(1).expect("no message is too long");
    let mut decoder = Decoder::new();
    let again = wire.iter().find_map(|byte| {
        let frame = decoder.push(*byte)?;
        M::decode(&frame)
    });
    // Compare bytes, because a NaN is not equal to itself.
    let again = again.and_then(|m| m.encode(1).ok());
    assert_eq!(again, Some(wire));
}

/// Frames as the target takes them: the kind, then the body.
fn seeds() -> Vec<Vec<u8>> {
    let body = |kind: u8, wire: &[u8]| {
        let mut decoder = Decoder::new();
        let found = wire
            .iter()
            .find_map(|b| decoder.push(*b).map(|frame| frame.body.to_vec()));
        [vec![kind], found.expect("a frame")].concat()
    };
    let commands = [
        Command::Configure(Config::shear_frame([1e3; 3], [158e3; 3], [0.02; 3]).into()),
        Command::Motion {
            points: 400,
            interval_s: 0.01,
            checksum: 5,
        },
        Command::Points {
            first: 0,
            points: [0.1; 16].into_iter().collect(),
        },
        Command::Event(Event::Arm),
    ];
    let mut seeds: Vec<_> = commands
        .iter()
        .map(|command| body(0, &command.encode(1).expect("short enough")))
        .collect();
    let step = StepReport::from_bytes(&[0; STEP_BYTES]).expect("a step");
    let telemetry = Telemetry {
        first_tick: 9,
        steps: core::iter::repeat_n(step, 3).collect(),
    };
    seeds.push([&[2], telemetry.encode(2, 3).as_slice()].concat());
    seeds
}
