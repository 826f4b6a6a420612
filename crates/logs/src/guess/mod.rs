//! What a column probably is, by the words in its name and the size of its numbers.

mod clock;
mod column;
mod name;
mod words;

pub use clock::is_time;
pub(crate) use clock::time_unit;
pub use name::joint as joint_of;

use crate::lerobot;
use crate::survey::{ColumnSurvey, Role, goes_on};
use crate::table::Table;
use column::{DEGREES, by_words};
use sealegs_model::{Unit, columns};

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
        if is_time(own) && goes_on(values) {
            asides.push((i, "a clock of its own".to_owned()));
            continue;
        }
        let stated = known(own).filter(|own| own.contains('_') && Unit::of_channel(own).is_ok());
        if let Some(target) = of_joint_by_contract(own) {
            let reason = "the data contract calls it so".to_owned();
            guesses.push(First { column: i, target, settings: None, reason, rank: 0 });
        } else if let Some(target) = stated {
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
    for mut guess in guesses {
        let name = &table.columns[guess.column].name;
        let of_a_joint_too = several.contains(&guess.target.to_owned()) || name::numbered(name).is_some();
        let named = joints.iter().find(|(column, _)| column == name).map(|(_, joint)| joint.clone());
        let by_contract = name.rsplit_once('.').filter(|_| of_joint_by_contract(name).is_some());
        let named = named.or_else(|| by_contract.map(|(joint, _)| joint.to_owned()));
        let place = named.or_else(|| name::joint(name).filter(|_| many_joints && of_a_joint_too));
        let target = match (place, by_contract) {
            (Some(joint), Some((_, what))) => format!("{joint}.{what}"),
            (Some(joint), None) => format!("{joint}.{}", of_a_joint(guess.target)),
            (None, _) if [columns::GOAL_SPEED, columns::FEEDFORWARD].contains(&guess.target) => {
                let why = format!("{}: a joint's {} beside a goal", guess.reason, guess.target);
                columns[guess.column].aside = Some(why);
                continue;
            }
            (None, _) => guess.target.to_owned(),
        };
        // A bench has one input, and a joint one command.
        let input = |t: &str| columns::INPUTS.contains(&t);
        let commands = columns::commanded_joint(&target);
        let twice = |t: &str| {
            t == target
                || (input(t) && input(&target))
                || (commands.is_some() && columns::commanded_joint(t) == commands)
        };
        let other = taken.iter().find(|(t, _)| twice(t));
        if let Some((_, other)) = other {
            columns[guess.column].aside = Some(format!("{}; '{other}' is taken in its place", guess.reason));
            continue;
        }
        let stands_in = guess.target == "output_torque_nm" && commands.is_some();
        if stands_in {
            guess.reason.push_str("; TODO: measured, and taken for the command, as no other one moves");
        }
        taken.push((target.clone(), columns[guess.column].name.clone()));
        let (settings, reason) = (guess.settings, guess.reason);
        columns[guess.column].role = Some(Role { target, settings, reason, stands_in });
    }
}

/// A channel by the contract's own name for it.
fn known(name: &str) -> Option<&'static str> {
    let mut all = columns::INPUTS.into_iter().chain(columns::OUTPUTS).chain(columns::BESIDE);
    all.find(|known| *known == name)
}

/// What a column is on a bench of the drive alone, if the contract itself calls it so behind a joint's name: `knee.angle_rad`.
fn of_joint_by_contract(name: &str) -> Option<&'static str> {
    let (_, what) = name.rsplit_once('.').filter(|(joint, _)| !joint.is_empty())?;
    if what == "angle_rad" {
        return Some("joint_angle_rad");
    }
    let own = columns::JOINT_COMMANDS.into_iter().chain(columns::BESIDE).chain(columns::OUTPUTS);
    own.filter(|own| own.contains('_')).find(|own| *own == what)
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

/// What a column of a dataset of LeRobot is: a measured position or its goal.
///
/// LeRobot gives positions in per cent of each joint's calibrated range, -100 to 100 and a gripper's from 0 on, unless the recording
/// was told to take degrees: the numbers do not say which.
fn of_dataset(index: usize, name: &str, degrees: bool) -> Option<First> {
    let (target, what) = match list_of(name)? {
        lerobot::ACTION => ("position_rad", "the goal"),
        _ => ("joint_angle_rad", "the measured position"),
    };
    let mut reason = format!("LeRobot's name for {what}");
    if degrees {
        reason.push_str("; TODO: in degrees (use_degrees), or in per cent of its calibrated range: then unit -> scale = rad per per cent");
    }
    let settings = degrees.then(|| "unit = \"deg\"".to_owned());
    Some(First { column: index, target, settings, reason, rank: 1 })
}

