//! The page and its WebSocket: bound to one address, behind a random token, only for pages of its own origin.

use super::decimate::{Band, CHANNELS, PendingPoints, StepColumns};
use experiment::failure::Failure;
use experiment::files::plain;
use outerloop_core::{Event, Mode};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tungstenite::http::StatusCode;
use tungstenite::{Message, WebSocket};

const PAGE: &str = include_str!("page.html");
/// Time between two messages to a browser.
const PERIOD: Duration = Duration::from_millis(20);
/// How long a browser may take to send its request, or to read a message, before it is dropped.
const TIMEOUT: Duration = Duration::from_secs(2);
/// How long a check of the buttons takes if none was pressed.
const SHORT_WAIT: Duration = Duration::from_millis(1);
/// The longest request, bytes.
const HEAD: usize = 8192;
/// Messages that a late browser receives first, at least: some 40 s.
const HISTORY: usize = 2000;

/// What the test and the browsers share.
pub struct Shared {
    address: SocketAddr,
    token: String,
    hello: String,
    state: Mutex<State>,
    /// Signals a new message.
    news: Condvar,
}

struct State {
    mode: Mode,
    step: u32,
    waiting: PendingPoints,
    /// The latest text of the rig watch; empty if there is none yet.
    watch: String,
    /// The latest messages.
    sent: Vec<Arc<str>>,
    first: usize,
    reported_mode: Option<Mode>,
    requested: Option<Event>,
    ended: bool,
}

/// Listens at `address`; everything else happens on separate threads.
pub fn open(address: SocketAddr, title: &str, rate_hz: f64) -> Result<Arc<Shared>, Failure> {
    let cannot = |e: std::io::Error| {
        Failure::input(format!(
            "--scope {address}: cannot be listened at ({}): accepted is an address of this machine with a free port",
            plain::reason(&e)
        ))
    };
    let listener = TcpListener::bind(address).map_err(cannot)?;
    let address = listener.local_addr().map_err(cannot)?;
    let token = token().map_err(|e| Failure::test(format!("--scope: no random token: {e}")))?;
    let channels: Vec<_> = CHANNELS
        .iter()
        .map(|(name, unit, _)| [name, unit])
        .collect();
    let hello = serde_json::json!({ "title": title, "rate_hz": rate_hz, "channels": channels });
    let shared = Arc::new(Shared {
        address,
        token,
        hello: hello.to_string(),
        state: Mutex::new(State {
            mode: Mode::Idle,
            step: 0,
            waiting: PendingPoints::new(),
            watch: String::new(),
            sent: Vec::new(),
            first: 0,
            reported_mode: None,
            requested: None,
            ended: false,
        }),
        news: Condvar::new(),
    });
    let writer = shared.clone();
    std::thread::spawn(move || {
        while !writer.state().ended {
            std::thread::sleep(PERIOD);
            writer.write();
        }
    });
    let accepting = shared.clone();
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let shared = accepting.clone();
            // A browser that misbehaves ends its own thread.
            std::thread::spawn(move || shared.answer(stream));
        }
    });
    Ok(shared)
}

/// 128 random bits.
fn token() -> Result<String, getrandom::Error> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes)?;
    Ok(bytes.iter().map(|b| format!("{b:02x}")).collect())
}

/// The event of a button, if it is allowed in this mode.
fn event_of(button: &str, mode: Mode) -> Option<Event> {
    let event = match button {
        "hold" => Event::Hold,
        "stop" => Event::Stop,
        "resume" => Event::Start,
        "clear" => Event::Clear,
        _ => return None,
    };
    // In Armed a start begins a test: a page must not do that.
    let meant = !(event == Event::Start && mode != Mode::Holding);
    (meant && mode.after(event).is_ok()).then_some(event)
}

impl Shared {
    /// The address for the browser.
    pub fn url(&self) -> String {
        format!("http://{}/{}/", self.address, self.token)
    }

    /// Takes a step.
    pub fn take(&self, mode: Mode, band: &Band, columns: &StepColumns) {
        let mut state = self.state();
        (state.mode, state.step) = (mode, columns.step);
        state.waiting.take(columns, band);
    }

    /// Takes the latest text of the rig watch.
    pub fn take_watch(&self, said: &str) {
        said.clone_into(&mut self.state().watch);
    }

    /// The last button pressed, given once.
    pub fn requested_event(&self) -> Option<Event> {
        self.state().requested.take()
    }

    /// The test is over: the last message says so, and every browser has a moment to receive it.
    pub fn end(&self) {
        self.state().ended = true;
        self.write();
        std::thread::sleep(3 * PERIOD);
    }

    // A thread that panicked leaves nothing half done that would affect the picture.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends the next message to all browsers.
    fn write(&self) {
        let mut state = self.state();
        let points = state.waiting.drain();
        if points.is_empty() && state.reported_mode == Some(state.mode) && !state.ended {
            return;
        }
        state.reported_mode = Some(state.mode);
        let (mode, ended) = (state.mode, state.ended);
        let buttons = ["hold", "stop", "resume", "clear"];
        let allowed: Vec<_> = buttons
            .into_iter()
            .filter(|b| !ended && event_of(b, mode).is_some())
            .collect();
        let mut text = format!(
            "{{\"mode\":\"{}\",\"ended\":{ended},\"allowed\":{allowed:?},\"step\":{},\"wall_ms\":{},\"watch\":{},\"points\":[",
            mode.name(),
            state.step,
            wall_ms(),
            serde_json::Value::from(state.watch.as_str()),
        );
        for (i, point) in points.iter().enumerate() {
            if i > 0 {
                text.push(',');
            }
            point.write(&mut text);
        }
        text.push_str("]}");
        if state.sent.len() == 2 * HISTORY {
            state.sent.drain(..HISTORY);
            state.first += HISTORY;
        }
        state.sent.push(text.into());
        self.news.notify_all();
    }

