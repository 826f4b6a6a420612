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
}

/// Derivatives by every free coordinate, block by block in the order of the evaluation's.
pub(crate) fn raw(
    data: &Data,
    model: &dyn Model,
    at: &Evaluation,
    coordinates: &Coordinates,
    u: &[f64],
    how: Difference,
) -> Vec<JacobianBlock> {
    let jobs: Vec<(usize, usize)> =
        (0..coordinates.len()).flat_map(|k| (0..data.runs.len()).map(move |run| (k, run))).collect();
    // For each job the columns of its run's channels; empty where neither side could be simulated.
    let columns: Vec<Vec<Vec<f64>>> = jobs
        .into_par_iter()
        .map(|(k, run)| {
            let shifted = |step: f64| -> Option<(f64, Prediction)> {
                let mut moved = u.to_vec();
                moved[k] += step;
                let values = coordinates.values(&moved, &at.values);
                let i = coordinates.free[k];
                let reached = coordinates.coordinate(k, values[i]) - u[k];
                if reached.abs() < 0.5 * step.abs() {
                    return None;
                }
                data.predict_run(run, model, &values).ok().map(|p| (reached, p))
            };
            let h = coordinates.difference(k);
            let up = shifted(h);
            let down = if how == Difference::Central || up.is_none() { shifted(-h) } else { None };
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
        .iter()
        .map(|block| JacobianBlock {
            run: block.run,
            channel: block.channel,
            columns: (0..coordinates.len())
                .map(|k| {
                    let job = &columns[k * data.runs.len() + block.run];
                    job.get(block.slot).cloned().unwrap_or_else(|| vec![0.0; block.residual.len()])
                })
                .collect(),
        })
        .collect()
}

/// Derivative of a run's residuals from predictions at two coordinates.
fn difference(
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

/// Takes out of the columns what the sensors' gain and bias can do in their place. `blocks` holds any
/// number of columns, in the order of `at.blocks`.
///
/// Sensor by sensor: the unknowns are the gain, the common bias and each run's bias, with their priors.
pub(crate) fn project(data: &Data, at: &Evaluation, blocks: &mut [JacobianBlock]) {
    let count = blocks.first().map_or(0, |b| b.columns.len());
    let done: Vec<(usize, Vec<Vec<f64>>)> = (0..data.channels.len())
        .into_par_iter()
        .flat_map_iter(|channel| {
            let mine: Vec<usize> = (0..blocks.len()).filter(|&i| blocks[i].channel == channel).collect();
            project_channel(data, at, blocks, channel, &mine, count)
        })
        .collect();
    for (i, columns) in done {
        blocks[i].columns = columns;
    }
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
    a[(0, 0)] = if free { prior.gain_std.powi(-2) } else { 1.0 };
    for (j, &i) in mine.iter().enumerate() {
        let k = 2 + j;
        let (gain, one) = &gains[j];
        let columns = &blocks[i].columns;
        let n = columns.first().map_or(0, Vec::len) as f64;
        a[(k, k)] = one * one * n + spread;
        a[(1, 1)] += spread;
        a[(1, k)] = -spread;
        a[(k, 1)] = -spread;
        for (c, column) in columns.iter().enumerate() {
            rhs[(k, c)] = one * column.iter().sum::<f64>();
        }
        if let Some(gain) = gain.as_ref().filter(|_| free) {
            a[(0, 0)] += dot(gain, gain);
            a[(0, k)] = one * gain.iter().sum::<f64>();
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
                let (g, b) = (taken[(0, c)], one * taken[(2 + j, c)]);
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
