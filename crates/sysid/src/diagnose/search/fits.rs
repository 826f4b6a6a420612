//! Fits of the sets that a search plans: first under the observer, then the best of them in open loop, and under the base
//! model's other discrete choices where none explains everything.

use super::{Observed, Search};
use crate::diagnose::Candidate;
use crate::diagnose::candidate::{Known, compare::is_seen};
use crate::diagnose::policy::{ALIKE_COST, FOLLOWERS, FOLLOWERS_DEAR, LEADERS, RIVAL_COST};
use crate::diagnose::refine::Models;
use crate::diagnose::refine::Seen;
use crate::diagnose::refine::horizon::Derivatives;
use crate::diagnose::screen::Plan;
use crate::fit::EQUAL_COST;
use rayon::prelude::*;
use sealegs_model::{Parameter, Scale};

/// A set that is to be fitted in open loop.
pub(crate) struct Planned {
    pub effects: Vec<String>,
    /// Where its fit starts.
    pub known: Known,
    /// What its fit under the observer came to; `None` where it cannot be simulated there, or nothing was measured to follow.
    pub seen: Option<Seen>,
}

impl Planned {
    /// What it leaves under the observer.
    pub(crate) fn cost(&self) -> f64 {
        self.seen.as_ref().map_or(f64::INFINITY, |seen| seen.cost)
    }
}

