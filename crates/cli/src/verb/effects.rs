//! `sealegs effects`: the catalogue of physical effects, and what each of them looks like in a log.

use crate::output::Destination;
use anyhow::Context;
use clap::Args;
use sealegs::catalogue;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Show the catalogue of effects, or one effect: its law, how it is told from its neighbours, its signature.
#[derive(Args)]
pub struct Effects {
    /// One effect's id; a place before it (`knee/`) does not count. Without it all are listed
    id: Option<String>,
    /// Write the cards as JSON, one with its signature where an id is given (`-` for standard output)
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
    /// Write the pages of the documentation's book into this folder
    #[arg(long, value_name = "FOLDER", hide = true, conflicts_with_all = ["id", "json"])]
    book: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input for an id that no effect has, with the nearest one; otherwise if an output cannot be written.
pub fn run(arguments: &Effects) -> anyhow::Result<u8> {
    if let Some(folder) = &arguments.book {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        for page in catalogue::book()? {
            Destination::new(&folder.join(&page.file))?.write(page.text.as_bytes())?;
        }
        list_in_summary(folder)?;
        return Ok(0);
    }
    let json = Destination::optional(arguments.json.as_ref())?;
    let to_stdout = arguments.json.as_ref().is_some_and(|p| p.as_os_str() == "-");
    let (text, document) = match &arguments.id {
        Some(id) => {
            let entry = catalogue::find(id)?;
            let signature = entry.signature()?;
            let text = catalogue::card_text(&entry, &signature);
            (text, serde_json::to_string_pretty(&entry.sheet(Some(signature)))?)
        }
        None => {
            let all = catalogue::entries()?;
            let sheets: Vec<_> = all.iter().map(|entry| entry.sheet(None)).collect();
            (catalogue::table_text(&all), serde_json::to_string_pretty(&sheets)?)
        }
    };
    if let Some(json) = json {
        json.write(format!("{document}\n").as_bytes())?;
    }
    if !to_stdout {
        std::io::stdout().write_all(text.as_bytes())?;
    }
    Ok(0)
}

/// Lists the effects' pages in the book's summary, which lies beside their folder, in the catalogue's order.
fn list_in_summary(folder: &Path) -> anyhow::Result<()> {
    let Some(file) = folder.parent().map(|source| source.join("SUMMARY.md")).filter(|f| f.is_file()) else {
        return Ok(());
    };
    let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let of_effect = |line: &&str| line.starts_with("  - [") && line.contains(&format!("]({name}/"));
    let text = std::fs::read_to_string(&file).with_context(|| file.display().to_string())?;
    let mut pages = String::new();
    for entry in catalogue::entries()? {
        let (id, page) = (&entry.card().id, entry.page_name());
        let of_leg = if *id == page { "" } else { " (leg)" };
        pages.push_str(&format!("  - [{id}{of_leg}]({name}/{page}.md)\n"));
    }
    let mut out = String::new();
    for line in text.lines().filter(|line| !of_effect(line)) {
        out.push_str(line);
        out.push('\n');
        if line.contains(&format!("]({name}/index.md)")) {
            out.push_str(&pages);
        }
    }
    Destination::new(&file)?.write(out.as_bytes())?;
    Ok(())
}
