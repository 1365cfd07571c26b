//! Text in the encodings that laboratories export: UTF-8, UTF-16, and the one of Western Windows.

use super::{look_ahead, plain, third_party};
use crate::failure::Failure;
use encoding_rs::{Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};
use std::io::{ErrorKind, Read};
use std::path::Path;

/// Reads a file as bytes; `-` is standard input.
///
/// # Errors
/// A file that cannot be read, or that this command will write, by its name.
pub fn bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    look_ahead::refuse_output(path)?;
    bytes_to_edit(path)
}

/// The same of a file that will be written back.
///
/// # Errors
/// A file that cannot be read, by its name; of a third-party one that is not there, where it is published.
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
/// Bytes that are no text.
pub fn text(file: &str, bytes: Vec<u8>) -> Result<String, Failure> {
    let text = decoded(file, bytes)?;
    // Lines of an old Macintosh, which some plotting programs still write.
    Ok(match text.contains('\r') && !text.contains('\n') {
        true => text.replace('\r', "\n"),
        false => text,
    })
}

fn decoded(file: &str, bytes: Vec<u8>) -> Result<String, Failure> {
    if let Some(encoding) = wide(&bytes) {
        return Ok(encoding.decode(&bytes).0.into_owned());
    }
    if bytes.contains(&0) {
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
        // Every byte is a letter there: an umlaut in a title, a degree sign, a superscript two.
        Err(e) => Ok(WINDOWS_1252.decode(e.as_bytes()).0.into_owned()),
    }
}

/// UTF-16, by its mark or because every other byte is zero, as of digits and Western letters.
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

/// What a binary file seems to be, and what to do with it.
fn kind(bytes: &[u8]) -> &'static str {
    match bytes {
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => {
            " of NumPy: write it with numpy.savetxt or scipy.io.savemat"
        }
        [b'P', b'K', 3, 4, ..] => ", a ZIP archive such as .xlsx or .npz: export its table as CSV",
        [0xd0, 0xcf, 0x11, 0xe0, ..] => ", an Excel workbook (.xls): export its table as CSV",
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
            " of MiniSEED, which is read as a ground motion alone: ObsPy writes it as text"
        }
        _ => "",
    }
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
        for (bytes, said) in [
            (&b"\x93NUMPY\x01\x00v\x00"[..], "NumPy"),
            (b"000001D IU \x00\x00", "MiniSEED"),
            (b"MS\x03\x04\x00\x00", "MiniSEED"),
            (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1\x00\x00", ".xls"),
            (b"PK\x03\x04\x00\x00", "ZIP"),
        ] {
            let e = text("f", bytes.to_vec()).unwrap_err().to_string();
            assert!(e.contains(said), "{e}");
        }
    }
}
