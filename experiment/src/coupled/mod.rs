//! Tests of a rig whose interface two coupled actuators move in x and in rotation: `[coupled]` of a test file.
//!
//! | look in | for |
//! |---|---|
//! | [`table`] | what the table holds |
//! | [`part`] | what only a test file of this kind has |
//! | [`settings`] | the same as the settings of core's loop |
//! | [`ideal`] | the motion with actuators that are where they are sent |
//! | [`interface`] | what its record has beside that of others, and sums over it: both systems of coordinates |
//! | [`figures`] | the figures that only such a test has |
//! | [`planned`] | whether it may be run: limits, and rigs that differ |
//! | [`stop`] | whether it can be stopped where it is fastest |

pub mod figures;
pub mod ideal;
pub mod interface;
pub mod part;
pub mod planned;
pub mod settings;
mod stop;
pub mod table;
