//! Recorded data in binary files: MAT (version 5 and 7.3) and HDF5.

use super::header::Header;
use super::table::NumberTable;
use crate::failure::Failure;
use hdf5_pure::{DType, File, Group};
use matfile::{MatFile, NumericData};

/// A matrix with more columns than this is an image, not a record.
const MOST_COLUMNS: usize = 64;

/// True if `bytes` belong to a file that [`parse`] reads.
pub fn is_binary(bytes: &[u8]) -> bool {
    is_mat5(bytes) || hdf5_pure::is_hdf5_bytes(bytes)
}

fn is_mat5(bytes: &[u8]) -> bool {
    bytes.starts_with(b"MATLAB 5.0")
}

/// The vectors and the columns of the matrices in a file that have the most common length.
///
/// # Errors
/// A file that cannot be read, or that contains no series.
pub fn parse(file: &str, bytes: Vec<u8>) -> Result<NumberTable, Failure> {
    let all = if is_mat5(&bytes) {
        if is_cut_off(&bytes) {
            return Err(Failure::input(format!(
                "{file}: ends in the middle of a variable: accepted is the whole file; was it copied to its end?"
            )));
        }
        mat5(&bytes)
    } else {
        hdf5(bytes)
    }
    .map_err(|why| Failure::input(format!("{file}: cannot be read: {why}")))?;
    let length = usual_length(&all).ok_or_else(|| {
        Failure::input(format!(
            "{file}: holds no series of numbers: accepted are vectors, or matrices with a quantity a column; {}",
            if all.is_empty() {
                "structures of version 5 and cells are not read: save with save(..., '-v7.3'), or their fields as variables"
            } else {
                "single numbers are no record"
            }
        ))
    })?;
    // A single number or a table of settings is no channel; a channel of another length must not vanish silently.
    let odd = all.iter().find(|(name, values)| {
        values.len() > 1 && values.len() != length && Header::of(name, None).likely().is_some()
    });
    if let Some((name, values)) = odd {
        return Err(Failure::input(format!(
            "{file}: {name} has {} values and the other series {length}: accepted are channels of one length",
            values.len()
        )));
    }
    let (names, columns): (Vec<String>, Vec<Vec<f64>>) = all
        .into_iter()
        .filter(|(_, values)| values.len() == length)
        .unzip();
    NumberTable::of_columns(file, "its variables", &names, columns)
}

/// True if a MAT file of version 5 is shorter than its parts say: each begins with its type and its length.
fn is_cut_off(bytes: &[u8]) -> bool {
    let little = bytes.get(126..128) == Some(b"IM");
    let mut at = 128;
    while let Some(length) = bytes.get(at + 4..at + 8).and_then(|b| b.try_into().ok()) {
        let length = if little {
            u32::from_le_bytes(length)
        } else {
            u32::from_be_bytes(length)
        };
        at += 8 + length as usize;
    }
    at > bytes.len()
}

/// The most common length of the series; of two equally common ones, the longer.
fn usual_length(all: &[(String, Vec<f64>)]) -> Option<usize> {
    let lengths = || all.iter().map(|(_, v)| v.len()).filter(|n| *n > 1);
    lengths().max_by_key(|n| (lengths().filter(|m| m == n).count(), *n))
}

type Series = Vec<(String, Vec<f64>)>;

fn mat5(bytes: &[u8]) -> Result<Series, String> {
    let mat = MatFile::parse(bytes).map_err(|e| e.to_string())?;
    let mut all = Series::new();
    for array in mat.arrays() {
        let values = match array.data() {
            NumericData::Double { real, .. } => real.clone(),
            NumericData::Single { real, .. } => real.iter().map(|x| f64::from(*x)).collect(),
            NumericData::Int8 { real, .. } => real.iter().map(|x| f64::from(*x)).collect(),
            NumericData::UInt8 { real, .. } => real.iter().map(|x| f64::from(*x)).collect(),
            NumericData::Int16 { real, .. } => real.iter().map(|x| f64::from(*x)).collect(),
            NumericData::UInt16 { real, .. } => real.iter().map(|x| f64::from(*x)).collect(),
            NumericData::Int32 { real, .. } => real.iter().map(|x| f64::from(*x)).collect(),
            NumericData::UInt32 { real, .. } => real.iter().map(|x| f64::from(*x)).collect(),
            NumericData::Int64 { real, .. } => real.iter().map(|x| *x as f64).collect(),
            NumericData::UInt64 { real, .. } => real.iter().map(|x| *x as f64).collect(),
        };
        let [rows, columns] = match array.size()[..] {
            [1, n] | [n, 1] | [n] => [n, 1],
            [rows, columns] => [rows, columns],
            _ => continue,
        };
        // MATLAB writes in column-major order.
        add(&mut all, array.name(), &values, rows, columns, false);
    }
    Ok(all)
}

