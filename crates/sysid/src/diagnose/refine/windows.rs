//! Windows: a model that forgets an error after a part of a run, where an error in open loop grows or adds up.
//!
//! The search fits and compares in windows. What it found is fitted in ever longer ones on the way to open loop, which alone
//! is judged and told. Where it leaves something, that error grows in open loop, too, and values that take some of it there
//! may be worth nothing on the next run: a last fit ends in the windows from which left-out runs are predicted best.

use super::{Models, records_of};
use crate::data::Data;
use crate::diagnose::policy::{EXPLAINED, WINDOWS};
use crate::diagnose::refine::folds::{folds, squares};
use crate::diagnose::{Candidate, with_effects};
use crate::fit::{self, Fit};
use sealegs_model::Model;

/// After what a simulation forgets an error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Memory {
    /// So many times the length of the search's windows.
    Windows(f64),
    /// Never.
    OpenLoop,
}

/// On the way from the search's windows to open loop: each fit starts where the one before it ended.
const WAY: [Memory; 4] =
    [Memory::Windows(1.0), Memory::Windows(4.0), Memory::Windows(16.0), Memory::OpenLoop];

/// The model as a search simulates it where whole runs in open loop say little: an error is forgotten after a part of the
/// mean duration of a run.
pub(crate) fn in_windows(data: &Data, model: &dyn Model) -> Option<Box<dyn Model>> {
    remembering(data, model, 1.0 / WINDOWS)
}

/// The same where an error is forgotten after such a share of the mean duration.
fn remembering(data: &Data, model: &dyn Model, share: f64) -> Option<Box<dyn Model>> {
    let records = records_of(data);
    let mean_s = records.iter().map(|r| r.duration_s()).sum::<f64>() / records.len().max(1) as f64;
    model.forgetting(&records, share * mean_s)
}

impl Models<'_> {
    /// The model itself with a memory; `None` where it never forgets.
    pub(crate) fn remembering(&self, memory: Memory) -> Option<Box<dyn Model>> {
        match memory {
            Memory::Windows(longer) => remembering(self.data, self.exact, longer / WINDOWS),
            Memory::OpenLoop => None,
        }
    }

    /// A candidate that was fitted in windows, fitted in ever longer ones: its values for a last fit, which may end anywhere
    /// from those of short windows. `None` for one that was fitted in open loop.
    pub(crate) fn with_longer_memory(&self, candidate: &Candidate) -> Option<Vec<f64>> {
        if !self.windowed {
            return None;
        }
        let last = WAY.iter().position(|memory| *memory == self.last)?;
        let further = |values: Vec<f64>, memory: &Memory| {
            let fit = self.fitted_to(self.data, candidate, values.clone(), *memory);
            fit.map_or(values, |fit| fit.values)
        };
        Some(WAY[..last].iter().skip(1).fold(candidate.fit.values.clone(), further))
    }

    /// A candidate's model fitted to some runs with a memory.
    fn fitted_to(&self, data: &Data, candidate: &Candidate, start: Vec<f64>, memory: Memory) -> Option<Fit> {
        let model = self.remembering(memory);
        let model =
            with_effects(model.as_deref().unwrap_or(self.exact), &candidate.effects, &self.seen).ok()?;
        let options = self.options(model.as_ref(), start, candidate);
        fit::fit(data, model.as_ref(), &options).ok()
    }

    /// The memory with which a last fit of a set predicts left-out runs best, in open loop as they will be judged. Open loop
    /// where the set explains what the windows hold: no error is left that would grow.
    #[must_use]
    pub(crate) fn last_memory(&self, set: &Candidate) -> Memory {
        if !self.windowed || set.fit.error() <= EXPLAINED * self.data.floor {
            return Memory::OpenLoop;
        }
        let Ok(open) = with_effects(self.exact, &set.effects, &self.seen) else { return Memory::OpenLoop };
        let of_fold = |rest: &Data, left_out: &Data| -> [f64; WAY.len()] {
            let mut values = set.fit.values.clone();
            WAY.map(|memory| {
                let Some(fit) = self.fitted_to(rest, set, values.clone(), memory) else {
                    return f64::INFINITY;
                };
                values.clone_from(&fit.values);
                squares(left_out, open.as_ref(), &fit)
            })
        };
        let folds = self.over_folds(&folds(self.data), of_fold);
        let left = |k: usize| folds.iter().map(|fold| fold[k]).sum::<f64>();
        let best = (0..WAY.len()).reduce(|a, b| if left(b) <= left(a) { b } else { a });
        best.map_or(Memory::OpenLoop, |best| WAY[best])
    }

    /// A candidate with what it leaves in open loop, where it was fitted in windows: that is what anybody is told.
    #[must_use]
    pub(crate) fn in_open_loop(&self, mut candidate: Candidate) -> Candidate {
        if !self.windowed {
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
