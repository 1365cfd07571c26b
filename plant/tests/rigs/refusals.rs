//! The `[plant]` table: its shape, and what is refused with which words.

use crate::common::{RATE_HZ, STIFFNESS, spec};
use plant::{Effect, Rig, RigSpec};

/// The message for a rig of `table` with two storeys.
fn refusal(table: &str) -> String {
    match toml::from_str::<RigSpec>(table) {
        Err(error) => error.message().to_string(),
        Ok(spec) => match Rig::new(&spec, &[STIFFNESS, STIFFNESS], RATE_HZ, 0) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("{table} is accepted"),
        },
    }
}

#[test]
fn the_table_of_a_test_file_reads_and_writes_back() {
    let table = "
        [actuator]
        kind = 'lag_delay'
        delay_ms = 4
        lag_ms = [22.2, 20]
        gain = 0.98
        delay_jump = { at_s = 8, delay_ms = 12 }
        [specimen]
        kind = 'bilinear'
        yield_mm = 30
        hardening_ratio = 0.05
        physical_mass_kg = 12
        [sensors]
        displacement_noise_mm = 0.1
        force_noise_n = 20
        bits = 16
        skew_ms = 0.02
        [[effects]]
        name = 'coulomb_friction'
        force_n = 20
        axis = 2
        [[effects]]
        name = 'gain_error'
        channel = 'specimen'
        error = 0.01";
    let read = spec(table);
    assert!(Rig::new(&read, &[STIFFNESS, STIFFNESS], RATE_HZ, 0).is_ok());
    let written = toml::to_string(&read).unwrap();
    assert_eq!(spec(&written), read);
    assert_eq!(spec(""), RigSpec::default());
}

#[test]
fn a_value_out_of_range_is_refused_by_its_path() {
    for (table, message) in [
        (
            "actuator.delay_ms = -4",
            "plant.actuator.delay_ms is -4, accepted is a number from 0 to 1000 ms",
        ),
        (
            "actuator = { kind = 'delay', delay_ms = nan }",
            "plant.actuator.delay_ms is NaN, accepted is a number from 0 to 1000 ms",
        ),
        (
            "actuator = { kind = 'delay', delay_ms = [4, 2000] }",
            "plant.actuator.delay_ms[1] is 2000, accepted is a number from 0 to 1000 ms",
        ),
        (
            "actuator = { kind = 'delay', delay_ms = [4, 4, 4] }",
            "plant.actuator.delay_ms is a list of 3, accepted is one number, or a list of 2 (one an axis)",
        ),
        (
            "actuator.gain = 0",
            "plant.actuator.gain is 0, accepted is a number from 0.1 to 10",
        ),
        (
            "actuator = { kind = 'delay', lag_ms = 3 }",
            "plant.actuator.lag_ms is given, accepted is it beside plant.actuator.kind = \"lag_delay\" only",
        ),
        (
            "actuator = { kind = 'second_order', delay_ms = 4, zeta = 0 }",
            "plant.actuator.zeta is 0, accepted is a number from 0.01 to 10",
        ),
        (
            "actuator = { kind = 'random_multiplier', multiplier_sd = 1 }",
            "plant.actuator.multiplier_sd is 1, accepted is a number from 0 to 0.5",
        ),
        (
            "actuator = { kind = 'delay', delay_jump = { at_s = -1, delay_ms = 4 } }",
            "plant.actuator.delay_jump.at_s is -1, accepted is a number from 0 to 1000000 s",
        ),
        (
            "actuator = { kind = 'servo_hydraulic', delay_ms = 8, servo = { valve_hz = 1 } }",
            "plant.actuator.servo.valve_hz is 1, accepted is a number from 5 to 1000 Hz",
        ),
        (
            "actuator.kind = 'servo_hydraulic'",
            "plant.actuator.delay_ms is 0, accepted is a number from 0.5 to 1000 ms beside plant.actuator.kind = \"servo_hydraulic\"",
        ),
        (
            "specimen.kind = 'bilinear'",
            "plant.specimen.yield_mm is missing, accepted is a number from 0.000001 to 1000000 mm beside this plant.specimen.kind",
        ),
        (
            "specimen.yield_mm = 3",
            "plant.specimen.yield_mm is given, accepted is it beside plant.specimen.kind = \"bilinear\" or \"bouc_wen\" only",
        ),
        (
            "specimen = { kind = 'bouc_wen', yield_mm = 3, hardening_ratio = 1.5 }",
            "plant.specimen.hardening_ratio is 1.5, accepted is a number from 0 to 1",
        ),
        (
            "specimen.kind = 'viscous'",
            "plant.specimen.damping_n_s_per_mm is 0, accepted is more than 0 beside plant.specimen.kind = \"viscous\"",
        ),
        (
            "specimen.physical_mass_kg = -1",
            "plant.specimen.physical_mass_kg is -1, accepted is a number from 0 to 1000000000 kg",
        ),
        (
            "sensors.bits = 1",
            "plant.sensors.bits is 1, accepted is a number from 2 to 32",
        ),
        (
            "sensors.force_noise_n = -1",
            "plant.sensors.force_noise_n is -1, accepted is a number from 0 to 1000000000 N",
        ),
        (
            "sensors.displacement_range_mm = 0",
            "plant.sensors.displacement_range_mm is 0, accepted is a number from 0.000001 to 100000 mm",
        ),
        (
            "effects = [{ name = 'offset', offset_n = 1 }, { name = 'backlash', width_mm = -1 }]",
            "plant.effects[1].width_mm of backlash is -1, accepted is a number from 0.000001 to 1000 mm",
        ),
        (
            "effects = [{ name = 'backlash' }]",
            "plant.effects[0].width_mm of backlash is missing, accepted is a number from 0.000001 to 1000 mm",
        ),
        (
            "effects = [{ name = 'degradation' }]",
            "plant.effects[0].reference_mm or travel_mm of degradation is missing, accepted is one of the two above 0",
        ),
        (
            "effects = [{ name = 'degradation', reference_mm = 9, travel_mm = 900 }]",
            "plant.effects[0].reference_mm and travel_mm of degradation is 9 and 900, accepted is one of the two above 0",
        ),
        (
            "effects = [{ name = 'offset', offset_n = 1, offset_mm = 1 }]",
            "plant.effects[0].offset_n of offset is 1, accepted is in the actuator channel offset_mm",
        ),
        (
            "effects = [{ name = 'rate_limit', rate_mm_per_s = 9, channel = 'specimen' }]",
            "plant.effects[0].channel of rate_limit is specimen, accepted is actuator",
        ),
        (
            "effects = [{ name = 'inertia_force', mass_kg = 9, axis = 3 }]",
            "plant.effects[0].axis is 3, accepted is a number from 1 to 2",
        ),
        (
            "actuator = { kind = 'delay', delay_ms = 4 }\neffects = [{ name = 'delay_error', delay_ms = -5 }]",
            "plant.actuator.delay_ms with the delay_error of plant.effects is -1, accepted is a number from 0 to 1000 ms",
        ),
        (
            "specimen = { kind = 'viscous', damping_n_s_per_mm = 1 }\neffects = [{ name = 'slip_gap', gap_mm = 1, slip_n = 0 }]",
            "plant.effects[0].name is slip_gap, accepted is an effect that is not one of stiffness, where the specimen has none",
        ),
    ] {
        assert_eq!(refusal(table), message);
    }
}

