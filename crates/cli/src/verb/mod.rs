//! The verbs: each file holds one verb's arguments and its `run`, which returns the exit status.

mod add;
mod check;
mod compare;
mod diagnose;
mod impact;
mod list;
pub mod design;
mod design_report;
mod bench;
mod reproduce;
mod run;

use clap::Subcommand;

/// What the program can do.
#[derive(Subcommand)]
pub enum Verb {
    Run(run::Run),
    Impact(impact::Impact),
    List(list::List),
    Check(check::CheckArguments),
    Compare(compare::Compare),
    Diagnose(diagnose::Diagnose),
    Add(add::Add),
    Bench(bench::BenchArguments),
    Reproduce(reproduce::Reproduce),
    Design(design::DesignArguments),
}

/// Does what was asked.
///
/// # Errors
///
/// Whatever the verb could not do; bad input is marked as such (see `failure`).
pub fn run(verb: Verb) -> anyhow::Result<u8> {
    match verb {
        Verb::Run(arguments) => run::run(&arguments),
        Verb::Impact(arguments) => impact::run(&arguments),
        Verb::List(arguments) => list::run(&arguments),
        Verb::Check(arguments) => check::run(&arguments),
        Verb::Compare(arguments) => compare::run(&arguments),
        Verb::Diagnose(arguments) => diagnose::run(&arguments),
        Verb::Add(arguments) => add::run(&arguments),
        Verb::Bench(arguments) => bench::run(&arguments),
        Verb::Reproduce(arguments) => reproduce::run(&arguments),
        Verb::Design(arguments) => design::run(&arguments),
    }
}
