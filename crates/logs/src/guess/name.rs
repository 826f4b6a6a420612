//! What a column's name says: its words, the unit at its end, the joint that it belongs to.

use super::words::{COMMANDED, DERIVED, Quantity, SUPPLY, WORDS};
use crate::table::stated_unit;

/// What a unit is one of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dimension {
    Angle,
    Length,
    AngularSpeed,
    LinearSpeed,
    Acceleration,
    Torque,
    Force,
    Current,
    Voltage,
    Temperature,
    /// Of an encoder: how many make a turn no name says.
    Counts,
}

/// How units are written at a name's end, in small letters; what `unit = ` calls them, nothing for SI; what they measure.
const UNITS: [(&[&str], &str, Dimension); 28] = [
    (&["rad", "radian", "radians"], "", Dimension::Angle),
    (&["deg", "degree", "degrees", "°"], "deg", Dimension::Angle),
    (&["mrad"], "mrad", Dimension::Angle),
    (&["rev", "revs", "turn", "turns"], "turn", Dimension::Angle),
    (&["count", "counts", "cnt", "tick", "ticks"], "", Dimension::Counts),
    (&["m"], "", Dimension::Length),
    (&["mm"], "mm", Dimension::Length),
    (&["cm"], "cm", Dimension::Length),
    (&["um", "µm"], "um", Dimension::Length),
    (&["rad_s", "rad/s", "radps", "rad_per_s"], "", Dimension::AngularSpeed),
    (&["deg_s", "deg/s", "dps", "degps", "°/s"], "deg/s", Dimension::AngularSpeed),
    (&["rpm", "1/min", "min^-1", "min-1", "u/min"], "rpm", Dimension::AngularSpeed),
    (&["rev_s", "rev/s", "turns/s", "turn/s", "rps"], "rev/s", Dimension::AngularSpeed),
    (&["m_s", "m/s"], "", Dimension::LinearSpeed),
    (&["mm_s", "mm/s"], "mm/s", Dimension::LinearSpeed),
    (&["rad_s2", "rad/s2", "rad/s^2", "m_s2", "m/s2", "m/s^2"], "", Dimension::Acceleration),
    (&["nm", "n_m", "n m", "n*m"], "", Dimension::Torque),
    (&["mnm"], "mNm", Dimension::Torque),
    (&["nmm"], "Nmm", Dimension::Torque),
    (&["ncm"], "Ncm", Dimension::Torque),
    (&["n", "newton", "newtons"], "", Dimension::Force),
    (&["kn"], "kN", Dimension::Force),
    (&["a", "amp", "amps"], "", Dimension::Current),
    (&["ma"], "mA", Dimension::Current),
    (&["v", "volt", "volts"], "", Dimension::Voltage),
    (&["mv"], "mV", Dimension::Voltage),
    (&["degc", "celsius", "°c"], "", Dimension::Temperature),
    (&["c"], "", Dimension::Temperature),
];

impl Dimension {
    /// What is measured in it; `None` for what no channel holds.
    pub(super) fn quantity(self) -> Option<Quantity> {
        Some(match self {
            Self::Angle | Self::Length | Self::Counts => Quantity::Position,
            Self::AngularSpeed | Self::LinearSpeed => Quantity::Speed,
            Self::Torque => Quantity::Torque,
            Self::Force => Quantity::Force,
            Self::Current => Quantity::Current,
            Self::Voltage => Quantity::Voltage,
            Self::Temperature => Quantity::Temperature,
            Self::Acceleration => return None,
        })
    }
}

/// The unit that a text is, by what `unit = ` calls it, nothing for SI.
fn known(text: &str) -> Option<(&'static str, Dimension)> {
    let text = text
        .trim()
        .to_lowercase()
        .replace(['·', '⋅'], "*")
        .replace('⁻', "-")
        .replace('¹', "1")
        .replace('μ', "µ");
    UNITS.iter().find(|(all, ..)| all.contains(&text.as_str())).map(|&(_, unit, of)| (unit, of))
}

/// The unit that a row of units under the header states.
pub(super) fn of_row(holds: &str) -> Option<(&'static str, Dimension)> {
    known(stated_unit(holds)?)
}

/// Words of a position that is an angle.
const ANGLES: [&str; 6] = ["theta", "q", "angle", "angles", "winkel", "phi"];

