//! Fit runs in parts, each of which is left out of a fit once.

use super::windows::in_windows;
use crate::data::{Data, DataRun};
use crate::diagnose::policy::{FOLDS, STEPS_PER_SAMPLE};
use crate::diagnose::refine::Models;
use crate::diagnose::{Candidate, values_by_name, with_effects};
use crate::fit::{self, Fit};
use rayon::prelude::*;
use sealegs_model::Model;
use std::ops::Range;

/// Some fit runs, and the others; or a part of a single run, and the rest of it.
pub(crate) struct Fold<'a> {
    pub rest: Data<'a>,
    pub left_out: Data<'a>,
}

/// The fit runs in parts, each of which is left out once; a single run in parts of equal length.
pub(crate) fn folds<'a>(data: &Data<'a>) -> Vec<Fold<'a>> {
    let one = data.runs.len() == 1;
    let parts = if one { FOLDS as usize } else { data.runs.len().min(FOLDS as usize) };
    let of_part = |is_of: &dyn Fn(usize) -> bool| {
        let of_run = |(number, run): (usize, &DataRun<'a>)| {
            if !one {
                return is_of(number % parts).then(|| run.clone());
            }
            let (rows, total) = (run.rows().enumerate(), run.scored_rows());
            let kept = rows.filter(|(row, _)| is_of(parts * row / total));
            let scored = stretches(kept.map(|(_, index)| index));
            (!scored.is_empty()).then(|| DataRun { scored, ..run.clone() })
        };
        let runs = data.runs.iter().enumerate().filter_map(of_run).collect();
        Data::from_parts(data.channels.clone(), runs, data.floor)
    };
    let fold = |part: usize| Fold { rest: of_part(&|of| of != part), left_out: of_part(&|of| of == part) };
    (0..parts).map(fold).collect()
}

/// Ascending rows as ranges.
fn stretches(rows: impl Iterator<Item = usize>) -> Vec<Range<usize>> {
    let mut all: Vec<Range<usize>> = Vec::new();
    for row in rows {
        match all.last_mut() {
            Some(last) if last.end == row => last.end += 1,
            _ => all.push(row..row + 1),
        }
    }
    all
}

impl Models<'_> {
    /// What `each` says of the rest of the fit runs and of what is left out, fold by fold.
    pub(crate) fn over_folds<T: Send>(
        &self,
        folds: &[Fold],
        each: impl Fn(&Data, &Data) -> T + Sync + Send,
    ) -> Vec<T> {
        let of_fold = |fold: &Fold| {
            // A copy counts its own work from zero.
            let (rest, left_out) = (fold.rest.clone(), fold.left_out.clone());
            let said = each(&rest, &left_out);
            self.data.add_work(&rest);
            self.data.add_work(&left_out);
            said
        };
        folds.par_iter().map(of_fold).collect()
    }

    /// Sum of squared residuals of runs that a set is not fitted to, over all folds; infinite if it cannot be simulated. In open
    /// loop, as the holdout runs will be judged, or in windows where open loop says little.
    pub(crate) fn left_of_others(&self, set: &Candidate, folds: &[Fold]) -> f64 {
        let searched = self.exact.coarser(STEPS_PER_SAMPLE);
        let searched = in_windows(self.data, searched.as_ref()).unwrap_or(searched);
        let Ok(model) = with_effects(searched.as_ref(), &set.effects, &self.seen) else {
            return f64::INFINITY;
        };
        let start = values_by_name(model.as_ref(), &set.known());
        let options = self.options(model.as_ref(), start, set);
        let of_fold = |rest: &Data, left_out: &Data| {
            let fit = fit::fit(rest, model.as_ref(), &options).ok();
            fit.map_or(f64::INFINITY, |fit| squares(left_out, model.as_ref(), &fit))
        };
        self.over_folds(folds, of_fold).into_iter().sum()
    }
}

/// Sum of squared residuals of runs with the values of a fit to others; infinite if they cannot be simulated.
pub(crate) fn squares(left_out: &Data, model: &dyn Model, fit: &Fit) -> f64 {
    let at = left_out.judge(model, &fit.values, fit.sensors());
    at.map_or(f64::INFINITY, |at| at.blocks.iter().flat_map(|b| &b.residual).map(|r| r * r).sum())
}