    /// One connection: the page, or its WebSocket.
    fn answer(&self, stream: TcpStream) {
        let _ = stream.set_nodelay(true);
        let _ = stream.set_write_timeout(Some(TIMEOUT));
        let _ = stream.set_read_timeout(Some(TIMEOUT));
        let Some(head) = peek_head(&stream) else {
            return;
        };
        if head.to_ascii_lowercase().contains("upgrade: websocket") {
            #[expect(clippy::result_large_err, reason = "the type is the library's")]
            let check =
                |request: &Request, response: Response| self.check_origin(request, response);
            if let Ok(socket) = tungstenite::accept_hdr(stream, check) {
                self.talk(socket);
            }
        } else {
            self.page(stream, &head);
        }
    }

    /// Accepts a WebSocket only from our own page.
    #[expect(clippy::result_large_err, reason = "the type is the library's")]
    fn check_origin(
        &self,
        request: &Request,
        response: Response,
    ) -> Result<Response, ErrorResponse> {
        let header = |name: &str| request.headers().get(name).and_then(|v| v.to_str().ok());
        let host = header("host").unwrap_or_default();
        let own = header("origin") == Some(&format!("http://{host}")) && self.is_own_address(host);
        if own && request.uri().path() == format!("/{}/ws", self.token) {
            return Ok(response);
        }
        let mut refusal = ErrorResponse::new(Some("refused\n".into()));
        *refusal.status_mut() = StatusCode::FORBIDDEN;
        Err(refusal)
    }

    /// True for a name under which a browser may know this address; any other name comes from a foreign page.
    fn is_own_address(&self, host: &str) -> bool {
        let (ip, port) = (self.address.ip(), self.address.port());
        if ip.is_unspecified() {
            return true;
        }
        host == self.address.to_string()
            || (ip.is_loopback() && host == format!("localhost:{port}"))
    }

    fn page(&self, mut stream: TcpStream, head: &str) {
        let mut words = head.split_whitespace();
        let (method, path) = (words.next(), words.next());
        let host = head.lines().find_map(|line| {
            let (name, value) = line.split_once(':')?;
            name.eq_ignore_ascii_case("host").then(|| value.trim())
        });
        let own = host.is_some_and(|host| self.is_own_address(host));
        let good = method == Some("GET") && own && path == Some(&format!("/{}/", self.token));
        let (status, kind, body) = if good {
            ("200 OK", "text/html; charset=utf-8", PAGE)
        } else {
            ("403 Forbidden", "text/plain", "refused\n")
        };
        // The peeked bytes are read, so that closing does not cut off the response.
        let _ = stream.read(&mut vec![0; HEAD]);
        let _ = write!(
            stream,
            "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
             Referrer-Policy: no-referrer\r\nX-Frame-Options: DENY\r\nX-Content-Type-Options: nosniff\r\n\
             Content-Security-Policy: default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
             connect-src ws://{}; frame-ancestors 'none'\r\nConnection: close\r\n\r\n{body}",
            body.len(),
            host.filter(|_| good).unwrap_or("localhost"),
        );
    }

    /// Sends all messages and receives buttons, until either end closes.
    fn talk(&self, mut socket: WebSocket<TcpStream>) {
        let _ = socket.get_ref().set_read_timeout(Some(SHORT_WAIT));
        let mut next = self.state().first;
        if socket.send(Message::text(self.hello.as_str())).is_err() {
            return;
        }
        loop {
            let (messages, ended) = {
                // A message is sent as soon as it exists; the buttons are checked in between.
                let nothing_new =
                    |s: &mut State| !s.ended && next.max(s.first) == s.first + s.sent.len();
                let (state, _) = self
                    .news
                    .wait_timeout_while(self.state(), PERIOD, nothing_new)
                    .unwrap_or_else(PoisonError::into_inner);
                next = next.max(state.first);
                (state.sent[next - state.first..].to_vec(), state.ended)
            };
            next += messages.len();
            for message in messages {
                if socket.send(Message::text(&*message)).is_err() {
                    return;
                }
            }
            if ended {
                let _ = socket.close(None);
                return;
            }
            match socket.read() {
                Ok(Message::Text(button)) => {
                    let mut state = self.state();
                    state.requested = event_of(&button, state.mode).or(state.requested);
                }
                Ok(Message::Close(_)) => return,
                Ok(_) => {}
                Err(tungstenite::Error::Io(e)) if waits(e.kind()) => {}
                Err(_) => return,
            }
        }
    }
}

fn waits(kind: std::io::ErrorKind) -> bool {
    matches!(
        kind,
        std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut
    )
}

fn wall_ms() -> u128 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.map_or(0, |t| t.as_millis())
}

/// The header of a request, left in the stream.
fn peek_head(stream: &TcpStream) -> Option<String> {
    let (mut bytes, began) = ([0; HEAD], Instant::now());
    while began.elapsed() < TIMEOUT {
        let count = stream.peek(&mut bytes).ok()?;
        if count == 0 {
            return None;
        }
        let head = String::from_utf8_lossy(&bytes[..count]);
        if head.contains("\r\n\r\n") {
            return Some(head.into_owned());
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    None
}
