//! The departures of a rig from an ideal one: one row per quantity, used by everything that handles it.
//!
//! | look in | for |
//! |---|---|
//! | this file | the rows, and how the simulated rig has them |
//! | [`cause`] | what a model says about them, each thing once |
//! | [`declared`] | what a laboratory declares, and the simulated rig as it would be if that were true |
//! | [`improvement`] | what the loop does about them |

pub mod cause;
pub mod declared;
pub mod improvement;

use diagnosis::{ActuatorModel, Declared, SpecimenModel};
use outerloop_core::Config;
use outerloop_core::config::{Filter, PerActuator, RigConfig};
use plant::Channel::{Actuator, Specimen};
use plant::{Channel, Effect, EffectSpec, RigSpec};
use std::ops::{Index, IndexMut};

/// The properties of a quantity.
pub struct QuantityRow {
    /// Its key in the simulated rig's table.
    name: &'static str,
    /// Its value on an ideal rig: 1 for a gain, else 0.
    ideal: f64,
    /// The effect that is its error, and that effect's parameter.
    error: Option<(Channel, Effect, &'static str)>,
    /// Its value in the table of a simulated rig, for one axis.
    simulated: fn(&RigSpec, usize) -> f64,
    /// Sets it in a simulated rig.
    simulate: fn(&mut RigSpec, f64),
    /// A model's statement about it.
    declared: fn(&ActuatorModel, &SpecimenModel) -> Option<Declared>,
    /// The loop's correction: its unit per unit of the quantity, its place in the loop's configuration, and a sentence.
    correction: Option<Correction>,
}

type Correction = (
    f64,
    fn(&mut RigConfig) -> &mut PerActuator,
    fn(f64) -> String,
);

macro_rules! rows {
    ($($(#[$doc:meta])* $quantity:ident $name:literal $ideal:literal {
        $(error: $error:expr,)?
        simulated: ($($simulated:tt)+),
        $(declared: $declared:expr,)?
        $(correction: $correction:expr,)?
    })*) => {
        /// A quantity in which a rig departs from an ideal one.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Quantity { $($(#[$doc])* $quantity,)* }

        /// One row for each, in order.
        const ROWS: &[(Quantity, QuantityRow)] = &[$((Quantity::$quantity, QuantityRow {
            name: $name,
            ideal: $ideal,
            error: or!($(Some($error),)? None),
            simulated: get!($($simulated)+),
            simulate: set!($($simulated)+),
            declared: or!($($declared,)? |_, _| None),
            correction: or!($(Some($correction),)? None),
        }),)*];
    };
}

/// The first one given.
macro_rules! or {
    ($first:expr $(, $_other:expr)?) => {
        $first
    };
}

/// Where a simulated rig has a quantity: in a key, in a key with one value per axis, or elsewhere, by two functions.
macro_rules! get {
    ($part:ident.$key:ident) => {
        |rig, _| rig.$part.$key
    };
    (each $part:ident.$key:ident) => {
        |rig, axis| rig.$part.$key.at(axis)
    };
    ($get:expr, $set:expr) => {
        $get
    };
}

macro_rules! set {
    ($part:ident.$key:ident) => {
        |rig, value| rig.$part.$key = value
    };
    (each $part:ident.$key:ident) => {
        |rig, value| rig.$part.$key = value.into()
    };
    ($get:expr, $set:expr) => {
        $set
    };
}

rows! {
    /// True displacement per command.
    CommandGain "gain" 1.0 {
        error: (Actuator, Effect::GainError, "error"),
        simulated: (each actuator.gain),
        declared: |actuator, _| actuator.gain,
        correction: (1.0, |rig| &mut rig.command_gain, |gain| format!(
            "the actuator goes {gain:.4} times as far as it is sent: commands are divided by that"
        )),
    }
    /// True displacement at command 0, mm. The simulated rig has no key for it, only the effect of that name.
    CommandOffset "offset" 0.0 {
        error: (Actuator, Effect::Offset, "offset_mm"),
        simulated: (|_, _| 0.0, |rig, mm| if mm != 0.0 {
            rig.effects.push(EffectSpec::new(Effect::Offset, &[("offset_mm", mm)]));
        }),
        declared: |actuator, _| actuator.offset_mm,
        correction: (1e-3, |rig| &mut rig.command_offset_m, |mm| format!(
            "the actuator stands at {mm:.4} mm for a command of 0: that is taken off the command"
        )),
    }
    /// Displacement read per true displacement.
    DisplacementGain "displacement_gain" 1.0 {
        simulated: (sensors.displacement_gain),
        correction: (1.0, |rig| &mut rig.displacement_gain, |gain| format!(
            "the displacement reads {gain:.4} times what it is, as actuator and force say together: readings are divided \
             by that"
        )),
    }
    /// Displacement read at a true displacement of 0, mm.
    DisplacementOffset "displacement_offset_mm" 0.0 {
        simulated: (sensors.displacement_offset_mm),
        correction: (1e-3, |rig| &mut rig.displacement_offset_m, |mm| format!(
            "the displacement reads {mm:.4} mm too much, as actuator and force say together: that is taken off the \
             reading"
        )),
    }
    /// Force read per true force.
    ForceGain "force_gain" 1.0 {
        error: (Specimen, Effect::GainError, "error"),
        simulated: (sensors.force_gain),
        correction: (1.0, |rig| &mut rig.force_gain, |gain| format!(
            "forces are divided by {gain:.4}, as a load cell's; if the specimen is that much stiffer or softer, declare its \
             stiffness instead"
        )),
    }
    /// Force read without force, N.
    ForceOffset "force_offset_n" 0.0 {
        error: (Specimen, Effect::Offset, "offset_n"),
        simulated: (sensors.force_offset_n),
        declared: |_, specimen| specimen.offset_n,
        correction: (1.0, |rig| &mut rig.force_offset_n, |force_n| format!(
            "{force_n:.2} N are taken off the force"
        )),
    }
    /// Delay of the force behind the displacement, ms; negative if the displacement is behind.
    ForceLate "skew_ms" 0.0 {
        error: (Specimen, Effect::ChannelSkew, "skew_ms"),
        simulated: (sensors.skew_ms),
        correction: (1.0, |rig| &mut rig.force_late_ms, held_back),
    }
    /// Transport delay from command to displacement, ms.
    Delay "delay_ms" 0.0 {
        error: (Actuator, Effect::DelayError, "delay_ms"),
        simulated: (|rig, axis| rig.actuator.times_ms(axis).unwrap_or_default()[0],
            |rig, ms| rig.actuator.set_times_ms(|[_, lag]| [ms, lag])),
        declared: |actuator, _| actuator.delay_ms.map(exact),
    }
    /// First-order lag from command to displacement, ms.
    Lag "lag_ms" 0.0 {
        error: (Actuator, Effect::LagError, "lag_ms"),
        simulated: (|rig, axis| rig.actuator.times_ms(axis).unwrap_or_default()[1],
            |rig, ms| rig.actuator.set_times_ms(|[delay, _]| [delay, ms])),
        declared: |actuator, _| actuator.lag_ms.map(exact),
    }
    /// Mass on the load cell, kg. The loop has it in its structure.
    Mass "physical_mass_kg" 0.0 {
        error: (Specimen, Effect::InertiaForce, "mass_kg"),
        simulated: (each specimen.physical_mass_kg),
        declared: |_, specimen| specimen.mass_kg,
    }
    /// Viscous damping of the specimen, N s/mm.
    Damping "damping_n_s_per_mm" 0.0 {
        error: (Specimen, Effect::ViscousDamping, "damping_n_s_per_mm"),
        simulated: (each specimen.damping_n_s_per_mm),
        declared: |_, specimen| specimen.damping_n_s_per_mm,
    }
    /// Sliding friction of the bearings, felt by the load cell, N: from an effect, which the simulated rig keeps.
    BearingFriction "bearing_friction_n" 0.0 {
        simulated: (|_, _| 0.0, |_, _| ()),
        correction: (1.0, |rig| &mut rig.bearing_friction_n, |force_n| format!(
            "{force_n:.1} N of friction are taken out as the bearings'; if it is the specimen's own, take it out of the \
             model instead"
        )),
    }
    /// Displacement over which that friction builds up, mm.
    BearingPresliding "bearing_presliding_mm" 0.0 {
        simulated: (|_, _| 0.0, |_, _| ()),
        correction: (1e-3, |rig| &mut rig.bearing_presliding_m, |mm| format!(
            "that friction builds up in {mm:.3} mm"
        )),
    }
    /// Amplitude of the mains' hum on the displacement, mm.
    DisplacementHum "displacement_hum_mm" 0.0 {
        simulated: (sensors.displacement_hum_mm),
    }
    /// The same on the force, N.
    ForceHum "force_hum_n" 0.0 {
        simulated: (sensors.force_hum_n),
    }
    /// Delay that the actuator changes to while the test runs, ms.
    DelayJump "delay_jump" 0.0 {
        simulated: (|rig, _| rig.actuator.delay_jump.map_or(0.0, |jump| jump.delay_ms),
            |rig, _| rig.actuator.delay_jump = None),
    }
}

/// Exact, however close it is to that of an ideal rig.
fn exact(declared: Declared) -> Declared {
    Declared {
        tolerance: 0.0,
        ..declared
    }
}

fn held_back(late_ms: f64) -> String {
    let (late, early) = if late_ms > 0.0 {
        ("force", "displacement")
    } else {
        ("displacement", "force")
    };
    format!(
        "the {late} is read {:.3} ms late: the {early} is held back as long, so that both are of one instant",
        late_ms.abs()
    )
}

/// The errors of a rig, each once, at its source.
#[derive(Clone, Debug, PartialEq)]
pub struct Departures {
    values: [f64; ROWS.len()],
    /// Effects that are not an error of a quantity, each in its channel.
    pub others: Vec<EffectSpec>,
}

impl Index<Quantity> for Departures {
    type Output = f64;
    fn index(&self, quantity: Quantity) -> &f64 {
        &self.values[quantity as usize]
    }
}

impl IndexMut<Quantity> for Departures {
    fn index_mut(&mut self, quantity: Quantity) -> &mut f64 {
        &mut self.values[quantity as usize]
    }
}

impl Departures {
    /// No departures: an ideal rig.
    fn none() -> Self {
        Self {
            values: std::array::from_fn(|i| ROWS[i].1.ideal),
            others: Vec::new(),
        }
    }

