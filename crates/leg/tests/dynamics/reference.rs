//! Truth from elsewhere: the THOR leg's equations of motion written down again without the engine, in one
//! linear system for joints and rotors together, integrated by RK4 at a much finer step.
//!
//! Same physical limit as the coupling (sprung mass at the screw side of a rod and at the mount of a linkage,
//! Hunt-Crossley contact with bristles), nothing else in common: no lag, no armature, no leapfrog.

use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Point3, Vector3};
use sealegs_leg::robot::{Drive, Geometry, Robot};
use sealegs_leg::scenario::{BaseSpec, Scenario};

const G: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// The leg as the reference sees it.
pub struct Reference {
    robot: Robot,
    carriage_kg: f64,
    rail: bool,
    rest: Vec<f64>,
    start_z: f64,
    currents: Vec<f64>,
    sole: Vec<Point3<f64>>,
    ground: Option<sealegs_leg::scenario::GroundSpec>,
    n: usize,
    m: usize,
}

/// Positions and speeds; `z` is the carriage's height, `bristles` belong to the sole points.
#[derive(Clone)]
pub struct State {
    pub x: DVector<f64>,
}

/// What the reference says of one instant.
#[derive(Default, Clone)]
pub struct Instant {
    pub force_1: Vec<f64>,
    pub force_2: Vec<f64>,
    pub ground: f64,
    pub q: Vec<f64>,
}

struct BodyKinematics {
    jacobian_v: DMatrix<f64>,
    jacobian_w: DMatrix<f64>,
    origin: Point3<f64>,
    w: Vector3<f64>,
    alpha: Vector3<f64>,
    acceleration: Vector3<f64>,
    velocity: Vector3<f64>,
}

impl BodyKinematics {
    fn at(&self, p: &Point3<f64>) -> (DMatrix<f64>, Vector3<f64>, Vector3<f64>) {
        let r = p - self.origin;
        let mut j = self.jacobian_v.clone();
        for c in 0..j.ncols() {
            let w = Vector3::new(self.jacobian_w[(0, c)], self.jacobian_w[(1, c)], self.jacobian_w[(2, c)]);
            let add = w.cross(&r);
            for i in 0..3 {
                j[(i, c)] += add[i];
            }
        }
        let v = self.velocity + self.w.cross(&r);
        let a = self.acceleration + self.alpha.cross(&r) + self.w.cross(&self.w.cross(&r));
        (j, v, a)
    }
}

fn dot(u: &Vector3<f64>, j: &DMatrix<f64>) -> DVector<f64> {
    DVector::from_fn(j.ncols(), |c, _| u.x * j[(0, c)] + u.y * j[(1, c)] + u.z * j[(2, c)])
}

impl Reference {
    /// The scenario's leg with constant currents (A).
    pub fn new(scenario: &Scenario, robot: Robot, currents: Vec<f64>) -> (Self, State) {
        let rail = matches!(scenario.base, BaseSpec::Rail { .. });
        let carriage_kg = match scenario.base {
            BaseSpec::Rail { carriage_mass_kg } => carriage_mass_kg,
            BaseSpec::Fixed { .. } => 0.0,
        };
        let q: Vec<f64> = robot
            .moving_joints()
            .map(|j| scenario.start.posture_rad.get(&j.name).copied().unwrap_or(0.0))
            .collect();
        let foot = robot.links.len() - 1;
        let shape = &robot.links[foot].collisions[0];
        let Geometry::Box { half: [hx, hy, hz] } = shape.geometry else { panic!("a box foot") };
        let sole: Vec<Point3<f64>> = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
            .map(|(x, y)| shape.origin * Point3::new(x * hx, y * hy, -hz))
            .to_vec();
        let posture = robot.posture(&Isometry3::identity(), &q);
        let lowest = sole.iter().map(|p| posture.point(foot, p).z).fold(f64::INFINITY, f64::min);
        let start_z = match scenario.base {
            BaseSpec::Rail { .. } => scenario.start.drop_height_m - lowest,
            BaseSpec::Fixed { height_m } => height_m,
        };
        let rest =
            (0..robot.actuators.len()).map(|i| robot.lever(i, &q).expect("in range").length_m).collect();
        let (n, m) = (robot.dofs + usize::from(rail), robot.actuators.len());
        let reference =
            Self { carriage_kg, rail, rest, start_z, currents, sole, ground: scenario.ground, n, m, robot };
        let mut x = DVector::zeros(2 * (n + m) + 12);
        for (i, q) in q.iter().enumerate() {
            x[usize::from(rail) + i] = *q;
        }
        (reference, State { x })
    }

