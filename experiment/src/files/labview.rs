//! LabVIEW's measurement files (`.lvm`): two headers of keys, then the table.

use super::header::Header;

/// What the first line of such a file begins with.
const MAGIC: &str = "LabVIEW Measurement";
/// What ends each of the two headers.
const END: &str = "***End_of_Header***";

/// The text with its table alone: the lines before it are blank, so that messages keep their line, and the units of
/// `Y_Unit_Label` stand in the names. A file without a column of times has those of `X0` and `Delta_X`. `None`: the text is no
/// such file, or one with times for each channel.
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
                .split(if found.contains('\t') { '\t' } else { ',' })
                .skip(1)
                .map(str::trim)
                .collect::<Vec<_>>(),
        )
    };
    let first = |name: &str| key(name)?.first()?.replace(',', ".").parse::<f64>().ok();
    let clock = match *key("X_Columns")?.first()? {
        "One" => None,
        "No" => Some((first("X0")?, first("Delta_X")?)),
        _ => return None,
    };
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
    for (row, line) in lines[end + 2..].iter().enumerate() {
        let time = clock.map(|(from_s, step_s)| (from_s + row as f64 * step_s).to_string());
        let cells = line.trim_end().splitn(names.len() + 1, separator);
        let mut cells: Vec<&str> = cells.take(names.len()).collect();
        if let (Some(time), [empty, ..]) = (&time, &mut cells[..])
            && empty.trim().is_empty()
        {
            *empty = time;
        }
        table.push('\n');
        table += &cells.join(&separator.to_string());
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
    fn a_file_without_times_has_those_of_its_header() {
        let text = TEXT
            .replace("\tOne", "\tNo")
            .replace("0.002\t0.002", "0,002\t0,002")
            .replace("\n0.000\t", "\n\t")
            .replace("\n0.002\t", "\n\t");
        let table = as_table(&text).unwrap();
        assert!(
            table.ends_with("\n0\t-1.5\t0.25\n0.002\t-1.6\t0.26\n"),
            "{table}"
        );
    }

    #[test]
    fn what_has_times_for_each_channel_is_left_as_it_is() {
        assert_eq!(as_table(&TEXT.replace("\tOne", "\tMulti")), None);
        assert_eq!(as_table("time_s,a\n0,1\n"), None);
    }
}
