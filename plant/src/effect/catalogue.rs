//! The list of effects: one entry per name.

use super::row::{Channel, Family, Parameter, named};
use crate::error::Accept;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The description of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Its name.
    pub effect: Effect,
    /// Its family.
    pub family: Family,
    /// Channels in which it can show; the first is the default.
    pub channels: &'static [Channel],
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// Its physics, in one line.
    pub physics: &'static str,
}

impl Effect {
    /// Its description.
    pub fn entry(self) -> &'static Entry {
        &catalogue()[self as usize]
    }
}

/// The least accepted value of a divisor.
const TINY: f64 = 1e-6;
const BIG: f64 = 1e9;

macro_rules! catalogue {
    ($($effect:ident $text:literal $family:ident [$($channel:ident),*] $physics:literal {
        $($(@$own:ident)? $name:ident $(= $default:literal)?: $min:expr => $max:expr, $unit:literal, $meaning:literal;)*
    })*) => {
        named! {
            /// A physical effect.
            Effect { $($effect = $text,)* }
        }

        const ENTRIES: &[Entry] = &[$(Entry {
            effect: Effect::$effect,
            family: Family::$family,
            channels: &[$(Channel::$channel),*],
            parameters: &[$(Parameter {
                name: stringify!($name),
                channel: one!($(Channel::$own)?),
                default: one!($($default)?),
                accept: Accept::new($min, $max, $unit),
                meaning: $meaning,
            }),*],
            physics: $physics,
        }),*];
    };
}

/// Every effect, in the order of [`Effect`].
pub const fn catalogue() -> &'static [Entry] {
    ENTRIES
}

macro_rules! one {
    () => {
        None
    };
    ($one:expr) => {
        Some($one)
    };
}

