//! Bytes to and from a board.

use experiment::failure::Failure;
use std::io;
use std::sync::OnceLock;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// How long a read waits for the first byte.
const WAIT: Duration = Duration::from_millis(5);

/// A stream of bytes with a board at its other end.
pub trait Port {
    /// The bytes received, at least one; 0 if none came within a few milliseconds.
    ///
    /// # Errors
    /// The other end is gone.
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize>;

    /// Sends all of `bytes`.
    ///
    /// # Errors
    /// The other end is gone.
    fn write(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// The time at the other end, from an arbitrary origin: the wall clock, or an emulated board's own time.
    fn now(&self) -> Duration {
        static BEGAN: OnceLock<(Instant, Duration)> = OnceLock::new();
        let (began, at) = BEGAN.get_or_init(|| {
            let at = SystemTime::now().duration_since(UNIX_EPOCH);
            (Instant::now(), at.unwrap_or_default())
        });
        *at + began.elapsed()
    }
}

impl<P: Port + ?Sized> Port for Box<P> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        (**self).read(bytes)
    }
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        (**self).write(bytes)
    }
    fn now(&self) -> Duration {
        (**self).now()
    }
}

/// A serial port.
pub struct Serial(Box<dyn serialport::SerialPort>);

impl Serial {
    /// Opens `device` at the link's speed.
    ///
    /// # Errors
    /// It cannot be opened.
    pub fn open(device: &str) -> Result<Self, Failure> {
        serialport::new(device, link::BAUD)
            .timeout(WAIT)
            .open()
            .map(Self)
            .map_err(|e| {
                Failure::input(format!(
                    "--port {device}: cannot be opened ({e}): accepted is the serial port of a board, e.g. /dev/ttyACM0"
                ))
            })
    }
}

impl Port for Serial {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match io::Read::read(&mut self.0, bytes) {
            Err(e) if e.kind() == io::ErrorKind::TimedOut => Ok(0),
            Err(e) if e.kind() == io::ErrorKind::Interrupted => Ok(0),
            // A port that is ready but has no bytes was unplugged.
            Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
            other => other,
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        io::Write::write_all(&mut self.0, bytes)
    }
}
