//! What a fit leaves: noise, the error of the search's own steps, or something to explain; and what is too far behind.

use super::search::Search;
use super::{Candidate, with_effects};
use crate::data::Evaluation;

/// Error as a ratio of the floor below which nothing is looked for: a stated noise is rounded, an encoder's quantum
/// is not quite noise, and the search's steps are coarse.
pub(super) const AT_FLOOR: f64 = 1.01;

/// The same on what is left out, where every parameter costs a little.
pub(super) const NEAR_FLOOR: f64 = 1.05;

/// Error as a ratio of the floor beyond which the best set is suspected to be a poor fit before others are put beside it.
pub(super) const FAR_ABOVE: f64 = 1.2;

/// Mean squared difference of predictions with the search's steps and the model's own, in squared floors, above which
/// the search's are too coarse.
const TOO_COARSE: f64 = 0.1;

/// The same as a share of what is left, where that is much: what is missing makes nearly all of it, and finer steps
/// cost several times as much (where repeats differ by more than the noise, all sets leave much).
const PART_OF_IT: f64 = 0.05;

/// The same as a share of what is left, where that is little.
const MOST_OF_IT: f64 = 0.5;

/// Share of what the base model leaves below which a fit explains everything that its law can: another valley of the
/// same law would leave more.
const TRACE: f64 = 1e-5;

/// Error as a ratio of the least so far, where that is near the floor, beyond which a set is given up after its race.
const HOPELESS: f64 = 5.0;

/// Mean squared error above the floor, in squared noise units.
pub(super) fn excess(error: f64, floor: f64) -> f64 {
    (error.powi(2) - floor.powi(2)).max(0.0)
}

/// Mean squared difference of two evaluations' residuals.
pub(super) fn mean_square_difference(a: &Evaluation, b: &Evaluation) -> f64 {
    let (mut squares, mut rows) = (0.0, 0usize);
    for (a, b) in a.blocks.iter().zip(&b.blocks) {
        squares += a.residual.iter().zip(&b.residual).map(|(x, y)| (x - y).powi(2)).sum::<f64>();
        rows += a.residual.len();
    }
    squares / rows.max(1) as f64
}

impl Search<'_> {
    /// Goes on with the model's own steps where the search's are too coarse for a set (a play whose ends meet), or make
    /// most of the little that is left: the error that they leave would be explained by further effects.
    pub(super) fn refine_steps(&mut self, index: usize) {
        let candidate = &self.tried[index];
        let (error, floor) = (candidate.fit.error(), self.data.floor);
        if error <= AT_FLOOR * floor {
            return;
        }
        let much_is_left = error > FAR_ABOVE * floor;
        let excess = excess(error, floor);
        let most = if much_is_left {
            (TOO_COARSE * floor * floor).max(PART_OF_IT * excess)
        } else {
            MOST_OF_IT * excess
        };
        if self.step_error(candidate) <= most {
            return;
        }
        self.base = self.exact;
        self.refined = true;
        let candidate = &self.tried[index];
        if let Some(fitted) = self.fitted_near(candidate, &candidate.effects, &candidate.known()) {
            self.tried[index] = self.shaken(self.descended(fitted));
        }
    }

    /// Mean squared difference of a candidate's predictions with the search's steps and with the model's own; 0 where
    /// they are the same steps, or simulations are dear.
    fn step_error(&self, candidate: &Candidate) -> f64 {
        if self.options.secants || self.refined {
            return 0.0;
        }
        let exactly = with_effects(self.exact, &candidate.effects, self.seen)
            .and_then(|model| self.data.evaluate(model.as_ref(), &candidate.fit.values));
        let Ok(exactly) = exactly else { return 0.0 };
        mean_square_difference(&exactly, &candidate.fit.evaluation)
    }

    /// Whether a fit leaves no more than the noise and the error of the search's steps, or a trace of what the base model
    /// leaves: it rests in the right valley.
    pub(super) fn is_settled(&self, candidate: &Candidate) -> bool {
        let (error, floor) = (candidate.fit.error(), self.data.floor);
        let near = || error <= NEAR_FLOOR * floor && excess(error, floor) <= self.step_error(candidate);
        let trace = TRACE * excess(self.tried[0].fit.error(), floor);
        error <= AT_FLOOR * floor || excess(error, floor) <= trace || near()
    }

    /// Whether nothing is left to explain.
    pub(super) fn at_floor(&self, index: usize) -> bool {
        let left_out = self.tried[index].validation.mean_square().sqrt();
        self.tried[index].fit.error() <= AT_FLOOR * self.data.floor
            && left_out <= NEAR_FLOOR * self.data.floor
    }

    /// Whether a set is far behind a leader, or the best so far, that leaves next to nothing.
    pub(super) fn is_hopeless(&self, candidate: &Candidate, leader: f64) -> bool {
        let least = self.tried.iter().map(|c| c.fit.error()).fold(leader, f64::min);
        least <= FAR_ABOVE * self.data.floor && candidate.fit.error() > HOPELESS * least
    }
}
