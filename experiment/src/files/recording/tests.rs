use super::*;

fn parse(text: &str) -> Result<SiRecording, String> {
    SiRecording::parse("r.csv", text).map_err(|e| e.to_string())
}

#[test]
fn units_become_si_and_unknown_quantities_stay_as_they_are() {
    let r = parse(
        "# rig A\ntime_ms,command_mm,displacement_m,force_kn,force2_n,oil_c\n0,1,0.002,3,4,40\n1,2,0.003,4,5,41\n",
    )
    .unwrap();
    assert_eq!(r.time_s, [0.0, 0.001]);
    assert_eq!(r.command_m().unwrap(), [0.001, 0.002]);
    assert_eq!(r.displacement_m().unwrap(), [0.002, 0.003]);
    assert_eq!(r.force().unwrap(), [3000.0, 4000.0]);
    assert!(r.force_has_unit());
    assert_eq!(r.column("force", 2).unwrap().values, [4.0, 5.0]);
    assert_eq!(r.column("oil_c", 1).unwrap().values, [40.0, 41.0]);
}

#[test]
fn a_force_without_a_unit_says_so_and_missing_channels_are_missing() {
    let r = parse("time_s,displacement_mm,force_1\n0,1,2\n1,2,3\n").unwrap();
    assert!(!r.force_has_unit());
    assert_eq!(r.force().unwrap(), [2.0, 3.0]);
    assert!(r.command_m().is_none());
}

#[test]
fn what_the_header_does_not_say_is_said_beside_it() {
    let table = || NumberTable::parse("r.csv", "Zeit;A;B;Disp (mm)\n0;1;2;3\n0,5;4;5;6\n").unwrap();
    let of = |said: &[&str], rate| {
        let assigned = said.iter().map(|s| s.parse().unwrap()).collect();
        SiRecording::of(table(), &Columns { assigned, rate }).map_err(|e| e.to_string())
    };
    let r = of(&["time=zeit:ms", "command=2:mm", "force=B:kn"], None).unwrap();
    assert_eq!(r.time_s, [0.0, 5e-4]);
    assert_eq!(r.command_m().unwrap(), [0.001, 0.004]);
    assert_eq!(r.force().unwrap(), [2000.0, 5000.0]);
    assert_eq!(r.displacement_m().unwrap(), [0.003, 0.006]);
    let r = of(&["time=zeit:s", "displacement=A:m"], None).unwrap();
    assert_eq!(r.displacement_m().unwrap(), [1.0, 4.0]);
    for (said, rate, words) in [
        (&[][..], None, "`Zeit` is refused: accepted are time_s"),
        (
            &["time=T:s"],
            None,
            "no column `T`: accepted are Zeit, A, B",
        ),
        (&["time=Zeit:mm"], None, "unit of `Zeit` is mm"),
        (
            &["time=Zeit:s", "command=A"],
            None,
            "unit of `A` is not said",
        ),
        (&["time=Zeit:s"], Some(10.0), "has times of its own"),
    ] {
        let e = of(said, rate).unwrap_err();
        assert!(e.contains(words), "{words}: {e}");
    }
    let table = || NumberTable::parse("r.csv", "command_mm,force_n\n1,2\n3,4\n").unwrap();
    let of = |rate| {
        SiRecording::of(
            table(),
            &Columns {
                assigned: vec![],
                rate,
            },
        )
    };
    assert_eq!(of(Some(500.0)).unwrap().time_s, [0.0, 0.002]);
    assert!(of(Some(0.0)).unwrap_err().to_string().contains("--rate 0"));
    assert!(of(None).unwrap_err().to_string().contains("has no time"));
    // Numbers without a unit do not count as times.
    for (name, taken) in [("timestamp", true), ("Time", true), ("time_ms", false)] {
        let text = format!("{name},command_mm,force_n\n7,1,2\n9,3,4\n");
        let rate = Some(500.0);
        let assigned = vec![];
        let read = SiRecording::of(
            NumberTable::parse("r.csv", &text).unwrap(),
            &Columns { assigned, rate },
        );
        match read {
            Ok(r) => assert!(
                taken && r.time_s == [0.0, 0.002] && r.notes[0].contains("--rate stands for it")
            ),
            Err(e) => assert!(!taken && e.to_string().contains("times of its own"), "{e}"),
        }
    }
}

#[test]
fn what_is_not_understood_is_said() {
    let r = parse("time_s,Ch 1 Command (mm),LVDT 1 disp (mm),LVDT 2 disp (mm),force_n\n0,1,2,3,4\n1,2,3,4,5\n").unwrap();
    assert_eq!(r.notes.len(), 2, "{:?}", r.notes);
    assert!(
        r.notes[0].contains("--column 'command=Ch 1 Command (mm)'"),
        "{}",
        r.notes[0]
    );
    assert!(
        r.notes[1].contains("LVDT 1 disp (mm), LVDT 2 disp (mm) may be it"),
        "{}",
        r.notes[1]
    );
}

#[test]
fn each_mistake_is_refused_with_its_line() {
    for (text, said) in [
        (
            "time_s,force_mm\n0,1\n1,1\n",
            "line 1: the column `force_mm` is refused",
        ),
        ("time_s,displacement_kn\n0,1\n1,1\n", "displacement_m"),
        ("time_s,command\n0,1\n1,1\n", "`command` is refused"),
        ("time_s,command0_mm\n0,1\n1,1\n", "`command0_mm` is refused"),
        ("time_s,commandm\n0,1\n1,1\n", "`commandm` is refused"),
        ("time_h,command_mm\n0,1\n1,1\n", "time_s"),
        ("command_mm,force_n\n0,1\n1,1\n", "has no time"),
        (
            "time_s,command_mm,command_m\n0,1,1\n1,1,1\n",
            "command of axis 1 stands twice",
        ),
        ("time_s,force_n\n0,1\n1,1\n1,2\n", "line 4: time 1 s"),
        ("time_s,force_n\n0,1\n1,nan\n", "line 3: force_n is `nan`"),
        ("time_s,force_n\n0,1\n1,high\n", "line 3: force_n is `high`"),
        ("time_s,force_n\n0,1\n1\n", "line 3: has 1 columns"),
        (
            "time_s,force_n\n0,1\n",
            "has one row of numbers: accepted are at least 50",
        ),
    ] {
        let e = parse(text).unwrap_err();
        assert!(e.contains(said) && !e.contains('\n'), "{e}");
    }
}

/// What a fuzzer begins with is read to its end; else it would never get past a header.
#[test]
fn the_seeds_of_the_fuzzer_that_are_binary_are_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus/records");
    let load = |name: &str| SiRecording::load(&folder.join(name)).map_err(|e| e.to_string());
    for name in [
        "mat-5.mat",
        "mat-5-compressed.mat",
        "mat-7.3.mat",
        "hdf5.h5",
    ] {
        let read = load(name).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(read.time_s.len(), 20, "{name}");
        // Each has a sine of five samples a quarter.
        let swings = read.columns.iter().any(|c| c.values[15] < 0.0);
        assert!(swings, "{name}: {read:?}");
    }
    let refused = load("mat-4.mat").unwrap_err();
    assert!(refused.contains("MATLAB 4"), "{refused}");
}