impl Search<'_> {
    /// Fits plans beside a set that were not fitted yet, first under the observer, then the best of them in open loop; the
    /// indices of all that were. `beside` is the set as it is under the observer: what leaves more there than without the
    /// effect started in the wrong place. Where a set that explains everything is there already, `to_beat` is its cost
    /// under the observer, and rivals alone are fitted.
    pub(crate) fn fit_all(
        &mut self,
        near: &Candidate,
        beside: Option<&Candidate>,
        plans: Vec<Plan>,
        to_beat: Option<f64>,
    ) -> Vec<usize> {
        let sets = plans.iter().map(|p| self.set_with(near, &p.added));
        let known: Vec<usize> =
            sets.filter_map(|set| self.tried.iter().position(|t| t.effects == set)).collect();
        let planned = self.planned(near, beside, plans);
        known.into_iter().chain(self.fit_best(near, beside, planned, to_beat)).collect()
    }

    /// The sets of some plans beside a set that were not fitted in open loop yet, with what they leave under the observer.
    pub(crate) fn planned(
        &mut self,
        near: &Candidate,
        beside: Option<&Candidate>,
        plans: Vec<Plan>,
    ) -> Vec<Planned> {
        let known = |start: Known| near.known().into_iter().chain(start).collect();
        let sets = plans.into_iter().map(|p| (self.set_with(near, &p.added), known(p.start)));
        let new = |(set, _): &(Vec<String>, Known)| self.tried.iter().all(|t| t.effects != *set);
        let sets: Vec<(Vec<String>, Known)> = sets.filter(new).collect();
        self.say_fitted(sets.iter().map(|(set, _)| set.clone()).collect());
        if let Some(beside) = beside {
            self.fit_observed(beside, &sets);
        }
        let seen = |set: &[String]| self.observed_from(&beside?.effects, set).map(|o| o.seen.clone());
        sets.into_iter().map(|(effects, known)| Planned { seen: seen(&effects), effects, known }).collect()
    }

    /// Fits the best of some sets in open loop, by what they leave under the observer (see [`Search::fit_all`]); the indices of
    /// those that were.
    pub(crate) fn fit_best(
        &mut self,
        near: &Candidate,
        beside: Option<&Candidate>,
        mut ranked: Vec<Planned>,
        to_beat: Option<f64>,
    ) -> std::ops::Range<usize> {
        let (models, first) = (&self.models, self.tried.len());
        // Without an observer they stay in the order of what they promise.
        ranked.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
        if let Some(beside) = beside {
            ranked.retain(|p| p.cost() < beside.fit.cost);
        }
        let first_cost = ranked.first().map_or(f64::INFINITY, Planned::cost);
        let least = first_cost.min(to_beat.unwrap_or(f64::INFINITY));
        if to_beat.is_some() {
            ranked.retain(|p| p.cost() <= RIVAL_COST * least);
        }
        let wave = |near: &Candidate, planned: &[Planned]| -> Vec<Candidate> {
            let fitted: Vec<Option<Candidate>> = planned
                .par_iter()
                .map(|p| models.fitted(near, &p.effects, &p.known, p.seen.as_ref().map(|s| &s.known)))
                .collect();
            fitted.into_iter().flatten().collect()
        };
        let leaders = if models.dear { 1 } else { LEADERS as usize }.min(ranked.len());
        let mut fitted = wave(near, &ranked[..leaders]);
        finish_best(models, &mut fitted);
        if let (true, [lead], [Planned { seen: Some(seen), .. }, ..]) =
            (models.dear, &mut fitted[..], &ranked[..])
            && !models.is_settled(lead, &self.tried[0])
        {
            let longer = models.through_beginnings(lead, lead.model.as_ref(), seen, Derivatives::Corrected);
            *lead = longer.filter(|longer| longer.fit.cost < lead.fit.cost).unwrap_or_else(|| lead.clone());
        }
        let chose = self.choose_again(&mut fitted);
        // Rivals have the same right to another choice.
        let each = |all: &mut Vec<Candidate>| {
            all.par_iter_mut().for_each(|c| *c = models.settled(c.clone()).0);
        };
        if chose {
            each(&mut fitted);
        }
        // Where derivatives are taken over, those of a set that explains more serve the others better.
        let lead = fitted.first().filter(|lead| models.dear && lead.fit.cost < near.fit.cost);
        let near = lead.cloned().unwrap_or_else(|| near.clone());
        let settled = to_beat.is_some() || fitted.iter().any(|c| models.is_settled(c, &self.tried[0]));
        let mut rest: Vec<_> = ranked.drain(leaders..).collect();
        if settled {
            rest.retain(|p| p.cost() <= RIVAL_COST * least);
        } else {
            let most = if self.models.dear { FOLLOWERS_DEAR } else { FOLLOWERS } as usize;
            let alike = rest.iter().filter(|p| p.cost() <= ALIKE_COST * least).count();
            rest.truncate(most.max(alike));
        }
        let mut rest = wave(&near, &rest);
        if chose && settled {
            each(&mut rest);
        }
        if !settled {
            finish_best(models, &mut rest);
        }
        fitted.extend(rest);
        self.no_worse_than_parts(&mut fitted);
        self.tried.extend(fitted);
        first..self.tried.len()
    }

    /// Fits sets under the observer that were not yet, beside one that was fitted there, and keeps what came of it.
    fn fit_observed(&mut self, beside: &Candidate, sets: &[(Vec<String>, Known)]) {
        let new = |(set, _): &&(Vec<String>, Known)| self.observed_from(&beside.effects, set).is_none();
        let sets: Vec<(Vec<String>, Known)> = sets.iter().filter(new).cloned().collect();
        let fits = self.models.observed_fits(beside, &sets);
        self.observed.extend(sets.into_iter().zip(&fits).filter_map(|((effects, _), fit)| {
            let (fit, from) = (fit.as_ref()?, beside.effects.clone());
            Some(Observed { effects, from, seen: Seen::of(fit), gains: is_seen(&beside.fit, fit) })
        }));
    }

    /// Fits sets again that leave more than a part of them does, from that part's values with what they have beyond it weak:
    /// they rest in a minimum of their own. Not where a simulation is dear.
    pub(crate) fn no_worse_than_parts(&self, sets: &mut [Candidate]) {
        if self.models.dear {
            return;
        }
        sets.par_iter_mut().for_each(|set| {
            let is_part = |t: &&Candidate| {
                let members = t.effects.iter().all(|e| set.effects.contains(e));
                members && t.effects.len() < set.effects.len() && !t.exact
            };
            let parts = self.tried.iter().filter(is_part);
            let part = parts.reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a });
            let part = part.filter(|part| part.fit.cost < set.fit.cost - EQUAL_COST);
            let again = part.and_then(|part| self.models.fitted_from_part(part, set));
            if let Some(again) = again.filter(|again| again.fit.cost < set.fit.cost) {
                *set = again;
            }
        });
    }

    /// Fits the lowest of some sets under the base model's other discrete choices where none explains everything: a choice
    /// that was made while something was missing leaves what no further effect takes. Returns whether another one is better.
    fn choose_again(&self, fitted: &mut [Candidate]) -> bool {
        if fitted.iter().any(|c| self.models.is_settled(c, &self.tried[0])) {
            return false;
        }
        let best = fitted.iter_mut().reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a });
        best.is_some_and(|best| {
            let before = best.fit.cost;
            *best = self.models.settled(best.clone()).0;
            best.fit.cost < before - EQUAL_COST
        })
    }

    /// Fits a set again, as [`Models::grown`] from the one that it grew from, where it leaves something: what rests at the
    /// wrong values misleads all that is added to it. Or where two magnitudes of an effect were added.
    pub(crate) fn fit_from_every_start(&mut self, index: usize, from: usize) {
        let (set, near) = (&self.tried[index], &self.tried[from]);
        let own = near.model.parameters().len();
        let further = set.model.parameters().get(own..).unwrap_or_default();
        let settled = !has_two_magnitudes(further) && self.models.is_settled(set, &self.tried[0]);
        if self.models.dear || self.is_long() || settled {
            return;
        }
        let added: Vec<String> = set.effects.iter().filter(|e| !near.effects.contains(e)).cloned().collect();
        let again = self.models.grown(near, &added).filter(|again| again.fit.cost < set.fit.cost);
        let effects = set.effects.clone();
        if let Some(again) = again {
            // The members stand in the catalogue's order.
            self.tried[index] = self.models.reordered(again, &effects);
        }
    }
}

/// Whether there are two magnitudes at least: they make up for one another, so that a fit rests anywhere along that, and an effect
/// that is screened in the wrong place promises nothing.
pub(crate) fn has_two_magnitudes(parameters: &[Parameter]) -> bool {
    parameters.iter().filter(|p| !p.fixed && p.scale == Scale::Logarithmic).count() >= 2
}

/// Whether there is a limit, which is nothing where it is infinite: beside base values that the clipped runs have driven away it is
/// reached nowhere, or everywhere, and an effect that is screened there promises nothing.
pub(crate) fn has_limit(parameters: &[Parameter]) -> bool {
    parameters.iter().any(|p| !p.fixed && p.neutral == Some(f64::INFINITY))
}

/// Fits the lowest of some candidates on (see [`Models::finished`]).
fn finish_best(models: &Models, candidates: &mut [Candidate]) {
    if let Some(best) = candidates.iter_mut().reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a }) {
        *best = models.finished(best.clone());
    }
}
