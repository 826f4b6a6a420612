//! Refits a model's free parameters inside their bounds, with what is known of them beforehand.
//!
//! The cost is half the sum of squares of
//!
//! - every residual in noise units, the sensors' gain and bias solved inside (see [`crate::nuisance`]),
//! - the sensors' prior rows,
//! - for each free parameter with a stated tolerance, `(value - nominal) / prior_std`, times the residual's own deviation
//!   in noise units where that is no noise: what is known is weighed against independent samples of that size.
//!
//! It is minimised by Levenberg and Marquardt's method: Gauss-Newton steps, damped in proportion to each
//! coordinate's own curvature, on the parameters that are not held at a bound. Derivatives are finite
//! differences; simulations run in parallel over parameters and runs, sums are taken in a fixed order. A
//! simulation that fails (a state that runs away) costs infinitely much, and the step is rejected.
//!
//! Standard errors are explained in [`FittedParameter::std`].

mod coordinates;
mod geodesic;
mod jacobian;
mod levenberg;
mod rescale;
mod secant;
mod signature;
mod steps;
mod uncertainty;

pub use coordinates::Bound;
pub(crate) use jacobian::dot;
pub use jacobian::{Difference, JacobianBlock};
pub(crate) use rescale::along_units;
pub use secant::KnownColumns;
pub use signature::Signatures;

use crate::data::{Data, Evaluation};
use crate::{Error, nuisance::Sensor};
use coordinates::Coordinates;
use levenberg::Search;
use nalgebra::DMatrix;
use sealegs_model::Model;
use std::sync::Arc;

/// How a fit is done.
#[derive(Debug, Clone, PartialEq)]
pub struct FitOptions {
    /// Values to start from in place of the nominal ones, in the order of the model's parameters.
    pub start: Option<Vec<f64>>,
    /// At most so many starting points: the first, then others from [`sealegs_model::Parameter::starts`].
    pub starts: usize,
    /// Steps that each start gets before the best of them goes on alone.
    pub race_steps: usize,
    /// At most so many steps.
    pub max_steps: usize,
    /// Ends when a step gains less than this, in units of cost times the mean squared residual (where
    /// that is above 1): 0.5 is one standard error of a parameter.
    pub tolerance: f64,
    /// Derivatives at the solution, for standard errors.
    pub difference: Difference,
    /// Only parameters whose name begins so are free; all others keep the start's values.
    pub only: Option<String>,
    /// The parameters of these names are not free, and keep the start's values.
    pub held: Vec<String>,
    /// Whether parameters that are held in a search only ([`sealegs_model::Parameter::freed_at_last`]) are free.
    pub last: bool,
    /// Whether a step that keeps its promise brings the derivatives up to date by itself, in place of a simulation
    /// for every parameter; they are then simulated only where a step fails, and at the end.
    pub secants: bool,
    /// Whether sets are compared only: gains of a thousandth of the cost do not matter to a fit without any derivatives of its
    /// own.
    pub compares: bool,
    /// Derivatives that are known from nearby, to begin with.
    pub columns: Option<Arc<KnownColumns>>,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            start: None,
            starts: 6,
            race_steps: 3,
            max_steps: 40,
            tolerance: 1e-3,
            difference: Difference::Central,
            only: None,
            held: Vec::new(),
            last: false,
            secants: false,
            compares: false,
            columns: None,
        }
    }
}

/// Gain of a step with which a fit of a model that is dear to simulate is content (see [`FitOptions::tolerance`]).
const DEAR_TOLERANCE: f64 = 0.3;

impl FitOptions {
    /// What suits a model.
    #[must_use]
    pub fn of(model: &dyn Model) -> Self {
        let usual = Self::default();
        if model.is_dear() { Self { secants: true, tolerance: DEAR_TOLERANCE, ..usual } } else { usual }
    }
}

/// A parameter after a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedParameter {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The fitted value.
    pub value: f64,
    /// The nominal value, about which its prior stands.
    pub nominal: f64,
    /// One standard deviation of what was known beforehand.
    pub prior_std: Option<f64>,
    /// One standard error; 0 for a fixed parameter.
    ///
    /// Where the residual is at the noise floor this is the usual `(J'J + priors)^-1`. Where the model is
    /// wrong the residual is neither white nor small, and that would be far too narrow: then the spread of
    /// the score `J'r` between stretches of the runs is used in the middle (a sandwich estimate, each
    /// stretch longer than the residual's memory). It describes how far apart the values would be on other
    /// data of this kind under the same wrong model, not the distance from the true value.
    pub std: f64,
    /// On which bound it ended, if on one.
    pub at_bound: Option<Bound>,
    /// Whether the data say anything: the standard error is clearly below the prior's, or below a third of
    /// the admitted range's standard deviation.
    pub felt: bool,
    /// Never changed by a fit.
    pub fixed: bool,
}

/// Two parameters that the data can hardly tell apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Correlation {
    /// Index of the first parameter.
    pub first: usize,
    /// Index of the second.
    pub second: usize,
    /// Between -1 and 1.
    pub value: f64,
}

