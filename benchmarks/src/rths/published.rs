//! Published figures for El Centro: the problem's own table, and an independent port of the problem.

/// Table 3 of the problem: J1 in ms and J2 to J9 in per cent of the published controller on the nominal plant, cases 1 to 4.
pub const TABLE_3: [[f64; 9]; 4] = [
    [4.6, 10.4, 11.5, 36.1, 19.0, 32.3, 32.4, 14.8, 14.8],
    [4.6, 9.8, 11.1, 33.1, 17.1, 30.5, 30.5, 15.3, 15.2],
    [4.6, 9.1, 10.2, 49.9, 36.7, 49.8, 49.8, 35.5, 35.6],
    [4.6, 10.5, 11.3, 72.6, 35.2, 68.5, 68.7, 33.4, 33.3],
];

/// A controller in an independent port.
#[derive(Clone, Copy, Debug)]
pub struct PortFigures {
    /// Its name in this crate.
    pub controller: &'static str,
    /// J2, J2*, J4, J4* and J7 of cases 1 to 4, per cent.
    pub nominal: [[f64; 4]; 5],
}

/// The controllers whose nominal figures the port gives to one digit more than our difference from them.
pub const PORT: [PortFigures; 3] = [
    PortFigures {
        controller: "amb",
        nominal: [
            [2.55, 2.39, 1.57, 1.98],
            [0.37, 0.34, 0.27, 0.32],
            [3.16, 2.95, 3.03, 3.61],
            [1.9, 1.7, 2.6, 3.0],
            [1.8, 1.7, 2.6, 3.0],
        ],
    },
    PortFigures {
        controller: "amb/lead=1",
        nominal: [
            [2.62, 2.46, 1.66, 2.08],
            [0.65, 0.62, 0.55, 0.66],
            [2.72, 2.55, 1.91, 2.28],
            [0.94, 0.90, 1.1, 1.1],
            [0.7, 0.6, 0.9, 1.0],
        ],
    },
    PortFigures {
        controller: "fixed-inverse",
        nominal: [
            [2.5, 2.4, 1.6, 2.0],
            [0.33, 0.30, 0.28, 0.33],
            [3.7, 3.4, 3.9, 4.8],
            [2.6, 2.4, 3.6, 4.4],
            [2.5, 2.4, 3.5, 4.3],
        ],
    },
];

/// J4 of the worst of twenty drawn plants in that port, cases 1 to 4, per cent. The port does not say how it draws them.
pub const WORST_DRAWN: [(&str, [f64; 4]); 4] = [
    ("pi-phase-lead", [46.0, 42.0, 64.0, 104.0]),
    ("fixed-inverse", [17.0, 16.0, 24.0, 30.0]),
    ("amb", [3.3, 3.2, 3.3, 4.0]),
    ("amb/lead=1", [2.8, 2.6, 2.0, 2.4]),
];
