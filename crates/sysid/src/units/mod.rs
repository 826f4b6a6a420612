//! Several units of one kind in one campaign: each with values of its own, the effects shared.
//!
//! A unit's springs, dampers and sensors differ from its twin's within their tolerances; the physics that a model lacks is
//! the same in all of them. So [`PerUnit`] gives the base model's free parameters once for each unit (`damping@left`,
//! `damping@right`), predicts each record with its unit's values, and leaves the effects' parameters as they are. To a fit
//! and to a search it is a model like any other. Gain and bias of sensors are a unit's own through [`crate::data::Channel`].
//! [`errors`] and [`differences`] say what became of each unit.

mod judge;

pub use judge::{Difference, UnitError, UnitValue, differences, error_of, errors};

use crate::{Campaign, Error, Role};
use sealegs_model::{Model, ModelError, Parameter, Prediction, Record};
use std::borrow::Cow;
use std::sync::Arc;

/// What stands between the name of a parameter and its unit's.
const AT: char = '@';

/// The units of a campaign, and which of them each run was recorded on.
#[derive(Debug, PartialEq, Eq)]
struct Units {
    names: Vec<String>,
    /// A record's name and the place of its unit among the names.
    of_record: Vec<(String, usize)>,
}

/// A model of several units. See the [module](self).
#[derive(Debug)]
pub struct PerUnit {
    inner: Box<dyn Model>,
    units: Arc<Units>,
    parameters: Vec<Parameter>,
    /// For each parameter its place in the inner model, and the unit that it belongs to; none if it is shared.
    places: Vec<(usize, Option<usize>)>,
}

/// A parameter's name without its unit, and the unit: `damping@left` is `damping` of `left`. None for what is shared.
///
/// ```
/// use sealegs_sysid::units::split;
///
/// assert_eq!(split("damping@left"), ("damping", Some("left")));
/// assert_eq!(split("sensor-lag@force_1_n.tau_s"), ("sensor-lag@force_1_n.tau_s", None));
/// ```
#[must_use]
pub fn split(parameter: &str) -> (&str, Option<&str>) {
    if is_of_effect(parameter) {
        return (parameter, None);
    }
    parameter.split_once(AT).map_or((parameter, None), |(name, unit)| (name, Some(unit)))
}

/// Whether a parameter is an effect's: those have a point in their names.
fn is_of_effect(parameter: &str) -> bool {
    parameter.contains('.')
}

/// The names of a campaign's units in the order of their first runs; empty where there are fewer than two.
#[must_use]
pub fn of_campaign(campaign: &Campaign) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for unit in campaign.runs.iter().filter_map(|r| r.unit.as_ref()) {
        if !names.contains(unit) {
            names.push(unit.clone());
        }
    }
    if names.len() < 2 { Vec::new() } else { names }
}

/// The model with values for each unit of the campaign; a copy of it where the campaign names fewer than two.
///
/// # Errors
///
/// [`Error::BadFile`] if a run has no unit beside others that have one, if a unit has no fit run, if a unit's name is
/// empty or has a point, an `@` or a slash in it, or if one run's name stands for two units.
pub fn per_unit(campaign: &Campaign, model: &dyn Model) -> Result<Box<dyn Model>, Error> {
    let names = of_campaign(campaign);
    if names.is_empty() {
        return Ok(model.clone_box());
    }
    let bad = |problem: String| Err(Error::bad(&campaign.file, None, Some("unit"), problem));
    if let Some(name) = names.iter().find(|n| n.is_empty() || n.contains(['.', AT, '/', '\\'])) {
        return bad(format!(
            "'{name}' must be a name without '.', '@' and slashes: it becomes a part of names of parameters and files"
        ));
    }
    let mut of_record: Vec<(String, usize)> = Vec::new();
    for run in &campaign.runs {
        let record = &run.record.name;
        let Some(unit) = names.iter().position(|n| run.unit.as_ref() == Some(n)) else {
            return bad(format!("run {record} has none, and others have '{}'", names.join("', '")));
        };
        match of_record.iter().find(|(name, _)| name == record) {
            Some((_, other)) if *other != unit => {
                return bad(format!("run {record} is of '{}' and of '{}'", names[*other], names[unit]));
            }
            Some(_) => {}
            None => of_record.push((record.clone(), unit)),
        }
    }
    let fitted = |name: &String| campaign.runs_of(Role::Fit).any(|r| r.unit.as_ref() == Some(name));
    if campaign.runs_of(Role::Fit).next().is_some()
        && let Some(name) = names.iter().find(|n| !fitted(n))
    {
        return bad(format!("'{name}' has no run with role \"fit\", from which its values could be known"));
    }
    Ok(Box::new(PerUnit::new(model.clone_box(), Arc::new(Units { names, of_record }))))
}