/// Whether a name is a motor's: by a word, by the part of a path that it stands in (`motor.pos_deg`), or by an `m` behind an angle.
pub(super) fn of_motor(name: &str) -> bool {
    const MOTOR: [&str; 4] = ["motor", "rotor", "mot", "mtr"];
    let words = words(last_part(name));
    let parts = name.split('.').rev().skip(1).any(|part| MOTOR.contains(&part.to_lowercase().as_str()));
    let angle_m = words.windows(2).any(|w| ANGLES.contains(&w[0].as_str()) && w[1] == "m");
    parts || angle_m || words.iter().any(|w| MOTOR.contains(&w.as_str()))
}

/// A name without the unit at its end, and that.
pub(super) fn without_unit(name: &str) -> (&str, Option<(&'static str, Dimension)>) {
    let name = name.trim();
    let inside = match name.chars().last() {
        Some(')') => name.rfind('('),
        Some(']') => name.rfind('['),
        _ => None,
    };
    if let Some(at) = inside {
        return match known(&name[at + 1..name.len() - 1]) {
            Some(unit) => (name[..at].trim_end(), Some(unit)),
            None => (name, None),
        };
    }
    let ends: Vec<usize> = name.match_indices(['_', ' ']).map(|(at, _)| at).rev().take(3).collect();
    // The longest one: `rad_s` is no second.
    let longest = ends.into_iter().rev().find_map(|at| Some((at, known(&name[at + 1..])?)));
    let Some((at, unit)) = longest else { return (name, None) };
    let rest = &name[..at];
    // A letter is a unit only where the words before it say the same: phase a, motor m.
    let before = words(last_part(rest));
    let says_so = || quantity_of(&before).map(|(q, _)| q) == unit.1.quantity();
    // `T_motor_C`, and `theta_m` of a motor.
    let is_temperature = unit.1 == Dimension::Temperature && before.iter().any(|w| w == "t");
    let is_motors = unit.1 == Dimension::Length && before.iter().any(|w| ANGLES.contains(&w.as_str()));
    let is_unit = name.len() - at > 2 || (says_so() && !is_motors) || is_temperature;
    if is_unit { (rest, Some(unit)) } else { (name, None) }
}

/// The unit of an estimate or a command of ODrive, which counts turns: no other drive calls them so.
pub(super) fn of_odrive(name: &str) -> Option<(&'static str, Dimension)> {
    let name = name.to_lowercase();
    let ends = |all: &[&str]| all.iter().any(|end| name.ends_with(end));
    if ends(&["pos_estimate", "input_pos"]) {
        return Some(("turn", Dimension::Angle));
    }
    ends(&["vel_estimate", "input_vel"]).then_some(("rev/s", Dimension::AngularSpeed))
}

/// What stands in brackets at a name's end, where it is no unit that is known: `tics` of `speed [tics]`, and not `2` of `positions[2]`.
pub(super) fn unknown_unit(name: &str) -> Option<&str> {
    let name = name.trim();
    let open = if name.ends_with(']') { '[' } else { '(' };
    let inside = name.strip_suffix([')', ']'])?;
    let at = inside.rfind(open)?;
    let (before, inside) = (&name[..at], &inside[at + 1..]);
    // A list's member stands behind its name without a space.
    let apart = open == '(' || before.ends_with([' ', '_']);
    (apart && !inside.is_empty() && known(inside).is_none()).then_some(inside)
}

/// The words of a name, small: `tau_con1` is `tau`, `con`, `1`; `jointPos` is `joint`, `pos`.
pub(super) fn words(name: &str) -> Vec<String> {
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
///
/// What holds the values of a signal (`logsout.tau_ref.Data`) is no part of its name.
pub(super) fn last_part(name: &str) -> &str {
    let parts = || name.rsplit('.').filter(|part| !part.is_empty());
    let holds = |part: &&str| HOLDS.contains(&part.to_lowercase().as_str());
    parts().find(|part| !holds(part)).or_else(|| parts().next()).unwrap_or(name)
}

/// What the field of a structure is called that holds a signal's values.
const HOLDS: [&str; 5] = ["data", "value", "values", "signal", "signals"];

/// What words say is measured, and by which of them. The first quantity of the list that is among them decides:
/// `torque_enable` is no torque.
pub(super) fn quantity_of(words: &[String]) -> Option<(Quantity, &str)> {
    let find = |list: &[&str]| words.iter().find(|w| list.contains(&w.as_str()));
    let (quantity, word) = WORDS.iter().find_map(|(q, list)| find(list).map(|w| (*q, w.as_str())))?;
    let rate = quantity == Quantity::Position && words.iter().any(|w| w == "dot");
    Some((if rate { Quantity::Speed } else { quantity }, word))
}

/// Words before a quantity that name no joint: a part of one drive, or what kind of number it is.
const NO_JOINT: [&str; 30] = [
    "m", "mot", "mtr", "motor", "joint", "spring", "load", "output", "input", "rotor", "link", "screw",
    "meas", "measured", "actual", "act", "present", "raw", "filt", "real", "sensor", "encoder", "abs", "inc",
    "dot", "d", "q", "id", "iq", "phase",
];

fn is_quantity(word: &str) -> bool {
    WORDS.iter().any(|(_, list)| list.contains(&word))
}

/// Whether a word says what kind of number it is, and names no joint.
fn is_kind(word: &str) -> bool {
    [&NO_JOINT[..], &COMMANDED, &DERIVED, &SUPPLY].iter().any(|list| list.contains(&word))
}

/// What stands before the quantity at a name's end: `arm_1_joint` of `arm_1_joint_position`, `knee` of `knee_tau_des`.
fn before_quantity(name: &str) -> Option<String> {
    let mut rest = last_part(name);
    loop {
        let (head, tail) = rest.rsplit_once(['_', ' '])?;
        let tail = tail.to_lowercase();
        if is_quantity(&tail) {
            let head = head.trim_matches(|c: char| !c.is_alphanumeric());
            let words = words(head);
            return (!words.is_empty() && !words.iter().all(|w| is_kind(w) || is_quantity(w)))
                .then(|| head.to_owned());
        }
        if !is_kind(&tail) {
            return None;
        }
        rest = head;
    }
}

/// What stands behind the quantity at a name's beginning: `hip` of `tau_hip_cmd`.
fn behind_quantity(name: &str) -> Option<String> {
    let words = words(last_part(name));
    let (first, rest) = words.split_first()?;
    let names = |w: &&String| !is_kind(w) && !is_quantity(w);
    let joint: Vec<&str> = rest.iter().filter(names).map(String::as_str).collect();
    if !is_quantity(first) {
        return None;
    }
    // `tau_J_2` of libfranka is a torque of the second joint.
    if let [word, number] = joint[..]
        && JOINT.contains(&word)
        && number.chars().all(|c| c.is_ascii_digit())
    {
        return Some(format!("joint{number}"));
    }
    let has_letters = joint.iter().any(|w| w.chars().any(char::is_alphabetic) && !JOINT.contains(w));
    has_letters.then(|| joint.join("_"))
}

/// What stands above the quantity in a path: `knee` of `/joint_states/knee/position`, as PlotJuggler writes it.
fn above_quantity(path: &str) -> Option<&str> {
    let (rest, quantity) = path.strip_prefix('/')?.rsplit_once('/')?;
    let (_, joint) = rest.rsplit_once('/')?;
    let words = words(joint);
    let named = !words.iter().all(|w| is_kind(w) || is_quantity(w));
    (is_quantity(&quantity.to_lowercase()) && named).then_some(joint)
}

/// Words that a number behind them makes the name of a joint.
const JOINT: [&str; 10] = ["j", "joint", "axis", "ax", "dof", "motor", "m", "act", "actuator", "servo"];

/// The numbered joint that a name begins with: `J1` of `J1 tau cmd`.
pub(super) fn numbered(name: &str) -> Option<&str> {
    let name = last_part(name);
    let letters = name.find(|c: char| !c.is_alphabetic())?;
    let number = letters + name[letters..].find(|c: char| c.is_ascii_digit())?;
    let end = number + name[number..].find(|c: char| !c.is_ascii_digit())?;
    let between = name[letters..number].chars().all(|c| matches!(c, '_' | '-' | ' '));
    (between && JOINT.contains(&name[..letters].to_lowercase().as_str())).then(|| &name[..end])
}

/// The joint that a name belongs to: what stands in its last brackets, its numbered beginning, what stands before or behind its
/// quantity, or the number at its end.
#[must_use]
pub fn joint(name: &str) -> Option<String> {
    let (name, _) = without_unit(name);
    let inside = name.rfind('[').and_then(|at| name[at + 1..].strip_suffix(']'));
    if let Some(inside) = inside {
        return Some(match inside.parse::<u32>() {
            Ok(number) => format!("joint{number}"),
            Err(_) => inside.to_owned(),
        });
    }
    if let Some(joint) = above_quantity(name) {
        return Some(joint.to_owned());
    }
    let named = numbered(name).map(str::to_owned).or_else(|| before_quantity(name));
    if let Some(joint) = named.or_else(|| behind_quantity(name)) {
        return Some(joint);
    }
    let digits = name.len() - name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    (digits > 0 && digits < name.len()).then(|| format!("joint{}", &name[name.len() - digits..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_fall_into_words() {
        assert_eq!(words("tau_con1"), ["tau", "con", "1"]);
        assert_eq!(words("jointPos[2]"), ["joint", "pos", "2"]);
        assert_eq!(words("/joint_states.position"), ["joint", "states", "position"]);
    }

    #[test]
    fn a_unit_at_a_names_end_is_none_of_its_words() {
        let of = |name| {
            let (rest, unit) = without_unit(name);
            (rest, unit.map(|(unit, _)| unit))
        };
        assert_eq!(of("hip_pos_deg"), ("hip_pos", Some("deg")));
        assert_eq!(of("Spring Torque [mNm]"), ("Spring Torque", Some("mNm")));
        assert_eq!(of("Velocity (deg/s)"), ("Velocity", Some("deg/s")));
        assert_eq!(of("hip_vel_rad_s"), ("hip_vel", Some("")));
        assert_eq!(of("acc_rad_s2"), ("acc", Some("")));
        assert_eq!(of("current_mA"), ("current", Some("mA")));
        assert_eq!(of("force_N"), ("force", Some("")));
        assert_eq!(of("current_a"), ("current", Some("")));
        assert_eq!(of("encoder_counts"), ("encoder", Some("")));
        for no_unit in ["phase_a", "pos_c", "force_m", "positions[2]", "jointPos", "state[knee]"] {
            assert_eq!(of(no_unit), (no_unit, None));
        }
    }

    #[test]
    fn units_are_known_as_instruments_write_them_and_others_are_said() {
        let of = |name| without_unit(name).1.map(|(unit, _)| unit);
        assert_eq!(of("rotor speed [1/min]"), Some("rpm"));
        assert_eq!(of("Motor speed (min⁻¹)"), Some("rpm"));
        assert_eq!(of("Torque command (N·m)"), Some(""));
        assert_eq!(of("travel [μm]"), Some("um"));
        assert_eq!(unknown_unit("speed [tics]"), Some("tics"));
        for known in ["speed [rpm]", "positions[2]", "state[knee]", "speed"] {
            assert_eq!(unknown_unit(known), None, "{known}");
        }
        assert_eq!(last_part("logsout.tau_ref.Data"), "tau_ref");
        assert_eq!(last_part("data"), "data");
    }

    #[test]
    fn joints_are_named_before_and_behind_their_quantity() {
        let named = [
            ("hip_vel_rpm", "hip"),
            ("left_knee_tau_des", "left_knee"),
            ("tau_hip_cmd", "hip"),
            ("q_knee", "knee"),
            ("q1_rad", "joint1"),
            ("tau_con1", "joint1"),
            ("tau_J_d_1", "joint1"),
            ("tau_J[3]", "joint3"),
            ("positions[2]", "joint2"),
            ("- arm_1_joint_position", "arm_1_joint"),
            ("/joint_states/arm_2_joint/position", "arm_2_joint"),
        ];
        for (name, expected) in named {
            assert_eq!(joint(name).as_deref(), Some(expected), "{name}");
        }
        for none in [
            "torque_Nm",
            "motor_position",
            "theta_dot",
            "pos_meas",
            "torque_enable",
            "d_current",
            "q_current",
        ] {
            assert_eq!(joint(none), None, "{none}");
        }
    }
}
