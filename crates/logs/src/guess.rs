//! What a column probably is, by the words in its name and the size of its numbers.

use crate::lerobot;
use crate::survey::{ColumnSurvey, Role};
use crate::table::Table;
use sealegs_model::{Unit, columns};

/// What is measured or commanded.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Quantity {
    Position,
    Speed,
    Torque,
    Force,
    Current,
    Voltage,
    Temperature,
    Enable,
}

/// Words of names, and what they mean.
const WORDS: [(Quantity, &[&str]); 8] = [
    (Quantity::Enable, &["enable", "enabled", "enabling"]),
    (Quantity::Temperature, &["temp", "temperature", "temps"]),
    (Quantity::Speed, &["vel", "velocity", "velocities", "speed", "omega", "qd", "dq", "qdot", "rpm"]),
    (Quantity::Torque, &["tau", "torque", "torques", "effort", "efforts", "moment", "nm"]),
    (Quantity::Force, &["force", "forces", "load", "loadcell", "fx", "fy", "fz", "f"]),
    (Quantity::Current, &["current", "currents", "curr", "cur", "iq", "amp", "amps", "ma", "i"]),
    (Quantity::Voltage, &["voltage", "volt", "volts", "vbus", "vbat", "vin", "u"]),
    (
        Quantity::Position,
        &[
            "position",
            "positions",
            "pos",
            "angle",
            "angles",
            "theta",
            "q",
            "qm",
            "enc",
            "encoder",
            "deg",
            "rad",
        ],
    ),
];

const COMMANDED: [&str; 19] = [
    "cmd",
    "command",
    "commanded",
    "des",
    "desired",
    "ref",
    "reference",
    "goal",
    "target",
    "set",
    "setpoint",
    "sp",
    "con",
    "ctrl",
    "control",
    "action",
    "u",
    "req",
    "demand",
];

const SUPPLY: [&str; 7] = ["supply", "bus", "vbus", "battery", "vbat", "input", "vin"];

/// Derived from other columns: what a controller made of a measurement is none.
const DERIVED: [&str; 7] = ["filt", "filtered", "est", "estimated", "fric", "error", "err"];

const TIME: [&str; 12] = [
    "t",
    "time",
    "times",
    "timestamp",
    "timestamps",
    "stamp",
    "ts",
    "sec",
    "secs",
    "seconds",
    "clock",
    "elapsed",
];

/// The words of a name, small: `tau_con1` is `tau`, `con`, `1`; `jointPos` is `joint`, `pos`.
fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut before = ' ';
    for c in name.chars() {
        let kind = |c: char| (c.is_alphabetic(), c.is_ascii_digit());
        let goes_on = kind(before) == kind(c) && !(before.is_lowercase() && c.is_uppercase());
        if c.is_alphanumeric() {
            match words.last_mut().filter(|_| goes_on && before.is_alphanumeric()) {
                Some(word) => word.extend(c.to_lowercase()),
                None => words.push(c.to_lowercase().collect()),
            }
        }
        before = c;
    }
    words
}

/// The last of a name's parts, without the topic or list that it is in.
fn last_part(name: &str) -> &str {
    name.rsplit('.').find(|part| !part.is_empty()).unwrap_or(name)
}

/// Whether a name says that it is time.
pub(crate) fn is_time(name: &str) -> bool {
    let words = words(last_part(name));
    words.iter().any(|w| TIME.contains(&w.as_str()))
}