impl PerUnit {
    fn new(inner: Box<dyn Model>, units: Arc<Units>) -> Self {
        let (mut parameters, mut places) = (Vec::new(), Vec::new());
        for (i, p) in inner.parameters().iter().enumerate() {
            if is_of_effect(&p.name) || (p.fixed && !p.freed_at_last) {
                parameters.push(p.clone());
                places.push((i, None));
                continue;
            }
            for (u, unit) in units.names.iter().enumerate() {
                parameters.push(Parameter { name: format!("{}{AT}{unit}", p.name), ..p.clone() });
                places.push((i, Some(u)));
            }
        }
        Self { inner, units, parameters, places }
    }

    fn around(&self, inner: Box<dyn Model>) -> Box<dyn Model> {
        Box::new(Self::new(inner, Arc::clone(&self.units)))
    }

    /// The unit of a record. One that nobody recorded, as an experiment to be proposed, is the first unit's.
    fn unit_of(&self, record: &Record) -> usize {
        self.units.of_record.iter().find(|(name, _)| *name == record.name).map_or(0, |(_, unit)| *unit)
    }

    /// The inner model's values for a record.
    fn values(&self, values: &[f64], record: &Record) -> Vec<f64> {
        let unit = self.unit_of(record);
        let mut own = vec![0.0; self.inner.parameters().len()];
        for (value, (place, of)) in values.iter().zip(&self.places) {
            if of.is_none_or(|of| of == unit) {
                own[*place] = *value;
            }
        }
        own
    }

    /// Names the unit where a value is refused.
    fn named(&self, error: ModelError, record: &Record) -> ModelError {
        match error {
            ModelError::BadParameter { name, value, admitted } if !is_of_effect(&name) => {
                let unit = &self.units.names[self.unit_of(record)];
                ModelError::BadParameter { name: format!("{name}{AT}{unit}"), value, admitted }
            }
            other => other,
        }
    }
}

impl Model for PerUnit {
    sealegs_model::passes_on_to_inner!();

    fn name(&self) -> String {
        format!("{}, units {}", self.inner.name(), self.units.names.join(", "))
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn predict(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> Result<Prediction, ModelError> {
        let own = self.values(values, record);
        self.inner.predict(&own, record, channels).map_err(|e| self.named(e, record))
    }

    fn predict_outputs(
        &self,
        values: &[f64],
        record: &Record,
        channels: &[String],
    ) -> Result<Prediction, ModelError> {
        let own = self.values(values, record);
        self.inner.predict_outputs(&own, record, channels).map_err(|e| self.named(e, record))
    }

    fn concerns(&self, parameter: usize, record: &Record) -> bool {
        self.places.get(parameter).is_some_and(|(place, of)| {
            of.is_none_or(|of| of == self.unit_of(record)) && self.inner.concerns(*place, record)
        })
    }
}

/// A record under the name of its unit, for tables: the unit's name behind a channel's.
#[must_use]
pub fn channel_of<'a>(channel: &'a str, unit: Option<&str>) -> Cow<'a, str> {
    unit.map_or(Cow::Borrowed(channel), |unit| Cow::Owned(format!("{channel} ({unit})")))
}
