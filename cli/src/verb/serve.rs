//! `outerloop serve`: the rig as an element of somebody else's model.

use super::rig_arguments::RigArguments;
use crate::answer::{SessionSection, of_served};
use crate::document::Document;
use crate::provenance::WithProvenance;
use crate::scope::Scoped;
use crate::serve::{
    DeclaredElement, Mover, SessionSummary, SessionVerdict, WaitingRoom, serve_client,
    wire::first_message_s,
};
use crate::site::TestSite;
use crate::terminal::interrupt;
use experiment::failure::Failure;
use experiment::files::test::TestFile;
use experiment::files::{look_ahead, output, plain, record_csv};
use experiment::trace::Trace;
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Serve the rig as an element of a finite-element model: OpenSees' genericClient
#[derive(clap::Args, Debug)]
pub struct Serve {
    /// The test file; its table [serve] says how the rig moves
    test: PathBuf,
    /// Address and port for the clients
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1:8090")]
    listen: SocketAddr,
    /// Override a value of the test file, e.g. serve.pace=continuous
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Seed of everything random in the simulated rig
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Serve one client, then end; exit status 1 if its test was not completed
    #[arg(long)]
    once: bool,
    /// Write report.html, record.csv and summary.json there; later clients get folders of their own, DIR-2 and so on
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// One JSON object for each client, on a line of standard output, and nothing else
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    place: RigArguments,
    #[command(flatten)]
    scope: Scoped,
}

/// The files in a client's folder.
const FILES: [&str; 3] = ["report.html", "record.csv", "summary.json"];

/// How often the operator's interrupt is checked.
const LOOK: Duration = Duration::from_millis(20);

impl Serve {
    /// Serves one client after another until the operator stops it.
    ///
    /// # Errors
    /// A test that cannot be served; an address that cannot be bound; a rig that is lost; with `--once`, a client that
    /// did not complete its test.
    pub fn run(&self) -> Result<(), Failure> {
        let out = look_ahead::folder(self.out.as_deref(), &FILES)?;
        let out = out.as_deref();
        let test = TestFile::load_any(&self.test, &self.overrides)?;
        if test.coupled.is_some() {
            super::coupled::refuse(&[("--scope", self.scope.is_wanted())])?;
        }
        let looks = test
            .watch
            .only_looks("by serve, whose targets come from outside");
        looks.map_err(Failure::input)?;
        let element = DeclaredElement::of(&test)?;
        let title = format!("serves {}", self.test.display());
        let rate_hz = test.config.timing.rate_hz;
        let scope = self.scope.open(&title, rate_hz, false)?;
        let keep = out.is_some();
        let mut rig = self.place.serve(&test, self.seed, keep, scope)?;
        let listener = TcpListener::bind(self.listen).map_err(|e| {
            Failure::input(format!(
                "--listen {}: cannot be listened at ({}): accepted is an address of this machine with a free port",
                self.listen,
                plain::reason(&e)
            ))
        })?;
        let cannot = |e: std::io::Error| Failure::test(format!("the network is lost: {e}"));
        let address = listener.local_addr().map_err(cannot)?;
        let timeout = Duration::from_secs_f64(first_message_s(test.serve.timeout_s));
        let mut waiting = WaitingRoom::new(listener, timeout).map_err(cannot)?;
        interrupt::watch_rig();
        eprintln!(
            "outerloop: serves {} at {address}; Ctrl-C ends it",
            self.test.display()
        );
        if !address.ip().is_loopback() {
            eprintln!(
                "outerloop: note: whoever can reach {address} can move the rig: the wire knows no password. Let a firewall admit \
                 the model's machine alone, or listen at 127.0.0.1 and forward the port by ssh."
            );
        }
        // Where the last client's results were written.
        let mut kept_in: Option<PathBuf> = None;
        while !interrupt::asked() {
            let Some(arrival) = waiting.next_arrival().map_err(cannot)? else {
                wait(rig.as_mut())?;
                continue;
            };
            let served = serve_client(arrival, &element, rig.as_mut());
            let trace = rig.take_trace();
            let document = self.document(&test, &served.summary, trace.as_ref())?;
            // A client that never sent a message has no results.
            if let (Some(first), Some(trace), true) = (out, &trace, served.spoke) {
                let folder = match &kept_in {
                    None => first.to_owned(),
                    Some(last) => self.folder_behind(last),
                };
                self.keep(&folder, &document, trace)?;
                kept_in = Some(folder);
            }
            self.tell(&document);
            let (verdict, reason) = (served.summary.verdict, served.summary.reason.clone());
            served.answer_nan_until_gone();
            let last =
                self.once || matches!(verdict, SessionVerdict::RigLost | SessionVerdict::Stopped);
            if last {
                return match verdict {
                    SessionVerdict::Completed => Ok(()),
                    _ => Err(Failure::test(reason.unwrap_or_default())),
                };
            }
        }
        Ok(())
    }

    /// The folder for the client after the one with `last`.
    fn folder_behind(&self, last: &Path) -> PathBuf {
        let folder = look_ahead::folder_behind(self.out.as_deref().unwrap_or(last), last);
        eprintln!(
            "outerloop: note: what this client left is in {}",
            folder.display()
        );
        folder
    }

    fn document(
        &self,
        test: &TestFile,
        summary: &SessionSummary,
        trace: Option<&Trace>,
    ) -> Result<Document, Failure> {
        let document = of_served(&SessionSection {
            test,
            summary,
            trace,
        });
        document.with_figures(FILES[2], &WithProvenance::seeded(summary, self.seed))
    }

    /// Writes a client's results.
    fn keep(&self, folder: &Path, document: &Document, trace: &Trace) -> Result<(), Failure> {
        let mut files = document.files();
        files.push((FILES[1], record_csv::to_csv(trace).into_bytes()));
        output::write_all(folder, &files)
    }

    /// Prints the result of a client; its figures are one line.
    fn tell(&self, document: &Document) {
        if self.json {
            answer!("{}", document.json_line());
        } else {
            println!("{}", document.terminal());
        }
    }
}

/// Services the rig while nobody is served, and carries out the requests of observers.
fn wait(rig: &mut dyn Mover) -> Result<(), Failure> {
    let began = std::time::Instant::now();
    rig.meanwhile().map_err(Failure::test)?;
    if !rig.needs_care() {
        std::thread::sleep(LOOK.saturating_sub(began.elapsed()));
    }
    Ok(())
}
