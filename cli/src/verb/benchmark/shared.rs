//! What both benchmarks need.

use crate::terminal::{Progress, interrupt};
use experiment::failure::Failure;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// A benchmark that cannot be run.
pub(super) fn refused(why: benchmarks::Refused) -> Failure {
    Failure::input(why.to_string())
}

/// The ground motions of both problems.
pub(super) const RECORDS: [&str; 3] = ["ElCentro", "Kobe", "Morgan"];

/// Tells a bar of trials that are done; work goes on until Ctrl-C.
pub(super) fn tell(progress: &Progress, trials: usize) -> ControlFlow<()> {
    progress.add(trials as u64);
    match interrupt::asked() {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    }
}

/// That there is something to report.
pub(super) fn require_some(rows: usize) -> Result<(), Failure> {
    match rows {
        0 => Err(Failure::test(
            "interrupted before the first row was whole: nothing is reported",
        )),
        _ => Ok(()),
    }
}

/// Refuses more drawn plants than anybody waits for.
pub(super) fn check_plants(plants: usize) -> Result<(), Failure> {
    if plants > 1000 {
        let sentence = format!("--plants {plants}: accepted are 0 to 1000");
        return Err(Failure::input(sentence));
    }
    Ok(())
}

/// Where a third-party file should be, by its path in the folder of data: as given, else `OUTERLOOP_DATA`, else beside the
/// checkout.
pub(super) fn data_file(given: Option<&Path>, path: &str) -> PathBuf {
    let folder = given.map(Path::to_owned).unwrap_or_else(|| {
        std::env::var_os("OUTERLOOP_DATA").map_or_else(|| "../shared/data".into(), PathBuf::from)
    });
    folder.join(path)
}
