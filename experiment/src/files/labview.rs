//! LabVIEW's measurement files (`.lvm`): two headers of keys, then the table.

use super::header::Header;

/// The beginning of the first line of such a file.
const MAGIC: &str = "LabVIEW Measurement";
/// Name of a column of times.
const TIMES: &str = "X_Value";
/// End mark of each of the two headers.
const END: &str = "***End_of_Header***";

/// The text with only its table: the lines before it are blank, so that messages keep their line numbers, and the units
/// of `Y_Unit_Label` are added to the names. A file without a column of times gets those of `X0` and `Delta_X`; one
/// with times for each channel is a table if they are the same. `None` if the text is no such file.
///
/// # Errors
/// Channels at different times, with the line.
pub fn as_table(text: &str) -> Result<Option<String>, String> {
    table(text).transpose()
}

fn table(text: &str) -> Option<Result<String, String>> {
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
        "One" | "Multi" => None,
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
    // After the last channel there is a column for comments, empty in most rows.
    let names = names.trim_end().split(separator);
    let names: Vec<&str> = names.filter(|name| name.trim() != "Comment").collect();
    // The times of further channels must equal those of the first.
    let is_time = |at: &usize| *at > 0 && names[*at].trim() == TIMES;
    let (times, kept): (Vec<usize>, Vec<usize>) = (0..names.len()).partition(is_time);
    let heads: Vec<String> = kept.iter().map(|at| named((*at, names[*at]))).collect();
    let mut table = "\n".repeat(end + 1);
    table += &heads.join(&separator.to_string());
    for (row, line) in lines[end + 2..].iter().enumerate() {
        let all: Vec<&str> = line.trim_end().split(separator).collect();
        let seconds = |at: usize| all.get(at)?.replace(',', ".").parse::<f64>().ok();
        if let Some(at) = times
            .iter()
            .find(|at| seconds(**at).is_some_and(|s| Some(s) != seconds(0)))
        {
            return Some(Err(format!(
                "line {}: a LabVIEW file with times for each channel (X_Columns Multi), of which those of `{}` are others: \
                 accepted are channels that were sampled together",
                end + 3 + row,
                names.get(at + 1).unwrap_or(&TIMES)
            )));
        }
        let time = clock.map(|(from_s, step_s)| (from_s + row as f64 * step_s).to_string());
        let mut cells: Vec<&str> = kept.iter().map_while(|at| all.get(*at).copied()).collect();
        if let (Some(time), [empty, ..]) = (&time, &mut cells[..])
            && empty.trim().is_empty()
        {
            *empty = time;
        }
        table.push('\n');
        table += &cells.join(&separator.to_string());
    }
    table.push('\n');
    Some(Ok(table))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\nTime\t14:02:11\n***End_of_Header***\t\n\t\n\
        Channels\t2\nY_Unit_Label\tmm\tkN\nX0\t0.0\t0.0\nDelta_X\t0.002\t0.002\n***End_of_Header***\t\n\
        X_Value\tCommand\tForce\tComment\n0.000\t-1.5\t0.25\n0.002\t-1.6\t0.26\tpump on\n";

    #[test]
    fn the_second_header_ends_at_the_table() {
        let table = as_table(TEXT).unwrap().unwrap();
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
        let table = as_table(&text).unwrap().unwrap();
        assert!(
            table.ends_with("\n0\t-1.5\t0.25\n0.002\t-1.6\t0.26\n"),
            "{table}"
        );
    }

    #[test]
    fn times_for_each_channel_are_one_where_they_are_the_same() {
        let head = TEXT.split("X_Value").next().unwrap();
        let head = head
            .replace("\tOne", "\tMulti")
            .replace("mm\tkN", "mm\t\tkN");
        let of = |row: &str| {
            as_table(&format!(
                "{head}X_Value\tCommand\tX_Value\tForce\tComment\n0.000\t-1.5\t0.000\t0.25\n{row}\n"
            ))
        };
        let table = of("0.002\t-1.6\t0.002\t0.26").unwrap().unwrap();
        let rows: Vec<&str> = table.lines().filter(|line| !line.is_empty()).collect();
        let expected = [
            "Time (s)\tCommand (mm)\tForce (kN)",
            "0.000\t-1.5\t0.25",
            "0.002\t-1.6\t0.26",
        ];
        assert_eq!(rows, expected);
        let e = of("0.002\t-1.6\t0.003\t0.26").unwrap_err();
        assert!(
            e.starts_with("line 14: a LabVIEW file") && e.contains("`Force`"),
            "{e}"
        );
        assert_eq!(as_table("time_s,a\n0,1\n").unwrap(), None);
    }
}
