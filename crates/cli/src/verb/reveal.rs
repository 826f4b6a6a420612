//! `sealegs reveal`: the answer of a mystery, and how a verdict stands against it.

use crate::failure::{OrBadInput, bad_input};
use clap::Args;
use sealegs::mystery::answer::{self, Answer};
use sealegs::mystery::{Verdict, page};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Open the answer of a mystery, and judge a verdict on it
#[derive(Args)]
pub struct Reveal {
    /// The mystery's folder
    folder: PathBuf,
    /// What `sealegs diagnose --json` wrote of it
    #[arg(long, value_name = "FILE.json")]
    verdict: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input if there is no sealed answer, if it or the verdict cannot be read, or if the verdict is on another
/// campaign.
pub fn run(arguments: &Reveal) -> anyhow::Result<u8> {
    let sealed = arguments.folder.join(answer::FILE);
    let answer =
        Answer::opened(&read(&sealed)?).map_err(|e| bad_input(format!("{}: {e:#}", sealed.display())))?;
    let verdict = match &arguments.verdict {
        None => None,
        Some(path) => {
            let verdict: Verdict = serde_json::from_str(&read(path)?).map_err(|e| {
                bad_input(format!("{}: no verdict of `diagnose --json`: {e}", path.display()))
            })?;
            if verdict.campaign != answer.campaign {
                return Err(bad_input(format!(
                    "{}: a verdict on '{}', not on '{}'",
                    path.display(),
                    verdict.campaign,
                    answer.campaign
                )));
            }
            Some(verdict)
        }
    };
    write!(std::io::stdout().lock(), "{}", page(&answer, verdict.as_ref()))?;
    Ok(0)
}

fn read(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path)
        .map_err(|e| format!("{}: cannot be read: {e}", path.display()))
        .or_bad_input()
}
