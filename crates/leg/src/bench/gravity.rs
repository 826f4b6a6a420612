//! Commands of a robot whose controller compensates gravity by itself: what it adds to them.

use super::RobotModel;
use super::joint::{Column, Joint};
use sealegs_model::columns::GRAVITY;
use sealegs_model::{Record, Signal};

impl RobotModel {
    /// Puts beside the torques (N m, sliding joints: forces, N) that a record commands those that hold the robot, as its URDF has it, at
    /// rest where each row measured its joints: what a controller that compensates gravity by itself adds to what it is told. It
    /// does so many times between two rows, as the joints move: they are columns of their own, `JOINT.gravity_nm`, which are
    /// interpolated. The number of joints that have one.
    ///
    /// # Errors
    ///
    /// The position's channel of a joint that the record does not measure: gravity depends on it.
    pub fn compensate_gravity(&self, record: &mut Record) -> Result<usize, String> {
        let effort = |joint: &Joint| {
            let own = joint.commands().into_iter().find(|(_, input)| *input == joint.effort());
            own.is_some_and(|(channel, _)| record.input(&channel).is_some())
        };
        let told: Vec<bool> = self.joints.iter().map(effort).collect();
        let number = told.iter().filter(|told| **told).count();
        if number == 0 {
            return Ok(0);
        }
        let position = |joint: &Joint| {
            let channel = joint.channel(Column::Position);
            record.output(&channel).map(<[f64]>::to_vec).ok_or(channel)
        };
        let positions = self.joints.iter().map(position).collect::<Result<Vec<_>, _>>()?;
        let mut equations = self.tree.equations();
        let still = vec![0.0; positions.len()];
        let mut holding: Vec<Vec<f64>> = vec![Vec::with_capacity(record.len()); positions.len()];
        for row in 0..record.len() {
            let posture: Vec<f64> = positions.iter().map(|of| of[row]).collect();
            self.tree.at(&posture, &still, &mut equations);
            holding.iter_mut().zip(&equations.bias).for_each(|(of, holds)| of.push(*holds));
        }
        let all = self.joints.iter().zip(told).zip(holding).filter(|((_, told), _)| *told);
        record.inputs.extend(all.map(|((joint, _), values)| {
            let what = GRAVITY[usize::from(joint.slides)];
            Signal { channel: format!("{}.{what}", joint.name), values }
        }));
        Ok(number)
    }
}

#[cfg(test)]
mod tests {
    use crate::bench::{RobotFile, RobotModel};
    use sealegs_model::{InputHold, Record, Signal};

    /// 2 kg whose centre of mass is 0.4 m from a hinge, hanging down at zero.
    const URDF: &str = r#"<robot name="pendulum">
      <link name="base"/>
      <link name="arm"><inertial><origin xyz="0 0 -0.4"/><mass value="2"/>
        <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 -1 0"/></joint>
    </robot>"#;

    fn record(outputs: Vec<Signal>) -> Record {
        let inputs = vec![Signal { channel: "hinge.torque_nm".into(), values: vec![0.5; 3] }];
        let time_s = vec![0.0, 0.1, 0.2];
        Record { name: "a".into(), cut: false, time_s, hold: InputHold::ZeroOrder, inputs, outputs }
    }

    #[test]
    fn the_torque_that_holds_a_pendulum_stands_beside_its_command() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("p.urdf"), URDF).expect("written");
        let file = RobotFile::of_urdf("p.urdf", "rigid-rotary", folder.path());
        let model = RobotModel::new(file, &[]).expect("a robot");
        let angle = Signal { channel: "hinge.angle_rad".into(), values: vec![0.0, 0.7, -1.2] };
        let mut with_angle = record(vec![angle.clone()]);
        assert_eq!(model.compensate_gravity(&mut with_angle), Ok(1));
        let added = with_angle.input("hinge.gravity_nm").expect("beside the command");
        for (added, angle) in added.iter().zip(angle.values) {
            let holds = 2.0 * 9.81 * 0.4 * angle.sin();
            assert!((added - holds).abs() < 1e-12, "{added} at {angle}");
        }
        assert_eq!(with_angle.input("hinge.torque_nm"), Some(&[0.5; 3][..]));
        assert_eq!(model.compensate_gravity(&mut record(Vec::new())), Err("hinge.angle_rad".to_owned()));
    }
}
