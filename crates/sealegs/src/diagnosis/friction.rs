//! The picture of friction against speed: measured, before and after by the same estimate.

use super::story::Story;
use crate::comparison::Part;
use crate::comparison::overlay::shown;
use sealegs_model::InputHold;
use sealegs_model::Unit;
use sealegs_recorder::chart::{Axis, Chart, Dash, Hue, Marker};
use sealegs_recorder::report::Report;
use sealegs_sysid::Evaluation;
use sealegs_sysid::friction::{DriveSignals, FrictionPoint, Treatment, viscous};

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

/// The signals of one run.
struct RunSignals {
    hold: InputHold,
    time_s: Vec<f64>,
    command: Vec<f64>,
    load: Vec<f64>,
    position: Vec<f64>,
}

impl RunSignals {
    fn of(part: &Part, run: usize, channels: &Channels, at: Option<&Evaluation>) -> Option<Self> {
        let get = |name: &str| signal(part, run, name, at);
        let (r, record) = (&part.data.runs[run], part.data.runs[run].record);
        Some(Self {
            hold: record.hold,
            time_s: r.rows().map(|i| record.time_s[i]).collect(),
            command: get(&channels.command)?,
            load: get(&channels.load)?,
            position: get(&channels.position)?,
        })
    }
}

/// The same, lent to an estimate.
fn lent_all(runs: &[RunSignals]) -> Vec<DriveSignals<'_>> {
    runs.iter()
        .map(|r| DriveSignals {
            time_s: &r.time_s,
            command: &r.command,
            load: &r.load,
            position: &r.position,
            held: r.hold == InputHold::ZeroOrder,
        })
        .collect()
}

/// Friction against speed, where an effect is named that is one.
pub fn curve(page: &mut Report, story: &Story) {
    let is_friction = |e: &&String| e.contains("friction") || e.contains("drag");
    let parts = &story.compared.parts;
    let effects = story.outcome.effects.iter();
    let Some(channels) = effects.filter(is_friction).find_map(|e| Channels::of(parts, e)) else { return };
    let signals = |side: &dyn Fn(&Part) -> Option<Evaluation>| -> Option<Vec<RunSignals>> {
        let mut all = Vec::new();
        for part in parts {
            let at = side(part);
            for run in 0..part.data.runs.len() {
                all.push(RunSignals::of(part, run, &channels, at.as_ref())?);
            }
        }
        Some(all)
    };
    let before = signals(&|p| Some(p.before.clone()));
    let after = signals(&|p| p.after.clone()).filter(|_| parts.iter().all(|p| p.after.is_some()));
    let (Some(measured), Some(before), Some(after)) = (signals(&|_| None), before, after) else { return };
    let Some(treatment) = Treatment::of(&lent_all(&after)) else { return };
    let Some((shares, after)) = treatment.regression(&lent_all(&after)) else { return };
    let curve = |runs: &[RunSignals]| treatment.curve(&lent_all(runs), shares);
    let (Some(measured), Some(before)) = (curve(&measured), curve(&before)) else { return };
    let slope = viscous(&after);
    let chart = |title: &str, slope: f64| {
        let less = |points: &[FrictionPoint]| -> Vec<(f64, f64)> {
            points.iter().map(|p| (p.speed, p.friction - slope * p.speed)).collect()
        };
        let speed = format!("{}/s", Unit::symbol_of(&channels.position));
        let across = Axis::new(&format!("speed by {}", channels.position), &speed);
        Chart::new(title, across, Axis::new("friction", Unit::symbol_of(&channels.load)))
            .scatter("measured", Hue::Ink, Marker::Circle, less(&measured))
            .line("before", Hue::Vermillion, Dash::Dashed, less(&before))
            .line("after", Hue::Blue, Dash::Solid, less(&after))
    };
    let (whole, dry) = (chart("Friction against speed", 0.0), chart("Without what is viscous", slope));
    let caption = format!(
        "What of {} neither reaches {} nor accelerates the drive, by ranges of speed, over all runs: measured, and as the two \
         models predict it. What reaches the load and what accelerates is by the model after. Dry friction is the step at \
         standstill, viscous friction the slope; below, without the slope of the model after.",
        channels.command, channels.load
    );
    page.details("Friction against speed, without an observer", |page| {
        page.figure_of(&[&whole, &dry], &caption);
    });
}
