//! The robot of a log, where its URDF is given: which of its joints the log's are.

use crate::failure::{OrBadInput, bad_input};
use sealegs::leg::robot::{JointKind, Robot};
use sealegs::logs::survey::{ColumnSurvey, Role, Survey, survey_named};
use sealegs::logs::{Log, joint_of};
use std::path::{Path, PathBuf};

/// A URDF and its joints that move, in the order of the file.
pub(super) struct KnownRobot {
    pub file: PathBuf,
    joints: Vec<Joint>,
}

struct Joint {
    name: String,
    slides: bool,
}

/// What a log's joint is in the URDF.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Is {
    /// The joint of this number, whose name fits.
    Named(usize),
    /// The joint of this number, as nothing but the order says.
    InOrder(usize),
    Nothing,
}

impl KnownRobot {
    /// # Errors
    ///
    /// Bad input for a file that is no URDF, or one of a robot none of whose joints moves.
    pub fn read(file: &Path) -> anyhow::Result<Self> {
        let robot = Robot::load(&file.display().to_string(), None).or_bad_input()?;
        let joints: Vec<Joint> = robot
            .moving_joints()
            .map(|j| Joint { name: j.name.clone(), slides: j.kind == JointKind::Prismatic })
            .collect();
        match joints.is_empty() {
            true => Err(bad_input(format!("{}: no joint of it moves", file.display()))),
            false => Ok(Self { file: file.to_owned(), joints }),
        }
    }

    /// Its file's name and joints, for people.
    pub fn described(&self) -> String {
        let names: Vec<&str> = self.joints.iter().map(|j| j.name.as_str()).collect();
        format!("{}: a robot; joints that move: {}", self.file.display(), names.join(", "))
    }

    /// What is in a log, its joints called as in the URDF. `joints` are those that its format names by column. Columns that stand still
    /// take part: without them the second joint of a list would be the first.
    pub fn survey(&self, log: &Log, joints: &[(String, String)]) -> Survey {
        let moved = as_if_all_moved(log);
        let first = survey_named(&moved, joints);
        let all =
            || log.tables.iter().zip(&first.tables).flat_map(|(t, seen)| t.columns.iter().zip(&seen.columns));
        let said = |own: &str, column: &ColumnSurvey| {
            let by_role =
                column.role.as_ref().and_then(|role| role.target.rsplit_once('.')).map(|(j, _)| j.to_owned());
            let is_one =
                column.role.as_ref().is_some_and(|role| role.target != "time_s") || column.aside.is_some();
            by_role.or_else(|| is_one.then(|| joint_of(own)).flatten())
        };
        let mut logged: Vec<String> = Vec::new();
        for (column, seen) in all() {
            if self.within(&seen.name).is_none()
                && let Some(joint) = said(&column.name, seen).filter(|joint| !logged.contains(joint))
            {
                logged.push(joint);
            }
        }
        let is = self.told_apart(&logged.iter().map(String::as_str).collect::<Vec<_>>());
        let lone = logged.is_empty() && self.joints.len() == 1;
        let of = |own: &str, column: &ColumnSurvey| -> Option<Is> {
            if let Some(joint) = self.within(&column.name) {
                return Some(Is::Named(joint));
            }
            let is_time = column.role.as_ref().is_some_and(|role| role.target == "time_s");
            match said(own, column) {
                Some(joint) => Some(is[logged.iter().position(|name| *name == joint)?]),
                None if lone && column.role.is_some() && !is_time => Some(Is::Named(0)),
                // A column whose quantity nobody would look for behind its joint's name: `elbow_tau_J_d`.
                None => {
                    only((0..logged.len()).filter(|i| has_word(&column.name, &logged[*i]))).map(|i| is[i])
                }
            }
        };
        let whose: Vec<(String, Option<Is>)> =
            all().map(|(c, seen)| (c.name.clone(), of(&c.name, seen))).collect();
        let named = |(own, is): &(String, Option<Is>)| match is {
            Some(Is::Named(i) | Is::InOrder(i)) => Some((own.clone(), self.joints[*i].name.clone())),
            Some(Is::Nothing) | None => None,
        };
        let names: Vec<(String, String)> =
            whose.iter().filter_map(named).chain(joints.iter().cloned()).collect();
        let mut found = survey_named(log, &names);
        let still = survey_named(&moved, &names);
        let columns = found.tables.iter_mut().flat_map(|t| &mut t.columns);
        let still = still.tables.into_iter().flat_map(|t| t.columns);
        for ((column, still), (_, is)) in columns.zip(still).zip(&whose) {
            settle(column, still);
            self.suit(column, *is);
        }
        found
    }

