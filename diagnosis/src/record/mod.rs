//! A record as it was taken: samples and time stamps, rests, band, and reasons to refuse it.

pub mod converter_step;
pub mod identify;
pub mod recording;
pub mod refusal;
pub mod rest;
pub mod spectrum;
pub mod stamps;
pub mod travel;
pub mod unmeasured;
