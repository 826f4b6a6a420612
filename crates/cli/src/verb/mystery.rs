//! `sealegs mystery`: campaigns with something hidden in them, to practise on, or to see how often `diagnose` is right.

use crate::failure::bad_input;
use crate::jobs::{self, JobArguments};
use crate::output::{Destination, NewFolder};
use crate::progress;
use clap::{Args, ValueEnum};
use sealegs::Options;
use sealegs::jobs::JobFolder;
use sealegs::mystery::{
    self, DURATION_S, Judged, Judgement, Mystery, answer, bench_mystery, judge, leg_mystery,
};
use sealegs::reference::campaign::Rig;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// What the mystery is recorded on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Bench {
    /// Both links held
    Locked,
    /// The screw turns a pendulum
    Pendulum,
    /// A whole leg, swinging on a stand or landing on a rail
    Leg,
}

impl Bench {
    fn as_str(self) -> &'static str {
        match self {
            Self::Locked => Rig::Locked.as_str(),
            Self::Pendulum => Rig::Pendulum.as_str(),
            Self::Leg => "leg",
        }
    }

    fn rig(self) -> Option<Rig> {
        match self {
            Self::Locked => Some(Rig::Locked),
            Self::Pendulum => Some(Rig::Pendulum),
            Self::Leg => None,
        }
    }
}

/// How hard it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Level {
    /// One effect of the catalogue that dominates the error.
    Easy,
    /// A weak effect, two at once, nothing at all, or one that is in no catalogue.
    Hard,
    /// A plain effect of the catalogue or nothing, in a log with one or two roughnesses.
    Rough,
}

impl Level {
    fn as_str(self) -> &'static str {
        match self {
            Self::Easy => "easy",
            Self::Hard => "hard",
            Self::Rough => "rough",
        }
    }
}

impl From<Level> for mystery::Level {
    fn from(level: Level) -> Self {
        match level {
            Level::Easy => Self::Easy,
            Level::Hard => Self::Hard,
            Level::Rough => Self::Rough,
        }
    }
}

/// Seeds as a list: `7`, `1,4`, `1-64`.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Seeds(Vec<u64>);

/// Most seeds of one list.
const MOST_SEEDS: usize = 9999;

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.parse::<u64>().map_err(|_| format!("'{text}' is no seed"));
        let mut seeds: Vec<u64> = Vec::new();
        for part in text.split(',') {
            let (first, last) = match part.split_once('-') {
                Some((first, last)) => (number(first)?, number(last)?),
                None => (number(part)?, number(part)?),
            };
            if first > last || last - first >= MOST_SEEDS as u64 {
                return Err(format!("'{part}': from the first to the last, at most {MOST_SEEDS}"));
            }
            seeds.extend(first..=last);
        }
        let mut once = seeds.clone();
        once.sort_unstable();
        once.dedup();
        if once.len() < seeds.len() || seeds.len() > MOST_SEEDS {
            return Err(format!("each seed once, and at most {MOST_SEEDS}"));
        }
        Ok(Self(seeds))
    }
}

/// Make a campaign with something hidden in it, to practise on; of several seeds one each
#[derive(Args)]
pub struct MysteryArguments {
    /// What it is recorded on
    #[arg(long, value_enum, default_value = "locked")]
    bench: Bench,
    /// Another seed hides something else; a list (`1,4`, `1-64`) makes a folder of campaigns
    #[arg(long, default_value = "1", value_name = "SEEDS")]
    seed: Seeds,
    /// How difficult the campaign is. A leg has no rough log, and hides no effect that is in no catalogue
    #[arg(long, value_enum, default_value = "easy")]
    level: Level,
    /// Duration of each run of a bench, s; 20 without it
    #[arg(long, value_name = "SECONDS")]
    duration: Option<f64>,
    /// The folder to make
    #[arg(short, long, value_name = "DIR", required_unless_present_any = ["jobs", "judge"], conflicts_with_all = ["jobs", "judge"])]
    output: Option<PathBuf>,
    /// Diagnose every mystery and judge the verdict by its answer, in place of a folder of campaigns
    #[arg(long)]
    judge: bool,
    /// With --judge: write the scores as JSON (`-` for standard output)
    #[arg(long, value_name = "FILE.json", requires = "judge", conflicts_with = "jobs")]
    json: Option<PathBuf>,
    #[command(flatten)]
    jobs: JobArguments,
}

