//! Simulated runs as arrays.

use crate::campaign::{array, bench_of, hold_of, rig_of, values_of};
use crate::error::{bad_input, raised};
use crate::models::{actuator_of, scenario_of};
use crate::work::watched;
use numpy::PyReadonlyArray1;
use pyo3::types::{PyDict, PyDictMethods};
use pyo3::{Bound, PyResult, Python, pyfunction};
use sealegs::actuator::ActuatorSpec;
use sealegs::leg::LegError;
use sealegs::leg::simulation::{Event, LegDescription, Observer, Sample};
use sealegs::leg_scene::LegRecorder;
use sealegs::model::Signal;
use sealegs::recorder::recording::Output;
use sealegs::{Bench, BenchBuilder, Scenario, Stop, bench_model};
use std::path::PathBuf;

/// The channels of a run.
fn channels<'py>(py: Python<'py>, time_s: &[f64], signals: &[Signal]) -> PyResult<Bound<'py, PyDict>> {
    let channels = PyDict::new(py);
    channels.set_item("time_s", array(py, time_s))?;
    for signal in signals {
        channels.set_item(&signal.channel, array(py, &signal.values))?;
    }
    Ok(channels)
}

/// Keeps a run's channels, records it where that is asked for, and lets it be ended from outside.
struct Watcher {
    channels: sealegs::leg::Channels,
    recorder: Option<LegRecorder>,
    stop: Stop,
}

impl Observer for Watcher {
    fn start(&mut self, leg: &LegDescription) -> Result<(), LegError> {
        self.channels.start(leg)?;
        self.recorder.as_mut().map_or(Ok(()), |recorder| recorder.start(leg))
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), LegError> {
        if self.stop.is_stopped() {
            return Err(LegError::Observer("stopped".to_owned()));
        }
        self.channels.sample(sample)?;
        self.recorder.as_mut().map_or(Ok(()), |recorder| recorder.sample(sample))
    }

    fn event(&mut self, event: &Event) -> Result<(), LegError> {
        self.channels.event(event)?;
        self.recorder.as_mut().map_or(Ok(()), |recorder| recorder.event(event))
    }
}

/// Runs a scenario: its channels, and peaks, events and energy as JSON.
#[pyfunction]
#[pyo3(signature = (scenario, scenario_json, overrides, recording))]
pub fn simulate_leg<'py>(
    py: Python<'py>,
    scenario: Option<&str>,
    scenario_json: Option<&str>,
    overrides: Vec<String>,
    recording: Option<PathBuf>,
) -> PyResult<(Bound<'py, PyDict>, String)> {
    let scenario = match (scenario, scenario_json) {
        (_, Some(json)) => scenario_of(json, &overrides)?,
        (Some(name), None) => Scenario::load(name, &overrides).map_err(|e| raised(e.into()))?,
        (None, None) => return Err(bad_input("no scenario was named")),
    };
    let (recorded, result) = watched(py, None, |options| {
        let document = toml::to_string_pretty(&scenario).unwrap_or_default();
        let recorder = recording.map(|path| LegRecorder::new(Output::File(path), document));
        let stop = options.stop_handle();
        let mut watcher = Watcher { channels: sealegs::leg::Channels::default(), recorder, stop };
        let result = sealegs::leg::run(&scenario, &mut watcher)?;
        if let Some(recorder) = watcher.recorder {
            recorder.end(result.stopped.as_deref())?;
        }
        Ok((watcher.channels, result))
    })?;
    let channels = channels(py, &recorded.time_s, &recorded.signals)?;
    Ok((channels, serde_json::to_string(&result).map_err(bad_input)?))
}

/// Runs an actuator on a bench: its channels with the command, and remarks on limits.
#[pyfunction]
#[pyo3(signature = (actuator, actuator_json, bench, rig, channel, time_s, command, spring, hold, step_s))]
#[allow(clippy::too_many_arguments, reason = "the Python package names them")]
pub fn simulate_bench<'py>(
    py: Python<'py>,
    actuator: Option<&str>,
    actuator_json: Option<&str>,
    bench: &str,
    rig: Vec<(String, f64)>,
    channel: &str,
    time_s: PyReadonlyArray1<'_, f64>,
    command: PyReadonlyArray1<'_, f64>,
    spring: Option<&str>,
    hold: &str,
    step_s: Option<f64>,
) -> PyResult<(Bound<'py, PyDict>, Vec<String>)> {
    let spec = match (actuator, actuator_json) {
        (_, Some(json)) => actuator_of(json)?,
        (Some(name), None) => ActuatorSpec::load(name, None).map_err(|e| raised(e.into()))?,
        (None, None) => return Err(bad_input("no actuator was named")),
    };
    let bench = match bench_of(bench)? {
        Bench::Leg | Bench::Robot => {
            return Err(bad_input(format!(
                "bench '{bench}' has no actuator of its own (known: locked, pendulum, free)"
            )));
        }
        bench => bench,
    };
    let rig = rig_of(&rig, bench).map_err(bad_input)?;
    let bench = bench_model::bench_of(bench, &rig, &spec)
        .map_err(|wrong| bad_input(format!("'{}' {}", wrong.key, wrong.problem)))?;
    let mut builder = BenchBuilder::of_spec(spec, bench).hold(hold_of(hold)?);
    if let Some(setting) = spring {
        builder = builder.spring(setting).map_err(raised)?;
    }
    if let Some(step_s) = step_s {
        builder = builder.step_s(step_s);
    }
    let (time_s, command) = (values_of(&time_s), values_of(&command));
    let run = watched(py, None, |_| builder.run(channel, time_s, command))?;
    let signals: Vec<Signal> = run.record.inputs.iter().chain(&run.prediction.outputs).cloned().collect();
    Ok((channels(py, &run.record.time_s, &signals)?, run.prediction.events))
}
