//! Fits from many starts, where nothing is known of a base parameter.
//!
//! A slow sensor beside a damping that can imitate it, or friction beside a part that rings, leaves an error of many
//! local minima, and no single start leads to the lowest one. Of many evenly spread starts the most promising are
//! followed, ever fewer of them for ever more steps.

use super::Search;
use crate::data::Data;
use crate::diagnose::Candidate;
use crate::diagnose::candidate::Known;
use crate::diagnose::policy::{EXPLAINED, SCATTERED, SCATTERED_RATIO, SHORTLIST};
use crate::diagnose::refine::Models;
use crate::diagnose::refine::starts::with_nominal_base;
use crate::diagnose::{values_by_name, with_effects};
use crate::fit::{self, Difference, FitOptions};
use crate::stats;
use rayon::prelude::*;
use sealegs_model::{Model, Parameter, Scale};

/// How many places are followed, of each set and of all together, and for how many steps.
const ROUNDS: [(usize, usize, usize); 3] = [(12, 240, 2), (4, 48, 4), (2, 8, 20)];

/// Starts of each set: four for each of the some twelve parameters that are spread at most.
const STARTS: u32 = 48;

/// Greatest ratio of a start to the best place that was found, up or down, about which there may be a lower one.
const NEARBY_RATIO: f64 = 2.0;

/// Bases of the sequence that fills the space of starts evenly (Halton 1960), one for each parameter.
const BASES: [u32; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];

/// Where a set has been followed to.
struct Place {
    set: usize,
    values: Vec<f64>,
    cost: f64,
}

impl Search<'_> {
    /// Fits pairs beside a set from many starts: the single effects that take most, each with every effect at another port; the
    /// indices. Fitted values may have taken the place of either, so that screening beside them promises nothing.
    pub(crate) fn scattered(&mut self, from: usize, fitted: &[usize]) -> Vec<usize> {
        let near = self.tried[from].clone();
        let mut leaders: Vec<usize> = fitted.to_vec();
        leaders.retain(|&i| self.tried[i].effects.len() == near.effects.len() + 1);
        let takes = |i: usize| near.fit.cost - self.tried[i].fit.cost;
        let most = leaders.iter().map(|&i| takes(i)).fold(0.0, f64::max);
        leaders.retain(|&i| takes(i) > SCATTERED * most);
        let cards = self.models.exact.effects(&self.models.seen);
        let port = |id: &str| cards.iter().find(|c| c.id == id).map(|c| c.acts_on.as_str());
        let mut sets: Vec<(Vec<String>, Known)> = Vec::new();
        for &leader in &leaders {
            let leader = &self.tried[leader];
            let own: Vec<_> = leader.effects.iter().filter(|e| !near.effects.contains(e)).collect();
            for other in self.admitted.iter().filter(|id| !leader.effects.contains(id)) {
                if own.iter().all(|e| port(e) != port(other)) {
                    // Alone an effect's values are biased by what is missing beside it: it starts from its guess.
                    sets.push((self.set_with(leader, std::slice::from_ref(other)), near.known()));
                }
            }
        }
        self.say_fitted(sets.iter().map(|(set, _)| set.clone()).collect());
        let mut indices = Vec::new();
        for fitted in self.models.scattered(&near, &sets) {
            indices.push(self.kept(fitted));
        }
        indices
    }
}

