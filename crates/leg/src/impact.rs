//! A sweep of drops: heights times spring settings, every drop on its own core, the table in fixed order.

use crate::LegError;
use crate::run::{RunResult, run};
use crate::scenario::{Scenario, SweepSpec};
use crate::simulation::{ActuatorModel, Event, LegDescription, Observer, Sample, Simulation};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the sweep found, one row for each height and spring, heights first.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ImpactTable {
    /// The scenario's name.
    pub scenario: String,
    /// Integration step, s.
    pub step_s: f64,
    /// The rows.
    pub rows: Vec<ImpactRow>,
}

/// One drop.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ImpactRow {
    /// Drop height, m.
    pub height_m: f64,
    /// Spring setting of all actuators.
    pub spring: String,
    /// Peak normal force of the ground, N.
    pub ground_force_n: f64,
    /// When, s.
    pub ground_force_time_s: f64,
    /// The actuators.
    pub actuators: Vec<ImpactActuator>,
    /// The worst residual of the energy balance as a ratio of the energy in motion.
    pub energy_residual: f64,
    /// Why the run stopped before its end, if it did.
    pub stopped: Option<String>,
    /// With `check`: the greatest change of any peak force at half the step, as a ratio of the peak.
    pub change_at_half_step: Option<f64>,
    /// With `check`: which peak changes most.
    pub changes_most: Option<String>,
}

/// One actuator in one drop. A margin is what is allowed over what was asked: below 1 the limit is exceeded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ImpactActuator {
    /// Its name.
    pub name: String,
    /// Peak force on link 1, N, with its sign (compression positive).
    pub force_1_n: f64,
    /// Peak force on link 2, N.
    pub force_2_n: f64,
    /// Peak deflection of the spring, m.
    pub deflection_m: f64,
    /// Peak bending stress, Pa; `None` for a spring without a beam in the load path.
    pub stress_pa: Option<f64>,
    /// Rated force over peak force.
    pub force_margin: Option<f64>,
    /// Yield strength over peak stress.
    pub stress_margin: Option<f64>,
}

impl ImpactRow {
    /// The greatest actuator force of the row, N, with its actuator's name.
    #[must_use]
    pub fn greatest_force(&self) -> (f64, &str) {
        self.actuators
            .iter()
            .map(|a| (a.force_1_n.abs().max(a.force_2_n.abs()), a.name.as_str()))
            .fold((0.0, ""), |best, next| if next.0 > best.0 { next } else { best })
    }

    /// All peak forces with their names, the ground's first.
    fn forces(&self) -> impl Iterator<Item = (String, f64)> {
        let actuators = self.actuators.iter().flat_map(|a| {
            [(format!("{} F1", a.name), a.force_1_n.abs()), (format!("{} F2", a.name), a.force_2_n.abs())]
        });
        std::iter::once(("ground".to_owned(), self.ground_force_n)).chain(actuators)
    }
}

/// Keeps the actuators' limits, and lets somebody else watch.
struct Limits<'a> {
    actuators: Vec<ActuatorModel>,
    watcher: &'a mut dyn Observer,
}

impl Observer for Limits<'_> {
    fn start(&mut self, leg: &LegDescription) -> Result<(), LegError> {
        self.actuators.clone_from(&leg.actuators);
        self.watcher.start(leg)
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), LegError> {
        self.watcher.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), LegError> {
        self.watcher.event(event)
    }
}

/// Watches nothing.
struct Nobody;

impl Observer for Nobody {
    fn start(&mut self, _: &LegDescription) -> Result<(), LegError> {
        Ok(())
    }

    fn sample(&mut self, _: &Sample) -> Result<(), LegError> {
        Ok(())
    }
}

/// One drop that is to be done: it can be done anywhere, and comes out the same.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpactDrop {
    /// Drop height, m.
    pub height_m: f64,
    /// Spring setting of all actuators.
    pub spring: String,
    scenario: Scenario,
}

impl ImpactDrop {
    /// Drops, and with `check` drops once more at half the step.
    ///
    /// # Errors
    ///
    /// What is wrong with the scenario or the spring setting.
    pub fn run(&self, check: bool) -> Result<ImpactRow, LegError> {
        self.watched(check, &mut Nobody)
    }

    /// As [`ImpactDrop::run`], with an observer of the drop (not of that at half the step).
    ///
    /// # Errors
    ///
    /// As [`ImpactDrop::run`], and what the observer reports.
    pub fn watched(&self, check: bool, watcher: &mut dyn Observer) -> Result<ImpactRow, LegError> {
        let row = one(&self.scenario, self.height_m, &self.spring, watcher)?;
        if check { checked(&self.scenario, row) } else { Ok(row) }
    }
}