// A row: the effect, its family, its channels (the first is the default), its physics. Then its parameters: `@` the
// channel that it belongs to, unless it is in all, `=` its default, if any, the accepted numbers, their unit, its
// meaning.
catalogue! {
    DelayError "delay_error" Timing [Actuator]
        "the transport delay is longer than declared" {
        delay_ms: -1000.0 => 1000.0, "ms", "added transport delay; negative where the actuator has as much to give";
    }
    LagError "lag_error" Timing [Actuator]
        "the first-order lag is slower than declared" {
        lag_ms: -1000.0 => 1000.0, "ms", "added to the time constant; negative where the actuator has as much to give";
    }
    SecondLag "second_lag" Timing [Actuator]
        "a further first-order lag in series, as of a servo valve or an amplifier" {
        lag_ms: TINY => 1000.0, "ms", "its time constant";
    }
    OilColumn "oil_column" Timing [Actuator]
        "the moving mass rings on the compressible oil: a second-order resonance" {
        frequency_hz: 0.1 => 1000.0, "Hz", "natural frequency";
        damping_ratio = 0.1: 0.001 => 5.0, "", "damping ratio";
    }
    ChannelSkew "channel_skew" Timing [Specimen]
        "displacement and force are not sampled at the same instant" {
        skew_ms: -1000.0 => 1000.0, "ms", "the force is later by this; negative: the displacement is";
    }
    GainError "gain_error" Calibration [Actuator, Specimen]
        "a calibration factor is off" {
        error: -0.9 => 9.0, "", "relative error of the gain";
    }
    Offset "offset" Calibration [Actuator, Specimen]
        "zero is not where it is thought to be" {
        @Actuator offset_mm: -1e4 => 1e4, "mm", "displacement at the command zero";
        @Specimen offset_n: -BIG => BIG, "N", "force read without force";
    }
    RigCompliance "rig_compliance" Calibration [Specimen, Actuator]
        "the reaction frame gives way: the specimen gets less displacement than its actuator reads (specimen), or the \
         actuator yields to the force (actuator)" {
        stiffness_n_per_mm: TINY => BIG, "N/mm", "stiffness of what gives way";
    }
    Drift "drift" Slow [Actuator, Specimen]
        "zero wanders with time" {
        @Actuator rate_mm_per_s: -1e3 => 1e3, "mm/s", "initial rate";
        @Specimen rate_n_per_s: -BIG => BIG, "N/s", "initial rate";
        time_constant_s = 0.0: 0.0 => 1e6, "s", "levels out after; 0 does not";
    }
    TemperatureGain "temperature_gain" Slow [Specimen, Actuator]
        "the gain changes while something warms up" {
        change: -0.9 => 9.0, "", "relative change in the end";
        time_constant_s = 60.0: 1e-3 => 1e6, "s", "time constant of warming up";
    }
    CoulombFriction "coulomb_friction" Friction [Specimen, Actuator]
        "dry friction of a bearing or a guide beside the specimen; in a controlled actuator, motion that is held back" {
        @Specimen force_n: TINY => BIG, "N", "friction force";
        @Actuator error_mm: TINY => 1e3, "mm", "by what the displacement is held back";
        presliding_mm = 0.05: TINY => 1e3, "mm", "way over which it builds up";
    }
    StribeckFriction "stribeck_friction" Friction [Specimen, Actuator]
        "dry friction that is greater at rest than in motion" {
        @Specimen force_n: TINY => BIG, "N", "friction force in motion";
        @Actuator error_mm: TINY => 1e3, "mm", "by what the displacement is held back in motion";
        rest_ratio = 1.5: 1.0 => 20.0, "", "friction at rest over that in motion";
        stribeck_mm_per_s = 5.0: TINY => 1e6, "mm/s", "velocity at which the difference has dropped to 1/e";
        presliding_mm = 0.05: TINY => 1e3, "mm", "way over which it builds up";
    }
    BilinearHysteresis "bilinear_hysteresis" Hysteresis [Specimen]
        "the storey yields: its stiffness drops to a share of itself, and unloading starts elastically" {
        yield_mm: TINY => 1e6, "mm", "yield drift";
        hardening_ratio = 0.05: 0.0 => 1.0, "", "stiffness after yield over initial stiffness";
    }
    BoucWenHysteresis "bouc_wen_hysteresis" Hysteresis [Specimen]
        "the storey yields with a smooth knee" {
        yield_mm: TINY => 1e6, "mm", "yield drift";
        hardening_ratio = 0.05: 0.0 => 1.0, "", "stiffness after yield over initial stiffness";
        sharpness = 2.0: 0.5 => 50.0, "", "exponent of the knee";
        loop_shape = 0.5: 0.5 => 1.0, "", "beta over beta + gamma";
    }
    Backlash "backlash" Gap [Actuator, Specimen]
        "play in a joint: a reversal passes only after the play is crossed" {
        width_mm: TINY => 1e3, "mm", "play in all";
    }
    DeadBand "dead_band" Gap [Actuator, Specimen]
        "nothing passes around zero" {
        width_mm: TINY => 1e3, "mm", "width of the band in all";
    }
    SlipGap "slip_gap" Gap [Specimen]
        "a bolted joint holds by friction, slips through the clearance of its hole, then bears" {
        gap_mm: TINY => 1e3, "mm", "clearance in all";
        slip_n: 0.0 => BIG, "N", "force at which it slips";
    }
    Saturation "saturation" Limit [Actuator, Specimen]
        "the stroke ends, or the force channel clips" {
        @Actuator limit_mm: TINY => 1e6, "mm", "largest displacement either way";
        @Specimen limit_n: TINY => BIG, "N", "largest force that is read either way";
    }
    RateLimit "rate_limit" Limit [Actuator]
        "the valve's flow limits the velocity" {
        rate_mm_per_s: TINY => 1e6, "mm/s", "largest velocity";
    }
    ViscousDamping "viscous_damping" Damping [Specimen]
        "a force in proportion to velocity" {
        damping_n_s_per_mm: 0.0 => 1e6, "N s/mm", "its constant";
    }
    QuadraticDamping "quadratic_damping" Damping [Specimen]
        "a force in proportion to velocity squared, as of oil through an orifice" {
        damping_n_s2_per_mm2: 0.0 => 1e6, "N s2/mm2", "its constant";
    }
    MaxwellDamper "maxwell_damper" Damping [Specimen]
        "a spring and a dashpot in series: viscous when slow, elastic when fast" {
        stiffness_n_per_mm: 0.0 => BIG, "N/mm", "stiffness of the spring";
        relaxation_ms: TINY => 1e6, "ms", "damping constant over stiffness";
    }
    Hardening "hardening" Stiffness [Specimen]
        "the storey stiffens with drift" {
        reference_mm: TINY => 1e6, "mm", "drift at which the secant stiffness has doubled";
        exponent = 2.0: 0.2 => 10.0, "", "power of the drift that the stiffness grows with; 2: a cubic force";
    }
    Softening "softening" Stiffness [Specimen]
        "the storey softens with drift, without a loop" {
        reference_mm: TINY => 1e6, "mm", "drift at which the secant stiffness has halved";
        exponent = 1.0: 0.2 => 10.0, "", "power of the drift; above 1 the force falls in the end";
    }
    Degradation "degradation" Stiffness [Specimen]
        "the storey loses stiffness for good, with the largest drift so far, as concrete that cracks or rubber that is \
         stretched for the first time, or with the way that it has gone, as in fatigue" {
        reference_mm = 0.0: 0.0 => 1e6, "mm", "largest drift at which the secant stiffness has halved; 0: drift takes none";
        exponent = 1.0: 0.1 => 10.0, "", "power of the largest drift; above 1 the force of a first loading falls in the end";
        travel_mm = 0.0: 0.0 => 1e9, "mm", "way after which half is lost of what the way takes in the end; 0: it takes none";
        lost_share = 1.0: 0.0 => 1.0, "", "share of the stiffness that the way takes in the end";
    }
    AsymmetricActuator "asymmetric_actuator" Asymmetry [Actuator]
        "a piston with unequal areas pushes and pulls differently" {
        difference: -1.0 => 1.0, "", "gain pushing less gain pulling, over their mean";
        retract_lag_ms = 0.0: 0.0 => 1000.0, "ms", "lag on the way back only";
    }
    AsymmetricStiffness "asymmetric_stiffness" Asymmetry [Specimen]
        "the storey is stiffer one way than the other" {
        difference: -1.9 => 1.9, "", "stiffness at positive drift less that at negative, over their mean";
    }
    InertiaForce "inertia_force" Inertia [Specimen]
        "mass between specimen and load cell: the load cell reads its acceleration as well" {
        mass_kg: 0.0 => BIG, "kg", "that mass";
    }
    MainsHum "mains_hum" Interference [Specimen, Actuator]
        "the mains couple into a cable" {
        @Specimen amplitude_n: 0.0 => BIG, "N", "amplitude";
        @Actuator amplitude_mm: 0.0 => 1e3, "mm", "amplitude";
        frequency_hz = 50.0: 0.01 => 1e4, "Hz", "frequency";
        third_harmonic = 0.0: 0.0 => 10.0, "", "amplitude of the third harmonic over that of the first";
    }
    Quantisation "quantisation" Interference [Specimen, Actuator]
        "a channel resolves multiples of a step only" {
        @Specimen step_n: TINY => BIG, "N", "the step";
        @Actuator step_mm: TINY => 1e3, "mm", "the step";
    }
    FrozenSensor "frozen_sensor" Interference [Specimen, Actuator]
        "a sensor reads on what it last read, and its noise: the load cell (specimen), the displacement transducer (actuator)" {
    }
    SensorNoise "sensor_noise" Interference [Specimen, Actuator]
        "a sensor is noisier than declared: the load cell (specimen), the displacement transducer (actuator)" {
        @Specimen rms_n: 0.0 => BIG, "N", "added white noise, rms";
        @Actuator rms_mm: 0.0 => 1e3, "mm", "added white noise, rms";
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_end_with_their_unit() {
        for parameter in catalogue().iter().flat_map(|e| e.parameters) {
            let unit = parameter.accept.unit.to_lowercase();
            let suffix = unit.replace('/', "_per_").replace(' ', "_");
            assert!(
                parameter.name.ends_with(&suffix),
                "{} in {unit}",
                parameter.name
            );
        }
    }
}
