//! Campaigns: of files, or of arrays in memory.

use crate::error::{bad_input, raised};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::types::{PyDict, PyDictMethods};
use pyo3::{Bound, PyResult, Python, pyclass, pymethods};
use sealegs::model::InputHold;
use sealegs::sysid::Run;
use sealegs::sysid::campaign::RigValues;
use sealegs::{Bench, Role, RunColumns};
use std::path::PathBuf;

/// A run as Python gives it: name, role, scenario, unit, its rig's numbers, columns, and the times between which its rows
/// count.
type GivenRun<'py> = (
    String,
    String,
    Option<String>,
    Option<String>,
    Vec<(String, f64)>,
    Vec<(String, PyReadonlyArray1<'py, f64>)>,
    (Option<f64>, Option<f64>),
);

/// Recorded runs with what they were recorded on.
#[pyclass(frozen, module = "sealegs._core")]
pub struct Campaign {
    pub inner: sealegs::Campaign,
}

#[pymethods]
impl Campaign {
    /// Reads a campaign's folder, or its campaign.toml.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let inner = py.detach(|| sealegs::Campaign::read(&path));
        Ok(Self { inner: inner.map_err(|e| raised(e.into()))? })
    }

    /// A campaign of arrays.
    #[staticmethod]
    #[pyo3(signature = (name, bench, model, runs, noise_std, inputs, hold, sample_rate_hz, window_s, gravity_compensated))]
    #[allow(clippy::too_many_arguments, reason = "the Python package names them")]
    fn build(
        py: Python<'_>,
        name: &str,
        bench: &str,
        model: &str,
        runs: Vec<GivenRun<'_>>,
        noise_std: Vec<(String, f64)>,
        inputs: Vec<String>,
        hold: &str,
        sample_rate_hz: Option<f64>,
        window_s: Option<f64>,
        gravity_compensated: bool,
    ) -> PyResult<Self> {
        let bench = bench_of(bench)?;
        let mut builder = sealegs::Campaign::builder(name, bench, model)
            .hold(hold_of(hold)?)
            .gravity_compensated(gravity_compensated);
        for (channel, std) in noise_std {
            builder = builder.noise_std(channel, std);
        }
        for input in inputs {
            builder = builder.input(input);
        }
        if let Some(rate) = sample_rate_hz {
            builder = builder.sample_rate_hz(rate);
        }
        if let Some(window_s) = window_s {
            builder = builder.window_s(window_s);
        }
        for (name, role, scenario, unit, rig, columns, (from_s, to_s)) in runs {
            let role = match role.as_str() {
                "fit" => Role::Fit,
                "holdout" => Role::Holdout,
                other => {
                    return Err(bad_input(format!("{name}: unknown role '{other}' (known: fit, holdout)")));
                }
            };
            let rig = rig_of(&rig, bench).map_err(|problem| bad_input(format!("{name}: {problem}")))?;
            let columns = columns.iter().map(|(channel, values)| (channel, values_of(values)));
            let mut run = RunColumns::new(name, role, columns).rig(rig);
            if let Some(scenario) = scenario {
                run = run.scenario(scenario);
            }
            if let Some(unit) = unit {
                run = run.unit(unit);
            }
            if let Some(from_s) = from_s {
                run = run.from_s(from_s);
            }
            if let Some(to_s) = to_s {
                run = run.to_s(to_s);
            }
            builder = builder.run(run);
        }
        let inner = py.detach(|| builder.build());
        Ok(Self { inner: inner.map_err(|e| raised(e.into()))? })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    #[getter]
    fn bench(&self) -> &'static str {
        self.inner.bench.as_str()
    }

    /// The actuator that the campaign names; for a leg its scenario, for a robot its URDF.
    #[getter]
    fn model(&self) -> &str {
        let Self { inner } = self;
        inner.scenario.as_ref().or(inner.robot.as_ref()).unwrap_or(&inner.actuator)
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.inner.notes.clone()
    }

    #[getter]
    fn noise_std(&self) -> Vec<(String, f64)> {
        self.inner.noise.iter().map(|n| (n.channel.clone(), n.std)).collect()
    }

    #[getter]
    fn noise_floor(&self) -> f64 {
        self.inner.noise_floor()
    }

    /// Name and role of each run.
    #[getter]
    fn runs(&self) -> Vec<(String, &'static str)> {
        self.inner.runs.iter().map(|r| (r.record.name.clone(), r.role.as_str())).collect()
    }

    /// The columns of a run.
    fn columns<'py>(&self, py: Python<'py>, run: &str) -> PyResult<Bound<'py, PyDict>> {
        let Some(Run { record, unknown, .. }) = self.inner.runs.iter().find(|r| r.record.name == run) else {
            let known: Vec<&str> = self.inner.runs.iter().map(|r| r.record.name.as_str()).collect();
            return Err(bad_input(format!("no run '{run}'; the campaign has {}", known.join(", "))));
        };
        let columns = PyDict::new(py);
        columns.set_item("time_s", array(py, &record.time_s))?;
        for signal in record.inputs.iter().chain(&record.outputs).chain(unknown) {
            columns.set_item(&signal.channel, array(py, &signal.values))?;
        }
        Ok(columns)
    }
}

/// Values as an array of Python's own.
pub fn array<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyArray1<f64>> {
    values.to_vec().into_pyarray(py)
}

/// The values of an array of Python's.
pub fn values_of(array: &PyReadonlyArray1<'_, f64>) -> Vec<f64> {
    array.as_array().iter().copied().collect()
}

/// A bench by the name that it has in files.
pub fn bench_of(name: &str) -> PyResult<Bench> {
    let known = [Bench::Locked, Bench::Pendulum, Bench::Free, Bench::Robot, Bench::Leg];
    known.into_iter().find(|bench| bench.as_str() == name).ok_or_else(|| {
        let names = known.map(Bench::as_str).join(", ");
        bad_input(format!("unknown bench '{name}' (known: {names})"))
    })
}

/// A rig's numbers by their keys in files; the error says what is wrong with which.
pub fn rig_of(numbers: &[(String, f64)], bench: Bench) -> Result<RigValues, String> {
    let mut rig = RigValues::default();
    for (key, number) in numbers {
        rig.set(key, *number, bench).map_err(|problem| format!("'{key}' {problem}"))?;
    }
    Ok(rig)
}

/// What a command does between its samples.
pub fn hold_of(name: &str) -> PyResult<InputHold> {
    match name {
        "zero-order" => Ok(InputHold::ZeroOrder),
        "linear" => Ok(InputHold::Linear),
        "band-limited" => Ok(InputHold::BandLimited),
        other => Err(bad_input(format!("unknown hold '{other}' (known: zero-order, linear, band-limited)"))),
    }
}
