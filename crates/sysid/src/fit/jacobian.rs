//! Sensitivities of the residual by finite differences, with the sensors' gain and bias projected out.
//!
//! For given model parameters the sensors are solved exactly, so that their columns (`prediction` for a
//! gain, `1` for a bias) can always take up a part of what a parameter does. What is left of a parameter's
//! column after that is what the data say about it (Kaufman's approximation of variable projection).

use super::coordinates::Coordinates;
use crate::data::{Data, Evaluation};
use crate::nuisance::SensorPrior;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use sealegs_model::{Model, Prediction};

/// Columns of derivatives of one run and channel's residual.
#[derive(Debug, Clone, PartialEq)]
pub struct JacobianBlock {
    /// Index of the run in the data.
    pub run: usize,
    /// Index of the channel in the data.
    pub channel: usize,
    /// One column a parameter, one row a scored sample: noise units a coordinate.
    pub columns: Vec<Vec<f64>>,
}

/// How derivatives are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Difference {
    /// One further simulation a parameter.
    Forward,
    /// Two.
    Central,
    /// None: what is known already, brought up to date by the steps since.
    Secant,
}

/// Where a finite difference moves the coordinates, and how its columns become those by the coordinates.
///
/// A simulation whose friction switches is smooth to a few thousandths of the noise only. That roughness, divided
/// by the step, looks like information, and most along combinations of parameters that the data hardly feel (a
/// common scale of all forces): each column alone is large there, and their sum should vanish. So once rough
/// columns are known, differences are taken along their principal directions, each with a step that changes
/// the residual as much as it should.
pub(crate) struct Directions {
    /// A move of all coordinates for each direction.
    moves: Vec<DVector<f64>>,
    /// Columns by coordinates = columns by direction times this.
    back: DMatrix<f64>,
}

/// Change of the residual, root mean square in noise units, that a difference should make beyond what the sensors
/// take up: forward, where the curvature counts, and central.
const CHANGE: [f64; 2] = [0.3, 1.0];

/// Change of the prediction, sensors aside, beyond which its curvature counts, as a multiple of that.
const BARE_CHANGE: f64 = 30.0;

impl Directions {
    /// One coordinate at a time, by its usual step.
    pub fn first(coordinates: &Coordinates) -> Self {
        let moves = Self::one_by_one(coordinates);
        Self { back: Self::back(&moves), moves }
    }

    fn one_by_one(coordinates: &Coordinates) -> Vec<DVector<f64>> {
        let n = coordinates.len();
        let unit =
            |k: usize| DVector::from_fn(n, |i, _| if i == k { coordinates.difference(k) } else { 0.0 });
        (0..n).map(unit).collect()
    }

    /// These coordinates alone, one at a time; the others' columns become 0.
    pub fn only(coordinates: &Coordinates, chosen: &[usize]) -> Self {
        let all = Self::one_by_one(coordinates);
        let n = all.len();
        let back =
            DMatrix::from_fn(chosen.len(), n, |j, k| if chosen[j] == k { 1.0 / all[k][k] } else { 0.0 });
        Self { moves: chosen.iter().map(|&k| all[k].clone()).collect(), back }
    }

