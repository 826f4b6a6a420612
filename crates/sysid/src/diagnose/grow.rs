//! Sets grown one effect at a time, each from its most promising starting values: in open loop, or under the observer alone.

use super::along::simpler_along;
use super::policy::STARTS;
use super::refine::Models;
use super::rugged;
use super::screen::{Known, addable, screen};
use super::search::{Observed, Search};
use super::starts::with_nominal_base;
use super::{Candidate, Progress, values_by_name, with_effects};
use crate::fit::{self, Difference, Fit};

/// Members of a set that is grown under the observer alone: what leaves something with as many is searched in open loop.
const TOGETHER: usize = 3;

impl Models<'_> {
    /// A set with one more effect, from its most promising starting values, from its guess, and beside the law that it
    /// becomes where it repeats along the screw; the lowest of the fits.
    #[must_use]
    pub fn with_one_more(&self, near: &Candidate, effect: &str) -> Option<Candidate> {
        let cards: Vec<_> = near.model.effects(&self.seen).into_iter().filter(|c| c.id == effect).collect();
        let mut effects = near.effects.clone();
        effects.push(effect.to_owned());
        let known = near.known();
        let beside = self.observing(near, &with_nominal_base(self.exact, &known));
        let in_its_place = cards.first().and_then(|card| {
            let simple = simpler_along(card).filter(|simple| !near.effects.contains(simple))?;
            let beside = self.with_one_more(near, &simple)?;
            self.repeating(&beside, card)
        });
        // Every period was looked at there.
        let looks = [beside.as_ref(), Some(near)].into_iter().flatten().filter(|_| in_its_place.is_none());
        let starts =
            looks.flat_map(|beside| screen(self.data, beside, &self.seen, &cards, STARTS as usize).promises);
        let starts: Vec<Known> = starts.map(|p| p.start).chain([Vec::new()]).collect();
        let fitted = starts.into_iter().filter_map(|start| {
            let known: Known = known.iter().cloned().chain(start).collect();
            let observed = beside.as_ref().and_then(|beside| {
                self.observed_fits(beside, &[(effects.clone(), known.clone())]).pop().flatten()
            });
            self.fitted(near, &effects, &known, observed.as_ref())
        });
        fitted.chain(in_its_place).reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a })
    }

    /// A candidate with more effects, grown one by one in either order, as what an effect shows may depend on another one
    /// being there already; the lowest fit. `None` if nothing can be simulated.
    #[must_use]
    pub(super) fn grown(&self, near: &Candidate, added: &[String]) -> Option<Candidate> {
        let backwards: Vec<String> = added.iter().rev().cloned().collect();
        let orders = if added.len() > 1 { vec![added.to_vec(), backwards] } else { vec![added.to_vec()] };
        let grown = orders.into_iter().filter_map(|order| {
            order.iter().try_fold(near.clone(), |grown, effect| self.with_one_more(&grown, effect))
        });
        grown.reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a })
    }

    /// The candidate with its effects in another order; as it is if that cannot be simulated.
    #[must_use]
    pub(super) fn reordered(&self, candidate: Candidate, effects: &[String]) -> Candidate {
        let again = || {
            let model = with_effects(self.coarse.as_ref(), effects, &self.seen).ok()?;
            let values = values_by_name(model.as_ref(), &candidate.known());
            let fit = fit::at_values(self.data, model.as_ref(), &values, Difference::Forward).ok()?;
            Some(Candidate { effects: effects.to_vec(), model, fit, ..candidate.clone() })
        };
        again().unwrap_or(candidate)
    }

    /// The base model with effects, grown one by one and fitted to the end. `None` if nothing can be simulated.
    #[must_use]
    pub fn with_effects(&self, base: &Candidate, effects: &[String]) -> Option<Candidate> {
        let best = self.grown(base, effects)?;
        let (settled, _) = self.settled(best);
        let last = self.last_memory(&settled);
        let models = Models { last, ..self.clone() };
        let last = models.in_open_loop(models.polished(&self.reordered(settled, effects)));
        let (fit, _) = rugged::widened(self.data, &last);
        Some(Candidate { fit, ..last })
    }
}

impl Search<'_> {
    /// The set that explains the fit runs, if one does that grows from the base model by what leaves least under the observer:
    /// where a motion amplifies small errors, as a pendulum under dry friction does, open loop does not tell which effect is
    /// a part of the truth before the others are there. Its rivals are fitted, too. `None` where a simulation is dear.
    pub(super) fn grown_under_observer(&mut self) -> Option<usize> {
        let mut beside = self.observing(&self.tried[0]).filter(|_| !self.models.dear)?;
        while beside.effects.len() < TOGETHER && !self.is_long() {
            let mut rivals = self.screened_under_observer(&beside);
            let one_more =
                |o: &&Observed| o.from == beside.effects && o.effects.len() == beside.effects.len() + 1;
            let least = self.observed.iter().filter(one_more);
            let least = least.reduce(|a, b| if b.cost < a.cost { b } else { a }).filter(|o| o.gains)?;
            let effects = least.effects.clone();
            let with = self.observing(&Candidate { effects: effects.clone(), ..beside.clone() })?;
            let before = self.tried.iter().position(|t| t.effects == effects);
            let fit = |base| self.models.fitted(base, &effects, &with.known(), Some(&with.fit));
            let index = match before {
                Some(index) => index,
                None => {
                    let fitted = self.models.finished(fit(&self.tried[0])?);
                    self.kept(fitted)
                }
            };
            if self.models.is_settled(&self.tried[index], &self.tried[0]) {
                let near = self.tried[index].clone();
                rivals.retain(|(set, ..)| *set != effects);
                self.fit_best(&near, Some(&beside), rivals, Some(with.fit.cost));
                return Some(index);
            }
            beside = with;
        }
        None
    }

    /// Fits what screening promises beside a set under the observer, unless that was done; without what was fitted in open
    /// loop already.
    fn screened_under_observer(&mut self, beside: &Candidate) -> Vec<(Vec<String>, Known, Option<Fit>)> {
        if self.observed.iter().any(|o| o.from == beside.effects) {
            return Vec::new();
        }
        (self.progress)(Progress::Screening { beside: beside.effects.clone() });
        let cards = addable(beside.model.as_ref(), &self.models.seen, &self.admitted);
        let known = |start: Known| beside.known().into_iter().chain(start).collect();
        let plans = self.at(beside, &cards).plans(f64::INFINITY, true);
        let sets: Vec<(Vec<String>, Known)> =
            plans.into_iter().map(|p| (self.set_with(beside, &p.added), known(p.start))).collect();
        self.say_fitted(sets.iter().map(|(set, _)| set.clone()).collect());
        let fits = self.fit_observed(beside, &sets);
        let new = |set: &[String]| self.tried.iter().all(|t| t.effects != set);
        let fitted = sets.into_iter().zip(fits).filter(|((set, _), _)| new(set));
        fitted.map(|((set, known), fit)| (set, known, fit)).collect()
    }
}
