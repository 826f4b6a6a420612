//! Whether a choice among fitted sets flips when fit runs are left out, told without another fit or simulation.
//!
//! Where the fit runs are three or more, every candidate's [`Validation`] holds what it leaves of each run when that run is
//! predicted from the others. A split leaves one run out of that comparison. It keeps the set that was chosen unless it turns
//! one of the judgements that led there: a set that is not clearly better on all runs is so without this one, or a smaller
//! set that is clearly worse on all runs is not so without it. The values that predict the other runs still know the run
//! that is left out, so that a split that keeps the choice is weaker evidence than one that flips it.

use crate::Evaluation;
use crate::diagnose::{Candidate, Found, Validation, clearly_better};
use crate::fit::Fit;
use nalgebra::DMatrix;

/// Fit runs from which on one may be left out.
pub const FEWEST_RUNS: usize = 3;

/// Error over the noise floor up to which the base model leaves nothing of any split, as nothing more is searched up to it.
const LEAVES_NOTHING: f64 = 1.01;

/// What a split chooses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Split {
    /// The run that is left out, by its place among the fit runs.
    pub left_out: usize,
    /// Index of the set in [`Found::tried`].
    pub chosen: usize,
}

/// What each split of the fit runs chooses of what was found, where `named` was chosen of all; `floor` is the noise floor.
/// None of fewer than [`FEWEST_RUNS`] runs.
#[must_use]
pub fn splits(found: &Found, named: usize, floor: f64) -> Option<Vec<Split>> {
    let mut sets: Vec<Lean> = found.tried.iter().map(Lean::of).collect::<Option<_>>()?;
    if let Some(base) = sets.first_mut() {
        // What was not fitted again is compared with the base model as the search knew it.
        if named == 0 && base.whole.stretches.len() == found.base_as_searched.stretches.len() {
            base.whole = found.base_as_searched.clone();
            base.with_all();
        }
    }
    // The steps of the search may have left what the model's own do not: other sets, fitted with those alone, took that.
    if named == 0 && found.tried.first().is_some_and(|base| base.fit.error() <= LEAVES_NOTHING * floor) {
        return Some((0..sets.first()?.runs.len()).map(|left_out| Split { left_out, chosen: 0 }).collect());
    }
    let equal = |i: usize| i == named || found.tied.contains(&i) || found.same.contains(&i);
    let others: Vec<usize> = (0..sets.len()).filter(|&i| !equal(i)).collect();
    flips(&mut sets, named, &others, floor)
}

/// A candidate without the derivatives and predictions of its fit, from which runs can be taken.
struct Lean {
    candidate: Candidate,
    whole: Validation,
    cost: f64,
    /// Sum of squared residuals of the fit, and their number, run by run.
    runs: Vec<(f64, usize)>,
}

impl Lean {
    /// None where the validation is not by whole runs, three or more.
    fn of(of: &Candidate) -> Option<Self> {
        let blocks = &of.fit.evaluation.blocks;
        let count = blocks.iter().map(|b| b.run + 1).max().unwrap_or(0);
        if count < FEWEST_RUNS || of.validation.stretches.len() != count {
            return None;
        }
        let mut runs = vec![(0.0, 0); count];
        for block in blocks {
            runs[block.run].0 += block.residual.iter().map(|r| r * r).sum::<f64>();
            runs[block.run].1 += block.residual.len();
        }
        let candidate = Candidate {
            effects: of.effects.clone(),
            model: of.model.clone_box(),
            fit: without_derivatives(&of.fit),
            validation: of.validation.clone(),
            exact: of.exact,
        };
        Some(Self { candidate, whole: of.validation.clone(), cost: of.fit.cost, runs })
    }

    fn with_all(&mut self) {
        self.candidate.validation = self.whole.clone();
        self.candidate.fit.cost = self.cost;
    }

