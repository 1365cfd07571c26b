//! Numbers as Fortran programs write them: `D` exponents, and no blank before a sign that fills its field.

/// The numbers of a line; for an unreadable one, its text.
pub fn numbers(line: &str, width: Option<usize>) -> Vec<Result<f64, &str>> {
    let words: Vec<&str> = match width {
        Some(width) => fields(line, width),
        None => line.split_whitespace().flat_map(split_numbers).collect(),
    };
    words.into_iter().map(number).collect()
}

fn number(word: &str) -> Result<f64, &str> {
    let plain = word.replace(['D', 'd'], "E");
    plain
        .parse()
        .ok()
        .filter(|x: &f64| x.is_finite())
        .ok_or(word)
}

/// Fields of a fixed width; blank ones at the end of the line do not count.
fn fields(line: &str, width: usize) -> Vec<&str> {
    let ascii = line.trim_end();
    (0..ascii.len())
        .step_by(width)
        .filter_map(|at| ascii.get(at..(at + width).min(ascii.len())))
        .map(str::trim)
        .filter(|field| !field.is_empty())
        .collect()
}

/// Numbers without a blank between them: a sign begins a new one unless it is that of an exponent.
fn split_numbers(word: &str) -> Vec<&str> {
    let bytes = word.as_bytes();
    let begins = |at: usize| {
        at == 0
            || matches!(bytes[at], b'-' | b'+')
                && !matches!(bytes[at - 1], b'e' | b'E' | b'd' | b'D')
    };
    let mut starts: Vec<usize> = (0..bytes.len()).filter(|at| begins(*at)).collect();
    starts.push(bytes.len());
    starts
        .windows(2)
        .filter_map(|w| word.get(w[0]..w[1]))
        .collect()
}

/// The field width in a format such as `(8F10.3)`, if `text` names one.
pub fn width_in(text: &str) -> Option<usize> {
    let upper = text.to_uppercase();
    let inner = upper.rsplit_once('(')?.1.split_once(')')?.0;
    let descriptor = inner.rsplit(['P', ',']).next()?.trim();
    let field = descriptor.trim_start_matches(|c: char| c.is_ascii_digit());
    let digits = field.strip_prefix(['F', 'E', 'G', 'D'])?;
    let width = digits.split('.').next()?.parse().ok()?;
    (2..=40).contains(&width).then_some(width)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_with_and_without_blanks() {
        for (line, width, expected) in [
            (
                " .1000D-01-.2000D-01 -3.0E+00",
                None,
                vec![0.01, -0.02, -3.0],
            ),
            ("1.5-2.5+3.5", None, vec![1.5, -2.5, 3.5]),
            ("  -1.123456.123  ", Some(8), vec![-1.123, 456.123]),
            ("   1.0      2.0       ", Some(10), vec![1.0, 2.0]),
        ] {
            let read: Vec<f64> = numbers(line, width)
                .into_iter()
                .map(Result::unwrap)
                .collect();
            assert_eq!(read, expected, "{line}");
        }
        assert_eq!(numbers("1 ab", None)[1], Err("ab"));
        assert_eq!(numbers("****", Some(4))[0], Err("****"));
    }

    #[test]
    fn a_format_says_how_wide_a_field_is() {
        for (text, width) in [
            ("Format=(8F10.3)", Some(10)),
            ("in cm/sec2. (8f10.3)", Some(10)),
            ("(1P5E15.7)", Some(15)),
            ("units=cm/sec2(04),Format=(6E13.6)", Some(13)),
            ("no format (04)", None),
        ] {
            assert_eq!(width_in(text), width, "{text}");
        }
    }
}
