//! Long work beside Python: the interpreter's lock released, progress told, Ctrl-C heard.

use crate::error::raised;
use pyo3::{Py, PyAny, PyErr, PyResult, Python};
use sealegs::{Options, Stop};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// How often signals are looked for, and progress is told: Ctrl-C then seems immediate.
const EVERY: Duration = Duration::from_millis(100);

/// Does `work` on a thread of its own without the interpreter's lock. `tell`, if there is one, is called from this thread
/// with what is being tried (`None` where nothing new is) and the simulations so far.
///
/// # Errors
///
/// What the work returns; what `tell` or a signal's handler raises (`KeyboardInterrupt` for Ctrl-C), which stops the
/// work.
pub fn watched<T: Send>(
    py: Python<'_>,
    tell: Option<&Py<PyAny>>,
    work: impl FnOnce(Options) -> sealegs::Result<T> + Send,
) -> PyResult<T> {
    let stop = Stop::new();
    let (sender, receiver) = channel::<String>();
    let options = Options::new().stop(&stop).on_progress(move |what| {
        // Nobody listens any more once the work was stopped.
        let _ = sender.send(what.to_owned());
    });
    let counted = stop.clone();
    let hear = move |what: Option<String>| -> PyResult<()> {
        Python::attach(|py| {
            py.check_signals()?;
            tell.map_or(Ok(()), |tell| tell.call1(py, (what, counted.simulations())).map(drop))
        })
    };
    py.detach(move || {
        std::thread::scope(|scope| {
            let worker = scope.spawn(|| work(options));
            let mut interrupted: Option<PyErr> = None;
            while interrupted.is_none() && !worker.is_finished() {
                let heard = match receiver.recv_timeout(EVERY) {
                    Ok(what) => hear(Some(what)),
                    Err(RecvTimeoutError::Timeout) => hear(None),
                    // The work is done but for its last lines.
                    Err(RecvTimeoutError::Disconnected) => break,
                };
                if let Err(raised) = heard {
                    stop.stop();
                    interrupted = Some(raised);
                }
            }
            let done = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            interrupted.map_or_else(|| done.map_err(raised), Err)
        })
    })
}