/// What only all columns together tell.
fn settled_by_others(guesses: &mut [First]) {
    let count = |all: &[First], target: &str| all.iter().filter(|g| g.target == target).count();
    // A drive whose only position is its motor's has no joint behind it, unless a load cell or a spring does.
    let springs = ["force_1_n", "spring_torque_nm", "spring_deflection_rad", "spring_deflection_m"];
    if count(guesses, "joint_angle_rad") == 0 && !guesses.iter().any(|g| springs.contains(&g.target)) {
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
    fn a_motors_encoder_is_none_of_the_joint_and_a_temperature_no_time() {
        let wave = |r: usize| (r as f64).sin();
        let of =
            |names: &[&str]| roles_of(names, wave).into_iter().map(|(_, target)| target).collect::<Vec<_>>();
        let two = ["time_s", "motor_angle_rad", "joint_angle_rad"];
        for names in [
            ["epoch_ms", "samples.motor.pos_deg", "samples.joint.q"],
            ["unix", "mot_deg", "joint_rad"],
            ["utc_ms", "theta_m", "theta_l"],
            ["t", "mot_enc", "joint_angle"],
        ] {
            assert_eq!(of(&names), two, "{names:?}");
        }
        let locked = ["time_s", "current_a", "force_1_n", "motor_angle_rad"];
        assert_eq!(of(&["t", "i_q", "F_lc", "theta_m"]), locked);
        let expected = ["time_s", "joint_angle_rad", "temperature_c"];
        for name in ["T_motor_C", "T_winding_C", "T [°C]", "T_winding", "T_mos"] {
            assert_eq!(of(&["t", "angle", name]), expected, "{name}");
        }
        // It rises with time, and is none.
        let rising = roles_of(&["t", "T_winding"], |r| 25.0 + 0.1 * r as f64);
        assert_eq!(rising[1].1, "temperature_c");
        assert_eq!(of(&["t", "pos_m", "force_N"]), ["time_s", "position_m", "force_1_n"]);
    }

    #[test]
    fn a_time_counter_that_begins_again_goes_on() {
        let period = 4_294_967_296.0;
        let stamps = (0..40).map(|r| (period - 100.0 + 5.0 * f64::from(r)) % period).collect();
        let columns = vec![
            crate::table::Column::of("time_ms", stamps),
            crate::table::Column::of("position", (0..40).map(|r| f64::from(r).sin()).collect()),
        ];
        let log = Log { tables: vec![Table { columns, ..Table::default() }], ..Log::default() };
        let found = survey(&log).tables.remove(0);
        let clock = found.clock.expect("a clock");
        assert!((clock.duration_s - 0.195).abs() < 1e-9 && clock.stands.is_none(), "{clock:?}");
        let role = found.columns[0].role.as_ref().expect("time");
        assert_eq!(role.settings.as_deref(), Some("unit = \"ms\", wrap = 4294967296.0"));
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
        let slow = |r: usize| (0.3 * r as f64).sin();
        assert_eq!(table("axis0.encoder.pos_estimate", slow), "unit = \"turn\"");
        assert_eq!(table("axis0.encoder.vel_estimate", wave), "unit = \"rev/s\"");
        assert_eq!(table("angle", |r| 100.0 * (r as f64).sin()), "unit = \"deg\"");
        // A motor turns many times behind its gear.
        assert_eq!(table("theta_m", |r| 25.3 * (r as f64).sin()), "");
        // 16384 counts a turn.
        let counts = |r: usize| (8191.5 + 8191.5 * (0.3 * r as f64).sin()).round();
        assert_eq!(table("encoder_counts", counts), "scale = 3.834952e-4");
        assert_eq!(table("position", counts), "scale = 3.834952e-4");
        let turns = |r: usize| (20.0 * r as f64) % 360.0;
        assert_eq!(table("joint_pos_deg", turns), "unit = \"deg\", wrap = true");
    }
}
