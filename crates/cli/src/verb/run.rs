//! `sealegs run`: one scenario from beginning to end, to look at and to read.

use crate::failure::{OrBadInput, bad_input};
use crate::kind;
use crate::output::Destination;
use crate::progress;
use clap::Args;
use sealegs::leg::scenario::Scenario;
use sealegs::leg::simulation::{Event, LegDescription, Observer, Sample, Simulation};
use sealegs::leg::{Channels, LegError, RunResult, run_simulation};
use sealegs::leg_scene::LegRecorder;
use sealegs::recorder::recording::Output;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Run a scenario: a drop, a swing, a leg of your own, or any URDF that falls from a fixed base.
#[derive(Args)]
pub struct Run {
    /// A shipped scenario's name (see `sealegs list`), a TOML file, or a URDF by itself.
    scenario: String,
    /// Write a Rerun recording.
    #[arg(long, value_name = "FILE")]
    rrd: Option<PathBuf>,
    /// Show the run in an installed Rerun viewer.
    #[arg(long)]
    view: bool,
    /// Write the channels as CSV (`-`: standard output).
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write peaks, events and energy balance as JSON (`-`: standard output).
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Change a key of the scenario, dotted: `start.drop_height_m=0.2`. May be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Integration step, s.
    #[arg(long, value_name = "SECONDS")]
    step: Option<f64>,
    /// Duration, s.
    #[arg(long, value_name = "SECONDS")]
    duration: Option<f64>,
    /// Refuse a URDF that would have to be mended.
    #[arg(long)]
    strict: bool,
}

/// Everyone who watches this run.
#[derive(Default)]
struct Watchers {
    recorders: Vec<LegRecorder>,
    channels: Option<Channels>,
    progress: Option<progress::Bar>,
}

impl Observer for Watchers {
    fn start(&mut self, leg: &LegDescription) -> Result<(), LegError> {
        self.recorders.iter_mut().try_for_each(|r| r.start(leg))?;
        self.channels.iter_mut().try_for_each(|c| c.start(leg))
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), LegError> {
        if let Some(bar) = &self.progress {
            bar.set_position((1e3 * sample.time_s) as u64);
        }
        self.recorders.iter_mut().try_for_each(|r| r.sample(sample))?;
        self.channels.iter_mut().try_for_each(|c| c.sample(sample))
    }

    fn event(&mut self, event: &Event) -> Result<(), LegError> {
        self.recorders.iter_mut().try_for_each(|r| r.event(event))
    }
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input; a run that stopped before its end, after everything that was recorded has been written.
pub fn run(args: &Run) -> anyhow::Result<u8> {
    let (scenario, simulation) = prepare(args)?;
    let rrd = Destination::optional(args.rrd.as_ref())?;
    let csv = Destination::optional(args.csv.as_ref())?;
    let json = Destination::optional(args.json.as_ref())?;
    let document = toml::to_string_pretty(&scenario).unwrap_or_default();
    let mut watchers = Watchers {
        channels: csv.as_ref().map(|_| Channels::default()),
        progress: Some(progress::bar(
            (1e3 * scenario.duration_s) as u64,
            "{elapsed} {bar:40} {pos} of {len} ms",
        )),
        ..Watchers::default()
    };
    if let Some(destination) = &rrd {
        let Some(part) = destination.part() else {
            return Err(bad_input("--rrd -: a recording goes to a file, or to a viewer with --view"));
        };
        watchers.recorders.push(LegRecorder::new(Output::File(part.to_owned()), document.clone()));
    }
    if args.view {
        watchers.recorders.push(LegRecorder::new(Output::Viewer, document));
    }
    let result = run_simulation(&scenario, simulation, &mut watchers)?;
    if let Some(bar) = watchers.progress.take() {
        bar.finish();
    }
    for recorder in watchers.recorders.drain(..) {
        recorder.end(result.stopped.as_deref())?;
    }
    if let Some(rrd) = rrd {
        rrd.finish()?;
    }
    if let (Some(csv), Some(channels)) = (csv, &watchers.channels) {
        csv.write(&csv_of(channels)?)?;
    }
    let to_stdout = [&args.csv, &args.json].iter().any(|p| p.as_ref().is_some_and(|p| p.as_os_str() == "-"));
    if let Some(json) = json {
        json.write(format!("{}\n", serde_json::to_string_pretty(&result)?).as_bytes())?;
    }
    if !to_stdout {
        std::io::stdout().write_all(summary(&result).as_bytes())?;
    }
    match result.stopped {
        Some(what) => {
            Err(anyhow::anyhow!("{}: {what}; what was recorded until then is kept", result.scenario))
        }
        None => Ok(0),
    }
}

/// The scenario, or the URDF by itself, ready to run.
fn prepare(args: &Run) -> anyhow::Result<(Scenario, Simulation)> {
    let mut set = args.set.clone();
    set.extend(args.duration.map(|s| format!("duration_s={s:?}")));
    set.extend(args.strict.then(|| "strict=true".to_owned()));
    if !Path::new(&args.scenario).extension().is_some_and(|e| e.eq_ignore_ascii_case("urdf")) {
        let scenario = load(&args.scenario, &set, args.step)?;
        let simulation = Simulation::new(&scenario).or_bad_input()?;
        return Ok((scenario, simulation));
    }
    set.extend(args.step.map(|s| format!("step_s={s:?}")));
    let (scenario, robot) = Scenario::for_robot(&args.scenario, &set).or_bad_input()?;
    let simulation = Simulation::with_robot(&scenario, robot).or_bad_input()?;
    Ok((scenario, simulation))
}

/// The scenario with the command line's changes.
pub(super) fn load(name: &str, set: &[String], step: Option<f64>) -> anyhow::Result<Scenario> {
    kind::expect_scenario(name)?;
    let mut set = set.to_vec();
    set.extend(step.map(|s| format!("step_s={s:?}")));
    Scenario::load(name, &set).or_bad_input()
}

fn csv_of(channels: &Channels) -> anyhow::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer
        .write_record(std::iter::once("time_s").chain(channels.signals.iter().map(|s| s.channel.as_str())))?;
    for (i, time) in channels.time_s.iter().enumerate() {
        let values = channels.signals.iter().map(|s| s.values[i].to_string());
        // Nine digits: the time stamps of a sampled run are multiples of its step.
        writer.write_record(std::iter::once(format!("{time:.9}")).chain(values))?;
    }
    Ok(writer.into_inner()?)
}

