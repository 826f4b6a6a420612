//! Second chances beside the best set: what lost a race from a poor start may explain as much with less.
//!
//! A set is first fitted from where the sets that it grew from had driven the base parameters, which may be far off,
//! and a simple law may rest there while one that contains it finds its way. Beside the best set the base
//! parameters are about right: every set that differs in one member is worth another look from there.

use super::Candidate;
use super::candidate::values_by_name;
use super::search::{EQUAL_COST, Search};
use super::with_effects;
use rayon::prelude::*;

/// Sets that are fitted again.
const SECOND_CHANCES: usize = 3;

/// Starting values of each rival that are simulated.
const STARTS: usize = 4;

/// Values by the parameters' names.
type Known = Vec<(String, f64)>;

/// A set that differs from the best in one member, at the best of its starting values.
struct Rival {
    effects: Vec<String>,
    known: Known,
    cost: f64,
}

impl Search<'_> {
    /// Fits the most promising sets that differ from the best in one member and have no more parameters again, with
    /// the best set's values of everything else.
    pub(super) fn second_chances(&mut self, best: usize) {
        let mut rivals: Vec<Rival> = Vec::new();
        for leaving in self.tried[best].effects.clone() {
            for rival in self.rivals(best, &leaving) {
                if rivals.iter().all(|r| r.effects != rival.effects) {
                    rivals.push(rival);
                }
            }
        }
        rivals.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        rivals.truncate(SECOND_CHANCES);
        let near = &self.tried[best];
        let fitted: Vec<Option<Candidate>> =
            rivals.par_iter().map(|r| self.fitted_near(near, &r.effects, &r.known)).collect();
        for candidate in fitted.into_iter().flatten() {
            self.keep(candidate);
        }
    }

    /// The sets with another effect in the place of one, that lost by more than they should if they were equal.
    fn rivals(&mut self, best: usize, leaving: &str) -> Vec<Rival> {
        let chosen = &self.tried[best];
        let rest: Vec<String> = chosen.effects.iter().filter(|e| *e != leaving).cloned().collect();
        let (cost, known) = (chosen.fit.cost, chosen.known());
        let count = |known: &[(String, f64)], id: &str| {
            known.iter().filter(|(name, _)| symbol(name, id).is_some()).count()
        };
        let most = count(&known, leaving);
        let Some(without) = self.index_of(&rest, best) else { return Vec::new() };
        let promises = self.screen_beside(without, 2);
        let others: Vec<(Vec<String>, Vec<Known>)> = promises
            .iter()
            .filter(|p| p.effect != leaving && p.drop > 0.0)
            .filter(|p| p.starts.first().is_some_and(|(_, start)| start.len() <= most))
            .map(|p| {
                let starts = p.starts.iter().take(STARTS).map(|(_, start)| start.clone());
                (self.with(&rest, &p.effect), starts.collect())
            })
            .filter(|(effects, _)| {
                self.tried.iter().all(|t| t.effects != *effects || t.fit.cost > cost + EQUAL_COST)
            })
            .collect();
        let mut rivals = Vec::new();
        for (effects, mut starts) in others {
            // Laws of one family call the same thing by the same name.
            if let Some(first) = starts.first() {
                let alike: Known = first
                    .iter()
                    .map(|(name, value)| {
                        let own = name.rsplit('.').next().unwrap_or(name);
                        let same = known.iter().find(|(n, _)| symbol(n, leaving) == Some(own));
                        (name.clone(), same.map_or(*value, |(_, v)| *v))
                    })
                    .collect();
                starts.push(alike);
            }
            rivals.extend(
                self.best_start(effects, &known, starts).filter(|r| r.cost < self.tried[without].fit.cost),
            );
        }
        rivals
    }

    /// A set at the one of these starting values that explains most, with the other values as known.
    fn best_start(&self, effects: Vec<String>, known: &[(String, f64)], starts: Vec<Known>) -> Option<Rival> {
        let model = with_effects(self.base, &effects, self.seen).ok()?;
        let tried: Vec<(f64, Known)> = starts
            .into_par_iter()
            .filter_map(|start| {
                let all: Known = known.iter().cloned().chain(start).collect();
                let values = values_by_name(model.as_ref(), &all);
                let cost = self.data.evaluate(model.as_ref(), &values).ok()?.cost;
                cost.is_finite().then_some((cost, all))
            })
            .collect();
        let best = tried.into_iter().reduce(|best, other| if other.0 < best.0 { other } else { best });
        best.map(|(cost, known)| Rival { effects, known, cost })
    }
}

/// What an effect calls one of its parameters, if it is its own.
fn symbol<'a>(parameter: &'a str, effect: &str) -> Option<&'a str> {
    parameter.strip_prefix(effect)?.strip_prefix('.')
}
