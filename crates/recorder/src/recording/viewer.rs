//! An installed Rerun viewer: finding, starting and reaching it.

use crate::RecorderError;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};

/// The viewer's version that fits the recordings written here.
const VERSION: &str = "0.36.3";

/// Opens a finished recording in an installed viewer and returns at once; the viewer stays open.
///
/// # Errors
///
/// [`RecorderError::NoViewer`] with how to get one, if none is installed.
pub fn show(recording: &Path) -> Result<(), RecorderError> {
    spawn(&[recording.as_os_str()], Stdio::null()).map(|_| ())
}

/// That no viewer can be used, and why.
pub(super) fn missing(what: impl Into<String>) -> RecorderError {
    RecorderError::NoViewer { what: what.into(), version: VERSION }
}

/// The standard input of a viewer. If one is running already, the new one hands over to it what it gets.
pub(super) fn pipe() -> Result<ChildStdin, RecorderError> {
    let arguments = ["--expect-data-soon", "-"].map(std::ffi::OsStr::new);
    spawn(&arguments, Stdio::piped())?.stdin.take().ok_or_else(|| missing("it takes no data"))
}

fn spawn(arguments: &[&std::ffi::OsStr], input: Stdio) -> Result<Child, RecorderError> {
    let program =
        find(std::env::var_os("PATH").as_deref()).ok_or_else(|| missing("no `rerun` on the PATH"))?;
    let mut command = Command::new(&program);
    // It outlives us: it must not hold our standard output open, nor die with our Ctrl-C.
    command.args(arguments).stdin(input).stdout(Stdio::null()).stderr(Stdio::null());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command.spawn().map_err(|e| missing(format!("{} cannot be started ({e})", program.display())))
}

/// The first `rerun` of a search path.
fn find(search: Option<&std::ffi::OsStr>) -> Option<PathBuf> {
    let name = format!("rerun{}", std::env::consts::EXE_SUFFIX);
    std::env::split_paths(search?).map(|folder| folder.join(&name)).find(|file| file.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_viewer_of_the_search_path_is_found() {
        let empty = tempfile::tempdir().unwrap();
        let full = tempfile::tempdir().unwrap();
        let program = full.path().join(format!("rerun{}", std::env::consts::EXE_SUFFIX));
        std::fs::write(&program, "").unwrap();
        let search = std::env::join_paths([empty.path(), full.path()]).unwrap();
        assert_eq!(find(Some(&search)), Some(program));
        assert_eq!(find(Some(empty.path().as_os_str())), None);
        assert_eq!(find(None), None);
    }

    #[test]
    fn a_missing_viewer_says_in_one_line_how_to_get_it() {
        let line = missing("no `rerun` on the PATH").to_string();
        assert!(line.contains("pip install rerun-sdk==0.36.3") && !line.contains('\n'), "{line}");
    }
}
