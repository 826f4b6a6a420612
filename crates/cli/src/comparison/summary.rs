//! A comparison as JSON; the keys of `base` are those of `diagnose`.

use super::{Compared, worst_of_response};
use crate::diagnosis::outcome::{ParameterValue, SensorValue, parameters, sensors};
use crate::diagnosis::provenance::Provenance;
use sealegs_sysid::sanity::Finding;
use sealegs_sysid::{Role, residual};
use serde::Serialize;

/// Everything that is said of a comparison.
#[derive(Serialize)]
pub struct Summary {
    /// The campaign's name.
    pub campaign: String,
    /// The model's name.
    pub model: String,
    /// 1, or what repeats of runs leave between them, noise units.
    pub noise_floor: f64,
    /// Whether the refit was skipped.
    pub as_is: bool,
    /// One sentence.
    pub sentence: String,
    /// What seems wrong with the log itself.
    pub sanity: Vec<Finding>,
    /// Errors with the model file's own values.
    pub given: Errors,
    /// Errors and values after the refit; as given if there was none.
    pub base: Base,
    /// Pairs of parameters with a correlation of more than 0.9: names and value.
    pub correlations: Vec<(String, String, f64)>,
    /// By run and channel.
    pub channels: Vec<Line>,
    /// The worst regions as sentences.
    pub worst: Vec<String>,
    /// All regions.
    pub regions: Vec<Place>,
    /// Structure tests.
    pub structure: Vec<Dependence>,
    /// Frequency responses in one line each.
    pub frequency_responses: Vec<Response>,
    /// What runs with the same input leave between them, by channel, in the channel's unit.
    pub repeats: Vec<Repeat>,
    /// Remarks on the files.
    pub notes: Vec<String>,
    /// Simulations done.
    pub simulations: u64,
    /// Seconds of experiment that they covered.
    pub simulated_s: f64,
    /// Where it came from.
    pub provenance: Provenance,
}

/// Errors in noise units.
#[derive(Serialize)]
pub struct Errors {
    holdout_error: Option<f64>,
    fit_error: Option<f64>,
}

/// The base model.
#[derive(Serialize)]
pub struct Base {
    holdout_error: Option<f64>,
    fit_error: Option<f64>,
    parameters: Vec<ParameterValue>,
    sensors: Vec<SensorValue>,
}

/// One run and channel.
#[derive(Serialize)]
pub struct Line {
    run: String,
    role: &'static str,
    channel: String,
    rows: usize,
    error: f64,
    rms: f64,
    percent: f64,
    peak: f64,
    bias: f64,
}

/// One region.
#[derive(Serialize)]
pub struct Place {
    axis: String,
    label: String,
    sample_share: f64,
    error_share: f64,
    error: f64,
}

/// One structure test.
#[derive(Serialize)]
pub struct Dependence {
    on: &'static str,
    depends: bool,
    explained: f64,
    by_chance: f64,
    detail: Option<String>,
    suggests: &'static str,
}

/// A response's worst place.
#[derive(Serialize)]
pub struct Response {
    channel: String,
    input: String,
    worst_at_hz: Option<f64>,
    measured_over_model_db: Option<f64>,
}

/// A pair of runs.
#[derive(Serialize)]
pub struct Repeat {
    runs: (String, String),
    channel: String,
    deviation: f64,
    offset: f64,
}

impl Summary {
    /// Everything that is said of a comparison.
    #[must_use]
    pub fn new(compared: &Compared, provenance: Provenance) -> Self {
        let before = |role| compared.part(role).map(|p| p.before.rms);
        let shown = |role| compared.part(role).map(|p| p.shown().rms);
        let name = |i: usize| compared.campaign.runs[i].record.name.clone();
        let fit = compared.fit.as_ref();
        Self {
            campaign: compared.campaign.name.clone(),
            model: compared.model.clone(),
            noise_floor: compared.floor,
            as_is: fit.is_none(),
            sentence: compared.sentence(),
            sanity: compared.sanity.clone(),
            given: Errors { holdout_error: before(Role::Holdout), fit_error: before(Role::Fit) },
            base: Base {
                holdout_error: shown(Role::Holdout),
                fit_error: shown(Role::Fit),
                parameters: fit.map(parameters).unwrap_or_default(),
                sensors: fit.map(sensors).unwrap_or_default(),
            },
            correlations: fit.map_or_else(Vec::new, |f| {
                let name = |i: usize| f.parameters[i].name.clone();
                f.correlations(0.9).iter().map(|c| (name(c.first), name(c.second), c.value)).collect()
            }),
            channels: compared
                .parts
                .iter()
                .flat_map(|p| residual::table(&p.data, p.shown()))
                .map(|c| Line {
                    run: c.run,
                    role: c.role.as_str(),
                    channel: c.channel,
                    rows: c.rows,
                    error: c.error,
                    rms: c.rms,
                    percent: c.percent,
                    peak: c.peak,
                    bias: c.bias,
                })
                .collect(),
            worst: compared.location.worst(5).iter().map(|r| r.sentence()).collect(),
            regions: compared
                .location
                .regions
                .iter()
                .map(|r| Place {
                    axis: r.subject(),
                    label: r.label.clone(),
                    sample_share: r.sample_share,
                    error_share: r.error_share,
                    error: r.error,
                })
                .collect(),
            structure: compared
                .tests
                .iter()
                .map(|t| Dependence {
                    on: t.on,
                    depends: t.depends(),
                    explained: t.explained,
                    by_chance: t.by_chance,
                    detail: t.detail.clone(),
                    suggests: t.suggests,
                })
                .collect(),
            frequency_responses: compared
                .responses
                .iter()
                .map(|r| {
                    let worst = worst_of_response(r);
                    Response {
                        channel: r.channel.clone(),
                        input: r.input.clone(),
                        worst_at_hz: worst.map(|w| w.0),
                        measured_over_model_db: worst.map(|w| w.1),
                    }
                })
                .collect(),
            repeats: compared
                .campaign
                .repeats
                .iter()
                .map(|r| Repeat {
                    runs: (name(r.runs.0), name(r.runs.1)),
                    channel: r.channel.clone(),
                    deviation: r.deviation,
                    offset: r.offset,
                })
                .collect(),
            notes: compared.campaign.notes.clone(),
            simulations: compared.work.0,
            simulated_s: compared.work.1,
            provenance,
        }
    }
}
