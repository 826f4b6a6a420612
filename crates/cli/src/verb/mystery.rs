//! `sealegs mystery`: a campaign with something hidden in it, to practise on.

use crate::output::NewFolder;
use crate::progress;
use clap::{Args, ValueEnum};
use sealegs::mystery::{self, Mystery, answer, bench_mystery, leg_mystery};
use sealegs::reference::campaign::Rig;
use std::io::Write;
use std::path::PathBuf;

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

    fn mystery(self, name: &str, seed: u64, level: mystery::Level) -> sealegs::Result<Mystery> {
        match self {
            Self::Locked => bench_mystery(name, Rig::Locked, seed, level),
            Self::Pendulum => bench_mystery(name, Rig::Pendulum, seed, level),
            Self::Leg => leg_mystery(name, seed, level),
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

impl From<Level> for mystery::Level {
    fn from(level: Level) -> Self {
        match level {
            Level::Easy => Self::Easy,
            Level::Hard => Self::Hard,
            Level::Rough => Self::Rough,
        }
    }
}

/// Make a campaign with something hidden in it, to practise on
#[derive(Args)]
pub struct MysteryArguments {
    /// What it is recorded on
    #[arg(long, value_enum, default_value = "locked")]
    bench: Bench,
    /// Another seed hides something else
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// One dominant effect; or a weak one, two, none, or (not on a leg) one that is in no catalogue; or a plain one or none
    /// in a rough log (not on a leg)
    #[arg(long, value_enum, default_value = "easy")]
    level: Level,
    /// The folder to make
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input if the folder is there already or cannot be made.
pub fn run(arguments: &MysteryArguments) -> anyhow::Result<u8> {
    let folder = NewFolder::new(&arguments.output)?;
    let name = format!("mystery-{}-{}", arguments.bench.as_str(), arguments.seed);
    let bar = progress::spinner();
    bar.set_message("hiding something where it shows, and recording four runs");
    let made = arguments.bench.mystery(&name, arguments.seed, arguments.level.into());
    bar.finish_and_clear();
    let made = made?;
    let sealed = made.answer.sealed()?;
    let files = made.files.iter().map(|(name, text)| (name.as_str(), text.as_str()));
    folder.write(files.chain([(answer::FILE, sealed.as_str())]))?;
    let place = arguments.output.display();
    writeln!(
        std::io::stdout().lock(),
        "{place}: a campaign of {} runs on the {} bench, with its answer sealed. Now:\n  \
         sealegs diagnose {place} --json verdict.json\n  sealegs reveal {place} --verdict verdict.json",
        made.runs,
        arguments.bench.as_str(),
    )?;
    Ok(0)
}
