//! Who has connected and is not served yet: whoever speaks first is served first, and who never speaks holds nobody up.

use super::wire::{FIRST_MESSAGE, waits};
use std::collections::VecDeque;
use std::io::Error;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::time::{Duration, Instant};

/// So many wait here; the others wait where the system keeps them.
const SEATS: usize = 64;

/// Somebody who has connected.
#[derive(Debug)]
pub struct Arrival {
    /// The connection.
    pub stream: TcpStream,
    /// Whose it is.
    pub client: SocketAddr,
    /// When it was accepted.
    pub at: Instant,
}

impl Arrival {
    /// The first message is here, or the connection has ended.
    fn speaks(&self) -> bool {
        match self.stream.peek(&mut [0; FIRST_MESSAGE]) {
            Ok(count) => count == 0 || count == FIRST_MESSAGE,
            Err(e) => !waits(e.kind()),
        }
    }
}

/// A door and those behind it.
#[derive(Debug)]
pub struct WaitingRoom {
    listener: TcpListener,
    timeout: Duration,
    waiting: VecDeque<Arrival>,
}

impl WaitingRoom {
    /// Lets in who connects at `listener`; the first message may take `timeout`.
    ///
    /// # Errors
    /// A listener that cannot be asked without waiting.
    pub fn new(listener: TcpListener, timeout: Duration) -> Result<Self, Error> {
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            timeout,
            waiting: VecDeque::new(),
        })
    }

    /// The next one to serve: the first who speaks, else one who has been silent for too long. `None`: nobody yet.
    ///
    /// # Errors
    /// The network is lost.
    pub fn next_arrival(&mut self) -> Result<Option<Arrival>, Error> {
        while self.waiting.len() < SEATS {
            match self.listener.accept() {
                Ok((stream, client)) => {
                    stream.set_nonblocking(true)?;
                    let at = Instant::now();
                    self.waiting.push_back(Arrival { stream, client, at });
                }
                Err(e) if waits(e.kind()) => break,
                Err(e) => return Err(e),
            }
        }
        let silent = |a: &Arrival| a.at.elapsed() > self.timeout;
        let speaks = self.waiting.iter().position(Arrival::speaks);
        let place = speaks.or_else(|| self.waiting.iter().position(silent));
        let Some(arrival) = place.and_then(|at| self.waiting.remove(at)) else {
            return Ok(None);
        };
        arrival.stream.set_nonblocking(false)?;
        Ok(Some(arrival))
    }
}