    fn kinematics(&self, x: &DVector<f64>) -> (Vec<Isometry3<f64>>, Vec<BodyKinematics>, Vec<f64>) {
        let (n, m, first) = (self.n, self.m, usize::from(self.rail));
        let z = self.start_z + if self.rail { x[0] } else { 0.0 };
        let q: Vec<f64> = (0..self.robot.dofs).map(|i| x[first + i]).collect();
        let speed = |i: usize| x[n + m + i];
        let poses = self.robot.posture(&Isometry3::translation(0.0, 0.0, z), &q).world_from_link;
        let mut all = Vec::new();
        let mut base = BodyKinematics {
            jacobian_v: DMatrix::zeros(3, n),
            jacobian_w: DMatrix::zeros(3, n),
            origin: Point3::from(poses[0].translation.vector),
            w: Vector3::zeros(),
            alpha: Vector3::zeros(),
            acceleration: Vector3::zeros(),
            velocity: Vector3::zeros(),
        };
        if self.rail {
            base.jacobian_v[(2, 0)] = 1.0;
            base.velocity.z = speed(0);
        }
        all.push(base);
        for joint in &self.robot.joints {
            let parent: &BodyKinematics = &all[joint.parent];
            let origin = Point3::from(poses[joint.child].translation.vector);
            let (jacobian_v, velocity, acceleration) = parent.at(&origin);
            let (mut jacobian_w, mut w, mut alpha) = (parent.jacobian_w.clone(), parent.w, parent.alpha);
            if let Some(dof) = joint.dof {
                let axis = poses[joint.child].rotation * joint.axis.into_inner();
                let c = first + dof;
                for i in 0..3 {
                    jacobian_w[(i, c)] += axis[i];
                }
                alpha += w.cross(&axis) * speed(c);
                w += axis * speed(c);
            }
            all.push(BodyKinematics { jacobian_v, jacobian_w, origin, w, alpha, acceleration, velocity });
        }
        (poses, all, q)
    }

