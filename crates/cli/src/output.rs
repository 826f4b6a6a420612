//! Output files and folders that are whole or not there at all: written beside their place, then renamed.

use crate::failure::bad_input;
use anyhow::Context;
use sealegs::recorder::recording;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Files and folders that are being written; an interrupt removes them.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes the unfinished files and ends the program: no new one is begun in between.
pub fn with_unfinished_removed(end: impl FnOnce()) {
    let files = UNFINISHED.lock();
    for path in files.iter().flat_map(|files| files.iter()) {
        remove(path);
    }
    end();
}

/// A place for a result, tried out before long work begins: a file, or standard output for `-`.
#[derive(Debug)]
pub struct Destination {
    path: PathBuf,
    unfinished: Option<PathBuf>,
}

impl Destination {
    /// Checks that `path` can be written by creating `<path>.part` beside it.
    ///
    /// # Errors
    ///
    /// Bad input if it cannot.
    pub fn new(path: &Path) -> anyhow::Result<Self> {
        if path == Path::new("-") {
            return Ok(Self { path: path.to_owned(), unfinished: None });
        }
        if path.is_dir() {
            return Err(bad_input(format!("{}: is a folder; name a file to write", path.display())));
        }
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(".part");
        let unfinished = path.with_file_name(name);
        let files = UNFINISHED.lock();
        std::fs::File::create(&unfinished)
            .map_err(|e| bad_input(format!("{}: cannot be written: {e}", path.display())))?;
        if let Ok(mut files) = files {
            files.push(unfinished.clone());
        }
        Ok(Self { path: path.to_owned(), unfinished: Some(unfinished) })
    }

    /// As [`Destination::new`] for an option that may be absent.
    ///
    /// # Errors
    ///
    /// Bad input if it cannot be written.
    pub fn optional(path: Option<&PathBuf>) -> anyhow::Result<Option<Self>> {
        path.map(|p| Self::new(p)).transpose()
    }

    /// Where another writer (a recording) may put its bytes before [`Destination::finish`]; `None` for
    /// standard output.
    pub fn part(&self) -> Option<&Path> {
        self.unfinished.as_deref()
    }

    /// Writes a recording of a comparison and puts it in place; standard output takes none.
    ///
    /// # Errors
    ///
    /// If the disk does not take it.
    pub fn record(self, recording: &recording::Comparison) -> anyhow::Result<()> {
        if let Some(part) = self.part() {
            recording.write(&recording::Output::File(part.to_owned()))?;
        }
        self.finish()
    }

    /// Writes everything and puts it in place.
    ///
    /// # Errors
    ///
    /// If the disk does not take it.
    pub fn write(self, bytes: &[u8]) -> anyhow::Result<()> {
        match &self.unfinished {
            None => std::io::stdout().write_all(bytes).context("standard output")?,
            Some(part) => std::fs::write(part, bytes).with_context(|| self.path.display().to_string())?,
        }
        self.finish()
    }

    /// Puts the file in place.
    ///
    /// # Errors
    ///
    /// If it cannot be renamed.
    pub fn finish(mut self) -> anyhow::Result<()> {
        if let Some(part) = self.unfinished.take() {
            std::fs::rename(&part, &self.path).with_context(|| self.path.display().to_string())?;
            forget(&part);
        }
        Ok(())
    }
}

impl Drop for Destination {
    fn drop(&mut self) {
        if let Some(part) = &self.unfinished {
            remove(part);
            forget(part);
        }
    }
}

/// A place for a folder of results that is not there yet, tried out before long work begins.
#[derive(Debug)]
pub struct NewFolder {
    path: PathBuf,
    unfinished: Option<PathBuf>,
}

impl NewFolder {
    /// Checks that `path` is free and can be made, by making `<path>.part` beside it, and the folders above.
    ///
    /// # Errors
    ///
    /// Bad input if there is something already, or if it cannot be made.
    pub fn new(path: &Path) -> anyhow::Result<Self> {
        if path.exists() {
            return Err(bad_input(format!("{}: is there already; name a new folder", path.display())));
        }
        let Some(name) = path.file_name() else {
            return Err(bad_input(format!("{}: names no new folder", path.display())));
        };
        let mut name = name.to_owned();
        name.push(".part");
        let unfinished = path.with_file_name(name);
        let above = unfinished.parent().map_or(Ok(()), std::fs::create_dir_all);
        above
            .and_then(|()| std::fs::create_dir(&unfinished))
            .map_err(|e| bad_input(format!("{}: cannot be made: {e}", path.display())))?;
        if let Ok(mut files) = UNFINISHED.lock() {
            files.push(unfinished.clone());
        }
        Ok(Self { path: path.to_owned(), unfinished: Some(unfinished) })
    }

    /// Writes a file, by its name within the folder.
    ///
    /// # Errors
    ///
    /// If the disk does not take it.
    pub fn add(&self, name: &str, text: &str) -> anyhow::Result<()> {
        let Some(part) = &self.unfinished else { return Ok(()) };
        let place = part.join(name);
        let written = place.parent().map_or(Ok(()), std::fs::create_dir_all);
        written
            .and_then(|()| std::fs::write(&place, text))
            .with_context(|| self.path.join(name).display().to_string())
    }

    /// Puts the folder in place.
    ///
    /// # Errors
    ///
    /// If it cannot be renamed.
    pub fn finish(mut self) -> anyhow::Result<()> {
        if let Some(part) = &self.unfinished {
            std::fs::rename(part, &self.path).with_context(|| self.path.display().to_string())?;
            forget(part);
        }
        self.unfinished = None;
        Ok(())
    }

    /// Writes the files, by name and text, and puts the folder in place.
    ///
    /// # Errors
    ///
    /// If the disk does not take them.
    pub fn write<'a>(self, files: impl IntoIterator<Item = (&'a str, &'a str)>) -> anyhow::Result<()> {
        for (name, text) in files {
            self.add(name, text)?;
        }
        self.finish()
    }
}

impl Drop for NewFolder {
    fn drop(&mut self) {
        if let Some(part) = &self.unfinished {
            remove(part);
            forget(part);
        }
    }
}

/// Removes what was not finished, whichever it is.
fn remove(part: &Path) {
    let _ = if part.is_dir() { std::fs::remove_dir_all(part) } else { std::fs::remove_file(part) };
}

fn forget(part: &Path) {
    if let Ok(mut files) = UNFINISHED.lock() {
        files.retain(|f| f != part);
    }
}
