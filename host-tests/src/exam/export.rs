//! Questions as files, for examinees outside this repository; the key stays here.

use exam::{Paper, Record, set};
use std::fmt::Write;
use std::fs;
use std::io;
use std::path::Path;

use super::plan::Item;

/// Writes `folder/CLASS-SEED/{model.toml, train.csv, test.csv, rest.csv}` for every item not of the detection limit.
///
/// # Errors
/// A file cannot be written.
pub fn export(folder: &Path, items: &[Item]) -> io::Result<usize> {
    let mut written = 0;
    for item in items.iter().filter(|i| i.detection.is_none()) {
        let case = set(item.class, item.seed, &item.options());
        let own = folder.join(&case.id);
        fs::create_dir_all(&own)?;
        let Paper {
            declared,
            train,
            test,
            rest_s,
        } = &case.paper;
        fs::write(own.join("model.toml"), declared.to_toml())?;
        fs::write(own.join("train.csv"), csv(train))?;
        fs::write(own.join("test.csv"), csv(test))?;
        let mut rest = String::from("from_s,to_s\n");
        for (from, to) in rest_s {
            let _ = writeln!(rest, "{from},{to}");
        }
        fs::write(own.join("rest.csv"), rest)?;
        written += 1;
    }
    Ok(written)
}

fn csv(record: &Record) -> String {
    let mut text = String::from("time_s,command_mm,displacement_mm,force_n\n");
    for i in 0..record.time_s.len() {
        let _ = writeln!(
            text,
            "{:.4},{:.6},{:.6},{:.5}",
            record.time_s[i], record.command_mm[i], record.displacement_mm[i], record.force_n[i]
        );
    }
    text
}
