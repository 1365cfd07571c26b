//! Text in the encodings that laboratories export: UTF-8, UTF-16, and the Western Windows code page.

use super::{look_ahead, plain, third_party};
use crate::failure::Failure;
use encoding_rs::{Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};
use std::io::{ErrorKind, Read};
use std::path::Path;

/// Reads a file as bytes; `-` is standard input.
///
/// # Errors
/// A file, with its name, that cannot be read, or that this command will write.
pub fn bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    look_ahead::refuse_output(path)?;
    bytes_to_edit(path)
}

/// The same for a file that will be written back.
///
/// # Errors
/// A file, with its name, that cannot be read; for a missing third-party file, where it is published.
pub fn bytes_to_edit(path: &Path) -> Result<Vec<u8>, Failure> {
    let read = if path == Path::new("-") {
        let mut all = Vec::new();
        std::io::stdin().read_to_end(&mut all).map(|_| all)
    } else {
        std::fs::read(path)
    };
    read.map_err(|e| {
        let published = match e.kind() {
            ErrorKind::NotFound => third_party::missing(path),
            _ => None,
        };
        published.unwrap_or_else(|| {
            Failure::input(format!(
                "{}: cannot be read: {}",
                path.display(),
                plain::reason(&e)
            ))
        })
    })
}

/// The text in `bytes`, which came from `file`.
///
/// # Errors
/// Bytes that are not text.
pub fn text(file: &str, bytes: Vec<u8>) -> Result<String, Failure> {
    let text = decoded(file, bytes)?;
    // Line ends of an old Macintosh, which some plotting programs still write.
    Ok(match text.contains('\r') && !text.contains('\n') {
        true => text.replace('\r', "\n"),
        false => text,
    })
}

fn decoded(file: &str, bytes: Vec<u8>) -> Result<String, Failure> {
    if let Some(encoding) = wide(&bytes) {
        return Ok(encoding.decode(&bytes).0.into_owned());
    }
    if is_binary(&bytes) {
        return Err(Failure::input(format!(
            "{file}: is a binary file{}: accepted are CSV and other text, MAT (5 and 7.3) and HDF5",
            kind(&bytes)
        )));
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(text
            .strip_prefix('\u{feff}')
            .map(str::to_owned)
            .unwrap_or(text)),
        // There every byte is a character: an umlaut in a title, a degree sign, a superscript two.
        Err(e) => Ok(WINDOWS_1252.decode(e.as_bytes()).0.into_owned()),
    }
}

/// True if the bytes are not text in any encoding.
pub fn is_binary(bytes: &[u8]) -> bool {
    wide(bytes).is_none() && bytes.contains(&0)
}

/// UTF-16, by its byte-order mark or because every other byte is zero, as for digits and Western letters.
fn wide(bytes: &[u8]) -> Option<&'static Encoding> {
    if let Some((encoding, _)) = Encoding::for_bom(bytes) {
        return (encoding != encoding_rs::UTF_8).then_some(encoding);
    }
    let head = &bytes[..bytes.len().min(512) & !1];
    let zeros = |from: usize| {
        head.iter()
            .skip(from)
            .step_by(2)
            .filter(|b| **b == 0)
            .count()
    };
    let most = 9 * (head.len() / 2) / 10;
    match (zeros(0), zeros(1)) {
        (0, odd) if odd > most.max(1) => Some(UTF_16LE),
        (even, 0) if even > most.max(1) => Some(UTF_16BE),
        _ => None,
    }
}

