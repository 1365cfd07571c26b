//! Who ran what, when, with which files and which program: what an archive must record of every result.

use schemars::JsonSchema;
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::path::Path;
use std::sync::OnceLock;

/// A file that the command named.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct NamedFile {
    /// Its path, as it was given.
    pub file: String,
    /// Its SHA-256, as `sha256sum` prints it.
    pub sha256: String,
}

/// Where a result comes from.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Provenance {
    /// When the program was started: local time with its offset from UTC.
    pub date: String,
    /// Who ran it: OUTERLOOP_OPERATOR, else the user of the machine.
    pub operator: String,
    /// The machine.
    pub machine: String,
    /// The command line.
    pub command: String,
    /// The folder that it was given in.
    pub folder: String,
    /// The program's version, with its commit in released binaries.
    pub version: String,
    /// SHA-256 of the program itself.
    pub program_sha256: String,
    /// Seed of everything random, where something was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// The files that the command named, with what was in them.
    pub files: Vec<NamedFile>,
}

/// The seed of this process.
static SEED: OnceLock<u64> = OnceLock::new();

/// Notes that everything random in this process comes from `seed`. Call before results are written.
pub fn note_seed(seed: u64) {
    SEED.get_or_init(|| seed);
}

/// A result and its provenance, as in `--json` and summary.json.
#[derive(Serialize)]
pub struct WithProvenance<'a, T> {
    #[serde(flatten)]
    result: &'a T,
    #[serde(skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
    provenance: &'static Provenance,
}

impl<'a, T: Serialize> WithProvenance<'a, T> {
    /// A result without anything random.
    pub fn of(result: &'a T) -> Self {
        Self {
            result,
            seed: None,
            provenance: Provenance::of_this_run(),
        }
    }

    /// A result, with the seed of everything random in it.
    pub fn seeded(result: &'a T, seed: u64) -> Self {
        note_seed(seed);
        Self {
            seed: Some(seed),
            ..Self::of(result)
        }
    }
}

/// The provenance of this process.
static THIS: OnceLock<Provenance> = OnceLock::new();

impl Provenance {
    /// The provenance of this process. Files are read at the first call, which comes before results are written.
    pub fn of_this_run() -> &'static Self {
        THIS.get_or_init(|| {
            let arguments: Vec<String> = std::env::args_os()
                .map(|a| a.to_string_lossy().into_owned())
                .collect();
            let of_user = |name: &str| std::env::var(name).ok().filter(|user| !user.is_empty());
            let names = ["OUTERLOOP_OPERATOR", "USER", "USERNAME", "LOGNAME"];
            let program = std::env::current_exe().ok();
            Self {
                date: jiff::Zoned::now()
                    .strftime("%Y-%m-%d %H:%M:%S %:z")
                    .to_string(),
                operator: names
                    .into_iter()
                    .find_map(of_user)
                    .unwrap_or_else(|| "not known (OUTERLOOP_OPERATOR names one)".into()),
                machine: gethostname::gethostname().to_string_lossy().into_owned(),
                command: command(&arguments),
                folder: std::env::current_dir()
                    .map_or_else(|_| "not known".into(), |f| f.display().to_string()),
                version: version(),
                program_sha256: program
                    .and_then(|path| hash_of(&path))
                    .unwrap_or_else(|| "not known".into()),
                seed: SEED.get().copied(),
                files: named_files(&arguments),
            }
        })
    }
}

/// The program's name and version.
pub fn version() -> String {
    // Set when a release is built; any other build is identified by the program's hash.
    match option_env!("OUTERLOOP_COMMIT") {
        Some(commit) => format!("outerloop {} ({commit})", env!("CARGO_PKG_VERSION")),
        None => format!("outerloop {}", env!("CARGO_PKG_VERSION")),
    }
}

/// The SHA-256 of some bytes.
pub fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

fn hash_of(path: &Path) -> Option<String> {
    // A pipe or a device would be read to its end, and its data lost.
    path.is_file()
        .then(|| std::fs::read(path).ok())
        .flatten()
        .map(|bytes| hash(&bytes))
}

/// A command line that a shell accepts again.
fn command(arguments: &[String]) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+@%".contains(c);
    let words = arguments.iter().enumerate().map(|(i, argument)| {
        let argument = match i {
            // The program's folder is not relevant.
            0 => Path::new(argument)
                .file_name()
                .map_or(argument.as_str(), |n| n.to_str().unwrap_or(argument)),
            _ => argument,
        };
        if !argument.is_empty() && argument.chars().all(plain) {
            argument.to_owned()
        } else {
            format!("'{}'", argument.replace('\'', "'\\''"))
        }
    });
    words.collect::<Vec<_>>().join(" ")
}

/// The arguments that are files: whole, after a `=`, or before the span of `FILE@T0..T1`.
fn named_files(arguments: &[String]) -> Vec<NamedFile> {
    let mut files: Vec<NamedFile> = Vec::new();
    for argument in arguments.iter().skip(1) {
        let behind = argument
            .split_once('=')
            .map_or(argument.as_str(), |(_, value)| value);
        for name in [argument.as_str(), behind] {
            let file = match name.rsplit_once('@') {
                Some((file, span)) if span.contains("..") => file,
                _ => name,
            };
            if files.iter().all(|f| f.file != file)
                && let Some(sha256) = hash_of(Path::new(file))
            {
                files.push(NamedFile {
                    file: file.to_owned(),
                    sha256,
                });
            }
        }
    }
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_told_by_what_is_in_them() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("abc");
        std::fs::write(&path, "abc").unwrap();
        let path = path.display().to_string();
        let named = named_files(
            &[
                "outerloop",
                "run",
                &path,
                &format!("--x={path}"),
                &format!("{path}@0..1"),
                "none",
            ]
            .map(String::from),
        );
        assert_eq!(named.len(), 1);
        // The example of FIPS 180-2.
        assert_eq!(
            named[0].sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }

    #[test]
    fn a_command_can_be_given_again() {
        let arguments = [
            "/usr/bin/outerloop",
            "run",
            "my test.toml",
            "--set",
            "a.b=3",
        ]
        .map(String::from);
        assert_eq!(
            command(&arguments),
            "outerloop run 'my test.toml' --set a.b=3"
        );
    }
}
