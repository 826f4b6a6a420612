//! The search for the smallest set of effects that explains the fit runs: sets grow by screening, the best
//! few at every size are fitted, members leave again, and rivals of each member are tried.

use super::candidate::Effort;
use super::compare::{clearly_better, worth};
use super::known_base::{is_driven, with_nominal_base};
use super::left::{FAR_ABOVE, NEAR_FLOOR};
use super::screen::{Promise, Starts, addable, race_periodic, screen};
use super::{Candidate, OpenChoice, Options, Progress, Validation, profile};
use crate::data::Data;
use crate::fit::{Difference, EQUAL_COST};
use rayon::prelude::*;
use sealegs_model::{Excitation, Model};

/// What the search leaves: the chosen set and everything that was fitted on the way.
#[derive(Debug)]
pub struct Found {
    /// Everything that was fitted, the base model first.
    pub tried: Vec<Candidate>,
    /// Index of the chosen one in `tried`.
    pub chosen: usize,
    /// Indices of sets of no more effects that neither the fit runs nor the holdout runs tell from the chosen one.
    pub tied: Vec<usize>,
    /// Indices of sets that are the chosen one by another name: richer laws from whose simple form nothing departs.
    pub same: Vec<usize>,
    /// Choices of the base model that explain the fit runs as well, with other values.
    pub open: Vec<OpenChoice>,
    /// What screening promised of each effect beside the base model.
    pub promises: Vec<Promise>,
    /// How the base model predicts what was left out, as exactly as the search was: what the sets that were not
    /// fitted again compare with.
    pub base_as_searched: Validation,
}

/// The search's state.
pub(super) struct Search<'a> {
    pub data: &'a Data<'a>,
    /// The base model as the search integrates it.
    pub base: &'a dyn Model,
    /// The base model itself.
    pub exact: &'a dyn Model,
    /// Whether the search goes on with that.
    pub refined: bool,
    /// The base model, and on a bench the leading set, at the base's nominal values, where effects are screened, too, if the
    /// base is suspected to be bent: fitted without the effect its parameters take its place as far as they go (a damping
    /// that of a slow sensor), and one linear step from what the maker states is near enough.
    pub nominal: Option<Candidate>,
    /// Whether the base is suspected to be bent, and not only beside no effect.
    pub bent: bool,
    pub seen: &'a Excitation,
    /// Effects to choose from, in the catalogue's order.
    pub admitted: Vec<String>,
    pub options: &'a Options,
    pub tried: Vec<Candidate>,
    /// What screening found beside which of `tried`.
    pub screened: Vec<(usize, Vec<Promise>)>,
    /// Simulations of fits from many starts, which do not count against growing.
    pub scattered: u64,
    pub progress: &'a (dyn Fn(Progress) + Sync),
}

/// Effects that may help only together: so many are always tried.
pub(super) const PAIR: usize = 2;

/// Most steps of a fit that goes on.
pub(super) const FINAL_STEPS: usize = 20;

/// How much more of what is unexplained a fit may leave after a race and still be fitted to the end.
const REACH: f64 = 8.0;

/// A set to be fitted, and where from.
struct Plan {
    effects: Vec<String>,
    known: Vec<(String, f64)>,
    /// Predicted cost.
    cost: f64,
    /// What it grows from.
    from: Parent,
}

/// What a set grows from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Parent {
    /// A candidate as it was fitted, by its index in [`Search::tried`].
    Tried(usize),
    /// [`Search::nominal`].
    Nominal,
}

/// Sets that are fitted beside the shortlist from a bent base's nominal values: several effects can take there what the
/// base has taken, and which of them does it only a fit tells.
const FROM_NOMINAL: usize = 6;

/// A set without one of its members.
pub(super) fn all_but(effects: &[String], leaving: &str) -> Vec<String> {
    effects.iter().filter(|e| *e != leaving).cloned().collect()
}

