//! A tree of bodies in its joints' coordinates: poses, Jacobians, mass matrix and bias forces.
//!
//! Where no loop is closed the joints' coordinates are all there is, and a search that simulates thousands of runs needs
//! nothing more.

use super::tree::Tree;
use crate::robot::{Inertial, Robot};
use nalgebra::{Cholesky, DMatrix, Dyn, Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};

/// Gravitational acceleration on a bench, m/s^2.
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

/// The moving bodies of a robot, parents first: body `i` moves by coordinate `i`.
#[derive(Debug, Clone)]
pub(crate) struct MovingBodies {
    bodies: Vec<Body>,
    /// `world_from_base`, of the base or of where the rail's carriage was built.
    base: Isometry3<f64>,
    /// Gravitational acceleration along -z of the world, m/s^2.
    gravity: f64,
}

/// What the equations of motion are at a state: `mass q'' = force - bias`.
#[derive(Debug, Clone)]
pub(crate) struct Equations {
    /// Mass matrix, kg m^2 (kg for a sliding joint).
    pub mass: DMatrix<f64>,
    /// Gravity, Coriolis and centrifugal torques, N m (N).
    pub bias: Vec<f64>,
    /// World quantities of every body, kept between calls.
    at: Vec<At>,
    /// By coordinate, kept between calls.
    beyond: Vec<Beyond>,
    /// Coordinates that move a body, from its own to the base's, with the velocity of its centre of mass and its turning per
    /// unit of their speeds, world frame.
    columns: Vec<Vec<Column>>,
}

/// A coordinate with the velocity of a centre of mass and the turning per unit of its speed.
pub(crate) type Column = (usize, Vector3<f64>, Vector3<f64>);

/// The bodies that a coordinate moves, as one, and what it takes that none of them accelerates: all about the world's origin, where
/// they add up.
#[derive(Debug, Clone, Default)]
struct Beyond {
    mass_kg: f64,
    /// Mass times the centre of mass, kg m.
    moment: Vector3<f64>,
    inertia: Matrix3<f64>,
    force: Vector3<f64>,
    torque: Vector3<f64>,
}

/// A body in the world.
#[derive(Debug, Clone, Default)]
struct At {
    pose: Isometry3<f64>,
    axis: Vector3<f64>,
    /// Its turning per unit of its coordinate's speed, and the velocity of its point that is at the world's origin.
    turns: Vector3<f64>,
    at_origin: Vector3<f64>,
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

impl MovingBodies {
    /// The moving bodies of a robot on a fixed base at the world's origin. Mass that hangs on the base by fixed joints does not
    /// move; links on fixed joints are part of the body that carries them.
    pub fn of(robot: &Robot) -> Self {
        Self::new(&Tree::new(robot), None, &Isometry3::identity(), GRAVITY_M_S2)
    }

    /// The bodies of a tree that its joints move, with its base at `world_from_base`. On a rail, whose vertical position is
    /// the first coordinate then, the base has the mass properties `on_rail`; else it does not move.
    pub fn new(
        tree: &Tree,
        on_rail: Option<&Inertial>,
        world_from_base: &Isometry3<f64>,
        gravity: f64,
    ) -> Self {
        let upright = Unit::new_unchecked(world_from_base.rotation.inverse() * Vector3::z());
        let carriage = on_rail.map(|base| Body::new(None, Isometry3::identity(), upright, true, Some(base)));
        let rail = usize::from(carriage.is_some());
        let joints = tree.bodies.iter().filter_map(|body| Some((body.joint.as_ref()?, body)));
        let moving = joints.map(|(joint, body)| {
            let parent = (joint.parent + rail).checked_sub(1);
            Body::new(parent, joint.origin, joint.axis, joint.slides, body.inertial.as_ref())
        });
        Self { bodies: carriage.into_iter().chain(moving).collect(), base: *world_from_base, gravity }
    }

    /// Mass of body `i`, kg.
    pub fn mass_kg(&self, i: usize) -> f64 {
        self.bodies[i].mass_kg
    }

    /// `world_from_base`.
    pub fn base(&self) -> &Isometry3<f64> {
        &self.base
    }

