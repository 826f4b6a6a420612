//! The numbers of the dissertation "Series Elasticity in Linearly Actuated Humanoids", recomputed by the product's own
//! models.
//!
//! A reproduction is data: each published value is a row of a table (`rows/*.toml`) with its place in the text, its unit,
//! its tolerance, and the formula that recomputes it. A formula is arithmetic over named inputs, or one call of a function
//! of this crate; the list of functions is [`functions`]. Nothing is tuned to the print, and a miss stays a miss.
//!
//! ```
//! let row = sealegs_reproduce::recompute("R3-02")?;
//! assert_eq!(row.unit, "Hz");
//! assert!((row.ours.expect("it has a formula") - 160.25).abs() < 0.01);
//! # Ok::<(), sealegs_reproduce::ReproduceError>(())
//! ```

mod equations;
mod error;
mod evaluate;
mod figures;
mod findings;
mod function;
mod html;
mod moving;
mod rehearsal;
mod rows;
mod setup;
mod template;
pub mod text;
mod thor;

pub use error::ReproduceError;
pub use evaluate::Row;
pub use findings::{Finding, findings};
pub use function::functions;
pub use html::html;
pub use moving::Explanation;
pub use rows::{Entry, Input, Verdict, entries};

use rehearsal::Rehearsals;
use sealegs_actuator::design::{Performance, table_8};
use sealegs_actuator::spring::SofterThanDesigned;
use setup::Setup;

/// Everything that was recomputed.
#[derive(Debug, Clone)]
pub struct Reproduction {
    /// One row per published value, in the order of the table.
    pub rows: Vec<Row>,
    /// Single causes for the printed moving-output peaks, the best first.
    pub explanations: Vec<Explanation>,
    /// What would explain the measured stiffnesses of THOR's beam.
    pub softer: SofterThanDesigned,
    /// Table 8 as it should be.
    pub table_8: [Performance; 4],
    /// Estimates for the figures.
    rehearsals: Rehearsals,
}

impl Reproduction {
    /// How many rows have a verdict.
    #[must_use]
    pub fn count(&self, verdict: Verdict) -> usize {
        self.rows.iter().filter(|r| r.verdict == verdict).count()
    }

    /// A row's value of ours, in the row's unit.
    #[must_use]
    pub fn ours(&self, id: &str) -> Option<f64> {
        self.rows.iter().find(|r| r.id == id).and_then(|r| r.ours)
    }
}

/// Recomputes every row of the table that has a formula: closed forms, and simulations of several seconds.
///
/// # Errors
///
/// [`ReproduceError`] if a row names what is not there, or a preset or a simulation fails.
pub fn reproduce() -> Result<Reproduction, ReproduceError> {
    let setup = Setup::new()?;
    let rows = setup.entries.iter().map(|entry| evaluate::row(&setup, entry)).collect::<Result<_, _>>()?;
    Ok(Reproduction {
        rows,
        explanations: moving::explanations(&setup.thor)?,
        softer: setup.softer.clone(),
        table_8: table_8(&setup.thor.spec, thor::CURRENT_LIMIT_A, thor::AMPLITUDE_N),
        rehearsals: setup.rehearsals()?.clone(),
    })
}

/// Recomputes one row.
///
/// # Errors
///
/// [`ReproduceError::UnknownRow`] if there is no such row; otherwise as [`reproduce`].
pub fn recompute(id: &str) -> Result<Row, ReproduceError> {
    let setup = Setup::new()?;
    let entry = setup.entries.iter().find(|e| e.id == id);
    evaluate::row(&setup, entry.ok_or_else(|| ReproduceError::UnknownRow { id: id.to_owned() })?)
}
