//! A record as it was taken: its samples and stamps, its rests, its band, and what it refuses.

pub mod converter_step;
pub mod identify;
pub mod recording;
pub mod refusal;
pub mod rest;
pub mod spectrum;
pub mod stamps;
pub mod travel;
pub mod unmeasured;
