//! Which jobs of a list are one machine's.

use crate::Error;
use std::fmt;
use std::str::FromStr;

/// The `i`-th of `n` shards of a list: every `n`-th job, beginning with the `i`-th.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// From 1 on.
    number: usize,
    /// How many there are.
    of: usize,
}

impl Shard {
    /// The whole list.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// Whether a job, counted from 0, is this shard's.
    #[must_use]
    pub fn takes(self, job: usize) -> bool {
        job % self.of == self.number - 1
    }
}

impl Default for Shard {
    fn default() -> Self {
        Self::WHOLE
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// Reads `i/n`.
///
/// ```
/// use sealegs::jobs::Shard;
///
/// let third: Shard = "3/4".parse()?;
/// assert!(third.takes(2) && third.takes(6) && !third.takes(3));
/// assert!("0/4".parse::<Shard>().is_err() && "5/4".parse::<Shard>().is_err());
/// # Ok::<(), sealegs::Error>(())
/// ```
impl FromStr for Shard {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Self { number, of }),
            _ => Err(Error::BadShard { given: text.to_owned() }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_job_is_in_exactly_one_shard() {
        for of in 1..=7 {
            let shards: Vec<Shard> = (1..=of).map(|i| format!("{i}/{of}").parse().unwrap()).collect();
            for job in 0..20 {
                assert_eq!(shards.iter().filter(|s| s.takes(job)).count(), 1, "job {job} of {of} shards");
            }
            assert_eq!(shards[of - 1].to_string(), format!("{of}/{of}"));
        }
    }

    #[test]
    fn what_is_no_shard_is_refused_with_its_text() {
        for text in ["", "1", "0/3", "4/3", "1/0", "-1/3", "1/3/5", "a/b", " 1/3"] {
            let error = text.parse::<Shard>().unwrap_err();
            assert!(error.is_bad_input() && error.to_string().contains(&format!("'{text}'")), "{error}");
        }
    }
}