    fn without(&mut self, run: usize) {
        let (squares, rows) = self.runs[run];
        let mut stretches = self.whole.stretches.clone();
        stretches.remove(run);
        let residuals = self.whole.residuals.saturating_sub(rows);
        self.candidate.validation = Validation { stretches, residuals };
        self.candidate.fit.cost = self.cost - 0.5 * squares;
    }

    fn mean_square(&self) -> f64 {
        self.candidate.validation.mean_square()
    }
}

/// The numbers of a fit that a comparison of two asks for.
fn without_derivatives(fit: &Fit) -> Fit {
    let at = &fit.evaluation;
    let evaluation = Evaluation {
        values: Vec::new(),
        predictions: Vec::new(),
        sensors: Vec::new(),
        blocks: Vec::new(),
        cost: at.cost,
        rms: at.rms,
    };
    Fit {
        values: Vec::new(),
        parameters: Vec::new(),
        free: Vec::new(),
        covariance: DMatrix::zeros(0, 0),
        evaluation,
        jacobian: Vec::new(),
        slopes: Vec::new(),
        normal: DMatrix::zeros(0, 0),
        gradient: Vec::new(),
        cost: fit.cost,
        steps: fit.steps,
        converged: fit.converged,
        std_inflation: fit.std_inflation,
        simulations: fit.simulations,
        simulated_s: fit.simulated_s,
    }
}

