//! What a test takes of this machine's memory, before it takes it.

use crate::failure::Failure;

/// Memory that is counted on where the machine does not say how much is left, bytes.
const ASSUMED_BYTES: u64 = 4 << 30;
/// Less is not spoken of, bytes.
const WORTH_A_WORD_BYTES: u64 = 1 << 30;

/// That so much memory is left.
///
/// # Errors
/// Less than `bytes`; `what` takes it, and `accepted` is what would do.
pub fn check(what: &str, bytes: u64, accepted: &str) -> Result<(), Failure> {
    let left = available_bytes();
    if bytes <= left {
        return Ok(());
    }
    Err(Failure::input(format!(
        "{what} take {} of memory, and {} are left on this machine: accepted are {accepted}",
        gigabytes(bytes),
        gigabytes(left)
    )))
}

/// What is worth saying of so many bytes.
pub fn worth_saying(bytes: u64) -> Option<String> {
    (bytes >= WORTH_A_WORD_BYTES).then(|| gigabytes(bytes))
}

fn gigabytes(bytes: u64) -> String {
    format!("{:.1} GB", bytes as f64 * 1e-9)
}

/// What can still be taken without writing other programs' memory to disk, as Linux estimates it.
fn available_bytes() -> u64 {
    let said = std::fs::read_to_string("/proc/meminfo").ok();
    said.and_then(|text| available_in(&text))
        .unwrap_or(ASSUMED_BYTES)
}

fn available_in(meminfo: &str) -> Option<u64> {
    let line = meminfo
        .lines()
        .find_map(|l| l.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_linux_says_is_read() {
        let text = "MemTotal:       24609528 kB\nMemAvailable:   18000000 kB\n";
        assert_eq!(available_in(text), Some(18_432_000_000));
        assert_eq!(available_in("MemTotal: 1 kB\n"), None);
    }

    #[test]
    fn what_does_not_fit_is_refused_with_both_figures() {
        assert_eq!(check("2 steps", 1 << 20, "fewer"), Ok(()));
        let e = check("9 steps", u64::MAX, "fewer").unwrap_err().to_string();
        assert!(
            e.starts_with("9 steps take 18446744073.7 GB of memory, and "),
            "{e}"
        );
        assert!(
            e.ends_with("are left on this machine: accepted are fewer"),
            "{e}"
        );
        assert_eq!(worth_saying(3 << 30).as_deref(), Some("3.2 GB"));
        assert_eq!(worth_saying(1 << 20), None);
    }
}
