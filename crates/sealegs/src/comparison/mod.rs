//! Where a model fails on a campaign: what `sealegs compare` computes, apart from how it is shown.

pub(crate) mod overlay;
pub(crate) mod page;
mod record;
mod result;
mod summary;
pub(crate) mod text;

pub use page::of as page;
pub use record::of as recording;
pub use result::{Comparison, compare as of_campaign};
pub use summary::Summary;
pub use text::of as text;

use crate::Result;
use crate::campaign_model::CampaignModel;
use crate::diagnosis::bounds;
use crate::diagnosis::drift::Astray;
use crate::diagnosis::outcome::parameters;
use sealegs_model::Model;
use sealegs_sysid::campaign::Bench;
use sealegs_sysid::diagnose::fit_holding;
use sealegs_sysid::frequency::{self, ChannelResponse};
use sealegs_sysid::locate::{Location, locate};
use sealegs_sysid::nuisance::Sensor;
use sealegs_sysid::sanity::{self, Finding};
use sealegs_sysid::structure::{self, StructureTest};
use sealegs_sysid::{Campaign, Data, Evaluation, Fit, FitOptions, Role, residual};

/// Integration steps per sampling period of the fits of a robot that an exact one begins from: as a diagnosis searches, and finer.
const STEPS_PER_SAMPLE: [f64; 2] = [4.0, 16.0];

/// Most steps of such a fit: a model that is far from the log goes a long way, and each of its steps is cheap.
const MOST_STEPS: usize = 200;

/// The runs of one role with both evaluations.
pub struct Part<'a> {
    /// The role.
    pub role: Role,
    /// The runs.
    pub data: Data<'a>,
    /// With the model file's values and sensors.
    pub before: Evaluation,
    /// After the refit; `None` if there was none.
    pub after: Option<Evaluation>,
}

impl Part<'_> {
    /// The evaluation that is looked at: after the refit, if there was one.
    #[must_use]
    pub fn shown(&self) -> &Evaluation {
        self.after.as_ref().unwrap_or(&self.before)
    }
}

/// A comparison.
pub struct Compared<'a> {
    /// The campaign.
    pub campaign: &'a Campaign,
    /// The model's name.
    pub model: String,
    /// The error below which no model can be expected to come, noise units.
    pub floor: f64,
    /// The refit.
    pub fit: Option<Fit>,
    /// Fit runs, then holdout runs, as far as there are any.
    pub parts: Vec<Part<'a>>,
    /// What seems wrong with the log itself.
    pub sanity: Vec<Finding>,
    /// Where the residual is, all runs together.
    pub location: Location,
    /// What it depends on.
    pub tests: Vec<StructureTest>,
    /// Frequency responses, all runs together.
    pub responses: Vec<ChannelResponse>,
    /// Simulations done, and the seconds of experiment that they covered.
    pub work: (u64, f64),
}

/// What the residual depends on, what explains most of it first.
pub(crate) fn strongest(tests: &[StructureTest]) -> Vec<&StructureTest> {
    let mut found: Vec<&StructureTest> = tests.iter().filter(|t| t.depends()).collect();
    found.sort_by(|a, b| b.explained.total_cmp(&a.explained));
    found
}

