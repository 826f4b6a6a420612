//! A diagnosis in the data contract's words: what `--json` writes and what text and report print.

use super::confidence::Confidence;
use super::drift::Astray;
use super::law::LawSaid;
use super::sentence::sentence;
pub use super::signals::{BranchSaid, CurveSaid, ForceSaid, MissingSignal, Share};
use super::splits::Splits;
use super::units::Units;
use schemars::JsonSchema;
use sealegs_actuator::spec::is_assumed_bound;
use sealegs_model::Unit;
use sealegs_sysid::campaign::Bench;
use sealegs_sysid::diagnose::{Candidate, Diagnosis, Judged, OpenChoice, VerdictKind};
use sealegs_sysid::sanity::Finding;
use sealegs_sysid::{Campaign, Data, Fit, Role, residual};
use serde::Serialize;
use std::collections::BTreeMap;

/// What a diagnosis says of a base model; `added` where effects that were asked for were fitted, and nothing was searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OutcomeKind {
    /// It predicts the held-out runs to the noise floor.
    Adequate,
    /// The named effects explain what it does not.
    MissingEffect,
    /// The named effects help on the held-out runs, but something structured stays.
    PartlyExplained,
    /// No known effect helps on the held-out runs.
    Unexplained,
    /// The effects that were asked for were added to it.
    Added,
}

impl From<VerdictKind> for OutcomeKind {
    fn from(kind: VerdictKind) -> Self {
        match kind {
            VerdictKind::Adequate => Self::Adequate,
            VerdictKind::MissingEffect => Self::MissingEffect,
            VerdictKind::PartlyExplained => Self::PartlyExplained,
            VerdictKind::Unexplained => Self::Unexplained,
        }
    }
}

/// The contract's keys, and a few more.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Outcome {
    /// The campaign's name.
    pub campaign: String,
    /// The noise floor, in noise units.
    pub noise_floor: f64,
    /// The refitted base model.
    pub base: Side,
    /// What is said of the base model.
    pub verdict: OutcomeKind,
    /// The effects that are named.
    pub effects: Vec<String>,
    /// Other sets that these data cannot tell from them.
    pub indistinguishable: Vec<Vec<String>>,
    /// Sets of richer laws that fit as well because they are the named ones by another name: a departure would show.
    pub same_by_another_name: Vec<Vec<String>>,
    /// Conventions of the log that explain the fit runs as well, and the values that differ under them.
    pub equally_good_choices: Vec<Choice>,
    /// The model with the effects.
    pub after: Option<Side>,
    /// Part of the residual energy above the floor that is left.
    pub unexplained_share: f64,
    /// Errors from the base model to the named set, one effect after the other in the order of what they take.
    pub ladder: Vec<RungSaid>,
    /// Effects that help significantly and take less than 1 % of the base model's held-out error.
    pub traces: Vec<String>,
    /// What is missing at each port of the base model, before anything was searched; the greatest over its uncertainty
    /// first.
    pub missing_signals: Vec<MissingSignal>,
    /// The same beside the named effects, where they leave something.
    pub missing_after: Vec<MissingSignal>,
    /// What is missing at the most important port over what it depends on, with the named effects' law; none where the
    /// runs measure no motion that could be followed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub missing_force: Option<ForceSaid>,
    /// A curve that takes what no known effect takes, where something is left and one helps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<LawSaid>,
    /// What became of each unit, where the campaign has several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<Units>,
    /// How the choice changes when fit runs are left out, where there are three or more and something was chosen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub splits: Option<Splits>,
    /// Sets by their prediction of left-out stretches, best first.
    pub ranking: Vec<Ranked>,
    /// Which experiment would tell more.
    pub next_experiment: String,
    /// The verdict in one sentence.
    pub sentence: String,
    /// How sure the verdict is, and why.
    pub confidence: Confidence,
    /// What is left and not explained: its frequency, what it follows, where it is largest; empty where nothing is left.
    pub remainder: Vec<String>,
    /// What seems wrong with the log itself; found before anything was fitted.
    pub sanity: Vec<Finding>,
    /// What else a reader should know: the files' oddities.
    pub notes: Vec<String>,
    /// What it cost.
    pub work: Work,
    /// Where the numbers come from.
    pub provenance: super::provenance::Provenance,
}