    /// The joint whose name stands in a column's; the longest such name.
    fn within(&self, column: &str) -> Option<usize> {
        let all = (0..self.joints.len()).filter(|i| has_word(column, &self.joints[*i].name));
        all.max_by_key(|i| self.joints[*i].name.len())
    }

    /// Which joints of the URDF a log's are: by their names, or, if these do not fit, by their order.
    fn told_apart(&self, logged: &[&str]) -> Vec<Is> {
        let fits: Vec<Vec<(usize, String)>> = logged.iter().map(|name| self.like(name)).collect();
        // Of `panda_joint1` and `panda_finger_joint1` those are meant by `joint1` to `joint7` that all have one beginning.
        let shared =
            |rest: &str| fits.iter().filter(|all| all.iter().any(|(_, other)| other == rest)).count();
        let called = |all: &Vec<(usize, String)>| {
            let most = all.iter().map(|(_, rest)| shared(rest)).max()?;
            only(all.iter().filter(|(_, rest)| shared(rest) == most).map(|(i, _)| *i))
        };
        let by_name: Vec<Option<usize>> = fits.iter().map(called).collect();
        let once = |i: &usize| by_name.iter().filter(|other| **other == Some(*i)).count() == 1;
        let named = |found: &Option<usize>| found.filter(once);
        let fit = by_name.iter().filter(|found| named(found).is_some()).count();
        // Mere numbers fit by chance where few of the joints have numbers, and may count from zero.
        let numbers: Option<Vec<usize>> = logged.iter().map(|name| key(name).parse().ok()).collect();
        if let Some(numbers) = numbers.filter(|_| fit < logged.len() || 2 * fit <= self.joints.len()) {
            let first = numbers.iter().min().copied().unwrap_or(0).min(1);
            let of = |number: &usize| match number - first {
                i if i < self.joints.len() => Is::InOrder(i),
                _ => Is::Nothing,
            };
            return numbers.iter().map(of).collect();
        }
        let in_order = fit == 0 && logged.len() <= self.joints.len();
        let of = |(at, found): (usize, &Option<usize>)| match named(found) {
            _ if in_order => Is::InOrder(at),
            Some(i) => Is::Named(i),
            None => Is::Nothing,
        };
        by_name.iter().enumerate().map(of).collect()
    }

    /// The joints with this name, or with one that says the same, each with the part of one name that the other lacks: `knee` may be
    /// `left_knee_joint`, and `joint3` `panda_joint3`.
    fn like(&self, name: &str) -> Vec<(usize, String)> {
        let own = key(name);
        let all = |fits: &dyn Fn(&str) -> Option<String>| -> Vec<(usize, String)> {
            let of = |(i, joint): (usize, &Joint)| Some((i, fits(&joint.name)?));
            self.joints.iter().enumerate().filter_map(of).collect()
        };
        let equal = |joint: &str| (joint == name).then(String::new);
        let same = |joint: &str| (key(joint) == own).then(String::new);
        let longer = |joint: &str| without_end(&key(joint), &own).or_else(|| without_end(&own, &key(joint)));
        let found = all(&equal).into_iter().take(1).collect::<Vec<_>>();
        [found, all(&same), all(&longer)].into_iter().find(|found| !found.is_empty()).unwrap_or_default()
    }

    /// Says how a column's joint was found, and gives one that slides a channel of its kind.
    fn suit(&self, column: &mut ColumnSurvey, is: Option<Is>) {
        let (Some(role), Some(is)) = (column.role.as_mut(), is) else { return };
        let urdf = self.file.file_name().unwrap_or_default().to_string_lossy();
        let joint = match is {
            Is::Named(i) => i,
            Is::InOrder(i) => {
                role.reason.push_str(&format!("; TODO: joint {} of {urdf} by its order", i + 1));
                i
            }
            Is::Nothing => {
                role.reason.push_str(&format!("; TODO: no joint of {urdf} is called so"));
                return;
            }
        };
        let Some((place, what)) = role.target.rsplit_once('.').filter(|_| self.joints[joint].slides) else {
            return;
        };
        let slides = match what {
            "angle_rad" => "position_m",
            "speed_rad_s" => "speed_m_s",
            "torque_nm" => "force_n",
            _ => return,
        };
        role.target = format!("{place}.{slides}");
        role.settings = None;
        role.reason.push_str("; it slides");
    }
}

