//! How sure a verdict is, and why: what a reader must know before the numbers are used.

use super::bounds;
use super::outcome::{Outcome, OutcomeKind, ParameterValue, Side};
use crate::report::units::error;
use schemars::JsonSchema;
use serde::Serialize;

/// How far a verdict can be relied on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// One explanation, at the noise floor, and nothing speaks against it.
    Sure,
    /// Something speaks against it, or another explanation fits as well.
    Reserved,
    /// No explanation.
    Open,
    /// Nothing was judged: the effects were asked for.
    #[default]
    Asked,
}

/// A level with its reasons.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct Confidence {
    /// The level.
    pub level: Level,
    /// Why, in sentences.
    pub reasons: Vec<String>,
    /// Whether the intervals hold under the named model only: something stays, or a parameter of the base model ended
    /// where it should not.
    pub intervals_conditional: bool,
}

/// Error over the noise floor on held-out runs from which on something stays: the diagnosis's own threshold of an
/// adequate model.
const STAYS: f64 = 1.05;

/// Share of the base model's energy above the floor that a curve takes for it to be said in place of what the residual follows.
const MOST_OF_IT: f64 = 0.5;

/// Share of the base model's error above the noise floor below which what a named set leaves says nothing for a wrong value in the
/// base model: an effect that does a wrong value's work leaves more. An estimate.
const NEXT_TO_NOTHING: f64 = 0.05;

/// What is said where a search was ended before it was done.
pub(super) const ENDED_EARLY: &str =
    "The search was ended before it was done: effects that were not fitted yet may explain more, or as much.";

/// Parameters and sentences that are said at most.
const MOST: usize = 3;

impl Outcome {
    /// Whether the held-out runs end above the noise floor.
    pub(super) fn stays(&self) -> bool {
        let side = self.after.as_ref().unwrap_or(&self.base);
        side.holdout_error > STAYS * self.noise_floor
    }

    /// What a model leaves of the base model's held-out error above the noise floor, as a share.
    fn left(&self, side: &Side) -> f64 {
        (side.holdout_error - self.noise_floor) / (self.base.holdout_error - self.noise_floor).max(1e-9)
    }

    /// The parameters whose unstated bounds matter: the base model's; of the model with the named effects where that ends at
    /// the noise floor or leaves next to nothing of the base model's error, for a missing effect drives the base model's refit to
    /// its bounds, too. None of what was asked for.
    pub(super) fn bounded(&self) -> &[ParameterValue] {
        match (self.verdict, &self.after) {
            (OutcomeKind::Added, _) => &[],
            (_, Some(after)) if !self.stays() || self.left(after) < NEXT_TO_NOTHING => &after.parameters,
            _ => &self.base.parameters,
        }
    }

    /// Which sets predict the held-out runs better than a curve that leaves so much of them: it follows the fit runs alone.
    fn better_held_out(&self, of_curve: f64) -> Option<String> {
        let better: Vec<String> = self
            .ranking
            .iter()
            .filter(|set| set.holdout_error < of_curve)
            .take(MOST)
            .map(|set| format!("{} ({})", set.effects.join(" + "), error(set.holdout_error)))
            .collect();
        (!better.is_empty()).then(|| {
            format!(
                "The held-out runs are predicted better by {}: the curve describes the fit runs only. Fit runs that are more \
                 like the held-out ones would decide.",
                better.join(", ")
            )
        })
    }
}

impl Confidence {
    /// That of a verdict. What the base model lacks of its own numbers comes first.
    #[must_use]
    pub fn of(o: &Outcome) -> Self {
        let mut judged = Self::judged(o);
        if o.work.ended_early {
            let sure = judged.level == Level::Sure;
            judged.level = if sure { Level::Reserved } else { judged.level };
            judged.reasons.insert(0, ENDED_EARLY.to_owned());
        }
        judged.reasons.splice(0..0, bounds::reason(o.bounded()));
        judged
    }

