//! JSON schemas of the results, made from their types.
//!
//! They describe what `--json` writes (JSON Schema 2020-12): a key that may be left out is not required. The published ones
//! are in `docs/schema`.

use crate::comparison::Summary as Comparison;
use crate::diagnosis::addition::Summary as Addition;
use crate::diagnosis::outcome::Outcome;
use crate::impact::ImpactTable;
use crate::mystery::Judgement;
use crate::{Result, json};
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};

/// A schema with the name of its file.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// The file's name: `diagnose.json`.
    pub file: &'static str,
    /// Its text.
    pub text: String,
}

/// Every schema that is published: of `compare`, `diagnose`, `add`, `impact` and `mystery --judge`.
///
/// ```
/// let diagnose = sealegs::schema::all()?.into_iter().find(|s| s.file == "diagnose.json");
/// assert!(diagnose.is_some_and(|s| s.text.contains("unexplained_share")));
/// # Ok::<(), sealegs::Error>(())
/// ```
///
/// # Errors
///
/// None for the types of this version.
pub fn all() -> Result<Vec<Published>> {
    let one =
        |file, schema: Schema| -> Result<Published> { Ok(Published { file, text: json(&schema)? + "\n" }) };
    Ok(vec![
        one("compare.json", of::<Comparison>("sealegs compare --json"))?,
        one("diagnose.json", of::<Outcome>("sealegs diagnose --json, of one campaign"))?,
        one("diagnose-several.json", of::<Vec<Outcome>>("sealegs diagnose --json, of several campaigns"))?,
        one("add.json", of::<Addition>("sealegs add --json"))?,
        one("impact.json", of::<ImpactTable>("sealegs impact --json"))?,
        one("mystery.json", of::<Judgement>("sealegs mystery --judge --json"))?,
    ])
}

/// The schema of a type as it is written, under a title.
fn of<T: JsonSchema>(title: &str) -> Schema {
    let generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let mut schema = generator.into_root_schema_for::<T>();
    schema.insert("title".to_owned(), title.into());
    schema
}