/// The verb's name in lists of jobs.
pub(super) const VERB: &str = "mystery";

/// What a list of mysteries follows from, and what is said of them.
#[derive(Debug, Serialize, Deserialize)]
struct About {
    bench: String,
    level: String,
    duration_s: Option<f64>,
    seeds: Vec<u64>,
    judge: bool,
}

/// A mystery's folder, with its answer sealed.
#[derive(Debug, Serialize, Deserialize)]
struct Folder {
    name: String,
    runs: usize,
    /// Name and text of each.
    files: Vec<(String, String)>,
}

impl Folder {
    fn of(made: Mystery) -> anyhow::Result<Self> {
        let sealed = made.answer.sealed()?;
        let mut files = made.files;
        files.push((answer::FILE.to_owned(), sealed));
        Ok(Self { name: made.answer.campaign, runs: made.runs, files })
    }
}

impl MysteryArguments {
    fn name(&self, seed: u64) -> String {
        format!("mystery-{}-{seed}", self.bench.as_str())
    }

    /// The duration of a run; none on a leg.
    fn duration_s(&self) -> anyhow::Result<Option<f64>> {
        match (self.bench, self.duration) {
            (Bench::Leg, Some(_)) => Err(bad_input("--duration: the runs of a leg have their own")),
            (Bench::Leg, None) => Ok(None),
            (_, given) => Ok(Some(given.unwrap_or(DURATION_S))),
        }
    }

    fn make(&self, seed: u64) -> sealegs::Result<Mystery> {
        let (name, level) = (self.name(seed), self.level.into());
        match self.bench.rig() {
            Some(rig) => bench_mystery(&name, rig, seed, level, self.duration.unwrap_or(DURATION_S)),
            None => leg_mystery(&name, seed, level),
        }
    }

