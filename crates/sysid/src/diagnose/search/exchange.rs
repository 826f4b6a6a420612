//! Members leave a set that needs them no more, and rivals take their places.

use super::Search;
use crate::diagnose::Candidate;
use crate::diagnose::candidate::all_but;
use crate::diagnose::candidate::compare::clearly_better;
use crate::diagnose::policy::{ALIKE_COST, MOST_OF_IT, NEEDED_COST, RIVAL_COST, RIVALS};
use crate::diagnose::screen::{Plan, Promise};

impl Search<'_> {
    /// Index of a set without one of its members. A fit of it from elsewhere may have ended where nothing leads on: it says
    /// that the member is needed only if one from the whole set's values does, under any of the base model's choices.
    pub(crate) fn rest_of(&mut self, rest: &[String], whole: usize) -> Option<usize> {
        let index = self.index_of(rest, whole)?;
        let (whole, floor) = (&self.tried[whole], self.models.data.floor);
        if rest.is_empty() || !clearly_better(&self.tried[index], whole, floor) {
            return Some(index);
        }
        let again = self.models.fitted(whole, rest, &whole.known(), None);
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

    /// Tries rivals in the place of each member of a set of several, as they promised to be beside the base model: effects at
    /// the same port, and those that alone leave as little as the member does.
    pub(crate) fn exchanged(&mut self, best: usize) -> usize {
        let effects = self.tried[best].effects.clone();
        if effects.len() < 2 {
            return best;
        }
        let cards = self.models.exact.effects(&self.models.seen);
        let port = |id: &str| cards.iter().find(|c| c.id == id).map(|c| c.acts_on.as_str());
        let (mut fitted, most) = (Vec::new(), RIVALS as usize);
        let own = self.observed_where_settled(best, &effects).map(|own| own.fit.cost);
        let base = self.observing(&self.tried[0]).map_or(self.tried[0].fit.cost, |base| base.fit.cost);
        for leaving in &effects {
            let rest = all_but(&effects, leaving);
            let promised = || self.promises.iter().filter(|p| !effects.contains(&p.effect) && p.drop > 0.0);
            let at_port = |p: &&Promise| port(&p.effect) == port(leaving);
            let alike = |p: &&Promise| !at_port(p) && self.leaves_as_little(&p.effect, leaving, base);
            let rivals = promised().filter(at_port).take(most).chain(promised().filter(alike).take(most));
            let mut plans: Vec<Plan> = rivals
                .map(|p| Plan { added: vec![p.effect.clone()], drop: p.drop, start: p.start.clone() })
                .collect();
            if let Some(own) = own {
                let near = Candidate { effects: rest.clone(), ..self.tried[best].clone() };
                plans.retain(|p| !self.is_beaten(&self.set_with(&near, &p.added), own));
                if plans.is_empty() {
                    continue;
                }
                let beside = self.observed_where_settled(best, &rest);
                fitted.extend(self.fit_all(&near, beside.as_ref(), plans, Some(own)));
            } else if let Some(without) = self.index_of(&rest, best) {
                let near = self.tried[without].clone();
                let beside = self.observing(&near);
                fitted.extend(self.fit_all(&near, beside.as_ref(), plans, None));
            }
        }
        let mean = |i: usize| self.mean_square(i);
        let rival = fitted.into_iter().filter(|&i| self.tried[i].effects.len() <= effects.len());
        rival.fold(best, |a, b| if mean(b) < mean(a) { b } else { a })
    }

    /// Whether an effect alone leaves hardly more than another one, which takes most of the cost that the base model leaves.
    fn leaves_as_little(&self, effect: &String, other: &String, base: f64) -> bool {
        let alone = |id: &String| {
            let set = std::slice::from_ref(id);
            let seen = self.least_observed(|o| o.effects == set).map(|o| o.seen.cost);
            seen.or_else(|| self.tried.iter().find(|t| t.effects == set).map(|t| t.fit.cost))
        };
        let (Some(own), Some(other)) = (alone(effect), alone(other)) else { return false };
        other < (1.0 - MOST_OF_IT) * base && own <= ALIKE_COST * other
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
