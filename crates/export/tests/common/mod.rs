//! Golden files: exports as they stand in `golden/`. `SEALEGS_WRITE_GOLDEN=1` writes them anew, for a look at what changed.

use std::path::Path;

/// Asserts that a file has not changed.
pub fn is_golden(name: &str, text: &str) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if std::env::var_os("SEALEGS_WRITE_GOLDEN").is_some() {
        std::fs::write(&file, text).unwrap();
    }
    let golden = std::fs::read_to_string(&file).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(text, golden, "{name} has changed");
}
