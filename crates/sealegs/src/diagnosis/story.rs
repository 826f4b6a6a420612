//! What a report and a recording show: two models on all runs, before and after, with where the first failed.

use super::outcome::Outcome;
use crate::comparison::{Compared, Part};
use sealegs_model::{InputHold, Record, Signal, internal};
use sealegs_sysid::diagnose::{Candidate, Diagnosis, Experiment};
use sealegs_sysid::frequency::{self, ChannelResponse};
use sealegs_sysid::locate::locate;
use sealegs_sysid::{Campaign, Data, Error, Evaluation, Role, structure};

/// Everything that is shown.
pub struct Story<'a> {
    /// The numbers.
    pub outcome: &'a Outcome,
    /// The base model (before) and the model with effects (after, if there is one) on all runs; place,
    /// dependences and responses are those of the base model.
    pub compared: Compared<'a>,
    /// The responses of the model after.
    pub after_responses: Vec<ChannelResponse>,
    /// The experiment that is proposed.
    pub experiment: Option<&'a Experiment>,
    /// One slow cycle of both models, where an effect's law shows in it.
    pub cycle: Option<Cycle>,
    /// The command as it was given.
    pub command: String,
}

/// What both models make of one slow cycle of the command, as no rig plays it: the effects' law itself.
pub struct Cycle {
    /// What the output is drawn over: the command where both ends are held, else the spring's deflection, for the
    /// command then moves the output's own load as well.
    pub across: Across,
    /// The output channel.
    pub output: String,
    /// Points of the base model.
    pub before: Vec<(f64, f64)>,
    /// The same of the model with effects.
    pub after: Vec<(f64, f64)>,
    /// How long the cycle takes, s.
    pub seconds: f64,
}

/// The quantity to the right of a cycle's picture.
#[derive(Debug, Clone, PartialEq)]
pub enum Across {
    /// The command, by its channel.
    Command(String),
    /// The spring's deflection, in m or rad.
    Deflection,
}

/// Duration of the cycle, s, and its samples; a quarter more leads into it.
const CYCLE_S: f64 = 16.0;
const CYCLE_SAMPLES: usize = 1600;

impl Cycle {
    /// Plays it, with the greatest command that the runs of `data` saw.
    fn of(data: &Data, before: &Candidate, after: &Candidate) -> Option<Self> {
        let signal = data.runs.first()?.record.inputs.first()?;
        let inputs = data.runs.iter().flat_map(|r| &r.record.inputs).flat_map(|s| &s.values);
        let peak = inputs.fold(0.0f64, |p, v| p.max(v.abs()));
        let names = || data.channels.iter().map(|c| c.name.as_str());
        let force = names().find(|n| n.ends_with("_n") || n.ends_with("_nm"));
        let output = force.or_else(|| names().next())?.to_owned();
        let lead = CYCLE_SAMPLES / 4;
        let values = (0..=lead + CYCLE_SAMPLES).map(|i| {
            let x = (i as f64 / CYCLE_SAMPLES as f64).rem_euclid(1.0);
            peak * if x < 0.25 {
                4.0 * x
            } else if x < 0.75 {
                2.0 - 4.0 * x
            } else {
                4.0 * x - 4.0
            }
        });
        let values: Vec<f64> = values.collect();
        let record = Record {
            cut: false,
            name: "one slow cycle".to_owned(),
            time_s: (0..values.len()).map(|i| i as f64 * CYCLE_S / CYCLE_SAMPLES as f64).collect(),
            hold: InputHold::Linear,
            inputs: vec![Signal { channel: signal.channel.clone(), values: values.clone() }],
            outputs: Vec::new(),
        };
        let play = |c: &Candidate| -> Option<(Across, Vec<(f64, f64)>)> {
            let channels = [output.clone()];
            let prediction = c.model.predict(&c.fit.values, &record, &channels).ok()?;
            let shown = prediction.output(&output)?;
            let (across, x) = match prediction.internal(internal::JOINT_ANGLE) {
                Some(_) => (Across::Deflection, prediction.internal(internal::SPRING_DEFLECTION)?),
                None => (Across::Command(signal.channel.clone()), values.as_slice()),
            };
            Some((across, x.iter().copied().zip(shown.iter().copied()).skip(lead).collect()))
        };
        let ((across, before), (_, after)) = (play(before)?, play(after)?);
        Some(Self { across, output, before, after, seconds: CYCLE_S })
    }
}

/// The two models of a story with their evaluations on the holdout runs.
pub struct Sides<'a> {
    /// The refitted base model.
    pub base: &'a Candidate,
    /// On the holdout runs.
    pub base_holdout: Option<&'a Evaluation>,
    /// The model with effects, if there is one to show.
    pub after: Option<&'a Candidate>,
    /// On the holdout runs.
    pub after_holdout: Option<&'a Evaluation>,
}

impl<'a> Sides<'a> {
    /// Those of a diagnosis.
    #[must_use]
    pub fn of(diagnosis: &'a Diagnosis) -> Self {
        let (verdict, tried) = (&diagnosis.verdict, &diagnosis.found.tried);
        let named = !verdict.effects.is_empty();
        Self {
            base: &tried[verdict.base.index],
            base_holdout: Some(&verdict.base_holdout),
            after: named.then(|| &tried[verdict.after.index]),
            after_holdout: named.then_some(&verdict.after_holdout),
        }
    }
}

impl<'a> Story<'a> {
    /// Puts it together from evaluations that are there already.
    ///
    /// # Errors
    ///
    /// What [`Data::new`] refuses.
    pub fn new(
        campaign: &'a Campaign,
        outcome: &'a Outcome,
        sides: &Sides,
        experiment: Option<&'a Experiment>,
        command: String,
    ) -> Result<Self, Error> {
        let model = sides.base.model.as_ref();
        let mut parts = vec![Part {
            role: Role::Fit,
            data: Data::new(campaign, Some(Role::Fit), model)?,
            before: sides.base.fit.evaluation.clone(),
            after: sides.after.map(|c| c.fit.evaluation.clone()),
        }];
        if let Some(before) = sides.base_holdout {
            parts.push(Part {
                role: Role::Holdout,
                data: Data::new(campaign, Some(Role::Holdout), model)?,
                before: before.clone(),
                after: sides.after_holdout.cloned(),
            });
        }
        let before: Vec<(&Data, &Evaluation)> = parts.iter().map(|p| (&p.data, &p.before)).collect();
        let after: Vec<(&Data, &Evaluation)> =
            parts.iter().filter_map(|p| Some((&p.data, p.after.as_ref()?))).collect();
        let after_responses = if after.is_empty() { Vec::new() } else { frequency::responses(&after) };
        let (location, tests, responses) =
            (locate(&before), structure::tests(&before), frequency::responses(&before));
        let compared = Compared {
            sanity: outcome.sanity.clone(),
            campaign,
            model: model.name(),
            floor: outcome.noise_floor,
            fit: Some(sides.base.fit.clone()),
            parts,
            location,
            tests,
            responses,
            work: (outcome.work.simulations, outcome.work.simulated_s),
        };
        let cycle = sides.after.and_then(|after| Cycle::of(&compared.parts[0].data, sides.base, after));
        Ok(Self { outcome, compared, after_responses, experiment, cycle, command })
    }
}
