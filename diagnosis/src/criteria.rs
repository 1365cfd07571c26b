//! Every threshold of a decision, each with its reason: here those that stages share, in the folder those of one stage; those of the
//! engine stand in its files. What only sets a computation's effort or accuracy stands beside it.

pub mod actuator;
pub mod coordinates;
pub mod records;
pub mod specimen;

/// Contiguous blocks of the training data; each is left out once. Fewer leave too little to learn from, more are shorter
/// than what a rig remembers.
pub const BLOCKS: usize = 6;
/// Declared parameters are held within so many tolerances.
pub const REACH: f64 = 3.0;

/// Cut-offs that are tried.
pub const CUTOFFS: usize = 10;
/// The lowest, and no cut-off below so many times the band of a span, a held-out one's own too: its accelerations would be missing.
pub const BAND_ROOM: f64 = 1.3;
/// The lowest cut-off within this of the best is taken: what it leaves out is noise.
pub const CUTOFF_ROOM: f64 = 1.03;
/// No cut-off at which the declared model, held within its tolerances, leaves so many times the squares that it leaves at its
/// best one: noise in an acceleration grows with the fifth power of the cut-off in squares, an element that is missing does not.
pub const CUTOFF_HOLDS: f64 = 3.0;
/// Share of the speed's power that ends the band of the motion.
pub const BAND_POWER: f64 = 0.9;

/// Samples that a search makes do with, as long as they show the band: averages of neighbours lose nothing else.
pub const SEARCHED: usize = 6000;
/// Samples a cycle of the cut-off that averaging leaves.
pub const A_CYCLE: f64 = 4.0;
/// No more samples than these are searched.
pub const MOST_SEARCHED: usize = 16_000;

/// Yield below this share of half the range: the elastic part is the give of a contact, the element is friction.
pub const FRICTION_YIELD: f64 = 0.04;
/// The same for friction that drops with speed.
pub const STRIBECK_YIELD: f64 = 0.06;
/// Exponents of speed: below the first friction, below the second viscous, above it quadratic.
pub const EXPONENTS: [f64; 2] = [0.25, 1.25];
/// Exponent of friction in series with a spring below which it is a damper there: 1 is Maxwell's, its reciprocal is the damper's
/// own, as in [`EXPONENTS`]: fluid dampers have 0.3 to 1 (Symans and Constantinou, 1998).
pub const RELAXES: f64 = 1.0 / EXPONENTS[0];
/// A force that saturates below this share of the top speed is friction.
pub const FRICTION_SPEED: f64 = 0.08;

/// A name takes at least this share off the held-out error: less is within what two runs of one test differ by.
pub const WORTH_A_NAME: f64 = 0.05;
/// Two causes are told apart where the wrong one leaves so many times the squares.
pub const CERTAIN: f64 = 2.0;
/// Expected share of false names that were given without a probability.
pub const LEAST_SURE: f64 = 0.4;
/// Expected share of false names of a line that stands in the rest.
pub const FALSE_LINES: f64 = 0.04;
/// A set of more names says nothing.
pub const LARGEST_SET: usize = 5;
/// Two causes cannot be told apart whose forces differ by less than this many variances of the noise, all samples taken
/// together: on simulated pairs 10 of 12 sets are complete then and 1 of 38 single effects gets a needless rival.
pub const INSEPARABLE: f64 = 100.0;
/// What leaves no more than this share of the rms accounts for the record.
pub const ACCOUNTS: f64 = 0.3;
/// So many times a known noise are the noise.
pub const NOISE: f64 = 1.3;
/// What leaves more than so many times a noise that a rest has told does not account for the record, however much it took.
pub const BESIDE_NOISE: f64 = 3.0;
/// Yield, over half the range, up to which hysteresis may be the give of a sliding contact: a lip seal gives tenths of a
/// millimetre, a fifth of a stroke of a few, and friction that gives smoothly (Dahl's law) is Bouc-Wen's equation with
/// equal rates out and back. Between this and [`FRICTION_YIELD`] friction and hysteresis are a set, whichever fits.
pub const MAY_BE_FRICTION: f64 = 0.2;
/// The same where the equation is Dahl's: its force comes near its end only after three times the give, so that half of a
/// half range is still a motion that hardly slides.
pub const MAY_BE_BRISTLES: f64 = 0.5;
/// Exponent below which a Bouc-Wen element may be Dahl's friction, whose exponent is 1.
pub const BRISTLES: f64 = 1.5;
/// A set whose model leaves more than this share of the held-out error says nothing: anything takes off a little.
pub const SET_LEAVES: f64 = 0.6;

/// Share of the power of the speed that one frequency must hold to be the only one: a second one of a sixth of its speed is
/// enough to tell stiffness from mass.
pub const ONE_FREQUENCY: f64 = 0.97;
/// Share of the moving time that must pass at the usual speed of its direction: a sine spends a fifth of it there.
pub const ONE_SPEED: f64 = 0.75;
/// Speeds within this share of each other are one: the forces of friction and of a damper differ by less than a law of
/// either holds to.
pub const SAME_SPEED: f64 = 0.15;
/// Share of the way that goes one way where there is but one.
pub const ONE_WAY: f64 = 0.97;
/// Share of its range by which a motion may cross zero and still stay on one side.
pub const ONE_SIDE: f64 = 0.05;
/// Phase of the declared lag at the end of the band, rad, below which a lag is a delay: they differ by half of that share.
pub const SLOW: f64 = 0.1;
/// Share of the squares of what is left that lines of other than the motion's frequencies hold where it is no noise.
pub const LINES: f64 = 0.3;
/// Where a linear model of any order makes less than this share of an output's squares, most of it comes from elsewhere.
pub const LITTLE: f64 = 0.5;
/// What a declared model leaves below this share of the force is within the class of a good load cell (0.5, ISO 7500-1):
/// where no element is worth its penalty nothing is missing that could be asked about.
pub const TRANSDUCER: f64 = 0.005;
/// The same of a displacement (0.1, a good LVDT). A rest tells the noise of a transducer, not how straight it is.
pub const DISPLACEMENT_TRANSDUCER: f64 = 0.001;
/// What delay, lag and load leave of an ordinary position loop, of its motion: valve, oil and seals are of a higher order. Of a hundred
/// sound rams that were simulated with all of them none left more than 0.002.
pub const POSITION_LOOP: f64 = 0.0025;
/// A rest that is so many times as loud as samples of the same motion differ by is none: that figure is within a third.
pub const LOUD_REST: f64 = 2.0;
/// A channel that moves by so many times what its samples differ by from a smooth curve does not stand still: low-passed noise
/// comes to three.
pub const SWINGS: f64 = 5.0;
/// No verdict of `none` where the declared model leaves this share of the output's standard deviation, whatever the noise is
/// said to be: a noise that is half of what is read hides what is missing.
pub const MOST_OF_IT: f64 = 0.5;
/// Of the noise, what steps must make at least to be most of it.
pub const IN_STEPS: f64 = 0.8;
/// How far, in steps, a reading may be from the truth: half of one, if it is not quite even.
pub const WITHIN: f64 = 0.7;