/// The log with columns of one number that go on a little, so that these are looked at as the others are.
fn as_if_all_moved(log: &Log) -> Log {
    let mut log = log.clone();
    for column in log.tables.iter_mut().flat_map(|table| &mut table.columns) {
        let first = column.values.iter().copied().find(|v| v.is_finite());
        if first.is_some_and(|first| column.values.iter().all(|v| !v.is_finite() || *v == first)) {
            column.values.iter_mut().enumerate().for_each(|(row, v)| *v += 1e-9 * (row % 7) as f64);
        }
    }
    log
}

/// What a column is beside those that stand still, as they would be if they moved: the position of a joint that stands says where, and
/// a measured torque commands no joint that has a command which stands.
fn settle(column: &mut ColumnSurvey, if_moved: ColumnSurvey) {
    let is_position =
        |role: &Role| [".angle_rad", ".position_m"].iter().any(|what| role.target.ends_with(what));
    match (&column.role, if_moved.role) {
        (None, Some(mut role)) if column.constant && is_position(&role) => {
            role.reason.push_str("; always the same: the joint stands there");
            column.role = Some(role);
        }
        (Some(_), None) => (column.role, column.aside) = (None, if_moved.aside),
        _ => {}
    }
}

/// The one of these, unless there are several.
fn only<T>(mut all: impl Iterator<Item = T>) -> Option<T> {
    all.next().filter(|_| all.next().is_none())
}

/// What a joint's name says: letters and digits in small, without the word `joint`.
fn key(name: &str) -> String {
    let name: String = name.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect();
    name.replace("joint", "")
}

/// Whether a name has another one between its words.
fn has_word(name: &str, word: &str) -> bool {
    let ends = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
    name.match_indices(word)
        .any(|(at, _)| ends(name[..at].chars().next_back()) && ends(name[at + word.len()..].chars().next()))
}

/// What is before the end of a name, if it has that end, and this is not the end of a number of several digits.
fn without_end(name: &str, end: &str) -> Option<String> {
    let is_digit = |c: char| c.is_ascii_digit();
    let rest = name.strip_suffix(end).filter(|_| !end.is_empty())?;
    let splits = end.starts_with(is_digit) && rest.ends_with(is_digit);
    (!splits).then(|| rest.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot(joints: &[&str]) -> KnownRobot {
        let joints = joints.iter().map(|name| Joint { name: (*name).to_owned(), slides: false });
        KnownRobot { file: PathBuf::from("r.urdf"), joints: joints.collect() }
    }

    #[test]
    fn joints_are_found_by_names_that_say_the_same_or_by_their_order() {
        let panda = robot(&["panda_joint1", "panda_joint2", "panda_joint11", "finger_joint1"]);
        let [one, two] = [Is::Named(0), Is::Named(1)];
        assert_eq!(panda.told_apart(&["panda_joint1", "panda_joint2"]), [one, two]);
        assert_eq!(panda.told_apart(&["joint1", "joint2", "joint11"]), [one, two, Is::Named(2)]);
        // They count from zero, and not all of them are there.
        assert_eq!(panda.told_apart(&["joint0", "joint2"]), [Is::InOrder(0), Is::InOrder(2)]);
        // The wrists' numbers are not the robot's.
        let ur = robot(&["pan", "lift", "elbow", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]);
        assert_eq!(ur.told_apart(&["joint1", "joint2"]), [Is::InOrder(0), Is::InOrder(1)]);
        assert_eq!(ur.told_apart(&["joint0", "joint1"]), [Is::InOrder(0), Is::InOrder(1)]);
        let legs = robot(&["left_knee", "right_knee", "neck"]);
        assert_eq!(legs.told_apart(&["knee", "neck"]), [Is::Nothing, Is::Named(2)]);
        let leg = robot(&["left_hip_joint", "left_knee_joint"]);
        assert_eq!(leg.told_apart(&["knee", "HIP"]), [two, one]);
        assert_eq!(leg.told_apart(&["q0", "q1"]), [Is::InOrder(0), Is::InOrder(1)]);
        assert_eq!(leg.told_apart(&["a", "b", "c"]), [Is::Nothing; 3]);
        assert_eq!(leg.within("cmd.left_knee_joint.q"), Some(1));
        assert_eq!(leg.within("left_knee.q"), None);
        assert_eq!(leg.told_apart(&["knee", "toe"]), [two, Is::Nothing]);
    }
}
