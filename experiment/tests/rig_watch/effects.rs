//! Every cause that the watch knows, as an effect of the simulated rig.

/// What goes wrong from 8 s on, and the cause that a set has to hold.
pub const EACH: [(&str, [&str; 2]); 26] = [
    (
        "name = 'delay_error'\ndelay_ms = 12",
        ["delay_error", "actuator"],
    ),
    (
        "name = 'gain_error'\nchannel = 'actuator'\nerror = 0.08",
        ["gain_error", "actuator"],
    ),
    (
        "name = 'offset'\nchannel = 'actuator'\noffset_mm = 2",
        ["offset", "actuator"],
    ),
    (
        "name = 'drift'\nchannel = 'actuator'\nrate_mm_per_s = 0.3",
        ["drift", "actuator"],
    ),
    (
        "name = 'coulomb_friction'\nchannel = 'actuator'\nerror_mm = 1.2",
        ["coulomb_friction", "actuator"],
    ),
    // The overlap of a valve.
    (
        "name = 'dead_band'\nchannel = 'actuator'\nwidth_mm = 3",
        ["dead_band", "actuator"],
    ),
    (
        "name = 'rate_limit'\nrate_mm_per_s = 120",
        ["rate_limit", "actuator"],
    ),
    (
        "name = 'saturation'\nchannel = 'actuator'\nlimit_mm = 20",
        ["saturation", "actuator"],
    ),
    (
        "name = 'gain_error'\nsensor = 'displacement'\nerror = 0.08",
        ["gain_error", "displacement"],
    ),
    (
        "name = 'offset'\nsensor = 'displacement'\noffset_mm = 2",
        ["offset", "displacement"],
    ),
    (
        "name = 'drift'\nsensor = 'displacement'\nrate_mm_per_s = 0.3",
        ["drift", "displacement"],
    ),
    (
        "name = 'channel_skew'\nskew_ms = -12",
        ["channel_skew", "displacement"],
    ),
    (
        "sensor = 'displacement'\nfrozen = true",
        ["frozen_sensor", "displacement"],
    ),
    (
        "sensor = 'displacement'\nname = 'sensor_noise'\nrms_mm = 0.4",
        ["sensor_noise", "displacement"],
    ),
    (
        "sensor = 'displacement'\nname = 'mains_hum'\namplitude_mm = 0.3",
        ["mains_hum", "displacement"],
    ),
    (
        "name = 'gain_error'\nsensor = 'force'\nerror = 0.15",
        ["gain_error", "force"],
    ),
    (
        "name = 'offset'\nsensor = 'force'\noffset_n = 500",
        ["offset", "force"],
    ),
    (
        "name = 'drift'\nsensor = 'force'\nrate_n_per_s = 80",
        ["drift", "force"],
    ),
    (
        "name = 'channel_skew'\nskew_ms = 12",
        ["channel_skew", "force"],
    ),
    (
        "name = 'inertia_force'\nmass_kg = 800",
        ["inertia_force", "force"],
    ),
    (
        "sensor = 'force'\nname = 'sensor_noise'\nrms_n = 60",
        ["sensor_noise", "force"],
    ),
    (
        "sensor = 'force'\nname = 'mains_hum'\namplitude_n = 60",
        ["mains_hum", "force"],
    ),
    (
        "name = 'dead_band'\nchannel = 'specimen'\nwidth_mm = 1.5",
        ["dead_band", "specimen"],
    ),
    (
        "name = 'coulomb_friction'\nchannel = 'specimen'\nforce_n = 300",
        ["coulomb_friction", "specimen"],
    ),
    (
        "name = 'degradation'\ntravel_mm = 1e-3\nlost_share = 0.6",
        ["degradation", "specimen"],
    ),
    (
        "name = 'degradation'\ntravel_mm = 1e-3\nlost_share = 0.6",
        ["gain_error", "force"],
    ),
];
