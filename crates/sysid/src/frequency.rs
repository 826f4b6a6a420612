//! Frequency responses of a campaign's runs, measured against model, on the same grid and estimate.
//!
//! The model's prediction passes through the same resampling, windows and averages as the measurement, so
//! that leakage and hold are alike on both sides and what differs is the model's error.

use crate::data::{Data, Evaluation};
use crate::frf::{Estimator, FrequencyResponse, Welch};
use crate::{resample, stats};
use sealegs_model::InputHold;

/// A channel's response to the input, measured and predicted.
#[derive(Debug, Clone)]
pub struct ChannelResponse {
    /// The output channel.
    pub channel: String,
    /// The input channel.
    pub input: String,
    /// From measurements, with coherence.
    pub measured: FrequencyResponse,
    /// From predictions through the fitted sensor, by the same estimate.
    pub predicted: FrequencyResponse,
}

/// Samples in a segment: at least 16 segments a campaign, at most 4096 samples.
const LONGEST_SEGMENT: usize = 4096;
const SHORTEST_SEGMENT: usize = 256;

/// H1 responses of every channel over one or several evaluations; channels of runs that are too short for
/// any segment are left out.
#[must_use]
pub fn responses(parts: &[(&Data, &Evaluation)]) -> Vec<ChannelResponse> {
    let mut names: Vec<&str> = Vec::new();
    for channel in parts.iter().flat_map(|(d, _)| &d.channels) {
        if !names.contains(&channel.name.as_str()) {
            names.push(&channel.name);
        }
    }
    let periods: Vec<f64> =
        parts.iter().flat_map(|(d, _)| &d.runs).map(|r| stats::median_period(&r.record.time_s)).collect();
    let period = stats::median(&periods);
    names.into_iter().filter_map(|name| response(parts, name, period)).collect()
}

fn response(parts: &[(&Data, &Evaluation)], name: &str, period: f64) -> Option<ChannelResponse> {
    let mut columns: Vec<(Vec<f64>, Vec<f64>, Vec<f64>)> = Vec::new();
    let mut input_name = String::new();
    for (data, at) in parts {
        for (run, prediction) in data.runs.iter().zip(&at.predictions) {
            let Some(slot) = run.names.iter().position(|n| n == name) else { continue };
            let (Some(input), Some(predicted)) = (run.record.inputs.first(), prediction.output(name)) else {
                continue;
            };
            input_name.clone_from(&input.channel);
            let sensor = &at.sensors[run.channels[slot]];
            // Band-limited noise would be resampled badly across a gap; the scored rows are what counts.
            let time: Vec<f64> = run.rows().map(|i| run.record.time_s[i]).collect();
            let pick = |values: &[f64]| -> Vec<f64> { run.rows().map(|i| values[i]).collect() };
            let hold = run.record.hold == InputHold::ZeroOrder;
            let u = resample::uniform(&time, &pick(&input.values), period, hold);
            let y = resample::uniform(&time, &pick(run.measured[slot]), period, false);
            let p: Vec<f64> = pick(predicted).iter().map(|v| sensor.gain * v).collect();
            columns.push((u, y, resample::uniform(&time, &p, period, false)));
        }
    }
    let total: usize = columns.iter().map(|c| c.0.len()).sum();
    let longest = columns.iter().map(|c| c.0.len()).max()?;
    let mut segment = LONGEST_SEGMENT;
    while segment > SHORTEST_SEGMENT && (segment > longest || segment * 8 > total) {
        segment /= 2;
    }
    let welch = Welch::hann(segment);
    let estimate =
        |pairs: Vec<(&[f64], &[f64])>| welch.spectra(period, &pairs).ok().map(|s| s.response(Estimator::H1));
    let measured = estimate(columns.iter().map(|(u, y, _)| (u.as_slice(), y.as_slice())).collect())?;
    let predicted = estimate(columns.iter().map(|(u, _, p)| (u.as_slice(), p.as_slice())).collect())?;
    Some(ChannelResponse { channel: name.to_owned(), input: input_name, measured, predicted })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::Role;
    use crate::fit::{Difference, at_values};
    use crate::toy::{Toy, campaign, run};

    #[test]
    fn a_right_model_has_the_measured_response_where_they_are_coherent() {
        let truth = [1.0, 4.0, 400.0];
        let noise = (0.2, 0.001);
        let record = run(&truth, 8000, 5, noise, (1.0, 0.0), 1.0);
        let campaign = campaign(vec![(Role::Fit, record)], noise);
        let toy = Toy::new();
        let data = Data::new(&campaign, None, &toy).unwrap();
        let at = at_values(&data, &toy, &truth, Difference::Forward).unwrap().evaluation;
        let all = responses(&[(&data, &at)]);
        assert_eq!(all.len(), 2);
        let force = all.iter().find(|r| r.channel == "force_1_n").unwrap();
        let mut compared = 0;
        for (i, &coherence) in force.measured.coherence.iter().enumerate() {
            if coherence > 0.95 {
                let ratio = (force.measured.value[i] / force.predicted.value[i]).norm();
                assert!((ratio - 1.0).abs() < 0.1, "{} Hz: {ratio}", force.measured.frequency_hz[i]);
                compared += 1;
            }
        }
        assert!(compared > 5);
    }
}
