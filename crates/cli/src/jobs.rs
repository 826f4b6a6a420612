//! Verbs whose work is a list of independent jobs: `--jobs FOLDER --shard I/N`.

use crate::progress;
use clap::Args;
use sealegs::jobs::{JobFolder, JobList, Shard};
use serde::Serialize;
use serde_json::Value;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The options that such a verb has.
#[derive(Args)]
pub struct JobArguments {
    /// Write one file for each job into this folder, instead of a result; a job with a complete file is skipped.
    /// `sealegs merge FOLDER` combines the results
    #[arg(long, value_name = "FOLDER")]
    pub jobs: Option<PathBuf>,
    /// Do only every N-th job of the list, beginning with the I-th: one shard for each machine that shares the folder
    #[arg(long, value_name = "I/N", requires = "jobs")]
    pub shard: Option<Shard>,
}

/// A list of jobs of this program.
#[must_use]
pub fn list<S: AsRef<str>>(verb: &str, about: Value, names: &[S]) -> JobList {
    JobList::new(verb, crate::VERSION, about, names)
}

/// Does a shard's jobs and says how far the list is.
///
/// # Errors
///
/// A folder with other jobs, a job that fails, a disk that does not take a result.
pub fn work<T: Serialize>(
    path: &Path,
    shard: Option<Shard>,
    list: JobList,
    job: impl Fn(usize) -> anyhow::Result<T>,
) -> anyhow::Result<u8> {
    let shard = shard.unwrap_or_default();
    let folder = JobFolder::open(path, list)?;
    let bar = progress::spinner();
    let worked = folder.work(shard, &|name| bar.say(name), job);
    bar.finish();
    let worked = worked?;
    let place = path.display();
    let all = folder.list().jobs.len();
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "{place}: shard {shard} has {} of {all} jobs: {} done now, {} before",
        worked.jobs,
        worked.jobs - worked.kept,
        worked.kept
    )?;
    match worked.missing {
        0 => writeln!(out, "all {all} jobs are done: sealegs merge {place}")?,
        n => writeln!(out, "{n} jobs of other shards are missing")?,
    }
    Ok(0)
}
