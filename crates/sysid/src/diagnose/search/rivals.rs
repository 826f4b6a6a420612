//! Sets that the data may not tell from the best one: it by other names, in a simpler law, or in parts.

use super::Search;
use super::nested::{as_simple, simpler_id};
use crate::diagnose::Candidate;
use crate::diagnose::candidate::{
    Known, all_but,
    compare::{clearly_better, gain, is_seen},
    symbol,
};
use crate::diagnose::policy::{NEAR_FLOOR, TIED_COST};
use crate::fit::EQUAL_COST;
use rayon::prelude::*;

/// What effects at the drive and at sensors act on, by their cards.
const DRIVE: &str = "drive";
/// See [`DRIVE`].
const SENSOR: &str = "sensor";

impl Search<'_> {
    /// Fits what may be a set that explains everything by another name, before its ties are told: an effect at all sensors in
    /// the place of one at the drive, and one at the drive in the place of that with the same parameters at all sensors, as a
    /// delay of the command is one of every sensor and an observer follows the sensors; and sets of no more effects that leave
    /// next to nothing, under the base model's other discrete choices, as a sample of one delay may be the stamp's convention
    /// beside another.
    pub fn confirm_rivals(&mut self, best: usize) {
        if self.models.dear {
            return self.finish_simpler(best);
        }
        let set = &self.tried[best];
        if set.effects.is_empty() || !self.models.is_settled(set, &self.tried[0]) {
            return;
        }
        let (effects, size) = (set.effects.clone(), set.effects.len());
        let cards = self.models.exact.effects(&self.models.seen);
        let acts_on = |id: &String, port: &str| cards.iter().any(|c| c.id == *id && c.acts_on == port);
        let everywhere = |id: &String| acts_on(id, SENSOR) && !id.contains('@');
        let parameters = |id: &String| -> Vec<String> {
            let card = cards.iter().find(|c| c.id == *id);
            card.into_iter().flat_map(|c| &c.parameters).map(|p| p.name.clone()).collect()
        };
        let replaces = |rival: &String, leaving: &String| match acts_on(leaving, DRIVE) {
            true => everywhere(rival),
            false => everywhere(leaving) && acts_on(rival, DRIVE) && parameters(rival) == parameters(leaving),
        };
        for leaving in &effects {
            let rest = Candidate { effects: all_but(&effects, leaving), ..self.tried[best].clone() };
            let rivals = self.admitted.iter().filter(|id| !effects.contains(id) && replaces(id, leaving));
            for rival in rivals.cloned().collect::<Vec<_>>() {
                // From its guess a delay may end a sample away.
                let known = renamed(&self.tried[best].known(), leaving, &rival);
                let with = self.set_with(&rest, &[rival]);
                if let Some(fitted) = self.models.fitted(&self.tried[best], &with, &known, None) {
                    self.kept(fitted);
                }
            }
        }
        let near = NEAR_FLOOR * self.models.data.floor;
        let is_near = |t: &Candidate| t.effects.len() <= size && t.fit.error() <= near;
        let rivals: Vec<usize> =
            (1..self.tried.len()).filter(|&i| i != best && is_near(&self.tried[i])).collect();
        let (models, tried) = (&self.models, &self.tried);
        let settled: Vec<Candidate> =
            rivals.par_iter().map(|&i| models.settled(tried[i].clone()).0).collect();
        for (i, settled) in rivals.into_iter().zip(settled) {
            if settled.fit.cost < self.tried[i].fit.cost {
                self.tried[i] = settled;
            }
        }
    }

    /// Where simulations are dear only the leader's fit is finished: fits the sets of fewest parameters on that leave a trace
    /// only and are clearly worse as they are. A spring at another setting is as stiff as one with a clamp beside it that
    /// never slips.
    fn finish_simpler(&mut self, best: usize) {
        let (chosen, floor) = (&self.tried[best], self.models.data.floor);
        let parameters = |i: usize| self.tried[i].effect_parameters();
        let is_simpler = |i: &usize| {
            (1..=chosen.effects.len()).contains(&self.tried[*i].effects.len())
                && parameters(*i) < parameters(best)
                && self.is_explained(*i)
        };
        let simpler: Vec<usize> = (1..self.tried.len()).filter(is_simpler).collect();
        let fewest = simpler.iter().map(|&i| parameters(i)).min();
        let simplest = simpler.into_iter().filter(|&i| Some(parameters(i)) == fewest);
        let worse: Vec<usize> = simplest.filter(|&i| clearly_better(&self.tried[i], chosen, floor)).collect();
        for i in worse {
            let finished = self.models.finished(self.tried[i].clone());
            self.kept(finished);
        }
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
        let first = equal.first().copied().unwrap_or(best);
        // Of those that fit equally well the catalogue's order decides: the rest of a digit would.
        let alike = |i: usize| {
            order(i) == order(first)
                && (self.tried[i].fit.cost - self.tried[first].fit.cost).abs() <= EQUAL_COST
        };
        let places = |i: usize| -> Vec<Option<usize>> {
            self.tried[i].effects.iter().map(|e| self.admitted.iter().position(|a| a == e)).collect()
        };
        let chosen = equal.iter().copied().filter(|&i| alike(i)).min_by_key(|&i| places(i)).unwrap_or(first);
        let own = &self.tried[chosen].effects;
        let tied = equal
            .into_iter()
            .filter(|&i| i != chosen)
            .filter(|&i| own.is_empty() || self.tried[i].effects.len() <= own.len())
            .filter(|&i| self.tried[i].fit.cost <= TIED_COST * self.tried[chosen].fit.cost)
            .collect();
        (chosen, tied)
    }

    /// The chosen set with a simpler law in the place of one that contains it (dry friction for one that differs between the
    /// directions), fitted from the chosen one's values: the simpler one is chosen and the richer one its tie unless the
    /// richer one is clearly better. Of a chosen one that is fitted to the end the simpler one is, too.
    pub fn simplified(&mut self, chosen: usize, tied: &mut Vec<usize>) -> usize {
        let (floor, effects) = (self.models.data.floor, self.tried[chosen].effects.clone());
        let cards = self.models.exact.effects(&self.models.seen);
        for effect in &effects {
            let of = |id: &String| cards.iter().find(|c| c.id == *id);
            let Some(richer) = of(effect) else { continue };
            let Some(simple) = richer.becomes.as_ref().map(|law| simpler_id(richer, law)) else { continue };
            if effects.contains(&simple) || !self.admitted.contains(&simple) {
                continue;
            }
            let Some(card) = of(&simple) else { continue };
            let known = as_simple(&self.tried[chosen].known(), richer, card);
            let rest = Candidate { effects: all_but(&effects, effect), ..self.tried[chosen].clone() };
            let set = self.set_with(&rest, std::slice::from_ref(&simple));
            let Some(fitted) = self.models.fitted(&self.tried[chosen], &set, &known, None) else { continue };
            let mut fitted = self.models.finished(fitted);
            if self.tried[chosen].exact {
                fitted = self.models.polished(&fitted);
            }
            let index = self.kept(fitted);
            let (simple, richer) = (&self.tried[index], &self.tried[chosen]);
            if !clearly_better(simple, richer, floor) || self.is_unseen(simple, richer) {
                tied.retain(|&i| i != index);
                tied.push(chosen);
                // Beside another law that contains it, the simpler one is that law twice. What was fitted to the end in open
                // loop is not compared with what was fitted in windows.
                let comparable = !self.tried[index].exact || !self.models.windowed;
                let pruned = if comparable && !self.is_long() {
                    let once = self.without_contained(index);
                    self.pruned(once)
                } else {
                    index
                };
                return self.simplified(pruned, tied);
            }
        }
        chosen
    }

    /// Whether an observer does not see what a richer law gains over a simple one, where a simulation is dear: a leg whose
    /// motion amplifies small errors follows either by chance.
    fn is_unseen(&self, simple: &Candidate, richer: &Candidate) -> bool {
        let observed = || Some((self.observing(simple)?, self.observing(richer)?));
        self.models.dear && observed().is_some_and(|(simple, richer)| !is_seen(&simple.fit, &richer.fit))
    }

    /// The chosen set with one of its laws in two parts, the simpler law and what makes up its departure, where that has no
    /// more parameters: sliding friction that differs between the directions is dry friction and a constant force. It takes
    /// the place of the chosen one if it is clearly better, and is a tie of it if it is not clearly worse. Not on a leg,
    /// where a simulation is dear.
    pub fn in_parts(&mut self, chosen: usize, tied: &mut Vec<usize>) -> usize {
        let floor = self.models.data.floor;
        let effects = self.tried[chosen].effects.clone();
        let parts = |effect: &String| {
            let cards = self.models.exact.effects(&self.models.seen);
            let law = cards.into_iter().find(|c| c.id == *effect)?.becomes?;
            let place = effect.rsplit_once('/').map_or(String::new(), |(place, _)| format!("{place}/"));
            let (simple, beside) = (format!("{place}{}", law.id), format!("{place}{}", law.beside?));
            let free = |id: &String| self.admitted.contains(id) && !effects.contains(id);
            (!self.models.dear && free(&simple) && free(&beside)).then(|| (effect.clone(), simple, beside))
        };
        let Some((whole, simple, beside)) = effects.iter().find_map(parts) else { return chosen };
        let rest = Candidate { effects: all_but(&effects, &whole), ..self.tried[chosen].clone() };
        let with_simple = self.set_with(&rest, std::slice::from_ref(&simple));
        let grown = self.index_of(&with_simple, chosen).and_then(|i| {
            let grown = self.models.with_one_more(&self.tried[i], &beside)?;
            let set = self.set_with(&rest, &[simple, beside]);
            Some(self.models.reordered(grown, &set))
        });
        let (Some(parts), whole) = (grown, &self.tried[chosen]) else { return chosen };
        let (better, worse) = (clearly_better(whole, &parts, floor), clearly_better(&parts, whole, floor));
        let index = self.tried.len();
        self.tried.push(parts);
        match (better, worse) {
            (true, _) => index,
            (false, true) => chosen,
            (false, false) => {
                tied.push(index);
                chosen
            }
        }
    }
}

/// Values by name with an effect's own under another one's name.
fn renamed(known: &Known, effect: &str, other: &str) -> Known {
    let name = |name: &String| match symbol(name, effect) {
        Some(own) => format!("{other}.{own}"),
        None => name.clone(),
    };
    known.iter().map(|(n, value)| (name(n), *value)).collect()
}

#[cfg(test)]
mod tests {
    use super::renamed;

    #[test]
    fn an_effects_values_are_taken_over_under_another_name() {
        let known = [("damping", 2.0), ("knee/lag.delay_s", 1e-3), ("knee/lag-of-two.delay_s", 2e-3)];
        let known = known.map(|(name, value)| (name.to_owned(), value)).to_vec();
        let names: Vec<String> =
            renamed(&known, "knee/lag", "knee/late").into_iter().map(|(n, _)| n).collect();
        assert_eq!(names, ["damping", "knee/late.delay_s", "knee/lag-of-two.delay_s"]);
    }
}
