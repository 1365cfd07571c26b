//! The test file: what is tested, how, and on which simulated rig.

use super::plain::{self, part, typed};
use super::{decode, refused, units};
use crate::compensation::Compensation;
use crate::coupled::part::CoupledPart;
use crate::failure::Failure;
use crate::files::serve::Settings;
use crate::files::watch::WatchSettings;
use crate::rig::declared::{self, Expected};
use crate::trace::Trace;
use diagnosis::Model;
use outerloop_core::{Config, Refusal, accept};
use plant::RigSpec;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// A whole test file.
///
/// ```
/// use experiment::files::test::TestFile;
/// use std::path::Path;
///
/// let text = "[structure]\nmass_kg = 1000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.02\n\
///             [plant.actuator]\nkind = 'delay'\ndelay_ms = 4\n";
/// let parse = |set: &[String]| TestFile::parse(text, "frame.toml", Path::new(""), set);
/// let test = parse(&["compensation.kind='tangent'".into()])?;
/// assert_eq!(test.config.compensation.kind.name(), "tangent");
/// // A mistake is one sentence, with the file and what was set from outside.
/// let mistake = parse(&["plant.actuator.delay_ms=-4".into()]).unwrap_err().to_string();
/// assert!(mistake.starts_with("frame.toml with --set plant.actuator.delay_ms=-4: "), "{mistake}");
/// # Ok::<(), experiment::failure::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct TestFile {
    /// What core is configured with.
    pub config: Config,
    /// The rig that stands in for the laboratory.
    pub plant: RigSpec,
    /// What the laboratory declares of it; left out: what the simulated rig really is.
    pub declared: Option<Model>,
    /// Where the delay comes from that the compensation expects.
    pub expected: Expected,
    /// What shakes the structure.
    pub excitation: Excitation,
    /// What a board has to be to run it.
    pub board: BoardWanted,
    /// How the rig serves a program outside.
    pub serve: Settings,
    /// Of a test of two coupled actuators: what only such a test has.
    pub coupled: Option<Box<CoupledPart>>,
    /// Whether the running test is watched.
    pub watch: WatchSettings,
    /// The file as it was used, with what `--set` changed.
    pub text: String,
}

/// `[board]`: what a board has to be to run the test.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BoardWanted {
    /// Number of its calibration, eight hexadecimal digits as `outerloop board calibrate` shows it.
    pub calibration: Option<String>,
    /// Bits of its converters, 12 (the chip's own) or 16 (external, -10 to +10 V); left out: where the board is emulated 12,
    /// and 16 for a test with three actuators; else whatever it has.
    pub converter_bits: Option<u16>,
}

impl BoardWanted {
    fn check(&self) -> Result<(), String> {
        if let Some(bits) = self.converter_bits
            && !matches!(bits, 12 | 16)
        {
            return Err(format!(
                "board.converter_bits = {bits} is refused: accepted are 12 (the chip's own converters) and 16 (external ones, see docs/wiring-16.md)"
            ));
        }
        match &self.calibration {
            Some(number) if number.len() != 8 || u32::from_str_radix(number, 16).is_err() => {
                Err(format!(
                    "board.calibration = \"{number}\" is refused: accepted are eight hexadecimal digits as `outerloop board calibrate` shows them"
                ))
            }
            _ => Ok(()),
        }
    }
}

/// `[excitation]`: which ground motion, how strong, how long.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Excitation {
    /// A file, relative to the test file; left out: the built-in near-fault record.
    pub record: Option<PathBuf>,
    /// Factor on the acceleration.
    pub scale: f64,
    /// Instead of a factor: the largest displacement, mm, that the linear structure on an ideal rig shall have.
    pub peak_response_mm: Option<f64>,
    /// Seconds of model time, above 0 to 3600; left out: the whole record.
    pub duration_s: Option<f64>,
    /// Seconds of model time at rest before the ground motion begins: a second of it tells a diagnosis the noise.
    pub rest_s: f64,
}

