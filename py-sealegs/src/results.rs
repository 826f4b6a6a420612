//! Comparison, diagnosis and addition, each as JSON, text, report, curves and recording.

use crate::campaign::{Campaign, array};
use crate::error::{bad_input, raised};
use crate::models::{json_of, source};
use crate::work::watched;
use pyo3::types::{PyDict, PyDictMethods, PyList, PyListMethods};
use pyo3::{Bound, Py, PyAny, PyResult, Python, pyclass, pyfunction, pymethods};
use sealegs::recorder::recording::{self, Output};
use sealegs::{ModelSource, Options};
use std::path::PathBuf;
use std::time::Duration;

/// The options of a verb.
fn given(options: Options, model: ModelSource, own_effects: Vec<PathBuf>, call: &str) -> Options {
    own_effects.into_iter().fold(options.model(model).command(call), Options::own_effect)
}

/// Where the model fails on a campaign.
#[pyfunction]
#[pyo3(signature = (campaign, model, model_json, own_effects, as_is, tell))]
pub fn compare(
    py: Python<'_>,
    campaign: &Campaign,
    model: Option<String>,
    model_json: Option<&str>,
    own_effects: Vec<PathBuf>,
    as_is: bool,
    tell: Option<Py<PyAny>>,
) -> PyResult<Comparison> {
    let model = source(&campaign.inner, model, model_json)?;
    let inner = watched(py, tell.as_ref(), |options| {
        let options = given(options, model, own_effects, "sealegs.compare").as_is(as_is);
        sealegs::compare(&campaign.inner, options)
    })?;
    Ok(Comparison { inner })
}

/// Which effect the model lacks. `how` is whether a log that is not what its header says is diagnosed all the same, and after how many
/// seconds the search ends.
#[pyfunction]
#[pyo3(signature = (campaign, model, model_json, own_effects, how, tell))]
pub fn diagnose(
    py: Python<'_>,
    campaign: &Campaign,
    model: Option<String>,
    model_json: Option<&str>,
    own_effects: Vec<PathBuf>,
    how: (bool, Option<f64>),
    tell: Option<Py<PyAny>>,
) -> PyResult<Diagnosis> {
    let model = source(&campaign.inner, model, model_json)?;
    let (force, at_most) = (how.0, how.1.map(seconds).transpose()?);
    let inner = watched(py, tell.as_ref(), |options| {
        let options = given(options, model, own_effects, "sealegs.diagnose").force(force);
        let options = at_most.into_iter().fold(options, Options::search_at_most);
        sealegs::diagnose(&campaign.inner, options)
    })?;
    Ok(Diagnosis { inner })
}

/// A time in seconds.
fn seconds(seconds: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(seconds)
        .map_err(|_| bad_input(format!("at_most: {seconds} is no time in seconds")))
}

/// The model with effects added.
#[pyfunction]
#[pyo3(signature = (effects, campaign, model, model_json, own_effects, tell))]
pub fn add(
    py: Python<'_>,
    effects: Vec<String>,
    campaign: &Campaign,
    model: Option<String>,
    model_json: Option<&str>,
    own_effects: Vec<PathBuf>,
    tell: Option<Py<PyAny>>,
) -> PyResult<Addition> {
    let model = source(&campaign.inner, model, model_json)?;
    let inner = watched(py, tell.as_ref(), |options| {
        sealegs::add(&effects, &campaign.inner, given(options, model, own_effects, "sealegs.add"))
    })?;
    Ok(Addition { inner })
}

