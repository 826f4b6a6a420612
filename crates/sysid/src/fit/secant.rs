//! Columns of derivatives without simulations: taken over from a fit nearby, and brought up to date by what each
//! step really changed (Broyden's update). Of a model with many parameters, where a set of columns costs a
//! simulation each, that is most of what a search needs; what it ends at is differentiated anew.

use super::Fit;
use super::coordinates::Coordinates;
use super::jacobian::{self, JacobianBlock, dot};
use crate::data::{Data, Evaluation};

/// Columns of derivatives by the parameters' names, from a fit nearby.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownColumns {
    names: Vec<String>,
    blocks: Vec<JacobianBlock>,
}

impl KnownColumns {
    /// Those of a fit.
    #[must_use]
    pub fn of(fit: &Fit) -> Self {
        let names = fit.free.iter().map(|&i| fit.parameters[i].name.clone()).collect();
        Self { names, blocks: fit.jacobian.clone() }
    }

    /// Which of the coordinates have a column here; none if these are not columns of the same data.
    fn places(&self, coordinates: &Coordinates, at: &Evaluation) -> Vec<Option<usize>> {
        let same = self.blocks.len() == at.blocks.len()
            && self.blocks.iter().zip(&at.blocks).all(|(k, b)| {
                (k.run, k.channel) == (b.run, b.channel)
                    && k.columns.first().is_none_or(|c| c.len() == b.residual.len())
            });
        let name = |k: usize| &coordinates.parameters[coordinates.free[k]].name;
        (0..coordinates.len()).map(|k| self.names.iter().position(|n| same && n == name(k))).collect()
    }

    /// Coordinates without a column here.
    pub(super) fn missing(&self, coordinates: &Coordinates, at: &Evaluation) -> Vec<usize> {
        let places = self.places(coordinates, at);
        (0..places.len()).filter(|&k| places[k].is_none()).collect()
    }

    /// Fills in the columns that are known.
    pub(super) fn fill(&self, coordinates: &Coordinates, at: &Evaluation, blocks: &mut [JacobianBlock]) {
        for (k, place) in self.places(coordinates, at).into_iter().enumerate() {
            let Some(place) = place else { continue };
            for (block, known) in blocks.iter_mut().zip(&self.blocks) {
                block.columns[k].clone_from(&known.columns[place]);
            }
        }
    }
}

/// Brings bare columns up to date after a step from `before` to `after`: the least change of the columns, each in
/// units of its usual difference, under which they would have predicted what the step did.
pub(super) fn update(
    columns: &mut [JacobianBlock],
    data: &Data,
    coordinates: &Coordinates,
    (before, u): (&Evaluation, &[f64]),
    (after, moved): (&Evaluation, &[f64]),
) {
    let step: Vec<f64> = u.iter().zip(moved).map(|(a, b)| b - a).collect();
    let weighed: Vec<f64> = (0..step.len()).map(|k| step[k] / coordinates.difference(k).powi(2)).collect();
    let size = dot(&step, &weighed);
    if size <= 0.0 || !size.is_finite() {
        return;
    }
    for run in 0..data.runs.len() {
        let real = jacobian::difference(
            data,
            before,
            run,
            (1.0, &after.predictions[run]),
            (0.0, &before.predictions[run]),
        );
        for (slot, real) in real.into_iter().enumerate() {
            let at = before.blocks.iter().position(|b| (b.run, b.slot) == (run, slot));
            let Some(block) = at.and_then(|i| columns.get_mut(i)) else { continue };
            let mut missed = real;
            for (column, s) in block.columns.iter().zip(&step) {
                missed.iter_mut().zip(column).for_each(|(m, c)| *m -= s * c);
            }
            for (column, w) in block.columns.iter_mut().zip(&weighed) {
                let share = w / size;
                column.iter_mut().zip(&missed).for_each(|(c, m)| *c += share * m);
            }
        }
    }
}
