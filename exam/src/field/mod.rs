//! Rigs as other laboratories record them. They have hydraulics with a valve and an oil column, parallel elements,
//! degradation, pinching, power laws, stiffness lost with the peak or with travel, and coherent disturbances. Motions can be
//! at one speed, at one frequency, slow, one-sided or with pauses. Records can be short with short rests, cut out of mid-motion
//! or without a rest, and have no noise at all or coarse converters. Written from textbooks on friction, dampers and
//! servo-hydraulics:
//!
//! - LuGre friction: Canudas de Wit et al., IEEE TAC 40(3), 1995, 419;
//! - distributed sliders: Iwan, J. Appl. Mech. 33, 1966, 893; Ramberg and Osgood, NACA TN 902, 1943;
//! - degradation by dissipated energy: Baber and Wen, J. Eng. Mech. Div. 107, 1981, 1069;
//! - magnetorheological damper in series with the spring of its oil: Spencer et al., J. Eng. Mech. 123(3), 1997, 230;
//! - valve, oil column and cylinder: Merritt, Hydraulic Control Systems, 1967, chapters 5 and 6;
//! - stiffness lost with the largest displacement so far: Mullins, Rubber Chem. Technol. 42, 1969, 339; Lemaitre, A Course on
//!   Damage Mechanics, 1992, chapter 2;
//! - contact: Hertz, J. reine angew. Math. 92, 1882, 156.
//!
//! [`set_field`] makes one [`Field`] from a seed, [`Truth::mark`] grades what was said about it, and [`Stand::play`] runs
//! another test on its rig.

mod drive;
mod force;
mod hidden;
mod mark;
mod motion;
mod ram;
mod reading;
mod stand;

pub use mark::{Mark, Said, Truth};
pub use motion::{Move, Span};
pub use ram::SOUND_RAM;
pub use stand::{Limits, Stand};

use crate::declared::Parameter;
use crate::draws::Draws;
use crate::fine::rms;
use crate::record::Record;
use drive::Drive;
use force::Cause;
use motion::Plan;
use ram::{Fault, Ram};
use reading::Reading;
use stand::Machine;

/// What the laboratory declares about the one channel of a field record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Believed {
    /// Gain, delay in ms, lag in ms, offset in mm.
    Actuator([Parameter; 4]),
    /// Stiffness in N/mm, damping in N s/mm, mass in kg, offset in N.
    Specimen([Option<Parameter>; 4]),
}

/// A question and its key.
#[derive(Clone, Debug)]
pub struct Field {
    /// Seed and cause.
    pub id: String,
    /// The declared model, for the examinee.
    pub believed: Believed,
    /// The training record, for the examinee. Columns that were not recorded are empty.
    pub train: Span,
    /// The test record, for the examinee.
    pub test: Span,
    /// The key, for the scorer alone.
    pub truth: Truth,
    /// Rms of what noise and converter add to the output of the training record, mm or N.
    pub noise_rms: f64,
    /// Whether a rest was recorded, in the span or before it.
    pub rests: bool,
    /// The rig, for further tests; none for a device.
    pub stand: Option<Stand>,
}

/// Names of all causes, those in the specimen first.
pub fn causes() -> impl Iterator<Item = &'static str> {
    let specimens = Cause::ALL.iter().map(|c| c.name());
    specimens.chain(Drive::ALL.iter().map(|d| d.name()))
}

/// The record of a seed; the causes take turns.
pub fn set_field(seed: u64) -> Field {
    let mut rng = Draws::new(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xF1E1D);
    let all = Cause::ALL.len() + Drive::ALL.len();
    let turn = (seed % all as u64) as usize;
    match Cause::ALL.get(turn) {
        Some(cause) => specimen(seed, *cause, &mut rng),
        None => actuator(seed, Drive::ALL[turn - Cause::ALL.len()], &mut rng),
    }
}

/// Names of the faults of rams.
pub fn faults() -> impl Iterator<Item = &'static str> {
    Fault::ALL.iter().map(|f| f.name())
}

/// The record of a ram under position control. Half of the rams are sound, and the faults take turns. The declared values were
/// identified without a load, with a laboratory's usual tolerances.
pub fn set_ram(seed: u64) -> Field {
    let (mut rng, plan, reading, ram) = ram_of(seed);
    let command = plan.motions(&mut rng).swap_remove(0).x;
    let fitted = ram.identified(&command, &mut rng);
    let tolerances = [0.005, 1.0, 2.0, 0.05];
    let own: [Parameter; 4] = std::array::from_fn(|i| Parameter::new(fitted[i], tolerances[i]));
    let truth = ram.truth();
    let stand = Stand::new(Machine::Ram(ram), reading, &plan);
    field(
        seed,
        Believed::Actuator(own),
        &plan,
        (stand, truth),
        &mut rng,
    )
}

