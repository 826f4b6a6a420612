//! What the functions of the table compute with: the table itself, the presets, and simulations that are done once.

use std::sync::OnceLock;

use sealegs_actuator::ActuatorSpec;
use sealegs_actuator::response::SecondOrderFit;
use sealegs_actuator::spring::{ClampSetting, MomentLoadedBeam, SofterThanDesigned};

use crate::ReproduceError;
use crate::rehearsal::{self, Rehearsals};
use crate::rows::{Entry, entries};
use crate::thor::Thor;

/// See the module.
#[derive(Debug)]
pub(crate) struct Setup {
    /// The table.
    pub(crate) entries: Vec<Entry>,
    /// THOR's actuator in its three models.
    pub(crate) thor: Thor,
    /// SAFFiR's actuator.
    pub(crate) saffir: ActuatorSpec,
    /// The fit of eq 3-14 as printed.
    pub(crate) fit: SecondOrderFit,
    /// What the two printed slopes of THOR's beam point to.
    pub(crate) softer: SofterThanDesigned,
    rehearsals: OnceLock<Result<Rehearsals, ReproduceError>>,
}

impl Setup {
    pub(crate) fn new() -> Result<Self, ReproduceError> {
        let entries = entries()?;
        let value = |id: &str| printed(&entries, id);
        let fit = SecondOrderFit {
            numerator_1_s2: value("E3-14a")?,
            damping_1_s: value("E3-14b")?,
            constant_1_s2: value("E3-14c")?,
        };
        let beam = MomentLoadedBeam::thor(ClampSetting::Compliant);
        let softer = SofterThanDesigned::new(&beam, value("H2-07")?, value("H2-08")?);
        Ok(Self {
            thor: Thor::new()?,
            saffir: ActuatorSpec::preset("saffir-linear")?,
            fit,
            softer,
            rehearsals: OnceLock::new(),
            entries,
        })
    }

    /// A printed value that others are computed from, in its row's unit.
    pub(crate) fn printed(&self, id: &str) -> Result<f64, ReproduceError> {
        printed(&self.entries, id)
    }

    /// The identifications of section 3-4 on simulated benches.
    pub(crate) fn rehearsals(&self) -> Result<&Rehearsals, ReproduceError> {
        self.rehearsals.get_or_init(|| rehearsal::rehearse(&self.thor)).as_ref().map_err(Clone::clone)
    }
}

fn printed(entries: &[Entry], id: &str) -> Result<f64, ReproduceError> {
    let found = entries.iter().find(|e| e.id == id).and_then(|e| e.value);
    found.ok_or_else(|| ReproduceError::UnknownRow { id: format!("{id} with a printed number") })
}