impl Default for Excitation {
    fn default() -> Self {
        Self {
            record: None,
            scale: 1.0,
            peak_response_mm: None,
            duration_s: None,
            rest_s: 0.0,
        }
    }
}

impl Excitation {
    fn within_range(&self) -> Result<(), Refusal> {
        let (scale, rest_s) = (self.scale, self.rest_s);
        let strong = scale.is_finite() && scale != 0.0 && scale.abs() <= 1e3;
        let short = (0.0..=60.0).contains(&rest_s);
        accept(
            "excitation.scale",
            scale,
            strong,
            "factors other than 0, to 1000",
        )?;
        accept("excitation.rest_s", rest_s, short, "0 to 60 s")?;
        let mm = self.peak_response_mm.unwrap_or(1.0);
        let accepted = "above 0 to 10000 mm";
        accept(
            "excitation.peak_response_mm",
            mm,
            mm > 0.0 && mm <= 1e4,
            accepted,
        )
    }

    /// That its values can be meant.
    ///
    /// # Errors
    /// The first that cannot, by its key.
    pub fn check(&self) -> Result<(), String> {
        self.within_range().map_err(|e| e.to_string())?;
        match self.peak_response_mm {
            Some(_) if self.scale != 1.0 => Err(
                "excitation.scale and excitation.peak_response_mm are both given: accepted is one of them".into(),
            ),
            _ => Ok(()),
        }
    }
}

