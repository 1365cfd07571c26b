//! Every threshold of a decision, with its reason: here those that stages share, in the folder those of a single stage;
//! the engine's are in its own files. Values that only set a computation's effort or accuracy are next to it.

pub mod actuator;
pub mod coordinates;
pub mod records;
pub mod specimen;

/// Contiguous blocks of the training data, each left out once. Fewer leave too little to learn from; more would be
/// shorter than a rig's memory.
pub const BLOCKS: usize = 6;
/// Declared parameters are held within this many tolerances.
pub const REACH: f64 = 3.0;

/// Number of cut-offs tried.
pub const CUTOFFS: usize = 10;
/// The lowest cut-off, as a multiple of any span's band, held-out ones too: below it accelerations are missing.
pub const BAND_ROOM: f64 = 1.3;
/// The lowest cut-off within this factor of the best is used: what it leaves out is noise.
pub const CUTOFF_ROOM: f64 = 1.03;
/// Largest allowed ratio of the declared model's squares, held within its tolerances, to those at its best cut-off: the
/// squares of noise in an acceleration grow with the fifth power of the cut-off, a missing element does not.
pub const CUTOFF_HOLDS: f64 = 3.0;
/// Fraction of the speed's power that defines the end of the motion's band.
pub const BAND_POWER: f64 = 0.9;

/// Number of samples sufficient for a search, if they show the band: averaging neighbours loses nothing else.
pub const SEARCHED: usize = 6000;
/// Samples per cycle of the cut-off after averaging.
pub const A_CYCLE: f64 = 4.0;
/// Largest number of samples searched.
pub const MOST_SEARCHED: usize = 16_000;

/// Yield below this fraction of half the range: the elastic part is a contact's give, so the element is friction.
pub const FRICTION_YIELD: f64 = 0.04;
/// Exponents of speed: below the first friction, below the second viscous, above it quadratic.
pub const EXPONENTS: [f64; 2] = [0.25, 1.25];
/// Exponent of friction in series with a spring below which it is a damper: 1 is Maxwell's, its reciprocal is the
/// damper's own, as in [`EXPONENTS`]: fluid dampers have 0.3 to 1 (Symans and Constantinou, 1998).
pub const RELAXES: f64 = 1.0 / EXPONENTS[0];
/// Relaxation of a damper's own oil and clevises, relative to the time for half of the motion's range: a fluid damper
/// relaxes in 6 ms (Constantinou and Symans, 1993), a quarter of what a motion of 6 Hz takes. Slower than that, it is a
/// dashpot behind a spring.
pub const GIVES: f64 = 0.25;
/// A force that saturates below this fraction of the top speed is friction.
pub const FRICTION_SPEED: f64 = 0.08;

/// A name must remove at least this fraction of the held-out error: two runs of one test may differ by less.
pub const WORTH_A_NAME: f64 = 0.05;
/// Two causes are told apart if the wrong one leaves this multiple of the squares.
pub const CERTAIN: f64 = 2.0;
/// Expected fraction of false names among those given without a probability.
pub const LEAST_SURE: f64 = 0.4;
/// Expected fraction of false names for a line that is present at rest.
pub const FALSE_LINES: f64 = 0.04;
/// Expected fraction of false names for a loop that swings by itself: a valve that became slow makes it swing, too.
pub const FALSE_SWINGS: f64 = 0.1;
/// A set with more names says nothing.
pub const LARGEST_SET: usize = 5;
/// Two causes cannot be told apart if their forces differ by less than this many variances of the noise, over all
/// samples: on simulated pairs 10 of 12 sets are complete then and 1 of 38 single effects gets a needless rival.
pub const INSEPARABLE: f64 = 100.0;
/// A residual of at most this fraction of the rms accounts for the record.
pub const ACCOUNTS: f64 = 0.3;
/// A residual up to this multiple of a known noise is noise.
pub const NOISE: f64 = 1.3;
/// A residual above this multiple of a noise determined by a rest does not account for the record in any case.
pub const BESIDE_NOISE: f64 = 3.0;
/// Largest yield, relative to half the range, at which hysteresis may be the give of a sliding contact: a lip seal
/// gives tenths of a millimetre, a fifth of a stroke of a few. Smooth friction (Dahl's law) is Bouc-Wen's equation with
/// equal rates out and back. Between this and [`FRICTION_YIELD`] friction and hysteresis form a set, whichever fits.
pub const MAY_BE_FRICTION: f64 = 0.2;
/// The same for Dahl's equation: its force nears its limit only after three times the give, so even half of a half
/// range hardly slides.
pub const MAY_BE_BRISTLES: f64 = 0.5;
/// Exponent below which a Bouc-Wen element may be Dahl's friction, whose exponent is 1.
pub const BRISTLES: f64 = 1.5;
/// A set whose model leaves more than this fraction of the held-out error says nothing: anything removes a little.
pub const SET_LEAVES: f64 = 0.6;

/// Fraction of the speed's power that one frequency must hold to be the only one: a second one with a sixth of its
/// speed is enough to tell stiffness from mass.
pub const ONE_FREQUENCY: f64 = 0.97;
/// Fraction of the moving time at its direction's usual speed for a motion of one speed: a sine spends a fifth there.
pub const ONE_SPEED: f64 = 0.75;
/// Speeds within this fraction of each other count as one: the forces of friction and a damper then differ by less than
/// either law is accurate.
pub const SAME_SPEED: f64 = 0.15;
/// Fraction of the travel that goes one way if the motion counts as one-way.
pub const ONE_WAY: f64 = 0.97;
/// Fraction of its range by which a motion may cross zero and still count as on one side.
pub const ONE_SIDE: f64 = 0.05;
/// Phase of the declared lag at the band's end, rad, below which a lag acts as a delay: they differ by half that share.
pub const SLOW: f64 = 0.1;
/// Fraction of the residual squares in lines at other than the motion's frequencies above which it is not noise.
pub const LINES: f64 = 0.3;
/// If a linear model of any order explains less than this fraction of an output's squares, most of it has other causes.
pub const LITTLE: f64 = 0.5;
/// A declared model's residual below this fraction of the force is within the class of a good load cell (0.5, ISO
/// 7500-1): if no element is worth its penalty, nothing that could be named is missing.
pub const TRANSDUCER: f64 = 0.005;
/// The same for a displacement (0.1, a good LVDT). A rest shows a transducer's noise, not its linearity.
pub const DISPLACEMENT_TRANSDUCER: f64 = 0.001;
/// Residual of delay, lag and load in an ordinary position loop, relative to its motion: valve, oil and seals are of a
/// higher order. Of a hundred simulated sound rams with all of them none left more than 0.002.
pub const POSITION_LOOP: f64 = 0.0025;
/// A rest louder than this multiple of the differences between like samples is none: that figure is good to a third.
pub const LOUD_REST: f64 = 2.0;
/// A channel that moves by more than this multiple of its samples' deviation from a smooth curve is not at rest:
/// low-passed noise reaches three.
pub const SWINGS: f64 = 5.0;
/// No verdict of `none` if the declared model leaves this fraction of the output's standard deviation, whatever the
/// stated noise: noise that is half of the reading hides what is missing.
pub const MOST_OF_IT: f64 = 0.5;
/// Smallest fraction of the noise for converter steps to be most of it.
pub const IN_STEPS: f64 = 0.8;
/// Largest deviation of a reading from the truth, in steps: half a step, allowing for uneven ones.
pub const WITHIN: f64 = 0.7;
