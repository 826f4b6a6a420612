//! A comparison as JSON; the keys of `base` are those of `diagnose`.

use super::{Compared, worst_of_response};
use crate::diagnosis::outcome::{ForceSaid, MissingSignal, ParameterValue, SensorValue, parameters, sensors};
use crate::diagnosis::provenance::Provenance;
use crate::diagnosis::units::Units;
use schemars::JsonSchema;
use sealegs_sysid::diagnose::Port;
use sealegs_sysid::sanity::Finding;
use sealegs_sysid::{Role, residual};
use serde::Serialize;

/// Everything that is said of a comparison.
#[derive(Debug, Clone, Serialize, JsonSchema)]
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
    /// What became of each unit, where the campaign has several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<Units>,
    /// Pairs of parameters with a correlation of more than 0.9: names and value.
    pub correlations: Vec<(String, String, f64)>,
    /// What is missing at each port, before anything is searched; the most important first, as in `diagnose`. Empty where
    /// the fit runs measure no motion that could be followed.
    pub missing_signals: Vec<MissingSignal>,
    /// The first of them that depends on something, over what it depends on.
    pub missing_force: Option<ForceSaid>,
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
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Errors {
    /// Root mean square residual of the holdout runs, noise units.
    pub holdout_error: Option<f64>,
    /// The same of the fit runs.
    pub fit_error: Option<f64>,
}

/// The base model.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Base {
    /// Root mean square residual of the holdout runs, noise units.
    pub holdout_error: Option<f64>,
    /// The same of the fit runs.
    pub fit_error: Option<f64>,
    /// The fitted parameters.
    pub parameters: Vec<ParameterValue>,
    /// The fitted sensors.
    pub sensors: Vec<SensorValue>,
}

/// One run and channel.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Line {
    /// The run's file name.
    pub run: String,
    /// `fit` or `holdout`.
    pub role: &'static str,
    /// The channel.
    pub channel: String,
    /// Rows that count.
    pub rows: usize,
    /// Root mean square residual, noise units.
    pub error: f64,
    /// The same in the channel's unit.
    pub rms: f64,
    /// Mean absolute residual, in the same unit.
    pub mean_absolute: f64,
    /// The root mean square in per cent of the measured channel's root mean square, the sensor's bias taken off.
    pub percent: f64,
    /// Greatest magnitude of the residual, noise units.
    pub peak: f64,
    /// The sensor's bias that this run was compared with, in the channel's unit.
    pub bias: f64,
}

/// One region.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Place {
    /// What the data were divided by.
    pub axis: String,
    /// The part.
    pub label: String,
    /// Share of the samples, 0 to 1.
    pub sample_share: f64,
    /// Share of the squared error, 0 to 1.
    pub error_share: f64,
    /// Root mean square residual, noise units.
    pub error: f64,
}

/// One structure test.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Dependence {
    /// What the residual may depend on.
    pub on: &'static str,
    /// Whether it does, more than chance allows.
    pub depends: bool,
    /// Share of its square that is explained, 0 to 1.
    pub explained: f64,
    /// The share that chance would explain.
    pub by_chance: f64,
    /// Where or how.
    pub detail: Option<String>,
    /// What that suggests.
    pub suggests: &'static str,
}

/// A response's worst place.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Response {
    /// The channel.
    pub channel: String,
    /// The input channel.
    pub input: String,
    /// Frequency of the greatest difference beyond three standard errors, Hz.
    pub worst_at_hz: Option<f64>,
    /// That difference, dB.
    pub measured_over_model_db: Option<f64>,
}

/// A pair of runs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Repeat {
    /// The runs' file names.
    pub runs: (String, String),
    /// The channel.
    pub channel: String,
    /// One run's own deviation, in the channel's unit.
    pub deviation: f64,
    /// Mean difference, in the channel's unit.
    pub offset: f64,
}

impl Summary {
    /// Everything that is said of a comparison.
    #[must_use]
    pub fn new(compared: &Compared, ports: &[Port], provenance: Provenance) -> Self {
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
            units: Units::of_comparison(compared),
            correlations: fit.map_or_else(Vec::new, |f| {
                let name = |i: usize| f.parameters[i].name.clone();
                f.correlations(0.9).iter().map(|c| (name(c.first), name(c.second), c.value)).collect()
            }),
            missing_signals: ports.iter().map(MissingSignal::of).collect(),
            missing_force: ForceSaid::of_ports(ports),
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
                    mean_absolute: c.mean_absolute,
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
