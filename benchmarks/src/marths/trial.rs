//! The closed loop under a ground motion, and its trace.
//!
//! The order within a sample: the strokes are read; the controller estimates where the actuators are; the frame responds to
//! that; the numerical part takes the force and the ground's acceleration of the same sample and gives the target; the
//! controller commands, and the command is held until the next sample. The plant never responds to a command within the same
//! sample, so no equations have to be solved.

use super::contestants::{Calibration, PairContestant};
use super::controller::TargetSample;
use super::frame::{InterfaceFrame, Resistance};
use super::rig::{ActuatorParameters, COUPLER, Channels, at_rest};
use super::structure::{
    FREE_ROTATION, FrameMatrices, Newmark, PhysicalMatrices, ROTATION, STOREYS, X,
};
use super::{RATE_HZ, SIGN};
use crate::Refused;

/// The trace of a trial, one value for each sample. Rotations are in the rig's sign unless stated otherwise.
#[derive(Clone, Debug, Default)]
pub struct MarthsTrace {
    /// Targets as strokes, m.
    pub target_m: Vec<[f64; 2]>,
    /// Strokes as read, m.
    pub read_m: Vec<[f64; 2]>,
    /// True strokes, m.
    pub stroke_m: Vec<[f64; 2]>,
    /// x (m) and rotation (rad) of the numerical part.
    pub numerical: Vec<[f64; 2]>,
    /// x (m) and rotation (rad) as the controller's block estimates them.
    pub interface: Vec<[f64; 2]>,
    /// Force (N) and moment (N m) of the frame, in the rig's sign.
    pub force: Vec<[f64; 2]>,
    /// The numerical part's rotation that nothing controls, rad, in the structure's sign.
    pub free_rotation: Vec<f64>,
    /// x of the second and third storey, m.
    pub storeys_m: Vec<[f64; 2]>,
    /// Share of the samples in which a command was at its limit.
    pub limited: f64,
}

/// Position of the interface for given strokes, m and rad.
pub(super) fn interface(stroke_m: [f64; 2]) -> [f64; 2] {
    COUPLER
        .interface(&stroke_m.map(|x| x as f32))
        .map(f64::from)
}

/// Strokes for a position of the interface.
fn strokes_m([x, rotation]: [f64; 2]) -> [f64; 2] {
    COUPLER.strokes_m(x as f32, rotation as f32).map(f64::from)
}

/// A structure under the ground motion without a rig, completely computed.
///
/// # Errors
/// A structure that cannot be integrated.
pub fn computed(matrices: &FrameMatrices, ground: &[f64]) -> Result<MarthsTrace, Refused> {
    let mut newmark = Newmark::new(matrices)?;
    let mut trace = MarthsTrace::default();
    for &g in ground {
        newmark.step(g, [0.0; 2]);
        trace.record_target(&newmark);
    }
    Ok(trace)
}

/// The same for a numerical part whose laboratory frame follows it without error or delay.
///
/// # Errors
/// A structure that cannot be integrated.
pub fn without_error(numerical: &FrameMatrices, ground: &[f64]) -> Result<MarthsTrace, Refused> {
    let frame = PhysicalMatrices::of_two(&InterfaceFrame::published().in_structure());
    let mut newmark = Newmark::new(&numerical.plus(&frame))?;
    newmark.shake(numerical);
    let mut trace = MarthsTrace::default();
    for &g in ground {
        newmark.step(g, [0.0; 2]);
        trace.record_target(&newmark);
    }
    Ok(trace)
}

/// A contestant's trial on a plant; `noise` multiplies the published noise, which is drawn with `seed`.
///
/// # Errors
/// A numerical part that cannot be integrated.
pub fn run(
    contestant: PairContestant,
    calibration: &Calibration,
    numerical: &FrameMatrices,
    plant: &ActuatorParameters,
    ground: &[f64],
    (seed, noise): (u64, f64),
) -> Result<MarthsTrace, Refused> {
    let mut controller = calibration.controller(contestant);
    let mut newmark = Newmark::new(numerical)?;
    let mut resistance = Resistance::new(InterfaceFrame::published());
    let (mut rig, mut channels) = (at_rest(plant), Channels::new(seed, noise));
    let mut trace = MarthsTrace::default();
    let mut limited = 0;
    for &g in ground {
        let stroke_m = match &controller {
            Some(_) => rig.strokes_m(),
            None => trace.target_m.last().copied().unwrap_or_default(),
        };
        let read_m = channels.read(stroke_m);
        let block_m = controller.as_mut().map_or(read_m, |c| c.observe(read_m));
        let at = interface(block_m);
        let force = resistance.step(at);
        newmark.step(g, [force[0], SIGN * force[1]]);
        trace.read_m.push(read_m);
        trace.stroke_m.push(stroke_m);
        trace.interface.push(at);
        trace.force.push(force);
        let target = trace.record_target(&newmark);
        if !target.interface.iter().all(|x| x.abs() < LOST) {
            break;
        }
        if let Some(controller) = &mut controller {
            let (sent, at_limit) = channels.send(controller.command(&TargetSample {
                ground_m_per_s2: g,
                ..target
            }));
            limited += usize::from(at_limit);
            rig.step(sent);
        }
    }
    trace.limited = limited as f64 / ground.len().max(1) as f64;
    Ok(trace)
}

/// A target beyond this, m or rad, means that the loop ran away.
const LOST: f64 = 1.0;

impl MarthsTrace {
    /// Records the state of the numerical part and returns it as a target.
    fn record_target(&mut self, newmark: &Newmark) -> TargetSample {
        let interface = [newmark.at(X), SIGN * newmark.at(ROTATION)];
        let stroke_m = strokes_m(interface);
        self.numerical.push(interface);
        self.target_m.push(stroke_m);
        self.free_rotation.push(newmark.at(FREE_ROTATION));
        self.storeys_m.push(STOREYS.map(|s| newmark.at(s)));
        TargetSample {
            interface,
            stroke_m,
            ground_m_per_s2: 0.0,
        }
    }

    /// True if it reached the end of the record with finite values.
    pub fn is_whole(&self, ground: &[f64]) -> bool {
        self.numerical.len() == ground.len()
            && self.numerical.iter().flatten().all(|x| x.is_finite())
    }

    /// Its length, s.
    pub fn duration_s(&self) -> f64 {
        self.numerical.len() as f64 / RATE_HZ
    }
}
