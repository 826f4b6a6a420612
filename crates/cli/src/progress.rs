//! What long work is doing: a line on the terminal that is drawn anew; in a pipe nothing, or with `--progress` a line for each
//! step and every ten seconds.

use indicatif::{ProgressBar, ProgressStyle};
use sealegs::diagnosis::progress::SO_FAR;
use std::io::IsTerminal;
use std::ops::Deref;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// How often a line is written in a pipe.
const EVERY: Duration = Duration::from_secs(10);

/// Whether lines are written where standard error is no terminal.
static IN_A_PIPE: AtomicBool = AtomicBool::new(false);

/// Asks for lines in a pipe, too, for this process.
pub fn in_a_pipe() {
    IN_A_PIPE.store(true, Ordering::Relaxed);
}

/// A progress bar that also says in a pipe, where that was asked for, where it is.
#[derive(Debug)]
pub struct Bar {
    bar: ProgressBar,
    lines: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Bar {
    fn new(bar: ProgressBar, template: &str) -> Self {
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        let lines = writes_lines().then(|| {
            let (stop, stopped) = channel();
            let own = bar.clone();
            let write = move || {
                while stopped.recv_timeout(EVERY) == Err(RecvTimeoutError::Timeout) {
                    write_line(&own);
                }
            };
            (stop, std::thread::spawn(write))
        });
        Self { bar, lines }
    }

    /// Says what is being done now.
    pub fn say(&self, what: &str) {
        say(&self.bar, what);
    }

    /// Takes the line off the terminal.
    pub fn finish(self) {
        self.bar.finish_and_clear();
        if let Some((stop, lines)) = self.lines {
            drop(stop);
            // The thread only writes; there is nothing to learn from how it ended.
            let _ = lines.join();
        }
    }
}

impl Deref for Bar {
    type Target = ProgressBar;

    fn deref(&self) -> &ProgressBar {
        &self.bar
    }
}

/// Whether lines are written: they were asked for, and nothing is drawn.
fn writes_lines() -> bool {
    IN_A_PIPE.load(Ordering::Relaxed) && !std::io::stderr().is_terminal()
}

/// Says what is being done in the place of what was; what was found so far stays on the terminal.
fn say(bar: &ProgressBar, what: &str) {
    if bar.message() == what {
        return;
    }
    if what.starts_with(SO_FAR) && !writes_lines() {
        bar.println(what);
        return;
    }
    bar.set_message(what.to_owned());
    if writes_lines() {
        write_line(bar);
    }
}

/// Seconds so far, what is being done or the share that is done and the time that is left.
fn write_line(bar: &ProgressBar) {
    let seconds = bar.elapsed().as_secs_f64();
    let share = bar.length().filter(|length| *length > 0).map(|length| {
        let done = 100.0 * bar.position() as f64 / length as f64;
        format!("{done:.0} % done, about {} s left ", bar.eta().as_secs())
    });
    eprintln!("{seconds:6.1} s  {}{}", share.unwrap_or_default(), bar.message());
}

/// A spinner that names what is being done.
#[must_use]
pub fn spinner() -> Bar {
    let bar = ProgressBar::new_spinner();
    bar.enable_steady_tick(Duration::from_millis(120));
    Bar::new(bar, "{spinner} {elapsed} {wide_msg}")
}

/// A bar of a length, drawn by a template of `indicatif`.
#[must_use]
pub fn bar(length: u64, template: &str) -> Bar {
    Bar::new(ProgressBar::new(length), template)
}

/// Shows on the spinner what is being tried.
pub fn on(bar: &Bar) -> impl Fn(&str) + Send + Sync + use<> {
    let bar = bar.bar.clone();
    move |what| say(&bar, what)
}