    /// Those of one axis of a simulated rig.
    pub fn of_rig(rig: &RigSpec, axis: usize) -> Self {
        let mut own = Self {
            values: std::array::from_fn(|i| (ROWS[i].1.simulated)(rig, axis)),
            others: Vec::new(),
        };
        for effect in &rig.effects {
            if effect.axis.is_none_or(|only| only == axis + 1) {
                own.add(effect.shows_in(), effect);
            }
        }
        own
    }

    /// What the loop corrects on an axis.
    pub fn taken_out(rig: &RigConfig, axis: usize) -> Self {
        let mut rig = rig.clone();
        let mut own = Self::none();
        for (quantity, row) in ROWS {
            if let Some((per_unit, setting, _)) = row.correction
                && let Some(value) = setting(&mut rig).get(axis)
            {
                own[*quantity] = value / per_unit;
            }
        }
        own
    }

    fn add(&mut self, channel: Channel, effect: &EffectSpec) {
        let own = Quantity::parameter_of_error(channel, effect.name);
        let own = own.filter(|_| effect.is_of_the_whole_test());
        let row = own.map(|quantity| (quantity, &ROWS[quantity as usize].1));
        let error = row.and_then(|(_, row)| effect.parameter(row.error?.2));
        match row.zip(error) {
            Some(((gain, row), error)) if row.ideal == 1.0 => self[gain] *= 1.0 + error,
            Some(((quantity, _), error)) => self[quantity] += error,
            None => self.others.push(effect.clone().in_channel(channel)),
        }
    }
}

/// Noise of the displacement, m, and of the force, N, one standard deviation: that declared to the filter in the file
/// or that of the simulated sensors, whichever is larger.
pub fn noise_rms(config: &Config, rig: &RigSpec) -> [f64; 2] {
    let [noise_m, noise_n] = rig.sensors.noise_rms();
    match &config.estimation {
        e if e.kind == Filter::Off => [noise_m, noise_n],
        e => [
            noise_m.max(e.displacement_noise_m),
            noise_n.max(e.force_noise_n),
        ],
    }
}

impl Quantity {
    /// Its key in the table of a simulated rig.
    pub fn name(self) -> &'static str {
        ROWS[self as usize].1.name
    }

    /// The quantity of which an effect is an error.
    fn parameter_of_error(channel: Channel, effect: Effect) -> Option<Self> {
        let of = |row: &QuantityRow| row.error.is_some_and(|e| (e.0, e.1) == (channel, effect));
        let row = ROWS.iter().find(|(_, row)| of(row));
        row.map(|(quantity, _)| *quantity)
    }
}
