//! A robot on a fixed base in its joints' coordinates: mass matrix and bias forces.
//!
//! Where a bench has no contact and no closed loop the joints' coordinates are all there is, and a search that simulates
//! thousands of runs needs nothing more. Links on fixed joints are part of the body that carries them.

use crate::robot::{Inertial, JointKind, Robot};
use nalgebra::{DMatrix, Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};

/// Gravitational acceleration along -z of the base, m/s^2.
const GRAVITY_M_S2: f64 = 9.81;

/// A body that one joint moves.
#[derive(Debug, Clone)]
struct Body {
    /// The body that carries its joint; `None` for the base.
    parent: Option<usize>,
    /// `parent_from_joint` at joint position zero.
    origin: Isometry3<f64>,
    axis: Unit<Vector3<f64>>,
    slides: bool,
    mass_kg: f64,
    /// In the body's frame, m.
    com: Vector3<f64>,
    /// About the centre of mass along the body's axes, kg m^2.
    inertia: Matrix3<f64>,
}

/// The bodies of a robot, parents first; body `i` moves by degree of freedom `i`.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    bodies: Vec<Body>,
}

/// What the equations of motion are at a state: `mass q'' = force - bias`.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    /// Mass matrix, kg m^2 (kg for a sliding joint).
    pub mass: DMatrix<f64>,
    /// Gravity, Coriolis and centrifugal torques, N m (N).
    pub bias: Vec<f64>,
    /// World quantities of every body, kept between calls.
    at: Vec<At>,
}

/// A body in the world.
#[derive(Debug, Clone, Default)]
struct At {
    pose: Isometry3<f64>,
    axis: Vector3<f64>,
    joint: Vector3<f64>,
    com: Vector3<f64>,
    inertia: Matrix3<f64>,
    turning: Vector3<f64>,
    /// Of the joint's point and of the turning, without the joints' own accelerations, gravity lifted.
    acceleration: Vector3<f64>,
    turning_rate: Vector3<f64>,
    force: Vector3<f64>,
    torque: Vector3<f64>,
}

impl Tree {
    /// The moving bodies of a robot on a fixed base. Mass that hangs on the base by fixed joints does not move.
    pub fn of(robot: &Robot) -> Self {
        let mut bodies: Vec<Body> = Vec::with_capacity(robot.dofs);
        // Which body carries a link, and where it is on it.
        let mut carried: Vec<(Option<usize>, Isometry3<f64>)> =
            vec![(None, Isometry3::identity()); robot.links.len()];
        for joint in &robot.joints {
            let (carrier, from_parent) = carried[joint.parent];
            let origin = from_parent * joint.origin;
            if joint.kind == JointKind::Fixed {
                carried[joint.child] = (carrier, origin);
                continue;
            }
            carried[joint.child] = (Some(bodies.len()), Isometry3::identity());
            bodies.push(Body {
                parent: carrier,
                origin,
                axis: joint.axis,
                slides: joint.kind == JointKind::Prismatic,
                mass_kg: 0.0,
                com: Vector3::zeros(),
                inertia: Matrix3::zeros(),
            });
        }
        for (link, (carrier, from_link)) in robot.links.iter().zip(&carried) {
            let (Some(inertial), Some(body)) = (&link.inertial, carrier.map(|i| &mut bodies[i])) else {
                continue;
            };
            let turn = from_link.rotation.to_rotation_matrix();
            let com = (from_link * inertial.com).coords;
            body.add(inertial.mass_kg, com, turn * inertial.inertia * turn.transpose());
        }
        Self { bodies }
    }

    /// Mass of body `i`, kg.
    pub fn mass_kg(&self, i: usize) -> f64 {
        self.bodies[i].mass_kg
    }

    /// Distance of the centre of mass of body `i` from its joint's point, m.
    pub fn com_m(&self, i: usize) -> f64 {
        self.bodies[i].com.norm()
    }

    /// Mass, centre of mass and the moments about it of body `i`, links on fixed joints included.
    pub fn inertial(&self, i: usize) -> Inertial {
        let body = &self.bodies[i];
        Inertial { mass_kg: body.mass_kg, com: body.com.into(), inertia: body.inertia }
    }

    /// Multiplies mass, centre of mass and the moments about it of body `i`.
    pub fn scale(&mut self, i: usize, mass: f64, com: f64, moments: f64) {
        let body = &mut self.bodies[i];
        body.mass_kg *= mass;
        body.com *= com;
        body.inertia *= moments;
    }

    /// Room for the equations.
    pub fn equations(&self) -> Equations {
        let n = self.bodies.len();
        Equations { mass: DMatrix::zeros(n, n), bias: vec![0.0; n], at: vec![At::default(); n] }
    }

