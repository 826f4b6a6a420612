//! Members leave a set that needs them no more, and rivals take their places.

use super::Search;
use crate::diagnose::Candidate;
use crate::diagnose::candidate::{all_but, compare::clearly_better};
use crate::diagnose::policy::{
    ALIKE_COST, FROM_EVERY_START, MOST_OF_IT, NEAR_FLOOR, NEEDED_COST, RIVAL_COST, RIVALS,
};
use crate::diagnose::screen::{Plan, Promise, addable};
use rayon::prelude::*;

impl Search<'_> {
    /// Index of a set without one of its members. A fit of it from elsewhere may have ended where nothing leads on: it says
    /// that the member is needed only if one from the whole set's values does, under any of the base model's choices.
    pub(crate) fn rest_of(&mut self, rest: &[String], whole: usize) -> Option<usize> {
        let index = self.index_of(rest, whole)?;
        let (whole, floor) = (&self.tried[whole], self.models.data.floor);
        if rest.is_empty() || !clearly_better(&self.tried[index], whole, floor) {
            return Some(index);
        }
        let known = self.merged_with_base(whole, rest).unwrap_or_else(|| whole.known());
        let again = self.models.fitted(whole, rest, &known, None);
        let again = again.map(|again| if self.models.dear { again } else { self.models.settled(again).0 });
        Some(again.map_or(index, |again| self.kept(again)))
    }

    /// Lets members leave, the least useful first, as long as the rest is not clearly worse.
    pub fn pruned(&mut self, mut best: usize) -> usize {
        loop {
            let effects = self.tried[best].effects.clone();
            let own = self.observed_where_settled(best, &effects).map(|own| own.fit.cost);
            let without: Vec<usize> = effects
                .iter()
                .filter_map(|leaving| {
                    let rest = all_but(&effects, leaving);
                    let needed = own.is_some_and(|own| {
                        let left = self.observed_where_settled(best, &rest);
                        left.is_some_and(|left| left.fit.cost > NEEDED_COST * own)
                    });
                    if needed { None } else { self.rest_of(&rest, best) }
                })
                .collect();
            let floor = self.models.data.floor;
            let as_good =
                without.into_iter().filter(|&i| !clearly_better(&self.tried[i], &self.tried[best], floor));
            match as_good.reduce(|a, b| if self.mean_square(b) < self.mean_square(a) { b } else { a }) {
                Some(i) => best = i,
                None => return best,
            }
        }
    }

    /// Tries rivals in the place of each member of a set of several: effects at the member's port, and those that alone leave as little
    /// as it does, as they promised to be beside the base model; where the set explains everything, those that leave no more under the
    /// observer. Where it leaves something, a rival may rest in a minimum of its own: those that left least beside the other
    /// members are fitted from every start.
    pub(crate) fn exchanged(&mut self, best: usize) -> usize {
        let effects = self.tried[best].effects.clone();
        let mut fitted = Vec::new();
        if effects.len() > 1 {
            let own = self.observed_where_settled(best, &effects).map(|own| own.fit.cost);
            for leaving in &effects {
                fitted.extend(self.promised_rivals(best, &effects, leaving, own));
            }
        }
        fitted.extend(self.rivals_anew(best));
        let mean = |i: usize| self.mean_square(i);
        let rival = fitted.into_iter().filter(|&i| self.tried[i].effects.len() <= effects.len());
        rival.fold(best, |a, b| if mean(b) < mean(a) { b } else { a })
    }

    /// Fits rivals of a member of a set as they promised to be; `own` is the set's cost under the observer where it explains
    /// everything. The indices.
    fn promised_rivals(
        &mut self,
        best: usize,
        effects: &[String],
        leaving: &String,
        own: Option<f64>,
    ) -> Vec<usize> {
        let (rest, mut plans) = (all_but(effects, leaving), self.rivals_of(leaving, effects));
        let near = match own {
            Some(_) => Candidate { effects: rest.clone(), ..self.tried[best].clone() },
            None => match self.index_of(&rest, best) {
                Some(without) => self.tried[without].clone(),
                None => return Vec::new(),
            },
        };
        plans.retain(|p| own.is_none_or(|own| !self.is_beaten(&self.set_with(&near, &p.added), own)));
        if plans.is_empty() {
            return Vec::new();
        }
        let beside = match own {
            Some(_) => self.observed_where_settled(best, &rest),
            None => self.observing(&near),
        };
        self.fit_all(&near, beside.as_ref(), plans, own)
    }

    /// Rivals of a member of a set as they promised to be beside the base model: those at its port, and those that alone leave as little.
    fn rivals_of(&self, leaving: &String, effects: &[String]) -> Vec<Plan> {
        let cards = self.models.exact.effects(&self.models.seen);
        let port = |id: &str| cards.iter().find(|c| c.id == id).map(|c| c.acts_on.as_str());
        let promised = || self.promises.iter().filter(|p| !effects.contains(&p.effect) && p.drop > 0.0);
        let at_port = |p: &&Promise| port(&p.effect) == port(leaving);
        let alike = |p: &&Promise| !at_port(p) && self.leaves_as_little(&p.effect, leaving);
        let most = RIVALS as usize;
        let rivals = promised().filter(at_port).take(most).chain(promised().filter(alike).take(most));
        rivals.map(|p| Plan { added: vec![p.effect.clone()], drop: p.drop, start: p.start.clone() }).collect()
    }

    /// Fits rivals of the members of a set from every start, each once: effects of several parameters that left least beside the
    /// other members. Members that take a trace only are left out: they stand for what the others do not explain. The indices;
    /// none where these explain everything, a simulation is dear, or much was simulated.
    fn rivals_anew(&mut self, best: usize) -> Vec<usize> {
        let named = self.without_traces(best);
        if !self.may_rest(named) {
            return Vec::new();
        }
        let effects = self.tried[named].effects.clone();
        let cards = addable(self.tried[0].model.as_ref(), &self.models.seen, &self.admitted);
        let mut fitted = Vec::new();
        for leaving in &effects {
            if self.models.dear || self.is_long() {
                break;
            }
            let Some(near) = self.index_of(&all_but(&effects, leaving), named) else { continue };
            let near = self.tried[near].clone();
            let rivals = cards.iter().filter(|c| !effects.contains(&c.id) && c.parameters.len() > 1);
            let mut sets: Vec<(f64, Vec<String>, &String)> = rivals
                .filter_map(|card| {
                    let set = self.set_with(&near, std::slice::from_ref(&card.id));
                    Some((self.left_by(&set)?, set, &card.id))
                })
                .collect();
            sets.sort_by(|a, b| a.0.total_cmp(&b.0));
            sets.truncate(FROM_EVERY_START as usize);
            sets.retain(|(_, set, _)| !self.fitted_anew.contains(set));
            self.say_fitted(sets.iter().map(|(_, set, _)| set.clone()).collect());
            let models = &self.models;
            let fit = |(_, set, effect): &(f64, Vec<String>, &String)| {
                Some(models.reordered(models.with_one_more(&near, effect)?, set))
            };
            let anew: Vec<Candidate> = sets.par_iter().filter_map(fit).collect();
            self.fitted_anew.extend(sets.into_iter().map(|(_, set, _)| set));
            fitted.extend(anew.into_iter().map(|set| self.kept(set)).collect::<Vec<_>>());
        }
        fitted
    }

    /// Whether a set leaves something without the members that take a trace only: it may rest where another one does not.
    pub(crate) fn may_rest(&self, set: usize) -> bool {
        self.tried[self.without_traces(set)].fit.error() > NEAR_FLOOR * self.models.data.floor
    }

    /// A set without the members that take no more than a trace of what the base model leaves.
    fn without_traces(&self, set: usize) -> usize {
        let effects = &self.tried[set].effects;
        let rest = |leaving: &String| {
            let rest = all_but(effects, leaving);
            self.tried.iter().position(|t| t.effects == rest).filter(|&i| self.is_explained(i))
        };
        effects.iter().find_map(rest).map_or(set, |rest| self.without_traces(rest))
    }

    /// What a set left under the observer, or in open loop where it was not fitted there; `None` of one that was not fitted.
    fn left_by(&self, set: &[String]) -> Option<f64> {
        let seen = self.least_observed(|o| o.effects == set).map(|o| o.seen.cost);
        seen.or_else(|| self.tried.iter().find(|t| t.effects == set).map(|t| t.fit.cost))
    }

    /// Whether an effect alone leaves hardly more than another one, which takes most of what the base model leaves: under the observer,
    /// or in open loop.
    fn leaves_as_little(&self, effect: &String, other: &String) -> bool {
        let alone = |id: &String| std::slice::from_ref(id).to_vec();
        let alike = |left: &dyn Fn(&[String]) -> Option<f64>| -> Option<bool> {
            let (own, other, base) = (left(&alone(effect))?, left(&alone(other))?, left(&[])?);
            Some(other < (1.0 - MOST_OF_IT) * base && own <= ALIKE_COST * other)
        };
        let seen = |set: &[String]| match set {
            [] => self.observing(&self.tried[0]).map(|base| base.fit.cost),
            _ => self.least_observed(|o| o.effects == set).map(|o| o.seen.cost),
        };
        let open = |set: &[String]| self.tried.iter().find(|t| t.effects == set).map(|t| t.fit.cost);
        alike(&seen) == Some(true) || alike(&open) == Some(true)
    }

    /// Whether a set was fitted under the observer before, and left too much there to be a rival of one of this cost.
    fn is_beaten(&self, effects: &[String], own: f64) -> bool {
        let least = self.least_observed(|o| o.effects == effects);
        least.is_some_and(|least| least.seen.cost > RIVAL_COST * own)
    }

    /// Some members of a set that explains everything, fitted under the observer: what they leave there tells what is worth a
    /// fit in open loop. `None` if the set leaves something, where what else is missing hides that.
    fn observed_where_settled(&self, best: usize, effects: &[String]) -> Option<Candidate> {
        let set = &self.tried[best];
        if !self.models.is_settled(set, &self.tried[0]) {
            return None;
        }
        self.observing(&Candidate { effects: effects.to_vec(), ..set.clone() })
    }
}

