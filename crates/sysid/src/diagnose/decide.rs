//! What a search ends with: the simplest of the sets that explain as much, what ties with it, and what the holdout runs
//! say where the fit runs leave that open.

use super::compare::{
    WORTH_SHARE, WORTH_SQUARED_NOISE, better_on_the_whole, clearly_better, gain, runs_helped,
};
use super::left::{FAR_ABOVE, NEAR_FLOOR, excess};
use super::search::{Search, all_but};
use crate::data::Data;
use rayon::prelude::*;

/// Cost as a ratio of the chosen set's above which a set is no tie, whatever is foreseen of stretches left out.
pub(super) const TIED_COST: f64 = 1.1;

/// Gain in the mean squared residual, in squared floors or as a share of what is left if that is more, below which the
/// holdout runs must confirm it.
const WEAK: f64 = 0.1;

/// Ratio of errors on holdout runs up to which these do not decide between sets that the fit runs leave open.
const HELD_OUT_ALIKE: f64 = 1.1;

/// Share of what is missing without it, on the holdout runs, that each effect of several takes where together they are
/// far from explaining everything: flexible laws share out among them what none of them is.
const EARNS: f64 = 0.5;

/// Share of the held-out runs on which a set must help that is named by them.
const MOST_RUNS: f64 = 0.75;

impl Search<'_> {
    /// Of all sets of no more effects that are not clearly worse, the simplest is chosen and the others are
    /// its ties. A set that holds the chosen one and something beside it is no tie.
    pub(super) fn ties(&self, best: usize) -> (usize, Vec<usize>) {
        let size = self.tried[best].effects.len();
        let mut equal: Vec<usize> = (0..self.tried.len())
            .filter(|&i| i == best || self.tried[i].effects.len() <= size)
            .filter(|&i| i == best || !clearly_better(&self.tried[i], &self.tried[best], self.data.floor))
            .collect();
        let order = |i: usize| {
            let t = &self.tried[i];
            (t.effects.len(), t.effect_parameters())
        };
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

    /// Error of a set on the holdout runs, in noise units.
    fn held_out(&self, holdout: &Data, index: usize) -> f64 {
        self.tried[index].held_out(holdout).map_or(f64::INFINITY, |evaluation| evaluation.rms)
    }

    /// The set, or a part of it where what the rest gains is little and nothing on the holdout runs: a ring that no fit
    /// can follow leaves a little that other effects take up, run by run.
    pub(super) fn supported(&self, holdout: &Data, best: usize) -> usize {
        let (own, floor, error) = (&self.tried[best].effects, self.data.floor, self.tried[best].fit.error());
        let little = WEAK * floor.powi(2).max(excess(error, floor));
        let weak = |i: usize| self.tried[i].fit.error().powi(2) - error.powi(2) < little;
        let part = |i: usize| {
            let effects = &self.tried[i].effects;
            effects.len() < own.len() && effects.iter().all(|e| own.contains(e))
        };
        let parts: Vec<usize> = (0..self.tried.len()).filter(|&i| part(i) && weak(i)).collect();
        if parts.is_empty() {
            return best;
        }
        let (floor, error) = (holdout.floor, self.held_out(holdout, best));
        let worth = (WORTH_SQUARED_NOISE * floor.powi(2)).max(WORTH_SHARE * excess(error, floor));
        let most = error.powi(2) + worth;
        let as_good = parts.into_iter().filter(|&i| self.held_out(holdout, i).powi(2) <= most);
        as_good.min_by_key(|&i| self.tried[i].effects.len()).unwrap_or(best)
    }

    /// The set, or one that gains on the whole but loses on some stretches of the fit runs, where much is left and most
    /// of the held-out runs say that it takes most of what is missing: of several effects in a rig one may hide
    /// another from a single run.
    pub(super) fn confirmed(&self, holdout: &Data, best: usize) -> usize {
        if self.tried[best].fit.error() <= FAR_ABOVE * self.data.floor {
            return best;
        }
        let Ok(before) = self.tried[best].held_out(holdout) else { return best };
        let missing = excess(before.rms, holdout.floor);
        let helps = |i: &usize| {
            self.tried[*i].held_out(holdout).is_ok_and(|after| {
                let (helped, all) = runs_helped(&before, &after);
                excess(after.rms, holdout.floor) <= (1.0 - EARNS) * missing
                    && helped as f64 >= MOST_RUNS * all as f64
            })
        };
        let better = |i: &usize| better_on_the_whole(&self.tried[best], &self.tried[*i], self.data.floor);
        let mut open: Vec<usize> = (0..self.tried.len()).filter(better).collect();
        open.sort_by(|&a, &b| self.mean_square(a).total_cmp(&self.mean_square(b)));
        open.into_iter().find(helps).unwrap_or(best)
    }

    /// The set, without the members that do not earn their place on the holdout runs, where it is far from explaining
    /// everything.
    pub(super) fn earned(&mut self, holdout: &Data, mut best: usize) -> usize {
        let far = |search: &Self, i: usize| search.tried[i].fit.error() > FAR_ABOVE * search.data.floor;
        let missing = |search: &Self, i: usize| excess(search.held_out(holdout, i), holdout.floor);
        let mut left = missing(self, best);
        while self.tried[best].effects.len() > 1 && far(self, best) {
            let effects = self.tried[best].effects.clone();
            let parts: Vec<usize> = effects
                .iter()
                .filter_map(|leaving| self.index_of(&all_but(&effects, leaving), best))
                .collect();
            let least = parts.into_iter().map(|i| (i, missing(self, i))).min_by(|a, b| a.1.total_cmp(&b.1));
            match least {
                Some((part, of_part)) if left > (1.0 - EARNS) * of_part => (best, left) = (part, of_part),
                _ => break,
            }
        }
        best
    }

    /// Of sets that the fit runs cannot tell apart, those that the holdout runs do not tell apart either: the chosen one
    /// first if it is among them, else the one that foresees best.
    pub(super) fn standing(&self, holdout: &Data, chosen: usize, tied: Vec<usize>) -> (usize, Vec<usize>) {
        if tied.is_empty() {
            return (chosen, tied);
        }
        let all: Vec<usize> = [chosen].into_iter().chain(tied).collect();
        let errors: Vec<f64> = all.par_iter().map(|&i| self.held_out(holdout, i)).collect();
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let most = (HELD_OUT_ALIKE * least).max(NEAR_FLOOR * holdout.floor);
        let best = if errors[0] <= most { Some(0) } else { errors.iter().position(|e| *e == least) };
        let best = best.unwrap_or(0);
        let others = (0..all.len()).filter(|&k| k != best && errors[k] <= most).map(|k| all[k]).collect();
        (all[best], others)
    }
}

