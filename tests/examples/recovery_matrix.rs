//! Makes the recovery matrix: `cargo run --release --example recovery_matrix -- --strengths 3 --seeds 3`.
//!
//! It runs long, and can be stopped: every campaign's outcome is a line of the results file, and those that are there
//! already are not made again. Lines of another search are left out, and their campaigns made again. The file is kept beside
//! the page, so that the matrix can be gone on with anywhere.
//!
//! On several machines that share a folder each does its part, and whoever finds every campaign done writes lines and page:
//! `cargo run --release --example recovery_matrix -- --jobs FOLDER --shard 3/8`.

use clap::Parser;
use sealegs::jobs::{JobFolder, Shard};
use sealegs_reference::campaign::Rig;
use sealegs_tests::matrix::{Asked, Case, DURATION_S, Outcome, cases, error, jobs, run, stamp, table};
use std::error::Error;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// The recovery matrix
#[derive(Parser)]
struct Arguments {
    /// Strengths: 1 middle, 2 and dominant, 3 and weak
    #[arg(long, default_value_t = 3)]
    strengths: usize,
    /// Individuals per effect, bench and strength
    #[arg(long, default_value_t = 3)]
    seeds: u64,
    /// The first individual: those of a matrix that is to count were never looked at before
    #[arg(long, default_value_t = 1)]
    first_seed: u64,
    /// One row only, for example backlash, nothing, "backlash + coulomb-friction"
    #[arg(long)]
    only: Option<String>,
    /// locked or pendulum only
    #[arg(long, value_parser = rig)]
    bench: Option<Rig>,
    /// Threads
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Outcomes, one line each
    #[arg(long, default_value = "tests/recovery-matrix.jsonl")]
    results: PathBuf,
    /// Where campaigns are made, and those stay that were not diagnosed or not located right
    #[arg(long, default_value = "target/recovery-matrix/campaigns")]
    campaigns: PathBuf,
    /// The page
    #[arg(long, default_value = "tests/recovery-matrix.md")]
    page: PathBuf,
    /// Keep one file for each campaign in this folder; those that are whole are not made again
    #[arg(long)]
    jobs: Option<PathBuf>,
    /// Do only every N-th campaign, beginning with the I-th
    #[arg(long, value_name = "I/N", requires = "jobs")]
    shard: Option<Shard>,
}

fn rig(name: &str) -> Result<Rig, String> {
    [Rig::Locked, Rig::Pendulum]
        .into_iter()
        .find(|r| r.as_str() == name)
        .ok_or_else(|| "locked or pendulum".to_owned())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    rayon::ThreadPoolBuilder::new().num_threads(arguments.threads).build_global()?;
    std::fs::create_dir_all(&arguments.campaigns)?;
    if let Some(folder) = arguments.results.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let asked = Asked {
        strengths: arguments.strengths,
        seeds: arguments.seeds,
        first_seed: arguments.first_seed,
        only: arguments.only.clone(),
        rig: arguments.bench,
    };
    let wanted = cases(&asked);
    let done = match &arguments.jobs {
        None => alone(&arguments, &wanted)?,
        Some(folder) => match shard(&arguments, folder, &wanted)? {
            Some(done) => done,
            None => return Ok(()),
        },
    };
    let order: Vec<String> =
        cases(&Asked { strengths: 3, only: None, rig: None, ..asked }).iter().map(Case::name).collect();
    write(&arguments, done, &order)
}

/// Makes what the results file does not have yet, and appends it.
fn alone(arguments: &Arguments, wanted: &[Case]) -> Result<Vec<Outcome>, Box<dyn Error>> {
    let search = stamp()?;
    let mut done = read(&arguments.results)?;
    if done.iter().any(|o| o.search != search) {
        done.retain(|o| o.search == search);
        std::fs::write(&arguments.results, lines(&done)?)?;
    }
    for (number, case) in wanted.iter().enumerate() {
        if done.iter().any(|o| o.name == case.name()) {
            continue;
        }
        let outcome = run(case, DURATION_S, &arguments.campaigns)?;
        let mut file = std::fs::OpenOptions::new().create(true).append(true).open(&arguments.results)?;
        file.write_all(lines(std::slice::from_ref(&outcome))?.as_bytes())?;
        tell(&outcome, number, wanted.len());
        done.push(outcome);
    }
    Ok(done)
}

/// Makes a shard's part of what the folder does not have yet; all outcomes, if every campaign has one then.
fn shard(
    arguments: &Arguments,
    folder: &Path,
    wanted: &[Case],
) -> Result<Option<Vec<Outcome>>, Box<dyn Error>> {
    let folder = JobFolder::open(folder, jobs(wanted, DURATION_S)?)?;
    let make = |number: usize| -> Result<Outcome, Box<dyn Error>> {
        let outcome = run(&wanted[number], DURATION_S, &arguments.campaigns)?;
        tell(&outcome, number, wanted.len());
        Ok(outcome)
    };
    let worked = folder.work(arguments.shard.unwrap_or_default(), &|_| (), make)?;
    if worked.missing > 0 {
        eprintln!("{} campaigns of other shards are missing", worked.missing);
        return Ok(None);
    }
    let done = folder.results()?;
    std::fs::write(&arguments.results, lines(&done)?)?;
    Ok(Some(done))
}

/// Says what came out.
fn tell(outcome: &Outcome, number: usize, of: usize) {
    eprintln!(
        "{}/{of} {}: {}, {} {} ({} -> {}, {:.0} s)",
        number + 1,
        outcome.name,
        outcome.score,
        outcome.verdict,
        outcome.said.join(" + "),
        error(outcome.base_error),
        error(outcome.after_error),
        outcome.seconds.unwrap_or(0.0)
    );
}

/// Outcomes as lines of the results file.
fn lines(outcomes: &[Outcome]) -> serde_json::Result<String> {
    outcomes.iter().map(|o| Ok(serde_json::to_string(o)? + "\n")).collect()
}

/// Writes the page, in the order of the table, whatever the order in which the outcomes were made.
fn write(arguments: &Arguments, mut done: Vec<Outcome>, order: &[String]) -> Result<(), Box<dyn Error>> {
    let place = |o: &Outcome| order.iter().position(|n| *n == o.name).unwrap_or(order.len());
    done.sort_by_key(place);
    std::fs::write(&arguments.page, table(&done, order.len(), &today()))?;
    Ok(())
}

/// The outcomes that are there; a last line that was cut short is left out.
fn read(path: &Path) -> Result<Vec<Outcome>, Box<dyn Error>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(path)?;
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    whole.lines().map(|line| Ok(serde_json::from_str(line)?)).collect()
}

/// Today's date in UTC, by the civil calendar (H. Hinnant, `civil_from_days`).
fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let z = seconds / 86_400 + 719_468;
    let (era, of_era) = (z / 146_097, z % 146_097);
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let day = of_era - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let (d, m) = (day - (153 * month + 2) / 5 + 1, if month < 10 { month + 3 } else { month - 9 });
    format!("{}-{m:02}-{d:02}", year + era * 400 + u64::from(m <= 2))
}