/// Compares `model`; refits unless `as_is`. What its file says of the sensors comes from `stated`.
///
/// # Errors
///
/// Bad input if a refit is wanted and there is no fit run; otherwise if the model cannot be simulated.
pub fn compare<'a>(
    campaign: &'a Campaign,
    model: &dyn Model,
    stated: &dyn CampaignModel,
    as_is: bool,
) -> Result<Compared<'a>> {
    if !as_is {
        campaign.require(Role::Fit)?;
    }
    let nominal: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    let sensors = |data: &Data| -> Vec<Sensor> {
        data.channels
            .iter()
            .map(|c| {
                let known = stated.sensor(&c.name);
                Sensor {
                    channel: c.name.clone(),
                    unit: c.unit.clone(),
                    gain: known.and_then(|s| s.gain).unwrap_or(1.0),
                    gain_std: 0.0,
                    gain_at_limit: false,
                    at_limit: Vec::new(),
                    bias: known.and_then(|s| s.bias).unwrap_or(0.0),
                    bias_spread: known.and_then(|s| s.bias_spread).unwrap_or(0.0),
                    run_bias: Vec::new(),
                    prior_cost: 0.0,
                }
            })
            .collect()
    };
    let mut parts = Vec::new();
    let mut fitted: Option<Fit> = None;
    for role in [Role::Fit, Role::Holdout] {
        if campaign.runs_of(role).next().is_none() {
            continue;
        }
        let data = Data::new(campaign, Some(role), model)?;
        let before = data.judge(model, &nominal, &sensors(&data))?;
        let after = match (role, &fitted) {
            _ if as_is => None,
            (Role::Fit, _) => {
                let found = own_fit(campaign, &data, model)?;
                let evaluation = found.evaluation.clone();
                fitted = Some(found);
                Some(evaluation)
            }
            (Role::Holdout, Some(fit)) => Some(data.judge(model, &fit.values, fit.sensors())?),
            (Role::Holdout, None) => None,
        };
        parts.push(Part { role, data, before, after });
    }
    let work = parts.iter().map(|p| p.data.work()).fold((0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let seen: &dyn Model = model;
    let sanity = sanity::look(campaign, seen);
    Ok(Compared::of(campaign, model.name(), fitted, parts, sanity, work))
}

/// The model's own parameters fitted to the fit runs. Those of a robot with many joints are fitted with longer steps first, and from
/// there with its own: these change little, and each is many times as dear. Where they change nothing, that fit is the last.
fn own_fit(campaign: &Campaign, data: &Data, model: &dyn Model) -> Result<Fit> {
    let options = FitOptions { last: true, ..FitOptions::of(model) };
    if campaign.bench != Bench::Robot || !model.is_dear() {
        return Ok(fit_holding(data, model, &options)?);
    }
    let mut from = options.clone();
    for steps in STEPS_PER_SAMPLE {
        let (coarse, thorough) = (model.coarser(steps), FitOptions { max_steps: MOST_STEPS, ..from.clone() });
        // What cannot be simulated with longer steps is fitted with its own.
        let Ok(near) = fit_holding(data, coarse.as_ref(), &thorough) else { break };
        let exactly = data.evaluate(model, &near.values).map_or(f64::INFINITY, |e| e.cost);
        let nothing = options.tolerance * near.evaluation.rms.powi(2).max(1.0);
        let max_steps = if (exactly - near.cost).abs() < nothing { 0 } else { options.max_steps };
        from = FitOptions { start: Some(near.values), starts: 1, max_steps, ..options.clone() };
    }
    Ok(fit_holding(data, model, &from)?)
}

impl<'a> Compared<'a> {
    /// What is said of evaluations that are there already.
    pub(crate) fn of(
        campaign: &'a Campaign,
        model: String,
        fit: Option<Fit>,
        parts: Vec<Part<'a>>,
        sanity: Vec<Finding>,
        work: (u64, f64),
    ) -> Self {
        let shown: Vec<(&Data, &Evaluation)> = parts.iter().map(|p| (&p.data, p.shown())).collect();
        let (location, tests, responses) =
            (locate(&shown), structure::tests(&shown), frequency::responses(&shown));
        let floor = campaign.noise_floor();
        Self { campaign, model, floor, fit, parts, sanity, location, tests, responses, work }
    }
    /// The part of a role.
    #[must_use]
    pub fn part(&self, role: Role) -> Option<&Part<'a>> {
        self.parts.iter().find(|p| p.role == role)
    }

    /// Whether the model leaves no more than the noise of the last role's runs.
    pub(crate) fn is_at_floor(&self) -> bool {
        self.parts.last().is_some_and(|part| part.shown().rms <= 1.1 * self.floor.max(1.0))
    }

    /// The comparison in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Some(part) = self.parts.last() else { return String::new() };
        let error = part.shown().rms;
        let figure = crate::diagnosis::text::figures(error, 3);
        let what = if self.fit.is_some() { "after its own parameters were refitted" } else { "as it is" };
        let runs = if part.role == Role::Holdout { "held-out" } else { "fit" };
        let fitted = self.fit.as_ref().map_or_else(Vec::new, parameters);
        let first = bounds::sentence(&fitted).map_or_else(String::new, |first| format!("{first} "));
        let said = if self.is_at_floor() {
            format!("The model is at the noise floor {what}: {figure} noise units on the {runs} runs.")
        } else {
            format!(
                "The error on the {runs} runs is {figure} noise units {what}; the noise floor is {:.2}.",
                self.floor
            )
        };
        let left = residual::by_channel(&part.data, part.shown());
        let left = left.iter().map(|error| (error.channel.as_str(), error.rms));
        let astray = Astray::of(self.campaign, part.role, left)
            .map_or_else(String::new, |a| format!(" {}", a.advice()));
        first + &said + &astray
    }
}

/// A measured response against the model's: where they are coherent and differ by more than three standard
/// errors of the estimate, the greatest difference in magnitude, dB, after its frequency, Hz.
#[must_use]
pub fn worst_of_response(response: &ChannelResponse) -> Option<(f64, f64)> {
    let (m, p) = (&response.measured, &response.predicted);
    let error = m.relative_error();
    (0..m.frequency_hz.len().min(p.value.len()))
        .filter(|&i| (m.value[i] - p.value[i]).norm() > 3.0 * error[i] * m.value[i].norm())
        .filter(|&i| m.coherence[i] > 0.8 && m.frequency_hz[i] > 0.0 && p.value[i].norm() > 0.0)
        .map(|i| (m.frequency_hz[i], 20.0 * (m.value[i].norm() / p.value[i].norm()).log10()))
        .filter(|(_, db)| db.is_finite())
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
}
