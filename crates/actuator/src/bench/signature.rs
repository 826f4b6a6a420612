//! An effect on a bench as a picture of its law.

use super::BenchModel;
use crate::effect::{Graph, law};
use sealegs_model::{Excitation, Model, ModelError};

impl BenchModel {
    /// The law of an effect over its own argument, at its parameters' values `own` (in the card's order), for a command
    /// on the channel `input`. `None` where at these values the effect does nothing.
    ///
    /// # Errors
    ///
    /// [`ModelError::UnknownEffect`], or [`ModelError::BadParameter`] for a drive that the input cannot command.
    pub fn law_graph(
        &self,
        id: &str,
        seen: &Excitation,
        own: &[f64],
        input: &str,
    ) -> Result<Option<Graph>, ModelError> {
        let with = self.including(id, seen)?;
        let base: Vec<f64> = self.parameters().iter().map(|p| p.value).collect();
        let all = [base.as_slice(), own].concat();
        Ok(law(&self.plant(&base, input)?, &with.plant(&all, input)?, &self.setting(seen)))
    }
}