/// The choice of each split among the named set and some others.
fn flips(sets: &mut [Lean], named: usize, others: &[usize], floor: f64) -> Option<Vec<Split>> {
    let better = |sets: &[Lean], worse: usize, better: usize| {
        clearly_better(&sets[worse].candidate, &sets[better].candidate, floor)
    };
    let size = |sets: &[Lean], i: usize| sets[i].candidate.effects.len();
    // Those that are better on all runs were refused for another reason, which a split does not know.
    let rivals: Vec<usize> = others.iter().copied().filter(|&i| !better(sets, named, i)).collect();
    let own = size(sets, named);
    let smaller: Vec<usize> =
        rivals.iter().copied().filter(|&i| size(sets, i) < own && better(sets, i, named)).collect();
    let runs = sets.get(named)?.runs.len();
    let mut splits = Vec::new();
    for left_out in 0..runs {
        sets.iter_mut().for_each(|set| set.without(left_out));
        let least = |of: &mut dyn Iterator<Item = usize>| {
            of.min_by(|&a, &b| sets[a].mean_square().total_cmp(&sets[b].mean_square()))
        };
        let over = least(&mut rivals.iter().copied().filter(|&i| better(sets, named, i)));
        let enough = || least(&mut smaller.iter().copied().filter(|&i| !better(sets, i, named)));
        splits.push(Split { left_out, chosen: over.or_else(enough).unwrap_or(named) });
    }
    sets.iter_mut().for_each(Lean::with_all);
    Some(splits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Block, Data};
    use crate::fit::{FitOptions, fit};
    use crate::toy::{Toy, campaign, run};
    use crate::{Campaign, Role};
    use sealegs_model::{Excitation, Model};

    const TRUTH: [f64; 3] = [1.1, 5.0, 380.0];
    const NOISE: (f64, f64) = (0.2, 0.001);

    fn toy() -> Campaign {
        let runs = (0..3).map(|seed| (Role::Fit, run(&TRUTH, 400, seed, NOISE, (1.0, 0.0), 1.0)));
        campaign(runs.collect(), NOISE)
    }

    /// A set of the toy's with so many effects, and the mean squares that it leaves of each run.
    fn set(campaign: &Campaign, effects: &[&str], mean_squares: [f64; 3]) -> Candidate {
        let mut model: Box<dyn Model> = Box::new(Toy::new());
        if !effects.is_empty() {
            model = model.with_effect("cubic-sensor", &Excitation::default()).unwrap();
        }
        let data = Data::new(campaign, Some(Role::Fit), model.as_ref()).unwrap();
        let options = FitOptions { starts: 1, max_steps: 3, ..FitOptions::default() };
        let fitted = fit(&data, model.as_ref(), &options).unwrap();
        let ids = effects.iter().map(|e| (*e).to_owned()).collect();
        let mut candidate = Candidate::exactly(&data, ids, model, fitted);
        let blocks = &mut candidate.fit.evaluation.blocks;
        for Block { run, residual, .. } in blocks.iter_mut() {
            residual.fill(mean_squares[*run].sqrt());
        }
        let squares = |run: usize| -> f64 {
            let own = blocks.iter().filter(|b| b.run == run).flat_map(|b| &b.residual);
            own.map(|r| r * r).sum()
        };
        candidate.validation.stretches = (0..3).map(squares).collect();
        candidate.fit.cost = 0.5 * candidate.validation.stretches.iter().sum::<f64>();
        candidate.fit.std_inflation = 1.0;
        candidate
    }

    fn found(tried: Vec<Candidate>, chosen: usize) -> Found {
        Found {
            chosen,
            tied: Vec::new(),
            same: Vec::new(),
            open: Vec::new(),
            promises: Vec::new(),
            laws: Vec::new(),
            rugged: Vec::new(),
            base_as_searched: tried[0].validation.clone(),
            tried,
        }
    }

    fn chosen(found: &Found, named: usize) -> Vec<usize> {
        splits(found, named, 1.0).unwrap().iter().map(|s| s.chosen).collect()
    }

    #[test]
    fn a_set_that_is_best_on_every_run_is_chosen_by_every_split() {
        let campaign = toy();
        let sets = vec![
            set(&campaign, &[], [9.0, 8.0, 10.0]),
            set(&campaign, &["friction"], [1.0, 1.0, 1.0]),
            set(&campaign, &["backlash"], [4.0, 4.0, 5.0]),
        ];
        assert_eq!(chosen(&found(sets, 1), 1), [1, 1, 1]);
    }

    #[test]
    fn a_split_without_the_run_that_decides_chooses_the_rival() {
        let campaign = toy();
        // Two runs speak for backlash; one, louder, for friction.
        let sets = vec![
            set(&campaign, &[], [9.0, 9.0, 30.0]),
            set(&campaign, &["friction"], [2.0, 2.0, 1.0]),
            set(&campaign, &["backlash"], [1.0, 1.0, 6.0]),
        ];
        let mut found = found(sets, 1);
        assert_eq!(chosen(&found, 1), [1, 1, 2]);
        // A rival that is listed as a tie flips nothing.
        found.tied = vec![2];
        assert_eq!(chosen(&found, 1), [1, 1, 1]);
    }

    #[test]
    fn an_effect_that_one_run_alone_has_felt_is_not_needed_without_it() {
        let campaign = toy();
        let sets =
            vec![set(&campaign, &[], [1.0, 1.0, 20.0]), set(&campaign, &["friction"], [1.0, 1.0, 1.0])];
        assert_eq!(chosen(&found(sets, 1), 1), [1, 1, 0]);
    }

    #[test]
    fn a_base_model_that_leaves_nothing_is_chosen_by_every_split() {
        let campaign = toy();
        for (left, chose) in [(3.0, [0, 0, 1]), (1.0, [0, 0, 0])] {
            let mut base = set(&campaign, &[], [2.0, 2.0, 1.0]);
            base.fit.evaluation.rms = left;
            let sets = vec![base, set(&campaign, &["backlash"], [1.0, 1.0, 6.0])];
            assert_eq!(chosen(&found(sets, 0), 0), chose, "{left}");
        }
    }

    #[test]
    fn two_runs_are_too_few() {
        let mut campaign = toy();
        campaign.runs.truncate(2);
        let data = Data::new(&campaign, Some(Role::Fit), &Toy::new()).unwrap();
        let fitted = fit(&data, &Toy::new(), &FitOptions { max_steps: 3, ..FitOptions::default() }).unwrap();
        let base = Candidate::of_base(&data, &Toy::new(), fitted);
        assert_eq!(splits(&found(vec![base], 0), 0, 1.0), None);
    }
}
