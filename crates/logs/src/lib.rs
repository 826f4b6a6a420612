//! Other people's logs as tables: named columns of numbers, with the file, the row and the column of every fault.
//!
//! - [`read`] looks at a file's ending (and its first bytes) and reads it whole: CSV in its many shapes, Parquet,
//!   MATLAB, HDF5, JSON, NumPy, MCAP, ROS 2 bags and recordings of Rerun, packed by gzip or not. A [`Log`] has one [`Table`]
//!   for each topic, list, length of arrays or set of rows that columns have numbers in. A cell that is no number is a [`Fault`] of its column, so that a column nobody needs breaks nothing.
//! - [`columns`] maps what a file has onto the names of the data contract: scale, unit, sign, offset, wrap.
//! - [`join`] puts tables and files with different clocks on one clock.
//! - [`survey`] says what is in a file, and what its columns probably are.
//!
//! Whatever a file claims of its size is checked before room is made for it. What a file holds is limited to some
//! half a gigabyte more than its own size.

mod arrays;
mod bag;
mod budget;
pub mod columns;
mod csv_table;
mod encoding;
mod episodes;
mod error;
mod fence;
mod guess;
mod hdf5;
pub mod join;
mod json;
pub mod lerobot;
mod matlab;
mod mcap_log;
mod moment;
mod numpy;
mod open;
mod parquet_table;
mod preamble;
mod ros;
mod rrd;
mod sparse;
mod sqlite;
mod stamps;
pub mod survey;
mod table;
mod topics;
mod units;
mod zip;

pub use episodes::EPISODE;
pub use error::{LogError, Place, place};
pub use guess::{is_time, joint_of};
pub use open::{Format, parse, read};
pub use table::{Column, Fault, Log, Places, Table};