/// What kind of binary file it seems to be, and what to do with it.
fn kind(bytes: &[u8]) -> &'static str {
    match bytes {
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => {
            " of NumPy: write it with numpy.savetxt or scipy.io.savemat"
        }
        [b'P', b'K', 3, 4, ..] => ", a ZIP archive such as .xlsx or .npz: export its table as CSV",
        [0xd0, 0xcf, 0x11, 0xe0, ..] => ", an Excel workbook (.xls): export its table as CSV",
        [0x1f, 0x8b, ..] => ", compressed by gzip: unpack it first",
        [b'T', b'D', b'S', b'm', ..] => {
            " of LabVIEW (TDMS): export it as text, or read it with npTDMS and save it as MAT"
        }
        [
            b'0'..=b'9',
            b'0'..=b'9',
            b'0'..=b'9',
            b'0'..=b'9',
            b'0'..=b'9',
            b'0'..=b'9',
            b'D' | b'R' | b'Q' | b'M',
            b' ',
            ..,
        ]
        | [b'M', b'S', 3, ..] => {
            " of MiniSEED: ObsPy reads it, takes the instrument's response off (remove_response, ACC) and writes it as text"
        }
        _ if is_sac(bytes) => " of SAC: ObsPy reads it and writes it as text",
        _ if is_mat_4(bytes) => {
            " of MATLAB 4: save it with `-v7`, or load it with scipy.io.loadmat and save it again"
        }
        _ => "",
    }
}

/// A seismologist's file: its header version, the 77th four-byte word, is 6 or 7.
fn is_sac(bytes: &[u8]) -> bool {
    matches!(
        bytes.get(304..308),
        Some([6 | 7, 0, 0, 0] | [0, 0, 0, 6 | 7])
    )
}

/// Five numbers (type, rows, columns, complex or not, length of the name) and a name that ends with a zero.
fn is_mat_4(bytes: &[u8]) -> bool {
    let (words, _) = bytes.as_chunks::<4>();
    let (Some(words), true) = (words.get(..5), bytes.len() > 20) else {
        return false;
    };
    let number = |read: fn([u8; 4]) -> u32, at: usize| read(words[at]) as usize;
    [u32::from_le_bytes as fn([u8; 4]) -> u32, u32::from_be_bytes]
        .into_iter()
        .any(|read| {
            let (kind, complex, length) = (number(read, 0), number(read, 3), number(read, 4));
            let name = bytes.get(20..20 + length.min(64));
            kind < 5000 && complex < 2 && length > 1 && {
                name.and_then(<[u8]>::split_last)
                    .is_some_and(|(end, name)| {
                        *end == 0 && name.iter().all(|b| b.is_ascii_alphanumeric() || *b == b'_')
                    })
            }
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_text_in_every_encoding() {
        let said = "time_s,acc_g\n0,1 ö\n";
        let wide =
            |order: fn(u16) -> [u8; 2]| said.encode_utf16().flat_map(order).collect::<Vec<_>>();
        let (little, big) = (wide(u16::to_le_bytes), wide(u16::to_be_bytes));
        let western = said.replace('ö', "\u{1}").into_bytes();
        let western: Vec<u8> = western
            .into_iter()
            .map(|b| if b == 1 { 0xf6 } else { b })
            .collect();
        for bytes in [
            said.as_bytes().to_vec(),
            [b"\xef\xbb\xbf", said.as_bytes()].concat(),
            [&b"\xff\xfe"[..], &little].concat(),
            [&b"\xfe\xff"[..], &big].concat(),
            little,
            big,
            western,
        ] {
            assert_eq!(text("f", bytes).unwrap(), said);
        }
        let mac = said.replace('\n', "\r").into_bytes();
        assert_eq!(text("f", mac).unwrap(), said);
    }

    #[test]
    fn a_binary_file_is_named() {
        let mut sac = vec![0x11; 632];
        sac[304..308].copy_from_slice(&[6, 0, 0, 0]);
        for (bytes, said) in [
            (&b"\x93NUMPY\x01\x00v\x00"[..], "NumPy"),
            (b"000001D IU \x00\x00", "MiniSEED"),
            (b"MS\x03\x04\x00\x00", "MiniSEED"),
            (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1\x00\x00", ".xls"),
            (b"PK\x03\x04\x00\x00", "ZIP"),
            (b"\x1f\x8b\x08\x00\x00", "gzip"),
            (&sac, "SAC"),
            (
                b"\0\0\0\0\x09\0\0\0\x01\0\0\0\0\0\0\0\x05\0\0\0time\0\0\0",
                "MATLAB 4",
            ),
        ] {
            let e = text("f", bytes.to_vec()).unwrap_err().to_string();
            assert!(e.contains(said), "{e}");
        }
    }
}
