//! Campaigns of a leg with something hidden in it: an individual leg, four runs, sensors with errors.

mod hidden;
mod logger;
mod runs;

pub use hidden::{LEG_CATALOGUE, LEG_PAIRS, Plain, leg_place, leg_plain, leg_visible};
pub use logger::LegSensor;

use super::{Draws, Hidden};
use crate::leg::{Instant, LegIndividual, LegReference};
use logger::signals;
use runs::Planned;
use sealegs_leg::LegError;
use sealegs_leg::robot::Robot;
use sealegs_leg::scenario::Scenario;
use std::fmt::Write;

/// The robot of these campaigns.
const ROBOT: &str = "thor-leg";

/// Time between rows, s.
const PERIOD_S: f64 = 1e-3;

/// What the leg does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scene {
    /// It swings on a stand, all its joints moving.
    Swing,
    /// It lands on a vertical rail.
    Drop,
}

impl Scene {
    /// Every one.
    pub const ALL: [Self; 2] = [Self::Swing, Self::Drop];

    /// The scenario that the campaign's model starts from.
    #[must_use]
    pub fn preset(self) -> &'static str {
        match self {
            Self::Swing => "thor-swing",
            Self::Drop => "thor-drop",
        }
    }

    /// Step of the integration, s: halving it changes no signal by a tenth of its noise, whatever is hidden.
    #[must_use]
    pub fn step_s(self) -> f64 {
        match self {
            Self::Swing => 5e-5,
            Self::Drop => 2e-5,
        }
    }
}

/// What is to be made.
#[derive(Debug, Clone)]
pub struct LegOrder {
    /// The campaign's name.
    pub name: String,
    /// What the leg does.
    pub scene: Scene,
    /// Seed of the individual, the motions and the noise.
    pub seed: u64,
    /// What is hidden, its ids with their places.
    pub hidden: Vec<Hidden>,
    /// Step of the integration, s.
    pub step_s: f64,
}

/// A run as it was recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct MadeLegRun {
    /// Its name; its files are `<name>.csv` and `<name>.toml`.
    pub name: &'static str,
    /// Held out rather than fitted.
    pub holdout: bool,
    /// The text of its table.
    pub table: String,
    /// The text of its scenario.
    pub scenario: String,
}

/// A campaign of a leg and the truth about it.
#[derive(Debug, Clone)]
pub struct MadeLeg {
    /// Its name.
    pub name: String,
    /// What the leg does.
    pub scene: Scene,
    /// The sensors with their errors.
    pub sensors: Vec<LegSensor>,
    /// The runs, those to fit on first.
    pub runs: Vec<MadeLegRun>,
    /// The base model's parameters as a model calls them, SI.
    pub parameters: Vec<(String, f64)>,
    /// What is hidden.
    pub hidden: Vec<Hidden>,
}

/// The individual leg of a seed, within one standard deviation of what the actuators' files and the model of the
/// contact state: stiffness 3 %, rotor inertia 6 %, damping 10 %, torque constant 2 %; contact stiffness 6 %, contact
/// damping 10 %.
fn individual(seed: u64, actuators: &[String]) -> LegIndividual {
    let of = |name: &String| {
        let mut d = Draws::of(seed, &format!("individual {name}"));
        [0.03, 0.06, 0.10, 0.02].map(|tolerance| 1.0 + d.between(-tolerance, tolerance))
    };
    let mut d = Draws::of(seed, "individual contact");
    let contact = [0.06, 0.10].map(|tolerance| 1.0 + d.between(-tolerance, tolerance));
    LegIndividual { actuators: actuators.iter().map(of).collect(), contact }
}

/// Joints and actuators by name.
fn names(robot: &Robot) -> (Vec<String>, Vec<String>) {
    let joints = robot.moving_joints().map(|j| j.name.clone()).collect();
    (joints, robot.actuators.iter().map(|a| a.name.clone()).collect())
}

impl LegOrder {
    /// Makes it. The same order gives the same bits.
    ///
    /// # Errors
    ///
    /// [`LegError::NotFinite`] if what is hidden makes the leg run away.
    pub fn make(&self) -> Result<MadeLeg, LegError> {
        let planned = runs::plan(self.scene, self.seed);
        let (sensors, lands) = (self.sensors()?, self.scene == Scene::Drop);
        let individual = self.individual()?;
        let parameters = self.leg(&planned[0], &individual, &[])?.base_parameters();
        let truth = self.truth(&[0, 1, 2, 3], &individual, &self.hidden)?;
        let made = |(planned, truth): (Planned, Vec<Instant>)| {
            let columns: Vec<Vec<String>> = sensors
                .iter()
                .zip(signals(&truth, lands))
                .map(|(sensor, signal)| sensor.column(&signal, planned.name, self.seed))
                .collect();
            let head: Vec<&str> = sensors.iter().map(|s| s.channel.as_str()).collect();
            let mut table = format!("time_s,{}\n", head.join(","));
            for row in 0..truth.len() {
                let _ = write!(table, "{:.3}", row as f64 * PERIOD_S);
                for column in &columns {
                    table.push(',');
                    table.push_str(&column[row]);
                }
                table.push('\n');
            }
            let Planned { name, holdout, scenario } = planned;
            MadeLegRun { name, holdout, table, scenario }
        };
        Ok(MadeLeg {
            name: self.name.clone(),
            scene: self.scene,
            runs: planned.into_iter().zip(truth).map(made).collect(),
            sensors,
            parameters,
            hidden: self.hidden.clone(),
        })
    }