impl Models<'_> {
    /// Whether a set is worth many starts: much is left, nothing is known of a base parameter, and no position was
    /// measured that an observer could follow to the right neighbourhood.
    #[must_use]
    pub fn is_worth_scattering(&self, best: &Candidate) -> bool {
        let is_position = |name: &str| name.ends_with("angle_rad") || name.ends_with("position_m");
        !self.dear
            && !self.data.channels.iter().any(|c| is_position(&c.name))
            && best.fit.error() > EXPLAINED * self.data.floor
            && self.exact.parameters().iter().any(Parameter::is_unknown)
    }

    /// The run of which a candidate leaves most and the one of which it leaves least: what tells places apart that are far
    /// from one another. Runs without a residual do not count.
    fn extremes(&self, candidate: &Candidate) -> Data<'_> {
        let at = &candidate.fit.evaluation;
        let left = |run: usize| {
            let blocks = at.blocks.iter().filter(move |b| b.run == run);
            let all: Vec<f64> = blocks.flat_map(|b| b.residual.iter().copied()).collect();
            (!all.is_empty()).then(|| stats::rms(&all))
        };
        let runs = || (0..self.data.runs.len()).filter_map(|run| Some((run, left(run)?)));
        let most = runs().max_by(|a, b| a.1.total_cmp(&b.1));
        let least = runs().min_by(|a, b| a.1.total_cmp(&b.1));
        let kept = |run: usize| [most, least].into_iter().flatten().any(|(i, _)| i == run);
        let runs = self.data.runs.iter().enumerate().filter(|(i, _)| kept(*i)).map(|(_, run)| run.clone());
        Data::from_parts(self.data.channels.clone(), runs.collect(), self.data.floor)
    }

    /// Fits of sets, each from the best of many starts on few runs, in the end on all; sets that cannot be simulated are
    /// left out.
    #[must_use]
    pub fn scattered(&self, near: &Candidate, sets: &[(Vec<String>, Known)]) -> Vec<Candidate> {
        let models: Vec<Option<Box<dyn Model>>> =
            sets.iter().map(|(set, _)| with_effects(self.coarse.as_ref(), set, &self.seen).ok()).collect();
        let own = self.exact.parameters().len();
        let few = self.extremes(near);
        let rough = Models { data: &few, observed: None, ..self.clone() };
        // Far from the solution what is known of the base takes the part of what is not: it stays as stated.
        let known: Vec<String> =
            self.exact.parameters().iter().filter(|p| !p.is_unknown()).map(|p| p.name.clone()).collect();
        let around = |values: Vec<(usize, Vec<f64>)>, ratio: f64| -> Vec<Place> {
            let starts: Vec<(usize, Vec<f64>)> = values
                .iter()
                .filter_map(|(set, values)| Some((*set, models[*set].as_deref()?, values)))
                .flat_map(|(set, model, values)| {
                    starts(model, own, values, ratio).into_iter().map(move |s| (set, s))
                })
                .collect();
            let looked = starts.into_par_iter().filter_map(|(set, values)| {
                let cost = few.evaluate(models[set].as_deref()?, &values).ok()?.cost;
                Some(Place { set, values, cost })
            });
            let mut all: Vec<Place> = looked.collect();
            for (of_each, of_all, steps) in ROUNDS {
                all = most_promising(all, sets.len(), of_each, of_all)
                    .into_par_iter()
                    .filter_map(|Place { set, values, .. }| {
                        let model = models[set].as_deref()?;
                        let usual = rough.options(model, values, near);
                        let held = [&known[..], &usual.held[..]].concat();
                        // Only the place is wanted, and its derivatives of the first step lead there.
                        let difference = Difference::Secant;
                        let options =
                            FitOptions { max_steps: steps, held, difference, secants: true, ..usual };
                        let fit = fit::fit(&few, model, &options).ok()?;
                        Some(Place { set, cost: fit.cost, values: fit.values })
                    })
                    .collect();
            }
            all
        };
        let stated = sets.iter().enumerate().filter_map(|(set, (_, known))| {
            let known = with_nominal_base(self.exact, known);
            Some((set, values_by_name(models[set].as_deref()?, &known)))
        });
        let wide = around(stated.collect(), SCATTERED_RATIO);
        let mut best = most_promising(wide, sets.len(), 1, usize::MAX);
        // What the best place shares with other sets starts there, too.
        let leader =
            best.first().and_then(|p| Some((&sets[p.set].0, named(models[p.set].as_deref()?, &p.values))));
        if let Some((lead, values)) = leader {
            let added = |e: &String| !near.effects.contains(e);
            let shares = |set: &[String]| lead.iter().any(|e| added(e) && set.contains(e));
            let related = (0..sets.len()).filter(|&set| shares(&sets[set].0));
            let starts =
                related.filter_map(|set| Some((set, values_by_name(models[set].as_deref()?, &values))));
            let places = around(starts.collect(), NEARBY_RATIO);
            best = most_promising(places.into_iter().chain(best).collect(), sets.len(), 1, usize::MAX);
        }
        self.data.add_work(&few);
        best.truncate(SHORTLIST as usize);
        best.into_par_iter()
            .filter_map(|place| {
                let known = named(models[place.set].as_deref()?, &place.values);
                self.fitted_near(near, &sets[place.set].0, &known)
            })
            .collect()
    }
}