#[cfg(test)]
mod tests {
    use super::Search;
    use crate::Role;
    use crate::data::Data;
    use crate::diagnose::refine::Models;
    use crate::diagnose::tests::{runs, toy};

    /// What `of` says of a search on the toy, whose force sensor shows something else than the force.
    fn search<T>(shows: impl Fn(f64, f64) -> f64, of: impl Fn(&mut Search) -> T) -> T {
        let (campaign, toy) = (runs(shows), toy());
        let data = Data::new(&campaign, Some(Role::Fit), &toy).expect("fit runs");
        let mut models = Models::new(&data, &toy);
        let base = models.base().expect("a fit");
        of(&mut Search::new(models, base, Vec::new(), &|_, _| ()))
    }

    /// Index of a set, fitted from the base model.
    fn fitted(search: &mut Search, effects: &[&str]) -> usize {
        let effects: Vec<String> = effects.iter().map(|&e| e.to_owned()).collect();
        search.index_of(&effects, 0).expect("a fit")
    }

    #[test]
    fn a_member_that_is_not_needed_leaves_and_one_that_is_stays() {
        for (even, left) in [(0.0, &["cubic-sensor"][..]), (0.02, &["cubic-sensor", "even-sensor"])] {
            let effects = search(
                |_, f| f + 1e-3 * f.powi(3) + even * f * f,
                |search| {
                    let both = fitted(search, &["cubic-sensor", "even-sensor"]);
                    let best = search.pruned(both);
                    search.tried[best].effects.clone()
                },
            );
            assert_eq!(effects, left, "{even}");
        }
    }

