//! Drops of a leg from several heights with several springs: which spring survives which drop, as a table, as a page
//! and as a recording of all drops side by side.
//!
//! ```
//! use sealegs::impact::{Survival, sweep};
//! use sealegs::leg::scenario::SweepSpec;
//! use sealegs::{Scenario, impact};
//!
//! let scenario = Scenario::load("thor-impact", &["duration_s=0.2".to_owned()])?;
//! let over = SweepSpec { heights_m: vec![0.02], springs: vec!["compliant".to_owned(), "stiff".to_owned()] };
//! let table = sweep(&scenario, &over, false, &|| ())?;
//! let survival = Survival::of(&table, Some(20e3));
//! assert_eq!(survival.springs, ["compliant", "stiff"]);
//! let page = impact::page(&table, Some(20e3), "sealegs impact thor-impact");
//! assert!(page.contains("Peak force of the ground"));
//! # Ok::<(), sealegs::leg::LegError>(())
//! ```

mod page;
mod scene;
mod survival;

pub use page::page;
pub use scene::{DropRecorder, record};
pub use sealegs_leg::impact::{
    ImpactActuator, ImpactDrop, ImpactRow, ImpactTable, drops, sweep, sweep_watched,
};
pub use survival::{Survival, Survived};
