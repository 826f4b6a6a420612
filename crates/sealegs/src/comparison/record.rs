//! A comparison as one recording.

use super::{Compared, Part};
use sealegs_model::Unit;
use sealegs_recorder::recording::{ComparedChannel, ComparedRun, Comparison};
use sealegs_sysid::data::DataRun;
use sealegs_sysid::{Evaluation, stats};

/// Which of a part's evaluations says where a recording opens.
type Judged = for<'p, 'a> fn(&'p Part<'a>) -> &'p Evaluation;

/// Measured, before and after, with the residuals, of every run. It opens where the evaluation `judged` is worst.
#[must_use]
pub fn of(compared: &Compared, summary_markdown: String, judged: Judged) -> Comparison {
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
                name: name_of(run),
                time_s: run.record.time_s.clone(),
                channels: (0..run.names.len())
                    .map(|slot| ComparedChannel {
                        name: run.names[slot].clone(),
                        unit: Unit::symbol_of(&run.names[slot]).to_owned(),
                        measured: run.measured[slot].to_vec(),
                        before: through(&part.before, slot),
                        after: part.after.as_ref().and_then(|at| through(at, slot)),
                        noise: part.data.channels[run.channels[slot]].noise_std,
                    })
                    .collect(),
            });
        }
    }
    // It opens on the first run and its first channel: the worst of the held-out runs.
    if let Some((run, channel)) = worst(compared, judged) {
        runs.sort_by_key(|r: &ComparedRun| r.name != run);
        for run in &mut runs {
            run.channels.sort_by_key(|c| c.name != channel);
        }
    }
    Comparison { name: compared.campaign.name.clone(), runs, summary_markdown }
}

/// A run's name in the recording.
fn name_of(run: &DataRun) -> String {
    format!("run-{:02} {} ({})", run.index + 1, run.record.name, run.role.as_str())
}

/// The run and channel with the greatest error among the held-out runs, or the fit runs if there are no others.
fn worst(compared: &Compared, judged: Judged) -> Option<(String, String)> {
    let part = compared.parts.last()?;
    let at = judged(part);
    let worst =
        at.blocks.iter().max_by(|a, b| stats::rms(&a.residual).total_cmp(&stats::rms(&b.residual)))?;
    let run = &part.data.runs[worst.run];
    Some((name_of(run), run.names[worst.slot].clone()))
}
