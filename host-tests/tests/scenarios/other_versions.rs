//! A program and a board of different builds: refused in one sentence, whichever is older, and nothing is executed.

use crate::board_link::{QUICK, loopback, run_over, test};
use experiment::failure::Failure;
use host_tests::loopback::{command_of_version, of_version};
use link::frame::{Decoder, Frame, FrameKind};
use link::message::Message;
use link::reply::{NumberedReply, Reply};
use link::{Command, VERSION};
use outerloop_cli::board::{self, Connection, Port};
use outerloop_core::{Event, Mode};
use std::io;

/// A board that gives the same answer to everything.
struct OneAnswer {
    decoder: Decoder,
    reply: Reply,
    out: Vec<u8>,
}

impl Port for OneAnswer {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let out = std::mem::take(&mut self.out);
        bytes[..out.len()].copy_from_slice(&out);
        Ok(out.len())
    }
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        for &byte in bytes {
            if let Some(frame) = self.decoder.push(byte) {
                let answer = NumberedReply {
                    request: frame.sequence,
                    reply: self.reply.clone(),
                };
                self.out.extend(answer.encode(1).unwrap());
            }
        }
        Ok(())
    }
}

/// A board that sends the same bytes over and over, or nothing at all.
struct Stranger(Vec<u8>);

impl Port for Stranger {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        bytes[..self.0.len()].copy_from_slice(&self.0);
        Ok(self.0.len())
    }
    fn write(&mut self, _: &[u8]) -> io::Result<()> {
        Ok(())
    }
}

/// What is said of a board that sends these bytes.
fn said_of(wire: Vec<u8>) -> Failure {
    match run_over(&test(&[]), Connection::new(Stranger(wire), QUICK)) {
        Err(failure) => failure,
        Ok(_) => panic!("accepted"),
    }
}

const EMPTY_REPLY: Frame<'static> = Frame {
    kind: FrameKind::Reply,
    sequence: 1,
    body: &[],
};

#[test]
fn a_board_with_an_older_or_a_newer_link_is_refused_with_both_versions() {
    for version in [VERSION - 1, VERSION + 1, 99] {
        let Failure::Input(said) = said_of(of_version(version, &EMPTY_REPLY)) else {
            panic!("{version} is no matter of the input");
        };
        let both = format!("another version of the link ({version}, this program {VERSION})");
        assert!(said.contains(&both), "{said}");
        assert!(
            said.contains("accepted is firmware of the same release"),
            "{said}"
        );
    }
}

#[test]
fn what_this_program_does_not_know_and_silence_are_told_apart() {
    // A reply of the same version that ends in the middle of what this program knows.
    let reply = Frame {
        body: &[1, 250],
        ..EMPTY_REPLY
    };
    let Failure::Input(said) = said_of(reply.encode().unwrap().to_vec()) else {
        panic!("no matter of the input");
    };
    assert!(
        said.contains("something that this program does not know"),
        "{said}"
    );
    let Failure::Test(said) = said_of(Vec::new()) else {
        panic!("no matter of the test");
    };
    assert!(
        said.contains("the board does not answer")
            || said.contains("nothing that can be read came"),
        "{said}"
    );
}

#[test]
fn firmware_of_another_release_that_speaks_the_same_link_is_refused() {
    let mut other = loopback(&test(&[]));
    let Reply::Identity(mut identity) = other.board.ask(1, Command::Identify) else {
        panic!("no identity");
    };
    identity.version = "0.0.9".try_into().unwrap();
    let answers = OneAnswer {
        decoder: Decoder::default(),
        reply: Reply::Identity(identity),
        out: Vec::new(),
    };
    let refused = board::identify(&mut Connection::new(answers, QUICK));
    let Err(Failure::Input(said)) = refused else {
        panic!("{refused:?}");
    };
    let own = env!("CARGO_PKG_VERSION");
    let versions = format!("firmware is version 0.0.9, this program {own}");
    assert!(said.contains(&versions), "{said}");
}

#[test]
fn a_board_carries_out_nothing_that_a_program_of_another_link_sends() {
    let t = test(&[]);
    let mut board = loopback(&t);
    for version in [VERSION - 1, VERSION + 1] {
        let arm = command_of_version(version, &Command::Event(Event::Arm));
        board.write(&arm).unwrap();
        let mut came = [0; 4096];
        for _ in 0..20 {
            board.read(&mut came).unwrap();
        }
    }
    assert_eq!(board.board.mode(), Mode::Idle);
    let mut connection = Connection::new(board, QUICK);
    let status = board::status(&mut connection).unwrap();
    assert_eq!(status.link.other_version, 2);
    // It still accepts its own version.
    assert!(status.link.good > 0);
}
