//! Fits of sets of effects: under an observer first, where the error is smooth, then open loop, where it counts.
//!
//! Whole runs in open loop have many local minima where a rotor sticks, play rattles or a limit is reached. Under an
//! observer (see [`Model::observing`]) an error lasts for one of its time constants only. What is fitted there begins the
//! fit in open loop, which alone is validated, compared and judged.

pub(super) mod conventions;
pub(super) mod count;
pub(super) mod folds;
pub(super) mod horizon;
pub(super) mod last;
pub(super) mod profile;
pub(super) mod rugged;
pub(super) mod starts;
pub(super) mod windows;

use crate::Error;
use crate::data::Data;
use crate::diagnose::candidate::{
    Known,
    compare::{excess, is_seen, mean_square_difference},
};
use crate::diagnose::policy::{
    AT_FLOOR, LEFT_SHARE, NEAR_FLOOR, OBSERVED_STEPS, RACE_STEPS, RACED, STEPS, STEPS_DEAR, STEPS_PER_SAMPLE,
    TRACE, WEAKER,
};
use crate::diagnose::{Candidate, values_by_name, with_effects};
use crate::fit::{self, Difference, Fit, FitOptions};
use rayon::prelude::*;
use sealegs_model::{Excitation, Model, Parameter, Record};
use starts::{mixed_by_place, weakened, weakest, with_nominal_base};
use std::sync::{Arc, Mutex, PoisonError};
use windows::{Memory, in_windows};

/// Gain of a step with which a fit in a search is content (see [`FitOptions::tolerance`]).
const TOLERANCE: f64 = 0.05;

/// The same of the leader where derivatives are dear: two standard errors of a parameter.
const FINISHED_TOLERANCE: f64 = 1.0;

/// The same where only the neighbourhood is wanted, or derivatives are dear.
const ROUGH_TOLERANCE: f64 = 3.0;

/// A base model in the forms in which a diagnosis uses it, with the fit runs.
#[derive(Clone)]
pub struct Models<'a> {
    /// The fit runs.
    pub data: &'a Data<'a>,
    /// The model itself.
    pub exact: &'a dyn Model,
    /// As the search integrates it.
    pub coarse: Box<dyn Model>,
    /// The same under an observer, where the runs measure a motion to follow.
    pub observed: Option<Box<dyn Model>>,
    /// What the fit runs measured and how hard they drove the model.
    pub seen: Excitation,
    /// Whether a simulation is dear, see [`Model::is_dear`].
    pub dear: bool,
    /// Whether `coarse` simulates in windows, see [`Model::forgetting`].
    pub windowed: bool,
    /// In what a last fit simulates then.
    pub last: Memory,
    /// Fits under the observer that were done before.
    pub(crate) before: Arc<Mutex<Vec<ObservedBefore>>>,
}

/// What a fit under the observer came to.
#[derive(Debug, Clone)]
pub(crate) struct Seen {
    /// What it left, as a cost.
    pub cost: f64,
    /// The same as an error.
    pub error: f64,
    pub known: Known,
}

impl Seen {
    pub fn of(fit: &Fit) -> Self {
        Self { cost: fit.cost, error: fit.error(), known: fit.known() }
    }
}

/// A set, its start under the observer, the most steps and what was held; and what came of it.
pub(crate) type ObservedBefore = ((Vec<String>, Vec<f64>, usize, Vec<String>), Candidate);

pub(crate) fn records_of<'a>(data: &Data<'a>) -> Vec<&'a Record> {
    data.runs.iter().map(|r| r.record).collect()
}

impl<'a> Models<'a> {
    /// The forms of a model for some runs.
    #[must_use]
    pub fn new(data: &'a Data<'a>, exact: &'a dyn Model) -> Self {
        let coarse = exact.coarser(STEPS_PER_SAMPLE);
        let observed = coarse.observing(&records_of(data));
        let windows = in_windows(data, coarse.as_ref());
        let windowed = windows.is_some();
        let dear = exact.is_dear();
        let coarse = windows.unwrap_or(coarse);
        let last = Memory::OpenLoop;
        let (seen, before) = (Excitation::default(), Arc::default());
        Self { data, exact, coarse, observed, seen, dear, windowed, last, before }
    }

