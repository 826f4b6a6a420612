//! Campaigns: of files, or of arrays in memory.

use crate::error::{bad_input, raised};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::types::{PyDict, PyDictMethods};
use pyo3::{Bound, PyResult, Python, pyclass, pymethods};
use sealegs::model::InputHold;
use sealegs::sysid::Run;
use sealegs::{Bench, Role, RunColumns};
use std::path::PathBuf;

/// A run as Python gives it: name, role, scenario, columns, and the times between which its rows count.
type GivenRun<'py> =
    (String, String, Option<String>, Vec<(String, PyReadonlyArray1<'py, f64>)>, (Option<f64>, Option<f64>));

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
    #[pyo3(signature = (name, bench, model, runs, noise_std, inputs, hold, sample_rate_hz))]
    #[allow(clippy::too_many_arguments, reason = "the Python package names them")]
    fn build(
        name: &str,
        bench: &str,
        model: &str,
        runs: Vec<GivenRun<'_>>,
        noise_std: Vec<(String, f64)>,
        inputs: Vec<String>,
        hold: &str,
        sample_rate_hz: Option<f64>,
    ) -> PyResult<Self> {
        let bench = bench_of(bench)?;
        let mut builder = sealegs::Campaign::builder(name, bench, model).hold(hold_of(hold)?);
        for (channel, std) in noise_std {
            builder = builder.noise_std(channel, std);
        }
        for input in inputs {
            builder = builder.input(input);
        }
        if let Some(rate) = sample_rate_hz {
            builder = builder.sample_rate_hz(rate);
        }
        for (name, role, scenario, columns, (from_s, to_s)) in runs {
            let role = match role.as_str() {
                "fit" => Role::Fit,
                "holdout" => Role::Holdout,
                other => {
                    return Err(bad_input(format!("{name}: unknown role '{other}' (known: fit, holdout)")));
                }
            };
            let columns = columns
                .into_iter()
                .map(|(channel, values)| (channel, values.as_array().iter().copied().collect::<Vec<f64>>()));
            let mut run = RunColumns::new(name, role, columns);
            if let Some(scenario) = scenario {
                run = run.scenario(scenario);
            }
            if let Some(from_s) = from_s {
                run = run.from_s(from_s);
            }
            if let Some(to_s) = to_s {
                run = run.to_s(to_s);
            }
            builder = builder.run(run);
        }
        Ok(Self { inner: builder.build().map_err(|e| raised(e.into()))? })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    #[getter]
    fn bench(&self) -> &'static str {
        self.inner.bench.as_str()
    }

    /// The actuator that the campaign names; for a leg its scenario.
    #[getter]
    fn model(&self) -> &str {
        self.inner.scenario.as_deref().unwrap_or(&self.inner.actuator)
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

fn bench_of(name: &str) -> PyResult<Bench> {
    match name {
        "locked" => Ok(Bench::Locked),
        "pendulum" => Ok(Bench::Pendulum),
        "leg" => Ok(Bench::Leg),
        other => Err(bad_input(format!("unknown bench '{other}' (known: locked, pendulum, leg)"))),
    }
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
