//! The verbs: each file holds one verb's arguments and its `run`, which returns the exit status.

mod add;
mod bench;
mod check;
mod compare;
mod completions;
pub mod design;
mod design_report;
mod diagnose;
mod effects;
mod export;
mod impact;
mod import;
mod list;
pub mod man;
mod merge;
mod mystery;
mod reproduce;
mod reveal;
mod run;
mod schema;
mod tour;

use clap::Subcommand;

/// What the program can do.
#[derive(Subcommand)]
pub enum Verb {
    /// Drop a leg, compare it with a recording, find what the model lacks, add it: the whole loop in one go.
    Tour(tour::Tour),
    /// Run a scenario: a drop, a swing, a leg of your own.
    Run(run::Run),
    /// Drop a leg from several heights with several springs; exit status 3 when a stated limit is exceeded.
    Impact(impact::Impact),
    /// List the robots, actuators, scenarios, effects and campaigns that come with the program.
    List(list::List),
    /// Show the catalogue of effects, or one effect: its law, how it is told from its neighbours, its signature.
    Effects(effects::Effects),
    /// Look into log files of any kind and write a first campaign file for them.
    Import(import::Import),
    /// Check a campaign: clocks, gaps, saturation, noise, excitation, and what it can identify.
    Check(check::CheckArguments),
    /// Show where the model fails on a campaign, and by how much.
    Compare(compare::Compare),
    /// Find the physical effect that the model lacks, or say that none is missing or none is known.
    Diagnose(diagnose::Diagnose),
    /// Add an effect to a model, refit it on a campaign and write the better model.
    Add(add::Add),
    /// Write a bench, a leg or a robot for MuJoCo, ROS, Isaac Lab or Gazebo, and say what that format cannot hold.
    Export(export::Export),
    /// Make a campaign with something hidden in it, to practise on.
    Mystery(mystery::MysteryArguments),
    /// Open the answer of a mystery, and judge a verdict on it.
    Reveal(reveal::Reveal),
    /// Put together what the shards of `diagnose`, `impact` or `mystery` have computed (`--jobs`, `--shard`).
    Merge(merge::Merge),
    /// Run an actuator on a test bench.
    Bench(bench::BenchArguments),
    /// Recompute the numbers of the dissertation "Series Elasticity in Linearly Actuated Humanoids".
    Reproduce(reproduce::Reproduce),
    /// Choose spring stiffness and spring side for a force bandwidth.
    Design(design::DesignArguments),
    /// Write the JSON schemas of the results into a folder.
    Schema(schema::SchemaArguments),
    /// Print the completions of a shell.
    Completions(completions::Completions),
    /// Write the man pages into a folder.
    Man(man::Man),
}

/// Does what was asked.
///
/// # Errors
///
/// Whatever the verb could not do; bad input is marked as such (see `failure`).
pub fn run(verb: Verb) -> anyhow::Result<u8> {
    match verb {
        Verb::Tour(arguments) => tour::run(&arguments),
        Verb::Run(arguments) => run::run(&arguments),
        Verb::Impact(arguments) => impact::run(&arguments),
        Verb::List(arguments) => list::run(&arguments),
        Verb::Effects(arguments) => effects::run(&arguments),
        Verb::Completions(arguments) => completions::run(&arguments),
        Verb::Man(arguments) => man::run(&arguments),
        Verb::Import(arguments) => import::run(&arguments),
        Verb::Check(arguments) => check::run(&arguments),
        Verb::Compare(arguments) => compare::run(&arguments),
        Verb::Diagnose(arguments) => diagnose::run(&arguments),
        Verb::Add(arguments) => add::run(&arguments),
        Verb::Export(arguments) => export::run(&arguments),
        Verb::Mystery(arguments) => mystery::run(&arguments),
        Verb::Reveal(arguments) => reveal::run(&arguments),
        Verb::Merge(arguments) => merge::run(&arguments),
        Verb::Schema(arguments) => schema::run(&arguments),
        Verb::Bench(arguments) => bench::run(&arguments),
        Verb::Reproduce(arguments) => reproduce::run(&arguments),
        Verb::Design(arguments) => design::run(&arguments),
    }
}
