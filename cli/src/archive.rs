//! `record.h5`: one file with everything needed to judge a test and to repeat it.
//!
//! HDF5 with MATLAB's conventions, so it is also a MAT file of version 7.3: `h5py.File` and MATLAB's `load` open it.
//! Every channel is a vector with its name in `record.csv`: time in double precision, counts and flags as 32-bit
//! integers, all others in single precision as the controller has them. `units` names their units. `test_file`,
//! `summary`, `provenance`, `repeat` and `sha256` are text; `ground_motion_m_per_s2` are the points of the ground motion.

use crate::order_recorder::OperatorOrder;
use crate::provenance::{Provenance, hash};
use crate::site::RigKind;
use experiment::compensation::Compensation;
use experiment::coupled::part::CoupledPart;
use experiment::failure::Failure;
use experiment::files::test::TestFile;
use experiment::files::{channels, look_ahead};
use experiment::summary::Summary;
use experiment::trace::Trace;
use experiment::{Experiment, Shaking};
use hdf5_pure::File;
use hdf5_pure::mat::builder::MatBuilder;
use hdf5_pure::mat::{MatError, Options};
use outerloop_core::{Config, Method};
use plant::RigSpec;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// The data needed to repeat a test, besides the points of its ground motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RepeatSettings {
    /// Version of this struct.
    pub format: u32,
    /// Where the test ran.
    pub place: RigKind,
    /// Seed of everything random in a simulated rig.
    pub seed: u64,
    /// The compensation in force.
    pub method: Method,
    /// The configuration of core.
    pub config: Config,
    /// The simulated rig.
    pub plant: RigSpec,
    /// Only for a test of two coupled actuators.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coupled: Option<Box<CoupledPart>>,
    /// Name of the ground motion.
    pub record: String,
    /// Length, s of model time.
    pub seconds: f64,
    /// Factor by which the points were multiplied.
    pub scale: f64,
    /// Interval of the points, s.
    pub interval_s: f64,
    /// The operator's requests.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub orders: Vec<OperatorOrder>,
}

/// Version of [`RepeatSettings`].
const FORMAT: u32 = 1;

/// A test that ran.
#[derive(Clone, Copy, Debug)]
pub struct FinishedTest<'a> {
    /// What was tested.
    pub experiment: &'a Experiment,
    /// With which compensation.
    pub compensation: Compensation,
    /// Where it ran.
    pub place: RigKind,
    /// The seed used.
    pub seed: u64,
    /// The operator's requests.
    pub orders: &'a [OperatorOrder],
    /// Its figures.
    pub summary: &'a Summary,
    /// Its channels.
    pub trace: &'a Trace,
}

/// The contents of the file.
///
/// # Errors
/// A test whose numbers a file cannot hold.
pub fn to_bytes(ran: &FinishedTest<'_>) -> Result<Vec<u8>, Failure> {
    let shaking = ran.experiment.shaking();
    let test = &ran.experiment.test;
    let mut coupled = test.coupled.clone();
    let method = match ran.compensation {
        Compensation::Method(method) => method,
        Compensation::Coupled(kind) => {
            if let Some(part) = &mut coupled {
                part.declared.compensation = kind;
            }
            test.config.compensation.kind
        }
    };
    let repeat = RepeatSettings {
        format: FORMAT,
        place: ran.place,
        seed: ran.seed,
        method,
        config: test.config.clone(),
        plant: test.plant.clone(),
        coupled,
        record: ran.experiment.record.clone(),
        seconds: ran.experiment.seconds,
        scale: ran.experiment.scale,
        interval_s: shaking.interval_s,
        orders: ran.orders.to_vec(),
    };
    let text = json(&repeat)?;
    // A file that cannot be read back would be noticed too late.
    let back: RepeatSettings = serde_json::from_str(&text).map_err(|e| cannot(&e.to_string()))?;
    if back != repeat {
        return Err(cannot("its configuration does not read back as it is"));
    }
    let mut texts = vec![
        ("test_file", ran.experiment.test.text.clone()),
        ("summary", json(ran.summary)?),
        ("provenance", json(Provenance::of_this_run())?),
        ("repeat", text),
    ];
    let mut sums = sums_of_texts(&texts);
    sums.extend(sums_of_numbers(ran.trace, shaking));
    texts.push(("sha256", json(&sums)?));
    write(ran.trace, shaking, &texts).map_err(|e| cannot(&e.to_string()))
}

