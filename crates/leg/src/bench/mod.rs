//! A robot on a fixed base or a rail with a drive on each of its joints, as a model that diagnosis can compare with records.
//!
//! Every joint has a drive ([`sealegs_actuator::bench`]): its rotor's inertia, damping, friction and every other effect of the
//! actuators' catalogue act at the joint, and carry its name: `elbow/coulomb-friction`. A drive with a series spring has the
//! spring between its rotor and the joint's link. The links' motion is integrated in the joints' coordinates, and in those of
//! the rotors that move apart from them.
//!
//! Columns: one of `<joint>.torque_nm`, `.current_a`, `.voltage_v` and `.position_rad` (the goal of a servo's own loop)
//! commands a joint, as its drive admits; one without any is told no torque. Beside it a drive reads `<joint>.enable`,
//! `.supply_v` and `.temperature_c`, or the same without a joint where all share them. `<joint>.angle_rad`, `.speed_rad_s` and
//! `.motor_angle_rad` are compared, and the torque that passes to the link, `.output_torque_nm`; with a spring
//! `.spring_deflection_rad` and `.spring_torque_nm`, too. Of a sliding joint `.force_n` commands, and compared are `.position_m`,
//! `.speed_m_s` and `.force_2_n` (with a spring `.force_1_n`, the spring's, and `.spring_deflection_m`). A run
//! begins where its log does: each joint's position and speed by a cubic through the first rows, or, where these tell them only
//! roughly, where the model's own motion meets them best; the position alone zero where it was not logged. Friction that the URDF states is not taken: `coulomb-friction` is found, or named by the file.

mod alike;
mod begin;
mod described;
mod file;
mod gravity;
mod joint;
mod links;
mod model;
mod observed;
mod parts;
mod predict;
mod records;
mod rub;
mod simulate;
mod stated;

pub use described::DrivenJoint;
pub use file::RobotFile;
pub use model::RobotModel;