/// The unit of time stamps, and why.
///
/// Seconds since 1970 are some 1.7e9 today, so that the size of an absolute stamp tells its unit. Of a clock that starts
/// somewhere else, a period above 5 cannot be seconds of a log.
pub(crate) fn time_unit(
    name: &str,
    holds: Option<&str>,
    first: f64,
    period: f64,
) -> (&'static str, &'static str) {
    let words = words(name);
    let has = |list: &[&str]| words.iter().any(|w| list.contains(&w.as_str()));
    let held = |unit: &str| holds.is_some_and(|h| h.contains(unit));
    if has(&["ns", "nsec", "nanoseconds", "nanos"]) || held("nanoseconds") {
        return ("ns", "its unit by its name or type");
    }
    if has(&["us", "usec", "microseconds", "micros"]) || held("microseconds") {
        return ("us", "its unit by its name or type");
    }
    if has(&["ms", "msec", "milliseconds", "millis"]) || held("milliseconds") {
        return ("ms", "its unit by its name or type");
    }
    match first.abs() {
        a if a > 1e17 => ("ns", "its unit by its size, counted from 1970"),
        a if a > 1e14 => ("us", "its unit by its size, counted from 1970"),
        a if a > 1e11 => ("ms", "its unit by its size, counted from 1970"),
        _ if period >= 5e4 => ("ns", "its unit by its steps"),
        _ if period >= 50.0 => ("us", "its unit by its steps"),
        _ if period >= 1.0 => ("ms", "its unit by its steps"),
        _ => ("s", "in seconds by its steps"),
    }
}

/// Words before a quantity that name no joint: a part of one drive, or what kind of number it is.
const NO_JOINT: [&str; 16] = [
    "motor", "joint", "spring", "load", "output", "input", "rotor", "link", "screw", "meas", "measured",
    "actual", "raw", "filt", "real", "sensor",
];

/// What stands before the quantity at a name's end: `arm_1_joint` of `arm_1_joint_position`.
fn before_quantity(name: &str) -> Option<String> {
    let name = last_part(name);
    let (rest, quantity) = name.rsplit_once('_')?;
    let rest = rest.trim_matches(|c: char| !c.is_alphanumeric());
    let is_quantity = WORDS.iter().any(|(_, list)| list.contains(&quantity.to_lowercase().as_str()));
    let words = words(rest);
    let no_joint = |w: &String| NO_JOINT.contains(&w.as_str()) || COMMANDED.contains(&w.as_str());
    (is_quantity && !words.is_empty() && !words.iter().all(no_joint)).then(|| rest.to_owned())
}

/// Words that a number behind them makes the name of a joint.
const JOINT: [&str; 10] = ["j", "joint", "axis", "ax", "dof", "motor", "m", "act", "actuator", "servo"];

/// The numbered joint that a name begins with: `J1` of `J1 tau cmd`.
fn numbered(name: &str) -> Option<&str> {
    let name = last_part(name);
    let letters = name.find(|c: char| !c.is_alphabetic())?;
    let number = letters + name[letters..].find(|c: char| c.is_ascii_digit())?;
    let end = number + name[number..].find(|c: char| !c.is_ascii_digit())?;
    let between = name[letters..number].chars().all(|c| matches!(c, '_' | '-' | ' '));
    (between && JOINT.contains(&name[..letters].to_lowercase().as_str())).then(|| &name[..end])
}

/// The joint that a name belongs to: what stands in its last brackets, its numbered beginning, what stands before its quantity,
/// or the number at its end.
fn joint(name: &str) -> Option<String> {
    let inside = name.rfind('[').and_then(|at| name[at + 1..].strip_suffix(']'));
    if let Some(inside) = inside {
        return Some(match inside.parse::<u32>() {
            Ok(number) => format!("joint{number}"),
            Err(_) => inside.to_owned(),
        });
    }
    if let Some(rest) = numbered(name).map(str::to_owned).or_else(|| before_quantity(name)) {
        return Some(rest);
    }
    let digits = name.len() - name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    (digits > 0 && digits < name.len()).then(|| format!("joint{}", &name[name.len() - digits..]))
}

/// A guess before other columns are looked at.
struct First {
    column: usize,
    target: &'static str,
    settings: Option<String>,
    reason: String,
    /// Better ones first: commanded before measured currents, measured before derived positions.
    rank: u8,
}