    /// Along the principal directions of columns that were taken nearby (`raw`, and `projected` of what the
    /// sensors take up). What is close to a bound goes by itself.
    pub fn principal(
        coordinates: &Coordinates,
        u: &[f64],
        raw: &[JacobianBlock],
        projected: &[JacobianBlock],
        how: Difference,
    ) -> Self {
        let n = coordinates.len();
        let rows: usize = raw.iter().map(|b| b.columns.first().map_or(0, Vec::len)).sum();
        let (bare, own) = (gram(raw, n), gram(projected, n));
        let change = CHANGE[usize::from(how == Difference::Central)] * (rows as f64).sqrt();
        let wanted = |squares: f64, bare: f64| {
            (change / squares.max(0.0).sqrt()).min(BARE_CHANGE * change / bare.max(0.0).sqrt())
        };
        let mut moves = vec![DVector::zeros(n); n];
        let mut inner = Vec::new();
        for k in 0..n {
            let usual = coordinates.difference(k);
            let step = wanted(own[(k, k)], bare[(k, k)]).clamp(1e-3 * usual, 100.0 * usual);
            let step = if step.is_finite() { step } else { usual };
            moves[k][k] = step;
            let inside = |s: f64| {
                (coordinates.coordinate(k, coordinates.value(k, u[k] + s)) - u[k] - s).abs() < 1e-6 * step
            };
            if own[(k, k)] > 0.0 && inside(10.0 * step) && inside(-10.0 * step) {
                inner.push(k);
            }
        }
        // In units of each coordinate's own step, so that the eigenvectors do not depend on the scales.
        let m = inner.len();
        if m < 2 {
            return Self { back: Self::back(&moves), moves };
        }
        let size: Vec<f64> = inner.iter().map(|&k| moves[k][k]).collect();
        let of =
            |a: &DMatrix<f64>| DMatrix::from_fn(m, m, |i, j| a[(inner[i], inner[j])] * size[i] * size[j]);
        let (own, bare) = (of(&own), of(&bare));
        if own.iter().any(|v| !v.is_finite()) {
            return Self::first(coordinates);
        }
        let eigen = own.symmetric_eigen();
        for (j, &k) in inner.iter().enumerate() {
            let v = eigen.eigenvectors.column(j);
            let farthest = 10.0 / v.amax();
            let step = wanted(eigen.eigenvalues[j], v.dot(&(&bare * v))).min(farthest);
            moves[k] = DVector::zeros(n);
            for (i, &l) in inner.iter().enumerate() {
                moves[k][l] = step * size[i] * v[i];
            }
        }
        Self { back: Self::back(&moves), moves }
    }

    fn back(moves: &[DVector<f64>]) -> DMatrix<f64> {
        let n = moves.len();
        let across = DMatrix::from_fn(n, n, |i, j| moves[j][i]);
        across.try_inverse().unwrap_or_else(|| DMatrix::identity(n, n))
    }
}

/// `J'J` over all blocks.
pub(super) fn gram(blocks: &[JacobianBlock], n: usize) -> DMatrix<f64> {
    let mut a = DMatrix::zeros(n, n);
    for block in blocks {
        for k in 0..n {
            for l in k..n {
                a[(k, l)] += dot(&block.columns[k], &block.columns[l]);
                a[(l, k)] = a[(k, l)];
            }
        }
    }
    a
}

/// Derivatives by every free coordinate, block by block in the order of the evaluation's.
pub(crate) fn raw(
    data: &Data,
    model: &dyn Model,
    at: &Evaluation,
    coordinates: &Coordinates,
    u: &[f64],
    how: Difference,
    along: &Directions,
) -> Vec<JacobianBlock> {
    let (count, moves) = (coordinates.len(), along.moves.len());
    let jobs: Vec<(usize, usize)> =
        (0..moves).flat_map(|k| (0..data.runs.len()).map(move |run| (k, run))).collect();
    // For each job the columns of its run's channels; empty where neither side could be simulated.
    let columns: Vec<Vec<Vec<f64>>> = jobs
        .into_par_iter()
        .map(|(k, run)| {
            let record = data.runs[run].record;
            if !(0..count).any(|l| along.moves[k][l] != 0.0 && model.concerns(coordinates.free[l], record)) {
                return Vec::new();
            }
            // How far along the direction a move gets inside the bounds, 1 being all the way, and what comes of it.
            let shifted = |times: f64| -> Option<(f64, Prediction)> {
                let moved: Vec<f64> =
                    u.iter().zip(along.moves[k].iter()).map(|(x, m)| x + times * m).collect();
                let values = coordinates.values(&moved, &at.values);
                let (most, reached) = (0..count).fold((0.0, 0.0), |(most, reached), l| {
                    let wanted: f64 = along.moves[k][l];
                    let got = coordinates.coordinate(l, values[coordinates.free[l]]) - u[l];
                    if wanted.abs() > most { (wanted.abs(), got / wanted) } else { (most, reached) }
                });
                if most == 0.0 || (reached * times) < 0.5 {
                    return None;
                }
                data.predict_outputs_of_run(run, model, &values).ok().map(|p| (reached, p))
            };
            let up = shifted(1.0);
            let down = if how == Difference::Central || up.is_none() { shifted(-1.0) } else { None };
            let here = (0.0, &at.predictions[run]);
            let (a, b) = match (&up, &down) {
                (Some(up), Some(down)) => ((up.0, &up.1), (down.0, &down.1)),
                (Some(up), None) => ((up.0, &up.1), here),
                (None, Some(down)) => (here, (down.0, &down.1)),
                (None, None) => return Vec::new(),
            };
            difference(data, at, run, a, b)
        })
        .collect();
    at.blocks
        .par_iter()
        .map(|block| {
            let by_direction: Vec<Option<&Vec<f64>>> =
                (0..moves).map(|k| columns[k * data.runs.len() + block.run].get(block.slot)).collect();
            JacobianBlock {
                run: block.run,
                channel: block.channel,
                columns: (0..count)
                    .map(|k| {
                        let mut column = vec![0.0; block.residual.len()];
                        for (j, by) in by_direction.iter().enumerate() {
                            let share = along.back[(j, k)];
                            if let Some(by) = by.filter(|_| share != 0.0) {
                                column.iter_mut().zip(by).for_each(|(c, v)| *c += share * v);
                            }
                        }
                        column
                    })
                    .collect(),
            }
        })
        .collect()
}