    fn judged(o: &Outcome) -> Self {
        let floor = o.noise_floor;
        let side = o.after.as_ref().unwrap_or(&o.base);
        let off = off(&side.parameters);
        let stays = o.stays();
        let mut reasons = Vec::new();
        match o.verdict {
            OutcomeKind::Added => return Self::default(),
            OutcomeKind::Unexplained => {
                let base = error(o.base.holdout_error);
                match &o.law {
                    Some(law) => {
                        reasons.push(format!(
                            "No effect is named because a curve explains the fit runs far better than any known one: {base} noise units on \
                             the held-out runs with the base model, {} with the curve.",
                            error(law.holdout_error)
                        ));
                        reasons.extend(o.better_held_out(law.holdout_error));
                    }
                    None => {
                        let which = match o.work.ended_early {
                            true => "No effect that was fitted before the search was ended",
                            false => "No known effect, alone or with others,",
                        };
                        reasons.push(format!(
                            "{which} lowers the error on the held-out runs enough to be named: {base} noise units with the base model."
                        ));
                    }
                }
                // What the curve takes is described by the curve.
                if o.law.as_ref().is_none_or(|law| law.explained < MOST_OF_IT) {
                    reasons.extend(o.remainder.iter().take(MOST).cloned());
                }
                return Self { level: Level::Open, reasons, intervals_conditional: true };
            }
            OutcomeKind::PartlyExplained => {
                reasons.push(format!(
                    "It explains a part: {} of the residual's energy above the noise floor remains and is structured.",
                    super::outcome::percent(o.unexplained_share)
                ));
                reasons.extend(o.remainder.iter().take(2).cloned());
            }
            _ if stays => reasons.push(format!(
                "A residual remains: the held-out error is {} noise units, the noise floor {}.",
                error(side.holdout_error),
                error(floor)
            )),
            _ => {}
        }
        if !o.indistinguishable.is_empty() {
            let sets: Vec<String> = o.indistinguishable.iter().map(|s| s.join(" + ")).collect();
            reasons.push(format!("These runs fit {} as well.", sets.join(", or ")));
        }
        if !o.equally_good_choices.is_empty() {
            reasons.push("A convention of the log is open, and the values depend on it (below).".to_owned());
        }
        reasons.extend(o.units.as_ref().and_then(super::units::Units::reservation));
        reasons.extend(o.splits.as_ref().and_then(|splits| splits.reservation(&o.effects)));
        reasons.extend(off.iter().take(MOST).cloned());
        if off.len() > MOST {
            reasons.push(format!("{} more ended at a bound or far from nominal.", off.len() - MOST));
        }
        let intervals_conditional = o.verdict == OutcomeKind::PartlyExplained || stays || !off.is_empty();
        if !reasons.is_empty() {
            return Self { level: Level::Reserved, reasons, intervals_conditional };
        }
        let floor = format!("{} noise units, noise floor {}", error(side.holdout_error), error(floor));
        reasons.push(match o.verdict {
            OutcomeKind::Adequate => format!("The base model predicts the held-out runs to the noise floor ({floor})."),
            _ => format!(
                "It brings the held-out runs to the noise floor ({floor}), no other effect of the catalogue does it with as few \
                 parameters, and no parameter of the base model ends at a bound or far from its nominal value."
            ),
        });
        Self { level: Level::Sure, reasons, intervals_conditional: false }
    }
}

/// What is said of parameters that ended where they should not.
fn off(parameters: &[ParameterValue]) -> Vec<String> {
    let free = || parameters.iter().filter(|p| !p.fixed);
    let at_bound = free().filter(|p| p.at_bound).map(|p| format!("{} ended at its bound.", p.name));
    let far = free().filter(|p| !p.at_bound && p.is_far()).map(|p| {
        format!(
            "{} ended {:.1} standard deviations from its nominal value.",
            p.name,
            p.from_nominal.unwrap_or(0.0).abs()
        )
    });
    at_bound.chain(far).collect()
}
