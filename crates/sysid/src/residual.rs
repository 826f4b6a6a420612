//! Errors of a model, run by run and channel by channel, in noise units and in per cent.

use crate::data::{Block, Channel, Data, Evaluation};
use crate::{Role, stats};

/// The error of one run and channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelError {
    /// The run's name.
    pub run: String,
    /// Its role.
    pub role: Role,
    /// The channel.
    pub channel: String,
    /// Rows that count.
    pub rows: usize,
    /// Root mean square residual in noise units: 1 is the noise floor.
    pub error: f64,
    /// The same in the channel's unit.
    pub rms: f64,
    /// Mean absolute residual in the channel's unit.
    pub mean_absolute: f64,
    /// The root mean square in per cent of the measured signal's root mean square, the sensor's bias taken off.
    pub percent: f64,
    /// Greatest residual in noise units.
    pub peak: f64,
    /// The bias that this run was compared with, in the channel's unit.
    pub bias: f64,
}

/// One line for each run and channel, in the order of the data.
#[must_use]
pub fn table(data: &Data, at: &Evaluation) -> Vec<ChannelError> {
    at.blocks
        .iter()
        .map(|block| {
            let run = &data.runs[block.run];
            let channel = &data.channels[block.channel];
            let bias = at.sensors[block.channel].bias_of(block.run);
            let signal: Vec<f64> = run.rows().map(|i| run.measured[block.slot][i] - bias).collect();
            let error = stats::rms(&block.residual);
            let size = stats::rms(&signal);
            let rms = error * channel.noise_std;
            ChannelError {
                run: run.record.name.clone(),
                role: run.role,
                channel: channel.name.clone(),
                rows: block.residual.len(),
                error,
                rms,
                mean_absolute: mean_absolute(&block.residual) * channel.noise_std,
                percent: if size > 0.0 { 100.0 * rms / size } else { 0.0 },
                peak: block.residual.iter().fold(0.0f64, |p, r| p.max(r.abs())),
                bias,
            }
        })
        .collect()
}

/// The error of one channel over all its runs.
#[derive(Debug, Clone, PartialEq)]
pub struct PooledError {
    /// The channel, over all units.
    pub channel: String,
    /// Root mean square residual in noise units.
    pub error: f64,
    /// The same in the channel's unit.
    pub rms: f64,
    /// Mean absolute residual in the channel's unit.
    pub mean_absolute: f64,
}

fn mean_absolute(residual: &[f64]) -> f64 {
    residual.iter().map(|r| r.abs()).sum::<f64>() / residual.len().max(1) as f64
}

/// One line for each channel, in the order of the data.
#[must_use]
pub fn by_channel(data: &Data, at: &Evaluation) -> Vec<PooledError> {
    let of_channel = |(c, channel): (usize, &Channel)| {
        if data.channels[..c].iter().any(|earlier| earlier.name == channel.name) {
            return None;
        }
        let same = |b: &&Block| data.channels[b.channel].name == channel.name;
        let residuals: Vec<f64> =
            at.blocks.iter().filter(same).flat_map(|b| b.residual.iter().copied()).collect();
        let (error, noise_std) = (stats::rms(&residuals), channel.noise_std);
        let mean_absolute = mean_absolute(&residuals) * noise_std;
        Some(PooledError { channel: channel.name.clone(), error, rms: error * noise_std, mean_absolute })
    };
    data.channels.iter().enumerate().filter_map(of_channel).collect()
}

/// The error of some of the runs: root mean square of their residuals, in noise units; none without residuals.
#[must_use]
pub fn of_runs(at: &Evaluation, counts: impl Fn(usize) -> bool) -> Option<f64> {
    let residuals = || at.blocks.iter().filter(|b| counts(b.run)).flat_map(|b| &b.residual);
    let rows = residuals().count();
    (rows > 0).then(|| (residuals().map(|r| r * r).sum::<f64>() / rows as f64).sqrt())
}

/// The error over several evaluations together: root mean square of all residuals, in noise units.
#[must_use]
pub fn pooled(parts: &[&Evaluation]) -> f64 {
    let squares: f64 = parts.iter().map(|e| e.rms * e.rms * e.residuals() as f64).sum();
    let count: usize = parts.iter().map(|e| e.residuals()).sum();
    (squares / count.max(1) as f64).sqrt()
}