/// The outcome of a fit, with what later stages build on.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Values in the order of the model's parameters.
    pub values: Vec<f64>,
    /// The same with names, errors and remarks.
    pub parameters: Vec<FittedParameter>,
    /// Indices of the parameters that were free.
    pub free: Vec<usize>,
    /// Covariance of the free parameters, in their units, in that order.
    pub covariance: DMatrix<f64>,
    /// Predictions, sensors and residuals at the solution.
    pub evaluation: Evaluation,
    /// Derivatives of the residual blocks by each free parameter's coordinate, the sensors' gain and bias
    /// projected out; multiply a column by `1 / slopes[k]` for the derivative by the value.
    pub jacobian: Vec<JacobianBlock>,
    /// d value / d coordinate of each free parameter.
    pub slopes: Vec<f64>,
    /// `J'J` plus the priors, by coordinates: the curvature of the cost.
    pub normal: DMatrix<f64>,
    /// Gradient of the cost by coordinates; near zero where no bound holds.
    pub gradient: Vec<f64>,
    /// The cost, priors counted.
    pub cost: f64,
    /// Steps taken.
    pub steps: usize,
    /// Whether the last step gained less than the tolerance.
    pub converged: bool,
    /// Factor between the standard errors used and those of white noise at the noise floor, root mean
    /// square over the free parameters: 1 if the residual is noise.
    pub std_inflation: f64,
    /// Simulations done by this fit.
    pub simulations: u64,
    /// Seconds of experiment that they covered.
    pub simulated_s: f64,
}

impl Fit {
    /// Error of the fit runs: root mean square residual in noise units.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.evaluation.rms
    }

    /// Values by the parameters' names.
    #[must_use]
    pub fn known(&self) -> Vec<(String, f64)> {
        self.parameters.iter().map(|p| (p.name.clone(), p.value)).collect()
    }

    /// Values where each free parameter's coordinate is moved by so much, inside its bounds and no further than a search
    /// goes at once.
    pub(crate) fn shifted(&self, model: &dyn Model, shift: &[f64]) -> Vec<f64> {
        let coordinates = Coordinates { free: self.free.clone(), ..Coordinates::new(model.parameters()) };
        let mut u = coordinates.coordinates(&self.values);
        for (k, u) in u.iter_mut().enumerate() {
            let most = coordinates.largest_step(k);
            *u += shift[k].clamp(-most, most);
        }
        coordinates.values(&u, &self.values)
    }

    /// The sensors, channel by channel.
    #[must_use]
    pub fn sensors(&self) -> &[Sensor] {
        &self.evaluation.sensors
    }

    /// Correlation of the errors of two free parameters, by their places among the free ones; 0 where one has none.
    #[must_use]
    pub fn correlation(&self, a: usize, b: usize) -> f64 {
        let c = &self.covariance;
        let size = (c[(a, a)] * c[(b, b)]).sqrt();
        if size > 0.0 { (c[(a, b)] / size).clamp(-1.0, 1.0) } else { 0.0 }
    }

    /// Pairs of free parameters whose errors are correlated more than `least` in magnitude.
    #[must_use]
    pub fn correlations(&self, least: f64) -> Vec<Correlation> {
        let mut pairs = Vec::new();
        for a in 0..self.free.len() {
            for b in a + 1..self.free.len() {
                let value = self.correlation(a, b);
                if value.abs() > least {
                    pairs.push(Correlation { first: self.free[a], second: self.free[b], value });
                }
            }
        }
        pairs
    }
}

/// Fits a model's free parameters to the data. Without a given start every discrete choice that the model
/// leaves (a fixed parameter with `starts`) is tried, and the one of lowest cost is kept, of [equals](EQUAL_COST) the
/// first.
///
/// # Errors
///
/// [`Error::NoStart`] if no starting point can be simulated.
pub fn fit(data: &Data, model: &dyn Model, options: &FitOptions) -> Result<Fit, Error> {
    if options.start.is_some() {
        return fit_from(data, model, options);
    }
    let mut all = Vec::new();
    for start in choices(model) {
        all.push(fit_from(data, model, &FitOptions { start: Some(start), ..options.clone() })?);
    }
    let costs: Vec<f64> = all.iter().map(|f| f.cost).collect();
    match first_of_the_best(&costs, EQUAL_COST) {
        Some(first) => Ok(all.swap_remove(first)),
        None => fit_from(data, model, options),
    }
}

/// Costs that differ by less are equal: a likelihood ratio of e^10 is decisive.
pub const EQUAL_COST: f64 = 10.0;

/// The first whose cost is above the least by no more than `equal`; `None` of none.
#[must_use]
pub fn first_of_the_best(costs: &[f64], equal: f64) -> Option<usize> {
    let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
    costs.iter().position(|cost| *cost <= least + equal)
}

/// The nominal values with every combination of the model's discrete choices.
#[must_use]
pub fn choices(model: &dyn Model) -> Vec<Vec<f64>> {
    let mut all = vec![model.parameters().iter().map(|p| p.value).collect::<Vec<f64>>()];
    for (i, p) in model.parameters().iter().enumerate().filter(|(_, p)| p.fixed && !p.starts.is_empty()) {
        all = p
            .starts
            .iter()
            .flat_map(|&choice| {
                all.iter().map(move |values| {
                    let mut values = values.clone();
                    values[i] = choice;
                    values
                })
            })
            .collect();
    }
    all
}

