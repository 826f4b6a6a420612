//! Levenberg and Marquardt's search inside bounds.

use super::coordinates::Coordinates;
use super::jacobian::{self, Difference, Directions, JacobianBlock};
use super::steps::{Proposal, along_flattest, proposal};
use super::uncertainty::AT_THE_FLOOR;
use super::{FitOptions, KnownColumns, geodesic, secant};
use crate::Error;
use crate::data::{Data, Evaluation};
use crate::stats;
use nalgebra::{DMatrix, DVector};
use sealegs_model::Model;
use std::sync::Arc;

/// A search and where it has got to; it can be continued.
pub(super) struct Search {
    pub u: Vec<f64>,
    pub evaluation: Evaluation,
    /// Cost with the parameters' priors.
    pub cost: f64,
    /// See [`doubt`]; it never grows on the way.
    pub doubt: f64,
    pub steps: usize,
    pub converged: bool,
    damping: f64,
    /// Forward far away; central once steps no longer keep their promise, as along a flat direction a forward
    /// difference's error is larger than the slope.
    difference: Difference,
    /// Whether forward differences will do where the model is far from the measurements.
    rough: bool,
    /// Columns taken last, bare and projected, for the steps of the next differences.
    last: Option<(Vec<JacobianBlock>, Vec<JacobianBlock>)>,
    /// How the last columns were taken, if here: [`Difference::Secant`] if they were taken elsewhere.
    taken: Difference,
    /// What of [`FitOptions`] concerns derivatives, where secants do most of the work.
    thrift: Option<Thrift>,
}

/// A place that a search has looked at.
struct Place {
    u: Vec<f64>,
    evaluation: Evaluation,
    /// Cost with the parameters' priors.
    cost: f64,
}

/// The lower of two places; the first of equals.
fn lower(a: Option<Place>, b: Option<Place>) -> Option<Place> {
    [a, b].into_iter().flatten().reduce(|a, b| if b.cost < a.cost { b } else { a })
}

/// A search that simulates for derivatives only where it must.
struct Thrift {
    /// Columns to begin with.
    columns: Option<Arc<KnownColumns>>,
    /// See [`FitOptions::compares`].
    compares: bool,
    /// The differences that say that nothing helps any more.
    finest: Difference,
    /// Whether the last columns still predict what a step does.
    trusted: bool,
    /// What the last step had promised to gain.
    promised: f64,
}

/// Steps that a race with secants tries at one place.
const MOST_REFUSED: usize = 3;

/// Share of the cost below which a gain does not matter to a race with secants.
const RACED: f64 = 1e-3;

/// Share of what the last step promised to gain, above which columns of secants are taken anew.
const CREEP: f64 = 0.3;

/// Above this error, in noise units, the model is wrong and its residual remembers: samples are then worth far
/// less than their number, and a gain of [`RELATIVE`] of the cost is nothing.
const WRONG: f64 = 1.5;
/// See [`WRONG`].
const RELATIVE: f64 = 1e-5;

/// Above this error, in noise units, a search that compares models is content with forward differences, and with steps that
/// gain this share of the cost: what is missing moves the values by far more.
const FAR: f64 = 5.0;
/// See [`FAR`].
const RELATIVE_FAR: f64 = 1e-3;

/// Steps that promise less than this, in units of the mean squared residual (at least 1), leave columns of derivatives
/// as good as they were: 0.5 is one standard error of a parameter.
const SMALL: f64 = 0.5;

/// Ratio of what is known's new weight to its old one down to which the end of a search stays the end.
const SAME_DOUBT: f64 = 0.7;

/// Damping does not fall below this.
const LEAST_DAMPING: f64 = 1e-12;

/// Steps are given up when damping has grown beyond this.
const MOST_DAMPING: f64 = 1e9;

