//! Tests of a rig whose interface two coupled actuators move in x and in rotation: `[coupled]` of a test file.
//!
//! | look in | for |
//! |---|---|
//! | [`table`] | what the table holds |
//! | [`load`] | from a file to a test, and to a test on a ground motion |
//! | [`file`](mod@file) | a whole test file of this kind |
//! | [`experiment`] | a test on a ground motion |
//! | [`settings`] | the same as the settings of core's loop |
//! | [`trial`] | the test on the simulated rig, and its ideal |
//! | [`trace`] | what it leaves: every quantity in both systems of coordinates |
//! | [`summary`] | the figures and the verdict |
//! | [`planned`] | whether it may be run: limits, and rigs that differ |

pub mod experiment;
pub mod file;
pub mod load;
pub mod planned;
pub mod settings;
pub mod summary;
pub mod table;
pub mod trace;
pub mod trial;