    /// Writes the equations of motion at joint positions `q` and speeds `v`.
    pub fn at(&self, q: &[f64], v: &[f64], out: &mut Equations) {
        self.move_bodies(q, v, &mut out.at);
        let n = self.bodies.len();
        out.mass.fill(0.0);
        out.bias.fill(0.0);
        for k in 0..n {
            // Every pair of joints on the way from body k to the base moves it.
            let mut i = Some(k);
            while let Some(joint) = i {
                let (linear, turning) = self.column(joint, k, &out.at);
                let at = &out.at[k];
                out.bias[joint] += linear.dot(&at.force) + turning.dot(&at.torque);
                let momentum = (linear * self.bodies[k].mass_kg, at.inertia * turning);
                let mut j = Some(joint);
                while let Some(other) = j {
                    let (linear, turning) = self.column(other, k, &out.at);
                    let m = linear.dot(&momentum.0) + turning.dot(&momentum.1);
                    out.mass[(joint, other)] += m;
                    if other != joint {
                        out.mass[(other, joint)] += m;
                    }
                    j = self.bodies[other].parent;
                }
                i = self.bodies[joint].parent;
            }
        }
    }

    /// Velocity of the centre of mass of body `k` and its turning per speed of a joint on its way to the base.
    fn column(&self, joint: usize, k: usize, at: &[At]) -> (Vector3<f64>, Vector3<f64>) {
        let axis = at[joint].axis;
        if self.bodies[joint].slides {
            (axis, Vector3::zeros())
        } else {
            (axis.cross(&(at[k].com - at[joint].joint)), axis)
        }
    }

    /// Poses, velocities and the accelerations that remain with the joints' own taken as zero: the outward half of the
    /// recursive Newton-Euler algorithm (R. Featherstone 2008, Rigid Body Dynamics Algorithms, section 5.3).
    fn move_bodies(&self, q: &[f64], v: &[f64], at: &mut [At]) {
        for i in 0..self.bodies.len() {
            let body = &self.bodies[i];
            let base = At { acceleration: Vector3::z() * GRAVITY_M_S2, ..At::default() };
            let (done, rest) = at.split_at_mut(i);
            let parent = body.parent.map_or(&base, |p| &done[p]);
            let here = &mut rest[0];
            let moved = if body.slides {
                Isometry3::from_parts(
                    Translation3::from(body.axis.into_inner() * q[i]),
                    UnitQuaternion::identity(),
                )
            } else {
                Isometry3::from_parts(
                    Translation3::identity(),
                    UnitQuaternion::from_axis_angle(&body.axis, q[i]),
                )
            };
            here.pose = parent.pose * body.origin * moved;
            here.axis = here.pose.rotation * body.axis.into_inner();
            here.joint = here.pose.translation.vector;
            let turn = here.pose.rotation.to_rotation_matrix();
            here.com = here.joint + turn * body.com;
            here.inertia = turn * body.inertia * turn.transpose();
            let along = here.axis * v[i];
            let arm = here.joint - parent.joint;
            let w = parent.turning;
            here.acceleration =
                parent.acceleration + parent.turning_rate.cross(&arm) + w.cross(&w.cross(&arm));
            if body.slides {
                here.turning = w;
                here.turning_rate = parent.turning_rate;
                here.acceleration += 2.0 * w.cross(&along);
            } else {
                here.turning = w + along;
                here.turning_rate = parent.turning_rate + w.cross(&along);
            }
            let (w, arm) = (here.turning, here.com - here.joint);
            let of_com = here.acceleration + here.turning_rate.cross(&arm) + w.cross(&w.cross(&arm));
            here.force = of_com * body.mass_kg;
            here.torque = here.inertia * here.turning_rate + w.cross(&(here.inertia * w));
        }
    }
}

