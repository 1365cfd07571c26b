//! Records and ground motions in files of every kind that is read: text in any dialect, MAT, HDF5. The content tells the kind, not the
//! name; the refusal of MAT 4 names it.
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