#[cfg(test)]
mod tests {
    use crate::diagnose::{Options, VerdictKind, diagnose};
    use crate::toy::{Toy, campaign, run};
    use crate::{Campaign, Role};
    use sealegs_model::Record;

    const NOISE: (f64, f64) = (0.2, 0.001);

    /// Runs whose force sensor has so much of a cube, 1/N^2.
    fn cubed(of_runs: &[(Role, f64)]) -> Campaign {
        let one = |(seed, (role, a)): (u64, &(Role, f64))| -> (Role, Record) {
            let mut record = run(&[1.1, 5.0, 380.0], 800, seed, NOISE, (1.0, 0.0), 1.0);
            let exact = run(&[1.1, 5.0, 380.0], 800, seed, (0.0, 0.0), (1.0, 0.0), 1.0);
            for (measured, force) in record.outputs[0].values.iter_mut().zip(&exact.outputs[0].values) {
                *measured += a * force.powi(3);
            }
            (*role, record)
        };
        campaign((0..).zip(of_runs).map(one).collect(), NOISE)
    }

    fn named(of_runs: &[(Role, f64)]) -> (VerdictKind, Vec<String>) {
        let campaign = cubed(of_runs);
        let verdict = diagnose(&campaign, &Toy::new(), &Options::default(), &|_| ()).unwrap().verdict;
        (verdict.kind, verdict.effects)
    }

    #[test]
    fn held_out_runs_confirm_what_one_fit_run_speaks_against() {
        const A: f64 = 0.002;
        let fit = [(Role::Fit, A), (Role::Fit, A), (Role::Fit, A), (Role::Fit, -0.3 * A)];
        let with = |held_out: [f64; 4]| -> Vec<(Role, f64)> {
            fit.into_iter().chain(held_out.map(|a| (Role::Holdout, a))).collect()
        };
        let cube = vec!["cubic-sensor".to_owned()];
        assert_eq!(named(&with([A, A, A, -0.2 * A])), (VerdictKind::PartlyExplained, cube));
        assert_eq!(named(&with([A, A, -0.5 * A, -0.5 * A])), (VerdictKind::Unexplained, Vec::new()));
    }
}
