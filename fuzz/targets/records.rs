//! Records and ground motions in CSV files of every kind that can be read.
#![no_main]

use experiment::files::columns::Columns;
use experiment::files::ground_motion::{ColumnChoice, GroundMotionFile};
use experiment::files::recording::SiRecording;
use fuzz::file_of;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let file = file_of(bytes, "csv");
    let _ = SiRecording::load(&file);
    let _ = SiRecording::load_with_any_time(&file, &Columns::default());
    let _ = GroundMotionFile::load(&file, ColumnChoice::default());
});
