//! The structures behind a test file, read from their own source: names, types and what their documentation says.

use std::collections::HashMap;
use syn::{Attribute, Expr, Fields, GenericArgument, Item, Lit, Meta, PathArguments, Type};

/// The files that define what a test file holds.
const SOURCES: [&str; 17] = [
    include_str!("../../../core/src/config/mod.rs"),
    include_str!("../../../core/src/config/compensation.rs"),
    include_str!("../../../core/src/config/rig.rs"),
    include_str!("../../../plant/src/rig.rs"),
    include_str!("../../../plant/src/actuator/spec.rs"),
    include_str!("../../../plant/src/actuator/servo_hydraulic.rs"),
    include_str!("../../../plant/src/measurement.rs"),
    include_str!("../../../plant/src/specimen/spec.rs"),
    include_str!("../../../plant/src/coupled/actuators.rs"),
    include_str!("../../../plant/src/coupled/coupler.rs"),
    include_str!("../../../plant/src/coupled/rig.rs"),
    include_str!("../../../plant/src/coupled/specimen.rs"),
    include_str!("../../../experiment/src/coupled/table.rs"),
    include_str!("../../../diagnosis/src/model.rs"),
    include_str!("../../../experiment/src/files/test.rs"),
    include_str!("../../../experiment/src/files/serve.rs"),
    include_str!("../../../experiment/src/files/watch.rs"),
];

/// What a key holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ValueKind {
    /// A number.
    Number,
    /// A whole number.
    Integer,
    /// A number, or a list with one for each floor or axis.
    Numbers,
    /// A list of so many numbers.
    List(usize),
    /// Rows of numbers; of how many rows, where that is fixed.
    Matrix(Option<usize>),
    /// A list of texts.
    Texts,
    /// A text, for example a path.
    Text,
    /// True or false.
    Flag,
    /// A name out of a list that the code has.
    Name,
    /// A table by its structure's name.
    Table(String),
    /// A list of tables, whose keys depend on each other.
    Tables,
}

/// A field of a structure.
#[derive(Clone, Debug)]
pub struct Field {
    /// Its key.
    pub name: String,
    /// What it holds.
    pub kind: ValueKind,
    /// Its documentation, in one paragraph.
    pub meaning: String,
}

/// A structure: its meaning and its fields.
#[derive(Clone, Debug)]
pub struct SourceStruct {
    /// Its documentation.
    pub meaning: String,
    /// Its fields, in their order.
    pub fields: Vec<Field>,
}

/// Every structure with named fields, by its name.
pub fn structures() -> HashMap<String, SourceStruct> {
    let mut all = HashMap::new();
    for source in SOURCES {
        // It has been compiled: it can be parsed.
        let Ok(file) = syn::parse_file(source) else {
            continue;
        };
        for item in file.items {
            // Only what is read from files; a working part may have the name of its description.
            if let Item::Struct(s) = item
                && s.attrs.iter().any(is_read)
                && let Fields::Named(fields) = &s.fields
            {
                let fields = fields.named.iter().map(field).collect();
                let meaning = documentation(&s.attrs);
                all.insert(s.ident.to_string(), SourceStruct { meaning, fields });
            }
        }
    }
    all
}

/// True if an attribute derives `Deserialize`.
fn is_read(attribute: &Attribute) -> bool {
    match &attribute.meta {
        Meta::List(list) => list.tokens.to_string().contains("Deserialize"),
        _ => false,
    }
}

fn field(f: &syn::Field) -> Field {
    let name = f.ident.as_ref().map(ToString::to_string);
    Field {
        name: renamed(&f.attrs).or(name).unwrap_or_default(),
        kind: kind(&f.ty),
        meaning: documentation(&f.attrs),
    }
}

fn kind(ty: &Type) -> ValueKind {
    match ty {
        Type::Array(list) => match &list.len {
            Expr::Lit(n) => match &n.lit {
                Lit::Int(n) if matches!(*list.elem, Type::Array(_)) => {
                    ValueKind::Matrix(n.base10_parse().ok())
                }
                Lit::Int(n) => ValueKind::List(n.base10_parse().unwrap_or(0)),
                _ => ValueKind::Numbers,
            },
            _ => ValueKind::Numbers,
        },
        Type::Path(path) => {
            let Some(last) = path.path.segments.last() else {
                return ValueKind::Name;
            };
            let inner = match &last.arguments {
                PathArguments::AngleBracketed(a) => a.args.iter().find_map(|a| match a {
                    GenericArgument::Type(ty) => Some(ty),
                    _ => None,
                }),
                _ => None,
            };
            match (last.ident.to_string().as_str(), inner) {
                ("Option", Some(inner)) => kind(inner),
                ("Vec", Some(inner)) => match kind(inner) {
                    ValueKind::Number => ValueKind::Numbers,
                    ValueKind::Numbers => ValueKind::Matrix(None),
                    ValueKind::Text => ValueKind::Texts,
                    _ => ValueKind::Tables,
                },
                ("f64" | "f32", _) => ValueKind::Number,
                ("u8" | "u16" | "u32" | "u64" | "usize", _) => ValueKind::Integer,
                ("PerFloor" | "PerActuator" | "PerAxis" | "ActuatorTimes" | "OwnParameters", _) => {
                    ValueKind::Numbers
                }
                ("String" | "PathBuf", _) => ValueKind::Text,
                ("bool", _) => ValueKind::Flag,
                (name, _) => ValueKind::Table(name.to_owned()),
            }
        }
        _ => ValueKind::Name,
    }
}

fn renamed(attributes: &[Attribute]) -> Option<String> {
    attributes.iter().find_map(|a| {
        let Meta::List(list) = &a.meta else {
            return None;
        };
        let text = list.tokens.to_string();
        let (_, rest) = text.split_once("rename = \"")?;
        Some(rest.split_once('"')?.0.to_owned())
    })
}

fn documentation(attributes: &[Attribute]) -> String {
    let lines = attributes.iter().filter_map(|a| match &a.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            Expr::Lit(text) => match &text.lit {
                Lit::Str(text) => Some(text.value().trim().to_owned()),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    });
    lines.collect::<Vec<_>>().join(" ").trim().to_owned()
}