/// Most remarks of a summary: the robots of some makers leave hundreds.
const MOST_REMARKS: usize = 20;

/// Peaks, events and the energy balance, for a terminal.
pub(super) fn summary(result: &RunResult) -> String {
    let mut out = String::new();
    let p = &result.peaks;
    for remark in result.remarks.iter().take(MOST_REMARKS) {
        let _ = writeln!(out, "{remark}");
    }
    if result.remarks.len() > MOST_REMARKS {
        let _ = writeln!(out, "and {} remarks more: --json has them", result.remarks.len() - MOST_REMARKS);
    }
    let _ = writeln!(
        out,
        "{}: {:.3} s at a step of {:.0} us, {} joints, {} actuators",
        result.scenario,
        result.time_s,
        1e6 * result.step_s,
        result.joints.len(),
        p.actuators.len()
    );
    if p.ground_force_n.value > 0.0 {
        let _ = writeln!(
            out,
            "peak ground force {:.0} N at {:.4} s",
            p.ground_force_n.value, p.ground_force_n.time_s
        );
    }
    if p.actuators.is_empty() {
        joints(&mut out, result);
    } else {
        actuators(&mut out, result);
    }
    for event in &result.events {
        let subject = if event.subject.is_empty() { String::new() } else { format!("{}: ", event.subject) };
        let _ = writeln!(out, "{:>9.4} s  {subject}{}", event.time_s, event.text);
    }
    let e = &result.energy;
    let _ = writeln!(
        out,
        "energy: motors {:+.3} J, rotors {:+.3} J, ground {:+.3} J, joints {:+.3} J; unexplained at most {:.1e} of \
         the energy in motion",
        e.motor_work_j, e.rotor_loss_j, e.ground_work_j, e.joint_work_j, result.worst_energy_residual
    );
    out
}

/// Where the joints are at the end.
fn joints(out: &mut String, result: &RunResult) {
    let width = result.joints.iter().map(|j| j.name.chars().count()).max().unwrap_or(0).max(5) + 2;
    let _ = writeln!(out, "{:<width$}{:>14}{:>18}", "joint", "at the end", "with");
    for j in &result.joints {
        let unit = if j.slides { "m" } else { "rad" };
        let (position, speed) = (format!("{:.4} {unit}", j.position), format!("{:.4} {unit}/s", j.speed));
        let _ = writeln!(out, "{:<width$}{position:>14}{speed:>18}", j.name);
    }
}

/// The greatest values of the actuators.
fn actuators(out: &mut String, result: &RunResult) {
    let _ = writeln!(
        out,
        "{:<14}{:>10}{:>10}{:>12}{:>10}{:>10}",
        "actuator", "F1 N", "F2 N", "spring mm", "beam MPa", "current A"
    );
    for a in &result.peaks.actuators {
        let _ = writeln!(
            out,
            "{:<14}{:>10.0}{:>10.0}{:>12.3}{:>10.1}{:>10.2}",
            a.name,
            a.force_1_n.value,
            a.force_2_n.value,
            1e3 * a.deflection_m.value,
            1e-6 * a.stress_pa.value,
            a.current_a.value
        );
    }
}
