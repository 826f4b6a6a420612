//! `sealegs man`: the man pages, one for the program and one for each verb, and the reference in the book.

use crate::output::Destination;
use anyhow::Context;
use clap::Args;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Write the man pages into a folder, one for the program and one for each verb.
#[derive(Args)]
pub struct Man {
    /// The folder, which is made if it is not there
    #[arg(short = 'o', long = "output", value_name = "FOLDER")]
    output: PathBuf,
    /// Write the command reference of the documentation's book in place of the man pages
    #[arg(long, hide = true)]
    book: bool,
}

/// The file of the command reference in the book.
const REFERENCE: &str = "commands.md";

/// Width of the reference's lines, characters.
const WIDTH: usize = 100;

/// Runs the verb.
///
/// # Errors
///
/// If a page cannot be written.
pub fn run(arguments: &Man) -> anyhow::Result<u8> {
    let folder = &arguments.output;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    if arguments.book {
        Destination::new(&folder.join(REFERENCE))?.write(reference().as_bytes())?;
        return Ok(0);
    }
    let program = crate::command_line();
    let mut pages = vec![("sealegs".to_owned(), program.clone())];
    for verb in program.get_subcommands().filter(|verb| !verb.is_hide_set()) {
        // clap takes no borrowed name: that of a page lives as long as the process.
        let name = format!("sealegs-{}", verb.get_name());
        pages.push((name.clone(), verb.clone().name(name.leak() as &'static str)));
    }
    for (name, command) in pages {
        let mut page = Vec::new();
        clap_mangen::Man::new(command).render(&mut page)?;
        Destination::new(&folder.join(format!("{name}.1")))?.write(&page)?;
    }
    Ok(0)
}

/// The command reference of the book: the help of every verb.
#[must_use]
pub fn reference() -> String {
    let mut program = crate::command_line().term_width(WIDTH);
    program.build();
    let mut out = String::from(
        "<!-- Made by `sealegs man --book -o docs/src` from the program's own help: do not edit. -->\n\n# Commands\n\n\
         Exit status: 0 done, 2 bad input, 3 a limit stated on the command line was exceeded, 1 anything else. A verdict \
         is never an error.\n",
    );
    let verbs: Vec<clap::Command> = program.get_subcommands().filter(|v| !v.is_hide_set()).cloned().collect();
    for mut verb in verbs.into_iter().filter(|v| v.get_name() != "help") {
        let help = verb.render_long_help().to_string();
        let trimmed: Vec<&str> = help.lines().map(str::trim_end).collect();
        let _ = write!(out, "\n## {}\n\n```text\n{}\n```\n", verb.get_name(), trimmed.join("\n").trim_end());
    }
    out
}