    /// The search's forms with the model's own steps from now on.
    pub fn refine(&mut self) {
        self.coarse = in_windows(self.data, self.exact).unwrap_or_else(|| self.exact.clone_box());
        self.observed = self.exact.observing(&records_of(self.data));
        self.before = Arc::default();
    }

    /// Goes on with the model's own steps where the search's change what a set predicts under the observer by more than a model that
    /// leaves nothing may miss by, and by a hundredth of what is missing there; whether they do. A slow log of a servo with a fast
    /// loop would lack an effect at once.
    pub fn refine_where_steps_show(&mut self, set: &Candidate) -> bool {
        let own = self.exact.observing(&records_of(self.data)).filter(|_| !self.dear);
        let seen = self.observing(set, &with_nominal_base(self.exact, &set.known()));
        let (Some(own), Some(Candidate { fit: seen, .. })) = (own, seen) else { return false };
        let exactly = with_effects(own.as_ref(), &set.effects, &self.seen)
            .and_then(|model| self.data.evaluate(model.as_ref(), &seen.values));
        let nothing = (NEAR_FLOOR.powi(2) - 1.0) * self.data.floor.powi(2);
        let least = nothing.max(LEFT_SHARE * excess(seen.error(), self.data.floor));
        let refines = exactly.is_ok_and(|exactly| mean_square_difference(&seen.evaluation, &exactly) > least);
        if refines {
            self.refine();
        }
        refines
    }

    /// Mean squared difference of a set's predictions with the search's steps and with the model's own, in squared noise
    /// units.
    #[must_use]
    pub fn step_error(&self, candidate: &Candidate) -> f64 {
        let exact = in_windows(self.data, self.exact);
        let exactly = with_effects(exact.as_deref().unwrap_or(self.exact), &candidate.effects, &self.seen)
            .and_then(|model| self.data.evaluate(model.as_ref(), &candidate.fit.values));
        exactly.map_or(0.0, |exactly| mean_square_difference(&exactly, &candidate.fit.evaluation))
    }

    /// The base model's own fit in open loop, every discrete choice tried where the observer does not tell; and what it saw.
    ///
    /// # Errors
    ///
    /// As [`fit::fit`].
    pub fn base(&mut self) -> Result<Candidate, Error> {
        let usual = FitOptions::of(self.exact);
        let difference = if self.dear { Difference::Forward } else { usual.difference };
        let options = FitOptions { difference, start: self.choice_under_observer(), ..usual };
        let fit = count::fit_holding(self.data, self.coarse.as_ref(), &options)?;
        self.seen = self.data.excitation(&fit.evaluation.predictions);
        let mut base = Candidate::of_base(self.data, self.coarse.as_ref(), fit);
        // Where the search's steps are the model's own there is nothing to polish.
        let exactly = self.data.predict(self.exact, &base.fit.values);
        base.exact = exactly.is_ok_and(|p| p == base.fit.evaluation.predictions);
        Ok(base)
    }

    /// The base model's nominal values with the discrete choices that are clearly the best under the observer; `None` where
    /// none is. Whole runs in open loop may favour a wrong one while an effect is missing, as it takes some of the drift.
    fn choice_under_observer(&self) -> Option<Vec<f64>> {
        let observed = self.observed.as_deref().filter(|_| !self.dear)?;
        let choices = fit::choices(observed);
        if choices.len() < 2 {
            return None;
        }
        let fit = |start: &Vec<f64>| {
            let options = FitOptions {
                start: Some(start.clone()),
                starts: 1,
                max_steps: OBSERVED_STEPS as usize,
                tolerance: ROUGH_TOLERANCE,
                difference: Difference::Forward,
                held: count::held(observed),
                ..FitOptions::default()
            };
            fit::fit(self.data, observed, &options).ok().map(|fit| (start.clone(), fit))
        };
        let mut fitted: Vec<(Vec<f64>, Fit)> = choices.par_iter().filter_map(fit).collect();
        fitted.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
        let (best, next) = (fitted.first()?, fitted.get(1)?);
        is_seen(&next.1, &best.1).then(|| best.0.clone())
    }

