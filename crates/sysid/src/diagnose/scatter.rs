//! Starts all over the place, where nothing is known of a base parameter and much is left.
//!
//! A friction beside a part that rings, or a slow sensor beside a damping that can imitate it, leaves an error of many
//! valleys, and no single start leads to the lowest one. Of many the most promising are followed, ever fewer for ever
//! longer.

use super::candidate::{Candidate, Effort};
use super::known_base::{is_unknown, values_with_nominal_base};
use super::left::FAR_ABOVE;
use super::search::{PAIR, Search};
use rayon::prelude::*;
use sealegs_model::{Parameter, Scale};

/// Pairs that are looked for from many starts.
const PAIRS: usize = 12;

/// The same of larger sets, which grow from those and begin nearer the right values.
const LARGER: usize = 4;

/// Starts of each set.
const STARTS: u32 = 48;

/// Greatest ratio to the nominal value, up or down.
const RATIO: f64 = 10.0;

/// What is followed of them, round by round.
const ROUNDS: [Round; 3] = [
    Round { of_each: 24, of_all: usize::MAX, steps: 2 },
    Round { of_each: 8, of_all: 48, steps: 4 },
    Round { of_each: 2, of_all: 8, steps: 20 },
];

/// Bases of the sequence that fills the space of starts evenly (Halton 1960), one for each parameter.
const BASES: [u32; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];

/// How many places are followed, of each set and of all together, and for how many steps.
struct Round {
    of_each: usize,
    of_all: usize,
    steps: usize,
}

/// Where a set has been followed to.
struct Place {
    set: usize,
    values: Vec<f64>,
    cost: f64,
}

impl Search<'_> {
    /// Fits with the sets of lowest cost looked for from many starts, where an effect may be hidden, several are combined, and
    /// no set explains much.
    pub(super) fn scattered_leaders(&mut self, mut fitted: Vec<Candidate>) -> Vec<Candidate> {
        fitted.sort_by(|a, b| a.fit.cost.total_cmp(&b.fit.cost));
        let explained = fitted.first().is_none_or(|c| c.fit.error() <= FAR_ABOVE * self.data.floor);
        if !self.bent || explained {
            return fitted;
        }
        let (mut leaders, mut others): (Vec<_>, Vec<_>) =
            fitted.into_iter().partition(|c| c.effects.len() >= PAIR);
        let most = if leaders.iter().all(|c| c.effects.len() == PAIR) { PAIRS } else { LARGER };
        others.extend(leaders.split_off(leaders.len().min(most)));
        let before = self.data.work().0;
        others.extend(self.followed_from_many_starts(leaders));
        self.scattered += self.data.work().0 - before;
        others
    }

    /// The sets, each at its fit from one of many other starts if that is better.
    fn followed_from_many_starts(&self, mut sets: Vec<Candidate>) -> Vec<Candidate> {
        let all: Vec<(usize, Vec<f64>)> = sets
            .iter()
            .enumerate()
            .flat_map(|(set, candidate)| self.starts(candidate).into_iter().map(move |start| (set, start)))
            .collect();
        let mut places: Vec<Place> = all
            .into_par_iter()
            .filter_map(|(set, values)| {
                let cost = self.data.evaluate(sets[set].model.as_ref(), &values).ok()?.cost;
                Some(Place { set, values, cost })
            })
            .collect();
        for round in ROUNDS {
            let effort = Effort::steps(round.steps);
            let followed: Vec<Option<(usize, Candidate)>> = most_promising(places, sets.len(), &round)
                .par_iter()
                .map(|place| {
                    let known = sets[place.set].named(&place.values);
                    let effects = &sets[place.set].effects;
                    let fit = Candidate::fitted(self.data, self.base, effects, self.seen, &known, &effort);
                    fit.ok().map(|c| (place.set, c))
                })
                .collect();
            places = Vec::new();
            for (set, candidate) in followed.into_iter().flatten() {
                places.push(Place { set, values: candidate.fit.values.clone(), cost: candidate.fit.cost });
                if candidate.fit.cost < sets[set].fit.cost {
                    sets[set] = candidate;
                }
            }
        }
        sets
    }

    /// Values all over the range of what nothing is known of; the others are the base's nominal values, its choices as they
    /// were made, and those at which the effects were fitted.
    fn starts(&self, candidate: &Candidate) -> Vec<Vec<f64>> {
        let (parameters, own) = (candidate.model.parameters(), self.base.parameters().len());
        let spread: Vec<usize> =
            (0..parameters.len()).filter(|&i| spreads(&parameters[i], i < own)).take(BASES.len()).collect();
        let nominal = values_with_nominal_base(self.base, candidate);
        let start = |n: u32| {
            let mut values = nominal.clone();
            for (&i, &base) in spread.iter().zip(&BASES) {
                let p = &parameters[i];
                let ratio = RATIO.powf(2.0 * radical_inverse(n, base) - 1.0);
                values[i] = (p.value * ratio).clamp(p.min, p.max);
            }
            values
        };
        (1..=STARTS).map(start).collect()
    }
}

/// The places of lowest cost, as many as a round follows.
fn most_promising(mut places: Vec<Place>, sets: usize, round: &Round) -> Vec<Place> {
    places.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut taken = vec![0; sets];
    places.retain(|place| {
        taken[place.set] += 1;
        taken[place.set] <= round.of_each
    });
    places.truncate(round.of_all);
    places
}

/// Whether the starts differ in a parameter: one of which nothing is known, or a positive one of an effect.
fn spreads(p: &Parameter, of_base: bool) -> bool {
    let periodic = p.starts.len() > 1 && p.scale == Scale::Linear && p.neutral.is_none();
    !p.fixed && p.value > 0.0 && p.prior_std.is_none() && if of_base { is_unknown(p) } else { !periodic }
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
            assert!(
                all[0] > 0.0
                    && all[all.len() - 1] < 1.0
                    && widest < 3.0 / f64::from(STARTS).min(f64::from(base))
            );
        }
        assert_eq!([1, 2, 3].map(|n| radical_inverse(n, 2)), [0.5, 0.25, 0.75]);
    }
}
