//! The picture of friction against speed: measured, before and after by the same estimate.

use super::figures::shown;
use super::story::Story;
use crate::comparison::Part;
use crate::comparison::text::unit;
use sealegs_model::InputHold;
use sealegs_recorder::chart::{Axis, Chart, Dash, Hue, Marker};
use sealegs_recorder::report::Report;
use sealegs_sysid::Evaluation;
use sealegs_sysid::friction::{DriveSignals, Treatment, viscous};

/// Channels that may play a role, the best first.
const COMMANDS: [&str; 3] = ["current_a", "motor_force_n", "motor_torque_nm"];
const LOADS: [&str; 4] = ["force_2_n", "force_1_n", "output_torque_nm", "spring_torque_nm"];
const POSITIONS: [&str; 4] =
    ["motor_angle_rad", "rotor_angle_rad", "spring_deflection_m", "spring_deflection_rad"];

/// Names of the channels at one place.
struct Channels {
    command: String,
    load: String,
    position: String,
}

impl Channels {
    /// Those that every run of the parts has, at the place of an effect.
    fn of(parts: &[Part], effect: &str) -> Option<Self> {
        let place = effect.split_once('/').map_or(String::new(), |(place, _)| format!("{place}."));
        let there = |name: &String, part: &Part, run: usize| {
            let r = &part.data.runs[run];
            r.names.contains(name) || r.record.inputs.iter().any(|s| s.channel == *name)
        };
        let first = |names: &[&str]| {
            let mut all = names.iter().map(|n| format!("{place}{n}"));
            all.find(|n| parts.iter().all(|p| (0..p.data.runs.len()).all(|run| there(n, p, run))))
        };
        Some(Self { command: first(&COMMANDS)?, load: first(&LOADS)?, position: first(&POSITIONS)? })
    }
}

/// A channel of a run at the rows that count: measured, or as a model has it; an input is what it is.
fn signal(part: &Part, run: usize, name: &str, at: Option<&Evaluation>) -> Option<Vec<f64>> {
    let r = &part.data.runs[run];
    let counting = |values: &[f64]| r.rows().map(|i| values[i]).collect();
    if let Some(input) = r.record.inputs.iter().find(|s| s.channel == name) {
        return Some(counting(&input.values));
    }
    let slot = r.names.iter().position(|n| n == name)?;
    match at {
        Some(at) => shown(part, at, run, slot).map(|values| counting(&values)),
        None => Some(counting(r.measured[slot])),
    }
}

/// Friction against speed, where an effect is named that is one.
pub fn curve(page: &mut Report, story: &Story) {
    let is_friction = |e: &&String| e.contains("friction") || e.contains("drag");
    let parts = &story.compared.parts;
    let effects = story.outcome.effects.iter();
    let Some(channels) = effects.filter(is_friction).find_map(|e| Channels::of(parts, e)) else { return };
    // Which of a part's evaluations, or the measurement.
    type Side<'s> = &'s dyn Fn(&Part) -> Option<Evaluation>;
    let sides: [(&str, Hue, Dash, Side); 3] = [
        ("measured", Hue::Ink, Dash::Solid, &|_| None),
        ("before", Hue::Vermillion, Dash::Dashed, &|p| Some(p.before.clone())),
        ("after", Hue::Blue, Dash::Solid, &|p| p.after.clone()),
    ];
    let mut treatment = None;
    let mut slope = None;
    let chart = |title: &str| {
        let speed = format!("{}/s", unit(&channels.position));
        let across = Axis::new(&format!("speed by {}", channels.position), &speed);
        Chart::new(title, across, Axis::new("friction", unit(&channels.load)))
    };
    let (mut whole, mut dry) = (chart("Friction against speed"), chart("Without what is viscous"));
    for (label, hue, dash, side) in sides {
        let evaluations: Vec<Option<Evaluation>> = parts.iter().map(side).collect();
        let mut owned = Vec::new();
        for (part, at) in parts.iter().zip(&evaluations) {
            for run in 0..part.data.runs.len() {
                let get = |name: &str| signal(part, run, name, at.as_ref());
                let all = (get(&channels.command), get(&channels.load), get(&channels.position));
                let (Some(command), Some(load), Some(position)) = all else { return };
                let (record, rows) = (part.data.runs[run].record, part.data.runs[run].rows());
                let time_s: Vec<f64> = rows.map(|i| record.time_s[i]).collect();
                owned.push((record.hold, time_s, command, load, position));
            }
        }
        let runs: Vec<DriveSignals> = owned
            .iter()
            .map(|(hold, time_s, command, load, position)| DriveSignals {
                time_s,
                command,
                load,
                position,
                held: *hold == InputHold::ZeroOrder,
            })
            .collect();
        if treatment.is_none() {
            treatment = Treatment::of(&runs);
        }
        let points = treatment.as_ref().and_then(|t| t.curve(&runs));
        // Without what was measured the models' curves have nothing to stand beside.
        let Some(points) = points else {
            if label == "measured" {
                return;
            }
            continue;
        };
        let slope = *slope.get_or_insert_with(|| viscous(&points));
        let less =
            |slope: f64| points.iter().map(|p| (p.speed, p.friction - slope * p.speed)).collect::<Vec<_>>();
        let add = |chart: Chart, points| match label {
            "measured" => chart.scatter(label, hue, Marker::Circle, points),
            _ => chart.line(label, hue, dash, points),
        };
        (whole, dry) = (add(whole, less(0.0)), add(dry, less(slope)));
    }
    page.section("Friction against speed");
    page.figure_of(
        &[&whole, &dry],
        &format!(
            "What of {} neither reaches {} nor accelerates the drive, by ranges of speed: a regression over all runs, of the \
             measured signals and of the models' predictions alike. Dry friction is the step at standstill, viscous friction \
             the slope, which is that of the measured curve in the picture below.",
            channels.command, channels.load
        ),
    );
}