    pub(crate) fn options(&self, model: &dyn Model, start: Vec<f64>, near: &Candidate) -> FitOptions {
        FitOptions {
            start: Some(start),
            starts: 1,
            max_steps: if self.dear { STEPS_DEAR } else { STEPS } as usize,
            tolerance: if self.dear { ROUGH_TOLERANCE } else { TOLERANCE },
            difference: if self.dear { Difference::Secant } else { Difference::Forward },
            secants: self.dear,
            compares: self.dear,
            columns: self.dear.then(|| near.columns()),
            held: count::held(model),
            ..FitOptions::default()
        }
    }

    /// A candidate fitted under the observer, from values by name: what screening looks beside, as its residual has no part
    /// that the base parameters could still take. `None` where there is no observer.
    #[must_use]
    pub fn observing(&self, candidate: &Candidate, known: &Known) -> Option<Candidate> {
        self.observed_for(candidate, known, OBSERVED_STEPS as usize, &[])
    }

    /// A candidate under the observer as its maker states it, or fitted where nothing is known of a base parameter: what is
    /// missing at a port is seen beside values that the missing effect has not driven away.
    #[must_use]
    pub fn as_stated(&self, candidate: &Candidate, known: &Known) -> Option<Candidate> {
        let unknown = |p: &Parameter| !p.fixed && p.prior_std.is_none();
        if self.exact.parameters().iter().any(unknown) || !candidate.effects.is_empty() {
            return self.observing(candidate, known);
        }
        // What a model has under an observer alone, a sensor's zero, its maker does not state.
        let stated: Vec<String> = self.exact.parameters().iter().map(|p| p.name.clone()).collect();
        let more = self.observed.as_deref().is_some_and(|o| o.parameters().len() > stated.len());
        self.observed_for(candidate, known, if more { RACE_STEPS as usize } else { 0 }, &stated)
    }