impl Search {
    pub fn new(
        data: &Data,
        model: &dyn Model,
        coordinates: &Coordinates,
        start: &[f64],
    ) -> Result<Self, Error> {
        let u = coordinates.coordinates(start);
        let values = coordinates.values(&u, start);
        let evaluation = data.evaluate(model, &values)?;
        let doubt = doubt(&evaluation);
        let cost = evaluation.cost + doubt * coordinates.prior_cost(&values);
        Ok(Self {
            u,
            evaluation,
            cost,
            doubt,
            steps: 0,
            converged: coordinates.len() == 0,
            damping: 1e-3,
            difference: Difference::Forward,
            rough: false,
            last: None,
            taken: Difference::Secant,
            thrift: None,
        })
    }

    /// The same search with derivatives as these options want them.
    pub fn with(mut self, options: &FitOptions) -> Self {
        self.rough = options.difference == Difference::Forward;
        self.thrift = options.secants.then(|| Thrift {
            columns: options.columns.clone(),
            compares: options.compares && options.difference == Difference::Secant,
            finest: options.difference,
            trusted: true,
            promised: f64::INFINITY,
        });
        self
    }

    /// Derivatives here: bare, and with what the sensors can take up projected out.
    pub fn derivatives(
        &self,
        data: &Data,
        model: &dyn Model,
        coordinates: &Coordinates,
        how: Difference,
    ) -> (Vec<JacobianBlock>, Vec<JacobianBlock>) {
        let along = |how, directions: &Directions| {
            let raw = jacobian::raw(data, model, &self.evaluation, coordinates, &self.u, how, directions);
            let projected = jacobian::projected(data, &self.evaluation, &raw);
            (raw, projected)
        };
        let principal = |(raw, projected): &(Vec<JacobianBlock>, Vec<JacobianBlock>)| {
            Directions::principal(coordinates, &self.u, raw, projected, how)
        };
        if let Some((raw, projected)) =
            self.last.as_ref().filter(|_| self.thrift.is_some() && self.is_taken(how))
        {
            return (raw.clone(), projected.clone());
        }
        match &self.last {
            Some(last) => along(how, &principal(last)),
            None if how == Difference::Forward => along(how, &Directions::first(coordinates)),
            None => {
                let rough = along(Difference::Forward, &Directions::first(coordinates));
                along(how, &principal(&rough))
            }
        }
    }

    /// Takes at most `steps` further steps.
    pub fn run(
        &mut self,
        data: &Data,
        model: &dyn Model,
        coordinates: &Coordinates,
        steps: usize,
        tolerance: f64,
    ) {
        for _ in 0..steps {
            if self.converged {
                return;
            }
            self.steps += 1;
            let (raw, projected) = match self.without_simulations(data, model, coordinates) {
                Some(columns) => columns,
                None => {
                    let columns = self.derivatives(data, model, coordinates, self.difference);
                    self.taken = self.difference;
                    columns
                }
            };
            let (mut a, mut g) = jacobian::normal(&projected, &raw, &self.evaluation);
            self.last = Some((raw, projected));
            add_priors(coordinates, &self.u, self.doubt, &mut a, &mut g);
            self.step(data, model, coordinates, &a, &g, tolerance);
        }
    }

    /// Whether the model is so far from the measurements that a search needs the neighbourhood of the solution only.
    fn is_rough(&self) -> bool {
        self.rough && self.evaluation.rms > FAR
    }

    /// Whether the last columns were taken here, and as well as this or better.
    fn is_taken(&self, how: Difference) -> bool {
        how == Difference::Secant || self.taken == Difference::Central || self.taken == how
    }

    /// The columns that a search with secants has without taking them all.
    fn without_simulations(
        &mut self,
        data: &Data,
        model: &dyn Model,
        coordinates: &Coordinates,
    ) -> Option<(Vec<JacobianBlock>, Vec<JacobianBlock>)> {
        let thrift = self.thrift.as_ref().filter(|t| t.trusted)?;
        if let Some(last) = self.last.take() {
            return Some(last);
        }
        let known = thrift.columns.as_ref()?;
        let missing = known.missing(coordinates, &self.evaluation);
        let along = Directions::only(coordinates, &missing);
        let how = Difference::Forward;
        let mut raw = jacobian::raw(data, model, &self.evaluation, coordinates, &self.u, how, &along);
        known.fill(coordinates, &self.evaluation, &mut raw);
        let projected = jacobian::projected(data, &self.evaluation, &raw);
        Some((raw, projected))
    }

