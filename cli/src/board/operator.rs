//! The person at the bench: says go before anything moves on its own, goes on after a hold, and stops by Ctrl-C.

use super::standing::{PistonsAt, Standing};
use experiment::failure::Failure;
use std::io::{BufRead, IsTerminal};
use std::sync::mpsc::{Receiver, channel};

/// Who decides, between the approach and the start, that the test may begin.
pub struct Operator(Asked);

enum Asked {
    /// Nothing real moves.
    Nobody,
    /// A script has said yes beforehand, and where the pistons stand.
    Script(Option<PistonsAt>),
    /// Lines from the keyboard.
    Person(Receiver<String>),
}

impl Operator {
    /// A person, who presses Enter.
    ///
    /// # Errors
    /// Standard input is no terminal.
    pub fn at_keyboard() -> Result<Self, Failure> {
        if !std::io::stdin().is_terminal() {
            return Err(Failure::input(
                "--port: standard input is no terminal, so that nobody can be asked before the test starts: accepted is a person at the keyboard, or --yes for a script",
            ));
        }
        let (typed, keyboard) = channel();
        std::thread::spawn(move || {
            let lines = std::io::stdin().lock().lines();
            for line in lines.map_while(Result::ok) {
                if typed.send(line).is_err() {
                    break;
                }
            }
        });
        Ok(Self::by(keyboard))
    }

    /// Somebody else's lines.
    pub fn by(lines: Receiver<String>) -> Self {
        Self(Asked::Person(lines))
    }

    /// Nobody is asked: nothing real moves.
    pub fn not_asked() -> Self {
        Self(Asked::Nobody)
    }

    /// Nobody is asked: a script has said yes beforehand, and where the pistons stand.
    pub fn script(pistons_at: Option<PistonsAt>) -> Self {
        Self(Asked::Script(pistons_at))
    }

    /// Somebody is there to be asked.
    pub fn is_asked(&self) -> bool {
        matches!(self.0, Asked::Person(_))
    }

    /// Asks, on standard error; the answer is [`agrees`](Self::agrees). What was typed before does not count.
    pub fn ask(&self, question: &str) {
        if let Asked::Person(lines) = &self.0 {
            while lines.try_recv().is_ok() {}
            eprintln!("outerloop: {question}");
        }
    }

    /// The person has pressed Enter since the question, or nobody is asked.
    pub fn agrees(&self) -> bool {
        match &self.0 {
            Asked::Person(lines) => lines.try_recv().is_ok(),
            Asked::Nobody | Asked::Script(_) => true,
        }
    }

    /// Whether the board may be armed with its pistons as they are: by a person who was asked [`Standing::question`], or by what a
    /// script has said.
    ///
    /// # Errors
    /// The pistons stand somewhere else than was said; a script that has not said where, and nobody else sees it.
    pub fn lets_arm(&self, standing: &Standing) -> Result<bool, Failure> {
        match &self.0 {
            Asked::Nobody => Ok(true),
            Asked::Script(Some(said)) => standing.compare(said).map(|()| true),
            Asked::Script(None) if standing.seen_twice => Ok(true),
            Asked::Script(None) => Err(Failure::input(
                "--yes: nobody is asked where the pistons stand, and no second transducer is compared (limits.disagree_m): accepted is --piston-at MM, as their scales show, or --piston-at none where none hangs on the board; nothing has moved",
            )),
            Asked::Person(lines) => {
                let Ok(line) = lines.try_recv() else {
                    return Ok(false);
                };
                if standing.seen_twice {
                    return Ok(true);
                }
                match line.parse() {
                    Ok(said) => standing.compare(&said).map(|()| true),
                    Err(sentence) => {
                        eprintln!("outerloop: {sentence}");
                        Ok(false)
                    }
                }
            }
        }
    }
}