fn write(
    trace: &Trace,
    shaking: Shaking<'_>,
    texts: &[(&str, String)],
) -> Result<Vec<u8>, MatError> {
    let mut file = MatBuilder::new(Options::default());
    let column = [trace.len(), 1];
    let time_s: Vec<f64> = (0..trace.len()).map(|i| trace.time_s(i)).collect();
    file.write_f64("time_s", &column, &time_s)?;
    let channels = channels::of(trace);
    for channel in &channels {
        file.write_f32(&channel.name, &column, channel.values)?;
    }
    for (name, values) in [
        ("tick_1", &trace.tick),
        ("step_1", &trace.step),
        ("flags_1", &trace.flags),
    ] {
        file.write_u32(name, &column, values)?;
    }
    let points = shaking.acc_m_per_s2;
    file.write_f32("ground_motion_m_per_s2", &[points.len(), 1], points)?;
    file.struct_("units", |units| {
        units.write_char("time_s", "s")?;
        units.write_char("ground_motion_m_per_s2", "m/s^2")?;
        for channel in &channels {
            units.write_char(&channel.name, channel.unit)?;
        }
        Ok(())
    })?;
    for (name, text) in texts {
        file.write_char(name, text)?;
    }
    file.finish()
}

/// SHA-256 of each item in an archive, by name.
type Sums = BTreeMap<String, String>;

fn sums_of_texts(texts: &[(&str, String)]) -> Sums {
    let sum = |(name, text): &(&str, String)| ((*name).to_owned(), hash(text.as_bytes()));
    texts.iter().map(sum).collect()
}

fn sums_of_numbers(trace: &Trace, shaking: Shaking<'_>) -> Sums {
    let time_s: Vec<u8> = (0..trace.len())
        .flat_map(|i| trace.time_s(i).to_le_bytes())
        .collect();
    let mut sums = Sums::from([
        ("time_s".to_owned(), hash(&time_s)),
        (
            "ground_motion_m_per_s2".to_owned(),
            sum_of_singles(shaking.acc_m_per_s2),
        ),
    ]);
    for channel in channels::of(trace) {
        sums.insert(channel.name, sum_of_singles(channel.values));
    }
    for (name, values) in [
        ("tick_1", &trace.tick),
        ("step_1", &trace.step),
        ("flags_1", &trace.flags),
    ] {
        sums.insert(name.to_owned(), sum_of_counts(values));
    }
    sums
}

fn sum_of_singles(values: &[f32]) -> String {
    let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    hash(&bytes)
}

fn sum_of_counts(values: &[u32]) -> String {
    let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    hash(&bytes)
}

/// A test as an archive holds it.
#[derive(Clone, Debug)]
pub struct ArchivedTest {
    /// How to repeat the test.
    pub repeat: RepeatSettings,
    /// The test, ready to run.
    pub experiment: Experiment,
    /// Its channels, by name.
    pub channels: Vec<(String, Vec<f32>)>,
    /// Control steps.
    pub steps: usize,
    /// Flags of every control step.
    pub flags: Vec<u32>,
    /// Its figures, as in `summary.json`.
    pub summary: serde_json::Value,
    /// Names of the items that have changed since they were written.
    pub changed: Vec<String>,
    /// The version that wrote it.
    pub version: String,
}

/// Refuses to replace a file, unless it is empty or the archive of a test that can be run again.
///
/// # Errors
/// Any other file, without `--force`.
pub fn refuse_to_replace(file: &Path) -> Result<(), Failure> {
    let empty = || file.metadata().is_ok_and(|found| found.len() == 0);
    if !file.is_file() || look_ahead::is_forced() || empty() {
        return Ok(());
    }
    let why = match load(file) {
        Ok(test) if test.repeat.place != RigKind::Simulated => {
            "holds a test on a board, which cannot be made again"
        }
        Ok(test) if test.summary["verdict"] == "stopped" => {
            "holds a test that was stopped by hand, which cannot be made again"
        }
        Ok(_) => return Ok(()),
        Err(_) => "is there already and is no archive",
    };
    Err(Failure::input(format!(
        "{}: {why}: accepted is the name of a new file, or --force",
        file.display()
    )))
}

impl ArchivedTest {
    /// The compensation in force.
    pub fn compensation(&self) -> Compensation {
        match &self.repeat.coupled {
            None => self.repeat.method.into(),
            Some(part) => part.declared.compensation.into(),
        }
    }
}

/// Reads an archive, or the `record.h5` of a folder that `run --out` wrote.
///
/// # Errors
/// A file that cannot be read, or that is not an archive.
pub fn load(path: &Path) -> Result<ArchivedTest, Failure> {
    let within = path.join("record.h5");
    let path = if path.is_dir() { &within } else { path };
    let bytes = experiment::files::decode::bytes(path)?;
    let file = path.display().to_string();
    if !hdf5_pure::is_hdf5_bytes(&bytes) {
        return Err(Failure::input(format!(
            "{file}: is no archive: accepted is a record.h5 of `run --out`, or a file of `run --archive`"
        )));
    }
    read(bytes, &file).map_err(|why| {
        Failure::input(format!(
            "{file}: cannot be replayed: {why}: accepted is an archive as `run --archive` writes it"
        ))
    })
}

