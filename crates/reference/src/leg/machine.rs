//! The motion of bodies and rotors: one linear system for all accelerations, with what the load cells show.

use super::bodies::{Body, Mass, Row, along, dot, motion};
use super::ground::{Bristles, CORNERS};
use super::setup::{LegReference, MOST_ACTUATORS};
use super::solve::{Factor, MOST};
use nalgebra::{Isometry3, Matrix3, Vector3};
use sealegs_leg::robot::{Drive, HoekensMount};

/// Step of the difference that gives a linkage's second derivative, rad.
const SLOPE_STEP_RAD: f64 = 1e-5;

/// Positions and speeds of bodies (the carriage first, then joints) and of screws, and the sole's bristles.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    pub x: [f64; MOST],
    pub v: [f64; MOST],
    pub bristles: Bristles,
}

/// What an actuator's load cells need beside the accelerations.
#[derive(Clone, Copy, Default)]
struct Cells {
    spring: f64,
    sprung: f64,
    /// Acceleration of what carries the sprung mass along the axis, per acceleration of the bodies, and the rest of it
    /// less gravity.
    carrier: Row,
    felt: f64,
    /// Force of the compliance between screw and link 2, if there is one.
    series: Option<f64>,
}

/// All accelerations as far as they follow from smooth forces, and how dry friction changes them.
pub(super) struct System {
    factor: Factor,
    /// Accelerations without dry friction.
    pub smooth: [f64; MOST],
    cells: [Cells; MOST_ACTUATORS],
    bodies: usize,
    /// Sum of the ground's normal forces, N.
    pub ground: f64,
    /// How fast bristles are drawn.
    pub drawing: Bristles,
}

impl System {
    /// Accelerations per unit of a force on a coordinate.
    pub fn mobility(&self, coordinate: usize) -> [f64; MOST] {
        let mut unit = [0.0; MOST];
        unit[coordinate] = 1.0;
        self.factor.solve(unit)
    }

    /// Forces of the load cells on link 1 and link 2 at given accelerations, N.
    pub fn forces(&self, actuator: usize, acceleration: &[f64; MOST]) -> [f64; 2] {
        let c = &self.cells[actuator];
        if let Some(force) = c.series {
            return [c.spring, force];
        }
        let carried = dot(&c.carrier, &acceleration[..self.bodies]) + c.felt;
        [c.spring, c.spring + c.sprung * (acceleration[self.bodies + actuator] - carried)]
    }
}

/// The lever of a linkage: length (m), moment arm (m/rad) and its slope (m/rad^2) over the joint's angle.
fn crank(mount: &HoekensMount, q: f64) -> [f64; 3] {
    let angle = |q: f64| mount.crank_angle_at_zero_rad + mount.sign * q;
    // Not a number where the bars do not reach: the run then ends with that.
    let arm = |q: f64| mount.sign * mount.linkage.moment_arm_m(angle(q)).unwrap_or(f64::NAN);
    let travel = mount.linkage.travel_m(angle(q)).unwrap_or(f64::NAN);
    let slope = (arm(q + SLOPE_STEP_RAD) - arm(q - SLOPE_STEP_RAD)) / (2.0 * SLOPE_STEP_RAD);
    [mount.length_mid_m + travel, arm(q), slope]
}

/// Poses and motions of the links.
type Links = (Vec<Isometry3<f64>>, Vec<Body>);

/// Mass matrix and smooth forces: `a q'' = f` for bodies and screws.
struct Equations {
    a: [[f64; MOST]; MOST],
    f: [f64; MOST],
}

/// A run's leg: the unloaded lengths are those of its start.
pub(super) struct Machine<'a> {
    pub of: &'a LegReference,
    /// Length at which each spring is unloaded with its screw at 0, m.
    pub rest: Vec<f64>,
}

