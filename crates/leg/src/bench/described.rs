//! A robot with its drives in parts, for whoever writes it in another format.

use super::RobotModel;
use super::begin::Begin;
use super::simulate::ahead_at_rest;
use crate::robot::{JointKind, Robot};
use sealegs_actuator::bench::BenchModel;
use sealegs_actuator::plant::Plant;
use sealegs_model::{Model, ModelError, Record};

/// A joint with its drive and the values of the drive's parameters.
#[derive(Debug, Clone)]
pub struct DrivenJoint<'a> {
    /// The joint's name.
    pub name: &'a str,
    /// The drive on the bench `free`, whose load at the posture zero is the robot's.
    pub drive: &'a BenchModel,
    /// Values of the drive's parameters, in their order.
    pub values: Vec<f64>,
    /// The column that commands it.
    pub command: String,
    /// What that column is called on the drive's own bench.
    pub input: &'static str,
    /// What its sensors can show: the column at a drive on its own bench, and here.
    pub channels: Vec<(&'static str, String)>,
    /// Viscous damping of the joint itself, behind a series spring, N m s/rad.
    pub damping: f64,
}

impl DrivenJoint<'_> {
    /// The plant of the drive at its values.
    ///
    /// # Errors
    ///
    /// [`ModelError::BadParameter`] for a value that no drive can have.
    pub fn plant(&self) -> Result<Plant, ModelError> {
        self.drive.plant(&self.values, self.input)
    }
}

impl RobotModel {
    /// The robot as the URDF states it.
    #[must_use]
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The joints that move with their drives, for parameter `values` in the order of the model's, by degree of freedom.
    #[must_use]
    pub fn driven_joints(&self, values: &[f64]) -> Vec<DrivenJoint<'_>> {
        let described = self.joints.iter().map(|joint| {
            let shown = |column| (joint.at_drive(column), joint.channel(column));
            DrivenJoint {
                name: &joint.name,
                drive: &joint.model,
                values: joint.own(values),
                command: joint.command(),
                input: joint.input(),
                channels: joint.columns().map(shown).collect(),
                damping: joint.damping,
            }
        });
        described.collect()
    }

    /// How far the rotor of each driven joint, whose `plants` these are, is ahead of it where a run begins, rad or m: 0 of one
    /// that moves with its joint.
    #[must_use]
    pub fn rotors_ahead(&self, values: &[f64], plants: &[Plant], start: &[(f64, f64)]) -> Vec<f64> {
        let posture: Vec<f64> = start.iter().map(|(position, _)| *position).collect();
        ahead_at_rest(&self.tree_at(values), plants, &posture)
    }

    /// The robot with the links' masses, centres and moments for parameter `values`. Where they are not the URDF's, the
    /// links on fixed joints are counted to the one that carries them.
    #[must_use]
    pub fn robot_at(&self, values: &[f64]) -> Robot {
        let mut robot = self.robot.as_ref().clone();
        let tree = self.tree_at(values);
        let moving: Vec<usize> = robot.moving_joints().map(|j| j.child).collect();
        for (body, link) in moving.into_iter().enumerate() {
            let (is, stated) = (tree.inertial(body), self.tree.inertial(body));
            if is == stated {
                continue;
            }
            for i in self.rigidly_on(link) {
                robot.links[i].inertial = None;
            }
            robot.links[link].inertial = Some(is);
        }
        robot
    }

    /// The links that fixed joints tie to a link.
    fn rigidly_on(&self, link: usize) -> Vec<usize> {
        let mut tied = vec![link];
        for joint in self.robot.joints.iter().filter(|j| j.kind == JointKind::Fixed) {
            if tied.contains(&joint.parent) {
                tied.push(joint.child);
            }
        }
        tied
    }

    /// Names of the records whose start is known, with position and speed of every joint there (rad and rad/s, m and m/s) as their
    /// first rows tell them.
    pub fn starts(&self) -> impl Iterator<Item = (&str, &[(f64, f64)])> {
        self.starts.iter().map(|(record, start)| (record.as_str(), start.at.as_slice()))
    }

    /// The same with a record's runs beginning at this position and speed of every joint (rad and rad/s, m and m/s).
    #[must_use]
    pub fn with_start(mut self, record: &str, start: Vec<(f64, f64)>) -> Self {
        self.starts.insert(record.to_owned(), Begin::known(start));
        self
    }

    /// The same with one record alone, whose run begins where a simulation with the nominal values begins it.
    ///
    /// # Errors
    ///
    /// Those of [`sealegs_model::Model::predict`].
    pub fn starting_as(mut self, record: &Record) -> Result<Self, ModelError> {
        let start = self.start(&self.nominal(), record)?;
        self.starts.clear();
        Ok(self.with_start(&record.name, start))
    }

    /// The nominal values, in the order of the model's parameters.
    #[must_use]
    pub fn nominal(&self) -> Vec<f64> {
        self.parameters().iter().map(|p| p.value).collect()
    }
}