fn read(bytes: Vec<u8>, file: &str) -> Result<ArchivedTest, String> {
    let h5 = File::from_bytes(bytes).map_err(|e| e.to_string())?;
    let text = |name: &str| text_of(&h5, name);
    let singles = |name: &str| -> Result<Vec<f32>, String> {
        h5.dataset(name)
            .and_then(|d| d.read::<f32>())
            .map_err(|e| format!("{name}: {e}"))
    };
    let repeat: RepeatSettings =
        serde_json::from_str(&text("repeat")?).map_err(|e| format!("repeat: {e}"))?;
    if repeat.format != FORMAT {
        return Err(format!(
            "its format is {}, this program's {FORMAT}",
            repeat.format
        ));
    }
    let provenance: serde_json::Value =
        serde_json::from_str(&text("provenance")?).map_err(|e| format!("provenance: {e}"))?;
    let test = TestFile::parse(&text("test_file")?, file, Path::new(""), &[])
        .map_err(|e| e.to_string())?;
    let test = TestFile {
        config: repeat.config.clone(),
        plant: repeat.plant.clone(),
        coupled: repeat.coupled.clone(),
        ..test
    };
    let numbers = |name: &str| -> Result<Vec<u32>, String> {
        h5.dataset(name)
            .and_then(|d| d.read::<u32>())
            .map_err(|e| format!("{name}: {e}"))
    };
    let summary = serde_json::from_str(&text("summary")?).map_err(|e| format!("summary: {e}"))?;
    let trace = test.trace();
    let names: Vec<String> = channels::of(&trace).into_iter().map(|c| c.name).collect();
    let channels = names
        .into_iter()
        .map(|name| Ok((name.clone(), singles(&name)?)))
        .collect::<Result<Vec<_>, String>>()?;
    Ok(ArchivedTest {
        experiment: Experiment::with_shaking(
            test,
            repeat.record.clone(),
            repeat.seconds,
            repeat.scale,
            &Shaking {
                acc_m_per_s2: &singles("ground_motion_m_per_s2")?,
                interval_s: repeat.interval_s,
            },
        ),
        repeat,
        changed: changed(&h5, &channels)?,
        steps: numbers("tick_1")?.len(),
        flags: numbers("flags_1")?,
        summary,
        channels,
        version: provenance["version"]
            .as_str()
            .unwrap_or("not known")
            .to_owned(),
    })
}

/// Names of the items that have changed since they were written; none for an archive of an earlier version, which has no sums.
fn changed(h5: &File, channels: &[(String, Vec<f32>)]) -> Result<Vec<String>, String> {
    let Ok(written) = text_of(h5, "sha256") else {
        return Ok(Vec::new());
    };
    let written: Sums = serde_json::from_str(&written).map_err(|e| format!("sha256: {e}"))?;
    let same = |(name, sum): &(&String, &String)| {
        let now = match name.as_str() {
            "time_s" => {
                let time_s = h5.dataset(name).and_then(|d| d.read::<f64>()).ok()?;
                let bytes: Vec<u8> = time_s.iter().flat_map(|x| x.to_le_bytes()).collect();
                hash(&bytes)
            }
            "tick_1" | "step_1" | "flags_1" => {
                sum_of_counts(&h5.dataset(name).and_then(|d| d.read::<u32>()).ok()?)
            }
            "test_file" | "summary" | "provenance" | "repeat" => {
                hash(text_of(h5, name).ok()?.as_bytes())
            }
            name => match channels.iter().find(|(own, _)| own == name) {
                Some((_, values)) => sum_of_singles(values),
                None => sum_of_singles(&h5.dataset(name).and_then(|d| d.read::<f32>()).ok()?),
            },
        };
        (now == **sum).then_some(())
    };
    let others = written.iter().filter(|entry| same(entry).is_none());
    Ok(others.map(|(name, _)| name.clone()).collect())
}

fn text_of(h5: &File, name: &str) -> Result<String, String> {
    let units: Vec<u16> = h5
        .dataset(name)
        .and_then(|d| d.read::<u16>())
        .map_err(|e| format!("{name}: {e}"))?;
    String::from_utf16(&units).map_err(|e| format!("{name}: {e}"))
}

fn json(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(value).map_err(|e| cannot(&e.to_string()))
}

fn cannot(why: &str) -> Failure {
    Failure::test(format!("the test cannot be archived: {why}"))
}
