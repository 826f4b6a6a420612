//! What a column probably is, by the words in its name and the size of its numbers.

mod name;

use crate::lerobot;
use crate::survey::{ColumnSurvey, Role};
use crate::table::Table;
use name::{Dimension, last_part, quantity_of, without_unit, words};
use sealegs_model::{Unit, columns};

/// What is measured or commanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
    (Quantity::Force, &["force", "forces", "loadcell", "cell", "fx", "fy", "fz", "f"]),
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
            "deflection",
            "elongation",
            "deg",
            "rad",
        ],
    ),
];

const COMMANDED: [&str; 21] = [
    "cmd",
    "command",
    "commands",
    "commanded",
    "setpoints",
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

/// Of these a topic or a list above the column may be called as well.
const COMMANDS: [&str; 8] =
    ["cmd", "command", "commands", "commanded", "desired", "reference", "target", "setpoints"];

/// Accelerations, which no channel holds.
const ACCELERATION: [&str; 8] =
    ["acc", "accel", "acceleration", "accelerations", "ddot", "qdd", "ddq", "jerk"];

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

/// A guess before other columns are looked at.
struct First {
    column: usize,
    target: &'static str,
    settings: Option<String>,
    reason: String,
    /// Better ones first: commanded before measured currents, measured before derived positions.
    rank: u8,
}

/// What a name comes to.
enum Guess {
    Role(First),
    /// Why it has none.
    Aside(String),
}

/// Puts a role into every column that has one.
pub(crate) fn roles(
    table: &Table,
    clock: Option<usize>,
    joints: &[(String, String)],
    columns: &mut [ColumnSurvey],
) {
    let (mut guesses, mut asides): (Vec<First>, Vec<(usize, String)>) = (Vec::new(), Vec::new());
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
            match of_dataset(i, own, degrees)
                .map(Guess::Role)
                .or_else(|| by_words(i, &column.name, values, column))
            {
                Some(Guess::Role(first)) => guesses.push(first),
                Some(Guess::Aside(why)) => asides.push((i, why)),
                None => {}
            }
        }
    }
    for (i, why) in asides {
        columns[i].aside = Some(why);
    }
    settled_by_others(&mut guesses);
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
    let mut taken: Vec<(String, String)> = Vec::new();
    for guess in guesses {
        let name = &table.columns[guess.column].name;
        let of_a_joint_too = several.contains(&guess.target.to_owned()) || name::numbered(name).is_some();
        let named = joints.iter().find(|(column, _)| column == name).map(|(_, joint)| joint.clone());
        let place = named.or_else(|| name::joint(name).filter(|_| many_joints && of_a_joint_too));
        let target = match place {
            Some(joint) => format!("{joint}.{}", of_a_joint(guess.target)),
            None => guess.target.to_owned(),
        };
        // A bench has one input.
        let input = |t: &str| columns::INPUTS.contains(&t);
        let other = taken.iter().find(|(t, _)| *t == target || (input(t) && input(&target)));
        if let Some((_, other)) = other {
            columns[guess.column].aside = Some(format!("{}; '{other}' is taken in its place", guess.reason));
            continue;
        }
        taken.push((target.clone(), columns[guess.column].name.clone()));
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
        "joint_torque_nm" | "motor_torque_nm" | "output_torque_nm" => "torque_nm",
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

/// An angle beyond this is in no degrees either: a turn and a tenth.
const LARGEST_DEGREES: f64 = 400.0;

/// The fewest counts of an encoder's turn, as a power of two: 12 bits are the coarsest that servos have.
const FEWEST_COUNTS: f64 = 12.0;

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

/// What a column is by the words and the unit in its name, and the size of its numbers.
fn by_words(index: usize, name: &str, values: &[f64], column: &ColumnSurvey) -> Option<Guess> {
    let (plain, unit) = without_unit(name);
    let unit = unit.or_else(|| name::of_row(column.holds.as_deref()?));
    let (all, words) = (words(plain), words(last_part(plain)));
    let find = |list: &[&str]| words.iter().find(|w| list.contains(&w.as_str()));
    if find(&ACCELERATION).is_some() || unit.is_some_and(|(_, of)| of.quantity().is_none()) {
        return Some(Guess::Aside("an acceleration: no channel holds it".to_owned()));
    }
    let by_name = quantity_of(&words).or_else(|| quantity_of(&all));
    let by_unit = unit.and_then(|(_, of)| of.quantity());
    let said = |word: &str| format!("'{word}' in its name");
    let (quantity, mut reason) = match (by_name, by_unit) {
        // `gyro_deg_s` and `theta_rad_s` are speeds.
        (Some((named, word)), unit) if unit.is_none_or(|unit| unit == named) => (named, said(word)),
        (_, Some(unit)) => (unit, "the unit in its name".to_owned()),
        (Some((named, word)), None) => (named, said(word)),
        (None, None) if find(&["load"]).is_some() => {
            return Some(Guess::Aside("a load in shares of the greatest one is no torque in N m".to_owned()));
        }
        (None, None) => return None,
    };
    let commanded = find(&COMMANDED).or_else(|| all.iter().find(|w| COMMANDS.contains(&w.as_str())));
    let (supply, derived) = (find(&SUPPLY), find(&DERIVED));
    let of_spring = find(&["spring"]).is_some();
    let of_motor = find(&["motor", "rotor"]).is_some();
    let long = unit.is_some_and(|(_, of)| matches!(of, Dimension::Length | Dimension::LinearSpeed));
    let target = match (quantity, commanded.is_some()) {
        (Quantity::Enable, _) => "enable",
        (Quantity::Temperature, _) => "temperature_c",
        (Quantity::Voltage, false) if supply.is_some() => "supply_v",
        (Quantity::Voltage, _) => "voltage_v",
        (Quantity::Current, _) => "current_a",
        (Quantity::Speed, false) if long => "speed_m_s",
        (Quantity::Speed, false) => "speed_rad_s",
        (Quantity::Speed, true) => return Some(Guess::Aside("no bench takes a commanded speed".to_owned())),
        (Quantity::Torque, true) if of_motor => "motor_torque_nm",
        (Quantity::Torque, true) => "joint_torque_nm",
        (Quantity::Torque, false) if of_spring => "spring_torque_nm",
        (Quantity::Torque, false) => "output_torque_nm",
        (Quantity::Force, commanded) if commanded || of_motor => "motor_force_n",
        (Quantity::Force, _) => "force_1_n",
        (Quantity::Position, false) if of_spring && long => "spring_deflection_m",
        (Quantity::Position, false) if of_spring => "spring_deflection_rad",
        (Quantity::Position, true) if long => {
            return Some(Guess::Aside("no bench takes a goal in metres".to_owned()));
        }
        (Quantity::Position, true) => "position_rad",
        (Quantity::Position, false) if long => "position_m",
        (Quantity::Position, false) if of_motor => "motor_angle_rad",
        (Quantity::Position, false) => "joint_angle_rad",
    };
    if let Some(word) = commanded {
        reason.push_str(&format!(", and '{word}': a command"));
    }
    if let Some(word) = supply.filter(|_| target == "supply_v") {
        reason.push_str(&format!(", and '{word}'"));
    }
    if let Some(word) = derived {
        reason.push_str(&format!("; '{word}': made by the controller"));
    }
    let settings = settings(target, unit, &words, values, column, &mut reason);
    // A command of a current is the input, a measured one only if there is none; so for torques and forces.
    let measured = matches!(quantity, Quantity::Current | Quantity::Torque) && commanded.is_none();
    let rank = 1 + u8::from(measured) + 2 * u8::from(derived.is_some());
    Some(Guess::Role(First { column: index, target, settings, reason, rank }))
}

/// What a column's map needs beside its channel: the unit of its name, or what the size of its numbers says, with why.
fn settings(
    target: &str,
    unit: Option<(&'static str, Dimension)>,
    words: &[String],
    values: &[f64],
    column: &ColumnSurvey,
    reason: &mut String,
) -> Option<String> {
    let has = |list: &[&str]| words.iter().any(|w| list.contains(&w.as_str()));
    let (size, angle) = (reach(column), target.ends_with("_rad"));
    let stated = unit.filter(|(_, of)| *of != Dimension::Counts);
    if let Some((unit, _)) = stated {
        let wraps = angle && begins_again(values, crate::units::turn(unit));
        let all = [
            (!unit.is_empty()).then(|| format!("unit = \"{unit}\"")),
            wraps.then(|| "wrap = true".to_owned()),
        ];
        let all: Vec<String> = all.into_iter().flatten().collect();
        return (!all.is_empty()).then(|| all.join(", "));
    }
    let whole = || values.iter().filter(|v| v.is_finite()).all(|v| v.fract() == 0.0);
    if angle && (unit.is_some() || (size > LARGEST_DEGREES && whole())) {
        let turn = (size + 1.0).log2().ceil().max(FEWEST_COUNTS).exp2();
        reason.push_str(&format!("; in counts: TODO, taken as {turn} a turn"));
        let wrap = if begins_again(values, turn) { format!(", wrap = {turn:.1}") } else { String::new() };
        return Some(format!("scale = {:.6e}{wrap}", std::f64::consts::TAU / turn));
    }
    if angle && (has(&["deg", "degrees"]) || (size > DEGREES && size <= LARGEST_DEGREES)) {
        reason.push_str(&format!("; reaches {size:.0}: degrees, it seems"));
        let wrap = if begins_again(values, 360.0) { ", wrap = true" } else { "" };
        return Some(format!("unit = \"deg\"{wrap}"));
    }
    if angle && begins_again(values, std::f64::consts::TAU) {
        return Some("wrap = true".to_owned());
    }
    if has(&["rpm"]) {
        return Some("unit = \"rpm\"".to_owned());
    }
    has(&["ma"]).then(|| "unit = \"mA\"".to_owned())
}

/// Whether an angle jumps by a turn and stays within it: an encoder that begins again.
fn begins_again(values: &[f64], turn: f64) -> bool {
    let within = values.iter().all(|v| v.abs() <= 1.05 * turn);
    within && values.windows(2).any(|w| (w[1] - w[0]).abs() > 0.8 * turn)
}

/// What only all columns together tell.
fn settled_by_others(guesses: &mut [First]) {
    let count = |all: &[First], target: &str| all.iter().filter(|g| g.target == target).count();
    // A drive whose only position is its motor's has no joint behind it.
    if count(guesses, "joint_angle_rad") == 0 {
        guesses
            .iter_mut()
            .filter(|g| g.target == "motor_angle_rad" && g.rank > 0)
            .for_each(|g| g.target = "joint_angle_rad");
    }
    // Where something else is commanded a measured voltage is the supply's.
    let commands = |g: &First| columns::INPUTS.contains(&g.target) && g.target != "voltage_v" && g.rank <= 1;
    if guesses.iter().any(commands) {
        for guess in guesses.iter_mut().filter(|g| g.target == "voltage_v" && !g.reason.contains("a command"))
        {
            guess.target = "supply_v";
            guess.reason.push_str("; another column is the command: the supply");
        }
    }
    // Of a drive that logs its position and one torque, and no command, the torque is what drives it.
    let is_input = |g: &First| columns::INPUTS.contains(&g.target);
    let one = count(guesses, "output_torque_nm") == 1 && count(guesses, "joint_angle_rad") == 1;
    if one && !guesses.iter().any(is_input) {
        for guess in guesses.iter_mut().filter(|g| g.target == "output_torque_nm" && g.rank > 0) {
            guess.target = "joint_torque_nm";
            guess.reason.push_str("; nothing else drives it: the input");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::survey;
    use crate::table::Log;

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
        let two = ["time_s", "motor_angle_rad", "joint_angle_rad"];
        assert_eq!(of(&["t", "motor_position", "joint_position"]), two);
        assert_eq!(of(&["t", "motor_position", "iq_ref"]), ["time_s", "joint_angle_rad", "current_a"]);
    }

    #[test]
    fn commands_are_told_from_measurements_and_units_from_joints() {
        let wave = |r: usize| (r as f64).sin();
        let of =
            |names: &[&str]| roles_of(names, wave).into_iter().map(|(_, target)| target).collect::<Vec<_>>();
        let legs =
            ["t_s", "hip_pos_deg", "knee_pos_deg", "hip_tau", "knee_tau", "hip_tau_cmd", "knee_tau_cmd"];
        let expected = ["time_s", "hip.angle_rad", "knee.angle_rad", "hip.torque_nm", "knee.torque_nm"];
        let found = roles_of(&legs, wave);
        assert_eq!(found.iter().map(|(_, target)| target.as_str()).collect::<Vec<_>>(), expected);
        assert!(
            found.iter().any(|(name, _)| name == "hip_tau_cmd")
                && !found.iter().any(|(name, _)| name == "hip_tau")
        );
        let sea = ["t", "motor_pos_rad", "joint_pos_rad", "motor_current_A", "spring_torque_Nm"];
        let expected = ["time_s", "motor_angle_rad", "joint_angle_rad", "current_a", "spring_torque_nm"];
        assert_eq!(of(&sea), expected);
        assert_eq!(of(&["t", "q1_rad", "tau1_Nm"]), ["time_s", "joint_angle_rad", "joint_torque_nm"]);
        // A servo's load is a share, its voltage the supply's, and an acceleration has no channel.
        let servo = ["t", "goal_position", "position", "load", "volt", "theta_dot", "acc_rad_s2"];
        assert_eq!(of(&servo), ["time_s", "position_rad", "joint_angle_rad", "supply_v", "speed_rad_s"]);
        assert_eq!(of(&["t", "pos_mm", "motor_force_N"]), ["time_s", "position_m", "motor_force_n"]);
    }

    #[test]
    fn units_and_counts_are_settings() {
        let table = |name: &str, value: fn(usize) -> f64| {
            let column = |name: &str, value: &dyn Fn(usize) -> f64| {
                crate::table::Column::of(name, (0..20).map(value).collect())
            };
            let columns = vec![column("t", &|r| 0.01 * r as f64), column(name, &value)];
            let log = Log { tables: vec![Table { columns, ..Table::default() }], ..Log::default() };
            let role = survey(&log).tables.remove(0).columns.remove(1).role.expect("a role");
            role.settings.unwrap_or_default()
        };
        let wave = |r: usize| (r as f64).sin();
        assert_eq!(table("Spring Torque [mNm]", wave), "unit = \"mNm\"");
        assert_eq!(table("vel_dps", wave), "unit = \"deg/s\"");
        assert_eq!(table("current_mA", wave), "unit = \"mA\"");
        assert_eq!(table("angle_rad", wave), "");
        assert_eq!(table("angle", |r| 100.0 * (r as f64).sin()), "unit = \"deg\"");
        // 16384 counts a turn.
        let counts = |r: usize| (8191.5 + 8191.5 * (0.3 * r as f64).sin()).round();
        assert_eq!(table("encoder_counts", counts), "scale = 3.834952e-4");
        assert_eq!(table("position", counts), "scale = 3.834952e-4");
        let turns = |r: usize| (20.0 * r as f64) % 360.0;
        assert_eq!(table("joint_pos_deg", turns), "unit = \"deg\", wrap = true");
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
