//! `outerloop serve` and a client that behaves as OpenSees' genericClient.

use crate::common::{command, started};
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, ChildStdout};
use std::time::Duration;

pub const STIFFNESS: f64 = 158e3;
/// Numbers of a message.
pub const LENGTH: usize = 256;

/// `outerloop serve`, ended with the test.
pub struct Server {
    pub child: Child,
    out: BufReader<ChildStdout>,
    pub address: String,
}

impl Server {
    pub fn start(arguments: &[&str]) -> Self {
        Self::of("examples/opensees.toml", arguments)
    }

    /// With another test file.
    pub fn of(test: &str, arguments: &[&str]) -> Self {
        // A board that is built first prints other lines before.
        let mut serve = command(&["serve", test, "--json"]);
        serve.args(["--listen", "127.0.0.1:0"]).args(arguments);
        let (mut child, mut said, line) = started(serve, "outerloop: serves");
        let address = line.split(" at ").nth(1).expect(&line);
        let address = address.split(';').next().unwrap().to_owned();
        // Its further output must not fill its pipe.
        std::thread::spawn(move || std::io::copy(&mut said, &mut std::io::sink()));
        let out = BufReader::new(child.stdout.take().unwrap());
        Self {
            child,
            out,
            address,
        }
    }

    pub fn client(&self) -> Client {
        self.client_of(1)
    }

    /// With an element of this many degrees of freedom.
    pub fn client_of(&self, n: i32) -> Client {
        let header = [n, n, n, 0, 1, 0, 0, 0, n, 0, LENGTH as i32];
        Client::connect(&self.address, &header)
    }

    /// The JSON line for a client that has gone.
    pub fn account(&mut self) -> Value {
        let mut line = String::new();
        self.out.read_line(&mut line).unwrap();
        serde_json::from_str(&line).expect("one JSON object a line")
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Behaves as OpenSees' genericClient.
pub struct Client(pub TcpStream);

impl Client {
    pub fn connect(address: &str, header: &[i32]) -> Self {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.set_nodelay(true).unwrap();
        // For a reply that does not come: a slow machine needs half a minute for the longest move of an emulated board.
        let timeout = Some(Duration::from_secs(180));
        stream.set_read_timeout(timeout).unwrap();
        let bytes: Vec<u8> = header.iter().flat_map(|i| i.to_le_bytes()).collect();
        stream.write_all(&bytes).unwrap();
        Self(stream)
    }

    pub fn say(&mut self, numbers: &[f64]) {
        let mut message = vec![0.0; LENGTH];
        message[..numbers.len()].copy_from_slice(numbers);
        let bytes: Vec<u8> = message.iter().flat_map(|x| x.to_le_bytes()).collect();
        // A closed connection is noticed at the next read.
        let _ = self.0.write_all(&bytes);
    }

    pub fn receive(&mut self) -> Option<f64> {
        self.receive_all().map(|[first, ..]| first)
    }

    /// All numbers of a reply.
    pub fn receive_all(&mut self) -> Option<[f64; LENGTH]> {
        let mut bytes = [0; 8 * LENGTH];
        self.0.read_exact(&mut bytes).ok()?;
        let (numbers, _) = bytes.as_chunks();
        Some(std::array::from_fn(|i| f64::from_le_bytes(numbers[i])))
    }

    pub fn ask(&mut self, action: f64) -> Option<f64> {
        self.say(&[action]);
        self.receive()
    }

    /// One step: trial, force, commit.
    pub fn step(&mut self, displacement: f64, time_s: f64) -> Option<f64> {
        self.step_all([displacement], time_s).map(|[force]| force)
    }

    /// The same with several degrees of freedom.
    pub fn step_all<const N: usize>(&mut self, to_m: [f64; N], time_s: f64) -> Option<[f64; N]> {
        let still = [0.0; N];
        self.say(&[&[3.0], &to_m[..], &still, &still, &[time_s]].concat());
        self.say(&[10.0]);
        let answer = self.receive_all()?;
        self.say(&[5.0]);
        Some(std::array::from_fn(|j| answer[j]))
    }
}

/// The displacements of a mass on the specimen under a ground motion, by explicit Newmark, with the restoring force
/// `force`.
pub fn integrate(steps: usize, mut force: impl FnMut(f64, f64) -> f64) -> Vec<f64> {
    let (m, dt, c) = (1000.0, 0.01, 500.0);
    let (mut u, mut v, mut a, mut path) = (0.0_f64, 0.0, 0.0, Vec::new());
    for i in 0..steps {
        let t = i as f64 * dt;
        u += dt * v + 0.5 * dt * dt * a;
        let half = v + 0.5 * dt * a;
        let ground = 3.0 * (11.0 * t).sin() * (0.7 * t).sin();
        a = (-m * ground - force(u, t) - c * half) / m;
        v = half + 0.5 * dt * a;
        path.push(u);
    }
    path
}
