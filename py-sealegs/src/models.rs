//! Models as JSON: what a file says, key by key, and back.

use crate::error::{bad_input, raised};
use pyo3::{PyResult, pyfunction};
use sealegs::actuator::ActuatorSpec;
use sealegs::leg::robot::Robot;
use sealegs::leg::scenario::preset_names as scenario_names;
use sealegs::{Bench, Campaign, ModelSource, Scenario};

/// How messages call a model that came as a dictionary.
const GIVEN: &str = "the model";

/// Names of what comes with the package: scenarios, robots, actuators.
#[pyfunction]
pub fn preset_names() -> (Vec<&'static str>, Vec<&'static str>, Vec<&'static str>) {
    (scenario_names(), Robot::preset_names(), ActuatorSpec::preset_names())
}

/// An actuator's file as JSON, by the name of its preset or file.
#[pyfunction]
pub fn actuator_model(name: &str) -> PyResult<String> {
    json_of(&ActuatorSpec::load(name, None).map_err(|e| raised(e.into()))?.to_toml())
}

/// A scenario's file as JSON, by the name of its preset or file.
#[pyfunction]
pub fn scenario_model(name: &str) -> PyResult<String> {
    let scenario = Scenario::load(name, &[]).map_err(|e| raised(e.into()))?;
    json_of(&toml::to_string(&scenario).map_err(bad_input)?)
}

/// TOML as JSON.
pub fn json_of(text: &str) -> PyResult<String> {
    let table: toml::Table = text.parse().map_err(bad_input)?;
    serde_json::to_string(&table).map_err(bad_input)
}

/// JSON as TOML; keys without a value are left out.
fn toml_of(json: &str) -> PyResult<String> {
    fn stated(value: serde_json::Value) -> Option<toml::Value> {
        use serde_json::Value;
        Some(match value {
            Value::Null => return None,
            Value::Bool(flag) => flag.into(),
            Value::Number(n) => match n.as_i64() {
                Some(whole) => whole.into(),
                None => n.as_f64()?.into(),
            },
            Value::String(text) => text.into(),
            Value::Array(items) => toml::Value::Array(items.into_iter().filter_map(stated).collect()),
            Value::Object(keys) => {
                let stated = keys.into_iter().filter_map(|(key, value)| Some((key, stated(value)?)));
                toml::Value::Table(stated.collect())
            }
        })
    }
    let value: serde_json::Value = serde_json::from_str(json).map_err(bad_input)?;
    let table = stated(value).ok_or_else(|| bad_input(format!("{GIVEN} is empty")))?;
    toml::to_string(&table).map_err(bad_input)
}

/// A scenario from JSON.
pub fn scenario_of(json: &str, overrides: &[String]) -> PyResult<Scenario> {
    Scenario::from_toml(&toml_of(json)?, GIVEN, overrides).map_err(|e| raised(e.into()))
}

/// An actuator from JSON.
pub fn actuator_of(json: &str) -> PyResult<ActuatorSpec> {
    ActuatorSpec::from_toml(&toml_of(json)?, GIVEN).map_err(|e| raised(e.into()))
}

/// The model of a campaign: none (its own), a name or file, or a dictionary as JSON.
pub fn source(campaign: &Campaign, name: Option<String>, json: Option<&str>) -> PyResult<ModelSource> {
    Ok(match (name, json) {
        (_, Some(json)) if campaign.bench == Bench::Leg => scenario_of(json, &[])?.into(),
        (_, Some(json)) => actuator_of(json)?.into(),
        (Some(name), None) => ModelSource::File(name.into()),
        (None, None) => ModelSource::Campaign,
    })
}
