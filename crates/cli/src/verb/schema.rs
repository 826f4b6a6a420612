//! `sealegs schema`: the JSON schemas of the results.

use crate::output::Destination;
use anyhow::Context;
use clap::Args;
use std::path::PathBuf;

/// Write the JSON schemas of what `--json` writes, one file for each verb
#[derive(Args)]
pub struct SchemaArguments {
    /// The folder, which is made if it is not there
    #[arg(short = 'o', long = "output", value_name = "FOLDER")]
    output: PathBuf,
}

/// Runs the verb.
///
/// # Errors
///
/// If a file cannot be written.
pub fn run(arguments: &SchemaArguments) -> anyhow::Result<u8> {
    let folder = &arguments.output;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    for schema in sealegs::schema::all()? {
        Destination::new(&folder.join(schema.file))?.write(schema.text.as_bytes())?;
    }
    Ok(0)
}
