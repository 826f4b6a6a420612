//! What tests of the command line share: the program, its files of results, and noise.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// Runs the program with this many threads.
pub fn sealegs(threads: usize, arguments: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_sealegs"));
    program.env("RAYON_NUM_THREADS", threads.to_string()).args(arguments).output().unwrap()
}

/// A file of results.
#[allow(dead_code, reason = "not every test of the program reads one")]
pub fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// A reproducible standard normal number: the sum of twelve uniform ones, less six.
#[allow(dead_code, reason = "not every test of the program draws noise")]
pub fn normal(state: &mut u64) -> f64 {
    let mut sum = -6.0;
    for _ in 0..12 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        sum += (*state >> 11) as f64 / (1u64 << 53) as f64;
    }
    sum
}
