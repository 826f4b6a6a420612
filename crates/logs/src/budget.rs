//! How much a file may hold: what a header claims is checked against this before room is made for it.

/// Most numbers of one file, 1.6 GB of them.
const MOST_NUMBERS: usize = 200_000_000;

/// Numbers that any file may hold, however small it is: run lengths and compression make many numbers of few bytes.
/// A third of a gigabyte of them; a decoder holds them twice, as bytes and as numbers, and a survey once more.
const FREE_NUMBERS: usize = 40_000_000;

/// Most columns of one table: no rig has so many, and a file that is no table at all may seem to.
pub(crate) const MOST_COLUMNS: usize = 10_000;

/// Longest array inside a row that becomes columns; a longer one is a picture or a scan.
pub(crate) const MOST_ARRAY: usize = 512;

/// Most bytes that a compressed part of a file may become.
pub(crate) const MOST_INFLATED: u64 = 256 << 20;

/// How many numbers of a file may still be read.
#[derive(Debug)]
pub(crate) struct Budget {
    left: usize,
    most: usize,
}

impl Budget {
    /// For a file of so many bytes: every number needs a byte, but for [`FREE_NUMBERS`].
    pub fn of_file(bytes: usize) -> Self {
        let most = FREE_NUMBERS.saturating_add(bytes).min(MOST_NUMBERS);
        Self { left: most, most }
    }

    /// Takes so many numbers, or says that they are too many.
    pub fn take(&mut self, numbers: usize) -> Result<(), String> {
        match self.left.checked_sub(numbers) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => Err(format!("holds more than {} numbers; cut it into several files", self.most)),
        }
    }
}
