//! A comparison as one recording.

use super::Compared;
use sealegs_recorder::recording::{ComparedChannel, ComparedRun, Comparison};
use sealegs_sysid::Evaluation;

/// Measured, as given and refitted, with the residuals, of every run.
#[must_use]
pub fn of(compared: &Compared, summary_markdown: String) -> Comparison {
    let mut runs = Vec::new();
    for part in &compared.parts {
        for (i, run) in part.data.runs.iter().enumerate() {
            let through = |at: &Evaluation, slot: usize| -> Option<Vec<f64>> {
                let sensor = &at.sensors[run.channels[slot]];
                let bias = sensor.bias_of(i);
                let predicted = at.predictions[i].output(&run.names[slot])?;
                Some(predicted.iter().map(|p| sensor.gain * p + bias).collect())
            };
            runs.push(ComparedRun {
                name: format!("run-{:02} {} ({})", run.index + 1, run.record.name, run.role.as_str()),
                time_s: run.record.time_s.clone(),
                channels: (0..run.names.len())
                    .map(|slot| ComparedChannel {
                        name: run.names[slot].clone(),
                        unit: super::text::unit(&run.names[slot]).to_owned(),
                        measured: run.measured[slot].to_vec(),
                        before: through(&part.before, slot),
                        after: part.after.as_ref().and_then(|at| through(at, slot)),
                    })
                    .collect(),
            });
        }
    }
    Comparison { name: compared.campaign.name.clone(), runs, summary_markdown }
}