/// Values under their parameters' names.
fn named(model: &dyn Model, values: &[f64]) -> Known {
    model.parameters().iter().map(|p| p.name.clone()).zip(values.iter().copied()).collect()
}

/// The values of a place, and others all over a range about them: of what nothing is known, up to a ratio up and down.
fn starts(model: &dyn Model, own: usize, about: &[f64], ratio: f64) -> Vec<Vec<f64>> {
    let parameters = model.parameters();
    let spread: Vec<usize> =
        (0..parameters.len()).filter(|&i| spreads(&parameters[i], i < own)).take(BASES.len()).collect();
    let start = |n: u32| {
        let mut values = about.to_vec();
        for (&i, &base) in spread.iter().zip(&BASES) {
            let p = &parameters[i];
            let times = ratio.powf(2.0 * radical_inverse(n, base) - 1.0);
            values[i] = (about[i] * times).clamp(p.min, p.max);
        }
        values
    };
    std::iter::once(about.to_vec()).chain((1..STARTS).map(start)).collect()
}

/// The places of lowest cost, so many of each set and of all together.
fn most_promising(mut places: Vec<Place>, sets: usize, of_each: usize, of_all: usize) -> Vec<Place> {
    places.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut taken = vec![0; sets];
    places.retain(|place| {
        taken[place.set] += 1;
        taken[place.set] <= of_each
    });
    places.truncate(of_all);
    places
}

/// Whether the starts differ in a parameter: one of which nothing is known, or a positive one of an effect.
fn spreads(p: &Parameter, of_base: bool) -> bool {
    let periodic = p.starts.len() > 1 && p.scale == Scale::Linear && p.neutral.is_none();
    !p.fixed && p.value > 0.0 && p.prior_std.is_none() && if of_base { p.is_unknown() } else { !periodic }
}

/// The digits of a number in a base, mirrored at the point: between 0 and 1.
fn radical_inverse(mut number: u32, base: u32) -> f64 {
    let (mut place, mut inverse) = (1.0, 0.0);
    while number > 0 {
        place /= f64::from(base);
        inverse += place * f64::from(number % base);
        number /= base;
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_fill_the_range_evenly() {
        for base in BASES {
            let mut all: Vec<f64> = (1..=STARTS).map(|n| radical_inverse(n, base)).collect();
            all.sort_by(f64::total_cmp);
            let widest = all.windows(2).map(|w| w[1] - w[0]).fold(all[0], f64::max);
            let last = all[all.len() - 1];
            assert!(all[0] > 0.0 && last < 1.0 && widest < 3.0 / f64::from(STARTS.min(base)));
        }
        assert_eq!([1, 2, 3].map(|n| radical_inverse(n, 2)), [0.5, 0.25, 0.75]);
    }

    #[test]
    fn the_most_promising_places_are_followed_of_every_set() {
        let place = |set: usize, cost: f64| Place { set, values: Vec::new(), cost };
        let places = vec![place(0, 3.0), place(0, 1.0), place(0, 2.0), place(1, 9.0)];
        let kept: Vec<(usize, f64)> =
            most_promising(places, 2, 2, 9).iter().map(|p| (p.set, p.cost)).collect();
        assert_eq!(kept, [(0, 1.0), (0, 2.0), (1, 9.0)]);
    }
}