/// The drops of a sweep from all heights with all springs (each for all actuators), heights first.
///
/// # Errors
///
/// What is wrong with the scenario, a height or a spring setting.
pub fn drops(scenario: &Scenario, over: &SweepSpec) -> Result<Vec<ImpactDrop>, LegError> {
    if over.heights_m.is_empty() || over.springs.is_empty() {
        let problem = "needs at least one height and one spring setting".to_owned();
        return Err(LegError::scenario(&scenario.name, "sweep", problem));
    }
    if let Some(bad) = over.heights_m.iter().find(|h| !(h.is_finite() && **h >= 0.0)) {
        let problem = format!("{bad}: must be zero or positive, and finite");
        return Err(LegError::scenario(&scenario.name, "sweep.heights_m", problem));
    }
    let drop = |height_m: f64, spring: &String| {
        let mut scenario = scenario.clone();
        scenario.start.drop_height_m = height_m;
        scenario.actuators.spring = Some(spring.clone());
        scenario.actuator.values_mut().for_each(|a| a.spring = None);
        ImpactDrop { height_m, spring: spring.clone(), scenario }
    };
    for spring in &over.springs {
        Simulation::new(&drop(over.heights_m[0], spring).scenario)?;
    }
    Ok(over.heights_m.iter().flat_map(|h| over.springs.iter().map(move |s| drop(*h, s))).collect())
}

/// Drops the scenario's robot from all heights with all springs (each for all actuators). With `check` every
/// drop is repeated at half the step. `done` is called once for each finished drop, from any thread.
///
/// # Errors
///
/// What is wrong with the scenario, a height or a spring setting: nothing is swept then.
pub fn sweep(
    scenario: &Scenario,
    over: &SweepSpec,
    check: bool,
    done: &(dyn Fn() + Sync),
) -> Result<ImpactTable, LegError> {
    Ok(sweep_watched(scenario, over, check, done, || Nobody)?.0)
}

/// As [`sweep`], with an observer of its own for every drop; they come back in the order of the rows.
///
/// # Errors
///
/// As [`sweep`], and what an observer reports.
pub fn sweep_watched<O: Observer + Send>(
    scenario: &Scenario,
    over: &SweepSpec,
    check: bool,
    done: &(dyn Fn() + Sync),
    watcher: impl Fn() -> O + Sync,
) -> Result<(ImpactTable, Vec<O>), LegError> {
    // Results come back in the order of the drops, whichever thread ran them.
    let rows: Result<Vec<(ImpactRow, O)>, LegError> = drops(scenario, over)?
        .par_iter()
        .map(|drop| {
            let mut watcher = watcher();
            let row = drop.watched(check, &mut watcher)?;
            done();
            Ok((row, watcher))
        })
        .collect();
    let (rows, watchers) = rows?.into_iter().unzip();
    Ok((ImpactTable { scenario: scenario.name.clone(), step_s: scenario.step_s, rows }, watchers))
}

fn one(
    drop: &Scenario,
    height_m: f64,
    spring: &str,
    watcher: &mut dyn Observer,
) -> Result<ImpactRow, LegError> {
    let mut limits = Limits { actuators: Vec::new(), watcher };
    let RunResult { peaks, worst_energy_residual, stopped, .. } = run(drop, &mut limits)?;
    let actuators = peaks.actuators.iter().zip(&limits.actuators).map(|(p, m)| {
        let force = p.force_1_n.value.abs().max(p.force_2_n.value.abs());
        let stress = Some(p.stress_pa.value).filter(|_| m.limits.stress_per_force_pa > 0.0);
        ImpactActuator {
            name: p.name.clone(),
            force_1_n: p.force_1_n.value,
            force_2_n: p.force_2_n.value,
            deflection_m: p.deflection_m.value,
            stress_pa: stress,
            force_margin: m.limits.rated_force.filter(|_| force > 0.0).map(|r| r / force),
            stress_margin: stress.filter(|s| *s > 0.0).and_then(|s| m.limits.yield_stress_pa.map(|y| y / s)),
        }
    });
    Ok(ImpactRow {
        height_m,
        spring: spring.to_owned(),
        ground_force_n: peaks.ground_force_n.value,
        ground_force_time_s: peaks.ground_force_n.time_s,
        actuators: actuators.collect(),
        energy_residual: worst_energy_residual,
        stopped,
        change_at_half_step: None,
        changes_most: None,
    })
}

/// The row with its change at half the step. A force that is small beside the row's greatest actuator force
/// changes nobody's mind: changes count against at least a tenth of that.
fn checked(drop: &Scenario, row: ImpactRow) -> Result<ImpactRow, LegError> {
    let fine = Scenario { step_s: 0.5 * drop.step_s, ..drop.clone() };
    let half = one(&fine, row.height_m, &row.spring, &mut Nobody)?;
    let least = 0.1 * row.greatest_force().0;
    let (change, name) = row
        .forces()
        .zip(half.forces())
        .map(|((name, a), (_, b))| ((a - b).abs() / b.max(least).max(f64::MIN_POSITIVE), name))
        .fold((0.0, String::new()), |worst, next| if next.0 > worst.0 { next } else { worst });
    Ok(ImpactRow { change_at_half_step: Some(change), changes_most: Some(name), ..row })
}