fn fit_from(data: &Data, model: &dyn Model, options: &FitOptions) -> Result<Fit, Error> {
    let before = data.work();
    let mut parameters = model.parameters().to_vec();
    if let Some(only) = &options.only {
        parameters.iter_mut().for_each(|p| p.fixed |= !p.name.starts_with(only.as_str()));
    }
    parameters.iter_mut().for_each(|p| {
        p.fixed = (p.fixed && !(options.last && p.freed_at_last)) || options.held.contains(&p.name);
    });
    let coordinates = Coordinates::new(&parameters);
    let nominal: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    let mut first = options.start.clone().unwrap_or_else(|| nominal.clone());
    first.resize(nominal.len(), 0.0);

    let mut searches = Vec::new();
    let mut failure = None;
    for start in starts(&coordinates, &first, options.starts) {
        match Search::new(data, model, &coordinates, &start) {
            Ok(search) => searches.push(search.with(options)),
            Err(error) => failure = failure.or(Some(error)),
        }
    }
    if searches.len() > 1 {
        for search in &mut searches {
            search.run(data, model, &coordinates, options.race_steps, options.tolerance);
        }
    }
    // The first of equals, so that the order of the starts decides and nothing else.
    let best = searches.into_iter().reduce(|best, other| if other.cost < best.cost { other } else { best });
    let Some(mut search) = best else {
        return Err(match failure {
            Some(Error::Model { run, source }) => Error::NoStart { run, source },
            Some(other) => other,
            None => unreachable!("there is always a first start"),
        });
    };
    let left = options.max_steps.saturating_sub(search.steps);
    search.run(data, model, &coordinates, left, options.tolerance);
    Ok(describe(data, model, &coordinates, search, options.difference, before))
}

/// Everything that a fit returns, at values that are not searched but given.
///
/// # Errors
///
/// As [`fit`].
pub fn at_values(
    data: &Data,
    model: &dyn Model,
    values: &[f64],
    difference: Difference,
) -> Result<Fit, Error> {
    let before = data.work();
    let coordinates = Coordinates::new(model.parameters());
    let search = Search::new(data, model, &coordinates, values)?;
    Ok(describe(data, model, &coordinates, search, difference, before))
}

/// The first start, then one for each other value worth starting from.
fn starts(coordinates: &Coordinates, first: &[f64], most: usize) -> Vec<Vec<f64>> {
    let mut starts = vec![first.to_vec()];
    let longest = coordinates.free.iter().map(|&i| coordinates.parameters[i].starts.len()).max().unwrap_or(0);
    for round in 0..longest {
        for &i in &coordinates.free {
            if let Some(&value) = coordinates.parameters[i].starts.get(round) {
                let mut start = first.to_vec();
                start[i] = value;
                if !starts.contains(&start) {
                    starts.push(start);
                }
            }
        }
    }
    starts.truncate(most.max(1));
    starts
}

fn describe(
    data: &Data,
    model: &dyn Model,
    coordinates: &Coordinates,
    search: Search,
    difference: Difference,
    before: (u64, f64),
) -> Fit {
    let (raw, projected) = search.derivatives(data, model, coordinates, difference);
    let Search { u, evaluation, cost, doubt, steps, converged, .. } = search;
    let (mut normal, mut gradient) = jacobian::normal(&projected, &raw, &evaluation);
    levenberg::add_priors(coordinates, &u, doubt, &mut normal, &mut gradient);
    let slopes: Vec<f64> = (0..u.len()).map(|k| coordinates.slope(k, u[k])).collect();
    let spread = uncertainty::covariance(data, &evaluation, &projected, coordinates, &u, (&normal, doubt));
    let values = evaluation.values.clone();
    let mut parameters: Vec<FittedParameter> = model
        .parameters()
        .iter()
        .zip(&values)
        .map(|(p, &value)| FittedParameter {
            name: p.name.clone(),
            unit: p.unit.clone(),
            value,
            nominal: p.value,
            prior_std: p.prior_std,
            std: 0.0,
            at_bound: None,
            felt: true,
            fixed: true,
        })
        .collect();
    for (k, &i) in coordinates.free.iter().enumerate() {
        let p = &mut parameters[i];
        p.fixed = false;
        p.std = spread.covariance[(k, k)].max(0.0).sqrt();
        p.at_bound = coordinates.bound(k, u[k]);
        p.felt = spread.felt[k];
    }
    let (simulations, simulated_s) = data.work();
    Fit {
        values,
        parameters,
        free: coordinates.free.clone(),
        covariance: spread.covariance,
        evaluation,
        jacobian: projected,
        slopes,
        normal,
        gradient: gradient.iter().copied().collect(),
        cost,
        steps,
        converged,
        std_inflation: spread.inflation,
        simulations: simulations - before.0,
        simulated_s: simulated_s - before.1,
    }
}

#[cfg(test)]
mod tests;
