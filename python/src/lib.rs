//! `outerloop._native`: the PC tool's library in Python's terms. What Python users see is `outerloop/__init__.py`.
//!
//! Nothing is decided here: files, tests and diagnoses are those of the program `outerloop`, and its refusals are raised
//! as `Refused` with their sentence. Python's other threads run during a test.

use diagnosis::Recording;
use experiment::Experiment;
use experiment::actuator_doubt::doubt;
use experiment::failure::Failure;
use experiment::files::any_table;
use experiment::files::ground_motion::{ColumnChoice, GroundMotionFile};
use experiment::files::measured::{self, FilePart, RecordFiles};
use experiment::files::near_fault::near_fault;
use experiment::files::recording;
use experiment::files::test::TestFile;
use experiment::files::{channels, model};
use experiment::judged::JudgedRun;
use experiment::trace::Trace;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

pyo3::create_exception!(
    outerloop,
    Refused,
    PyValueError,
    "What was given cannot be used: what, where, which value, and what would be accepted."
);

fn refused(failure: Failure) -> PyErr {
    Refused::new_err(failure.to_string())
}

/// A ground motion: a file, or times, s, and accelerations, g.
#[derive(FromPyObject)]
enum Motion<'py> {
    Points(PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>),
    File(PathBuf),
}

impl Motion<'_> {
    fn read(&self) -> PyResult<GroundMotionFile> {
        match self {
            Self::File(path) => GroundMotionFile::load(path, ColumnChoice::default()),
            Self::Points(time_s, acc_g) => {
                let (time_s, acc_g) = (time_s.as_array().to_vec(), acc_g.as_array().to_vec());
                GroundMotionFile::of_columns("record", time_s, acc_g)
            }
        }
        .map_err(refused)
    }
}

/// Recorded data: a file with or without a span, or columns by their names.
#[derive(FromPyObject)]
enum Recorded<'py> {
    FilePart(String),
    Columns(Vec<(String, PyReadonlyArray1<'py, f64>)>),
}

/// Recordings, and whether the forces of all of them are in newtons.
fn recordings(all: &[Recorded<'_>]) -> PyResult<(Vec<Recording>, bool)> {
    let mut library = RecordFiles::default();
    let (mut parts, mut has_unit) = (Vec::new(), true);
    for each in all {
        parts.extend(match each {
            Recorded::FilePart(text) => {
                let part: FilePart = text.parse().map_err(|e: String| Refused::new_err(e))?;
                library.parts(&[part]).map_err(refused)?
            }
            Recorded::Columns(columns) => {
                let (names, values): (Vec<String>, Vec<Vec<f64>>) = columns
                    .iter()
                    .map(|(name, values)| (name.clone(), values.as_array().to_vec()))
                    .unzip();
                let whole = recording::SiRecording::of_columns("the recording", &names, values)
                    .map_err(refused)?;
                has_unit &= whole.force().is_none() || whole.force_has_unit();
                measured::parts_of(&whole, None).map_err(refused)?
            }
        });
    }
    Ok((parts, has_unit && library.force_has_unit()))
}

/// A test on a ground motion.
fn experiment(
    test: &TestFile,
    record: Option<&Motion<'_>>,
    duration: Option<f64>,
) -> PyResult<Experiment> {
    let shaking = match (record, &test.excitation.record) {
        (Some(record), _) => record.read()?,
        (None, Some(path)) => {
            GroundMotionFile::load(path, ColumnChoice::default()).map_err(refused)?
        }
        (None, None) => near_fault(),
    };
    Experiment::new(test.clone(), &shaking, duration).map_err(refused)
}

/// One closed-loop test: its figures, and every step of it where `trace` asks for them.
#[pyfunction]
#[pyo3(signature = (test, overrides, record, compensation, seed, duration, trace))]
#[expect(clippy::too_many_arguments, reason = "Python names them")]
fn run<'py>(
    py: Python<'py>,
    test: PathBuf,
    overrides: Vec<String>,
    record: Option<Motion<'py>>,
    compensation: Option<&str>,
    seed: u64,
    duration: Option<f64>,
    trace: bool,
) -> PyResult<(Bound<'py, PyAny>, Option<Bound<'py, PyDict>>)> {
    let test = TestFile::load(&test, &overrides).map_err(refused)?;
    let method = match compensation {
        Some(name) => ::experiment::method(name).map_err(refused)?,
        None => test.config.compensation.kind,
    };
    let experiment = experiment(&test, record.as_ref(), duration)?;
    let ran: Result<JudgedRun, Failure> = py.detach(|| {
        let ideal = experiment.ideal()?;
        experiment.run(method, &ideal, seed, trace, ())
    });
    let ran = ran.map_err(refused)?;
    let summary = pythonize::pythonize(py, &ran.summary)?;
    let steps = ran.trace.map(|t| columns_of(py, &t)).transpose()?;
    Ok((summary, steps))
}

/// The columns of record.csv.
fn columns_of<'py>(py: Python<'py>, trace: &Trace) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    let put = |name: &str, values: Vec<f64>| columns.set_item(name, PyArray1::from_vec(py, values));
    put(
        "time_s",
        (0..trace.len()).map(|i| trace.time_s(i)).collect(),
    )?;
    for channel in channels::of(trace) {
        let values = channel.values.iter().map(|x| f64::from(*x)).collect();
        put(&channel.name, values)?;
    }
    put("step_1", trace.step.iter().map(|n| f64::from(*n)).collect())?;
    put(
        "flags_1",
        trace.flags.iter().map(|n| f64::from(*n)).collect(),
    )?;
    Ok(columns)
}

