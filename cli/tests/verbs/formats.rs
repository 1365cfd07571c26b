//! Records in the formats of laboratories: every dialect of CSV, MAT and HDF5, recognized and read with the same result.

use crate::common::{json, outerloop, refused};

/// A motion and the response of a first-order actuator, at 1 kHz.
fn rows() -> Vec<[f64; 3]> {
    let mut moved = 0.0;
    (0..4000)
        .map(|i| {
            let t = f64::from(i) * 1e-3;
            let command = 10.0 * (1.7 * t).sin() + 4.0 * (7.3 * t).sin() + (23.0 * t).sin();
            moved += (command - moved) * (1.0 - (-1e-3_f64 / 0.02).exp());
            [t, command, moved]
        })
        .collect()
}

fn lag_ms(arguments: &[&str]) -> f64 {
    let found = json(&[&["identify", "--json"][..], arguments].concat());
    found["lag_ms"].as_f64().unwrap()
}

#[test]
fn one_record_in_every_dialect_is_one_record() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, bytes: Vec<u8>| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path.display().to_string()
    };
    let table = |head: &str, separator: &str, comma: bool| {
        let lines = rows().into_iter().map(|row| {
            let cells = row.map(|x| format!("{x:.6}"));
            let line = cells.join(separator);
            if comma { line.replace('.', ",") } else { line }
        });
        let lines: Vec<String> = lines.collect();
        format!("{head}\n{}\n", lines.join("\n"))
    };
    let plain = table("time_s,command_mm,displacement_mm", ",", false);
    let expected = lag_ms(&[&file("plain.csv", plain.into())]);
    assert!((expected - 20.0).abs() < 1.0, "{expected}");
    let wide: Vec<u8> = table("Time (s)\tCommand (mm)\tDisplacement (mm)", "\t", true)
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    for (name, bytes, more) in [
        (
            "tabs.txt",
            table("Time (s)\tCmd [mm]\tDisp (mm)", "\t", false).into_bytes(),
            vec![],
        ),
        (
            "german.csv",
            table("Zeit;Soll;Weg\ns;mm;mm", ";", true).into_bytes(),
            vec![],
        ),
        ("excel.txt", wide, vec![]),
        (
            "labview.lvm",
            table(
                "LabVIEW Measurement\t\nRate\t1000\n\nTime\tRef\tPosition\nsec\tmm\tmm",
                "\t",
                false,
            )
            .into_bytes(),
            vec![],
        ),
        (
            "named.csv",
            table("T,A,B", ",", false).into_bytes(),
            vec![
                "--column",
                "time=T:s",
                "--column",
                "command=A:mm",
                "--column",
                "displacement=3:mm",
            ],
        ),
    ] {
        let path = file(name, bytes);
        let found = lag_ms(&[&[path.as_str()][..], &more].concat());
        assert!(
            (found - expected).abs() < 1e-3,
            "{name}: {found}, not {expected}"
        );
    }
    let long = file("long.csv", b"time_s,command_mm\n0,1\n0.1,1e12\n".to_vec());
    refused(
        &["identify", &long],
        &["line 3", "1.000e9 m", "is the unit right?"],
    );
    let unnamed = file(
        "unnamed.csv",
        table("Time,Cmd,Disp", ",", false).into_bytes(),
    );
    refused(
        &["identify", &unnamed],
        &["`Time`", "time_s", "--column 'time=Time:UNIT'"],
    );
    refused(
        &["identify", &unnamed, "--column", "time=Zeit:s"],
        &["no column `Zeit`", "Time, Cmd, Disp"],
    );
}