    #[test]
    fn a_rival_takes_the_place_of_a_member_that_is_not_there() {
        let effects = search(
            |_, f| f + 1e-3 * f.powi(3) + 0.02 * f * f,
            |search| {
                let base = search.tried[0].clone();
                search.screened_beside(&base);
                let wrong = fitted(search, &["square-sensor", "even-sensor"]);
                let best = search.exchanged(wrong);
                search.tried[best].effects.clone()
            },
        );
        assert_eq!(effects, ["cubic-sensor", "even-sensor"]);
    }

    #[test]
    fn a_rival_of_several_parameters_is_fitted_from_every_start_where_a_set_leaves_something() {
        let law = |f: f64| f + 0.05 * f.signum() * f.abs().powf(2.5);
        let asked = |shows: &dyn Fn(f64) -> f64| {
            search(
                |_, f| shows(f),
                |search| {
                    let alone = fitted(search, &["power-sensor"]);
                    let cubic = fitted(search, &["cubic-sensor"]);
                    // As after a fit that rests in a minimum of its own.
                    search.tried[alone].fit.cost = search.tried[0].fit.cost;
                    let anew = search.rivals_anew(cubic);
                    let fits: Vec<(usize, f64)> =
                        anew.iter().map(|&i| (i, search.tried[i].fit.error())).collect();
                    (alone, fits)
                },
            )
        };
        let (alone, fits) = asked(&law);
        assert!(matches!(fits[..], [(i, error)] if i == alone && error < 1.05), "{fits:?}");
        // A set that leaves nothing has no rivals.
        assert!(asked(&|f| f + 1e-3 * f.powi(3)).1.is_empty());
    }
}
