//! A double pendulum with torque drives, and what tests of robots compare.

use sealegs_leg::bench::{RobotFile, RobotModel};
use sealegs_model::Model;
use std::path::Path;

/// Two links that hang from a base.
pub const TWO: &str = r#"<robot name="two">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 -0.275"/><mass value="0.608"/>
    <inertia ixx="0.0087" iyy="0.0087" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0 -0.166"/><mass value="0.63"/>
    <inertia ixx="0.0078" iyy="0.0078" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 -1 0"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 -0.3"/><axis xyz="0 -1 0"/></joint>
</robot>"#;

/// A drive, 6:1, that takes a torque.
pub const TORQUE: &str = "id = \"drive\"\nkind = \"rotary\"\nspring = \"none\"\n[motor]\ntorque_constant_nm_a = 1.0\n\
                      rotor_inertia_kg_m2 = 6e-5\nrotor_damping_nm_s = 1e-3\n[transmission]\ntype = \"gear\"\n\
                      gear_ratio = 6.0\n";

/// The robot of a URDF with one drive at every joint; both are written into a folder.
pub fn robot(folder: &Path, urdf: &str, drive: &str) -> RobotModel {
    std::fs::write(folder.join("robot.urdf"), urdf).expect("written");
    std::fs::write(folder.join("drive.toml"), drive).expect("written");
    let file = RobotFile::of_urdf("robot.urdf", "drive.toml", folder);
    RobotModel::new(file, &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// The nominal values of a model's parameters.
pub fn values(model: &dyn Model) -> Vec<f64> {
    model.parameters().iter().map(|p| p.value).collect()
}

/// The greatest difference of two signals.
pub fn farthest(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
