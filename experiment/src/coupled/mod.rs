//! Tests of a rig with an interface moved in x and rotation by two coupled actuators: `[coupled]` of a test file.
//!
//! | look in | for |
//! |---|---|
//! | [`table`] | the contents of the table |
//! | [`part`] | the contents specific to such a test file |
//! | [`settings`] | the same as the settings of core's loop |
//! | [`ideal`] | the motion with ideal actuators |
//! | [`interface`] | the additional contents of its record, and sums over it: both systems of coordinates |
//! | [`figures`] | the figures specific to such a test |
//! | [`drawn`] | rigs that are drawn around the one of the file |
//! | [`margins`] | how much later and stronger its loop may become |
//! | [`planned`] | whether it may be run: limits, and rigs that differ |
//! | [`stop`] | whether it can be stopped at its fastest |

pub(crate) mod drawn;
pub mod figures;
pub mod ideal;
pub mod interface;
pub mod margins;
pub mod part;
pub mod planned;
pub mod settings;
mod stop;
pub mod table;
