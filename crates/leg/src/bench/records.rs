//! What records are to a robot: which columns command it, where runs begin, and which parameters they feel.

use super::RobotModel;
use super::begin::Begin;
use super::joint::Joint;
use crate::error::meant;
use sealegs_model::Record;
use sealegs_model::columns::{FEEDFORWARD, GOAL_SPEED};

/// What a commanded torque does not feel of a drive.
const UNFELT_BY_EFFORT: [&str; 2] = ["force_constant", "winding_resistance"];

/// Columns that stand beside a goal.
const GOAL_COLUMNS: [&str; 2] = [GOAL_SPEED, FEEDFORWARD];

impl RobotModel {
    /// The same model for these records: runs start as their first rows say, and what a joint's commands do not feel of its
    /// drive is not fitted.
    #[must_use]
    pub fn for_records(mut self, records: &[&Record]) -> Self {
        let plain = self.plain.as_deref().unwrap_or(&self);
        let starts = records.iter().map(|record| (record.name.clone(), Begin::of(record, plain)));
        self.starts.extend(starts.collect::<Vec<_>>());
        for joint in &self.joints {
            let input = |record: &&Record| joint.command_in(record).ok().flatten().map(|(input, _)| input);
            let is_torque = |input: &str| {
                input == joint.effort() || (input == "position_rad" && joint.model.spec().has_torque_loop())
            };
            if !records.iter().filter_map(input).all(is_torque) {
                continue;
            }
            for name in UNFELT_BY_EFFORT.map(|p| format!("{}/{p}", joint.name)) {
                self.parameters.iter_mut().filter(|p| p.name == name).for_each(|p| p.fixed = true);
            }
        }
        self
    }

    /// What keeps a record's column from commanding this robot, if anything does.
    #[must_use]
    pub fn refuses_input(&self, record: &Record, channel: &str) -> Option<String> {
        let beside_goal =
            |joint: &&Joint| GOAL_COLUMNS.iter().any(|c| channel == format!("{}.{c}", joint.name));
        if let Some(joint) = self.joints.iter().find(beside_goal) {
            return (!joint.follows_goal(record) || !joint.model.spec().has_torque_loop()).then(|| {
                format!(
                    "is for a joint that follows a goal by a loop which commands a torque: the drive of '{}' has no [servo] with \
                     proportional_nm_per_rad, or it has no column {}.position_rad",
                    joint.name, joint.name
                )
            });
        }
        if let Some(joint) = self.joints.iter().find(|j| j.reads(channel)) {
            return joint.commanded_beside(record, channel).map(|other| {
                format!(
                    "commands joint '{}' as '{other}' does: a joint takes one command, the other column is to go",
                    joint.name
                )
            });
        }
        let commands = |joint: &Joint| joint.commands().into_iter().map(|(name, _)| name).collect::<Vec<_>>();
        let of =
            self.joints.iter().find(|j| channel.rsplit_once('.').is_some_and(|(name, _)| name == j.name));
        if let Some(joint) = of {
            let takes = commands(joint).join(", ");
            return Some(format!("does not command joint '{}': its drive takes {takes}", joint.name));
        }
        let all: Vec<String> = self.joints.iter().flat_map(commands).collect();
        let hint = meant(channel, all.iter().map(String::as_str));
        let joints: Vec<&str> = self.joints.iter().map(|j| j.name.as_str()).collect();
        Some(format!("commands no joint of {}{hint}; its joints are {}", self.name, joints.join(", ")))
    }

    /// Whether a joint follows a goal by its own loop in any of the records.
    pub(super) fn has_loop(&self, records: &[&Record]) -> bool {
        records.iter().any(|record| self.joints.iter().any(|joint| joint.follows_goal(record)))
    }
}
