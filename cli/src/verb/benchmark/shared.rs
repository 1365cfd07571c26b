//! Shared by both benchmarks.

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

/// Advances the progress bar by completed trials; work goes on until Ctrl-C.
pub(super) fn tell(progress: &Progress, trials: usize) -> ControlFlow<()> {
    progress.add(trials as u64);
    match interrupt::asked() {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    }
}

/// Checks that there is something to report.
pub(super) fn require_some(rows: usize) -> Result<(), Failure> {
    match rows {
        0 => Err(Failure::test(
            "interrupted before the first row was whole: nothing is reported",
        )),
        _ => Ok(()),
    }
}

/// Refuses an unreasonable number of drawn plants.
pub(super) fn check_plants(plants: usize) -> Result<(), Failure> {
    if plants > 1000 {
        let sentence = format!("--plants {plants}: accepted are 0 to 1000");
        return Err(Failure::input(sentence));
    }
    Ok(())
}

/// Location of a third-party file, by its path in the data folder: the given folder, else `OUTERLOOP_DATA`, else next to
/// the checkout.
pub(super) fn data_file(given: Option<&Path>, path: &str) -> PathBuf {
    let folder = given.map(Path::to_owned).unwrap_or_else(|| {
        std::env::var_os("OUTERLOOP_DATA").map_or_else(|| "../shared/data".into(), PathBuf::from)
    });
    folder.join(path)
}
