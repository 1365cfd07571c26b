//! The person at the bench: says go before anything moves on its own, goes on after a hold, and stops by Ctrl-C.

use experiment::failure::Failure;
use std::io::{BufRead, IsTerminal};
use std::sync::mpsc::{Receiver, channel};

/// Who decides, between the approach and the start, that the test may begin.
pub struct Operator {
    /// Lines from the keyboard; none where nobody is asked.
    go: Option<Receiver<()>>,
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
        let (pressed, keyboard) = channel();
        std::thread::spawn(move || {
            let lines = std::io::stdin().lock().lines();
            for _ in lines.map_while(Result::ok) {
                if pressed.send(()).is_err() {
                    break;
                }
            }
        });
        Ok(Self::by(keyboard))
    }

    /// Somebody who says go by a message, from a window for instance.
    pub fn by(go: Receiver<()>) -> Self {
        Self { go: Some(go) }
    }

    /// Nobody is asked: a script has said yes beforehand, or nothing real moves.
    pub fn not_asked() -> Self {
        Self { go: None }
    }

    /// Somebody is there to be asked.
    pub fn is_asked(&self) -> bool {
        self.go.is_some()
    }

    /// Asks, on standard error; the answer is [`agrees`](Self::agrees). What was typed before does not count.
    pub fn ask(&self, question: &str) {
        if let Some(go) = &self.go {
            while go.try_recv().is_ok() {}
            eprintln!("outerloop: {question}");
        }
    }

    /// The person has pressed Enter since the question, or nobody is asked.
    pub fn agrees(&self) -> bool {
        self.go.as_ref().is_none_or(|go| go.try_recv().is_ok())
    }
}
