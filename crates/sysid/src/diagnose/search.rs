//! The search for the smallest set of effects that explains the fit runs: sets grow by screening, the promising ones are
//! fitted, members leave again, and rivals of each member are tried.

use super::compare::{clearly_better, gain};
use super::policy::{AT_FLOOR, MOST_EFFECTS, NEAR_FLOOR, STARTS, STARTS_DEAR, TIED_COST};
use super::refine::{Models, with_nominal_base};
use super::screen::{Known, Plan, Promise, Screened, addable, screen};
use super::{Candidate, Progress};
use rayon::prelude::*;

/// Times that members are exchanged and taken out in turn.
const ROUNDS: usize = 2;

/// Rivals of a member that are fitted.
const RIVALS: usize = 3;

/// Share of what a member explains that a rival must promise in its place.
const RIVAL_SHARE: f64 = 0.3;

/// Effects of the screening in open loop that are fitted, too: a sensor that the observer follows hides its own fault.
const OPEN_LOOP: usize = 3;

/// The search's state.
pub(super) struct Search<'a> {
    pub models: &'a Models<'a>,
    /// Effects to choose from, in the catalogue's order.
    pub admitted: Vec<String>,
    /// Everything that was fitted, the base model first.
    pub tried: Vec<Candidate>,
    /// What screening promised of each effect beside the base model.
    pub promises: Vec<Promise>,
    pub progress: &'a (dyn Fn(Progress) + Sync),
}

