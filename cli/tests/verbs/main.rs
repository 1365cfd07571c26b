//! Each verb as people and scripts call it, in one binary; tests that depend on real time are in others.
#![allow(missing_docs)]

#[path = "../common/mod.rs"]
mod common;

mod archive;
mod benchmark_marths;
mod benchmark_rths;
mod check;
mod command_line;
mod coupled;
mod diagnose;
mod diff;
mod documents;
mod exit_status;
mod formats;
mod identify;
mod improve;
mod keys;
mod links;
mod narrow;
mod outputs;
mod refusals;
mod reports;
mod shell;
mod sweep;
mod tutorial;