    /// A candidate under the observer after so many steps at most from values by name, with some of them held; as it was found
    /// before, where that was asked for already.
    fn observed_for(
        &self,
        candidate: &Candidate,
        known: &Known,
        steps: usize,
        held: &[String],
    ) -> Option<Candidate> {
        let observed = self.observed.as_deref()?;
        let model = with_effects(observed, &candidate.effects, &self.seen).ok()?;
        let start = values_by_name(model.as_ref(), known);
        let asked = (candidate.effects.clone(), start.clone(), steps, held.to_vec());
        let before = || self.before.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, fitted)) = before().iter().find(|(known, _)| *known == asked) {
            return Some(fitted.clone());
        }
        let usual = under_observer(self.options(model.as_ref(), start, candidate));
        let held = usual.held.iter().chain(held).cloned().collect();
        let options = FitOptions { max_steps: steps, tolerance: ROUGH_TOLERANCE, held, ..usual };
        let fit = fit::fit(self.data, model.as_ref(), &options).ok();
        let fitted = fit.map(|fit| Candidate { model, fit, ..candidate.clone() });
        // What was refused is asked for again.
        before().extend(fitted.clone().map(|fitted| (asked, fitted)));
        fitted
    }

    /// Sets fitted from values by name under the observer, each from where it leaves least: beside the base model's nominal
    /// values, beside those of `near`, and there with an effect that is a part as strong, as a linear regression overrates
    /// what saturates. After a few steps only those go on that may still be the best. `None` where nothing can be
    /// simulated. `near` is fitted under the observer, too: its derivatives may be taken over.
    #[must_use]
    pub fn observed_fits(&self, near: &Candidate, sets: &[(Vec<String>, Known)]) -> Vec<Option<Fit>> {
        let first = |(set, known): &(Vec<String>, Known)| self.observed_fit(near, set, known);
        let mut fits: Vec<Option<Fit>> = sets.par_iter().map(first).collect();
        let least = fits.iter().flatten().map(|fit| fit.cost).fold(f64::INFINITY, f64::min);
        fits.par_iter_mut().zip(sets).for_each(|(fit, (set, _))| {
            let raced = fit.as_ref().filter(|fit| !fit.converged && fit.cost <= RACED * least);
            if let Some(on) = raced.and_then(|fit| self.observed_on(near, set, fit)) {
                *fit = Some(on);
            }
        });
        fits
    }

    /// A set's first few steps under the observer.
    pub(crate) fn observed_fit(&self, near: &Candidate, effects: &[String], known: &Known) -> Option<Fit> {
        let model = with_effects(self.observed.as_deref()?, effects, &self.seen).ok()?;
        let nominal = values_by_name(model.as_ref(), &with_nominal_base(self.exact, known));
        let of_base = near.known().into_iter().filter(|(name, _)| !name.contains('.'));
        let beside: Known = known.iter().cloned().chain(of_base).rev().collect();
        let beside = values_by_name(model.as_ref(), &beside);
        let weaker = weakened(model.as_ref(), &beside, near, WEAKER);
        let starts = [nominal, beside, weaker];
        let cost =
            |values: &Vec<f64>| self.data.evaluate(model.as_ref(), values).map_or(f64::INFINITY, |e| e.cost);
        let best = starts.into_iter().map(|s| (cost(&s), s)).reduce(|a, b| if b.0 < a.0 { b } else { a })?;
        let from = |start: Vec<f64>| {
            let options = FitOptions {
                max_steps: RACE_STEPS as usize,
                tolerance: ROUGH_TOLERANCE,
                ..self.options(model.as_ref(), start, near)
            };
            fit::fit(self.data, model.as_ref(), &options).ok()
        };
        let fit = from(best.1)?;
        let (least, weaker) = weakest(model.as_ref(), &fit.values, near, &cost);
        let again = if least < fit.cost { from(weaker) } else { None };
        Some(again.filter(|again| again.cost < fit.cost).unwrap_or(fit))
    }

    /// The rest of such a fit.
    pub(crate) fn observed_on(&self, near: &Candidate, effects: &[String], fit: &Fit) -> Option<Fit> {
        let model = with_effects(self.observed.as_deref()?, effects, &self.seen).ok()?;
        let options = FitOptions {
            max_steps: (OBSERVED_STEPS - RACE_STEPS) as usize,
            tolerance: ROUGH_TOLERANCE,
            ..self.options(model.as_ref(), fit.values.clone(), near)
        };
        fit::fit(self.data, model.as_ref(), &options).ok()
    }

    /// A set fitted in open loop from values by name, or from those of its fit under the observer where these are nearer.
    /// `None` if nothing can be simulated.
    #[must_use]
    pub fn fitted(
        &self,
        near: &Candidate,
        effects: &[String],
        known: &Known,
        observed: Option<&Known>,
    ) -> Option<Candidate> {
        let model = with_effects(self.coarse.as_ref(), effects, &self.seen).ok()?;
        let mut starts = vec![values_by_name(model.as_ref(), known)];
        if let Some(observed) = observed {
            // The effects as the observer has them, beside the base model as it is nearby.
            let nearby = near.known().into_iter().filter(|(name, _)| !name.contains('.'));
            let mixed: Known = nearby.chain(observed.iter().cloned()).collect();
            starts.push(values_by_name(model.as_ref(), &mixed));
            starts.push(values_by_name(model.as_ref(), observed));
        }
        let cost =
            |values: &Vec<f64>| self.data.evaluate(model.as_ref(), values).map_or(f64::INFINITY, |e| e.cost);
        let costs: Vec<f64> = starts.iter().map(cost).collect();
        let best = (0..starts.len()).reduce(|a, b| if costs[b] < costs[a] { b } else { a })?;
        let mut start = starts[best].clone();
        if let (true, Some(own)) = (self.dear && observed.is_some(), starts.last()) {
            start = mixed_by_place(model.as_ref(), (start, costs[best]), own, near, &cost);
        }
        let options = self.options(model.as_ref(), start, near);
        let fitted = Candidate::fitted(self.data, effects.to_vec(), model, &options).ok()?;
        Some(self.tuned(fitted))
    }

    /// A set fitted in open loop from values by name.
    #[must_use]
    pub fn fitted_near(&self, near: &Candidate, effects: &[String], known: &Known) -> Option<Candidate> {
        let model = with_effects(self.coarse.as_ref(), effects, &self.seen).ok()?;
        let start = values_by_name(model.as_ref(), known);
        let options = self.options(model.as_ref(), start, near);
        Candidate::fitted(self.data, effects.to_vec(), model, &options).ok()
    }

    /// A set fitted from the values of a part of it, with what it has beyond that as it is in the set, but weaker.
    #[must_use]
    pub(crate) fn fitted_from_part(&self, part: &Candidate, set: &Candidate) -> Option<Candidate> {
        let model = with_effects(self.coarse.as_ref(), &set.effects, &self.seen).ok()?;
        let known: Known = part.known().into_iter().chain(set.known()).collect();
        let start = weakened(model.as_ref(), &values_by_name(model.as_ref(), &known), part, WEAKER);
        let options = self.options(model.as_ref(), start, part);
        Candidate::fitted(self.data, set.effects.clone(), model, &options).ok()
    }

    /// Where the search does without derivatives, a candidate fitted on with its own.
    #[must_use]
    pub(crate) fn finished(&self, candidate: Candidate) -> Candidate {
        if !self.dear {
            return candidate;
        }
        let (model, start) = (candidate.model.clone_box(), candidate.fit.values.clone());
        let options = finishing(self.options(model.as_ref(), start, &candidate));
        Candidate::fitted(self.data, candidate.effects.clone(), model, &options).unwrap_or(candidate)
    }

    /// The candidate with its counts searched again nearby.
    fn tuned(&self, candidate: Candidate) -> Candidate {
        if self.dear {
            return candidate;
        }
        count::tuned(self.data, candidate, |near, known| {
            self.fitted_near(near, &near.effects, &known.to_vec())
        })
    }

    /// Whether nothing is left to explain, or a trace of what the base model leaves.
    #[must_use]
    pub fn is_settled(&self, candidate: &Candidate, base: &Candidate) -> bool {
        let floor = self.data.floor;
        let left = excess(candidate.fit.error(), floor);
        candidate.fit.error() <= AT_FLOOR * floor || left <= TRACE * excess(base.fit.error(), floor)
    }
}

