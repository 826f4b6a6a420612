//! What a person and a program get of a diagnosis: JSON, text, report, recording, plan.

pub mod outcome;
pub mod progress;
pub mod provenance;
pub mod text;

use sealegs_model::Model;
use sealegs_sysid::Campaign;

/// The noise floor of a campaign in noise units: what repeats of a run leave between them, root mean square
/// over the channels that the model predicts; never below 1.
#[must_use]
pub fn floor(campaign: &Campaign, model: &dyn Model) -> f64 {
    let mut channels: Vec<(&str, f64, f64)> = Vec::new();
    for pair in campaign.repeats.iter().filter(|p| model.predicts(&p.channel)) {
        let Some(noise) = campaign.noise_std(&pair.channel) else { continue };
        let square = (pair.deviation / noise.std).powi(2);
        match channels.iter_mut().find(|(name, ..)| *name == pair.channel) {
            Some((_, sum, count)) => {
                *sum += square;
                *count += 1.0;
            }
            None => channels.push((&pair.channel, square, 1.0)),
        }
    }
    let mean = channels.iter().map(|(_, sum, count)| sum / count).sum::<f64>() / channels.len().max(1) as f64;
    if mean.is_finite() { mean.sqrt().max(1.0) } else { 1.0 }
}