#[test]
fn an_unknown_name_is_refused() {
    for (table, says) in [
        ("actuator.delay = 4", "unknown field `delay`"),
        ("actuators = {}", "unknown field `actuators`"),
        ("actuator.kind = 'springy'", "unknown variant `springy`"),
        (
            "actuator.delay_ms = '4'",
            "a number, or a list of numbers (one an axis)",
        ),
        ("specimen.mass = 4", "unknown field `mass`"),
        ("sensors.bit = 4", "unknown field `bit`"),
        (
            "effects = [{ name = 'gremlins' }]",
            "unknown variant `gremlins`",
        ),
        (
            "effects = [{ name = 'offset', offset_n = 'much' }]",
            "invalid type: string",
        ),
    ] {
        let message = refusal(table);
        assert!(message.contains(says), "{table}: {message}");
    }
}

#[test]
fn a_rig_needs_storeys_with_stiffness_and_a_rate() {
    let rig = |k: &[f64], hz| {
        Rig::new(&RigSpec::default(), k, hz, 0)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        rig(&[], 2000.0),
        "the number of storeys is 0, accepted is at least 1"
    );
    assert!(rig(&[1e6, -1.0], 2000.0).starts_with("the stiffness of a storey is -1,"));
    assert!(rig(&[1e6], 0.0).starts_with("the control rate is 0,"));
    assert!(rig(&[1e6], f64::NAN).starts_with("the control rate is NaN,"));
}

#[test]
fn an_effect_is_checked_when_it_is_added() {
    let refused = RigSpec::default().with_effect(Effect::OilColumn, &[("damping_ratio", 0.1)]);
    assert_eq!(
        refused.unwrap_err().to_string(),
        "plant.effects[0].frequency_hz of oil_column is missing, accepted is a number from 0.1 to 1000 Hz"
    );
    let unknown = RigSpec::default().with_effect(Effect::Offset, &[("offset_kn", 0.1)]);
    assert!(
        unknown
            .unwrap_err()
            .to_string()
            .contains("accepted is in the actuator channel offset_mm")
    );
}
