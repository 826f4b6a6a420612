//! What is said of a curve beyond the catalogue, and its file, which `add` takes like any effect's.

use crate::report::units::capital;
use sealegs_model::Law;
use sealegs_sysid::diagnose::Diagnosis;
use serde::Serialize;

/// A curve that takes what no known effect takes.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct LawSaid {
    /// The id under which a model includes it.
    pub effect: String,
    /// The port with its place.
    pub port: String,
    /// What it depends on.
    pub depends_on: String,
    /// The effects that are named beside it.
    pub beside: Vec<String>,
    /// Root mean square residual of the holdout runs with it, in noise units.
    pub holdout_error: f64,
    /// The same of the fit runs.
    pub fit_error: f64,
    /// Share of the energy above the noise floor that it takes on the holdout runs.
    pub explained: f64,
    /// The law itself; the text of its file is this as TOML.
    #[schemars(with = "std::collections::BTreeMap<String, serde_json::Value>")]
    pub law: Law,
}

impl LawSaid {
    /// That of a diagnosis, where there is one that helps.
    #[must_use]
    pub fn of(diagnosis: &Diagnosis) -> Option<Self> {
        let judged = diagnosis.verdict.law.as_ref()?;
        let found = &diagnosis.found.laws[judged.which];
        // What the rotor lacks and the command tells is the drive's.
        let port = match found.law.acts_on.as_str() {
            "drive" => found.law.place.as_ref().map_or("drive".to_owned(), |place| format!("{place}/drive")),
            _ => found.port.clone(),
        };
        Some(Self {
            effect: found.law.effect(),
            port,
            depends_on: found.on.to_owned(),
            beside: diagnosis.verdict.effects.clone(),
            holdout_error: judged.holdout_error,
            fit_error: judged.fit_error,
            explained: judged.explained,
            law: found.law.clone(),
        })
    }

    /// In one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        capital(&self.said())
    }

    /// The same as a part of another sentence.
    pub(super) fn said(&self) -> String {
        let place = self.law.place.as_ref().map_or_else(String::new, |place| format!(" of {place}"));
        let port = match self.law.acts_on.split_once('/') {
            Some((_, channel)) => format!("sensor {channel}"),
            None => self.law.acts_on.clone(),
        };
        let what = if self.beside.is_empty() { "what is missing" } else { "what stays" };
        format!(
            "{what} acts at the {port}{place} and depends on {}: a curve explains {} of it on the held-out runs, down to {:.2} noise units.",
            self.depends_on,
            super::outcome::percent(self.explained),
            self.holdout_error
        )
    }

    /// The text of its file.
    ///
    /// # Errors
    ///
    /// None for finite numbers.
    pub fn file(&self, campaign: &str) -> crate::Result<String> {
        let text = toml::to_string(&self.law).map_err(crate::Error::model_file)?;
        Ok(format!(
            "# What no known effect gives in the campaign {campaign}: a curve that was fitted to it. Valid where it was seen.\n\
             # sealegs add THIS.toml --campaign CAMPAIGN -o BETTER.toml\n\n{text}"
        ))
    }
}