#[test]
fn what_stands_beside_a_record_does_not_spoil_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, head: &str, line: &dyn Fn(usize, [f64; 3]) -> String| {
        let lines = rows().into_iter().enumerate().map(|(i, row)| line(i, row));
        let path = folder.path().join(name);
        std::fs::write(
            &path,
            format!("{head}\n{}\n", lines.collect::<Vec<_>>().join("\n")),
        )
        .unwrap();
        path.display().to_string()
    };
    let head = "time_s,command_mm,displacement_mm,State";
    let whole = file("text.csv", head, &|_, [t, u, x]| {
        format!("{t},{u},{x},moves")
    });
    let output = outerloop(&["identify", &whole]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("`State` is left out: `moves` in line 2 is no number"),
        "{said}"
    );
    // A clock that jitters by up to 0.1 ms: the correction is reported.
    let late = |i: usize| 1e-4 * (i as f64 * 0.618_033_988_75).fract();
    let jitter =
        file(
            "jitter.csv",
            "time_s,command_mm,displacement_mm",
            &|i, [t, u, x]| format!("{:.9},{u},{x}", t + late(i)),
        );
    let said = String::from_utf8(outerloop(&["identify", &jitter]).stderr).unwrap();
    assert!(said.contains("laid on an even grid of 1.000 ms"), "{said}");
    // A logger that lost a cell at 3.5 s: allowed outside the requested span.
    let holed = file("hole.csv", "time_s,command_mm,displacement_mm", &|i,
                                                                        [
        t,
        u,
        x,
    ]| match i {
        3500 => format!("{t},,{x}"),
        _ => format!("{t},{u},{x}"),
    });
    refused(
        &["identify", &holed],
        &["line 3502", "the cell is blank", "at 3.5 s", "FILE@T0..T1"],
    );
    let found = lag_ms(&[&format!("{holed}@0..3.4")]);
    assert!((found - 20.0).abs() < 1.0, "{found}");
    // Small units, and times of day at an even rate whose column has no unit.
    let micro = file(
        "micro.csv",
        "Time (us),Command (um),Displacement (um)",
        &|i, [_, u, x]| format!("{},{},{}", 1000 * i, 1e3 * u, 1e3 * x),
    );
    let day =
        file(
            "day.csv",
            "Time,Command (mm),Displacement (mm)",
            &|_, [t, u, x]| format!("14:00:{t:06.3},{u},{x}"),
        );
    for arguments in [&[micro.as_str()][..], &[&day, "--rate", "1000"]] {
        let found = lag_ms(arguments);
        assert!((found - 20.0).abs() < 1.0, "{arguments:?}: {found}");
    }
    // Times of day, at an even rate.
    let clock = file(
        "clock.csv",
        "Time (s),Command (mm),Displacement (mm)",
        &|_, [t, u, x]| format!("2024-05-03 14:00:{t:06.3},{u},{x}"),
    );
    refused(
        &["identify", &clock],
        &[
            "line 2",
            "2024-05-03 14:00:00.000",
            "a time of day",
            "--rate HZ",
        ],
    );
    let found = lag_ms(&[&clock, "--rate", "1000"]);
    assert!((found - 20.0).abs() < 1.0, "{found}");
}

/// Data published by others, if they are on this machine.
fn outside(name: &str) -> Option<String> {
    test_data::file(&format!("outside/{name}")).map(|path| path.display().to_string())
}

#[test]
fn published_mat_and_hdf5_files_are_read_as_they_are() {
    // EMPS: position reference and measured position of a drive (MAT 5), and the same as CSV.
    if let (Some(mat), Some(csv)) = (outside("DATA_EMPS.mat"), outside("emps.csv")) {
        let columns = ["time=t:s", "command=qg:m", "displacement=qm:m"];
        let columns = columns.map(|c| ["--column", c]).concat();
        let (mat, csv) = (format!("{mat}@0..20"), format!("{csv}@0..20"));
        let of_mat = json(&[&["identify", "--json", &mat][..], &columns].concat());
        let of_csv = json(&["identify", "--json", &csv]);
        for key in ["gain", "delay_ms", "lag_ms", "offset_mm"] {
            let [a, b] = [&of_mat, &of_csv].map(|r| r[key].as_f64().unwrap());
            assert!((a - b).abs() < 1e-3 * a.abs().max(1.0), "{key}: {a} {b}");
        }
    }
    // Bouc-Wen: force in and displacement out (HDF5), without times.
    if let Some(h5) = outside("bouc_wen_train.h5") {
        refused(
            &["identify", &h5],
            &["has no time", "--rate", "multisine/u"],
        );
    }
}
