//! The verdict in one sentence, and the channel that pictures it.

use super::confidence::ENDED_EARLY;
use super::headline::set_with_values;
use super::outcome::{ChannelSaid, Outcome, OutcomeKind, percent};
use crate::report::units::{error, with_interval};

impl Outcome {
    /// The channels that the base model misses most, so many, with their errors before and after:
    /// `position_m 111 mm → 5.28 mm`. `None` where there is none.
    pub(super) fn worst_channels(&self, most: usize) -> Option<String> {
        let mut worst: Vec<&ChannelSaid> = self.base.channels.iter().collect();
        worst.sort_by(|a, b| b.holdout_error.total_cmp(&a.holdout_error));
        let size = |e: &ChannelSaid| with_interval(e.holdout_rms, None, &e.unit);
        let said = |before: &&ChannelSaid| {
            let same = |c: &&ChannelSaid| c.channel == before.channel;
            let after = self.after.as_ref().and_then(|a| a.channels.iter().find(same));
            let after = after.map_or_else(String::new, |after| format!(" → {}", size(after)));
            format!("{} {}{after}", before.channel, size(before))
        };
        let said: Vec<String> = worst.iter().take(most).map(said).collect();
        (!said.is_empty()).then(|| said.join(", "))
    }
}

/// Channels whose errors are told in their own units.
pub(super) const TOLD: usize = 3;

/// Error in noise units from which on the verdict says it in the worst channel's own unit, too.
const FAR: f64 = 1000.0;

/// The verdict in one sentence with its numbers.
pub(super) fn sentence(o: &Outcome) -> String {
    let set = set_with_values(o);
    let floor = o.noise_floor;
    // Where a sensor is far better than the model, noise units are large numbers that nobody can picture.
    let said = |e: f64| if e >= FAR { error(e) } else { format!("{e:.2}") };
    let base = said(o.base.holdout_error);
    let pictured = o.worst_channels(1).filter(|_| o.base.holdout_error >= FAR);
    let pictured = pictured.map_or_else(String::new, |w| format!(" Root mean square, held-out: {w}."));
    let law = o.law.as_ref().map_or_else(String::new, |law| format!(" Beyond the catalogue, {}", law.said()));
    let first = super::bounds::sentence(o.bounded());
    let first = first.map_or_else(String::new, |first| format!("{first} "));
    let verdict = match (o.verdict, &o.after) {
        (OutcomeKind::Adequate, _) => format!(
            "Nothing is missing: with its own parameters refitted, the base model is at the noise floor on the held-out \
             runs (error {:.3}, noise floor {floor:.2} noise units).",
            o.base.holdout_error
        ),
        (OutcomeKind::MissingEffect, Some(after)) => format!(
            "Missing: {set}. It takes the error on the held-out runs from {base} to {:.3} noise units (noise \
             floor {floor:.2}); {} of the residual energy above the noise floor is left.{pictured}",
            after.holdout_error,
            percent(o.unexplained_share)
        ),
        (OutcomeKind::PartlyExplained, Some(after)) => format!(
            "Partly explained: {set} takes the error on the held-out runs from {base} to {} noise units, but {} of the \
             residual energy above the noise floor ({floor:.2}) remains and is structured.{pictured}{law}",
            said(after.holdout_error),
            percent(o.unexplained_share)
        ),
        _ if o.work.ended_early => format!(
            "Unexplained so far: the base model leaves an error of {base} noise units on the held-out runs (noise floor \
             {floor:.2}), and no effect that was fitted before the search was ended explains that.{pictured}{law}"
        ),
        _ => format!(
            "Unexplained: the base model leaves an error of {base} noise units on the held-out runs (noise \
             floor {floor:.2}), and no known effect, alone or with others, explains that.{pictured}{law}"
        ),
    };
    let ended = if o.work.ended_early { format!(" {ENDED_EARLY}") } else { String::new() };
    first + &verdict + &ended
}