impl Machine<'_> {
    /// Poses and motions of the links.
    pub fn motion(&self, s: &State) -> Links {
        let (of, n) = (self.of, self.of.bodies);
        motion(&of.robot, of.rail, of.base_height, &s.x[..n], &s.v[..n])
    }

    /// The system at a state, with these currents (A) in the motors.
    pub fn system(&self, s: &State, currents: &[f64]) -> System {
        let (of, n) = (self.of, self.of.bodies);
        let links = self.motion(s);
        let (poses, bodies) = &links;
        let mut to = Equations { a: [[0.0; MOST]; MOST], f: [0.0; MOST] };
        for (i, link) in of.robot.links.iter().enumerate() {
            if let Some(own) = &link.inertial {
                let r = poses[i].rotation.to_rotation_matrix();
                let inertia = r * own.inertia * r.transpose();
                let mass = Mass { mass_kg: own.mass_kg, at: poses[i] * own.com, inertia };
                mass.add_to(&bodies[i], &of.gravity, n, &mut to.a, &mut to.f);
            }
        }
        if of.rail {
            to.a[0][0] += of.carriage_kg;
            to.f[0] += of.carriage_kg * of.gravity.z;
        }
        self.joints(s, &mut to.f);
        let mut cells = [Cells::default(); MOST_ACTUATORS];
        for i in 0..of.parts.len() {
            let motor = of.parts[i].force_per_command * currents[i];
            cells[i] = match of.drive(i) {
                Drive::Hoekens(mount) => self.crank(i, mount, s, motor, &links, &mut to),
                _ => self.rod(i, s, motor, &links, &mut to),
            };
        }
        let (mut total, mut drawing) = (0.0, [[0.0; 2]; CORNERS]);
        if let Some(ground) = &of.ground {
            for touch in ground.touches(poses, bodies, &s.bristles) {
                total += touch.normal;
                drawing[touch.corner] = touch.drawing();
                let pushed = along(&touch.force(), &touch.point.by);
                (0..n).for_each(|k| to.f[k] += pushed[k]);
            }
        }
        let factor = Factor::of(to.a, of.count);
        let smooth = factor.solve(to.f);
        System { factor, smooth, cells, bodies: n, ground: total, drawing }
    }

    /// Stops and viscous losses of the joints.
    fn joints(&self, s: &State, f: &mut [f64; MOST]) {
        let stops = &self.of.scenario.stops;
        for (dof, joint) in self.of.robot.moving_joints().enumerate() {
            let k = usize::from(self.of.rail) + dof;
            f[k] -= joint.damping * s.v[k];
            let past = s.x[k] - s.x[k].clamp(joint.limits.lower, joint.limits.upper);
            let push = -stops.stiffness_nm_rad * past - stops.damping_nm_s_rad * s.v[k];
            if past > 0.0 {
                f[k] += push.min(0.0);
            } else if past < 0.0 {
                f[k] += push.max(0.0);
            }
        }
    }

    /// Adds a rod between two points, its sprung mass at the screw side's.
    fn rod(&self, i: usize, s: &State, motor: f64, links: &Links, to: &mut Equations) -> Cells {
        let (poses, bodies) = links;
        let (of, n, row) = (self.of, self.of.bodies, self.of.bodies + i);
        let (part, placement) = (&of.parts[i], &of.robot.actuators[i]);
        let Drive::Linear { point_1, point_2 } = &placement.drive else { return Cells::default() };
        let (p1, p2) = (poses[placement.link_1] * point_1, poses[placement.link_2] * point_2);
        let mass = Mass { mass_kg: part.sprung, at: p2, inertia: Matrix3::zeros() };
        mass.add_to(&bodies[placement.link_2], &of.gravity, n, &mut to.a, &mut to.f);
        let length = (p2 - p1).norm();
        let u = (p2 - p1) / length;
        let (end_1, end_2) = (bodies[placement.link_1].at(&p1), bodies[placement.link_2].at(&p2));
        let (along_1, along_2) = (along(&u, &end_1.by), along(&u, &end_2.by));
        let rate = u.dot(&(end_2.velocity - end_1.velocity));
        let spring = self.spring(i, s, length, rate);
        for k in 0..n {
            to.f[k] += spring * (along_2[k] - along_1[k]);
            to.a[k][row] -= part.sprung * along_2[k];
            to.a[row][k] -= part.sprung * along_2[k];
        }
        let felt = u.dot(&(end_2.bias - of.gravity));
        let series = self.screw_end(i, s, spring, &along_2, felt, to);
        to.a[row][row] += part.rotor + part.sprung;
        to.f[row] += part.on_screw(motor, s.x[row], s.v[row]) - spring + part.sprung * felt;
        Cells { spring, sprung: part.sprung, carrier: along_2, felt, series }
    }

    /// The spring's force at the actuator's length (m) and its rate (m/s), N.
    fn spring(&self, i: usize, s: &State, length: f64, rate: f64) -> f64 {
        let row = self.of.bodies + i;
        let (end, end_rate) = self.of.screw_end(i).map_or((0.0, 0.0), |e| (s.x[e], s.v[e]));
        let deflection = s.x[row] - end - (length - self.rest[i]);
        self.of.parts[i].spring_force(deflection, s.v[row] - end_rate - rate)
    }

    /// Adds the row of a screw's end on its compliance, with the unsprung mass, which a leg has in its link 2; returns
    /// the compliance's force: `(m_p + m_u) (s'' + carrier + felt) - m_p y'' = spring - k s`.
    fn screw_end(
        &self,
        i: usize,
        s: &State,
        spring: f64,
        carrier: &Row,
        felt: f64,
        to: &mut Equations,
    ) -> Option<f64> {
        let (part, row, end) = (&self.of.parts[i], self.of.bodies + i, self.of.screw_end(i)?);
        let [stiffness, unsprung] = part.series?;
        let force = stiffness * s.x[end];
        let moving = part.sprung + unsprung;
        to.a[end][end] += moving;
        to.a[end][row] -= part.sprung;
        to.a[row][end] -= part.sprung;
        for k in 0..self.of.bodies {
            to.a[end][k] += moving * carrier[k];
            to.a[k][end] += moving * carrier[k];
        }
        to.f[end] += spring - force - moving * felt;
        Some(force)
    }

    /// Adds an actuator that turns a joint through a linkage, its sprung mass at the mount:
    /// `F_bs = spring + m_p (y'' - arm q'' - turning - u.a_1)` on rotor, joint and mount.
    fn crank(
        &self,
        i: usize,
        mount: &HoekensMount,
        s: &State,
        motor: f64,
        links: &Links,
        to: &mut Equations,
    ) -> Cells {
        let (poses, bodies) = links;
        let (of, n, row) = (self.of, self.of.bodies, self.of.bodies + i);
        let (part, placement) = (&of.parts[i], &of.robot.actuators[i]);
        let column = usize::from(of.rail) + of.robot.joints[mount.joint].dof.unwrap_or(0);
        let [length, arm, slope] = crank(mount, s.x[column]);
        let turning = slope * s.v[column].powi(2);
        let p1 = poses[placement.link_1] * mount.point_1;
        let mass = Mass { mass_kg: part.sprung, at: p1, inertia: Matrix3::zeros() };
        mass.add_to(&bodies[placement.link_1], &of.gravity, n, &mut to.a, &mut to.f);
        let u: Vector3<f64> = poses[placement.link_1].rotation * mount.axis_1.into_inner();
        let end_1 = bodies[placement.link_1].at(&p1);
        let along_1 = along(&u, &end_1.by);
        let rate = arm * s.v[column];
        let spring = self.spring(i, s, length, rate);
        let felt = u.dot(&(end_1.bias - of.gravity));
        let m = part.sprung;
        let known = spring - m * (turning + felt);
        to.f[row] += part.on_screw(motor, s.x[row], s.v[row]) - known;
        to.a[row][row] += part.rotor + m;
        to.f[column] += arm * known;
        to.a[column][row] -= arm * m;
        for k in 0..n {
            let carried = along_1[k] + if k == column { arm } else { 0.0 };
            to.a[row][k] -= m * carried;
            to.a[column][k] += arm * m * carried;
            // The reaction m (y'' - arm q'' - turning) along the axis, at the mount.
            to.f[k] -= m * turning * along_1[k];
            to.a[k][row] -= m * along_1[k];
            to.a[k][column] += m * arm * along_1[k];
        }
        let mut carrier = along_1;
        carrier[column] += arm;
        let felt = felt + turning;
        let series = self.screw_end(i, s, spring, &carrier, felt, to);
        Cells { spring, sprung: m, carrier, felt, series }
    }

    /// Length, its rate, and moment arms of each actuator over the bodies' coordinates, at the state.
    pub fn lengths(&self, s: &State) -> Vec<(f64, f64)> {
        let of = self.of;
        let (poses, bodies) = self.motion(s);
        let of_actuator = |i: usize| match of.drive(i) {
            Drive::Hoekens(mount) => {
                let column = usize::from(of.rail) + of.robot.joints[mount.joint].dof.unwrap_or(0);
                let [length, arm, _] = crank(mount, s.x[column]);
                (length, arm * s.v[column])
            }
            Drive::Linear { point_1, point_2 } => {
                let placement = &of.robot.actuators[i];
                let (p1, p2) = (poses[placement.link_1] * point_1, poses[placement.link_2] * point_2);
                let (end_1, end_2) = (bodies[placement.link_1].at(&p1), bodies[placement.link_2].at(&p2));
                let between = p2 - p1;
                (between.norm(), between.normalize().dot(&(end_2.velocity - end_1.velocity)))
            }
            Drive::RigidPosition { .. } => (f64::NAN, f64::NAN),
        };
        (0..of.parts.len()).map(of_actuator).collect()
    }
}
