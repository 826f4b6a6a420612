//! The dissertation's numbers, recomputed by the product's own models: one file per topic, each entering its rows in a
//! [`Ledger`] with a line of why. The printed side is data ([`published`]); nothing here is tuned to it, and a miss
//! stays a miss.

mod chapter2;
mod chapter3;
pub mod chapter4;
mod clipping;
mod equations;
pub mod figures;
pub mod findings;
pub mod html;
mod ledger;
pub mod moving;
pub mod published;
mod rehearsal;
pub mod text;
pub mod thor;

pub use ledger::{Ledger, Row};
pub use published::Verdict;

use rehearsal::Rehearsals;
use sealegs::actuator::design::{Performance, table_8};
use sealegs::actuator::spring::{ClampSetting, MomentLoadedBeam, SofterThanDesigned};
use thor::Thor;

/// Everything that was recomputed.
#[derive(Debug, Clone)]
pub struct Reproduction {
    /// One row per published value, in the order of the text.
    pub rows: Vec<Row>,
    /// Single causes for the printed moving-output peaks, the best first.
    pub explanations: Vec<moving::Explanation>,
    /// What would explain the measured stiffnesses of THOR's beam.
    pub softer: SofterThanDesigned,
    /// Table 8 as it should be.
    pub table_8: [Performance; 4],
    /// Estimates for the figures.
    pub rehearsals: Rehearsals,
}

impl Reproduction {
    /// How many rows have a verdict.
    #[must_use]
    pub fn count(&self, verdict: Verdict) -> usize {
        self.rows.iter().filter(|r| r.verdict == verdict).count()
    }

    /// A row's value of ours.
    #[must_use]
    pub fn ours(&self, id: &str) -> Option<f64> {
        self.rows.iter().find(|r| r.id == id).and_then(|r| r.ours)
    }
}

/// Recomputes every row that can be recomputed: closed forms, then simulations.
///
/// # Errors
///
/// If a preset, a printed value or a simulation fails.
pub fn reproduce() -> anyhow::Result<Reproduction> {
    let published = published::published()?;
    let thor = Thor::new()?;
    let mut ledger = Ledger::new(&published);
    chapter2::enter(&mut ledger)?;
    chapter3::enter(&mut ledger, &thor)?;
    moving::enter(&mut ledger, &thor)?;
    let rehearsals = rehearsal::enter(&mut ledger, &thor)?;
    chapter4::enter(&mut ledger, &thor)?;
    clipping::enter(&mut ledger, &thor)?;
    Ok(Reproduction {
        rows: ledger.rows(),
        explanations: moving::explanations(&thor)?,
        softer: SofterThanDesigned::new(
            &MomentLoadedBeam::thor(ClampSetting::Compliant),
            ledger.printed("H2-07")?,
            ledger.printed("H2-08")?,
        ),
        table_8: table_8(&thor.spec, chapter4::CURRENT_LIMIT_A, chapter4::AMPLITUDE_N),
        rehearsals,
    })
}