    /// Derivative of the state, and what belongs to the instant.
    fn derivative(&self, x: &DVector<f64>) -> (DVector<f64>, Instant) {
        let (n, m) = (self.n, self.m);
        let (poses, bodies, q) = self.kinematics(x);
        let mut a = DMatrix::<f64>::zeros(n + m, n + m);
        let mut f = DVector::<f64>::zeros(n + m);
        let add_mass = |a: &mut DMatrix<f64>,
                        f: &mut DVector<f64>,
                        link: usize,
                        mass: f64,
                        at: Point3<f64>,
                        inertia: Matrix3<f64>| {
            let b = &bodies[link];
            let (j, _, bias) = b.at(&at);
            let jw = &b.jacobian_w;
            let inertia_d = DMatrix::from_fn(3, 3, |r, c| inertia[(r, c)]);
            let mm = j.transpose() * &j * mass + jw.transpose() * inertia_d * jw;
            let mut block = a.view_mut((0, 0), (n, n));
            block += mm;
            let force = (G - bias) * mass;
            let torque = -(inertia * b.alpha + b.w.cross(&(inertia * b.w)));
            let mut rows = f.rows_mut(0, n);
            rows += dot(&force, &j) + dot(&torque, jw);
        };
        for (i, link) in self.robot.links.iter().enumerate() {
            if let Some(inertial) = &link.inertial {
                let r = poses[i].rotation.to_rotation_matrix();
                let inertia = r * inertial.inertia * r.transpose();
                add_mass(&mut a, &mut f, i, inertial.mass_kg, poses[i] * inertial.com, inertia);
            }
        }
        if self.rail {
            a[(0, 0)] += self.carriage_kg;
            f[0] += self.carriage_kg * G.z;
        }
        let mut instant = Instant { q: q.clone(), ..Instant::default() };
        // Per actuator: spring force, sprung mass, attachment acceleration = row . q'' + bias, for the cells.
        let mut cells = Vec::new();
        for (i, placement) in self.robot.actuators.iter().enumerate() {
            let c = placement.spec.as_ref().expect("sprung").coefficients();
            let (y, y_speed, row) = (x[n + i], x[2 * n + m + i], n + i);
            let motor = c.force_constant * self.currents[i];
            let mp = c.sprung_mass;
            match &placement.drive {
                Drive::Linear { point_1, point_2 } => {
                    let p1 = poses[placement.link_1] * point_1;
                    let p2 = poses[placement.link_2] * point_2;
                    add_mass(&mut a, &mut f, placement.link_2, mp, p2, Matrix3::zeros());
                    let length = (p2 - p1).norm();
                    let u = (p2 - p1) / length;
                    let spring = c.stiffness * (y - (length - self.rest[i]));
                    let (j1, _, _) = bodies[placement.link_1].at(&p1);
                    let (j2, _, bias2) = bodies[placement.link_2].at(&p2);
                    let (along_1, along_2) = (dot(&u, &j1), dot(&u, &j2));
                    for k in 0..n {
                        f[k] += spring * (along_2[k] - along_1[k]);
                        a[(k, row)] -= mp * along_2[k];
                        a[(row, k)] -= mp * along_2[k];
                    }
                    a[(row, row)] += c.reflected_inertia + mp;
                    let felt = u.dot(&(bias2 - G));
                    f[row] += motor - c.damping * y_speed - spring + mp * felt;
                    cells.push((spring, mp, along_2, felt, 1.0));
                }
                Drive::Hoekens(mount) => {
                    let lever = self.robot.lever(i, &q).expect("in range");
                    let dof = self.robot.joints[mount.joint].dof.expect("moves");
                    let column = usize::from(self.rail) + dof;
                    let arm = lever.arms[dof];
                    let h = 1e-5;
                    let arm_at = |d: f64| {
                        let mut q = q.clone();
                        q[dof] += d;
                        self.robot.lever(i, &q).expect("in range").arms[dof]
                    };
                    let slope = (arm_at(h) - arm_at(-h)) / (2.0 * h);
                    let turning = slope * x[n + m + column].powi(2);
                    let p1 = poses[placement.link_1] * mount.point_1;
                    add_mass(&mut a, &mut f, placement.link_1, mp, p1, Matrix3::zeros());
                    let u = poses[placement.link_1].rotation * mount.axis_1.into_inner();
                    let (j1, _, bias1) = bodies[placement.link_1].at(&p1);
                    let along = dot(&u, &j1);
                    let spring = c.stiffness * (y - (lever.length_m - self.rest[i]));
                    let felt = u.dot(&(bias1 - G));
                    // F_bs = spring + mp (y'' - arm q'' - turning - along.q'' - felt), on rotor, joint, mount.
                    let known = spring - mp * (turning + felt);
                    f[row] += motor - c.damping * y_speed - known;
                    a[(row, row)] += c.reflected_inertia + mp;
                    f[column] += arm * known;
                    a[(column, row)] -= arm * mp;
                    for k in 0..n {
                        let s = along[k] + if k == column { arm } else { 0.0 };
                        a[(row, k)] -= mp * s;
                        a[(column, k)] += arm * mp * s;
                        // Reaction mp (y'' - s'') u at the mount.
                        f[k] -= mp * turning * along[k];
                        a[(k, row)] -= mp * along[k];
                        a[(k, column)] += mp * arm * along[k];
                    }
                    let mut all = along.clone();
                    all[column] += arm;
                    cells.push((spring, mp, all, felt + turning, 1.0));
                }
                Drive::RigidPosition { .. } => panic!("no position drives here"),
            }
        }
        let mut dx = DVector::zeros(x.len());
        let bristles = 2 * (n + m);
        if let Some(g) = &self.ground {
            let foot = self.robot.links.len() - 1;
            for (k, point) in self.sole.iter().enumerate() {
                let p = poses[foot] * point;
                if p.z >= 0.0 {
                    continue;
                }
                let (j, v, _) = bodies[foot].at(&p);
                let normal =
                    (g.stiffness_n_m_n * (-p.z).powf(g.exponent) * (1.0 - g.damping_s_m * v.z)).max(0.0);
                let bristle = Vector3::new(x[bristles + 3 * k], x[bristles + 3 * k + 1], 0.0);
                let slide = Vector3::new(v.x, v.y, 0.0);
                let mut tangential = -bristle * g.bristle_stiffness_n_m - slide * g.bristle_damping_n_s_m;
                let bound = g.friction * normal;
                if tangential.norm() > bound {
                    tangential *= bound / tangential.norm();
                }
                instant.ground += normal;
                let force = tangential + Vector3::z() * normal;
                let mut rows = f.rows_mut(0, n);
                rows += dot(&force, &j);
                for i in 0..2 {
                    dx[bristles + 3 * k + i] = v[i];
                }
            }
        }
        let acceleration = a.lu().solve(&f).expect("regular");
        for (i, (spring, mp, along, felt, _)) in cells.iter().enumerate() {
            let attachment: f64 = (0..n).map(|k| along[k] * acceleration[k]).sum();
            instant.force_1.push(*spring);
            instant.force_2.push(spring + mp * (acceleration[n + i] - attachment - felt));
        }
        for i in 0..n + m {
            dx[i] = x[n + m + i];
            dx[n + m + i] = acceleration[i];
        }
        (dx, instant)
    }

