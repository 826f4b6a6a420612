//! `sealegs merge`: the results of a list of jobs, put together into the one that the serial run gives.

use super::{diagnose, impact, mystery};
use crate::failure::bad_input;
use crate::output::Destination;
use clap::Args;
use sealegs::jobs::JobFolder;
use std::path::PathBuf;

/// Put together what the shards of `diagnose`, `impact` or `mystery` have computed: the same result, to the last bit, as without
/// `--jobs`
#[derive(Args)]
pub struct Merge {
    /// The folder that `--jobs` named
    folder: PathBuf,
    /// Write the result as JSON (`-` for standard output)
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Of `impact`: write the table as CSV
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Of `impact`: write a report as one HTML file
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Of `mystery`: the folder to make
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input for a folder without a list of jobs, for jobs that have no whole result, and for an option that is another
/// verb's.
pub fn run(arguments: &Merge) -> anyhow::Result<u8> {
    let folder = JobFolder::read(&arguments.folder)?;
    let verb = folder.list().verb.clone();
    let only = |option: &str, given: bool, of: &str| match given && verb != of {
        true => Err(bad_input(format!("{option}: the jobs are those of `{verb}`, not of `{of}`"))),
        false => Ok(()),
    };
    only("--csv", arguments.csv.is_some(), impact::VERB)?;
    only("--report", arguments.report.is_some(), impact::VERB)?;
    only("--output", arguments.output.is_some(), mystery::VERB)?;
    match verb.as_str() {
        impact::VERB => impact::merge(
            &folder,
            impact::Outputs::new(arguments.csv.as_ref(), arguments.json.as_ref(), arguments.report.as_ref())?,
        ),
        diagnose::VERB => diagnose::merge(&folder, Destination::optional(arguments.json.as_ref())?),
        mystery::VERB => mystery::merge(&folder, arguments.output.as_deref(), arguments.json.as_ref()),
        other => Err(bad_input(format!(
            "{}: jobs of `{other}`, which this program cannot put together",
            arguments.folder.display()
        ))),
    }
}