impl TestFile {
    /// Reads `path` and applies the overrides `PATH=VALUE`. A test of two coupled actuators is refused: not everything that
    /// can be done with others can be done with one.
    ///
    /// # Errors
    /// A file, key or value that cannot be used.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, Failure> {
        let test = Self::load_any(path, overrides)?;
        if test.coupled.is_some() {
            return Err(Failure::input(format!(
                "{}: coupled is a test of two coupled actuators: accepted are the commands run, compare, check, sweep, \
                 serve, replay and diff",
                path.display()
            )));
        }
        Ok(test)
    }

    /// As [`TestFile::load`], of either kind.
    ///
    /// # Errors
    /// A file, key or value that cannot be used.
    pub fn load_any(path: &Path, overrides: &[String]) -> Result<Self, Failure> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let file = path.display().to_string();
        let bytes = decode::bytes(path)?;
        if decode::is_binary(&bytes) {
            return Err(Failure::input(format!(
                "{file}: is a binary file, and no test file: accepted is one in TOML, as `outerloop new` writes it; \
                 `outerloop replay` and `diff` take the archive of a test"
            )));
        }
        Self::parse(&decode::text(&file, bytes)?, &file, folder, overrides)
    }

    /// What only a test of two coupled actuators has.
    ///
    /// # Errors
    /// A test of another kind.
    pub fn coupled_part(&self) -> Result<&CoupledPart, Failure> {
        self.coupled.as_deref().ok_or_else(|| {
            Failure::input(
                "the test has no table [coupled]: accepted is a test of two coupled actuators",
            )
        })
    }

    /// The compensation that it asks for.
    pub fn compensation(&self) -> Compensation {
        match &self.coupled {
            None => self.config.compensation.kind.into(),
            Some(part) => part.declared.compensation.into(),
        }
    }

    /// A compensation by its name, of those that this test can be run under.
    ///
    /// # Errors
    /// Another name.
    pub fn compensation_named(&self, name: &str) -> Result<Compensation, Failure> {
        Compensation::named(name, self.coupled.is_some())
    }

    /// The compensations with these names, or `otherwise` where none is named.
    ///
    /// # Errors
    /// As for [`TestFile::compensation_named`].
    pub fn compensations(
        &self,
        names: &[String],
        otherwise: Vec<Compensation>,
    ) -> Result<Vec<Compensation>, Failure> {
        match names {
            [] => Ok(otherwise),
            names => names.iter().map(|n| self.compensation_named(n)).collect(),
        }
    }

    /// A record of this test without a step yet.
    pub fn trace(&self) -> Trace {
        let rate_hz = self.config.timing.rate_hz;
        match &self.coupled {
            None => Trace::new(self.config.degrees_of_freedom(), rate_hz),
            Some(part) => Trace::of_coupled(part, rate_hz),
        }
    }

    /// Reads `text`, which came from `file`, of either kind; records that it names are relative to `folder`.
    ///
    /// # Errors
    /// A key or value that cannot be used.
    pub fn parse(
        text: &str,
        file: &str,
        folder: &Path,
        overrides: &[String],
    ) -> Result<Self, Failure> {
        parse(text, file, overrides, |table| {
            Self::from_table(table, folder)
        })
    }

    /// What is declared of the rig, in the file or else by the simulated rig itself. `None` where that is more than a model
    /// can say: several actuators, or an actuator that is no delay and lag.
    pub fn declared_model(&self) -> Option<Model> {
        self.declared
            .clone()
            .or_else(|| declared::from_plant(&self.config, &self.plant))
    }

    /// A warning where the compensation is given what no laboratory knows.
    pub fn warning_of_true_delay(&self) -> Option<String> {
        (self.expected == Expected::Truth).then(|| {
            format!(
                "Nothing is declared of the actuator ([declared.actuator]): the compensation uses the true delay of the simulated actuator, {} ms.",
                self.config.compensation.delay_ms
            )
        })
    }

    fn from_table(mut table: Table, folder: &Path) -> Result<Self, String> {
        let text = toml::to_string(&table).unwrap_or_default();
        units::convert(&mut table)?;
        let mut excitation: Excitation = part("excitation", table.remove("excitation"))?;
        excitation.check()?;
        excitation.record = excitation.record.map(|record| folder.join(record));
        let serve: Settings = part("serve", table.remove("serve"))?;
        serve.check().map_err(|e| e.to_string())?;
        if table.contains_key("coupled") {
            let (coupled, plant, config) = CoupledPart::take(table)?;
            return Ok(Self {
                config,
                plant,
                declared: None,
                expected: Expected::Default,
                excitation,
                board: BoardWanted::default(),
                serve,
                watch: WatchSettings::default(),
                coupled: Some(Box::new(coupled)),
                text,
            });
        }
        let plant = table.remove("plant");
        refuse_late_ideal(plant.as_ref())?;
        let mut plant: RigSpec = part("plant", plant)?;
        plant.effects.retain(|e| e.enabled);
        let board: BoardWanted = part("board", table.remove("board"))?;
        board.check()?;
        let watch: WatchSettings = part("watch", table.remove("watch"))?;
        watch.check()?;
        lists_of_one(&mut table);
        let declared: Option<Model> = table
            .remove("declared")
            .map(|value| typed("declared", value))
            .transpose()?;
        if let Some(model) = &declared {
            model.check().map_err(|e| format!("declared: {e}"))?;
        }
        let expected = declared::complete(&mut table, declared.as_ref(), &plant);
        let mut config: Config = typed("", Value::Table(table))?;
        if let Some(model) = &declared {
            declared::correct(model, &mut config)?;
        }
        config
            .check()
            .map_err(|e| refused::sentence(&e, &config, &plant, expected))?;
        // A rig that cannot be simulated is a mistake in this file, whatever runs it.
        let storeys = &config.structure.stiffness_n_per_m;
        plant::Rig::new(&plant, storeys, config.timing.rate_hz, 0).map_err(|e| e.to_string())?;
        Ok(Self {
            config,
            plant,
            declared,
            expected,
            excitation,
            board,
            serve,
            coupled: None,
            watch,
            text,
        })
    }
}