/// Declares what all three results have in common.
macro_rules! shown {
    ($name:ident, $text:ident) => {
        #[pymethods]
        impl $name {
            /// The numbers, as the program's `--json` writes them.
            fn to_json(&self) -> PyResult<String> {
                self.inner.to_json().map_err(raised)
            }

            /// The result in one sentence.
            #[getter]
            fn sentence(&self) -> &str {
                self.inner.sentence()
            }

            /// What the program prints.
            fn to_text(&self) -> PyResult<String> {
                $text(&self.inner)
            }

            /// The report as one HTML file.
            fn to_html(&self, py: Python<'_>) -> PyResult<String> {
                py.detach(|| self.inner.to_html()).map_err(raised)
            }

            /// Measured, before and after, run by run.
            fn curves<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
                curves(py, &py.detach(|| self.inner.recording()).map_err(raised)?)
            }

            /// Writes a recording for Rerun.
            fn write_recording(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
                let write =
                    || -> sealegs::Result<()> { Ok(self.inner.recording()?.write(&Output::File(path))?) };
                py.detach(write).map_err(raised)
            }
        }
    };
}

/// Where a model fails.
#[pyclass(frozen, module = "sealegs._core")]
pub struct Comparison {
    inner: sealegs::Comparison,
}

fn comparison_text(comparison: &sealegs::Comparison) -> PyResult<String> {
    comparison.to_text().map_err(raised)
}

shown!(Comparison, comparison_text);

/// What a model lacks.
#[pyclass(frozen, module = "sealegs._core")]
pub struct Diagnosis {
    inner: sealegs::Diagnosis,
}

#[allow(clippy::unnecessary_wraps, reason = "one signature for all three results")]
fn diagnosis_text(diagnosis: &sealegs::Diagnosis) -> PyResult<String> {
    Ok(diagnosis.to_text())
}

shown!(Diagnosis, diagnosis_text);

/// A better model.
#[pyclass(frozen, module = "sealegs._core")]
pub struct Addition {
    inner: sealegs::Addition,
}

#[allow(clippy::unnecessary_wraps, reason = "one signature for all three results")]
fn addition_text(addition: &sealegs::Addition) -> PyResult<String> {
    Ok(addition.to_text())
}

shown!(Addition, addition_text);

/// What only a diagnosis has; PyO3 admits one block of methods a class, so this is a function.
#[pyfunction]
pub fn plan(diagnosis: &Diagnosis, folder: PathBuf) -> PyResult<Option<String>> {
    diagnosis.inner.plan(&folder).map_err(raised)
}

/// The model with the effects that a diagnosis names, at its values; none where it names nothing.
#[pyfunction]
pub fn better(diagnosis: &Diagnosis) -> Option<Addition> {
    diagnosis.inner.better().map(|inner| Addition { inner })
}

/// The model file of an addition that will lie in a folder, of one unit where there are several: as TOML, and as JSON.
#[pyfunction]
#[pyo3(signature = (addition, folder, unit = None))]
pub fn model_file(addition: &Addition, folder: PathBuf, unit: Option<&str>) -> PyResult<(String, String)> {
    let text = match unit {
        None => addition.inner.model_file(&folder),
        Some(unit) => addition.inner.model_file_of(unit, &folder),
    };
    let text = text.map_err(raised)?;
    let json = json_of(&text)?;
    Ok((text, json))
}

/// A recording's curves as dictionaries of arrays.
fn curves<'py>(py: Python<'py>, recording: &recording::Comparison) -> PyResult<Bound<'py, PyList>> {
    let runs = PyList::empty(py);
    for run in &recording.runs {
        let channels = PyDict::new(py);
        for channel in &run.channels {
            let curve = PyDict::new(py);
            curve.set_item("unit", &channel.unit)?;
            curve.set_item("measured", array(py, &channel.measured))?;
            curve.set_item("before", channel.before.as_ref().map(|v| array(py, v)))?;
            curve.set_item("after", channel.after.as_ref().map(|v| array(py, v)))?;
            channels.set_item(&channel.name, curve)?;
        }
        let entry = PyDict::new(py);
        entry.set_item("name", &run.name)?;
        entry.set_item("time_s", array(py, &run.time_s))?;
        entry.set_item("channels", channels)?;
        runs.append(entry)?;
    }
    Ok(runs)
}
