//! Thresholds of the search among single effects against a known noise, each with its reason.

// What is enough, and what is too much to be left.

/// Smallest structured rms that matters, in noise rms.
pub const MATTERS: f64 = 0.3;
/// Smallest structured rms that alarms where nothing accounts for any of it.
pub const ALARMS: f64 = 0.5;
/// Smallest rms that an effect must explain, in noise rms.
pub const EXPLAINS: f64 = 0.15;
/// Least fall of the Bayesian information criterion.
pub const EVIDENCE: f64 = 30.0;
/// Within this much of it two explanations are equally good.
pub const EQUAL: f64 = 10.0;
/// The noise is known from a rest of a second or two, to some percent.
pub const CERTAIN: f64 = 1.05;
/// Explanations are equally good that differ by less than this share of what the better one leaves unexplained.
pub const INDIFFERENT: f64 = 0.1;
/// What leaves no more than this share of the structured rms accounts for it.
pub const ACCOUNTS: f64 = 0.12;
/// Share of what it explains that an effect computed from a reading may leave for the reading's noise: some
/// thousandths of its rms, squared.
pub const READING: f64 = 3e-5;
/// Largest share of the structured rms that may remain.
pub const REMAINS: f64 = 0.3;
/// A second effect must explain this share of the original structured rms.
pub const SECOND: f64 = 0.2;
/// Samples a second that a screening makes do with: a rig moves far below half of it.
pub const LOOK_HZ: f64 = 250.0;
/// How many leading candidates are fitted to the records as they are.
pub const LEADING: usize = 4;
/// The same beside another effect.
pub const PAIRED: usize = 2;

// When the noise or the steps of a reading are the answer.

/// Up to so many times the noise may be missing in an actuator that is known.
pub const KNOWN: f64 = 0.3;
/// Of the noise, what steps must make at least to be most of it.
pub const IN_STEPS: f64 = 0.8;
/// How far, in steps, a reading may be from the truth: half of one, if it is not quite even.
pub const WITHIN: f64 = 0.7;

// When a name gives way to a simpler cause.

/// Of noise next to nothing lies so many times its rms away.
pub const FAR: f64 = 5.0;
/// Of a limit, what a transducer of class 0.5 may be off.
pub const CLASS: f64 = 0.005;
/// Readings beyond a limit, as a share of those that a model without it has there, that stand against it.
pub const PASS: f64 = 0.01;