/// Puts a role into every column that has one.
pub(crate) fn roles(
    table: &Table,
    clock: Option<usize>,
    joints: &[(String, String)],
    columns: &mut [ColumnSurvey],
) {
    let mut guesses: Vec<First> = Vec::new();
    let degrees = are_degrees(columns);
    for (i, column) in columns.iter().enumerate() {
        let values = &table.columns[i].values;
        // The number of the row, whatever it is called.
        let counts = values.len() > 1 && values.windows(2).all(|w| w[1] - w[0] == 1.0);
        if Some(i) == clock || counts || column.range.is_none() || (column.constant && column.holds.is_none())
        {
            continue;
        }
        let own = &table.columns[i].name;
        let stated = known(own).filter(|own| own.contains('_') && Unit::of_channel(own).is_ok());
        if let Some(target) = stated {
            let reason = "the data contract calls it so".to_owned();
            guesses.push(First { column: i, target, settings: None, reason, rank: 0 });
        } else {
            guesses.extend(of_dataset(i, own, degrees).or_else(|| by_words(i, own, column)));
        }
    }
    // Of a drive that logs its position and one torque, and no command, the torque is what drives it.
    let count = |target: &str| guesses.iter().filter(|g| g.target == target).count();
    let is_input = |g: &First| columns::INPUTS.contains(&g.target);
    if count("output_torque_nm") == 1 && count("joint_angle_rad") == 1 && !guesses.iter().any(is_input) {
        for guess in guesses.iter_mut().filter(|g| g.target == "output_torque_nm" && g.rank > 0) {
            guess.target = "joint_torque_nm";
            guess.reason.push_str("; nothing else drives it: the input");
        }
    }
    guesses.sort_by_key(|g| g.rank);
    let several: Vec<&str> = guesses
        .iter()
        .map(|g| g.target)
        .filter(|t| {
            // Only columns alike in rank belong to different joints: pos_meas1 and pos_meas2.
            let best = guesses.iter().filter(|g| g.target == *t).map(|g| g.rank).min();
            guesses.iter().filter(|g| g.target == *t && Some(g.rank) == best).count() > 1
        })
        .collect();
    let several: Vec<String> = several.into_iter().map(str::to_owned).collect();
    let many_joints = !several.is_empty();
    let mut taken: Vec<String> = Vec::new();
    for guess in guesses {
        let name = &table.columns[guess.column].name;
        let of_a_joint_too = several.contains(&guess.target.to_owned()) || numbered(name).is_some();
        let named = joints.iter().find(|(column, _)| column == name).map(|(_, joint)| joint.clone());
        let place = named.or_else(|| joint(name).filter(|_| many_joints && of_a_joint_too));
        let target = match place {
            Some(joint) => format!("{joint}.{}", of_a_joint(guess.target)),
            None => guess.target.to_owned(),
        };
        if taken.contains(&target) {
            continue;
        }
        taken.push(target.clone());
        columns[guess.column].role = Some(Role { target, settings: guess.settings, reason: guess.reason });
    }
}

/// A channel by the contract's own name for it.
fn known(name: &str) -> Option<&'static str> {
    let mut all = columns::INPUTS.into_iter().chain(columns::OUTPUTS).chain(columns::BESIDE);
    all.find(|known| *known == name)
}

/// What a bench's channel is called behind the name of a joint.
fn of_a_joint(target: &str) -> &str {
    match target {
        "joint_angle_rad" => "angle_rad",
        // A robot's joints are commanded by their torques: where none is said to be commanded the measured one is taken.
        "joint_torque_nm" | "output_torque_nm" => "torque_nm",
        other => other,
    }
}

/// The list that a column is a number of, if it is one of those in which a dataset of LeRobot holds joints.
fn list_of(name: &str) -> Option<&str> {
    let list = name.split_once('[').map_or(name, |(list, _)| list);
    [lerobot::STATE, lerobot::ACTION].contains(&list).then_some(list)
}

/// Greatest magnitude in a column.
fn reach(column: &ColumnSurvey) -> f64 {
    column.range.map_or(0.0, |(low, high)| low.abs().max(high.abs()))
}

/// Whether the joints of a dataset are in degrees: all are, if any of them reaches what no joint has in radians.
fn are_degrees(columns: &[ColumnSurvey]) -> bool {
    columns.iter().filter(|c| list_of(&c.name).is_some()).any(|c| reach(c) > DEGREES)
}

