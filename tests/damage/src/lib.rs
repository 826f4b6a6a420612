//! Damaged files: what disks, editors and hurried hands make of a good one.

use proptest::prelude::*;
use std::sync::mpsc;
use std::time::Duration;

/// Numbers that a reader must survive, whatever they stand for.
const EXTREMES: [&str; 16] = [
    "1e300",
    "-1e300",
    "1e-300",
    "nan",
    "-inf",
    "inf",
    "0",
    "-1",
    "0.0",
    "1e9",
    "-1e-9",
    "1e400",
    "4294967296",
    "9223372036854775807",
    "\"\"",
    "[]",
];

/// One change of a file; the numbers choose where.
#[derive(Debug, Clone, Copy)]
enum Change {
    Truncate(u32),
    Byte(u32, u8),
    SwapLines(u32, u32),
    DropLine(u32),
    RepeatLine(u32, u32),
    Extreme(u32, u32),
    Rename(u32, u8),
    Insert(u32, u8),
}

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        1 => any::<u32>().prop_map(Change::Truncate),
        1 => any::<(u32, u8)>().prop_map(|(a, b)| Change::Byte(a, b)),
        1 => any::<(u32, u32)>().prop_map(|(a, b)| Change::SwapLines(a, b)),
        1 => any::<u32>().prop_map(Change::DropLine),
        1 => any::<(u32, u32)>().prop_map(|(a, b)| Change::RepeatLine(a, b)),
        5 => any::<(u32, u32)>().prop_map(|(a, b)| Change::Extreme(a, b)),
        1 => any::<(u32, u8)>().prop_map(|(a, b)| Change::Rename(a, b)),
        1 => any::<(u32, u8)>().prop_map(|(a, b)| Change::Insert(a, b)),
    ]
}

/// A good text with one to three faults: cut short, bytes changed, lines swapped, lost or doubled, numbers
/// replaced by extremes, names misspelt; or no such text at all.
pub fn damaged(good: &[u8]) -> impl Strategy<Value = Vec<u8>> + use<> {
    let good = good.to_vec();
    prop_oneof![
        12 => prop::collection::vec(change(), 1..4).prop_map(move |changes| {
            changes.into_iter().fold(good.clone(), apply)
        }),
        1 => prop::collection::vec(any::<u8>(), 0..300),
    ]
}

/// A good file that is no text, with one to eight bytes changed or its end lost; or no such file at all.
pub fn damaged_bytes(good: &[u8]) -> impl Strategy<Value = Vec<u8>> + use<> {
    let good = good.to_vec();
    let one = prop_oneof![
        8 => any::<(u32, u8)>().prop_map(|(a, b)| Change::Byte(a, b)),
        1 => any::<u32>().prop_map(Change::Truncate),
        1 => any::<(u32, u8)>().prop_map(|(a, b)| Change::Insert(a, b)),
    ];
    prop_oneof![
        12 => prop::collection::vec(one, 1..8).prop_map(move |changes| {
            changes.into_iter().fold(good.clone(), apply)
        }),
        1 => prop::collection::vec(any::<u8>(), 0..300),
    ]
}

fn apply(mut bytes: Vec<u8>, change: Change) -> Vec<u8> {
    let within = |at: u32, length: usize| at as usize % length.max(1);
    match change {
        Change::Truncate(at) => bytes.truncate(within(at, bytes.len())),
        Change::Byte(at, value) => {
            let at = within(at, bytes.len());
            bytes.iter_mut().skip(at).take(1).for_each(|b| *b = value);
        }
        Change::Insert(at, value) => bytes.insert(within(at, bytes.len()), value),
        Change::Extreme(at, which) => {
            let words = words(&bytes, |b| b.is_ascii_digit() || b"+-.eE".contains(&b));
            let numbers: Vec<_> =
                words.into_iter().filter(|w| bytes[w.clone()].iter().any(u8::is_ascii_digit)).collect();
            if let Some(place) = numbers.get(within(at, numbers.len())) {
                let extreme = EXTREMES[within(which, EXTREMES.len())];
                bytes.splice(place.clone(), extreme.bytes());
            }
        }
        Change::Rename(at, value) => {
            let names = words(&bytes, |b| b.is_ascii_alphabetic() || b == b'_');
            if let Some(place) = names.get(within(at, names.len())) {
                bytes[place.start] = value;
            }
        }
        Change::SwapLines(a, b) => change_lines(&mut bytes, |lines| {
            let (a, b) = (within(a, lines.len()), within(b, lines.len()));
            lines.swap(a, b);
        }),
        Change::DropLine(a) => change_lines(&mut bytes, |lines| {
            lines.remove(within(a, lines.len()));
        }),
        Change::RepeatLine(a, b) => change_lines(&mut bytes, |lines| {
            let line = lines[within(a, lines.len())].clone();
            lines.insert(within(b, lines.len()), line);
        }),
    }
    bytes
}

fn change_lines(bytes: &mut Vec<u8>, change: impl FnOnce(&mut Vec<Vec<u8>>)) {
    let mut lines: Vec<Vec<u8>> = bytes.split(|&b| b == b'\n').map(<[u8]>::to_vec).collect();
    change(&mut lines);
    *bytes = lines.join(&b'\n');
}

/// Where the bytes of a kind stand together.
fn words(bytes: &[u8], kind: impl Fn(u8) -> bool) -> Vec<std::ops::Range<usize>> {
    let mut words: Vec<std::ops::Range<usize>> = Vec::new();
    for i in (0..bytes.len()).filter(|&i| kind(bytes[i])) {
        match words.last_mut() {
            Some(word) if word.end == i => word.end += 1,
            _ => words.push(i..i + 1),
        }
    }
    words
}

/// Settings of a property test: this many cases, in proportion more or fewer with `PROPTEST_CASES` (256 is one),
/// and no file of past failures (a found fault becomes a test of its own).
#[must_use]
pub fn cases(cases: u32) -> ProptestConfig {
    let default = ProptestConfig::default();
    let cases = (u64::from(cases) * u64::from(default.cases) / 256) as u32;
    ProptestConfig { failure_persistence: None, cases, ..default }
}

/// What `read` returns, if it neither panics nor takes longer than ten seconds (it should take milliseconds;
/// the machine may be busy) nor makes the process larger than 1 GB.
///
/// # Panics
///
/// If it does.
pub fn survives<T: Send + 'static>(read: impl FnOnce() -> T + Send + 'static) -> T {
    let (done, result) = mpsc::channel();
    let thread = std::thread::spawn(move || {
        let _ = done.send(read());
    });
    match result.recv_timeout(Duration::from_secs(10)) {
        Ok(value) => {
            assert!(peak_memory_kb() < 1_000_000, "{} kB", peak_memory_kb());
            value
        }
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("it hangs"),
        Err(mpsc::RecvTimeoutError::Disconnected) => {
            let _ = thread.join();
            panic!("it panics");
        }
    }
}

/// Greatest memory that this process has had, kB; 0 where the system does not tell.
fn peak_memory_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    line.and_then(|l| l.split_whitespace().next()).and_then(|n| n.parse().ok()).unwrap_or(0)
}
