use super::*;

fn load(name: &str, text: &str, columns: ColumnChoice) -> Result<GroundMotionFile, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    GroundMotionFile::load(&path, columns).map_err(|e| e.to_string())
}

fn plain(dt: f64, unit: AccelerationUnit) -> ColumnChoice {
    ColumnChoice {
        interval_s: Some(dt),
        unit: Some(unit),
    }
}

/// As NIED writes them: labels of 18 columns, then eight counts per line.
fn knet(scale: &str, duration_s: usize) -> String {
    let head = [
        ("Origin Time", "2011/03/11 14:46:00"),
        ("Lat.", "38.103"),
        ("Long.", "142.860"),
        ("Depth. (km)", "24"),
        ("Mag.", "9.0"),
        ("Station Code", "MYG004"),
        ("Station Lat.", "38.7292"),
        ("Station Long.", "141.0217"),
        ("Station Height(m)", "40"),
        ("Record Time", "2011/03/11 14:46:36"),
        ("Sampling Freq(Hz)", "100Hz"),
        ("Duration Time(s)", &duration_s.to_string()),
        ("Dir.", "E-W"),
        ("Scale Factor", scale),
        ("Max. Acc. (gal)", "300.000"),
        ("Last Correction", "2011/03/11 14:46:36"),
        ("Memo.", ""),
    ];
    let head: String = head
        .iter()
        .map(|(label, value)| format!("{label:<18}{value}\n"))
        .collect();
    let counts: Vec<String> = (0..200)
        .map(|i| format!("{:9}", if i % 2 == 0 { 5_000 } else { -3_000 }))
        .collect();
    let lines: String = counts.chunks(8).map(|c| c.concat() + "\n").collect();
    head + &lines
}

#[test]
fn knet_is_scaled_from_counts_behind_its_mean() {
    let g = load(
        "MYG004.EW",
        &knet("7845(gal)/8223790", 2),
        ColumnChoice::default(),
    )
    .unwrap();
    assert_eq!((g.interval_s, g.acc_m_per_s2.len()), (0.01, 200));
    // 4000 counts on either side of the recorder's zero.
    let expected = 4_000.0 * 7845.0 / 8_223_790.0 / 100.0;
    for (i, a) in g.acc_m_per_s2.iter().enumerate() {
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        assert!((f64::from(*a) - sign * expected).abs() < 1e-6, "{i}: {a}");
    }
    let wrong = |text: &str| load("MYG004.EW", text, ColumnChoice::default()).unwrap_err();
    let cut = wrong(&knet("7845(gal)/8223790", 3));
    assert!(cut.contains("300") && cut.contains("200"), "{cut}");
    let scale = wrong(&knet("7845/8223790", 2));
    assert!(
        scale.contains("line 14") && scale.contains("7845(gal)/8223790"),
        "{scale}"
    );
}

#[test]
fn the_same_motion_in_every_format_is_the_same() {
    let csv = load(
        "a.csv",
        "time_s,acc_g\n0,0.1\n0.02,-0.2\n0.04,0.3\n",
        ColumnChoice::default(),
    )
    .unwrap();
    let head = "PEER\nx\nACCELERATION TIME SERIES IN UNITS OF G\n";
    let text = format!("{head}NPTS=   3, DT= .0200 SEC\n .1 -.2\n .3\n");
    let at2 = load("a.AT2", &text, ColumnChoice::default()).unwrap();
    let text = format!("{head}   3   .0200   NPTS, DT\n .1 -.2\n .3\n");
    let old_at2 = load("a.at2", &text, ColumnChoice::default()).unwrap();
    let text = "# gal\n98.0665\n-196.133\n294.1995\n";
    let column = load("a.txt", text, plain(0.02, AccelerationUnit::Gal)).unwrap();
    for other in [&at2, &old_at2, &column] {
        assert!((csv.interval_s - other.interval_s).abs() < 1e-9);
        for (a, b) in csv.acc_m_per_s2.iter().zip(&other.acc_m_per_s2) {
            assert!((a - b).abs() < 1e-6);
        }
    }
}