fn ram_of(seed: u64) -> (Draws, Plan, Reading, Ram) {
    let mut rng = Draws::new(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x4A11);
    let plan = Plan::of_rams(&mut rng);
    let reading = Reading::of_rams(&mut rng);
    let ram = Ram::draw(Fault::of(seed), plan.amplitude_mm, plan.speed(), &mut rng);
    (rng, plan, reading, ram)
}

/// What the best-fitting sound ram leaves of the displacement of a seed's ram, over the noise of its reading. A fault that
/// leaves less than the noise cannot be found.
pub fn hidden_by_a_sound_ram(seed: u64) -> f64 {
    let (mut rng, plan, _, ram) = ram_of(seed);
    let command = plan.motions(&mut rng).swap_remove(0).x;
    let sound = ram.sound(plan.speed(), &rng);
    hidden::beyond_sound(&ram, &sound, &command) / set_ram(seed).noise_rms
}

/// A declared value that is wrong by about a tolerance.
fn believed(truth: f64, tolerance: f64, rng: &mut Draws) -> Parameter {
    let off = (0.8 * rng.normal()).clamp(-1.8, 1.8);
    Parameter::new(truth + off * tolerance, tolerance)
}

fn specimen(seed: u64, cause: Cause, rng: &mut Draws) -> Field {
    let plan = Plan::draw(cause.motion(rng), rng);
    let reading = Reading::draw(rng);
    let rig = force::Rig::draw(&plan, cause, rng);
    let believed = {
        let [k, c, m] = rig.linear;
        let reach = rig.linear_force();
        Believed::Specimen([
            Some(believed(k, 0.03 * k, rng)),
            Some(believed(
                c,
                force::DAMPING_KNOWN * c.max(0.01 * rig.damping_unit()),
                rng,
            )),
            (m > 0.0).then(|| believed(m, 0.05 * m, rng)),
            Some(believed(0.0, 0.005 * reach, rng)),
        ])
    };
    let truth = rig.truth(&plan);
    let stand = Stand::new(Machine::Specimen(rig), reading, &plan);
    field(seed, believed, &plan, (stand, truth), rng)
}

fn actuator(seed: u64, cause: Drive, rng: &mut Draws) -> Field {
    let plan = Plan::draw(Move::of_actuators(rng), rng);
    let reading = Reading::draw(rng);
    let rig = drive::Rig::draw(&plan, cause, rng);
    let believed = Believed::Actuator([
        believed(1.0, 0.01, rng),
        believed(rig.declared_ms[0], 0.5, rng),
        believed(rig.declared_ms[1], 0.05 * rig.declared_ms[1], rng),
        believed(0.0, 0.002 * plan.amplitude_mm, rng),
    ]);
    let truth = rig.truth(&plan);
    let stand = Stand::new(Machine::Actuator(rig), reading, &plan);
    field(seed, believed, &plan, (stand, truth), rng)
}

/// Records and cuts the planned motions.
fn field(
    seed: u64,
    believed: Believed,
    plan: &Plan,
    (mut stand, truth): (Stand, Truth),
    rng: &mut Draws,
) -> Field {
    let motions = plan.motions(rng);
    let both = motions.iter().map(|m| stand.read(m, rng));
    let (files, perfect): (Vec<Record>, Vec<Record>) = both.map(|[read, is]| (read, is)).unzip();
    let [train, test] = plan.spans(&files);
    let [is, _] = plan.spans(&perfect);
    let reading = stand.reading;
    Field {
        id: format!("{seed} {} {} {reading:?}", truth.cause, plan.name()),
        believed,
        noise_rms: rms_apart(output(&train.record), output(&is.record)),
        rests: plan.rests(),
        train,
        test,
        truth: Truth {
            steps: reading.has_steps(),
            ..truth
        },
        stand: Some(stand),
    }
}

/// The output that a model has to explain.
fn output(record: &Record) -> &[f64] {
    if record.force_n.is_empty() {
        &record.displacement_mm
    } else {
        &record.force_n
    }
}

/// Rms of the difference of two signals.
pub fn rms_apart(a: &[f64], b: &[f64]) -> f64 {
    rms(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>())
}