    /// The true signals of the first and the last run in units of their sensors' noise, one after the other.
    ///
    /// # Errors
    ///
    /// As [`LegOrder::make`].
    pub fn true_signals(&self) -> Result<Vec<f64>, LegError> {
        let sensors = self.sensors()?;
        let mut all = Vec::new();
        for run in self.truth(&[0, 3], &self.individual()?, &self.hidden)? {
            for (sensor, signal) in sensors.iter().zip(signals(&run, self.scene == Scene::Drop)) {
                all.extend(signal.iter().map(|s| s / sensor.noise_std()));
            }
        }
        Ok(all)
    }

    /// The sensors of the leg.
    fn sensors(&self) -> Result<Vec<LegSensor>, LegError> {
        let (joints, actuators) = names(&Robot::load(ROBOT, None)?);
        Ok(LegSensor::all(&joints, &actuators, self.scene == Scene::Drop, self.seed))
    }

    /// The individual leg of the seed.
    fn individual(&self) -> Result<LegIndividual, LegError> {
        Ok(individual(self.seed, &names(&Robot::load(ROBOT, None)?).1))
    }

    /// An individual leg in a run with effects in it.
    fn leg(
        &self,
        planned: &Planned,
        individual: &LegIndividual,
        hidden: &[Hidden],
    ) -> Result<LegReference, LegError> {
        let scenario = Scenario::from_toml(&planned.scenario, planned.name, &[])?;
        let leg = LegReference::new(&scenario, Robot::load(ROBOT, None)?, individual)?;
        let put_in = |leg: LegReference, hidden: &Hidden| {
            let values: Vec<f64> = hidden.parameters.iter().map(|p| p.1).collect();
            leg.with(&hidden.id, &values)
        };
        Ok(hidden.iter().fold(leg, put_in))
    }

    /// The true signals of some of the runs of an individual, found side by side.
    fn truth(
        &self,
        runs: &[usize],
        individual: &LegIndividual,
        hidden: &[Hidden],
    ) -> Result<Vec<Vec<Instant>>, LegError> {
        let planned = runs::plan(self.scene, self.seed);
        let legs = runs.iter().map(|run| self.leg(&planned[*run], individual, hidden));
        let legs = legs.collect::<Result<Vec<_>, _>>()?;
        std::thread::scope(|scope| {
            let started: Vec<_> =
                legs.iter().map(|leg| scope.spawn(|| leg.run(self.step_s, PERIOD_S))).collect();
            let ended =
                started.into_iter().map(|run| run.join().unwrap_or_else(|e| std::panic::resume_unwind(e)));
            ended.collect()
        })
    }
}

impl MadeLeg {
    /// The text of `campaign.toml`.
    #[must_use]
    pub fn description(&self) -> String {
        let mut text = format!(
            "name = \"{}\"\nbench = \"leg\"\nscenario = \"{}\"\nsample_rate_hz = {:.1}\n\n[noise_std]\n",
            self.name,
            self.scene.preset(),
            1.0 / PERIOD_S
        );
        for sensor in &self.sensors {
            let _ = writeln!(text, "\"{}\" = {:.3e}", sensor.channel, sensor.noise_std());
        }
        for run in &self.runs {
            let role = if run.holdout { "holdout" } else { "fit" };
            let _ = write!(
                text,
                "\n[[run]]\nfile = \"{0}.csv\"\nrole = \"{role}\"\nscenario = \"{0}.toml\"\n",
                run.name
            );
        }
        text
    }

    /// Every file of the campaign's folder: name and text.
    #[must_use]
    pub fn files(&self) -> Vec<(String, String)> {
        let of_run = |run: &MadeLegRun| {
            [
                (format!("{}.csv", run.name), run.table.clone()),
                (format!("{}.toml", run.name), run.scenario.clone()),
            ]
        };
        let runs = self.runs.iter().flat_map(of_run);
        std::iter::once(("campaign.toml".to_owned(), self.description())).chain(runs).collect()
    }
}
