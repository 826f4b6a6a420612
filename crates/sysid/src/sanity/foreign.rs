//! Whether the sensors follow the command column at all, by the model or by any linear filter of it.

use super::against::Seen;
use super::policy::{COHERENCE_SEGMENTS, EXCITED, LONGEST_SEGMENT, MODEL_FAILS};
use super::{Finding, Problem, Severity, finding};
use crate::frf::Welch;
use crate::{Campaign, resample, stats};
use sealegs_model::InputHold;

/// `near`: the share of each column's variance that the model leaves at the best offset that an effect could be.
pub(super) fn look(campaign: &Campaign, seen: &[Seen], near: &[f64]) -> Option<Finding> {
    let commanded = |s: &&Seen| campaign.runs[s.pair.run].record.inputs.len() == 1;
    let own: Vec<&Seen> = seen.iter().filter(commanded).collect();
    let channel = &campaign.runs[own.first()?.pair.run].record.inputs[0].channel;
    let cure = format!(
        "find the column that was commanded in these runs and call it `{channel}`; if it is already that one, check the load \
         (mass_kg, length_m) and look for an angle that wraps"
    );
    if own.iter().all(|s| !s.moves()) {
        // The model rests; so must the rig.
        let moved = own.iter().filter(|s| s.line.measured > 4.0 * EXCITED * s.pair.noise).count();
        let share = moved as f64 / own.len() as f64;
        let evidence =
            format!("under `{channel}` the model hardly moves, and {moved} of {} columns do", own.len());
        return finding(Problem::ForeignCommand, share, Severity::Stops, channel, evidence, cure);
    }
    // What has a finding of its own follows the command in its way.
    let judged = seen.iter().filter(|s| s.judged).count();
    if near.is_empty() || 2 * judged > near.len() {
        return None;
    }
    let by_model = stats::mean(near);
    if by_model < MODEL_FAILS {
        return None;
    }
    // A nominal model may be far off; then some other filter of the command does better.
    let coherent = coherent_share(campaign, &own)?;
    finding(
        Problem::ForeignCommand,
        1.0 - coherent,
        Severity::Stops,
        channel,
        format!(
            "the sensors do not follow `{channel}`: the model leaves {:.0} % of their variance, and no more than {:.0} % of \
             any column's is coherent with the command",
            100.0 * by_model,
            100.0 * coherent
        ),
        cure,
    )
}

/// The greatest share of a column's power that is coherent with the command, over all runs; what chance makes of a
/// finite number of segments is taken off.
fn coherent_share(campaign: &Campaign, own: &[&Seen]) -> Option<f64> {
    let mut channels: Vec<&str> = own.iter().map(|s| s.pair.channel).collect();
    channels.sort_unstable();
    channels.dedup();
    let periods: Vec<f64> = campaign.runs.iter().map(|r| r.clock.period_s).collect();
    let period = stats::median(&periods);
    let of_channel = |channel: &str| -> Option<f64> {
        let columns: Vec<(Vec<f64>, Vec<f64>)> = own
            .iter()
            .filter(|s| s.pair.channel == channel)
            .map(|s| {
                let record = &campaign.runs[s.pair.run].record;
                let even = |values: &[f64], hold| resample::uniform(&record.time_s, values, period, hold);
                let held = record.hold == InputHold::ZeroOrder;
                (even(&record.inputs[0].values, held), even(s.pair.measured, false))
            })
            .collect();
        let rows: usize = columns.iter().map(|c| c.0.len()).sum();
        let longest = columns.iter().map(|c| c.0.len()).max()?;
        let segment = (rows / COHERENCE_SEGMENTS).min(longest).clamp(2, LONGEST_SEGMENT);
        let pairs: Vec<(&[f64], &[f64])> =
            columns.iter().map(|(u, y)| (u.as_slice(), y.as_slice())).collect();
        let spectra = Welch::hann(segment).spectra(period, &pairs).ok()?;
        let lines = spectra.cross.iter().zip(&spectra.input);
        let followed: f64 = lines.filter(|(_, u)| **u > 0.0).map(|(c, u)| c.norm_sqr() / u).sum();
        let all: f64 = spectra.output.iter().sum();
        let chance = 1.0 / spectra.effective_averages.max(1.0 + 1e-9);
        (all > 0.0).then(|| ((followed / all - chance) / (1.0 - chance)).clamp(0.0, 1.0))
    };
    channels.into_iter().filter_map(of_channel).reduce(f64::max)
}
