//! A robot on a fixed base or a rail with a torque drive on each of its joints, as a model that diagnosis can compare
//! with records.
//!
//! Every joint has a drive without a spring ([`sealegs_actuator::bench`]): its rotor's inertia, damping, friction and
//! every other effect of the actuators' catalogue act at the joint, and carry its name: `elbow/coulomb-friction`. The
//! links' motion is integrated in the joints' coordinates.
//!
//! Columns: `<joint>.torque_nm` commands a joint (one without such a column gets none), `<joint>.angle_rad` and
//! `<joint>.speed_rad_s` are compared; of a sliding joint `.force_n`, `.position_m`, `.speed_m_s`. A run begins where its
//! log does: each joint's position and speed by a parabola through the first rows, the position alone zero where it was
//! not logged. Friction that the URDF states is not taken: `coulomb-friction` is found, or named by the file.

mod described;
mod file;
mod joint;
mod links;
mod model;
mod observed;
mod simulate;
mod stated;
mod tree;

pub use described::DrivenJoint;
pub use file::RobotFile;
pub use model::RobotModel;
