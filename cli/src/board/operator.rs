//! The person at the bench: agrees before anything moves on its own, resumes after a hold, and stops by Ctrl-C.

use super::standing::{PistonsAt, Standing};
use crate::terminal::interrupt;
use experiment::failure::Failure;
use std::io::{BufRead, IsTerminal};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

/// Who agrees, between the approach and the start, that the test may begin.
pub struct Operator(Asked);

enum Asked {
    /// Nothing real moves, so nobody is asked.
    Nobody,
    /// A script agreed in advance, and said where the pistons stand before the first arming.
    Script(Option<PistonsAt>, Arc<AtomicBool>),
    /// Lines from the keyboard.
    Person(Arc<Mutex<Receiver<String>>>),
}

/// The only reader of the keyboard, for all tests of this process.
static KEYBOARD: LazyLock<Arc<Mutex<Receiver<String>>>> = LazyLock::new(|| {
    let (typed, keyboard) = channel();
    std::thread::spawn(move || {
        let lines = std::io::stdin().lock().lines();
        for line in lines.map_while(Result::ok) {
            if typed.send(line).is_err() {
                break;
            }
        }
    });
    Arc::new(Mutex::new(keyboard))
});

impl Operator {
    /// A person who presses Enter.
    ///
    /// # Errors
    /// Standard input is no terminal.
    pub fn at_keyboard() -> Result<Self, Failure> {
        if !std::io::stdin().is_terminal() {
            return Err(Failure::input(
                "--port: standard input is no terminal, so that nobody can be asked before the test starts: accepted is a person at the keyboard, or --yes for a script",
            ));
        }
        Ok(Self(Asked::Person(Arc::clone(&KEYBOARD))))
    }

    /// Lines from another source.
    pub fn by(lines: Receiver<String>) -> Self {
        Self(Asked::Person(Arc::new(Mutex::new(lines))))
    }

    /// Nobody is asked: nothing real moves.
    pub fn not_asked() -> Self {
        Self(Asked::Nobody)
    }

    /// Nobody is asked: a script agreed in advance, and said where the pistons stand before the first arming; `used`: one
    /// arming has used that.
    pub fn script(pistons_at: Option<PistonsAt>, used: Arc<AtomicBool>) -> Self {
        Self(Asked::Script(pistons_at, used))
    }

    /// True if somebody can be asked.
    pub fn is_asked(&self) -> bool {
        matches!(self.0, Asked::Person(_))
    }

    /// Asks on standard error; [`agrees`](Self::agrees) gives the answer. What was typed before does not count.
    pub fn ask(&self, question: &str) {
        if let Asked::Person(lines) = &self.0 {
            while line(lines).is_ok() {}
            eprintln!("outerloop: {question}");
        }
    }

    /// Reports that the board's button holds the test, and asks whoever can be asked.
    pub fn ask_to_go_on(&self) {
        match &self.0 {
            Asked::Person(_) => self.ask("the test is held: Enter goes on, Ctrl-C stops"),
            Asked::Nobody | Asked::Script(..) => {
                eprintln!("outerloop: the test is held, and nobody is asked: Ctrl-C stops");
            }
        }
    }

    /// True if the person has pressed Enter alone since the question, or if nobody is asked.
    ///
    /// # Errors
    /// A lost keyboard.
    pub fn agrees(&self) -> Result<bool, Failure> {
        let Asked::Person(lines) = &self.0 else {
            return Ok(true);
        };
        match line(lines) {
            Ok(typed) => Ok(is_enter(&typed)),
            Err(TryRecvError::Empty) => Ok(false),
            Err(TryRecvError::Disconnected) => Err(Failure::test(
                "the keyboard is gone, so that nobody says that it may go on: it was stopped",
            )),
        }
    }

    /// The same before a start: Ctrl-C gives it up, with the sentence `given_up`.
    ///
    /// # Errors
    /// Given up; a lost keyboard.
    pub fn lets_start(&self, given_up: &str) -> Result<bool, Failure> {
        match self.agrees() {
            Ok(false) if interrupt::asked() => Err(Failure::test(given_up)),
            answer => answer,
        }
    }

    /// True if the board may be armed with its pistons as they are: a person answered [`Standing::question`], or a script
    /// stated their position, which is valid for one arming.
    ///
    /// # Errors
    /// The pistons stand somewhere other than stated; a script that has not stated their position, with no second
    /// transducer to check it; a lost keyboard.
    pub fn lets_arm(&self, standing: &Standing) -> Result<bool, Failure> {
        let lines = match &self.0 {
            Asked::Nobody => return Ok(true),
            Asked::Person(lines) => lines,
            Asked::Script(..) if standing.seen_twice => return Ok(true),
            Asked::Script(Some(PistonsAt::NoPiston), _) => return Ok(true),
            Asked::Script(Some(said), used) if !used.swap(true, Ordering::Relaxed) => {
                return standing.compare(said).map(|()| true);
            }
            Asked::Script(..) => {
                return Err(Failure::input(
                    "--yes: nobody is asked where the pistons stand before this arming, and no second transducer is compared (limits.disagree_m): accepted is --piston-at MM, as their scales show, for one arming, or --piston-at none where none hangs on the board; nothing has moved",
                ));
            }
        };
        match line(lines) {
            Err(TryRecvError::Empty) => Ok(false),
            Err(TryRecvError::Disconnected) => Err(Failure::test(
                "the keyboard is gone, so that nobody says that the board may be armed; nothing has moved",
            )),
            Ok(typed) if standing.seen_twice => Ok(is_enter(&typed)),
            Ok(typed) => match typed.parse() {
                Ok(said) => standing.compare(&said).map(|()| true),
                Err(sentence) => {
                    eprintln!("outerloop: {sentence}");
                    Ok(false)
                }
            },
        }
    }
}

/// The next typed line.
fn line(lines: &Mutex<Receiver<String>>) -> Result<String, TryRecvError> {
    lines
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .try_recv()
}

/// True for Enter alone; anything else is rejected with a message.
fn is_enter(typed: &str) -> bool {
    let enter = typed.trim().is_empty();
    if !enter {
        eprintln!(
            "outerloop: `{}` is no answer: accepted are Enter alone, or Ctrl-C",
            typed.trim()
        );
    }
    enter
}
