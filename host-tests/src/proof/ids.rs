//! What is to be proved: every command, fault, obstacle, limit, and pair of mode and event, from the code's own lists.

use link::Command;
use link::reply::{NotReady, Obstacle};
use outerloop_core::config::Limits;
use outerloop_core::{Event, Fault, Mode};
use serde::de::{DeserializeOwned, Deserializer, Error as _, Visitor, value::Error};
use serde::forward_to_deserialize_any;

/// The kind of an id.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A command of the PC to the board.
    Command,
    /// What trips a test.
    Fault,
    /// What blocks arming, or starting.
    Obstacle,
    /// A key of `[limits]`.
    Limit,
    /// An event in a mode.
    Mode,
}

impl Kind {
    /// Every kind, in the order of the page.
    pub const ALL: [Self; 5] = [
        Self::Command,
        Self::Fault,
        Self::Obstacle,
        Self::Limit,
        Self::Mode,
    ];

    /// The first word of its ids.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Command => "command",
            Self::Fault => "fault",
            Self::Obstacle => "obstacle",
            Self::Limit => "limit",
            Self::Mode => "mode",
        }
    }
}

/// Something to be proved.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Id {
    /// Its kind.
    pub kind: Kind,
    /// Its name in a claim: `fault.adc_rail`, `mode.idle.arm`.
    pub name: String,
    /// Words that the code of a test must all contain to claim it.
    pub words: Vec<String>,
}

impl Id {
    /// Whether it is listed: by its name, or by the beginning of it before an asterisk.
    pub fn is_meant_by(&self, listed: &str) -> bool {
        match listed.strip_suffix('*') {
            Some(begin) => self.name.starts_with(begin),
            None => self.name == listed,
        }
    }
}

/// Every id.
pub fn all() -> Vec<Id> {
    let enums = |kind: Kind, rust: &str, names: &[&str]| -> Vec<Id> {
        let id = |variant: &&str| Id {
            kind,
            name: format!("{}.{}", kind.name(), snake(variant)),
            words: vec![format!("{rust}::{variant}")],
        };
        names.iter().map(id).collect()
    };
    let mut ids = enums(Kind::Command, "Command", names_of::<Command>());
    for fault in Fault::ALL {
        ids.push(Id {
            kind: Kind::Fault,
            name: format!("fault.{}", fault.name()),
            words: vec![format!("Fault::{fault:?}")],
        });
    }
    ids.extend(enums(Kind::Obstacle, "Obstacle", names_of::<Obstacle>()));
    ids.extend(enums(Kind::Obstacle, "NotReady", names_of::<NotReady>()));
    for limit in names_of::<Limits>() {
        ids.push(Id {
            kind: Kind::Limit,
            name: format!("limit.{limit}"),
            words: vec![(*limit).to_owned()],
        });
    }
    for mode in Mode::ALL {
        for event in Event::ALL {
            ids.push(Id {
                kind: Kind::Mode,
                name: pair(mode, event),
                words: vec![format!("Mode::{mode:?}"), format!("Event::{event:?}")],
            });
        }
    }
    ids
}

/// The id of an event in a mode.
pub fn pair(mode: Mode, event: Event) -> String {
    let [mode, event] = [format!("{mode:?}"), format!("{event:?}")].map(|n| snake(&n));
    format!("mode.{mode}.{event}")
}

fn snake(variant: &str) -> String {
    let mut name = String::new();
    for c in variant.chars() {
        if c.is_uppercase() && !name.is_empty() {
            name.push('_');
        }
        name.extend(c.to_lowercase());
    }
    name
}

/// The names of an enum's variants or a struct's fields, as deserialized.
fn names_of<T: DeserializeOwned>() -> &'static [&'static str] {
    let mut names: &'static [&'static str] = &[];
    // Returns the names and no value.
    let _ = T::deserialize(Names(&mut names));
    names
}

/// A deserializer that gives no value and keeps the names.
struct Names<'a>(&'a mut &'static [&'static str]);

impl<'de> Deserializer<'de> for Names<'_> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        Err(Error::custom("it has no names"))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, Error> {
        *self.0 = variants;
        Err(Error::custom("its names are enough"))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, Error> {
        *self.0 = fields;
        Err(Error::custom("its names are enough"))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_list_of_the_code_is_there_by_its_names() {
        let ids = all();
        let count = |kind| ids.iter().filter(|id| id.kind == kind).count();
        assert_eq!(count(Kind::Fault), Fault::ALL.len());
        assert_eq!(count(Kind::Mode), Mode::ALL.len() * Event::ALL.len());
        // For the others the code has no list except the type itself.
        assert!(count(Kind::Command) >= 13 && count(Kind::Obstacle) >= 9);
        for name in [
            "command.identify",
            "fault.stale_sample",
            "obstacle.nothing_to_run",
            "obstacle.strained",
            "limit.tracking_m",
            "mode.approaching.stop",
        ] {
            assert!(ids.iter().any(|id| id.name == name), "{name}");
        }
    }
}