/// The same test under several compensations and ground motions, a row each.
#[pyfunction]
fn compare<'py>(
    py: Python<'py>,
    test: PathBuf,
    overrides: Vec<String>,
    records: Vec<Motion<'py>>,
    compensations: Vec<String>,
    seed: u64,
    duration: Option<f64>,
) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let test = TestFile::load(&test, &overrides).map_err(refused)?;
    let methods: Result<Vec<_>, Failure> = compensations.iter().map(|n| ::experiment::method(n)).collect();
    let methods = methods.map_err(refused)?;
    let mut experiments = Vec::new();
    for record in &records {
        experiments.push(experiment(&test, Some(record), duration)?);
    }
    if records.is_empty() {
        experiments.push(experiment(&test, None, duration)?);
    }
    let mut rows = Vec::new();
    for experiment in &experiments {
        let ideal = py.detach(|| experiment.ideal()).map_err(refused)?;
        for method in &methods {
            py.check_signals()?;
            let ran = py.detach(|| experiment.run(*method, &ideal, seed, false, ()));
            rows.push(pythonize::pythonize(py, &ran.map_err(refused)?.summary)?);
        }
    }
    Ok(rows)
}

/// Gain, delay, lag and offset of an actuator, and what makes them doubtful.
#[pyfunction]
fn identify<'py>(
    py: Python<'py>,
    recording: Recorded<'py>,
) -> PyResult<(Bound<'py, PyAny>, Option<String>)> {
    let (parts, _) = recordings(std::slice::from_ref(&recording))?;
    // Of a record with gaps, only the longest piece.
    let longest = parts.iter().max_by_key(|p| p.time_s.len());
    let longest = longest.ok_or_else(|| Refused::new_err("no record"))?;
    let found = py.detach(|| diagnosis::identify(longest));
    let found = found.map_err(|e| Refused::new_err(e.to_string()))?;
    let doubts = doubt(longest, &found);
    Ok((pythonize::pythonize(py, &found)?, doubts))
}

/// What a declared model, as TOML, lacks.
#[pyfunction]
fn diagnose<'py>(
    py: Python<'py>,
    declared: (String, String),
    train: Vec<Recorded<'py>>,
    test: Vec<Recorded<'py>>,
    rest: Vec<Recorded<'py>>,
) -> PyResult<(Bound<'py, PyAny>, String)> {
    let (name, text) = declared;
    let declared = model::parse(&name, &text).map_err(refused)?;
    let (train, in_newtons) = recordings(&train)?;
    let (test, also) = recordings(&test)?;
    let (rest, _) = recordings(&rest)?;
    let found = py.detach(|| diagnosis::diagnose(&declared, &train, &test, &rest));
    let mut found = found.map_err(|e| Refused::new_err(e.to_string()))?;
    for channel in &mut found.channels {
        channel.error_with_remainder = None;
    }
    if !(in_newtons && also) {
        measured::without_force_unit(&mut found);
    }
    let improved = model::to_toml(&found.improved).map_err(refused)?;
    Ok((pythonize::pythonize(py, &found)?, improved))
}

/// The columns of a table of numbers: text in any dialect, MAT or HDF5.
#[pyfunction]
fn read_record(py: Python<'_>, file: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let table = py
        .detach(|| any_table::read(&file, false)?.whole())
        .map_err(refused)?;
    let columns = PyDict::new(py);
    for (header, values) in table.headers.iter().zip(table.columns) {
        columns.set_item(&header.text, PyArray1::from_vec(py, values))?;
    }
    Ok(columns)
}

/// The module.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("Refused", module.py().get_type::<Refused>())?;
    module.add_function(wrap_pyfunction!(run, module)?)?;
    module.add_function(wrap_pyfunction!(compare, module)?)?;
    module.add_function(wrap_pyfunction!(identify, module)?)?;
    module.add_function(wrap_pyfunction!(diagnose, module)?)?;
    module.add_function(wrap_pyfunction!(read_record, module)?)
}
