//! Clients that have connected but are not served yet. The first one to send a message is served first; a silent one
//! blocks nobody.

use super::wire::{FIRST_MESSAGE, waits};
use std::collections::VecDeque;
use std::io::Error;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::time::{Duration, Instant};

/// At most this many wait here; the operating system queues the others.
const SEATS: usize = 64;

/// A client that has connected.
#[derive(Debug)]
pub struct Arrival {
    /// The connection.
    pub stream: TcpStream,
    /// Its address.
    pub client: SocketAddr,
    /// When it was accepted.
    pub at: Instant,
}

impl Arrival {
    /// True if the first message is complete, or the connection has ended.
    fn speaks(&self) -> bool {
        match self.stream.peek(&mut [0; FIRST_MESSAGE]) {
            Ok(count) => count == 0 || count == FIRST_MESSAGE,
            Err(e) => !waits(e.kind()),
        }
    }
}

/// The listener and the waiting clients.
#[derive(Debug)]
pub struct WaitingRoom {
    listener: TcpListener,
    timeout: Duration,
    waiting: VecDeque<Arrival>,
}

impl WaitingRoom {
    /// Accepts clients at `listener`; the first message may take up to `timeout`.
    ///
    /// # Errors
    /// A listener that cannot be made non-blocking.
    pub fn new(listener: TcpListener, timeout: Duration) -> Result<Self, Error> {
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            timeout,
            waiting: VecDeque::new(),
        })
    }

    /// The next client to serve: the first that has sent its message, else one that has been silent too long. `None`:
    /// nobody yet.
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
