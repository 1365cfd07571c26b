//! `outerloop board desk`: everything that a bare board with four wires can show, on one page.

use crate::answer::of_desk;
use crate::board::desk::incident::{self, INCIDENTS, Incident};
use crate::board::desk::{self, DeskRow, RowVerdict};
use crate::board::emulated::{Emulated, EmulatedRig};
use crate::board::{BoardConnection, Connection, Image, Port, Timeouts};
use crate::board::{calibrate, identify, status};
use crate::provenance::WithProvenance;
use crate::site::{RigKind, TestSite};
use crate::terminal::interrupt;
use crate::verb::rig_arguments::RigArguments;
use crate::verb::{MethodName, hand_over, no_files};
use clap::Args;
use experiment::failure::Failure;
use experiment::files::look_ahead;
use link::reply::Identity;
use outerloop_core::Method;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use std::process::Command;

/// Test a bare board with four wires (docs/desk.md): period, methods, a whole test, saves, crashes; write a page
#[derive(Args, Debug)]
#[command(group(clap::ArgGroup::new("place").args(["port", "emulated"]).required(true)))]
pub(super) struct Desk {
    #[command(flatten)]
    place: RigArguments,
    /// The image: nucleo_f429zi (the chip's own converters) or nucleo_f429zi_16 (external converters); left out: any of them on
    /// a board, nucleo_f429zi with --emulated
    #[arg(long, value_name = "NAME", value_parser = image)]
    image: Option<Image>,
    /// How long the board idles at each rate, s
    #[arg(long, value_name = "S", default_value_t = 5.0, value_parser = seconds)]
    seconds: f64,
    /// Methods, each with a test of its own, separated by commas; left out: all, and `paper` joined to each predictor
    #[arg(long, value_delimiter = ',', value_name = "A,B,...", value_parser = MethodName, hide_possible_values = true)]
    methods: Vec<String>,
    /// Length, s, of the whole closed-loop test
    #[arg(long, value_name = "S", default_value_t = 8.0, value_parser = seconds)]
    duration: f64,
    /// Program that operates a debug probe; called with `drill N` or `reset`
    #[arg(long, value_name = "PROGRAM", conflicts_with = "emulated")]
    probe: Option<PathBuf>,
    /// A line for the page, e.g. the board's number and the hash of the flashed image; may be given several times
    #[arg(long, value_name = "TEXT")]
    note: Vec<String>,
    /// Folder for the page (report.html) and its figures (desk.json)
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// The files written.
const FILES: [&str; 2] = ["report.html", "desk.json"];

fn seconds(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "accepted are seconds")?;
    let accepted = (0.1..=86_400.0).contains(&value);
    accepted
        .then_some(value)
        .ok_or("accepted are 0.1 to 86400 s".into())
}

/// An image whose board four wires turn into a rig, by its name.
fn image(name: &str) -> Result<Image, String> {
    let images = [Image::Internal, Image::External];
    let named = images.into_iter().find(|image| image.name() == name);
    named.ok_or_else(|| {
        let accepted = images.map(Image::name).join(", ");
        format!("`{name}` is unknown: accepted are {accepted}")
    })
}

/// The contents of desk.json.
#[derive(Serialize, JsonSchema)]
pub struct DeskAnswer<'a> {
    board: &'a Identity,
    emulated: bool,
    notes: &'a [String],
    rows: &'a [DeskRow],
}

impl Desk {
    /// Fills the page row by row.
    ///
    /// # Errors
    /// A board that is silent, has another image or is already calibrated; a row that fails.
    pub(super) fn run(&self) -> Result<(), Failure> {
        let out = look_ahead::folder(Some(&self.out), &FILES)?;
        let out = out.unwrap_or_else(|| self.out.clone());
        let methods = self.methods()?;
        interrupt::watch();
        let mut board = self.connect(None)?;
        let identity = identify(&mut board)?;
        self.refuse_another_image(&identity)?;
        self.refuse_what_is_no_desk(&mut board)?;
        let rows = self.rows(board, &identity, &methods)?;
        let found = DeskAnswer {
            board: &identity,
            emulated: self.is_emulated(),
            notes: &self.note,
            rows: &rows,
        };
        hand_over((Some(&out), false), no_files, |_| {
            of_desk(&identity, self.is_emulated(), &self.note, &rows)
                .with_figures(FILES[1], &WithProvenance::of(&found))
        })?;
        let bad = rows.iter().filter(|row| row.verdict == RowVerdict::Bad);
        match bad.clone().next() {
            None => Ok(()),
            Some(first) => Err(Failure::test(format!(
                "{} of {} rows are not as they have to be, the first: {}: {}",
                bad.count(),
                rows.len(),
                first.what,
                first.found
            ))),
        }
    }