impl Body {
    /// Adds a rigidly attached part with its inertia about its own centre of mass.
    fn add(&mut self, mass_kg: f64, com: Vector3<f64>, inertia: Matrix3<f64>) {
        let total = self.mass_kg + mass_kg;
        if total <= 0.0 {
            return;
        }
        let d = com - self.com;
        // The two-body form of the parallel axis theorem: reduced mass times squared distance.
        let reduced = self.mass_kg * mass_kg / total;
        self.inertia += inertia + (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * reduced;
        self.com += d * (mass_kg / total);
        self.mass_kg = total;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two links in the xz plane, hanging at zero, with a tip on a fixed joint.
    const URDF: &str = r#"<robot name="two">
      <link name="base"/>
      <link name="upper"><inertial><origin xyz="0 0 -0.275"/><mass value="0.608"/>
        <inertia ixx="0.009" iyy="0.0087" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <link name="lower"><inertial><origin xyz="0 0 -0.1"/><mass value="0.43"/>
        <inertia ixx="0.007" iyy="0.0075" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <link name="tip"><inertial><origin xyz="0 0 -0.01"/><mass value="0.2"/>
        <inertia ixx="0.0001" iyy="0.0002" izz="0.0001" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
        <axis xyz="0 -1 0"/></joint>
      <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
        <origin xyz="0 0 -0.3"/><axis xyz="0 -1 0"/></joint>
      <joint name="weld" type="fixed"><parent link="lower"/><child link="tip"/><origin xyz="0 0 -0.2"/></joint>
    </robot>"#;

    #[test]
    fn analytic_double_pendulum() {
        let tree = Tree::of(&Robot::from_urdf(URDF, "two.urdf", None).expect("good"));
        let (m1, r1, i1, l1) = (0.608, 0.275, 0.0087, 0.3);
        let (m2, r2) = (0.63, (0.43 * 0.1 + 0.2 * 0.21) / 0.63);
        let i2 = 0.0075 + 0.0002 + 0.43 * (r2 - 0.1_f64).powi(2) + 0.2 * (0.21_f64 - r2).powi(2);
        let mut out = tree.equations();
        for (q, v) in [([0.3, -0.8], [1.5, -2.0]), ([2.5, 1.0], [-0.4, 3.0]), ([0.0, 0.0], [0.0, 0.0])] {
            tree.at(&q, &v, &mut out);
            // The textbook's matrices for angles from hanging, the second relative.
            let c = m2 * l1 * r2 * q[1].cos();
            let s = m2 * l1 * r2 * q[1].sin();
            let lower = i2 + m2 * r2 * r2;
            let m11 = i1 + m1 * r1 * r1 + lower + m2 * l1 * l1 + 2.0 * c;
            let g = GRAVITY_M_S2;
            let g2 = m2 * g * r2 * (q[0] + q[1]).sin();
            let bias = [
                -s * (2.0 * v[0] * v[1] + v[1] * v[1]) + (m1 * r1 + m2 * l1) * g * q[0].sin() + g2,
                s * v[0] * v[0] + g2,
            ];
            for (got, truth) in [
                (out.mass[(0, 0)], m11),
                (out.mass[(0, 1)], lower + c),
                (out.mass[(1, 0)], lower + c),
                (out.mass[(1, 1)], lower),
                (out.bias[0], bias[0]),
                (out.bias[1], bias[1]),
            ] {
                assert!((got - truth).abs() < 1e-12 * (1.0 + truth.abs()), "{q:?}: {got} {truth}");
            }
        }
    }

    #[test]
    fn energy_a_spatial_arm_with_a_rail_keeps_its_energy() {
        let urdf = URDF
            .replace(r#"<joint name="elbow" type="continuous">"#, r#"<joint name="elbow" type="prismatic">"#)
            .replace(r#"<origin xyz="0 0 -0.3"/><axis xyz="0 -1 0"/>"#, r#"<origin xyz="0.1 0.2 -0.3" rpy="0.3 0.2 0.5"/><axis xyz="0.6 0 0.8"/><limit lower="-9" upper="9" effort="1" velocity="1"/>"#);
        let tree = Tree::of(&Robot::from_urdf(&urdf, "rail.urdf", None).expect("good"));
        let mut out = tree.equations();
        // The bias has the power that the mass matrix's change asks for: d/dt (v' M v / 2) = v' (M a + ...) whatever a.
        let (q, v) = ([0.7, 0.2], [1.3, -0.9]);
        let kinetic = |q: [f64; 2], out: &mut Equations| {
            tree.at(&q, &v, out);
            (0..2).map(|i| (0..2).map(|j| 0.5 * v[i] * out.mass[(i, j)] * v[j]).sum::<f64>()).sum::<f64>()
        };
        let e = 1e-5;
        let ahead = kinetic([q[0] + e * v[0], q[1] + e * v[1]], &mut out);
        let back = kinetic([q[0] - e * v[0], q[1] - e * v[1]], &mut out);
        let rate = (ahead - back) / (2.0 * e);
        tree.at(&q, &[0.0; 2], &mut out);
        let gravity: f64 = out.bias.iter().zip(&v).map(|(b, v)| b * v).sum();
        tree.at(&q, &v, &mut out);
        let power: f64 = out.bias.iter().zip(&v).map(|(b, v)| b * v).sum();
        assert!((power - gravity - rate).abs() < 1e-8 * power.abs(), "{} {rate}", power - gravity);
    }
}
