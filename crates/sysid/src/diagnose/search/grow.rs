//! Sets grown one effect at a time, each from its most promising starting values: in open loop, or under the observer alone.

use super::along::simpler_along;
use super::fits::Planned;
use super::{Observed, Search};
use crate::diagnose::candidate::Known;
use crate::diagnose::candidate::compare::excess;
use crate::diagnose::policy::{LEFT_SHARE, MAY_EXPLAIN, NEAR_FLOOR, PROMISES_ON, SEEN_TOGETHER, STARTS};
use crate::diagnose::refine::Models;
use crate::diagnose::refine::Seen;
use crate::diagnose::refine::rugged;
use crate::diagnose::refine::starts::with_nominal_base;
use crate::diagnose::screen::screen;
use crate::diagnose::{Candidate, values_by_name, with_effects};
use crate::fit::{self, Difference};

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
            let observed = observed.map(|fit| fit.known());
            self.fitted(near, &effects, &known, observed.as_ref())
        });
        fitted.chain(in_its_place).reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a })
    }

    /// A candidate with more effects, grown one by one in either order, as what an effect shows may depend on another one
    /// being there already; the lowest fit. `None` if nothing can be simulated.
    #[must_use]
    pub(crate) fn grown(&self, near: &Candidate, added: &[String]) -> Option<Candidate> {
        let backwards: Vec<String> = added.iter().rev().cloned().collect();
        let orders = if added.len() > 1 { vec![added.to_vec(), backwards] } else { vec![added.to_vec()] };
        let grown = orders.into_iter().filter_map(|order| {
            order.iter().try_fold(near.clone(), |grown, effect| self.with_one_more(&grown, effect))
        });
        grown.reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a })
    }

    /// The candidate with its effects in another order; as it is if that cannot be simulated.
    #[must_use]
    pub(crate) fn reordered(&self, candidate: Candidate, effects: &[String]) -> Candidate {
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
    /// a part of the truth before the others are there. Its rivals are fitted, too. `None` where a simulation is dear, and
    /// where the observer hides what is missing.
    pub(crate) fn grown_under_observer(&mut self) -> Option<usize> {
        if self.models.dear || self.at_floor(0) {
            return None;
        }
        let floor = self.models.data.floor;
        let mut beside = self.observing(&self.tried[0])?;
        let most = LEFT_SHARE * excess(beside.fit.error(), floor);
        let may_explain = |error: f64| error <= MAY_EXPLAIN * floor || excess(error, floor) <= most;
        while beside.fit.error() > NEAR_FLOOR * floor && !self.is_long() {
            // What these steps leave beside it would be taken for another effect.
            if !beside.effects.is_empty() && self.models.refine_where_steps_show(&beside) {
                (self.observed, self.screened) = (Vec::new(), Vec::new());
                beside = self.observing(&beside)?;
            }
            let plans = self.screened_beside(&beside).plans(f64::INFINITY, true);
            let left = beside.cost_above(floor);
            let promised = plans.iter().map(|plan| plan.drop).fold(0.0, f64::max);
            if !beside.effects.is_empty() && promised < PROMISES_ON * left {
                break;
            }
            let planned = self.planned(&beside, Some(&beside), plans);
            let one_more =
                |o: &Observed| o.from == beside.effects && o.effects.len() == beside.effects.len() + 1;
            let effects = self.least_observed(one_more).filter(|o| o.gains)?.effects.clone();
            let with = self.observing(&Candidate { effects: effects.clone(), ..beside.clone() })?;
            if may_explain(with.fit.error()) {
                let lead = Planned { effects, known: with.known(), seen: Some(Seen::of(&with.fit)) };
                if let Some(index) = self.explained_by(&beside, lead, planned) {
                    return Some(index);
                }
            }
            if with.effects.len() >= SEEN_TOGETHER as usize {
                break;
            }
            beside = with;
        }
        None
    }

    /// Fits a set in open loop that grew beside another one; its index if it explains everything, with its rivals fitted.
    fn explained_by(
        &mut self,
        beside: &Candidate,
        lead: Planned,
        mut planned: Vec<Planned>,
    ) -> Option<usize> {
        let (effects, cost) = (lead.effects.clone(), lead.cost());
        let base = self.tried[0].clone();
        self.fit_best(&base, Some(beside), vec![lead], None);
        let index = self.tried.iter().position(|t| t.effects == effects)?;
        if !self.models.is_settled(&self.tried[index], &base) {
            return None;
        }
        planned.retain(|p| p.effects != effects);
        let near = self.tried[index].clone();
        self.fit_best(&near, Some(beside), planned, Some(cost));
        Some(index)
    }
}
