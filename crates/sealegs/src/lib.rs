//! Legs with linear series elastic actuators: simulate them, compare them with logs, find the physical effect that the
//! model lacks, and add it.
//!
//! ```no_run
//! use sealegs::{Campaign, Options, add, compare, diagnose};
//!
//! // A folder with a campaign.toml and one table a run.
//! let campaign = Campaign::read("knee-bench".as_ref())?;
//! // Where does the model fail, and by how much?
//! println!("{}", compare(&campaign, Options::new())?.sentence());
//! // Which physical effect is missing?
//! let verdict = diagnose(&campaign, Options::new())?;
//! println!("{}", verdict.sentence());
//! std::fs::write("diagnose.html", verdict.to_html()?)?;
//! // How far does the error fall with it?
//! let better = add(&verdict.outcome().effects, &campaign, Options::new())?;
//! println!("{}", better.sentence());
//! std::fs::write("better.toml", better.model_file(".".as_ref())?)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What there is
//!
//! - [`Campaign`] holds logs: [`Campaign::read`] takes files, [`Campaign::builder`] columns in memory.
//! - [`compare()`], [`diagnose()`] and [`add()`] return [`Comparison`], [`Diagnosis`] and [`Addition`]: types that
//!   serialise ([`comparison::Summary`], [`diagnosis::outcome::Outcome`], [`diagnosis::addition::Summary`]) and from
//!   which JSON, text, an HTML report and a Rerun recording are made. [`Options`] says which model is meant
//!   ([`ModelSource`]), who is told of progress, and who may stop the work ([`Stop`]).
//! - [`ScenarioBuilder`] and [`leg::scenario::Scenario::run`] simulate a leg, [`BenchBuilder`] an actuator on a bench.
//! - [`catalogue`] has every effect's card, and what a log shows of it.
//! - [`impact`] drops a leg from several heights with several springs: table, report, recording.
//! - [`jobs`] spreads lists of independent jobs over machines, and puts their results together.
//! - [`mystery`] makes campaigns with something hidden in them, and judges a verdict.
//! - [`schema`] describes the results' JSON.
//! - [`Error`] is one enum for everything that can go wrong, with the members' own errors inside.
//!
//! The members are here under their own names: [`model`], [`actuator`], [`leg`], [`sysid`], [`recorder`] and
//! [`reference`](mod@reference).
//!
//! # Conventions
//!
//! `f64`, SI units and radians; a name's ending is its unit (`force_1_n`, `motor_angle_rad`). A residual is measured
//! minus predicted, in units of the channel's noise. Forces inside an actuator are positive in compression.

pub mod bench_model;
pub mod campaign_model;
pub mod catalogue;
pub mod comparison;
pub mod diagnosis;
mod error;
pub mod impact;
pub mod jobs;
pub mod leg_model;
pub mod leg_scene;
pub mod mystery;
pub mod notes;
mod options;
mod report;
mod robot_columns;
pub mod robot_model;
pub mod sanity;
pub mod schema;
mod simulate;
mod stoppable;

pub use sealegs_actuator as actuator;
pub use sealegs_leg as leg;
pub use sealegs_logs as logs;
pub use sealegs_model as model;
pub use sealegs_recorder as recorder;
pub use sealegs_reference as reference;
pub use sealegs_sysid as sysid;

pub use comparison::{Comparison, of_campaign as compare};
pub use diagnosis::{Addition, Diagnosis, add, diagnose};
pub use error::{Error, Result};
pub use options::{ModelSource, Options, Stop};
pub use sealegs_leg::scenario::Scenario;
pub use sealegs_sysid::campaign::{Bench, Campaign, CampaignBuilder, Role, RunColumns};
pub use simulate::{BenchBuilder, BenchRun, ScenarioBuilder};

/// A result as JSON, indented.
fn json(result: &impl serde::Serialize) -> Result<String> {
    serde_json::to_string_pretty(result)
        .map_err(|e| Error::Unwritable { what: "the result", problem: e.to_string() })
}