    /// One accepted step, or the end.
    fn step(
        &mut self,
        data: &Data,
        model: &dyn Model,
        coordinates: &Coordinates,
        a: &DMatrix<f64>,
        g: &DVector<f64>,
        tolerance: f64,
    ) {
        let mut enough = tolerance * self.evaluation.rms.powi(2).max(1.0);
        if self.evaluation.rms > WRONG {
            enough = enough.max(RELATIVE * self.cost);
        }
        if self.is_rough() {
            enough = enough.max(RELATIVE_FAR * self.cost);
        }
        // A race is not won by what no longer predicts a step.
        let races = self.thrift.as_ref().is_some_and(|t| t.compares);
        if races {
            enough = enough.max(RACED * self.cost);
        }
        let mut refused = 0;
        while self.damping < MOST_DAMPING && !(races && refused == MOST_REFUSED) {
            let (moved, promised) = match proposal(coordinates, &self.u, a, g, self.damping) {
                Proposal::Step(moved, promised) => (moved, promised),
                Proposal::Singular => {
                    self.damping = (self.damping * 30.0).max(1e-10);
                    continue;
                }
                Proposal::Stuck => break,
            };
            if promised < enough {
                // Along a direction that only priors tell anything of it is the damping that promises so little.
                if refused == 0 && self.damping > LEAST_DAMPING {
                    self.damping = (self.damping * 1e-3).max(LEAST_DAMPING);
                    continue;
                }
                break;
            }
            let taken = self.taken;
            let straight = self.visit(data, model, coordinates, moved);
            let accelerated = straight
                .as_ref()
                .filter(|place| self.cost - place.cost < 0.5 * promised)
                .and_then(|place| self.accelerated(data, model, coordinates, place, (a, self.damping)));
            if let Some(gained) =
                lower(straight, accelerated).and_then(|place| self.accept(data, coordinates, place, enough))
            {
                if promised < SMALL * self.evaluation.rms.powi(2).max(1.0) {
                    self.taken = taken;
                }
                // A step that kept its promise deserves more trust. Directions that only priors tell anything of
                // are a million times flatter than others: damping must be able to vanish.
                let (kept, rough) = (gained / promised, self.is_rough());
                match &mut self.thrift {
                    Some(thrift) => {
                        // Secants that have missed a direction creep along it.
                        let creeps = promised > CREEP * thrift.promised;
                        thrift.trusted = (kept > 0.5 && !creeps) || thrift.finest == Difference::Secant;
                        thrift.promised = if creeps { f64::INFINITY } else { promised };
                    }
                    None if kept < 0.5 && !rough => self.difference = Difference::Central,
                    None => {}
                }
                self.damping *= match kept {
                    r if r > 0.5 => 0.03,
                    r if r > 0.2 => 0.3,
                    _ => 4.0,
                };
                self.damping = self.damping.max(LEAST_DAMPING);
                return;
            }
            refused += 1;
            self.damping = (self.damping * 30.0).max(1e-10);
        }
        if self.difference == Difference::Central {
            for (moved, promised) in along_flattest(coordinates, &self.u, (a, g)) {
                let place =
                    (promised >= enough).then(|| self.visit(data, model, coordinates, moved)).flatten();
                if place.and_then(|place| self.accept(data, coordinates, place, enough)).is_some() {
                    self.damping = 1e-3;
                    return;
                }
            }
        }
        // Nothing helps, as far as these columns can tell.
        self.damping = 1e-3;
        match &mut self.thrift {
            Some(thrift) if thrift.finest == Difference::Secant => self.converged = true,
            Some(thrift) if self.taken != thrift.finest && self.taken != Difference::Central => {
                thrift.trusted = false;
                self.difference = thrift.finest;
            }
            Some(_) => self.converged = true,
            None => {
                self.converged = self.is_rough() || self.difference == Difference::Central;
                self.difference = Difference::Central;
            }
        }
    }

