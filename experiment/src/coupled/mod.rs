//! Tests of a rig whose interface two coupled actuators move in x and in rotation: `[coupled]` of a test file.
//!
//! | look in | for |
//! |---|---|
//! | [`table`] | what the table holds |
//! | [`part`] | what only a test file of this kind has |
//! | [`settings`] | the same as the settings of core's loop |
//! | [`ideal`] | the motion with actuators that are where they are sent |
//! | [`trial`] | the test on the simulated rig |
//! | [`trace`] | what it leaves: every quantity in both systems of coordinates |
//! | [`summary`] | the figures and the verdict |
//! | [`planned`] | whether it may be run: limits, and rigs that differ |

pub mod ideal;
pub mod part;
pub mod planned;
pub mod settings;
pub mod summary;
pub mod table;
pub mod trace;
pub mod trial;