/// Derivative of a run's residuals from predictions at two coordinates, the sensors as they are.
pub(super) fn difference(
    data: &Data,
    at: &Evaluation,
    run: usize,
    a: (f64, &Prediction),
    b: (f64, &Prediction),
) -> Vec<Vec<f64>> {
    let r = &data.runs[run];
    r.channels
        .iter()
        .zip(&r.names)
        .map(|(&c, name)| {
            let (Some(pa), Some(pb)) = (a.1.output(name), b.1.output(name)) else { return Vec::new() };
            let factor = -at.sensors[c].gain / (data.channels[c].noise_std * (a.0 - b.0));
            r.rows().map(|i| factor * (pa[i] - pb[i])).collect()
        })
        .collect()
}

/// The columns that a channel's sensor can take up in one block: gain (unless fixed or at its limit)
/// and bias, in noise units.
fn sensor_columns(data: &Data, at: &Evaluation, run: usize, channel: usize) -> (Option<Vec<f64>>, f64) {
    let per_noise = 1.0 / data.channels[channel].noise_std;
    let free = data.channels[channel].prior.gain_std > 0.0 && !at.sensors[channel].gain_at_limit;
    let predicted = at.predictions[run].output(&data.channels[channel].name).filter(|_| free);
    (predicted.map(|p| data.runs[run].rows().map(|i| -p[i] * per_noise).collect()), -per_noise)
}

/// The columns without what the sensors' gain and bias can do in their place. `blocks` holds any number of columns,
/// in the order of `at.blocks`.
///
/// Sensor by sensor: the unknowns are the gain, the common bias and each run's bias, with their priors.
pub(crate) fn projected(data: &Data, at: &Evaluation, blocks: &[JacobianBlock]) -> Vec<JacobianBlock> {
    let count = blocks.first().map_or(0, |b| b.columns.len());
    let done: Vec<(usize, Vec<Vec<f64>>)> = (0..data.channels.len())
        .into_par_iter()
        .flat_map_iter(|channel| {
            let mine: Vec<usize> = (0..blocks.len()).filter(|&i| blocks[i].channel == channel).collect();
            project_channel(data, at, blocks, channel, &mine, count)
        })
        .collect();
    let mut columns = vec![Vec::new(); blocks.len()];
    for (i, projected) in done {
        columns[i] = projected;
    }
    let with = |(b, columns): (&JacobianBlock, _)| JacobianBlock { run: b.run, channel: b.channel, columns };
    blocks.iter().zip(columns).map(with).collect()
}

