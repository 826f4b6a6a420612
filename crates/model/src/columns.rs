//! The columns of a bench's log, as the contract calls them: what a campaign may hold and a bench's model takes and predicts.

/// Commands to the motor; a run of a bench has exactly one of them. `joint_torque_nm` is `motor_torque_nm` by the name that
/// drives without a spring are commanded by.
pub const INPUTS: [&str; 6] =
    ["current_a", "motor_force_n", "motor_torque_nm", "joint_torque_nm", "voltage_v", "position_rad"];

/// Whether the drive is switched on, beside an input: below 0.5 its bridge is open.
pub const ENABLE: &str = "enable";

/// The measured supply of a servo, beside its input, V.
pub const SUPPLY: &str = "supply_v";

/// The measured temperature of the drive, beside its input, degrees Celsius.
pub const TEMPERATURE: &str = "temperature_c";

/// The goal's own speed, beside a goal of a loop that commands a torque, rad/s.
pub const GOAL_SPEED: &str = "goal_speed_rad_s";

/// The torque that such a loop adds to its own, N m.
pub const FEEDFORWARD: &str = "feedforward_nm";

/// What a controller adds to a torque (N m) or force (N) that it is told, by where its joint is: it compensates gravity.
pub const GRAVITY: [&str; 2] = ["gravity_nm", "gravity_n"];

/// What a drive reads beside its command.
pub const BESIDE: [&str; 7] = [ENABLE, SUPPLY, TEMPERATURE, GOAL_SPEED, FEEDFORWARD, GRAVITY[0], GRAVITY[1]];

/// Commands to a joint of a robot, behind the joint's name and a dot; the goal of a servo's own loop is the last.
pub const JOINT_COMMANDS: [&str; 5] = ["torque_nm", "force_n", "current_a", "voltage_v", "position_rad"];

/// The joint that a robot's channel commands: `knee` of `knee.torque_nm`.
#[must_use]
pub fn commanded_joint(channel: &str) -> Option<&str> {
    let (joint, what) = channel.rsplit_once('.')?;
    JOINT_COMMANDS.contains(&what).then_some(joint)
}

/// What a bench's sensors may have recorded.
pub const OUTPUTS: [&str; 11] = [
    "force_1_n",
    "force_2_n",
    "motor_angle_rad",
    "spring_deflection_m",
    "joint_angle_rad",
    "output_torque_nm",
    "spring_torque_nm",
    "spring_deflection_rad",
    "position_m",
    "speed_m_s",
    "speed_rad_s",
];
