//! Second chances beside the best set: what lost a race from a poor start may explain as much with less, or more.
//!
//! A set is first fitted from where the sets that it grew from had driven the base parameters, which may be far off,
//! and a law may rest there while another one finds its way. Beside the best set the base parameters are about right,
//! and so is the size of each effect: every set that differs in one member is worth another look from there.

use super::Candidate;
use super::candidate::{symbol, values_by_name};
use super::compare::clearly_better;
use super::screen::is_amplitude;
use super::search::{Search, all_but};
use super::with_effects;
use crate::fit::EQUAL_COST;
use rayon::prelude::*;
use sealegs_model::Parameter;

/// Sets that are fitted again.
const SECOND_CHANCES: usize = 3;

/// Starting values of each rival that are simulated, each as it was screened and as strong as what it replaces.
const STARTS: usize = 4;

/// The same of laws with more parameters, which differ in more than their strength.
const STARTS_OF_RICHER: usize = 12;

/// Share of what a member explains that another effect must have promised in its place.
const PROMISING: f64 = 0.1;

/// Values by the parameters' names.
type Known = Vec<(String, f64)>;

/// A set that differs from the best in one member, at the best of its starting values.
struct Rival {
    effects: Vec<String>,
    known: Known,
    cost: f64,
}

impl Search<'_> {
    /// Fits the most promising sets that differ from the best in one member again, with the best set's values of
    /// everything else; of no more parameters where the best set leaves nothing to explain. Returns the best set then.
    pub(super) fn second_chances(&mut self, best: usize) -> usize {
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
        let fitted: Vec<Option<Candidate>> = rivals.par_iter().map(|r| self.chance(near, r)).collect();
        let fitted = self.scattered_leaders(fitted.into_iter().flatten().collect());
        let kept: Vec<usize> = fitted.into_iter().map(|candidate| self.keep(candidate)).collect();
        kept.into_iter().fold(best, |best, i| {
            if clearly_better(&self.tried[best], &self.tried[i], self.data.floor) { i } else { best }
        })
    }

    /// A rival's fit near the best set; given up after a race if it is hopeless.
    fn chance(&self, near: &Candidate, rival: &Rival) -> Option<Candidate> {
        if self.options.secants {
            return self.fitted_near(near, &rival.effects, &rival.known);
        }
        let race = self.options.effort(near, self.options.race_steps);
        let raced =
            Candidate::fitted(self.data, self.base, &rival.effects, self.seen, &rival.known, &race).ok()?;
        let hopeless = self.is_hopeless(&raced, near.fit.error());
        Some(if hopeless { raced } else { self.finished(raced) })
    }

    /// The sets with another effect in the place of one, that lost by more than they should if they were equal.
    fn rivals(&mut self, best: usize, leaving: &str) -> Vec<Rival> {
        let chosen = &self.tried[best];
        let rest = all_but(&chosen.effects, leaving);
        let (cost, known, model) = (chosen.fit.cost, chosen.known(), chosen.model.clone_box());
        let old: Vec<(&Parameter, f64)> = model
            .parameters()
            .iter()
            .zip(&chosen.fit.values)
            .filter(|(p, _)| symbol(&p.name, leaving).is_some())
            .map(|(p, v)| (p, *v))
            .collect();
        let richer = !self.at_floor(best);
        let Some(without) = self.index_of(&rest, best) else { return Vec::new() };
        let promises = self.screen_beside(without, 2);
        let most = self.tried[without].fit.cost;
        let least = PROMISING * (most - cost);
        let mut rivals = Vec::new();
        for promise in promises.iter().filter(|p| p.effect != leaving && p.drop > least.max(0.0)) {
            let effects = self.with(&rest, &promise.effect);
            let done = |t: &Candidate| t.effects == effects && t.fit.cost <= cost + EQUAL_COST;
            let more = promise.starts.first().is_some_and(|(_, start)| start.len() > old.len());
            if self.tried.iter().any(done) || (more && !richer) {
                continue;
            }
            let starts = promise.starts.iter().map(|(_, start)| start);
            let starts: Vec<&Known> = starts.take(if more { STARTS_OF_RICHER } else { STARTS }).collect();
            rivals.extend(self.best_start(effects, &known, &starts, &old).filter(|r| r.cost < most));
        }
        rivals
    }

    /// A set at the one of these starting values, as they are or as strong as the effect that it replaces, that
    /// explains most, with the other values as known.
    fn best_start(
        &self,
        effects: Vec<String>,
        known: &[(String, f64)],
        starts: &[&Known],
        old: &[(&Parameter, f64)],
    ) -> Option<Rival> {
        let model = with_effects(self.base, &effects, self.seen).ok()?;
        let alike = starts.iter().map(|start| alike(model.parameters(), start, old));
        let starts: Vec<Known> = starts.iter().map(|&s| s.clone()).chain(alike).collect();
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

/// Starting values of an effect that are as strong as an old one: its amplitudes scaled together so that the first is
/// the old one's, if they have one unit, and what both call by the same name alike.
fn alike(parameters: &[Parameter], start: &Known, old: &[(&Parameter, f64)]) -> Known {
    let of = |name: &str| parameters.iter().find(|p| p.name == name);
    let amplitude = old.iter().find(|(p, _)| is_amplitude(p));
    let own = |p: &Parameter| amplitude.is_some_and(|(o, _)| is_amplitude(p) && o.unit == p.unit);
    let first = start.iter().find(|(name, _)| of(name).is_some_and(own)).map(|(_, v)| *v);
    let ratio = amplitude.zip(first).map_or(1.0, |((_, v), first)| v / first);
    let ratio = if ratio.is_finite() && ratio != 0.0 { ratio } else { 1.0 };
    let last = |name: &str| name.rsplit('.').next().map(str::to_owned);
    start
        .iter()
        .map(|(name, value)| {
            let same = old.iter().find(|(p, _)| last(&p.name) == last(name)).map(|(_, v)| *v);
            let scaled = of(name).filter(|p| own(p)).map(|p| (value * ratio).clamp(p.min, p.max));
            (name.clone(), same.or(scaled).unwrap_or(*value))
        })
        .collect()
}