fn project_channel(
    data: &Data,
    at: &Evaluation,
    blocks: &[JacobianBlock],
    channel: usize,
    mine: &[usize],
    count: usize,
) -> Vec<(usize, Vec<Vec<f64>>)> {
    let prior: SensorPrior = data.channels[channel].prior;
    let size = 2 + mine.len();
    let mut a = DMatrix::<f64>::zeros(size, size);
    let mut rhs = DMatrix::<f64>::zeros(size, count);
    let spread = prior.run_bias_std.powi(-2);
    a[(1, 1)] = prior.bias_std.powi(-2);
    let gains: Vec<(Option<Vec<f64>>, f64)> =
        mine.iter().map(|&i| sensor_columns(data, at, blocks[i].run, channel)).collect();
    let free = gains.iter().all(|(g, _)| g.is_some());
    // A run whose bias is held at its limit beside the common one moves with that.
    let held = |i: usize| at.sensors[channel].at_limit.contains(&blocks[i].run);
    let place = |j: usize, i: usize| if held(i) { 1 } else { 2 + j };
    a[(0, 0)] = if free { prior.gain_std.powi(-2) } else { 1.0 };
    for (j, &i) in mine.iter().enumerate() {
        let k = place(j, i);
        let (gain, one) = &gains[j];
        let columns = &blocks[i].columns;
        let n = columns.first().map_or(0, Vec::len) as f64;
        a[(k, k)] += one * one * n;
        if k == 1 {
            a[(2 + j, 2 + j)] = 1.0;
        } else {
            a[(k, k)] += spread;
            a[(1, 1)] += spread;
            a[(1, k)] = -spread;
            a[(k, 1)] = -spread;
        }
        for (c, column) in columns.iter().enumerate() {
            rhs[(k, c)] += one * column.iter().sum::<f64>();
        }
        if let Some(gain) = gain.as_ref().filter(|_| free) {
            a[(0, 0)] += dot(gain, gain);
            a[(0, k)] += one * gain.iter().sum::<f64>();
            a[(k, 0)] = a[(0, k)];
            for (c, column) in columns.iter().enumerate() {
                rhs[(0, c)] += dot(gain, column);
            }
        }
    }
    let Some(cholesky) = a.cholesky() else {
        return mine.iter().map(|&i| (i, blocks[i].columns.clone())).collect();
    };
    let taken = cholesky.solve(&rhs);
    mine.iter()
        .enumerate()
        .map(|(j, &i)| {
            let (gain, one) = &gains[j];
            let columns = blocks[i].columns.iter().enumerate().map(|(c, column)| {
                let (g, b) = (taken[(0, c)], one * taken[(place(j, i), c)]);
                match gain.as_ref().filter(|_| free) {
                    Some(gain) => column.iter().zip(gain).map(|(v, p)| v - g * p - b).collect(),
                    None => column.iter().map(|v| v - b).collect(),
                }
            });
            (i, columns.collect())
        })
        .collect()
}

/// `J'J` and `J'r` over all blocks, each block in parallel, summed in their order.
pub(crate) fn normal(
    blocks: &[JacobianBlock],
    raw: &[JacobianBlock],
    at: &Evaluation,
) -> (DMatrix<f64>, DVector<f64>) {
    let count = blocks.first().map_or(0, |b| b.columns.len());
    let parts: Vec<(DMatrix<f64>, DVector<f64>)> = (0..blocks.len())
        .into_par_iter()
        .map(|i| {
            let mut a = DMatrix::zeros(count, count);
            let mut g = DVector::zeros(count);
            for k in 0..count {
                // Half projected: J' (1 - Z (Z'Z + prior)^-1 Z') J counts the sensors' priors in.
                for l in 0..count {
                    a[(k, l)] = dot(&blocks[i].columns[k], &raw[i].columns[l]);
                }
                g[k] = dot(&raw[i].columns[k], &at.blocks[i].residual);
            }
            (a, g)
        })
        .collect();
    let mut a = DMatrix::zeros(count, count);
    let mut g = DVector::zeros(count);
    for (pa, pg) in &parts {
        a += pa;
        g += pg;
    }
    let symmetric = (&a + a.transpose()) * 0.5;
    (symmetric, g)
}

/// The scalar product, in the order of the samples, in eight strands that the processor adds in parallel.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut strands = [0.0; 8];
    let (ca, cb) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f64 = ca.remainder().iter().zip(cb.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in ca.zip(cb) {
        for i in 0..8 {
            strands[i] += x[i] * y[i];
        }
    }
    strands.iter().sum::<f64>() + tail
}
