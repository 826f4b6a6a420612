//! Work that is a list of independent jobs, on one machine or on many.
//!
//! A [`JobList`] says what the jobs are. A [`JobFolder`] keeps the list and one file for each job that is done. Whoever
//! shares the folder takes a [`Shard`] of the list; a job with a whole result is not done again, a job whose file is cut
//! short or changed is. When every job has its result, they are put together in the list's order, and that is what one
//! machine alone would have made, to the last bit: a job does not know who does it.
//!
//! Nothing here starts a job elsewhere: that is the business of SLURM, Ray or a shell.
//!
//! ```
//! use sealegs::jobs::{JobFolder, JobList, Shard};
//!
//! let squares = JobList::new("squares", "0.1.0", serde_json::json!({ "of": [1, 2, 3] }), &["one", "two", "three"]);
//! # let place = std::env::temp_dir().join(format!("sealegs-squares-{}", std::process::id()));
//! let folder = JobFolder::open(&place, squares)?;
//! for shard in ["1/2", "2/2"] {
//!     let square = |job: usize| Ok::<_, sealegs::Error>((job + 1).pow(2));
//!     folder.work(shard.parse::<Shard>()?, &|_| (), square)?;
//! }
//! assert_eq!(folder.results::<usize>()?, [1, 4, 9]);
//! # std::fs::remove_dir_all(&place).expect("the folder is ours");
//! # Ok::<(), sealegs::Error>(())
//! ```

mod folder;
mod shard;

pub use folder::{JobFolder, JobList, Worked, hash};
pub use shard::Shard;
