//! What a single column is, by its name and the size of its numbers.

use super::clock::is_temperature;
use super::name::{self, Dimension, last_part, quantity_of, without_unit, words};
use super::words::{ACCELERATION, COMMANDED, COMMANDS, DERIVED, FEEDFORWARD_WORDS, Quantity, SUPPLY};
use super::{First, Guess, reach};
use crate::survey::ColumnSurvey;
use crate::units;
use sealegs_model::columns::{FEEDFORWARD, GOAL_SPEED};

/// An angle beyond this is in degrees, rad.
pub(super) const DEGREES: f64 = 20.0;

/// An angle beyond this is in no degrees either: a turn and a tenth.
const LARGEST_DEGREES: f64 = 400.0;

/// A current, a torque or a speed in whole numbers beyond this is raw: a drive that resolves 1 A or 1 N m has no control.
const LARGEST_WHOLE: f64 = 50.0;

/// The fewest counts of an encoder's turn, as a power of two: 12 bits are the coarsest that servos have.
const FEWEST_COUNTS: f64 = 12.0;

/// What a column is by the words and the unit in its name, and the size of its numbers.
pub(super) fn by_words(index: usize, name: &str, values: &[f64], column: &ColumnSurvey) -> Option<Guess> {
    let (plain, unit) = without_unit(name);
    let stated = unit.or_else(|| name::of_row(column.holds.as_deref()?));
    let of_odrive = name::of_odrive(name).filter(|_| stated.is_none());
    let unit = stated.or(of_odrive);
    let (all, words) = (words(plain), words(last_part(plain)));
    let find = |list: &[&str]| words.iter().find(|w| list.contains(&w.as_str()));
    if find(&ACCELERATION).is_some() || unit.is_some_and(|(_, of)| of.quantity().is_none()) {
        return Some(Guess::Aside("an acceleration: no channel holds it".to_owned()));
    }
    let warm = is_temperature(last_part(plain), &words).then_some((Quantity::Temperature, "T"));
    let warm = warm.filter(|_| unit.is_none() && quantity_of(&words).is_none());
    let by_name = warm.or_else(|| quantity_of(&words)).or_else(|| quantity_of(&all));
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
        // MuJoCo's `ctrl`, a learner's `actions`.
        (None, None) => {
            let word = find(&COMMANDED).filter(|word| word.len() > 2)?;
            let why = format!(
                "TODO: '{word}' in its name: a command of what? motor_torque_nm, position_rad, current_a, voltage_v, or a joint's own"
            );
            return Some(Guess::Aside(why));
        }
    };
    let commanded = find(&COMMANDED).or_else(|| all.iter().find(|w| COMMANDS.contains(&w.as_str())));
    // Franka's `tau_J_d` is desired, and a current's `d` an axis.
    let last = words.iter().rev().find(|w| w.chars().any(char::is_alphabetic));
    let desired = last.filter(|w| *w == "d" && words.len() > 1 && quantity != Quantity::Current);
    let commanded = commanded.or(desired);
    if quantity == Quantity::Current && words.iter().any(|w| w == "d") {
        return Some(Guess::Aside("the current of the d axis makes no torque".to_owned()));
    }
    let (supply, derived) = (find(&SUPPLY), find(&DERIVED));
    let of_spring = find(&["spring"]).is_some();
    let of_motor = name::of_motor(plain);
    let long = unit.is_some_and(|(_, of)| matches!(of, Dimension::Length | Dimension::LinearSpeed));
    let target = match (quantity, commanded.is_some()) {
        (Quantity::Enable, _) => "enable",
        (Quantity::Temperature, _) => "temperature_c",
        (Quantity::Voltage, false) if supply.is_some() => "supply_v",
        (Quantity::Voltage, _) => "voltage_v",
        (Quantity::Current, _) => "current_a",
        (Quantity::Speed, false) if long => "speed_m_s",
        (Quantity::Speed, false) => "speed_rad_s",
        (Quantity::Speed, true) => GOAL_SPEED,
        (Quantity::Torque, _) if find(&FEEDFORWARD_WORDS).is_some() => FEEDFORWARD,
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
    if of_odrive.is_some() {
        reason.push_str("; ODrive counts turns");
    }
    let settings = settings(target, unit, &words, values, column, &mut reason);
    if let Some(unit) = name::unknown_unit(name) {
        reason.push_str(&format!("; TODO: its unit '{unit}' is not known"));
    }
    let fast = matches!(quantity, Quantity::Current | Quantity::Torque | Quantity::Speed);
    if fast && unit.is_none() && reach(column) > LARGEST_WHOLE && are_whole(values) {
        reason.push_str("; whole numbers: raw counts? TODO: its scale");
    }
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
    let counts = match unit {
        Some((_, of)) => of == Dimension::Counts,
        None => size > LARGEST_DEGREES && are_whole(values),
    };
    if angle && counts {
        let turn = (size + 1.0).log2().ceil().max(FEWEST_COUNTS).exp2();
        reason.push_str(&format!("; in counts: TODO, taken as {turn} a turn"));
        let wrap = if begins_again(values, turn) { format!(", wrap = {turn:.1}") } else { String::new() };
        return Some(format!("scale = {:.6e}{wrap}", std::f64::consts::TAU / turn));
    }
    let unit = match unit.filter(|(_, of)| *of != Dimension::Counts) {
        Some((unit, _)) => unit,
        None if angle && target == "motor_angle_rad" && size > DEGREES && size <= LARGEST_DEGREES => {
            reason.push_str(&format!("; reaches {size:.0}: TODO: in rad, or \"deg\""));
            ""
        }
        None if angle && (has(&["deg", "degrees"]) || (size > DEGREES && size <= LARGEST_DEGREES)) => {
            reason.push_str(&format!("; reaches {size:.0}: degrees, it seems"));
            "deg"
        }
        None if angle && size > LARGEST_DEGREES => {
            reason.push_str(&format!("; reaches {size:.0}: TODO: its unit"));
            ""
        }
        None if has(&["rpm"]) => "rpm",
        None if has(&["ma"]) => "mA",
        None => "",
    };
    let wraps = angle && begins_again(values, units::turn(unit));
    let all =
        [(!unit.is_empty()).then(|| format!("unit = \"{unit}\"")), wraps.then(|| "wrap = true".to_owned())];
    let all: Vec<String> = all.into_iter().flatten().collect();
    (!all.is_empty()).then(|| all.join(", "))
}

/// Whether all numbers are whole.
fn are_whole(values: &[f64]) -> bool {
    values.iter().filter(|v| v.is_finite()).all(|v| v.fract() == 0.0)
}

/// Whether an angle jumps by a turn and stays within it: an encoder that begins again.
fn begins_again(values: &[f64], turn: f64) -> bool {
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let within = finite().all(|v| v.abs() <= 1.05 * turn);
    within && finite().zip(finite().skip(1)).any(|(a, b)| (b - a).abs() > 0.8 * turn)
}