    /// Number of coordinates.
    pub fn len(&self) -> usize {
        self.bodies.len()
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

    /// Puts another mass, centre of mass and other moments about it into body `i`.
    pub fn set_inertial(&mut self, i: usize, inertial: &Inertial) {
        let body = &mut self.bodies[i];
        (body.mass_kg, body.com, body.inertia) = (inertial.mass_kg, inertial.com.coords, inertial.inertia);
    }

    /// Multiplies mass, centre of mass and the moments about it of body `i`.
    pub fn scale(&mut self, i: usize, mass: f64, com: f64, moments: f64) {
        let body = &mut self.bodies[i];
        body.mass_kg *= mass;
        body.com *= com;
        body.inertia *= moments;
    }

    /// The bodies in groups that do not move one another, each in their order: of what stands on the base.
    pub fn parts(&self) -> Vec<Vec<usize>> {
        let mut parts: Vec<Vec<usize>> = Vec::new();
        for (i, body) in self.bodies.iter().enumerate() {
            match body.parent.and_then(|parent| parts.iter_mut().find(|part| part.contains(&parent))) {
                Some(part) => part.push(i),
                None => parts.push(vec![i]),
            }
        }
        parts
    }

    /// One of the [`parts`](Self::parts) by itself.
    pub fn part(&self, bodies: &[usize]) -> Self {
        let own = |i: usize| bodies.iter().position(|body| *body == i);
        let body =
            |i: &usize| Body { parent: self.bodies[*i].parent.and_then(own), ..self.bodies[*i].clone() };
        Self { bodies: bodies.iter().map(body).collect(), base: self.base, gravity: self.gravity }
    }

    /// Room for the equations.
    pub fn equations(&self) -> Equations {
        let n = self.bodies.len();
        let columns = (0..n).map(|k| {
            let way = std::iter::successors(Some(k), |&i| self.bodies[i].parent);
            way.map(|i| (i, Vector3::zeros(), Vector3::zeros())).collect()
        });
        Equations {
            mass: DMatrix::zeros(n, n),
            bias: vec![0.0; n],
            at: vec![At::default(); n],
            beyond: vec![Beyond::default(); n],
            columns: columns.collect(),
        }
    }

    /// Writes the equations of motion at joint positions `q` and speeds `v`.
    pub fn at(&self, q: &[f64], v: &[f64], out: &mut Equations) {
        self.place(q, out);
        self.set_in_motion(v, out);
    }

    /// Writes where the bodies are.
    pub fn place(&self, q: &[f64], out: &mut Equations) {
        for i in 0..self.bodies.len() {
            let body = &self.bodies[i];
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
            let parent = body.parent.map_or(self.base, |p| out.at[p].pose);
            let here = &mut out.at[i];
            here.pose = parent * body.origin * moved;
            here.axis = here.pose.rotation * body.axis.into_inner();
            here.joint = here.pose.translation.vector;
            (here.turns, here.at_origin) = if body.slides {
                (Vector3::zeros(), here.axis)
            } else {
                (here.axis, here.joint.cross(&here.axis))
            };
            let turn = here.pose.rotation.to_rotation_matrix();
            here.com = here.joint + turn * body.com;
            here.inertia = turn * body.inertia * turn.transpose();
        }
    }

    /// Writes how each coordinate moves the bodies, which were placed (see [`Equations::columns`]).
    pub fn write_columns(&self, out: &mut Equations) {
        for (columns, own) in out.columns.iter_mut().zip(&out.at) {
            for (joint, linear, turning) in columns {
                let at = &out.at[*joint];
                (*linear, *turning) = (at.at_origin + at.turns.cross(&own.com), at.turns);
            }
        }
    }

    /// Writes the equations of motion of bodies that were placed, at speeds `v`: the composite-rigid-body algorithm (R. Featherstone
    /// 2008, Rigid Body Dynamics Algorithms, section 6.2), and the inward half of the recursive Newton-Euler algorithm.
    pub fn set_in_motion(&self, v: &[f64], out: &mut Equations) {
        self.accelerate(v, &mut out.at);
        for ((beyond, at), body) in out.beyond.iter_mut().zip(&out.at).zip(&self.bodies) {
            let (mass_kg, com) = (body.mass_kg, &at.com);
            let moment = com * mass_kg;
            let around = Matrix3::from_diagonal_element(com.dot(&moment)) - moment * com.transpose();
            let (force, torque) = (at.force, at.torque + com.cross(&at.force));
            *beyond = Beyond { mass_kg, moment, inertia: at.inertia + around, force, torque };
        }
        for i in (0..self.bodies.len()).rev() {
            let (at, beyond) = (&out.at[i], &out.beyond[i]);
            out.bias[i] = at.turns.dot(&beyond.torque) + at.at_origin.dot(&beyond.force);
            let momentum = at.at_origin * beyond.mass_kg + at.turns.cross(&beyond.moment);
            let turning = beyond.inertia * at.turns + beyond.moment.cross(&at.at_origin);
            for j in std::iter::successors(Some(i), |&j| self.bodies[j].parent) {
                let m = out.at[j].turns.dot(&turning) + out.at[j].at_origin.dot(&momentum);
                (out.mass[(i, j)], out.mass[(j, i)]) = (m, m);
            }
            if let Some(parent) = self.bodies[i].parent {
                let (inner, outer) = out.beyond.split_at_mut(i);
                inner[parent].add(&outer[0]);
            }
        }
    }

    /// Velocities and the accelerations that remain with the joints' own taken as zero: the outward half of the recursive
    /// Newton-Euler algorithm (R. Featherstone 2008, Rigid Body Dynamics Algorithms, section 5.3).
    fn accelerate(&self, v: &[f64], at: &mut [At]) {
        let base = At {
            joint: self.base.translation.vector,
            acceleration: Vector3::z() * self.gravity,
            ..At::default()
        };
        for (i, body) in self.bodies.iter().enumerate() {
            let (done, rest) = at.split_at_mut(i);
            let parent = body.parent.map_or(&base, |p| &done[p]);
            let here = &mut rest[0];
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

/// Solves with the Cholesky factor of a matrix, which is used up and keeps its memory; whether the matrix is positive definite, as
/// that of bodies with mass is.
pub(crate) fn solve_with(matrix: &mut DMatrix<f64>, solve: impl FnOnce(&Cholesky<f64, Dyn>)) -> bool {
    let Some(factor) = Cholesky::new(std::mem::take(matrix)) else { return false };
    solve(&factor);
    *matrix = factor.unpack_dirty();
    true
}

impl Equations {
    /// `world_from_body`.
    pub fn pose(&self, body: usize) -> &Isometry3<f64> {
        &self.at[body].pose
    }

    /// Centre of mass of a body, world, m.
    pub fn com(&self, body: usize) -> &Vector3<f64> {
        &self.at[body].com
    }

    /// The coordinates that move a body, and how, as [`MovingBodies::write_columns`] left them.
    pub fn columns(&self, body: usize) -> &[Column] {
        &self.columns[body]
    }
}

impl Beyond {
    fn add(&mut self, other: &Self) {
        self.mass_kg += other.mass_kg;
        self.moment += other.moment;
        self.inertia += other.inertia;
        self.force += other.force;
        self.torque += other.torque;
    }
}

impl Body {
    fn new(
        parent: Option<usize>,
        origin: Isometry3<f64>,
        axis: Unit<Vector3<f64>>,
        slides: bool,
        inertial: Option<&Inertial>,
    ) -> Self {
        Self {
            parent,
            origin,
            axis,
            slides,
            mass_kg: inertial.map_or(0.0, |i| i.mass_kg),
            com: inertial.map_or_else(Vector3::zeros, |i| i.com.coords),
            inertia: inertial.map_or_else(Matrix3::zeros, |i| i.inertia),
        }
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
        let tree = MovingBodies::of(&Robot::from_urdf(URDF, "two.urdf", None).expect("good"));
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
        let tree = MovingBodies::of(&Robot::from_urdf(&urdf, "rail.urdf", None).expect("good"));
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