fn hdf5(bytes: Vec<u8>) -> Result<Series, String> {
    let file = File::from_bytes(bytes).map_err(|e| e.to_string())?;
    let root = file.root();
    // MATLAB's matrices are transposed in the file: its rows are the file's columns.
    let (datasets, groups) = (root.datasets(), root.groups());
    let datasets = datasets.map_err(|e| e.to_string())?;
    let groups = groups.map_err(|e| e.to_string())?;
    let of_datasets = datasets
        .iter()
        .filter_map(|name| root.dataset(name).ok()?.attrs().ok());
    let of_groups = groups
        .iter()
        .filter_map(|name| root.group(name).ok()?.attrs().ok());
    let of_matlab = of_datasets
        .chain(of_groups)
        .any(|attributes| attributes.contains_key("MATLAB_class"));
    let mut all = Series::new();
    collect(&root, "", of_matlab, &mut all)?;
    Ok(if of_matlab {
        without_structure(all)
    } else {
        all
    })
}

/// For a MATLAB file with everything in one structure: the names of its fields.
fn without_structure(mut all: Series) -> Series {
    while let Some((group, _)) = all.first().and_then(|(name, _)| name.split_once('/')) {
        let group = format!("{group}/");
        if !all.iter().all(|(name, _)| name.starts_with(&group)) {
            break;
        }
        for (name, _) in &mut all {
            name.drain(..group.len());
        }
    }
    all
}

const fn is_number(kind: &DType) -> bool {
    use DType as D;
    matches!(
        kind,
        D::F32 | D::F64 | D::I8 | D::I16 | D::I32 | D::I64 | D::U8 | D::U16 | D::U32 | D::U64
    )
}

fn collect(group: &Group, path: &str, of_matlab: bool, all: &mut Series) -> Result<(), String> {
    for name in group.datasets().map_err(|e| e.to_string())? {
        let data = group.dataset(&name).map_err(|e| e.to_string())?;
        let whole = format!("{path}{name}");
        let shape = data.shape().map_err(|e| e.to_string())?;
        let [rows, columns] = match shape[..] {
            [1, n] | [n, 1] | [n] => [n, 1],
            [columns, rows] if of_matlab => [rows, columns],
            [rows, columns] => [rows, columns],
            _ => continue,
        };
        // Non-numeric data, such as text, is not a series.
        if !data.dtype().is_ok_and(|kind| is_number(&kind)) {
            continue;
        }
        let values = data.read_f64().map_err(|e| {
            format!("{whole}: {e}; is the file whole? h5repack writes what the newest HDF5 stores in an older form")
        })?;
        let (rows, columns) = (rows as usize, columns as usize);
        add(all, &whole, &values, rows, columns, !of_matlab);
    }
    for name in group.groups().map_err(|e| e.to_string())? {
        // MATLAB keeps its bookkeeping in groups with such names.
        if !name.starts_with('#') {
            let inner = group.group(&name).map_err(|e| e.to_string())?;
            collect(&inner, &format!("{path}{name}/"), of_matlab, all)?;
        }
    }
    Ok(())
}

/// Adds a vector, or a matrix by columns: `name(1)`, `name(2)`, ... `by_row`: the order of its numbers.
fn add(all: &mut Series, name: &str, values: &[f64], rows: usize, columns: usize, by_row: bool) {
    if values.len() != rows * columns || columns > MOST_COLUMNS {
        return;
    }
    for j in 0..columns {
        let at = |i: usize| {
            if by_row {
                i * columns + j
            } else {
                j * rows + i
            }
        };
        let name = match columns {
            1 => name.to_owned(),
            _ => format!("{name}({})", j + 1),
        };
        all.push((name, (0..rows).map(|i| values[at(i)]).collect()));
    }
}