impl Search<'_> {
    /// Grows, prunes and compares, from the fitted base model (`tried[0]`); the holdout runs decide between sets that the
    /// fit runs leave open, and whether a small gain is one.
    pub fn run(mut self, holdout: &Data) -> Found {
        let mut promises = Vec::new();
        let mut best = 0;
        if self.tried[0].fit.error() <= FAR_ABOVE * self.data.floor {
            self.refine_steps(0);
        }
        let mut frontier = vec![0];
        for size in 1..=self.options.most_effects {
            if self.at_floor(best)
                || (size > PAIR && self.data.work().0 - self.scattered > self.options.growing_simulations)
            {
                break;
            }
            let mut plans = self.plans_from_nominal(&frontier, size);
            for &from in &frontier {
                let found = self.screen_beside(from, size);
                for promise in &found {
                    plans.extend(self.plans(Parent::Tried(from), promise));
                }
                if size == 1 {
                    promises = found;
                }
            }
            let most = match size {
                1 => self.options.shortlist,
                // What little is left is worth no long search.
                _ if self.tried[best].fit.error() <= NEAR_FLOOR * self.data.floor => {
                    self.options.shortlist_later.div_ceil(2)
                }
                _ => self.options.shortlist_later,
            };
            let mut fitted = self.fit_best(plans, most);
            if fitted.is_empty() {
                break;
            }
            let best_here = self.best_of(&fitted);
            if clearly_better(&self.tried[best], &self.tried[best_here], self.data.floor) {
                best = best_here;
            } else if size > 1 {
                // Two effects may help only together: a second size is always tried, a third only if the
                // second brought something.
                break;
            }
            // A law that came to rest half way is found before others are put beside it.
            self.refine_steps(best);
            if self.tried[best].fit.error() > FAR_ABOVE * self.data.floor {
                let better = self.second_chances(best);
                if better != best {
                    fitted.push(better);
                    best = better;
                }
            }
            frontier = self.frontier(fitted, size);
        }
        for _ in 0..2 {
            let before = best;
            best = self.swap(best);
            best = self.prune(best);
            if best == before {
                break;
            }
        }
        best = self.second_chances(best);
        best = self.supported(holdout, best);
        best = self.confirmed(holdout, best);
        best = self.earned(holdout, best);
        let (chosen, tied) = self.ties(best);
        let (chosen, mut tied) = self.standing(holdout, chosen, tied);
        let same = self.by_another_name(chosen);
        tied.retain(|i| !same.contains(i));
        let (settled, others) = self.settled(self.tried[chosen].clone());
        let (profiled, room) = self.profiled(settled.clone());
        self.tried[chosen] = profiled;
        let base_as_searched = self.tried[0].validation.clone();
        for i in [0, chosen] {
            if !self.tried[i].exact {
                self.tried[i] = self.polished(&self.tried[i]);
            }
        }
        let places = self.reconcile(chosen);
        profile::widen(&mut self.tried[chosen], &room);
        let room = profile::room(&self.tried[chosen], &places);
        profile::widen(&mut self.tried[chosen], &room);
        let open = self.open_choices(&settled, &others, &self.tried[chosen]);
        Found { tried: self.tried, chosen, tied, same, open, promises, base_as_searched }
    }

    pub(super) fn screen_beside(&mut self, from: usize, size: usize) -> Vec<Promise> {
        if let Some((_, known)) = self.screened.iter().find(|(i, _)| *i == from) {
            return known.clone();
        }
        let beside = &self.tried[from];
        (self.progress)(Progress::Screening { beside: beside.effects.clone() });
        let mut promises = self.screened(beside, self.most_starts(size));
        if self.screened.iter().all(|(i, _)| self.tried[*i].effects.len() < self.tried[from].effects.len())
            && !self.at_floor(from)
        {
            let mut order: Vec<usize> = (0..promises.len()).collect();
            order.sort_by(|&a, &b| promises[b].drop.total_cmp(&promises[a].drop));
            for i in order.into_iter().take(self.options.periodic_raced) {
                let (promise, most) = (promises[i].clone(), self.options.periods_raced);
                promises[i] = race_periodic(self.data, beside, self.seen, promise, most);
            }
        }
        self.screened.push((from, promises.clone()));
        promises
    }

    /// What every effect promises beside a candidate, from so many starting values at most.
    fn screened(&self, beside: &Candidate, most: usize) -> Vec<Promise> {
        let cards = addable(beside.model.as_ref(), self.seen, &self.admitted);
        screen(self.data, beside, self.seen, &cards, Starts { most, first: self.options.starts_first })
    }

    /// What sets grow from.
    fn parent(&self, from: Parent) -> &Candidate {
        match (from, &self.nominal) {
            (Parent::Tried(i), _) => &self.tried[i],
            (Parent::Nominal, nominal) => nominal.as_ref().unwrap_or(&self.tried[0]),
        }
    }

    /// Effects as they are screened beside the nominal base model and, if it is bent, beside the leading set with it.
    fn plans_from_nominal(&mut self, frontier: &[usize], size: usize) -> Vec<Plan> {
        if size > 1 {
            let leader = frontier.first().filter(|_| self.bent);
            self.nominal = leader.and_then(|&i| self.at_nominal(&self.tried[i]));
        }
        let Some(beside) = &self.nominal else { return Vec::new() };
        let promises = self.screened(beside, self.most_starts(size));
        promises.iter().flat_map(|promise| self.plans(Parent::Nominal, promise)).collect()
    }

    /// Starting values of each effect that are simulated where sets of this size are looked for.
    fn most_starts(&self, size: usize) -> usize {
        if size == 1 { self.options.starts } else { self.options.starts_later }
    }

    /// A set with one more effect, from its most promising start and the most promising one that is
    /// elsewhere.
    fn plans(&self, from: Parent, promise: &Promise) -> Vec<Plan> {
        let beside = self.parent(from);
        // Near the floor little can be gained, and what promises less than it would have to bring is not worth a fit.
        let near_floor = beside.fit.error() <= NEAR_FLOOR * self.data.floor;
        let least = if near_floor { 0.5 * worth(beside, self.data.floor) } else { 0.0 };
        if promise.drop <= least {
            return Vec::new();
        }
        let promising = promise.starts.iter().filter(|(drop, _)| *drop > 0.5 * promise.drop);
        promising
            .take(self.options.starts_fitted)
            .map(|(drop, start)| {
                let mut known = beside.known();
                known.extend(start.iter().cloned());
                Plan {
                    effects: self.with(&beside.effects, &promise.effect),
                    known,
                    cost: beside.fit.cost - drop,
                    from,
                }
            })
            .collect()
    }

    pub(super) fn with(&self, effects: &[String], one_more: &str) -> Vec<String> {
        let chosen = |id: &String| effects.contains(id) || id == one_more;
        self.admitted.iter().filter(|id| chosen(id)).cloned().collect()
    }

    /// The sets that are fitted: those of lowest predicted cost that were not fitted yet, from each candidate that they
    /// grow from in turn, the best of these first. What fits much and foresees nothing must not take all the places.
    fn shortlist<'p>(&self, plans: impl Iterator<Item = &'p Plan> + Clone, most: usize) -> Vec<Vec<String>> {
        let mut parents: Vec<Parent> = Vec::new();
        for plan in plans.clone() {
            if !parents.contains(&plan.from) {
                parents.push(plan.from);
            }
        }
        let left = |from: Parent| match from {
            Parent::Tried(i) => self.mean_square(i),
            Parent::Nominal => 0.0,
        };
        parents.sort_by(|&a, &b| left(a).total_cmp(&left(b)));
        let mut queues: Vec<_> =
            parents.iter().map(|&p| plans.clone().filter(move |plan| plan.from == p)).collect();
        let mut sets: Vec<Vec<String>> = Vec::new();
        let mut left = true;
        while left && sets.len() < most {
            left = false;
            for queue in &mut queues {
                let new = queue.find(|plan| {
                    !sets.contains(&plan.effects) && self.tried.iter().all(|t| t.effects != plan.effects)
                });
                if let Some(plan) = new.filter(|_| sets.len() < most) {
                    sets.push(plan.effects.clone());
                    left = true;
                }
            }
        }
        sets
    }

    /// Fits the `most` sets of lowest predicted cost that were not fitted yet; returns their indices.
    fn fit_best(&mut self, mut plans: Vec<Plan>, most: usize) -> Vec<usize> {
        plans.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let mut sets = self.shortlist(plans.iter(), most);
        if self.bent {
            let from_nominal = plans.iter().filter(|p| p.from == Parent::Nominal);
            let new = self.shortlist(from_nominal, FROM_NOMINAL);
            sets.extend(new.into_iter().filter(|set| !sets.contains(set)).collect::<Vec<_>>());
        }
        if !sets.is_empty() {
            (self.progress)(Progress::Fitting { sets: sets.clone() });
        }
        let (data, base, seen, options) = (self.data, self.base, self.seen, self.options);
        let race = |from: Parent| {
            // The way from nominal values is longer than from a fit, and what rests nearer would win a race over few steps.
            let far = !options.secants && from == Parent::Nominal;
            let steps = if far { FINAL_STEPS } else { options.race_steps };
            Effort {
                difference: if options.secants { Difference::Secant } else { Difference::Forward },
                ..options.effort(self.parent(from), steps)
            }
        };
        let raced: Vec<Option<Candidate>> = sets
            .par_iter()
            .map(|set| {
                let of_set = || plans.iter().filter(|p| p.effects == *set);
                // Where a wrong model has driven the base parameters far, a search with the right effect may not find back.
                let lost =
                    of_set().next().filter(|p| !options.secants && is_driven(base, self.parent(p.from)));
                let lost = lost.map(|p| (p.from, with_nominal_base(base, p.known.clone())));
                let (nominal, fitted): (Vec<&Plan>, Vec<&Plan>) =
                    of_set().partition(|p| p.from == Parent::Nominal);
                let starts =
                    fitted.into_iter().take(options.starts_fitted).chain(nominal.into_iter().take(1));
                starts
                    .map(|p| (p.from, p.known.clone()))
                    .chain(lost)
                    .filter_map(|(from, known)| {
                        Candidate::fitted(data, base, set, seen, &known, &race(from)).ok()
                    })
                    .reduce(|best, other| if other.fit.cost < best.fit.cost { other } else { best })
            })
            .collect();
        let mut raced: Vec<Candidate> = raced.into_iter().flatten().collect();
        raced.sort_by(|a, b| a.fit.cost.total_cmp(&b.fit.cost));
        // Those that lead after a few steps are fitted to the end; of a model whose fits are dear, those within reach.
        let noise = |c: &Candidate| {
            let residuals: usize = c.fit.evaluation.blocks.iter().map(|b| b.residual.len()).sum();
            0.5 * self.data.floor * self.data.floor * residuals as f64
        };
        let reach =
            raced.first().map_or(0.0, |c| noise(c) + REACH * (c.fit.cost - noise(c)).max(0.02 * noise(c)));
        let leader = raced.first().map_or(f64::INFINITY, |c| c.fit.error());
        let within = |c: &Candidate| !options.secants || c.fit.cost <= reach;
        let finished: Vec<Candidate> = raced
            .into_par_iter()
            .enumerate()
            .map(|(place, c)| match place {
                _ if self.is_hopeless(&c, leader) => c,
                // A choice that the base model made far from the truth may be wrong beside an effect.
                0 => self.with_best_choice(
                    self.shaken(self.whole(self.descended(self.returned(self.finished(c))))),
                    0.0,
                ),
                1 if within(&c) => self.with_best_choice(self.whole(self.returned(self.finished(c))), 0.0),
                _ if place < self.options.finishers && within(&c) => self.finished(c),
                // What promised most may have had the longest way to go.
                _ if sets.first() == Some(&c.effects) && !options.secants => self.returned(self.finished(c)),
                _ => c,
            })
            .collect();
        let finished = self.scattered_leaders(finished);
        let first = self.tried.len();
        self.tried.extend(finished);
        (first..self.tried.len()).collect()
    }

    pub(super) fn mean_square(&self, index: usize) -> f64 {
        self.tried[index].validation.mean_square()
    }

    fn best_of(&self, indices: &[usize]) -> usize {
        indices
            .iter()
            .copied()
            .reduce(|a, b| if self.mean_square(b) < self.mean_square(a) { b } else { a })
            .unwrap_or(0)
    }

    /// The sets that the next size grows from.
    fn frontier(&self, mut fitted: Vec<usize>, size: usize) -> Vec<usize> {
        fitted.sort_by(|&a, &b| self.mean_square(a).total_cmp(&self.mean_square(b)));
        fitted.truncate(if size == 1 { self.options.beam_first } else { self.options.beam });
        // Where one set explains nearly everything, growing from sets that do not is a waste.
        let excess = |i: usize| (self.mean_square(i) - self.data.floor * self.data.floor).max(0.0);
        if let Some(&best) = fitted.first() {
            let near = (10.0 * excess(best)).max(0.02 * excess(0));
            fitted.retain(|&i| i == best || excess(i) <= near || excess(best) > 0.1 * excess(0));
        }
        fitted
    }

    /// Index of a set, fitted now if it was not, from another candidate's values.
    pub(super) fn index_of(&mut self, effects: &[String], near: usize) -> Option<usize> {
        if let Some(i) = self.tried.iter().position(|t| t.effects == effects) {
            return Some(i);
        }
        let near = &self.tried[near];
        let fitted = self.fitted_near(near, effects, &near.known())?;
        Some(self.keep(fitted))
    }

    /// A set fitted from known values and with the derivatives of a candidate nearby; `None` if it cannot be simulated.
    pub(super) fn fitted_near(
        &self,
        near: &Candidate,
        effects: &[String],
        known: &[(String, f64)],
    ) -> Option<Candidate> {
        let effort = self.options.effort(near, FINAL_STEPS);
        Candidate::fitted(self.data, self.base, effects, self.seen, known, &effort).ok()
    }

    /// Takes a candidate in, in the place of a worse fit of the same set; returns its index.
    pub(super) fn keep(&mut self, candidate: Candidate) -> usize {
        match self.tried.iter().position(|t| t.effects == candidate.effects) {
            Some(i) => {
                if candidate.fit.cost < self.tried[i].fit.cost {
                    self.tried[i] = candidate;
                }
                i
            }
            None => {
                self.tried.push(candidate);
                self.tried.len() - 1
            }
        }
    }

    /// Lets members leave, the least useful first, as long as the rest is not clearly worse.
    fn prune(&mut self, mut best: usize) -> usize {
        loop {
            let effects = self.tried[best].effects.clone();
            let mut without: Vec<usize> = Vec::new();
            for leaving in &effects {
                let rest = all_but(&effects, leaving);
                let Some(i) = self.index_of(&rest, best) else { continue };
                without.push(i);
                // It was fitted from elsewhere and may have come to rest far from here.
                if !rest.is_empty() && self.tried[i].fit.cost > self.tried[best].fit.cost + EQUAL_COST {
                    let near = &self.tried[best];
                    if let Some(again) = self.fitted_near(near, &rest, &near.known()) {
                        self.keep(again);
                    }
                }
            }
            let next = without
                .into_iter()
                .filter(|&i| !clearly_better(&self.tried[i], &self.tried[best], self.data.floor))
                .reduce(|a, b| if self.mean_square(b) < self.mean_square(a) { b } else { a });
            match next {
                Some(i) => best = i,
                None => return best,
            }
        }
    }

    /// Tries rivals in the place of each member.
    fn swap(&mut self, mut best: usize) -> usize {
        for _ in 0..2 {
            let effects = self.tried[best].effects.clone();
            let mut plans = Vec::new();
            for leaving in &effects {
                let rest = all_but(&effects, leaving);
                let Some(without) = self.index_of(&rest, best) else { continue };
                let worth = self.tried[without].fit.cost - self.tried[best].fit.cost;
                for promise in self.screen_beside(without, 2) {
                    if promise.effect != *leaving && promise.drop > 0.3 * worth {
                        plans.extend(self.plans(Parent::Tried(without), &promise));
                    }
                }
            }
            let mut fitted = self.fit_best(plans, self.options.shortlist_later);
            fitted.push(best);
            let better = self.best_of(&fitted);
            if better == best {
                break;
            }
            best = better;
        }
        best
    }
}
