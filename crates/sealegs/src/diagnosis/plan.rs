//! The next experiment: as a file that a rig can play, the limits that it keeps to, and in words where there is nothing to play.

use sealegs_actuator::ActuatorSpec;
use sealegs_sysid::Campaign;
use sealegs_sysid::diagnose::{Experiment, Limits, Play, Verdict, in_words};
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// What the actuator file says the rig bears, in the unit of the campaign's input.
#[must_use]
pub fn limits(spec: &ActuatorSpec, campaign: &Campaign) -> Limits {
    let input = campaign.runs.first().and_then(|r| r.record.inputs.first()).map(|s| s.channel.as_str());
    let peak = spec.ratings.peak(spec.kind);
    let input = match input {
        Some("current_a") => {
            let by_force = peak.map(|p| p / spec.coefficients().force_constant);
            [spec.motor.current_limit_a, by_force].into_iter().flatten().reduce(f64::min)
        }
        Some("voltage_v") => spec.motor.supply_v,
        // A goal is limited by what the runs showed alone.
        Some("position_rad") => None,
        _ => peak,
    };
    Limits { input }
}

/// What to do next with a robot, whose joints move together.
pub(super) fn moved_otherwise(verdict: &Verdict) -> String {
    let all = std::iter::once(&verdict.effects).chain(&verdict.indistinguishable);
    let places: BTreeSet<&str> =
        all.flatten().filter_map(|id| id.split_once('/')).map(|(at, _)| at).collect();
    let what = match places.into_iter().collect::<Vec<_>>()[..] {
        [] => "the robot".to_owned(),
        ref places => places.join(" and "),
    };
    let why = match &verdict.indistinguishable[..] {
        [] => "to confirm it".to_owned(),
        ties => {
            let ties: Vec<String> = ties.iter().map(|set| in_words(set)).collect();
            format!("to tell {} and {} apart", in_words(&verdict.effects), ties.join(", "))
        }
    };
    format!(
        "Its joints move together, so no single column is proposed to be played; {why}, move {what} at other speeds, loads and \
         amplitudes than these runs have."
    )
}

/// An experiment's input as CSV: `time_s` and the input column, one row a sample; `None` for a run of the rig's own.
#[must_use]
pub fn csv(experiment: &Experiment) -> Option<String> {
    let Play::Input { channel, time_s, values } = &experiment.play else { return None };
    let mut out = format!("time_s,{channel}\n");
    for (t, v) in time_s.iter().zip(values) {
        // Nanoseconds and nine significant digits: what any player resolves.
        let _ = writeln!(out, "{},{}", (t * 1e9).round() / 1e9, rounded(*v));
    }
    Some(out)
}

fn rounded(value: f64) -> f64 {
    // Adding zero takes the sign off a negative zero.
    format!("{value:.8e}").parse::<f64>().map_or(value, |v| v + 0.0)
}