    fn is_emulated(&self) -> bool {
        self.place.kind() == RigKind::Emulated
    }

    fn connect(&self, incident: Option<Incident>) -> Result<BoardConnection, Failure> {
        let port: Box<dyn Port> = match self.place.serial()? {
            Some(port) => port,
            None => {
                let image = self.image.unwrap_or_default();
                Box::new(Emulated::start(&EmulatedRig::on_desk(image, incident)?)?)
            }
        };
        Ok(Connection::new(port, Timeouts::BOARD))
    }

    /// The flashed board and the one that responds may differ.
    fn refuse_another_image(&self, own: &Identity) -> Result<(), Failure> {
        if let Some(image) = self.image.filter(|image| image.codes() != own.codes) {
            return Err(Failure::input(format!(
                "board desk: --image {}: the board is a {}, which has other converters: accepted is a board with this image",
                image.name(),
                own.board
            )));
        }
        Ok(())
    }

    /// A calibrated board may have a rig; and a person knows what is connected.
    fn refuse_what_is_no_desk(&self, board: &mut BoardConnection) -> Result<(), Failure> {
        if status(board)?.calibrated && !look_ahead::is_forced() {
            return Err(Failure::input(
                "board desk: somebody has calibrated this board, so that a rig may hang on it: accepted is a bare board, or \
                 --force where nothing but the four wires is connected",
            ));
        }
        let person = self.place.operator()?;
        person.ask(
            "the output will move: Enter, if nothing but the four wires of docs/desk.md is connected to the board; Ctrl-C \
             gives it up",
        );
        while !person.lets_start("the desk was given up before anything moved")? {
            board.listen()?;
            board.forget_steps();
        }
        Ok(())
    }

    fn rows(
        &self,
        mut board: BoardConnection,
        own: &Identity,
        methods: &[Method],
    ) -> Result<Vec<DeskRow>, Failure> {
        let mut rows = vec![
            // The slower rate last: the tests after it run at that rate, too.
            desk::idle(&mut board, desk::fastest_hz(own), self.seconds),
            desk::idle(&mut board, 2000, self.seconds),
        ];
        rows.push(desk::saves(&mut board));
        calibrate(&mut board, desk::calibration(&own.codes))?;
        let (board, tested) = desk::each_method(board, methods);
        rows.extend(tested);
        let (mut board, whole) = desk::whole_test(board, self.duration);
        rows.push(whole);
        rows.push(desk::forget(&mut board));
        drop(board);
        rows.extend(self.incidents()?);
        rows.push(DeskRow::not_done(
            "levels of the pins in reset, the trigger lines, the converters' accuracy",
            "not done: only a scope on the metal shows them, see docs/hil.md",
        ));
        Ok(rows)
    }

    fn methods(&self) -> Result<Vec<Method>, Failure> {
        if self.methods.is_empty() {
            return Ok(desk::methods());
        }
        let names = self.methods.iter();
        names.map(|name| experiment::method(name)).collect()
    }

    /// Each incident on a new emulated board, or one after the other on the board at the port.
    fn incidents(&self) -> Result<Vec<DeskRow>, Failure> {
        let mut rows = Vec::new();
        for expected in INCIDENTS {
            if interrupt::asked() {
                break;
            }
            let (incident, name, ..) = expected;
            rows.push(match (&self.probe, self.is_emulated()) {
                (None, false) => DeskRow::not_done(
                    &format!("in a running test: {name}"),
                    "not done: it needs a debug probe (--probe, scripts/desk has one)",
                ),
                (probe, _) => {
                    let mut board = self.connect(Some(incident))?;
                    incident::row(&mut board, expected, |incident, board| match probe {
                        // The emulated board's laboratory applies it by itself.
                        None => Ok(()),
                        Some(program) => by_probe(program, incident, board),
                    })
                }
            });
        }
        Ok(rows)
    }
}

/// Listens to the board while the probe runs: a board that hears nothing from the PC for half a second gives it up.
fn by_probe(
    program: &std::path::Path,
    incident: Incident,
    board: &mut BoardConnection,
) -> Result<(), Failure> {
    let arguments = match incident {
        Incident::Drill(number) => vec!["drill".into(), number.to_string()],
        Incident::Reset => vec!["reset".into()],
    };
    let called = format!("{} {}", program.display(), arguments.join(" "));
    let cannot = |why: String| Failure::test(format!("--probe: `{called}`: {why}"));
    let started = Command::new(program).args(&arguments).spawn();
    let mut running = started.map_err(|e| cannot(e.to_string()))?;
    let ended = loop {
        if let Some(ended) = running.try_wait().map_err(|e| cannot(e.to_string()))? {
            break ended;
        }
        board.listen()?;
    };
    ended
        .success()
        .then_some(())
        .ok_or_else(|| cannot(ended.to_string()))
}
