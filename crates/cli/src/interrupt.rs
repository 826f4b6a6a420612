//! Ctrl-C: on a terminal the first one ends a diagnosis's search, which judges what it found; any other one ends the program with
//! no unfinished file left.

use crate::output;
use crate::progress::Bar;
use indicatif::ProgressBar;
use sealegs::Stop;
use std::io::IsTerminal;
use std::sync::Mutex;

/// The search that an interrupt ends, and where that is said.
static SEARCH: Mutex<Option<(Stop, ProgressBar)>> = Mutex::new(None);

/// The status of a program that an interrupt ended.
const INTERRUPTED: i32 = 130;

/// Listens for interrupts from now on.
pub fn listen() {
    // Without the handler an interrupt still breaks no finished file, it only leaves a `.part` behind.
    let _ = ctrlc::set_handler(|| {
        let search = SEARCH.lock().ok().and_then(|mut search| search.take());
        match search {
            Some((stop, bar)) => {
                bar.println("ending the search and judging what was found; Ctrl-C again stops at once");
                stop.end_search();
            }
            None => output::with_unfinished_removed(|| std::process::exit(INTERRUPTED)),
        }
    });
}

/// While it lives the next interrupt ends a search.
pub struct EndsSearch;

impl EndsSearch {
    /// Not where nobody sees that the program goes on: whoever interrupts it in a pipe wants it to end.
    pub fn new(stop: Stop, bar: &Bar) -> Self {
        if std::io::stderr().is_terminal()
            && let Ok(mut search) = SEARCH.lock()
        {
            *search = Some((stop, (**bar).clone()));
        }
        Self
    }
}

impl Drop for EndsSearch {
    fn drop(&mut self) {
        if let Ok(mut search) = SEARCH.lock() {
            *search = None;
        }
    }
}
