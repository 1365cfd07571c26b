//! Diagnoses of whole sets of records: of exams, and by third parties.
#![allow(missing_docs)]

mod drawn_records;
mod exam_quick;
mod exam_scorer;
mod next_errors;
mod other_channels;
mod outside_records;
mod real_records;
