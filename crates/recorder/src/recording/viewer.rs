//! An installed Rerun viewer: finding, starting and reaching it.

use crate::RecorderError;
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// The viewer's version that fits the recordings written here.
const VERSION: &str = "0.36.3";

/// Opens a finished recording in an installed viewer and returns at once; the viewer stays open.
///
/// # Errors
///
/// [`RecorderError::NoViewer`] with how to get one, if none is installed.
pub fn show(recording: &Path) -> Result<(), RecorderError> {
    spawn(&[recording.as_os_str()])
}

/// That no viewer can be used, and why.
pub(super) fn missing(what: impl Into<String>) -> RecorderError {
    RecorderError::NoViewer { what: what.into(), version: VERSION }
}

/// The address of a running viewer; starts one if none listens.
pub(super) fn start(arguments: &[&std::ffi::OsStr]) -> Result<String, RecorderError> {
    let address = SocketAddr::from(([127, 0, 0, 1], rerun::DEFAULT_SERVER_PORT));
    let listens = || TcpStream::connect_timeout(&address, Duration::from_millis(200)).is_ok();
    if !listens() {
        let mut all = vec![std::ffi::OsStr::new("--expect-data-soon")];
        all.extend(arguments);
        spawn(&all)?;
        // The data would be lost, and reported as lost only seconds later, if nobody listened yet.
        let attempts = 100;
        let ready = (0..attempts).any(|_| {
            std::thread::sleep(Duration::from_millis(100));
            listens()
        });
        if !ready {
            return Err(missing("the installed one was started and does not answer within 10 s"));
        }
    }
    Ok(rerun::DEFAULT_CONNECT_URL.to_owned())
}

fn spawn(arguments: &[&std::ffi::OsStr]) -> Result<(), RecorderError> {
    let program =
        find(std::env::var_os("PATH").as_deref()).ok_or_else(|| missing("no `rerun` on the PATH"))?;
    let mut command = Command::new(&program);
    // It outlives us: it must not hold our standard output open, nor die with our Ctrl-C.
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command.spawn().map_err(|e| missing(format!("{} cannot be started ({e})", program.display())))?;
    Ok(())
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
