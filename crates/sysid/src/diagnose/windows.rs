//! Windows: a model that forgets an error after a part of a run, where an error in open loop grows or adds up.
//!
//! The search fits and compares in windows; what it found is fitted in ever longer ones on the way to open loop, which alone is
//! judged and told.

use super::policy::WINDOWS;
use super::refine::{Models, records_of};
use super::{Candidate, with_effects};
use crate::data::Data;
use crate::fit;
use sealegs_model::Model;

/// How much longer windows become on the way to open loop.
const LONGER: [f64; 2] = [4.0, 16.0];

/// The model as a search simulates it where whole runs in open loop say little: an error is forgotten after a part of the
/// mean duration of a run.
pub(super) fn in_windows(data: &Data, model: &dyn Model) -> Option<Box<dyn Model>> {
    remembering(data, model, 1.0 / WINDOWS)
}

/// The same where an error is forgotten after such a share of the mean duration.
fn remembering(data: &Data, model: &dyn Model, share: f64) -> Option<Box<dyn Model>> {
    let records = records_of(data);
    let mean_s = records.iter().map(|r| r.duration_s()).sum::<f64>() / records.len().max(1) as f64;
    model.forgetting(&records, share * mean_s)
}

impl Models<'_> {
    /// A candidate that was fitted in windows, fitted in ever longer ones: its values for open loop, where a fit from those
    /// of short windows may end anywhere. `None` for one that was fitted in open loop.
    pub(super) fn with_longer_memory(&self, candidate: &Candidate) -> Option<Vec<f64>> {
        let mut values = candidate.fit.values.clone();
        for longer in LONGER {
            let model = remembering(self.data, self.exact, longer / WINDOWS)?;
            let model = with_effects(model.as_ref(), &candidate.effects, &self.seen).ok()?;
            let options = self.options(model.as_ref(), values.clone(), candidate);
            if let Ok(fit) = fit::fit(self.data, model.as_ref(), &options) {
                values = fit.values;
            }
        }
        Some(values)
    }

    /// A candidate of the search with what it leaves in open loop, where it was fitted in windows: that is what anybody is
    /// told.
    #[must_use]
    pub(super) fn in_open_loop(&self, mut candidate: Candidate) -> Candidate {
        if candidate.exact || !self.windowed {
            return candidate;
        }
        if let Ok(open) = with_effects(self.exact, &candidate.effects, &self.seen) {
            candidate.model = open;
        }
        let (model, fit) = (candidate.model.as_ref(), &candidate.fit);
        if let Ok(evaluation) = self.data.judge(model, &fit.values, fit.sensors()) {
            candidate.fit.evaluation = evaluation;
        }
        candidate
    }
}