#[test]
fn the_networks_formats_hold_the_same_motion() {
    // 0.1, -0.2 and 0.3 g in cm/s^2, eight fields of ten per line.
    let fixed = "   98.0665 -196.1330  294.1995\n";
    let csmip = format!(
        "CORRECTED ACCELEROGRAM\nstation\n      3 points of accel data equally spaced at  .020 sec, in cm/sec2. \
         (8f10.4)\n{fixed}      3 points of veloc data equally spaced at  .020 sec, in cm/sec.  (8f10.4)\n{fixed}"
    );
    let reals: String = (1..=100)
        .map(|i| {
            let x = if i == 62 { 0.02 } else { f64::from(i) };
            format!("{x:15.6E}{}", if i % 5 == 0 { "\n" } else { "" })
        })
        .collect();
    let cosmos = format!(
        "Corrected acceleration  (Format v01.20 with 13 text lines)\n 100 Real-header values follow on 20 lines, \
         Format= (5E15.6)\n{reals}      3 acceleration pts, approx 0 secs, units=cm/sec2 (04), \
         Format=(8F10.4)\n{fixed}End-of-data for Chan  1 acceleration\n"
    );
    let integers: String = (1..=48)
        .map(|i| {
            let n = match i {
                16 => 1,
                17 => 3,
                _ => -32768,
            };
            format!("{n:10}{}", if i % 8 == 0 { "\n" } else { "" })
        })
        .collect();
    let reals: String = (1..=50)
        .map(|i| {
            let x = if i == 2 { 50.0 } else { 1.7e38 };
            format!("{x:15.7E}{}", if i % 5 == 0 { "\n" } else { "" })
        })
        .collect();
    let smc = format!(
        "2 CORRECTED ACCELEROGRAM\n{}{integers}{reals}|a comment\n{fixed}",
        "text\n".repeat(10)
    );
    let esm = "EVENT_NAME: central_italy\nSAMPLING_INTERVAL_S: 0.020000\nNDATA: 3\nUNITS: cm/s^2\n\
               DATA_TYPE: ACCELERATION\n98.0665\n-196.133\n294.1995\n";
    let at2 = "PEER\nKöln\nACCELERATION TIME HISTORY IN UNITS OF CM/SEC/SEC\nNPTS= 3, DT= .0200 SEC\n\
               .980665D+02-.196133D+03 .2941995D+03\n";
    let dialect = "Zeit [s];Acceleration (m/s²)\n0,00;0,980665\n0,02;-1,96133\n0,04;2,941995\n";
    for (name, text) in [
        ("a.v2", csmip.as_str()),
        ("b.V2C", &cosmos),
        ("c.smc", &smc),
        ("d.ASC", esm),
        ("e.txt", at2),
        ("f.csv", dialect),
    ] {
        let g = load(name, text, ColumnChoice::default()).unwrap();
        assert!(
            (g.interval_s - 0.02).abs() < 1e-9,
            "{name}: {}",
            g.interval_s
        );
        let expected = [0.1, -0.2, 0.3].map(|x| (x * 9.80665) as f32);
        assert_eq!(g.acc_m_per_s2.len(), 3, "{name}");
        for (a, b) in g.acc_m_per_s2.iter().zip(expected) {
            assert!((a - b).abs() < 1e-5, "{name}: {a} {b}");
        }
    }
    let one_line = load(
        "g.txt",
        "98.0665 -196.133 294.1995",
        plain(0.02, AccelerationUnit::Gal),
    )
    .unwrap();
    assert_eq!(one_line.acc_m_per_s2.len(), 3);
    let unit = ColumnChoice {
        unit: Some(AccelerationUnit::Gal),
        ..ColumnChoice::default()
    };
    let two = load("h.txt", "0 98.0665\n0.02 -196.133\n0.04 294.1995\n", unit).unwrap();
    assert!((two.interval_s - 0.02).abs() < 1e-9 && two.acc_m_per_s2.len() == 3);

    let less = esm.replace("NDATA: 3", "NDATA: 4");
    let velocity = esm.replace("ACCELERATION", "VELOCITY");
    let few = csmip.replacen("      3", "     30", 1);
    for (name, text, said) in [
        ("d.ASC", less.as_str(), "NPTS = 4"),
        ("d.ASC", &velocity, "line 5: `VELOCITY`"),
        ("a.v2", &few, "line 5: `3 po`"),
        ("e.txt", &at2.replace("CM/SEC/SEC", "FT/SEC/SEC"), "line 3"),
    ] {
        let e = load(name, text, ColumnChoice::default()).unwrap_err();
        assert!(e.contains(said), "{said} is not in: {e}");
    }
    let e = load("a.csv", "time_s,acc_g\n0,0\n0.02,1\n", unit).unwrap_err();
    assert!(e.contains("is in g and --unit says gal"), "{e}");
}

