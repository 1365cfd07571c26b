//! The declaration of a served rig: an element of the client's model.

use experiment::coupled::part::CoupledPart;
use experiment::failure::Failure;
use experiment::files::serve::Settings;
use experiment::files::test::TestFile;
use outerloop_core::Pace;

/// The declaration of the rig.
#[derive(Clone, Debug)]
pub struct DeclaredElement {
    pub(super) settings: Settings,
    /// Row by row, N/m; for two actuators on one coupler also N/rad and so on.
    pub(super) stiffness: Vec<f64>,
    pub(super) coordinates: Vec<Coordinate>,
    pub(super) model_step_s: f64,
    pub(super) rate_hz: f64,
}

/// A degree of freedom of the element.
#[derive(Clone, Debug)]
pub(super) struct Coordinate {
    /// Its name, which ends with its unit; only for two actuators on one coupler.
    pub name: Option<String>,
    /// The largest target, in `unit`.
    pub limit: f64,
    /// The key with this limit.
    pub limit_key: &'static str,
    /// m or rad.
    pub unit: &'static str,
    /// m or rad per unit on the wire.
    pub displacement_per_wire: f64,
    /// N or N m per unit on the wire.
    pub force_per_wire: f64,
}

impl DeclaredElement {
    /// From a test file.
    ///
    /// # Errors
    /// A test that cannot be served: without limits, with storeys or coordinates that exist only in the computer, or,
    /// where the rig moves continuously, without time for the model.
    pub fn of(test: &TestFile) -> Result<Self, Failure> {
        let coordinates = match &test.coupled {
            None => storeys(test)?,
            Some(part) => interface(test, part)?,
        };
        Ok(Self {
            settings: test.serve,
            stiffness: declared_stiffness(test),
            coordinates,
            model_step_s: test.config.model_step_s(),
            rate_hz: test.config.timing.rate_hz,
        })
    }

    /// The stiffness matrix, row by row, in the units of the wire.
    pub(super) fn stiffness_on_wire(&self) -> Vec<f64> {
        let n = self.coordinates.len();
        let entries = self.stiffness.iter().enumerate();
        let on_wire = entries.map(|(place, k)| {
            let (row, column) = (&self.coordinates[place / n], &self.coordinates[place % n]);
            k * column.displacement_per_wire / row.force_per_wire
        });
        on_wire.collect()
    }
}

fn refuse<T>(what: impl Into<String>) -> Result<T, Failure> {
    Err(Failure::input(what.into()))
}

/// For a frame each of whose storeys has its own actuator.
fn storeys(test: &TestFile) -> Result<Vec<Coordinate>, Failure> {
    let c = &test.config;
    let storeys = c.degrees_of_freedom();
    if c.physical_storeys() != storeys {
        return refuse(
            "serve: structure.physical_storeys is below the number of floors: accepted is a rig of which every storey \
             stands in the laboratory, since the rest of the structure is the client's",
        );
    }
    let Some(limit) = c.limits.displacement_m else {
        return refuse(
            "serve: limits.displacement_m is missing: accepted is the largest displacement, m, that a client may ask for",
        );
    };
    if c.limits.force_n.is_none() {
        return refuse(
            "serve: limits.force_n is missing: accepted is the largest force, N, that the specimen may answer with",
        );
    }
    if test.serve.pace == Pace::Continuous && c.timing.solve_substeps == 0 {
        return refuse(
            "serve: loop.solve_substeps is 0 beside serve.pace = \"continuous\": accepted are the control steps in \
             which the model solves its step, 1 to one less than loop.substeps",
        );
    }
    let each = Coordinate {
        name: None,
        limit,
        limit_key: "limits.displacement_m",
        unit: "m",
        displacement_per_wire: test.serve.length_unit.metres(),
        force_per_wire: test.serve.force_unit.newtons(),
    };
    Ok(vec![each; storeys])
}

/// For two actuators on one coupler: x and the rotation of the interface.
fn interface(test: &TestFile, part: &CoupledPart) -> Result<Vec<Coordinate>, Failure> {
    let (serve, limits) = (&test.serve, &part.declared.limits);
    if serve.pace == Pace::Continuous {
        return refuse(
            "serve.pace = \"continuous\" is refused: accepted beside [coupled] is \"stop_and_go\", since its loop has no \
             substeps in which a model could solve its step",
        );
    }
    let names = &part.declared.structure.coordinates;
    let [x, rotation] = names.as_slice() else {
        return refuse(format!(
            "coupled.structure.coordinates has {} names: accepted in a test that is served are 2, x and the rotation, since the \
             rest of the structure is the client's",
            names.len()
        ));
    };
    let (metres, newtons) = (serve.length_unit.metres(), serve.force_unit.newtons());
    Ok(vec![
        Coordinate {
            name: Some(x.clone()),
            limit: limits.x_m,
            limit_key: "coupled.limits.x_m",
            unit: "m",
            displacement_per_wire: metres,
            force_per_wire: newtons,
        },
        Coordinate {
            name: Some(rotation.clone()),
            limit: limits.rotation_rad,
            limit_key: "coupled.limits.rotation_rad",
            unit: "rad",
            displacement_per_wire: 1.0,
            // A moment.
            force_per_wire: newtons * metres,
        },
    ])
}

/// Stiffness of the part in the laboratory, row by row, N/m; for two actuators on one coupler also N/rad, N m/m
/// and N m/rad.
pub fn declared_stiffness(test: &TestFile) -> Vec<f64> {
    match &test.coupled {
        None => shear_frame(&test.config.structure.stiffness_n_per_m),
        Some(part) => part.declared.specimen.stiffness.as_flattened().to_vec(),
    }
}

/// The stiffness matrix of a shear frame, row by row, from the stiffnesses of its storeys.
pub fn shear_frame(storeys: &[f64]) -> Vec<f64> {
    let n = storeys.len();
    let mut matrix = vec![0.0; n * n];
    for (j, k) in storeys.iter().enumerate() {
        matrix[j * n + j] += k;
        if let Some(below) = j.checked_sub(1) {
            matrix[below * n + below] += k;
            matrix[below * n + j] -= k;
            matrix[j * n + below] -= k;
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::shear_frame;

    #[test]
    fn storeys_make_a_shear_frame() {
        assert_eq!(shear_frame(&[158e3]), [158e3]);
        let two = [5.0, -2.0, -2.0, 2.0];
        assert_eq!(shear_frame(&[3.0, 2.0]), two);
    }
}