    /// The cost at a place; `None` where nothing can be simulated.
    fn visit(&self, data: &Data, model: &dyn Model, coordinates: &Coordinates, u: Vec<f64>) -> Option<Place> {
        let values = coordinates.values(&u, &self.evaluation.values);
        let evaluation = data.evaluate(model, &values).ok()?;
        let cost = evaluation.cost + self.doubt * coordinates.prior_cost(&values);
        cost.is_finite().then_some(Place { u, evaluation, cost })
    }

    /// Where the accelerated step leads that goes with a straight one, if the columns are those of here.
    fn accelerated(
        &self,
        data: &Data,
        model: &dyn Model,
        coordinates: &Coordinates,
        straight: &Place,
        curvature: (&DMatrix<f64>, f64),
    ) -> Option<Place> {
        let (_, columns) = self.last.as_ref().filter(|_| self.thrift.is_none())?;
        let (from, to) = ((&self.u[..], &self.evaluation), (&straight.u[..], &straight.evaluation));
        let end = geodesic::accelerated(coordinates, from, to, columns, curvature)?;
        self.visit(data, model, coordinates, end)
    }

    /// Goes there if the cost falls, and returns by how much; by less than `enough`, the search has converged.
    fn accept(&mut self, data: &Data, coordinates: &Coordinates, place: Place, enough: f64) -> Option<f64> {
        let gained = self.cost - place.cost;
        if gained <= 0.0 {
            return None;
        }
        let Place { u: moved, evaluation, cost } = place;
        self.converged = gained < enough;
        if self.thrift.is_some() {
            if let Some((raw, projected)) = &mut self.last {
                let (before, after) = ((&self.evaluation, &self.u[..]), (&evaluation, &moved[..]));
                secant::update(raw, data, coordinates, before, after);
                *projected = jacobian::projected(data, &evaluation, raw);
            }
            // Columns from elsewhere cannot say that this is the end.
            self.converged &= self.taken != Difference::Secant;
            self.taken = Difference::Secant;
        }
        (self.u, self.evaluation, self.cost) = (moved, evaluation, cost);
        let doubt = doubt(&self.evaluation);
        if doubt < self.doubt {
            // What is known counts less now, and steps that were not worth while may be.
            self.converged &= doubt > SAME_DOUBT * self.doubt;
            self.cost += (doubt - self.doubt) * coordinates.prior_cost(&self.evaluation.values);
            self.doubt = doubt;
        }
        Some(gained)
    }
}

/// Squares of the residual over its independent samples: by how much its variance is more than that of the stated noise, as
/// far as a fit can tell. Where a model lacks something its residual is large and remembers, and taken for noise it would
/// outweigh whatever is known of the parameters, which then run to their bounds in the place of what is missing. What is
/// known counts so much more. 1 at the noise.
fn doubt(at: &Evaluation) -> f64 {
    if at.rms <= AT_THE_FLOOR {
        return 1.0;
    }
    let samples: f64 = at.blocks.iter().map(|b| stats::independent(&b.residual)).sum();
    let squares: f64 = at.blocks.iter().flat_map(|b| &b.residual).map(|r| r * r).sum();
    if squares.is_finite() { (squares / samples.max(1.0)).max(1.0) } else { 1.0 }
}

/// Adds each parameter's prior row to the normal equations, so much heavier.
pub(super) fn add_priors(
    coordinates: &Coordinates,
    u: &[f64],
    weight: f64,
    a: &mut DMatrix<f64>,
    g: &mut DVector<f64>,
) {
    for (k, &x) in u.iter().enumerate() {
        if let Some((row, slope)) = coordinates.prior_row(k, x) {
            a[(k, k)] += weight * slope * slope;
            g[k] += weight * slope * row;
        }
    }
}
