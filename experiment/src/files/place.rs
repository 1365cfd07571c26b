//! Resolves a path before something is written there.

use super::plain;
use crate::failure::Failure;
use std::fs;
use std::io::Error;
use std::path::{Path, PathBuf};

/// What a path leads to.
pub(super) enum Place {
    /// A regular file, existing or not, with its real path.
    File(PathBuf),
    /// Something that must be written to and not replaced.
    Stream,
}

impl Place {
    /// Follows links.
    ///
    /// # Errors
    /// A folder.
    pub(super) fn of(path: &Path) -> Result<Self, Error> {
        match fs::metadata(path) {
            Ok(found) if found.is_file() => Ok(Self::File(path.canonicalize()?)),
            Ok(found) if found.is_dir() => Err(Error::other("it is a folder")),
            Ok(_) => Ok(Self::Stream),
            // A link to a file that does not exist yet: the file is created, the link stays.
            Err(_) => match fs::read_link(path) {
                Ok(target) => Ok(Self::File(
                    path.parent().unwrap_or(Path::new("")).join(target),
                )),
                Err(_) => Ok(Self::File(path.to_owned())),
            },
        }
    }
}

/// Checks that something is a folder, or does not exist yet.
///
/// # Errors
/// Anything else.
pub(super) fn refuse_no_folder(folder: &Path) -> Result<(), Failure> {
    if folder.exists() && !folder.is_dir() {
        return Err(Failure::input(format!(
            "{}: is no folder: accepted is a folder, or a name that is free",
            folder.display()
        )));
    }
    Ok(())
}

/// The message for a place that cannot be written.
pub(super) fn cannot(path: &Path, e: &Error) -> Failure {
    Failure::input(format!(
        "{}: cannot be written: {}",
        path.display(),
        plain::reason(e)
    ))
}
