//! LabVIEW's measurement files (`.lvm`): two headers of keys, then the table.

use super::header::Header;

/// What the first line of such a file begins with.
const MAGIC: &str = "LabVIEW Measurement";
/// What ends each of the two headers.
const END: &str = "***End_of_Header***";

/// The text with its table alone: the lines before it are blank, so that messages keep their line, and the units of
/// `Y_Unit_Label` stand in the names. `None`: the text is no such file, or one without times of its own.
pub fn as_table(text: &str) -> Option<String> {
    if !text.starts_with(MAGIC) {
        return None;
    }
    let lines: Vec<&str> = text.lines().collect();
    let end = lines.iter().rposition(|line| line.starts_with(END))?;
    let key = |name: &str| {
        let found = lines[..end].iter().find(|line| line.starts_with(name))?;
        Some(
            found
                .split(['\t', ','])
                .skip(1)
                .map(str::trim)
                .collect::<Vec<_>>(),
        )
    };
    if key("X_Columns")?.first() != Some(&"One") {
        return None;
    }
    let names = lines.get(end + 1)?;
    let separator = if names.contains('\t') { '\t' } else { ',' };
    let units = key("Y_Unit_Label").unwrap_or_default();
    let named = |(at, name): (usize, &str)| match at {
        0 => "Time (s)".to_owned(),
        at => match units.get(at - 1) {
            Some(unit) if !unit.is_empty() && Header::of(name, None).unit.is_empty() => {
                format!("{name} ({unit})")
            }
            _ => name.to_owned(),
        },
    };
    // Behind the last channel stands a column for comments, empty in most rows.
    let names = names.trim_end().split(separator);
    let names: Vec<String> = names
        .filter(|name| name.trim() != "Comment")
        .enumerate()
        .map(named)
        .collect();
    let mut table = "\n".repeat(end + 1);
    table += &names.join(&separator.to_string());
    for line in &lines[end + 2..] {
        let cells = line.trim_end().splitn(names.len() + 1, separator);
        table.push('\n');
        table += &cells
            .take(names.len())
            .collect::<Vec<_>>()
            .join(&separator.to_string());
    }
    table.push('\n');
    Some(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\nTime\t14:02:11\n***End_of_Header***\t\n\t\n\
        Channels\t2\nY_Unit_Label\tmm\tkN\nX0\t0.0\t0.0\nDelta_X\t0.002\t0.002\n***End_of_Header***\t\n\
        X_Value\tCommand\tForce\tComment\n0.000\t-1.5\t0.25\n0.002\t-1.6\t0.26\tpump on\n";

    #[test]
    fn the_second_header_ends_at_the_table() {
        let table = as_table(TEXT).unwrap();
        assert_eq!(
            table.lines().count(),
            TEXT.lines().count(),
            "messages keep their line"
        );
        let rows: Vec<&str> = table.lines().filter(|line| !line.is_empty()).collect();
        assert_eq!(
            rows,
            [
                "Time (s)\tCommand (mm)\tForce (kN)",
                "0.000\t-1.5\t0.25",
                "0.002\t-1.6\t0.26"
            ]
        );
    }

    #[test]
    fn what_has_no_times_is_left_as_it_is() {
        assert_eq!(as_table(&TEXT.replace("\tOne", "\tNo")), None);
        assert_eq!(as_table("time_s,a\n0,1\n"), None);
    }
}
