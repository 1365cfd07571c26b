//! The interface of two coupled actuators in a running test: the additional contents of its record compared with other
//! tests, and the sums over it.

use super::part::CoupledPart;
use crate::observer::{AnyRecord, TestObserver};
use plant::coupled::CouplerSpec;

/// A quantity of both actuators, or of x and rotation.
pub type Both = [Vec<f32>; 2];

/// One control step in both systems of coordinates.
struct BothCoordinates {
    /// Displacements of x and rotation from the readings of the strokes.
    displacement: [f32; 2],
    /// True displacements, on a simulated rig; NaN otherwise.
    truth: [f32; 2],
    /// True strokes, m; NaN as above.
    true_stroke_m: [f32; 2],
    /// Target of each stroke, m.
    wanted_m: [f32; 2],
}

impl BothCoordinates {
    fn of(coupler: &CouplerSpec, r: &AnyRecord<'_>) -> Self {
        let first_two = |x: &[f32]| [0, 1].map(|i| f64::from(x[i]));
        let single = |x: [f64; 2]| x.map(|x| x as f32);
        let strokes_m = r
            .coupled
            .map_or_else(|| first_two(r.displacement_m), |read| read.stroke_m);
        Self {
            displacement: single(coupler.interface(strokes_m)),
            truth: single(r.coupled.map_or([f64::NAN; 2], |read| read.true_interface)),
            true_stroke_m: single(r.coupled.map_or([f64::NAN; 2], |read| read.true_stroke_m)),
            wanted_m: single(coupler.strokes_m(first_two(r.command_m))),
        }
    }
}

/// The additional contents of a record of two coupled actuators, one value per control step. Readings, forces and sent
/// commands of the trace's first two floors are the actuators'; estimates and targets are those of x and rotation.
#[derive(Clone, Debug)]
pub struct InterfaceTrace {
    coupler: CouplerSpec,
    /// Names of the coordinates, with their units.
    pub coordinates: Vec<String>,
    /// Displacements of x and rotation by the readings.
    pub displacement: Both,
    /// True displacements; NaN without a simulated rig.
    pub truth: Both,
    /// True strokes, m; NaN without a simulated rig.
    pub true_stroke_m: Both,
    /// Target of each stroke, m.
    pub wanted_m: Both,
}

impl InterfaceTrace {
    /// Without any step.
    pub fn of(part: &CoupledPart) -> Self {
        Self {
            coupler: part.declared.coupler.clone(),
            coordinates: part.declared.structure.coordinates.clone(),
            displacement: Both::default(),
            truth: Both::default(),
            true_stroke_m: Both::default(),
            wanted_m: Both::default(),
        }
    }

    /// Adds a control step.
    pub(crate) fn push(&mut self, record: &AnyRecord<'_>) {
        let now = BothCoordinates::of(&self.coupler, record);
        for i in 0..2 {
            self.displacement[i].push(now.displacement[i]);
            self.truth[i].push(now.truth[i]);
            self.true_stroke_m[i].push(now.true_stroke_m[i]);
            self.wanted_m[i].push(now.wanted_m[i]);
        }
    }
}

/// Displacement minus target, target, and force of x and rotation at a control step.
#[derive(Clone, Copy, Debug)]
struct AtStep {
    error: [f64; 2],
    target: [f64; 2],
    displacement: [f64; 2],
    force: [f64; 2],
}

/// Sums over a running test of two coupled actuators.
#[derive(Clone, Debug)]
pub struct InterfaceScore {
    coupler: CouplerSpec,
    /// Declared stiffness of the specimen.
    stiffness: [[f64; 2]; 2],
    before: Option<AtStep>,
    /// Energy errors over x and rotation, J: Eq 12, HSEM, Eq 6. Negative if the actuators put energy in.
    pub energy_j: [f64; 3],
    /// Squares of true stroke minus target, and of the target, by actuator, m^2; on a board of the measured stroke.
    off_m2: [[f64; 2]; 2],
    /// Largest rotation of the target, rad.
    pub peak_rotation_rad: f64,
    /// Largest force of each actuator as read, N.
    pub peak_actuator_force_n: [f64; 2],
}

impl InterfaceScore {
    /// Without any step.
    pub fn of(part: &CoupledPart) -> Self {
        Self {
            coupler: part.declared.coupler.clone(),
            stiffness: part.declared.specimen.stiffness,
            before: None,
            energy_j: [0.0; 3],
            off_m2: [[0.0; 2]; 2],
            peak_rotation_rad: 0.0,
            peak_actuator_force_n: [0.0; 2],
        }
    }

    /// Root mean square of true stroke minus target over that of the target, by actuator.
    pub fn tracking_rms(&self) -> [f64; 2] {
        self.off_m2
            .map(|[off, wanted]| (off / wanted.max(f64::MIN_POSITIVE)).sqrt())
    }

    fn add_energy(&mut self, before: &AtStep, now: &AtStep) {
        let elastic = |of: &AtStep, i: usize| {
            self.stiffness[i][0] * of.error[0] + self.stiffness[i][1] * of.error[1]
        };
        for i in 0..2 {
            let step = now.target[i] - before.target[i];
            let force = 0.5 * (now.force[i] + before.force[i]);
            self.energy_j[0] +=
                0.5 * (now.error[i] + before.error[i]) * (now.force[i] - before.force[i]);
            self.energy_j[1] += force * (step - (now.displacement[i] - before.displacement[i]));
            self.energy_j[2] += 0.5 * (elastic(now, i) + elastic(before, i)) * step;
        }
    }
}

impl TestObserver for InterfaceScore {
    fn on_step(&mut self, r: &AnyRecord<'_>) {
        let both = BothCoordinates::of(&self.coupler, r);
        let target = [0, 1].map(|i| f64::from(r.command_m[i]));
        let displacement = both.displacement.map(f64::from);
        let now = AtStep {
            error: [0, 1].map(|i| displacement[i] - target[i]),
            target,
            displacement,
            force: [0, 1].map(|i| f64::from(r.estimated_force_n[i])),
        };
        if let Some(before) = self.before.replace(now) {
            self.add_energy(&before, &now);
        }
        self.peak_rotation_rad = target[1].abs().max(self.peak_rotation_rad);
        for i in 0..2 {
            let wanted = f64::from(both.wanted_m[i]);
            let read_m = f64::from(r.displacement_m[i]);
            let at_m = r.coupled.map_or(read_m, |read| read.true_stroke_m[i]);
            let off = at_m - wanted;
            self.off_m2[i][0] += off * off;
            self.off_m2[i][1] += wanted * wanted;
            let force_n = f64::from(r.force_n[i].abs());
            self.peak_actuator_force_n[i] = force_n.max(self.peak_actuator_force_n[i]);
        }
    }
}