/// A convention under which the data are explained as well.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Choice {
    /// Parameters of the base model that are choices, with what is chosen.
    pub choices: BTreeMap<String, f64>,
    /// Values that differ by more than three standard errors then, each in its parameter's unit.
    pub parameters: BTreeMap<String, f64>,
}

impl Choice {
    fn of(open: &OpenChoice) -> Self {
        let by_name = |pairs: &[(String, f64)]| pairs.iter().cloned().collect();
        Self { choices: by_name(&open.choices), parameters: by_name(&open.values) }
    }
}

/// A model with its errors.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Side {
    /// Root mean square residual of the holdout runs, in noise units.
    pub holdout_error: f64,
    /// The same of the fit runs.
    pub fit_error: f64,
    /// Its parameters.
    pub parameters: Vec<ParameterValue>,
    /// Its sensors.
    pub sensors: Vec<SensorValue>,
    /// The errors of the holdout runs in the channels' own units; empty where nothing was held out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub channels: Vec<ChannelSaid>,
}

/// What a model leaves of a channel.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ChannelSaid {
    /// The channel.
    pub channel: String,
    /// Its unit.
    pub unit: String,
    /// Root mean square residual of the holdout runs, in that unit.
    pub holdout_rms: f64,
    /// Mean absolute residual of the holdout runs, in that unit.
    pub holdout_mean_absolute: f64,
    /// The root mean square in noise units.
    pub holdout_error: f64,
}

/// A step of the ladder.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct RungSaid {
    /// The effects so far.
    pub effects: Vec<String>,
    /// Root mean square residual of the holdout runs, in noise units.
    pub holdout_error: f64,
    /// The same of the fit runs.
    pub fit_error: f64,
}

/// A fitted parameter.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ParameterValue {
    /// Its name.
    pub name: String,
    /// Its value in its unit.
    pub value: f64,
    /// One standard error; 0 for a fixed one, none where the data say nothing at all or where it is withheld, see
    /// [`Outcome::new`].
    pub std: Option<f64>,
    /// The unit; empty for a ratio.
    pub unit: String,
    /// Not fitted.
    pub fixed: bool,
    /// It ended on a bound.
    pub at_bound: bool,
    /// The data say something about it.
    pub felt: bool,
    /// Its distance from the nominal value in standard deviations of what is known of it, if anything is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_nominal: Option<f64>,
    /// The nominal value of a base parameter that ended at a bound which no file states: half or one and a half of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub assumed_about: Option<f64>,
}

/// Standard deviations from a nominal value beyond which it is said: a wrong model, or a fit at rest in a wrong place, may
/// have driven a parameter there.
const FAR_FROM_NOMINAL: f64 = 3.0;

impl ParameterValue {
    /// Whether the value ended far from what is known of it.
    #[must_use]
    pub fn is_far(&self) -> bool {
        !self.fixed && self.from_nominal.is_some_and(|far| far.abs() > FAR_FROM_NOMINAL)
    }

    /// What a person should know of the value; empty where there is nothing.
    #[must_use]
    pub fn remark(&self) -> String {
        match (self.at_bound, self.felt, self.from_nominal) {
            (true, ..) if self.assumed_about.is_some() => "at a bound that no file states".to_owned(),
            (true, ..) => "at its bound".to_owned(),
            (_, false, _) => "not identifiable from these runs".to_owned(),
            _ if self.is_far() => {
                format!("{:.1} standard deviations from nominal", self.from_nominal.unwrap_or(0.0).abs())
            }
            _ => String::new(),
        }
    }
}

/// A sensor's fitted gain and bias.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SensorValue {
    /// The channel.
    pub channel: String,
    /// The unit whose sensor it is, where the campaign has several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of_unit: Option<String>,
    /// Measured per true.
    pub gain: f64,
    /// Its standard error.
    pub gain_std: f64,
    /// Common bias in the channel's unit.
    pub bias: f64,
    /// How far the runs' own biases scatter about it.
    pub bias_spread: f64,
}