/// A MAT file of version 7.3, which is HDF5, with these vectors.
fn variables(named: &[(&str, &[f64])], columns: ColumnChoice) -> Result<GroundMotionFile, String> {
    use hdf5_pure::mat::{Options, builder::MatBuilder};
    let mut file = MatBuilder::new(Options::default());
    for (name, values) in named {
        file.write_f64(name, &[values.len(), 1], values).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gm.mat");
    std::fs::write(&path, file.finish().unwrap()).unwrap();
    GroundMotionFile::load(&path, columns).map_err(|e| e.to_string())
}

#[test]
fn variables_of_a_binary_file_are_columns() {
    let (time_s, acc) = ([0.0, 0.01, 0.02], [0.0, 0.1, -0.2]);
    let g = |acc: &[f64]| -> Vec<f32> { acc.iter().map(|a| (a * 9.80665) as f32).collect() };
    let one = variables(
        &[("time_s", &time_s), ("acc_g", &acc), ("vel_x", &acc)],
        ColumnChoice::default(),
    );
    assert_eq!(one.as_ref().unwrap().acc_m_per_s2, g(&acc));
    assert_eq!(one.unwrap().interval_s, 0.01);
    let alone = variables(
        &[("ag", &acc), ("dt", &[0.01])],
        plain(0.01, AccelerationUnit::G),
    )
    .unwrap();
    assert_eq!((alone.acc_m_per_s2, alone.interval_s), (g(&acc), 0.01));
    for (named, said) in [
        (&[("ag", &acc[..])][..], "--dt S"),
        (
            &[
                ("time_s", &time_s[..]),
                ("acc_x_g", &acc),
                ("acc_y_g", &acc),
            ],
            "has 2 accelerations, acc_x_g, acc_y_g",
        ),
        (
            &[("time_s", &time_s), ("acc_g", &acc[..2]), ("b", &acc)],
            "acc_g has 2 values",
        ),
    ] {
        let e = variables(named, ColumnChoice::default()).unwrap_err();
        assert!(e.contains(said) && !e.contains('\n'), "{e}");
    }
}

#[test]
fn rounded_times_are_a_constant_interval() {
    let mut text = "time_s,acc_g\n".to_owned();
    for i in 0..4000 {
        text += &format!("{:.4},0.1\n", f64::from(i) / 256.0);
    }
    let g = load("a.csv", &text, ColumnChoice::default()).unwrap();
    assert!((g.interval_s - 1.0 / 256.0).abs() < 1e-7);
}

#[test]
fn each_mistake_is_refused_with_its_line() {
    let at2 = "x\ny\nACCELERATION IN UNITS OF G\n";
    for (name, text, said) in [
        (
            "a.csv",
            "time_s,acc_g\n0,0\n0.02,0\n0.04,0\n0.07,0\n",
            "line 5",
        ),
        ("a.csv", "time_s,acc_g\n0,0\n0.02,NaN\n", "line 3"),
        ("a.csv", "time_s,acc_g\n0,0\n0.02,x\n", "line 3"),
        (
            "a.csv",
            "time_s,acc_ft\n0,0\n0.02,0\n",
            "line 1: the header",
        ),
        ("a.csv", "time_s,vel_g\n0,0\n0.02,0\n", "line 1: the header"),
        ("a.csv", "acc_g\n0\n0.02\n", "line 1: the header"),
        ("a.csv", "0,0.1\n0.02,0.2\n", "line 1: `0` stands where"),
        (
            "a.csv",
            "time_s,acc_g\n0,0\n0.02,0,0\n",
            "line 3: has 3 columns",
        ),
        (
            "a.csv",
            "time_s,acc_g\n0,0\n-0.02,0\n",
            "line 3: time -0.02 s",
        ),
        ("a.csv", "time_s,acc_g\n0,0\n0.02,820\n", "820.000 g"),
        ("a.csv", "time_s,acc_g\n", "0 points"),
        ("a.csv", "", "is empty"),
        (
            "a.AT2",
            &format!("{at2}NPTS= 3, DT= .02 SEC\n.1 .2\n"),
            "NPTS = 3",
        ),
        (
            "a.AT2",
            &format!("{at2}NPTS= 2, DT= 0 SEC\n.1 .2\n"),
            "DT = 0",
        ),
        (
            "a.AT2",
            &format!("{at2}NPTS= 2, DT= .02 SEC\n.1 ab\n"),
            "line 5: `ab`",
        ),
        ("a.AT2", &format!("{at2}.1 .2\n"), "no line with NPTS"),
        (
            "a.AT2",
            "x\ny\nVELOCITY IN UNITS OF CM/S\nNPTS= 2, DT= .02 SEC\n.1 .2\n",
            "line 3",
        ),
        ("a.txt", "0\n1\n", "--dt"),
    ] {
        let e = load(name, text, ColumnChoice::default()).unwrap_err();
        assert!(e.contains(said), "{said} is not in: {e}");
        assert!(!e.contains('\n'));
    }
    let e = load("a.txt", "0\n1\nx\n", plain(0.01, AccelerationUnit::G)).unwrap_err();
    assert!(e.contains("line 3: `x`"), "{e}");
    let e = load("a.txt", "0\n1\n", plain(-1.0, AccelerationUnit::G)).unwrap_err();
    assert!(e.contains("--dt = -1"), "{e}");
    let csv = "time_s,acc_g\n0,0\n0.02,1\n";
    let e = load("a.csv", csv, plain(0.01, AccelerationUnit::G)).unwrap_err();
    assert!(e.contains("0.02 s and --dt says 0.01 s"), "{e}");
}

#[test]
fn a_time_in_another_unit_is_asked_about() {
    for (interval, good) in [
        (0.01, true),
        (10.0, false),
        (10_000.0, false),
        (1e-5, false),
    ] {
        let rows: String = (0..50)
            .map(|i| format!("{},0.1\n", f64::from(i) * interval))
            .collect();
        let read = load(
            "a.csv",
            &format!("time_s,acc_g\n{rows}"),
            ColumnChoice::default(),
        );
        match read {
            Ok(_) => assert!(good, "{interval}"),
            Err(e) => assert!(!good && e.to_string().contains("another unit"), "{e}"),
        }
    }
}
