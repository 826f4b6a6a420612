//! The pages of the book that the program makes are those of the present cards and of the present command line.

use std::path::{Path, PathBuf};

fn source(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src").join(file)
}

fn text(file: &str) -> String {
    std::fs::read_to_string(source(file)).unwrap_or_else(|e| panic!("docs/src/{file}: {e}"))
}

/// A page without the coordinates of its pictures: their last digit is the processor's.
fn without_coordinates(page: &str) -> String {
    let mut out = String::new();
    let mut rest = page;
    while let Some(from) = rest.find(" points=\"") {
        let (before, after) = rest.split_at(from + " points=\"".len());
        out.push_str(before);
        rest = &after[after.find('"').unwrap_or(0)..];
    }
    out + rest
}

#[test]
fn every_effect_has_its_present_page() {
    let pages = sealegs::catalogue::book().unwrap();
    let made: Vec<&str> = pages.iter().map(|p| p.file.as_str()).collect();
    for page in &pages {
        let there = text(&format!("effects/{}", page.file));
        assert!(
            without_coordinates(&there) == without_coordinates(&page.text),
            "docs/src/effects/{} is out of date: run `sealegs effects --book docs/src/effects`",
            page.file
        );
    }
    for entry in std::fs::read_dir(source("effects")).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        assert!(made.contains(&name.as_str()), "docs/src/effects/{name} is of no effect");
    }
}

#[test]
fn the_command_reference_is_the_present_help() {
    let there = text("commands.md");
    assert!(
        there == sealegs_cli::verb::man::reference(),
        "docs/src/commands.md is out of date: run `sealegs man --book -o docs/src`"
    );
}

#[test]
fn the_summary_names_every_page_and_every_page_is_there() {
    let summary = text("SUMMARY.md");
    let links: Vec<&str> = summary.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    for link in &links {
        assert!(source(link).is_file(), "SUMMARY.md names {link}, which is not there");
    }
    for effect in sealegs::catalogue::entries().unwrap() {
        let file = format!("effects/{}.md", effect.page_name());
        assert!(links.contains(&file.as_str()), "SUMMARY.md does not name {file}");
    }
}
