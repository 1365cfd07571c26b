//! Whole tests across crates. One binary: each one links everything.
#![allow(missing_docs)]

mod benchmark_targets;
mod board_coupled;
mod board_desk;
mod board_incidents;
mod board_link;
mod board_of_three;
mod board_served;
mod comparison_table;
mod energy_balance;
mod marths_frame;
mod methods;
mod noise;
mod other_versions;
mod paper_figures;
mod proof_table;
mod recipes;
mod releases;
mod rths_baseline;
mod stability;
mod storeys;
mod surveys;
mod tangent_force;
mod tiers;
