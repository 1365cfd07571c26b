//! A folder of results that is there whole or not at all.

use crate::failure::Failure;
use std::fs;
use std::path::Path;

/// Writes `files` into `folder`: first beside their places, then all of them renamed.
///
/// # Errors
/// A folder or file that cannot be written; what was there before is left as it was.
pub fn write_all(folder: &Path, files: &[(&str, String)]) -> Result<(), Failure> {
    let cannot = |path: &Path, e: std::io::Error| {
        Failure::input(format!("{}: cannot be written: {e}", path.display()))
    };
    fs::create_dir_all(folder).map_err(|e| cannot(folder, e))?;
    let mut ready = Vec::new();
    for (name, text) in files {
        let partial = folder.join(format!(".{name}.partial"));
        if let Err(e) = fs::write(&partial, text) {
            let _ = fs::remove_file(&partial);
            for (done, _) in ready {
                let _ = fs::remove_file(done);
            }
            return Err(cannot(&partial, e));
        }
        ready.push((partial, folder.join(name)));
    }
    for (partial, place) in ready {
        fs::rename(&partial, &place).map_err(|e| cannot(&place, e))?;
    }
    Ok(())
}

/// Writes one file, whole or not at all.
///
/// # Errors
/// A file that cannot be written; what was there before is left as it was.
pub fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let name = path.file_name().and_then(|n| n.to_str()).ok_or_else(|| {
        Failure::input(format!(
            "{}: is no name of a file: accepted is a path that ends with one",
            path.display()
        ))
    })?;
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    write_all(folder.unwrap_or(Path::new(".")), &[(name, text.to_owned())])
}
