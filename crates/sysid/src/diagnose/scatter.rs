//! Starts all over the place, where nothing is known of a base parameter and much is left.
//!
//! A friction beside a part that rings, or a slow sensor beside a damping that can imitate it, leaves an error of many
//! valleys, and no single start leads to the lowest one. Of many the most promising are followed, ever fewer for ever
//! longer.

use super::candidate::{Candidate, Effort, values_by_name};
use super::known_base::is_unknown;
use super::left::FAR_ABOVE;
use super::search::Search;
use rayon::prelude::*;
use sealegs_model::{Parameter, Scale};

/// Starts.
const STARTS: u32 = 48;

/// Greatest ratio to the nominal value, up or down.
const RATIO: f64 = 10.0;

/// How many are followed, and for how many steps, round by round.
const ROUNDS: [(usize, usize); 3] = [(24, 2), (8, 4), (2, 20)];

/// Bases of the sequence that fills the space of starts evenly (Halton 1960), one for each parameter.
const BASES: [u32; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];

impl Search<'_> {
    /// The candidate, or its fit from one of many other starts if that is better.
    pub(super) fn scattered(&self, candidate: Candidate) -> Candidate {
        if !self.bent || candidate.fit.error() <= FAR_ABOVE * self.data.floor {
            return candidate;
        }
        let model = candidate.model.as_ref();
        let own = self.base.parameters().len();
        let nominal: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
        let fitted = &candidate.fit.values;
        let spread: Vec<usize> = (0..nominal.len())
            .filter(|&i| spreads(&model.parameters()[i], i < own))
            .take(BASES.len())
            .collect();
        let start = |n: u32| -> Vec<f64> {
            // What is not spread starts from the base's nominal values and where the effects were fitted.
            let mut values = nominal.clone();
            values[own..].copy_from_slice(&fitted[own..]);
            for (&i, &base) in spread.iter().zip(&BASES) {
                let p = &model.parameters()[i];
                let ratio = RATIO.powf(2.0 * radical_inverse(n, base) - 1.0);
                values[i] = (p.value * ratio).clamp(p.min, p.max);
            }
            values
        };
        let cost = |values: &[f64]| self.data.evaluate(model, values).map_or(f64::INFINITY, |e| e.cost);
        let mut places: Vec<(Vec<f64>, f64)> = (1..=STARTS)
            .into_par_iter()
            .map(|n| {
                let values = start(n);
                let cost = cost(&values);
                (values, cost)
            })
            .collect();
        let mut best = candidate.clone();
        for (most, steps) in ROUNDS {
            places.sort_by(|a, b| a.1.total_cmp(&b.1));
            places.truncate(most);
            let effort = Effort::steps(steps);
            let followed: Vec<Option<Candidate>> = places
                .par_iter()
                .map(|(values, _)| {
                    let known = candidate.named(values);
                    let (data, base, seen) = (self.data, self.base, self.seen);
                    Candidate::fitted(data, base, &candidate.effects, seen, &known, &effort).ok()
                })
                .collect();
            let followed: Vec<Candidate> = followed.into_iter().flatten().collect();
            places = followed.iter().map(|c| (values_by_name(model, &c.known()), c.fit.cost)).collect();
            best =
                followed.into_iter().fold(best, |best, c| if c.fit.cost < best.fit.cost { c } else { best });
        }
        best
    }
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