/// A set in the ranking.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Ranked {
    /// The set.
    pub effects: Vec<String>,
    /// Root mean square residual of the holdout runs, in noise units.
    pub holdout_error: f64,
    /// Log-likelihood ratio against the base model on left-out stretches of the fit runs.
    pub evidence: f64,
    /// All parameters of the model with the set.
    pub parameters: Vec<ParameterValue>,
}

/// What a diagnosis cost.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct Work {
    /// Simulations.
    pub simulations: u64,
    /// Seconds of experiment that they covered.
    pub simulated_s: f64,
    /// Integration steps that they took; 0 where that was not counted.
    pub steps: u64,
    /// Whether the search was ended before it was done.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub ended_early: bool,
}

/// The parameters of a fit.
#[must_use]
pub fn parameters(fit: &Fit) -> Vec<ParameterValue> {
    fit.parameters
        .iter()
        .filter(|p| p.value.is_finite())
        .map(|p| ParameterValue {
            name: p.name.clone(),
            value: p.value,
            std: Some(p.std).filter(|s| s.is_finite()),
            unit: p.unit.clone(),
            fixed: p.fixed,
            at_bound: p.at_bound.is_some(),
            assumed_about: (p.at_bound.is_some()
                && !p.fixed
                && p.prior_std.is_none()
                && !p.name.contains('.')
                && is_assumed_bound(p.value / p.nominal))
            .then_some(p.nominal),
            felt: p.felt,
            from_nominal: p
                .prior_std
                .filter(|std| !p.fixed && *std > 0.0)
                .map(|std| (p.value - p.nominal) / std)
                .filter(|far| far.is_finite()),
        })
        .collect()
}

/// The sensors of a fit.
#[must_use]
pub fn sensors(fit: &Fit) -> Vec<SensorValue> {
    let finite = |v: f64| if v.is_finite() { v } else { 0.0 };
    fit.sensors()
        .iter()
        .map(|s| SensorValue {
            channel: s.channel.clone(),
            of_unit: s.unit.clone(),
            gain: finite(s.gain),
            gain_std: finite(s.gain_std),
            bias: finite(s.bias),
            bias_spread: finite(s.bias_spread),
        })
        .collect()
}

/// What is said of effects' parameters along which the error is rugged.
fn rugged_note(names: &[String]) -> Option<String> {
    (!names.is_empty()).then(|| {
        format!(
            "The error has many minima along {}: many values give about the same error, and the interval covers them all.",
            names.join(" and ")
        )
    })
}

/// The errors of the holdout runs, channel by channel.
fn channel_errors(
    campaign: &Campaign,
    candidate: &Candidate,
) -> Result<Vec<ChannelSaid>, sealegs_sysid::Error> {
    let (model, fit) = (candidate.model.as_ref(), &candidate.fit);
    let data = Data::new(campaign, Some(Role::Holdout), model)?;
    let left = data.judge(model, &fit.values, fit.sensors())?;
    let said = |e: residual::PooledError| ChannelSaid {
        unit: Unit::symbol_of(&e.channel).to_owned(),
        holdout_rms: e.rms,
        holdout_mean_absolute: e.mean_absolute,
        holdout_error: e.error,
        channel: e.channel,
    };
    Ok(residual::by_channel(&data, &left).into_iter().map(said).collect())
}

