//! A fence around a decoder that panics on some damaged files, as the libraries of binary formats do.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether this thread is inside the fence.
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

/// Installs, once, a hook that passes on every panic but those inside the fence.
static HOOK: Once = Once::new();

/// What `decode` returns, or `None` if it panics; nothing is printed then.
///
/// Only for code that owns all that it changes: whatever it leaves half done is dropped.
pub(crate) fn fenced<T>(decode: impl FnOnce() -> T) -> Option<T> {
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            if !INSIDE.get() {
                before(panic);
            }
        }));
    });
    INSIDE.set(true);
    let result = catch_unwind(AssertUnwindSafe(decode));
    INSIDE.set(false);
    result.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_stays_inside() {
        let empty: Vec<u8> = Vec::new();
        assert_eq!(fenced(|| empty[0]), None);
        assert_eq!(fenced(|| 1), Some(1));
        assert!(!INSIDE.get());
    }
}