/// The table of `text`, which came from `file`, with the overrides `PATH=VALUE`, as `build` makes a test of it.
///
/// # Errors
/// A line that is no TOML; an override that cannot be set; what `build` refuses.
pub fn parse<T>(
    text: &str,
    file: &str,
    overrides: &[String],
    build: impl Fn(Table) -> Result<T, String>,
) -> Result<T, Failure> {
    let plain: Table = text.parse().map_err(|e: toml::de::Error| {
        Failure::input(format!("{file}, {}", plain::in_line(text, &e)))
    })?;
    let mut table = plain.clone();
    for assignment in overrides {
        set(&mut table, assignment)?;
    }
    build(table).map_err(|mistake| {
        // Whose mistake it is: the file's own, or that of what was set from outside.
        let own = overrides.is_empty() || build(plain).is_err();
        let set = if own {
            String::new()
        } else {
            format!(" with --set {}", overrides.join(" --set "))
        };
        Failure::input(format!("{file}{set}: {mistake}"))
    })
}

/// Refuses an actuator that has what only late ones have, and no kind: the default is ideal and would ignore it. Where `ideal` is
/// written it is meant.
fn refuse_late_ideal(plant: Option<&Value>) -> Result<(), String> {
    let actuator = plant.and_then(|p| p.get("actuator")?.as_table());
    let Some(actuator) = actuator.filter(|a| !a.contains_key("kind")) else {
        return Ok(());
    };
    let late = [
        "delay_ms",
        "lag_ms",
        "zeta",
        "multiplier_sd",
        "delay_jump",
        "servo",
    ];
    match late.into_iter().find(|key| actuator.contains_key(*key)) {
        Some(key) => Err(format!(
            "plant.actuator.{key} is given and plant.actuator.kind is not: accepted is a kind beside it, such as \"delay\" or \
             \"lag_delay\"; \"ideal\" ignores it (`outerloop keys plant.actuator`)"
        )),
        None => Ok(()),
    }
}

/// One degree of freedom is written as numbers: core takes lists.
fn lists_of_one(table: &mut Table) {
    let tables = ["structure", "rig"];
    let numbers = tables
        .into_iter()
        .filter_map(|name| match table.remove(name) {
            Some(Value::Table(mut part)) => {
                for (key, value) in part.iter_mut() {
                    if !value.is_array() && key != "physical_storeys" {
                        *value = Value::Array(vec![value.clone()]);
                    }
                }
                Some((name.to_owned(), Value::Table(part)))
            }
            other => Some((name.to_owned(), other?)),
        })
        .collect::<Vec<_>>();
    table.extend(numbers);
    // A method that a program brings itself may have a single number, too.
    if let Some(Value::Table(compensation)) = table.get_mut("compensation")
        && let Some(own) = compensation.get_mut("own")
        && !own.is_array()
    {
        *own = Value::Array(vec![own.clone()]);
    }
}