    /// What slipped beyond its bound is let go, and what does not touch relaxes.
    fn settle_bristles(&self, x: &mut DVector<f64>) {
        let Some(g) = &self.ground else { return };
        let bristles = 2 * (self.n + self.m);
        let (poses, bodies, _) = self.kinematics(x);
        let foot = self.robot.links.len() - 1;
        for (k, point) in self.sole.iter().enumerate() {
            let p = poses[foot] * point;
            let at = bristles + 3 * k;
            if p.z >= 0.0 {
                x[at] = 0.0;
                x[at + 1] = 0.0;
                continue;
            }
            let (_, v, _) = bodies[foot].at(&p);
            let normal = (g.stiffness_n_m_n * (-p.z).powf(g.exponent) * (1.0 - g.damping_s_m * v.z)).max(0.0);
            let slide = Vector3::new(v.x, v.y, 0.0) * g.bristle_damping_n_s_m;
            let wanted = -Vector3::new(x[at], x[at + 1], 0.0) * g.bristle_stiffness_n_m - slide;
            let bound = g.friction * normal;
            if wanted.norm() > bound {
                let held = wanted * (bound / wanted.norm());
                let bristle = -(held + slide) / g.bristle_stiffness_n_m;
                x[at] = bristle.x;
                x[at + 1] = bristle.y;
            }
        }
    }

    /// Integrates for `steps` of `h`, calling `see` with the number of each instant and what it is.
    pub fn run(&self, mut state: State, h: f64, steps: usize, mut see: impl FnMut(usize, &Instant)) {
        for step in 0..=steps {
            let (k1, instant) = self.derivative(&state.x);
            see(step, &instant);
            let (k2, _) = self.derivative(&(&state.x + &k1 * (0.5 * h)));
            let (k3, _) = self.derivative(&(&state.x + &k2 * (0.5 * h)));
            let (k4, _) = self.derivative(&(&state.x + &k3 * h));
            state.x += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0);
            self.settle_bristles(&mut state.x);
        }
    }
}
