//! Where the bodies are and how they move: poses, Jacobians and the accelerations that are left where none is given.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use sealegs_leg::robot::Robot;

/// Most coordinates of the bodies: joints, and the carriage on its rail.
pub(super) const MOST_JOINTS: usize = 8;

/// One number per coordinate of the bodies.
pub(super) type Row = [f64; MOST_JOINTS];

/// A vector per coordinate: a column each of a Jacobian.
pub(super) type Jacobian = [Vector3<f64>; MOST_JOINTS];

/// How a link moves, in the world's frame. Accelerations are those at zero second derivatives of the coordinates.
pub(super) struct Body {
    velocity_by: Jacobian,
    turning_by: Jacobian,
    origin: Point3<f64>,
    /// Angular velocity, rad/s.
    pub turning: Vector3<f64>,
    /// Angular acceleration, rad/s^2.
    pub turning_bias: Vector3<f64>,
    velocity: Vector3<f64>,
    bias: Vector3<f64>,
}

/// A point of a body: its Jacobian, velocity (m/s) and acceleration at zero second derivatives (m/s^2).
pub(super) struct Moving {
    pub by: Jacobian,
    pub velocity: Vector3<f64>,
    pub bias: Vector3<f64>,
}

impl Body {
    /// A point in the world that moves with this body.
    pub fn at(&self, p: &Point3<f64>) -> Moving {
        let r = p - self.origin;
        Moving {
            by: std::array::from_fn(|c| self.velocity_by[c] + self.turning_by[c].cross(&r)),
            velocity: self.velocity + self.turning.cross(&r),
            bias: self.bias + self.turning_bias.cross(&r) + self.turning.cross(&self.turning.cross(&r)),
        }
    }
}

/// A vector's component along each column.
pub(super) fn along(u: &Vector3<f64>, by: &Jacobian) -> Row {
    std::array::from_fn(|c| u.dot(&by[c]))
}

pub(super) fn dot(a: &Row, b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The poses `world_from_link` and motions of all links, the base at a height (m) and moving up at a speed (m/s) if
/// it is on a rail, whose coordinate is then the first. `q` and `v` are the coordinates of all bodies and their speeds.
pub(super) fn motion(
    robot: &Robot,
    rail: bool,
    base_height: f64,
    q: &[f64],
    v: &[f64],
) -> (Vec<Isometry3<f64>>, Vec<Body>) {
    let first = usize::from(rail);
    let height = base_height + if rail { q[0] } else { 0.0 };
    let poses = robot.posture(&Isometry3::translation(0.0, 0.0, height), &q[first..]).world_from_link;
    let none = [Vector3::zeros(); MOST_JOINTS];
    let mut base = Body {
        velocity_by: none,
        turning_by: none,
        origin: Point3::from(poses[0].translation.vector),
        turning: Vector3::zeros(),
        turning_bias: Vector3::zeros(),
        velocity: Vector3::zeros(),
        bias: Vector3::zeros(),
    };
    if rail {
        base.velocity_by[0] = Vector3::z();
        base.velocity = Vector3::z() * v[0];
    }
    let mut all = vec![base];
    for joint in &robot.joints {
        let parent = &all[joint.parent];
        let origin = Point3::from(poses[joint.child].translation.vector);
        let Moving { by, velocity, bias } = parent.at(&origin);
        let mut body = Body {
            velocity_by: by,
            turning_by: parent.turning_by,
            origin,
            turning: parent.turning,
            turning_bias: parent.turning_bias,
            velocity,
            bias,
        };
        if let Some(dof) = joint.dof {
            let c = first + dof;
            let axis = poses[joint.child].rotation * joint.axis.into_inner();
            body.turning_by[c] += axis;
            body.turning_bias += body.turning.cross(&axis) * v[c];
            body.turning += axis * v[c];
        }
        all.push(body);
    }
    (poses, all)
}

/// A mass in motion: what it adds to the mass matrix `a` and to the forces `f` of the bodies' coordinates, in gravity.
pub(super) struct Mass {
    /// kg.
    pub mass_kg: f64,
    /// In the world.
    pub at: Point3<f64>,
    /// About its centre along the world's axes, kg m^2.
    pub inertia: Matrix3<f64>,
}

impl Mass {
    /// Adds it as a part of a body.
    pub fn add_to<const N: usize>(
        &self,
        body: &Body,
        gravity: &Vector3<f64>,
        count: usize,
        a: &mut [[f64; N]; N],
        f: &mut [f64; N],
    ) {
        let Moving { by, bias, .. } = body.at(&self.at);
        let force = (gravity - bias) * self.mass_kg;
        let turning = &body.turning_by;
        let spin = self.inertia * body.turning;
        let torque = -(self.inertia * body.turning_bias + body.turning.cross(&spin));
        for i in 0..count {
            f[i] += force.dot(&by[i]) + torque.dot(&turning[i]);
            let (push, twist) = (by[i] * self.mass_kg, self.inertia * turning[i]);
            for j in 0..count {
                a[i][j] += push.dot(&by[j]) + twist.dot(&turning[j]);
            }
        }
    }
}