/// An angle beyond this is in degrees, rad.
const DEGREES: f64 = 20.0;

/// What a column of a dataset of LeRobot is: a measured position or its goal.
fn of_dataset(index: usize, name: &str, degrees: bool) -> Option<First> {
    let (target, what) = match list_of(name)? {
        lerobot::ACTION => ("position_rad", "the goal"),
        _ => ("joint_angle_rad", "the measured position"),
    };
    let mut reason = format!("LeRobot's name for {what}");
    if degrees {
        reason.push_str("; in degrees, it seems");
    }
    let settings = degrees.then(|| "unit = \"deg\"".to_owned());
    Some(First { column: index, target, settings, reason, rank: 1 })
}

fn by_words(index: usize, name: &str, column: &ColumnSurvey) -> Option<First> {
    let words = words(last_part(name));
    let find = |list: &[&str]| words.iter().find(|w| list.contains(&w.as_str()));
    // The first word that means something decides: `torque_enable` is no torque because `enable` is looked for first.
    let (quantity, word) = WORDS.iter().find_map(|(q, list)| find(list).map(|w| (*q, w.as_str())))?;
    let commanded = find(&COMMANDED);
    let supply = find(&SUPPLY);
    let derived = find(&DERIVED);
    let target = match (quantity, commanded.is_some()) {
        (Quantity::Enable, _) => "enable",
        (Quantity::Temperature, _) => "temperature_c",
        (Quantity::Voltage, false) if supply.is_some() => "supply_v",
        (Quantity::Voltage, _) => "voltage_v",
        (Quantity::Current, _) => "current_a",
        (Quantity::Speed, false) => "speed_rad_s",
        (Quantity::Torque, true) => "joint_torque_nm",
        (Quantity::Torque, false) => "output_torque_nm",
        (Quantity::Force, true) => "motor_force_n",
        (Quantity::Force, false) => "force_1_n",
        (Quantity::Position, true) => "position_rad",
        (Quantity::Position, false) => "joint_angle_rad",
        // No bench takes a commanded speed.
        (Quantity::Speed, true) => return None,
    };
    let mut reason = format!("'{word}' in its name");
    if let Some(word) = commanded {
        reason.push_str(&format!(", and '{word}': a command"));
    }
    if let Some(word) = supply.filter(|_| target == "supply_v") {
        reason.push_str(&format!(", and '{word}'"));
    }
    if let Some(word) = derived {
        reason.push_str(&format!("; '{word}': made by the controller"));
    }
    let mut settings = None;
    let size = reach(column);
    if target.ends_with("_rad") && (find(&["deg", "degrees"]).is_some() || (size > DEGREES && size <= 400.0))
    {
        settings = Some("unit = \"deg\"".to_owned());
        reason.push_str(&format!("; reaches {size:.0}: degrees, it seems"));
    } else if find(&["rpm"]).is_some() {
        settings = Some("unit = \"rpm\"".to_owned());
    } else if find(&["ma"]).is_some() {
        settings = Some("unit = \"mA\"".to_owned());
    }
    // A command of a current is the input, a measured one only if there is none; so for torques and forces.
    let measured = matches!(quantity, Quantity::Current | Quantity::Torque) && commanded.is_none();
    let rank = 1 + u8::from(measured) + 2 * u8::from(derived.is_some());
    Some(First { column: index, target, settings, reason, rank })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::survey;
    use crate::table::Log;

    #[test]
    fn names_fall_into_words() {
        assert_eq!(words("tau_con1"), ["tau", "con", "1"]);
        assert_eq!(words("jointPos[2]"), ["joint", "pos", "2"]);
        assert_eq!(words("/joint_states.position"), ["joint", "states", "position"]);
    }

    fn roles_of(names: &[&str], values: fn(usize) -> f64) -> Vec<(String, String)> {
        let column = |(i, name): (usize, &&str)| {
            crate::table::Column::of(
                *name,
                (0..20).map(|r| if i == 0 { f64::from(r) * 0.01 } else { values(r as usize) }).collect(),
            )
        };
        let columns = names.iter().enumerate().map(column).collect();
        let log = Log { tables: vec![Table { columns, ..Table::default() }], ..Log::default() };
        let found = survey(&log).tables.remove(0).columns.into_iter();
        found.filter_map(|c| c.role.map(|r| (c.name, r.target))).collect()
    }

    #[test]
    fn columns_of_a_servo_and_of_two_joints_are_recognised() {
        let wave = |r: usize| (r as f64).sin();
        let servo = roles_of(
            &["timestamp", "position", "speed", "goal_position", "input_volts", "temp", "index"],
            wave,
        );
        let expected = [
            ("timestamp", "time_s"),
            ("position", "joint_angle_rad"),
            ("speed", "speed_rad_s"),
            ("goal_position", "position_rad"),
            ("input_volts", "supply_v"),
            ("temp", "temperature_c"),
        ];
        assert_eq!(servo, expected.map(|(a, b)| (a.to_owned(), b.to_owned())));
        let joints = roles_of(&["time", "pos_meas1", "pos_meas2", "pos_filt1", "tau_con1", "tau_con2"], wave);
        let expected = [
            ("time", "time_s"),
            ("pos_meas1", "joint1.angle_rad"),
            ("pos_meas2", "joint2.angle_rad"),
            ("tau_con1", "joint1.torque_nm"),
            ("tau_con2", "joint2.torque_nm"),
        ];
        assert_eq!(joints, expected.map(|(a, b)| (a.to_owned(), b.to_owned())));
        let names = ["stamp [s]", "J1 pos", "J2 pos", "J1 vel", "J1 tau cmd", "J2 tau cmd", "J1 tau est"];
        let expected = [
            ("stamp [s]", "time_s"),
            ("J1 pos", "J1.angle_rad"),
            ("J2 pos", "J2.angle_rad"),
            ("J1 vel", "J1.speed_rad_s"),
            ("J1 tau cmd", "J1.torque_nm"),
            ("J2 tau cmd", "J2.torque_nm"),
        ];
        assert_eq!(roles_of(&names, wave), expected.map(|(a, b)| (a.to_owned(), b.to_owned())));
    }

    #[test]
    fn joints_are_named_before_their_quantity_and_a_lone_torque_drives() {
        let wave = |r: usize| (r as f64).sin();
        let of =
            |names: &[&str]| roles_of(names, wave).into_iter().map(|(_, target)| target).collect::<Vec<_>>();
        let arm = [
            "t",
            "- arm_1_joint_position",
            "- lift_joint_position",
            "- arm_1_joint_effort",
            "- lift_joint_effort",
        ];
        let expected = [
            "time_s",
            "arm_1_joint.angle_rad",
            "lift_joint.angle_rad",
            "arm_1_joint.torque_nm",
            "lift_joint.torque_nm",
        ];
        assert_eq!(of(&arm), expected);
        assert_eq!(
            of(&["time", "position", "velocity", "torque"]),
            ["time_s", "joint_angle_rad", "speed_rad_s", "joint_torque_nm"]
        );
        // With a command the torque is a sensor's.
        assert_eq!(
            of(&["time", "position", "torque", "current_cmd"]),
            ["time_s", "joint_angle_rad", "output_torque_nm", "current_a"]
        );
        // Two sensors of one drive are no two joints.
        assert_eq!(of(&["t", "motor_position", "joint_position"]), ["time_s", "joint_angle_rad"]);
    }

    #[test]
    fn the_unit_of_time_is_told_by_name_size_or_steps() {
        assert_eq!(time_unit("t_ms", None, 0.0, 1.0).0, "ms");
        assert_eq!(time_unit("stamp", None, 1.7e18, 1e6).0, "ns");
        assert_eq!(time_unit("stamp", None, 1.7e9, 0.01).0, "s");
        assert_eq!(time_unit("t", None, 0.0, 1e4).0, "us");
        assert_eq!(time_unit("t", Some("time stamps (Timestamp) in microseconds"), 0.0, 0.1).0, "us");
    }
}