/// Sets one value by its dotted path; a number in the path is a place in a list, from 0. Whether the names exist is
/// found out when the table is read.
fn set(table: &mut Table, assignment: &str) -> Result<(), Failure> {
    let refuse = |why: &str| {
        Failure::input(format!(
            "--set {assignment}: {why}: accepted is PATH=VALUE, e.g. plant.actuator.delay_ms=8"
        ))
    };
    let (path, text) = assignment
        .split_once('=')
        .ok_or_else(|| refuse("has no `=`"))?;
    let value = format!("x = {text}")
        .parse::<Table>()
        .ok()
        .and_then(|mut t| t.remove("x"))
        .unwrap_or_else(|| Value::String(text.to_owned()));
    let keys: Vec<&str> = path.trim().split('.').collect();
    if keys.iter().any(|k| k.is_empty()) {
        return Err(refuse("has an empty name in its path"));
    }
    let (first, rest) = (keys[0], &keys[1..]);
    let mut here = table
        .entry(first)
        .or_insert_with(|| Value::Table(Table::new()));
    for key in rest {
        here = match here {
            Value::Table(t) => t.entry(*key).or_insert_with(|| Value::Table(Table::new())),
            Value::Array(list) => key
                .parse::<usize>()
                .ok()
                .and_then(|i| list.get_mut(i))
                .ok_or_else(|| refuse(&format!("`{key}` is no place in the list")))?,
            _ => {
                return Err(refuse(&format!(
                    "`{key}` would be a part of a single value"
                )));
            }
        };
    }
    *here = value;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use outerloop_core::config::ActuatorTimes;

    const TEXT: &str = "[structure]\nmass_kg = 1000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.02\n\
                        [plant.actuator]\nkind = \"delay\"\ndelay_ms = 4\n";

    fn with(overrides: &[&str]) -> Result<TestFile, String> {
        let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
        TestFile::parse(TEXT, "t.toml", Path::new("tests"), &overrides).map_err(|e| e.to_string())
    }

    #[test]
    fn a_late_actuator_needs_a_kind_and_an_ideal_one_ignores_what_it_has() {
        let text = TEXT.replace("kind = \"delay\"\n", "");
        let of = |text: &str| TestFile::parse(text, "t.toml", Path::new(""), &[]);
        let said = of(&text).unwrap_err().to_string();
        assert!(said.contains("plant.actuator.delay_ms is given"), "{said}");
        assert!(of(&TEXT.replace("delay\"", "ideal\"")).is_ok());
        assert!(of(&text.replace("delay_ms", "gain")).is_ok());
    }

    #[test]
    fn numbers_stand_for_one_degree_of_freedom_and_the_clamp_follows_the_rig() {
        let t = with(&[]).unwrap();
        assert_eq!(t.config.structure.mass_kg.as_slice(), [1000.0]);
        assert_eq!(t.config.compensation.delay_ms, 4.0.into());
        let t = with(&["plant.actuator.delay_ms=8", "compensation.kind=eq14"]).unwrap();
        assert_eq!(t.config.compensation.delay_ms, 8.0.into());
        assert_eq!(t.config.compensation.kind.name(), "eq14");
        let t = with(&["compensation.delay_ms=3"]).unwrap();
        assert_eq!(t.config.compensation.delay_ms, 3.0.into());
    }

    #[test]
    fn the_delay_is_one_for_all_actuators_or_one_for_each() {
        let frame = [
            "structure.mass_kg=[1e3,1e3,1e3]",
            "structure.stiffness_n_per_m=[8e5,8e5,8e5]",
            "structure.damping_ratio=[0.02,0.02,0.02]",
        ];
        let of_three = |more: &[&str]| with(&[&frame[..], more].concat());
        let told = |more: &[&str]| of_three(more).unwrap().config.compensation.delay_ms;
        let each = ActuatorTimes::each(&[4.0, 6.0, 9.0]).unwrap();
        assert_eq!(told(&["compensation.delay_ms=[4,6,9]"]), each);
        assert_eq!(told(&["compensation.delay_ms=[4,\"0.006 s\",9]"]), each);
        assert_eq!(told(&["plant.actuator.delay_ms=[4,6,9]"]), each);
        assert_eq!(told(&[]), 4.0.into());
        for (set, said) in [
            (
                "compensation.delay_ms=[4,6]",
                "compensation.delay_ms has 2 values: accepted are one value, or as many as storeys in the laboratory",
            ),
            (
                "plant.actuator.delay_ms=[4,6]",
                "plant.actuator.delay_ms or lag_ms has 2 values: accepted are one value, or as many as storeys in the laboratory",
            ),
            (
                "compensation.delay_ms=[4,6,-9]",
                "compensation.delay_ms = -9 is refused: accepted are above 0 and below 10000 ms",
            ),
            (
                "compensation.delay_ms=[4,6,9,1,2]",
                "compensation.delay_ms: a longer list than a rig has actuators",
            ),
        ] {
            let e = of_three(&[set]).unwrap_err();
            assert!(e.contains(said), "{e}");
        }
    }

    #[test]
    fn a_value_may_say_its_unit() {
        let t = with(&[
            "plant.actuator.delay_ms=0.008 s",
            "structure.stiffness_n_per_m=[\"158 kN/m\"]",
            "structure.damping_ratio=2 %",
            "declared.actuator.delay_ms={value=\"8 ms\",tolerance=\"1 ms\"}",
        ])
        .unwrap();
        assert_eq!(t.config.structure.stiffness_n_per_m.as_slice(), [158e3]);
        assert_eq!(t.config.structure.damping_ratio.as_slice(), [0.02]);
        assert_eq!(t.config.compensation.delay_ms, 8.0.into());
        let e = with(&["structure.mass_kg=1000 N"]).unwrap_err();
        let said = "structure.mass_kg = \"1000 N\" is refused: N is a force, and the key is a mass: accepted is a number \
                    alone, or one with a unit, as in \"1000 kg\"";
        assert!(e.ends_with(said), "{e}");
    }

    #[test]
    fn overrides_reach_into_lists_and_new_tables() {
        let three = "structure.mass_kg=[1,2,3]";
        let t = with(&[
            three,
            "structure.stiffness_n_per_m=[1000,1000,1000]",
            "structure.damping_ratio=[0.02,0.02,0.02]",
            "structure.mass_kg.1=5",
            "limits.force_n=10",
            "excitation.record=a.csv",
        ])
        .unwrap();
        assert_eq!(t.config.structure.mass_kg.as_slice(), [1.0, 5.0, 3.0]);
        assert_eq!(t.config.limits.force_n, Some(10.0));
        assert_eq!(t.excitation.record, Some(PathBuf::from("tests/a.csv")));
    }

    #[test]
    fn each_mistake_says_where_it_is() {
        for (assignment, said) in [
            ("loop.rate=2000", &["--set loop.rate=2000", "rate_hz"][..]),
            ("plant.actuator.delay=8", &["plant.actuator", "delay_ms"]),
            ("plant.motor.kind=ideal", &["plant", "motor", "actuator"]),
            (
                "nonsense.x=1",
                &["nonsense", "plant", "excitation", "structure"],
            ),
            (
                "loop.rate_hz=fast",
                &["loop.rate_hz", "\"fast\"", "a number"],
            ),
            ("loop=5", &["loop", "accepted is a table"]),
            (
                "loop.substeps=1000000",
                &["substeps", "a whole number to 65535"],
            ),
            (
                "structure.mass_kg=[1,2,3,4,5,6,7,8,9,10]",
                &["mass_kg", "at most 8 values"],
            ),
            ("loop.rate_hz=1", &["loop.rate_hz = 1", "10 to 100000 Hz"]),
            (
                "compensation.kind=magic",
                &["compensation.kind", "magic", "paper"],
            ),
            (
                "plant.actuator.kind=magic",
                &["plant.actuator.kind", "magic", "lag_delay"],
            ),
            ("structure.mass_kg.x.y=1", &["a single value"]),
            ("loop.rate_hz", &["has no `=`"]),
            ("=1", &["empty name"]),
            ("excitation.scale=0", &["excitation.scale = 0"]),
            ("excitation.scale=nan", &["excitation.scale = NaN"]),
            ("excitation.peak_response_mm=-1", &["peak_response_mm = -1"]),
            (
                "board.calibration=12ab",
                &["board.calibration", "eight hexadecimal"],
            ),
            ("excitation.rest_s=-1", &["rest_s = -1", "0 to 60 s"]),
        ] {
            let e = with(&[assignment]).unwrap_err();
            for word in said {
                assert!(e.contains(word), "{word} is not in: {e}");
            }
            assert!(!e.contains('\n'), "{e}");
        }
    }

    #[test]
    fn mistakes_of_the_file_name_the_file_and_not_the_override() {
        let text = TEXT.replace("4", "\"four\"");
        let set = ["loop.rate_hz=1000".to_owned()];
        let e = TestFile::parse(&text, "t.toml", Path::new(""), &set).unwrap_err();
        let e = e.to_string();
        assert!(e.starts_with("t.toml: plant.actuator.delay_ms"), "{e}");
        let broken = format!("{TEXT}[loop\n");
        let e = TestFile::parse(&broken, "t.toml", Path::new(""), &[]).unwrap_err();
        assert!(
            e.to_string().starts_with("t.toml, line 8, `[loop`: "),
            "{e}"
        );
    }
}