impl Outcome {
    /// Everything that is said of a diagnosis; the next experiment, whether the search was ended early and what is wrong with the log
    /// come from outside.
    ///
    /// Where something stays that the named effects do not explain, their intervals cover the values of the sets that
    /// predict as well; where a parameter of the base model ended at a bound or far from what is known, they are withheld.
    #[must_use]
    pub fn new(
        campaign: &Campaign,
        diagnosis: &Diagnosis,
        (next_experiment, ended_early): (String, bool),
        sanity: Vec<Finding>,
        provenance: super::provenance::Provenance,
    ) -> Self {
        let verdict = &diagnosis.verdict;
        let side = |judged: &Judged| {
            let fit = &diagnosis.found.tried[judged.index].fit;
            Side {
                holdout_error: judged.holdout_error,
                fit_error: fit.error(),
                parameters: parameters(fit),
                sensors: sensors(fit),
                channels: channel_errors(campaign, &diagnosis.found.tried[judged.index]).unwrap_or_default(),
            }
        };
        let named = matches!(verdict.kind, VerdictKind::MissingEffect | VerdictKind::PartlyExplained);
        let rugged = named.then(|| rugged_note(&diagnosis.found.rugged)).flatten();
        let mut outcome = Self {
            campaign: campaign.name.clone(),
            noise_floor: verdict.floor,
            base: side(&verdict.base),
            verdict: verdict.kind.into(),
            effects: verdict.effects.clone(),
            indistinguishable: verdict.indistinguishable.clone(),
            same_by_another_name: verdict.same_by_another_name.clone(),
            equally_good_choices: if named {
                diagnosis.found.open.iter().map(Choice::of).collect()
            } else {
                Vec::new()
            },
            after: named.then(|| side(&verdict.after)),
            unexplained_share: verdict.unexplained_share,
            ladder: verdict
                .ladder
                .iter()
                .map(|r| RungSaid {
                    effects: r.effects.clone(),
                    holdout_error: r.holdout_error,
                    fit_error: r.fit_error,
                })
                .collect(),
            traces: verdict.traces.clone(),
            missing_signals: diagnosis.ports.iter().map(MissingSignal::of).collect(),
            missing_after: diagnosis.ports_after.iter().map(MissingSignal::of).collect(),
            missing_force: diagnosis
                .force
                .as_ref()
                .filter(|_| named || verdict.law.is_some())
                .map(ForceSaid::of)
                .or_else(|| ForceSaid::of_ports(&diagnosis.ports)),
            law: LawSaid::of(diagnosis),
            ranking: verdict
                .ranking
                .iter()
                .filter(|r| r.holdout_error.is_finite() && r.evidence.is_finite())
                .map(|r| {
                    let candidate = &diagnosis.found.tried[r.index];
                    Ranked {
                        effects: candidate.effects.clone(),
                        holdout_error: r.holdout_error,
                        evidence: r.evidence,
                        parameters: parameters(&candidate.fit),
                    }
                })
                .collect(),
            units: Units::of_diagnosis(campaign, diagnosis),
            splits: Splits::of(campaign, diagnosis),
            next_experiment,
            sentence: String::new(),
            confidence: Confidence::default(),
            remainder: verdict.remainder.clone(),
            sanity,
            notes: campaign.notes.iter().cloned().chain(rugged).collect(),
            work: Work {
                simulations: diagnosis.simulations,
                simulated_s: diagnosis.simulated_s,
                steps: diagnosis.steps,
                ended_early,
            },
            provenance,
        };
        if matches!(verdict.kind, VerdictKind::PartlyExplained | VerdictKind::Unexplained) {
            let advice = outcome.astray(campaign).map(|astray| astray.advice());
            // Only a robot's runs are fitted in pieces.
            let after = outcome.after.as_ref().filter(|_| matches!(campaign.bench, Bench::Robot));
            let fitted = after.and_then(|after| super::drift::fitted(&outcome.base, after));
            outcome.remainder.splice(0..0, advice.into_iter().chain(fitted));
        }
        outcome.confidence = Confidence::of(&outcome);
        super::intervals::make_honest(&mut outcome);
        outcome.sentence = sentence(&outcome);
        outcome
    }

    /// How far a joint goes astray on the held-out runs in open loop, if one does.
    pub(super) fn astray(&self, campaign: &Campaign) -> Option<Astray> {
        let left = &self.after.as_ref().unwrap_or(&self.base).channels;
        Astray::of(campaign, Role::Holdout, left.iter().map(|said| (said.channel.as_str(), said.holdout_rms)))
    }
}

/// A share in per cent, with a digit more where it is small.
#[must_use]
pub fn percent(share: f64) -> String {
    let p = 100.0 * share;
    if p < 0.1 {
        "less than 0.1 %".to_owned()
    } else if p < 10.0 {
        format!("{p:.1} %")
    } else {
        format!("{p:.0} %")
    }
}
