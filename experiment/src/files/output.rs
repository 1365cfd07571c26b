//! A folder of results that is written completely or not at all.

use super::note;
use super::place::{Place, cannot, refuse_no_folder};
use crate::failure::Failure;
use std::fs::{self, File};
use std::io::{Error, Write};
use std::path::{Path, PathBuf};

/// Writes `files` into `folder`: first under temporary names, then renames them all. Links are followed; what is not a
/// regular file, such as a pipe or a device, is written to directly.
///
/// # Errors
/// A folder or file that cannot be written; previous contents are unchanged.
pub fn write_all<N: AsRef<str>, T: AsRef<[u8]>>(
    folder: &Path,
    files: &[(N, T)],
) -> Result<(), Failure> {
    let replaced = put(folder, files)?;
    if !replaced.is_empty() {
        let folder = folder.display();
        note(format_args!(
            "in {folder} were before, and are replaced: {}",
            replaced.join(", ")
        ));
    }
    Ok(())
}

/// The same, and what was there before.
fn put<N: AsRef<str>, T: AsRef<[u8]>>(
    folder: &Path,
    files: &[(N, T)],
) -> Result<Vec<String>, Failure> {
    let new = !folder.exists();
    refuse_no_folder(folder)?;
    fs::create_dir_all(folder).map_err(|e| cannot(folder, &e))?;
    write_into(folder, files).inspect_err(|_| {
        // Remove all of a result that could not be written; a non-empty folder stays.
        if new {
            let _ = fs::remove_dir(folder);
        }
    })
}

fn write_into<N: AsRef<str>, T: AsRef<[u8]>>(
    folder: &Path,
    files: &[(N, T)],
) -> Result<Vec<String>, Failure> {
    let mut ready: Vec<(tempfile::TempPath, PathBuf)> = Vec::new();
    let mut streams = Vec::new();
    for (name, text) in files {
        let name = name.as_ref();
        let place = folder.join(name);
        match Place::of(&place).map_err(|e| cannot(&place, &e))? {
            Place::File(real) => {
                let partial =
                    temporary_file(&real, name, text.as_ref()).map_err(|e| cannot(&place, &e))?;
                ready.push((partial, real));
            }
            Place::Stream => streams.push((place, text.as_ref())),
        }
    }
    for (place, text) in streams {
        let written = File::options().write(true).open(&place);
        written
            .and_then(|mut f| f.write_all(text))
            .map_err(|e| cannot(&place, &e))?;
    }
    let mut replaced = Vec::new();
    for (partial, place) in ready {
        if place.is_file()
            && let Some(name) = place.file_name()
        {
            replaced.push(name.to_string_lossy().into_owned());
        }
        partial
            .persist(&place)
            .map_err(|e| cannot(&place, &e.error))?;
    }
    Ok(replaced)
}

/// Writes one file, completely or not at all; see [`write_all`].
///
/// # Errors
/// A file that cannot be written; previous contents are unchanged.
pub fn write(path: &Path, text: impl AsRef<[u8]>) -> Result<(), Failure> {
    let (folder, name) = parts(path)?;
    write_all(folder, &[(name, text)])
}

/// Writes back a file that was read to be changed: replacing it is intended, and not reported.
///
/// # Errors
/// As for [`write`].
pub fn write_back(path: &Path, text: impl AsRef<[u8]>) -> Result<(), Failure> {
    let (folder, name) = parts(path)?;
    put(folder, &[(name, text)]).map(drop)
}

/// The folder and the name of a file.
fn parts(path: &Path) -> Result<(&Path, &str), Failure> {
    let name = path.file_name().and_then(|n| n.to_str()).ok_or_else(|| {
        Failure::input(format!(
            "{}: is no name of a file: accepted is a path that ends with one",
            path.display()
        ))
    })?;
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    Ok((folder.unwrap_or(Path::new(".")), name))
}

/// `text` in a new file next to `place`, to be renamed to it.
fn temporary_file(place: &Path, name: &str, text: &[u8]) -> Result<tempfile::TempPath, Error> {
    let folder = place.parent().filter(|p| !p.as_os_str().is_empty());
    let mut builder = tempfile::Builder::new();
    let prefix = format!(".{name}.");
    builder.prefix(&prefix).suffix(".partial");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As for any new file: the system's mask is applied.
        let as_new = fs::Permissions::from_mode(0o666);
        builder.permissions(fs::metadata(place).map_or(as_new, |m| m.permissions()));
    }
    let mut file = builder.tempfile_in(folder.unwrap_or(Path::new(".")))?;
    file.write_all(text)?;
    Ok(file.into_temp_path())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};

    #[test]
    fn a_link_stays_a_link_and_its_file_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("real.toml"), "old").unwrap();
        fs::set_permissions(at("real.toml"), fs::Permissions::from_mode(0o640)).unwrap();
        symlink("real.toml", at("link")).unwrap();
        symlink("new.toml", at("ahead")).unwrap();
        for (link, file) in [("link", "real.toml"), ("ahead", "new.toml")] {
            write(&at(link), "new").unwrap();
            assert!(at(link).is_symlink());
            assert_eq!(fs::read_to_string(at(file)).unwrap(), "new");
        }
        let mode = fs::metadata(at("real.toml")).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
    }

    #[test]
    fn a_folder_that_cannot_be_filled_is_not_left_behind() {
        let folder = tempfile::tempdir().unwrap();
        let new = folder.path().join("new");
        // No file can have this name.
        let long = "x".repeat(300);
        assert!(write_all(&new, &[("a", "1"), (&long, "2")]).is_err());
        assert!(!new.exists());
        assert!(write_all(folder.path(), &[(&long, "2")]).is_err());
        assert!(folder.path().exists());
    }

    #[test]
    fn a_pipe_is_written_to_and_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read_to_string(pipe).unwrap()
        });
        write(&pipe, "through").unwrap();
        assert_eq!(reader.join().unwrap(), "through");
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        write(Path::new("/dev/null"), "gone").unwrap();
        assert!(
            fs::metadata("/dev/null")
                .unwrap()
                .file_type()
                .is_char_device()
        );
    }
}