/// How the leader is fitted on where derivatives are dear.
pub(crate) fn finishing(options: FitOptions) -> FitOptions {
    FitOptions {
        difference: Difference::Forward,
        tolerance: FINISHED_TOLERANCE,
        max_steps: STEPS as usize,
        ..options
    }
}

/// Derivatives in open loop are others than those under the observer, where a fit takes few steps: it can afford its own.
fn under_observer(options: FitOptions) -> FitOptions {
    FitOptions { columns: None, difference: Difference::Forward, ..options }
}

#[cfg(test)]
mod tests {
    use super::Models;
    use crate::Role;
    use crate::data::Data;
    use crate::toy::{Toy, campaign, run};

    #[test]
    fn steps_that_leave_an_error_under_the_observer_are_not_searched_with_unless_much_more_is_missing() {
        let noise = (0.1, 1e-4);
        for (coarser_by, missing, refines) in
            [(1.0, 0.0, false), (1.0 + 1e-5, 0.0, false), (1.2, 0.0, true), (1.2, 1.0, false)]
        {
            let mut record = run(&[1.0, 4.0, 400.0], 800, 5, noise, (1.0, 0.0), 1.0);
            let force = record.outputs.iter_mut().find(|s| s.channel == "force_1_n").expect("a force");
            force.values.iter_mut().for_each(|f| *f += missing * f.powi(3));
            let campaign = campaign(vec![(Role::Fit, record)], noise);
            let mut toy = Toy::new();
            toy.coarser_by = coarser_by;
            let data = Data::new(&campaign, Some(Role::Fit), &toy).expect("a fit run");
            let mut models = Models::new(&data, &toy);
            let first = models.base().expect("a fit");
            assert_eq!(models.refine_where_steps_show(&first), refines, "{coarser_by}");
            let mass = models.base().expect("a fit").fit.values[0];
            assert!(missing > 0.0 || (mass - 1.0).abs() < 0.01, "{coarser_by}: {mass}");
        }
    }
}
