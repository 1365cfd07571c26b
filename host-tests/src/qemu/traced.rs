//! The steps of a test, instruction by instruction.

use super::bench::{Records, Script, drive, solved};
use super::cycles::{Code, Course};
use super::machine::{Clock, Machine, Test};
use outerloop_core::Sample;
use std::io::{Error, Result};
use std::path::Path;

/// Runs `ticks` control periods with the image in QEMU; returns the steps in which an integration step was solved.
///
/// # Errors
/// As [`every`].
///
/// # Panics
/// As [`every`].
pub fn traced<const N: usize>(
    image: &Path,
    code: &Code,
    test: &Test<'_>,
    ticks: u32,
    script: Script<'_>,
    rig: impl FnMut(&[f32; N]) -> Sample<N>,
) -> Result<Vec<Course>> {
    let (courses, records) = every(image, code, test, ticks, script, rig)?;
    assert_eq!(courses.len(), records.len(), "a step each period");
    let courses = courses.into_iter().zip(&records);
    let courses = courses.filter(|(_, words)| solved(words));
    Ok(courses.map(|(course, _)| course).collect())
}

/// Runs `ticks` control periods with the image in QEMU; returns every run of the measured code, and all records.
///
/// # Errors
/// The test is refused, or the emulator or the image in it has ended.
pub fn every<const N: usize>(
    image: &Path,
    code: &Code,
    test: &Test<'_>,
    ticks: u32,
    script: Script<'_>,
    rig: impl FnMut(&[f32; N]) -> Sample<N>,
) -> Result<(Vec<Course>, Records)> {
    let filter = code.filter();
    let mut machine = Machine::<N>::start_filtered(image, Clock::Tracing, Some(&filter))?;
    let trace = machine.trace().ok_or(Error::other("there is no trace"))?;
    let (courses, records) = std::thread::scope(|scope| {
        let reader = scope.spawn(|| code.steps(trace));
        machine.begin(test)?;
        let records = drive::<N>(test, ticks, script, rig, |command, sample| {
            let (answer, words) = machine.period(command, sample)?;
            Ok((answer.command_m, words))
        })?;
        machine.end()?;
        let courses = reader.join().map_err(|_| Error::other("the reader"))??;
        Ok::<_, Error>((courses, records))
    })?;
    Ok((courses, records))
}
