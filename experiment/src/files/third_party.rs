//! Where a third-party file is published, by its name: for messages about missing files.

use crate::failure::Failure;
use serde_json::Value;
use std::path::Path;

/// The data used by `scripts/fetch-data`.
const SOURCES: &str = include_str!("../../../scripts/data-sources.json");

/// The refusal of a missing third-party file: whose it is, where it is published, and how to get it. `None` if no
/// third-party file has this name.
pub fn missing(path: &Path) -> Option<Failure> {
    let name = path.file_name()?;
    let known: Value = serde_json::from_str(SOURCES).ok()?;
    let file = known["files"].as_array()?.iter().find(|file| {
        file["path"]
            .as_str()
            .map(Path::new)
            .and_then(Path::file_name)
            == Some(name)
    })?;
    let source = &known["sources"][file["source"].as_str()?];
    let address = match (source["repository"].as_str(), source["address"].as_str()) {
        (Some(repository), _) => format!("https://github.com/{repository}"),
        (None, address) => address?.to_owned(),
    };
    let comes = match (file["by_hand"].as_str(), file["from"].as_str()) {
        (Some(why), _) => format!("it is brought by hand ({why})"),
        (None, Some(from)) => format!("`scripts/fetch-data` makes it of {from}"),
        (None, None) => "`scripts/fetch-data` brings it".to_owned(),
    };
    Some(Failure::input(format!(
        "{}: is not there: it is other people's and no part of outerloop, published at {address}; {comes}, and docs/data.md says \
         what it holds and where it is looked for",
        path.display()
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_third_party_file_is_known_with_its_address_and_no_other() {
        let known: Value = serde_json::from_str(SOURCES).unwrap();
        for file in known["files"].as_array().unwrap() {
            let path = Path::new("elsewhere").join(file["path"].as_str().unwrap());
            let said = missing(&path).unwrap().to_string();
            assert!(said.contains("https://"), "{said}");
            let by_hand = said.contains("is brought by hand (");
            assert!(by_hand != file["convert"].is_string(), "{said}");
        }
        assert!(missing(Path::new("my-own.csv")).is_none());
        assert!(missing(Path::new("..")).is_none());
    }
}
