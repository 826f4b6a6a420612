//! What records are to a robot: which columns command it, where runs begin, and which parameters they feel.

use super::RobotModel;
use super::joint::{Column, Joint};
use crate::error::nearest;
use sealegs_actuator::bench::{LONGEST_S, rows_within, start_of};
use sealegs_model::{Model, Record};

/// Times that a start is corrected: the second one sees what the first has left of the torques' part.
const CORRECTIONS: usize = 2;

/// What a commanded torque does not feel of a drive.
const UNFELT_BY_EFFORT: [&str; 2] = ["force_constant", "winding_resistance"];

impl RobotModel {
    /// The same model for these records: runs start as their first rows say, and what a joint's commands do not feel of its
    /// drive is not fitted. Whatever is fitted, a run starts in the same place.
    #[must_use]
    pub fn for_records(mut self, records: &[&Record]) -> Self {
        let mut plain = self.plain.as_deref().unwrap_or(&self).clone();
        for record in records {
            plain.begin(record);
            let first = record.at_rows(0..rows_within(&record.time_s, LONGEST_S));
            for _ in 0..CORRECTIONS {
                plain.correct_start(&first);
            }
        }
        self.starts.extend(plain.starts);
        for joint in &self.joints {
            let input = |record: &&Record| joint.command_in(record).ok().flatten().map(|(input, _)| input);
            if records.iter().filter_map(input).any(|input| input != joint.effort()) {
                continue;
            }
            for name in UNFELT_BY_EFFORT.map(|p| format!("{}/{p}", joint.name)) {
                self.parameters.iter_mut().filter(|p| p.name == name).for_each(|p| p.fixed = true);
            }
        }
        self
    }

    /// Lets a record start as its first rows say, the position alone zero where it was not logged.
    fn begin(&mut self, record: &Record) {
        let of = |joint: &Joint| {
            let signal = |column| record.output(&joint.channel(column));
            let position = signal(Column::Position).map(|values| start_of(&record.time_s, values));
            let speed = signal(Column::Speed).map(|values| start_of(&record.time_s, values).value);
            position.map_or((0.0, speed.unwrap_or(0.0)), |start| (start.value, start.slope))
        };
        self.starts.insert(record.name.clone(), self.joints.iter().map(of).collect());
    }

    /// Corrects a record's start by what its `first` rows show beside the motion that follows from it: the torques account for
    /// most of the acceleration there, and what is left is slow, so that more rows tell the speed.
    fn correct_start(&mut self, first: &Record) {
        let places = self.positions().into_iter();
        let measured: Vec<String> = places.filter(|place| first.output(place).is_some()).collect();
        // What cannot be simulated is said when it is to be compared.
        let Ok(predicted) = self.predict(&self.nominal(), first, &measured) else { return };
        let Some(start) = self.starts.get_mut(&first.name) else { return };
        for (joint, at) in self.joints.iter().zip(start) {
            let place = joint.channel(Column::Position);
            let Some((seen, follows)) = first.output(&place).zip(predicted.output(&place)) else { continue };
            let left: Vec<f64> = seen.iter().zip(follows).map(|(seen, follows)| seen - follows).collect();
            let start = start_of(&first.time_s, &left);
            *at = (at.0 + start.value, at.1 + start.slope);
        }
    }

    /// What keeps a record's column from commanding this robot, if anything does.
    #[must_use]
    pub fn refuses_input(&self, record: &Record, channel: &str) -> Option<String> {
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
        let hint = nearest(channel, all.iter().map(String::as_str))
            .map(|n| format!("; did you mean '{n}'?"))
            .unwrap_or_default();
        Some(format!("commands no joint of {}{hint}", self.name))
    }

    /// Whether a joint follows a goal by its own loop in any of the records.
    pub(super) fn has_loop(&self, records: &[&Record]) -> bool {
        let goal = |record: &&Record, joint: &Joint| {
            matches!(joint.command_in(record), Ok(Some(("position_rad", _))))
        };
        records.iter().any(|record| self.joints.iter().any(|joint| goal(record, joint)))
    }
}
