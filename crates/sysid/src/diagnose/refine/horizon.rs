//! Fits of ever longer beginnings of the runs.
//!
//! Where play rattles or a foot strikes, a simulation in open loop amplifies any error of a value with time, and the error of a
//! whole run has many local minima. Over the first part of it that error has not grown yet: a fit there ends nearer to the truth,
//! near enough for one of a longer part.

use super::{Models, finishing};
use crate::data::{Data, DataRun};
use crate::diagnose::policy::{EXPLAINED, HORIZON_STEPS};
use crate::diagnose::refine::Seen;
use crate::diagnose::{Candidate, values_by_name};
use crate::fit::{self, Difference, Fit, FitOptions};
use sealegs_model::{Model, Record};

/// Shares of the runs: an eighth of two seconds holds some strokes of play that rattles, and the longer the part the steeper
/// the error's minimum.
const SHARES: [f64; 4] = [0.125, 0.25, 0.5, 0.7];

/// Share up to which a step's own gain corrects derivatives well enough, and the error is smooth.
const RUGGED_FROM: f64 = 0.5;

/// The derivatives that a fit of beginnings takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Derivatives {
    /// Once, corrected by what each step gains.
    Corrected,
    /// The same as long as the error is smooth, and anew at every step of the longer beginnings.
    AnewWhereRugged,
}

impl Models<'_> {
    /// A set fitted to ever longer beginnings of all runs, and to whole runs at last, from its values under an observer: there
    /// play has the width that it has, and in open loop it rattles, so that no fit of whole runs leads from one width to
    /// another. `None` where the observer leaves something, too, so that no values explain the runs, or nothing can be
    /// simulated.
    pub(crate) fn through_beginnings(
        &self,
        set: &Candidate,
        model: &dyn Model,
        observed: &Seen,
        derivatives: Derivatives,
    ) -> Option<Candidate> {
        if observed.error > EXPLAINED * self.data.floor {
            return None;
        }
        let options = |start, share: f64| {
            let options = finishing(self.options(model, start, set));
            let corrected = derivatives == Derivatives::Corrected || share <= RUGGED_FROM;
            FitOptions { columns: None, secants: corrected, ..options }
        };
        let through = |start: Vec<f64>, share: f64| {
            let records = beginnings(self.data, share);
            let data = of_beginnings(self.data, &records);
            let options = FitOptions { max_steps: HORIZON_STEPS as usize, ..options(start.clone(), share) };
            let fit = fit::fit(&data, model, &options);
            self.data.add_work(&data);
            fit.map_or(start, |fit| fit.values)
        };
        let start = SHARES.into_iter().fold(values_by_name(model, &observed.known), through);
        Candidate::fitted(self.data, set.effects.clone(), model.clone_box(), &options(start, 1.0)).ok()
    }

    /// How far the integrator's steps put each value of a fit off, over the first half of the runs: twice what half of them move
    /// it by, as the error of a step at which a law switches is in proportion to it. `None` if either model cannot be fitted
    /// there.
    pub(crate) fn off_by_steps(&self, fit: &Fit, model: &dyn Model, finer: &dyn Model) -> Option<Vec<f64>> {
        let records = beginnings(self.data, RUGGED_FROM);
        let data = of_beginnings(self.data, &records);
        let fitted = |model: &dyn Model, start: &[f64]| {
            let usual = FitOptions::of(model);
            let options = FitOptions { start: Some(start.to_vec()), starts: 1, last: true, ..usual };
            let options =
                FitOptions { max_steps: HORIZON_STEPS as usize, difference: Difference::Forward, ..options };
            fit::fit(&data, model, &options).ok()
        };
        let usual = fitted(model, &fit.values);
        let off = usual.and_then(|usual| {
            let finer = fitted(finer, &usual.values)?;
            Some(finer.values.iter().zip(&usual.values).map(|(a, b)| 2.0 * (a - b)).collect())
        });
        self.data.add_work(&data);
        off
    }
}

/// The first part of every run.
fn beginnings(data: &Data, share: f64) -> Vec<Record> {
    let rows = |record: &Record| (share * record.len() as f64).ceil() as usize;
    data.runs.iter().map(|run| run.record.at_rows(0..rows(run.record))).collect()
}

/// The data of such runs.
fn of_beginnings<'a>(data: &Data<'a>, records: &'a [Record]) -> Data<'a> {
    let of_run = |(run, record): (&DataRun<'a>, &'a Record)| {
        let rows = record.time_s.len();
        let scored = run.scored.iter().filter(|s| s.start < rows).map(|s| s.start..s.end.min(rows)).collect();
        let measured = run.measured.iter().map(|m| &m[..rows]).collect();
        DataRun { record, scored, measured, ..run.clone() }
    };
    let runs = data.runs.iter().zip(records).map(of_run).collect();
    Data::from_parts(data.channels.clone(), runs, data.floor)
}

#[cfg(test)]
mod tests {
    use super::{Derivatives, beginnings, of_beginnings};
    use crate::Role;
    use crate::data::Data;
    use crate::diagnose::refine::Seen;
    use crate::diagnose::{Candidate, Models};
    use crate::fit::{FitOptions, fit};
    use crate::toy::{Toy, campaign, run};

    #[test]
    fn beginnings_are_the_first_rows_of_every_channel() {
        let records = [800, 401].map(|rows| {
            (Role::Fit, run(&[1.0, 4.0, 400.0], rows, rows as u64, (0.1, 1e-4), (1.0, 0.0), 1.0))
        });
        let campaign = campaign(records.into(), (0.1, 1e-4));
        let data = Data::new(&campaign, Some(Role::Fit), &Toy::new()).expect("fit runs");
        let records = beginnings(&data, 0.25);
        let quarter = of_beginnings(&data, &records);
        for (run, whole) in quarter.runs.iter().zip(&data.runs) {
            let rows = whole.record.time_s.len().div_ceil(4);
            assert!(run.record.time_s.len() == rows && run.rows().all(|row| row < rows));
            assert!(run.measured.iter().zip(&whole.measured).all(|(part, all)| *part == &all[..rows]));
        }
    }

    #[test]
    fn a_set_is_fitted_through_beginnings_where_the_observer_explains_it_alone() {
        let toy = Toy::new();
        let record = run(&[1.0, 4.0, 400.0], 800, 3, (0.1, 1e-4), (1.0, 0.0), 1.0);
        let campaign = campaign(vec![(Role::Fit, record)], (0.1, 1e-4));
        let data = Data::new(&campaign, Some(Role::Fit), &toy).expect("a fit run");
        let models = Models::new(&data, &toy);
        let best = fit(&data, &toy, &FitOptions::default()).expect("a fit");
        let set = Candidate::exactly(&data, Vec::new(), Box::new(Toy::new()), best);
        let mut observed = Seen::of(&set.fit);
        observed.known.iter_mut().for_each(|(_, value)| *value *= 1.1);
        let again =
            models.through_beginnings(&set, &toy, &observed, Derivatives::AnewWhereRugged).expect("a fit");
        // A step that gains less than two standard errors ends a fit of a search.
        let stds = set.fit.parameters.iter().map(|p| p.std);
        let off =
            again.fit.values.iter().zip(&set.fit.values).zip(stds).map(|((a, b), std)| (a - b).abs() / std);
        let most = off.fold(0.0, f64::max);
        assert!(most < 2.0, "{most}");
        observed.error *= 2.0;
        assert!(models.through_beginnings(&set, &toy, &observed, Derivatives::Corrected).is_none());
    }
}