    fn judged(&self, seed: u64) -> anyhow::Result<Judged> {
        Ok(judge(&self.make(seed)?, Options::new())?)
    }
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input if the folder is there already or cannot be made.
pub fn run(arguments: &MysteryArguments) -> anyhow::Result<u8> {
    let duration_s = arguments.duration_s()?;
    let seeds = &arguments.seed.0;
    if let Some(folder) = &arguments.jobs.jobs {
        return work(arguments, folder, duration_s);
    }
    let bar = progress::spinner();
    if arguments.judge {
        let json = Destination::optional(arguments.json.as_ref())?;
        let judged = seeds.iter().map(|seed| {
            bar.say(&arguments.name(*seed));
            arguments.judged(*seed)
        });
        let mysteries = judged.collect::<anyhow::Result<Vec<_>>>();
        bar.finish();
        let (bench, level) = (arguments.bench.as_str(), arguments.level.as_str());
        return say(&Judgement::new(bench, level, duration_s, mysteries?), json);
    }
    let Some(output) = &arguments.output else { return Err(bad_input("--output: which folder to make?")) };
    let folder = NewFolder::new(output)?;
    bar.say("hiding something where it shows, and recording its runs");
    let made = seeds.iter().map(|seed| Folder::of(arguments.make(*seed)?));
    let runs = put(folder, made, seeds.len());
    bar.finish();
    told(output, runs?, arguments.bench.as_str(), seeds.len())
}

/// Does a shard of the mysteries.
fn work(arguments: &MysteryArguments, folder: &Path, duration_s: Option<f64>) -> anyhow::Result<u8> {
    let seeds = &arguments.seed.0;
    let about = About {
        bench: arguments.bench.as_str().to_owned(),
        level: arguments.level.as_str().to_owned(),
        duration_s,
        seeds: seeds.clone(),
        judge: arguments.judge,
    };
    let names: Vec<String> = seeds.iter().map(|seed| arguments.name(*seed)).collect();
    let list = jobs::list(VERB, serde_json::to_value(about)?, &names);
    let shard = arguments.jobs.shard;
    if arguments.judge {
        jobs::work(folder, shard, list, |number| arguments.judged(seeds[number]))
    } else {
        jobs::work(folder, shard, list, |number| Folder::of(arguments.make(seeds[number])?))
    }
}

/// Puts the mysteries of a folder of jobs together: a folder of campaigns, or the scores.
///
/// # Errors
///
/// Bad input where one is missing, or the folder is not named, is there already or cannot be made.
pub(super) fn merge(jobs: &JobFolder, output: Option<&Path>, json: Option<&PathBuf>) -> anyhow::Result<u8> {
    let about: About = jobs.about()?;
    if about.judge {
        if output.is_some() {
            return Err(bad_input("--output: the jobs judged their mysteries, and made no folders"));
        }
        let mysteries = jobs.results()?;
        let judgement = Judgement::new(&about.bench, &about.level, about.duration_s, mysteries);
        return say(&judgement, Destination::optional(json)?);
    }
    if json.is_some() {
        return Err(bad_input("--json: the jobs judged nothing (--judge)"));
    }
    let Some(output) = output else { return Err(bad_input("--output: which folder to make?")) };
    let made: Vec<Folder> = jobs.results()?;
    let number = made.len();
    let runs = put(NewFolder::new(output)?, made.into_iter().map(Ok), number)?;
    told(output, runs, &about.bench, number)
}

/// Writes the files: of one mystery into the folder itself, of several into a folder each. Returns the runs of the last.
fn put(
    folder: NewFolder,
    made: impl Iterator<Item = anyhow::Result<Folder>>,
    number: usize,
) -> anyhow::Result<usize> {
    let mut runs = 0;
    for one in made {
        let one = one?;
        runs = one.runs;
        for (file, text) in &one.files {
            let place = if number == 1 { file.clone() } else { format!("{}/{file}", one.name) };
            folder.add(&place, text)?;
        }
    }
    folder.finish()?;
    Ok(runs)
}

/// Says what was made and what to do with it.
fn told(output: &Path, runs: usize, bench: &str, number: usize) -> anyhow::Result<u8> {
    let place = output.display();
    let mut out = std::io::stdout().lock();
    if number > 1 {
        writeln!(
            out,
            "{place}: {number} campaigns on the {bench} bench, a folder each, with their answers sealed. Now:\n  \
             sealegs diagnose {place}/* --json verdicts.json"
        )?;
        return Ok(0);
    }
    writeln!(
        out,
        "{place}: a campaign of {runs} runs on the {bench} bench, with its answer sealed. Now:\n  \
         sealegs diagnose {place} --json verdict.json\n  sealegs reveal {place} --verdict verdict.json"
    )?;
    Ok(0)
}

/// Writes and prints the scores.
fn say(judgement: &Judgement, json: Option<Destination>) -> anyhow::Result<u8> {
    let to_stdout = json.as_ref().is_some_and(|destination| destination.part().is_none());
    if let Some(destination) = json {
        destination.write((serde_json::to_string_pretty(judgement)? + "\n").as_bytes())?;
    }
    if !to_stdout {
        write!(std::io::stdout().lock(), "{}", judgement.text())?;
    }
    Ok(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_read_as_a_list() {
        let seeds = |text: &str| text.parse::<Seeds>().map(|s| s.0);
        assert_eq!(seeds("7").unwrap(), [7]);
        assert_eq!(seeds("1,4-6").unwrap(), [1, 4, 5, 6]);
        for (text, said) in [
            ("", "no seed"),
            ("x", "no seed"),
            ("5-4", "first to the last"),
            ("1,1-2", "once"),
            ("1-99999", "at most"),
        ] {
            assert!(seeds(text).unwrap_err().contains(said), "{text}");
        }
    }
}
