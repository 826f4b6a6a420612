//! Simulated runs as arrays.

use crate::campaign::{array, hold_of};
use crate::error::{bad_input, raised};
use crate::models::{actuator_of, scenario_of};
use crate::work::watched;
use numpy::PyReadonlyArray1;
use pyo3::types::{PyDict, PyDictMethods};
use pyo3::{Bound, PyResult, Python, pyfunction};
use sealegs::actuator::ActuatorSpec;
use sealegs::actuator::bench::{Bench, PendulumRig};
use sealegs::leg::{LegError, simulation};
use sealegs::model::Signal;
use sealegs::recorder::recording::Output;
use sealegs::{BenchBuilder, Scenario, leg_scene};
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

/// Ends a run from outside.
struct Stoppable {
    channels: sealegs::leg::Channels,
    stop: sealegs::Stop,
}

impl simulation::Observer for Stoppable {
    fn start(&mut self, leg: &simulation::LegDescription) -> Result<(), LegError> {
        self.channels.start(leg)
    }

    fn sample(&mut self, sample: &simulation::Sample) -> Result<(), LegError> {
        if self.stop.is_stopped() {
            return Err(LegError::Observer("stopped".to_owned()));
        }
        self.channels.sample(sample)
    }

    fn event(&mut self, _event: &simulation::Event) -> Result<(), LegError> {
        Ok(())
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
        if let Some(path) = recording {
            leg_scene::record(&scenario, Output::File(path))?;
        }
        let channels = sealegs::leg::Channels::default();
        let mut observer = Stoppable { channels, stop: options.stop_handle() };
        let result = sealegs::leg::run(&scenario, &mut observer)?;
        Ok((observer.channels, result))
    })?;
    let channels = channels(py, &recorded.time_s, &recorded.signals)?;
    Ok((channels, serde_json::to_string(&result).map_err(bad_input)?))
}

/// Runs an actuator on a bench: its channels with the command, and remarks on limits.
#[pyfunction]
#[pyo3(signature = (actuator, actuator_json, bench, channel, time_s, command, spring, hold, step_s))]
#[allow(clippy::too_many_arguments, reason = "the Python package names them")]
pub fn simulate_bench<'py>(
    py: Python<'py>,
    actuator: Option<&str>,
    actuator_json: Option<&str>,
    bench: &str,
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
    let bench = match bench {
        "locked" => Bench::Locked,
        "pendulum" => Bench::Pendulum(PendulumRig::default()),
        other => return Err(bad_input(format!("unknown bench '{other}' (known: locked, pendulum)"))),
    };
    let mut builder = BenchBuilder::of_spec(spec, bench).hold(hold_of(hold)?);
    if let Some(setting) = spring {
        builder = builder.spring(setting).map_err(raised)?;
    }
    if let Some(step_s) = step_s {
        builder = builder.step_s(step_s);
    }
    let values = |column: &PyReadonlyArray1<'_, f64>| column.as_array().iter().copied().collect::<Vec<f64>>();
    let (time_s, command) = (values(&time_s), values(&command));
    let run = watched(py, None, |_| builder.run(channel, time_s, command))?;
    let signals: Vec<Signal> = run.record.inputs.iter().chain(&run.prediction.outputs).cloned().collect();
    Ok((channels(py, &run.record.time_s, &signals)?, run.prediction.events))
}