impl Search<'_> {
    /// Grows, exchanges and prunes from the base model (`tried[0]`); the index of the best set.
    pub fn run(&mut self) -> usize {
        let mut best = 0;
        while self.tried[best].effects.len() < MOST_EFFECTS as usize && !self.at_floor(best) {
            let fitted = self.grown(best);
            let better = self.best_of(&fitted, best);
            if better == best {
                break;
            }
            best = better;
        }
        for _ in 0..ROUNDS {
            let before = best;
            best = self.exchanged(best);
            best = self.pruned(best);
            if best == before {
                break;
            }
        }
        best
    }

    /// Fits what screening promises beside a set; the indices.
    fn grown(&mut self, from: usize) -> Vec<usize> {
        let screened = self.screened(from);
        if from == 0 {
            self.promises.clone_from(&screened.promises);
        }
        let noise = 0.5 * self.models.data.floor.powi(2) * self.tried[from].validation.residuals as f64;
        let left = (self.tried[from].fit.cost - noise).max(0.0);
        let plans = screened.plans(left);
        self.fit_all(from, plans)
    }

    /// What screening finds beside a set, under the observer and, where simulations are cheap, in open loop as well.
    fn screened(&self, from: usize) -> Screened {
        let (models, candidate) = (self.models, &self.tried[from]);
        (self.progress)(Progress::Screening { beside: candidate.effects.clone() });
        let starts = if models.dear { STARTS_DEAR } else { STARTS } as usize;
        let known = with_nominal_base(models.exact, &candidate.known());
        let beside = models.observing(candidate, &known);
        let cards = addable(candidate.model.as_ref(), &models.seen, &self.admitted);
        let at = |beside: &Candidate| screen(models.data, beside, &models.seen, &cards, starts);
        let Some(mut screened) = beside.as_ref().map(at) else { return at(candidate) };
        if !models.dear {
            let open = at(candidate).promises.into_iter().take(OPEN_LOOP);
            for promise in open {
                let effects = |p: &Plan| p.added == [promise.effect.clone()];
                if !screened.plans(0.0).iter().any(effects) {
                    screened.pairs.push(Plan {
                        added: vec![promise.effect],
                        drop: f64::MAX,
                        start: promise.start,
                    });
                }
            }
        }
        screened
    }

    /// Fits plans beside a set that were not fitted yet; the indices of all of them.
    fn fit_all(&mut self, from: usize, plans: Vec<Plan>) -> Vec<usize> {
        let near = &self.tried[from];
        let with = |plan: &Plan| -> Vec<String> {
            let chosen = |id: &String| near.effects.contains(id) || plan.added.contains(id);
            self.admitted.iter().filter(|id| chosen(id)).cloned().collect()
        };
        let sets: Vec<(Vec<String>, Known)> = plans
            .iter()
            .map(|plan| (with(plan), near.known().into_iter().chain(plan.start.clone()).collect()))
            .collect();
        let new: Vec<_> = sets.iter().filter(|(set, _)| self.tried.iter().all(|t| t.effects != *set)).collect();
        if !new.is_empty() {
            (self.progress)(Progress::Fitting { sets: new.iter().map(|(set, _)| set.clone()).collect() });
        }
        let fitted: Vec<Option<Candidate>> =
            new.par_iter().map(|(set, known)| self.models.fitted(near, set, known)).collect();
        self.tried.extend(fitted.into_iter().flatten());
        let index = |set: &Vec<String>| self.tried.iter().position(|t| t.effects == *set);
        sets.iter().filter_map(|(set, _)| index(set)).collect()
    }

    /// Whether nothing is left to explain.
    pub fn at_floor(&self, index: usize) -> bool {
        let floor = self.models.data.floor;
        self.tried[index].fit.error() <= AT_FLOOR * floor
            && self.mean_square(index).sqrt() <= NEAR_FLOOR * floor
    }

    fn mean_square(&self, index: usize) -> f64 {
        self.tried[index].validation.mean_square()
    }

    /// The best of some sets if it is clearly better than another one, else that.
    fn best_of(&self, indices: &[usize], than: usize) -> usize {
        let floor = self.models.data.floor;
        let better = indices.iter().copied().filter(|&i| clearly_better(&self.tried[than], &self.tried[i], floor));
        better.reduce(|a, b| if self.mean_square(b) < self.mean_square(a) { b } else { a }).unwrap_or(than)
    }

    /// Index of a set, fitted now if it was not, from another candidate's values.
    fn index_of(&mut self, effects: &[String], near: usize) -> Option<usize> {
        if let Some(i) = self.tried.iter().position(|t| t.effects == effects) {
            return Some(i);
        }
        let near = &self.tried[near];
        let fitted = self.models.fitted(near, effects, &near.known())?;
        self.tried.push(fitted);
        Some(self.tried.len() - 1)
    }

    /// Lets members leave, the least useful first, as long as the rest is not clearly worse.
    fn pruned(&mut self, mut best: usize) -> usize {
        loop {
            let effects = self.tried[best].effects.clone();
            let without: Vec<usize> =
                effects.iter().filter_map(|leaving| self.index_of(&all_but(&effects, leaving), best)).collect();
            let floor = self.models.data.floor;
            let as_good = without.into_iter().filter(|&i| !clearly_better(&self.tried[i], &self.tried[best], floor));
            match as_good.reduce(|a, b| if self.mean_square(b) < self.mean_square(a) { b } else { a }) {
                Some(i) => best = i,
                None => return best,
            }
        }
    }

    /// Tries rivals in the place of each member of a set of several.
    fn exchanged(&mut self, best: usize) -> usize {
        let effects = self.tried[best].effects.clone();
        if effects.len() < 2 {
            return best;
        }
        let mut fitted = Vec::new();
        for leaving in &effects {
            let Some(without) = self.index_of(&all_but(&effects, leaving), best) else { continue };
            let worth = self.tried[without].fit.cost - self.tried[best].fit.cost;
            let promises = self.screened(without).promises.into_iter();
            let plans = promises
                .filter(|p| p.effect != *leaving && p.drop > RIVAL_SHARE * worth)
                .map(|p| Plan { added: vec![p.effect], drop: p.drop, start: p.start })
                .take(RIVALS);
            let plans = plans.collect();
            fitted.extend(self.fit_all(without, plans));
        }
        let mean = |i: usize| self.mean_square(i);
        let rival = fitted.into_iter().filter(|&i| self.tried[i].effects.len() <= effects.len());
        rival.fold(best, |a, b| if mean(b) < mean(a) { b } else { a })
    }

    /// Of all sets of no more effects that are not clearly worse, the simplest is chosen and the others are its ties. A set
    /// that holds the chosen one and something beside it is no tie.
    pub fn ties(&self, best: usize) -> (usize, Vec<usize>) {
        let size = self.tried[best].effects.len();
        let floor = self.models.data.floor;
        let mut equal: Vec<usize> = (0..self.tried.len())
            .filter(|&i| i == best || self.tried[i].effects.len() <= size)
            .filter(|&i| i == best || !clearly_better(&self.tried[i], &self.tried[best], floor))
            .collect();
        let order = |i: usize| (self.tried[i].effects.len(), self.tried[i].effect_parameters());
        equal.sort_by(|&a, &b| {
            order(a).cmp(&order(b)).then(gain(&self.tried[a], &self.tried[b]).total_cmp(&0.0))
        });
        let chosen = equal.first().copied().unwrap_or(best);
        let own = &self.tried[chosen].effects;
        let tied = equal
            .into_iter()
            .skip(1)
            .filter(|&i| own.is_empty() || self.tried[i].effects.len() <= own.len())
            .filter(|&i| self.tried[i].fit.cost <= TIED_COST * self.tried[chosen].fit.cost)
            .collect();
        (chosen, tied)
    }
}

/// A set without one of its members.
pub(super) fn all_but(effects: &[String], leaving: &str) -> Vec<String> {
    effects.iter().filter(|e| *e != leaving).cloned().collect()
}
