//! The foot on the ground: compliant contact at sole points by our own forces.
//!
//! The engine's solver contact gives no impact force (its peak grows as one over the step), so it is off,
//! and every sole point feels
//!
//! ```text
//! normal    N = k d^n (1 + c d')          never negative: nothing sticks       (Hunt and Crossley 1975)
//! friction  T = -kt z - ct v_t            |T| <= mu N: beyond it the bristle's root slips
//! ```
//!
//! with the depth `d` below the plane, its rate `d'`, and the bristle's elongation `z`. A bristle belongs to
//! a sole point, not to an entry of a contact manifold, whose order changes with the pose. Regularised
//! friction would creep by millimetres a second under a constant load; a bristle rests.
//!
//! Sole points come from the collision shapes by parry's support function: for boxes and meshes the
//! extreme points along the eight space diagonals (a box's corners), for spheres and capsules their centres
//! with a radius, for cylinders eight points of each rim.

mod sole;

use super::engine::{BodyState, Engine};
use crate::robot::{Geometry, Shape};
use nalgebra::{Isometry3, Point3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::shape::{ConvexPolyhedron, Cuboid, SupportMap};
use serde::{Deserialize, Serialize};
use sole::Sole;

/// The ground and what touching it is like, as it stands in a scenario's file. The defaults let four corners sink 1 mm under
/// 350 N: an estimate of a shoe sole on a hard floor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Ground {
    /// Height of the plane at x = y = 0, m.
    pub height_m: f64,
    /// Slope, rad: positive rises forward, along +x.
    pub slope_rad: f64,
    /// Coulomb coefficient `mu`.
    pub friction: f64,
    /// Stiffness of one sole point `k`, N/m^n.
    pub stiffness_n_m_n: f64,
    /// Exponent `n`.
    pub exponent: f64,
    /// Hunt-Crossley damping `c`, s/m.
    pub damping_s_m: f64,
    /// Bristle stiffness of one sole point `kt`, N/m.
    pub bristle_stiffness_n_m: f64,
    /// Bristle damping of one sole point `ct`, N s/m.
    pub bristle_damping_n_s_m: f64,
}

impl Default for Ground {
    /// A level plane at height 0; four corners sink 1 mm under 350 N.
    fn default() -> Self {
        Self {
            height_m: 0.0,
            slope_rad: 0.0,
            friction: 0.8,
            stiffness_n_m_n: 2.77e6,
            exponent: 1.5,
            damping_s_m: 0.5,
            bristle_stiffness_n_m: 87.5e3,
            bristle_damping_n_s_m: 125.0,
        }
    }
}

impl Ground {
    /// The plane's upward normal.
    #[must_use]
    pub fn normal(&self) -> [f64; 3] {
        let (sin, cos) = self.slope_rad.sin_cos();
        [-sin, 0.0, cos]
    }

    /// The normal force of one sole point in N, `depth` m below the plane and sinking at `rate` m/s.
    #[must_use]
    pub(crate) fn normal_force_n(&self, depth: f64, rate: f64) -> f64 {
        (self.elastic_force_n(depth) * (1.0 + self.damping_s_m * rate)).max(0.0)
    }

    /// The normal force of one sole point at rest in N, `depth` m below the plane.
    #[must_use]
    #[inline]
    fn elastic_force_n(&self, depth: f64) -> f64 {
        let stiff = if self.exponent == 1.5 { depth * depth.sqrt() } else { depth.powf(self.exponent) };
        self.stiffness_n_m_n * stiff
    }
}

/// A point of a sole, possibly with a radius around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SolePoint {
    /// Body that it belongs to.
    pub body: usize,
    /// Centre in the body's frame, m.
    pub center: Point3<f64>,
    /// Radius around it, m; 0 for a corner.
    pub radius_m: f64,
}

/// The sole points of a shape in its body's frame.
pub(crate) fn sole_points(body: usize, body_from_shape: &Isometry3<f64>, shape: &Shape) -> Vec<SolePoint> {
    let at = |x: f64, y: f64, z: f64, radius_m: f64| SolePoint {
        body,
        center: body_from_shape * Point3::new(x, y, z),
        radius_m,
    };
    match &shape.geometry {
        Geometry::Sphere { radius_m } => vec![at(0.0, 0.0, 0.0, *radius_m)],
        Geometry::Capsule { radius_m, length_m } => {
            [-0.5, 0.5].map(|s| at(0.0, 0.0, s * length_m, *radius_m)).to_vec()
        }
        Geometry::Cylinder { radius_m, length_m } => (0..16)
            .map(|i| {
                let angle = f64::from(i / 2) * std::f64::consts::FRAC_PI_4;
                let end = if i % 2 == 0 { -0.5 } else { 0.5 };
                at(radius_m * angle.cos(), radius_m * angle.sin(), end * length_m, 0.0)
            })
            .collect(),
        Geometry::Box { half } => {
            let [x, y, z] = *half;
            corners(&Cuboid::new(Vector::new(x, y, z))).iter().map(|p| at(p.x, p.y, p.z, 0.0)).collect()
        }
        Geometry::Mesh(mesh) => {
            let points: Vec<Vector> = mesh.vertices.iter().map(|&[x, y, z]| Vector::new(x, y, z)).collect();
            match ConvexPolyhedron::from_convex_hull(&points) {
                Some(hull) => corners(&hull).iter().map(|p| at(p.x, p.y, p.z, 0.0)).collect(),
                None => points.iter().map(|p| at(p.x, p.y, p.z, 0.0)).collect(),
            }
        }
    }
}

/// The extreme points along the eight space diagonals, each once.
fn corners(shape: &impl SupportMap) -> Vec<Vector> {
    let mut found: Vec<Vector> = Vec::with_capacity(8);
    for i in 0..8 {
        let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let point = shape.local_support_point(Vector::new(sign(0), sign(1), sign(2)));
        if !found.iter().any(|p| (*p - point).length() < 1e-9) {
            found.push(point);
        }
    }
    found
}

/// A sole point's bristle and where the point was.
#[derive(Debug, Clone, Copy)]
struct Touch {
    bristle: Vector3<f64>,
    /// Place of the centre at the last pose, and one step before it.
    before: Point3<f64>,
    earlier: Point3<f64>,
    touching: bool,
    force: Vector3<f64>,
    at: Point3<f64>,
    depth_m: f64,
}

/// What the ground does at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GroundInstant {
    /// Sum of the normal forces, N.
    pub normal_force_n: f64,
    /// Whole force on the leg, world, N.
    pub force_n: [f64; 3],
    /// Where it acts: the mean of the touching points, weighted by normal force; world, m.
    pub center_m: [f64; 3],
    /// Number of touching sole points.
    pub touching: usize,
}

/// All sole points and the ground.
#[derive(Debug, Clone)]
pub(crate) struct Contact {
    ground: Ground,
    normal: Vector3<f64>,
    origin: Point3<f64>,
    points: Vec<SolePoint>,
    touches: Vec<Touch>,
    /// The bodies that have sole points.
    soles: Vec<Sole>,
}

impl Contact {
    pub fn new(ground: Ground, points: Vec<SolePoint>, engine: &Engine) -> Self {
        let mut contact = Self {
            normal: ground.normal().into(),
            origin: Point3::new(0.0, 0.0, ground.height_m),
            ground,
            points,
            touches: Vec::new(),
            soles: Vec::new(),
        };
        contact.start(engine);
        contact
    }

    /// Takes up the pose at the start with relaxed bristles.
    pub fn start(&mut self, engine: &Engine) {
        let touch = |p: &SolePoint| {
            let at = engine.states[p.body].pose * p.center;
            Touch {
                bristle: Vector3::zeros(),
                before: at,
                earlier: at,
                touching: false,
                force: Vector3::zeros(),
                at,
                depth_m: 0.0,
            }
        };
        self.touches = self.points.iter().map(touch).collect();
        let mut bodies: Vec<usize> = self.points.iter().map(|p| p.body).collect();
        bodies.sort_unstable();
        bodies.dedup();
        self.soles = bodies.into_iter().map(Sole::new).collect();
    }

    /// Puts the ground's forces on the bodies. Velocities are those at the time of the pose.
    pub fn apply(&mut self, engine: &mut Engine, step_s: f64) -> GroundInstant {
        for (point, touch) in self.points.iter().zip(&mut self.touches) {
            touch.move_to(point, &engine.states[point.body], (&self.origin, &self.normal), step_s);
        }
        let mut total = GroundInstant::default();
        let mut center = Vector3::zeros();
        for sole in &mut self.soles {
            let points = self.points.iter().zip(&mut self.touches);
            let mut touches: Vec<&mut Touch> =
                points.filter(|(p, t)| p.body == sole.body && t.touching).map(|(_, t)| t).collect();
            sole.press(&mut touches, (&self.ground, &self.normal), engine, step_s);
            for touch in touches {
                engine.add_force(sole.body, &touch.force, &touch.at);
                let normal = touch.force.dot(&self.normal);
                total.normal_force_n += normal;
                total.touching += 1;
                for i in 0..3 {
                    total.force_n[i] += touch.force[i];
                }
                center += touch.at.coords * normal;
            }
        }
        if total.normal_force_n > 0.0 {
            total.center_m = (center / total.normal_force_n).into();
        }
        total
    }

    /// Power of the ground's forces on the leg, W, once the step that they were applied in is done: each
    /// force times the point's mean velocity from one step before its pose to one step after.
    pub fn power(&self, engine: &Engine, step_s: f64) -> f64 {
        let mut power = 0.0;
        for (point, touch) in self.points.iter().zip(&self.touches) {
            if touch.touching {
                let body = &engine.states[point.body];
                let place = body.pose * point.center;
                let mut velocity = (place - touch.earlier) / (2.0 * step_s);
                if point.radius_m > 0.0 {
                    velocity += body.twist.angular.cross(&(touch.at - touch.before));
                }
                power += touch.force.dot(&velocity);
            }
        }
        power
    }
}

impl Touch {
    /// Takes up the point's new place, and its bristle with it; the plane is an origin and its normal.
    fn move_to(
        &mut self,
        point: &SolePoint,
        body: &BodyState,
        (origin, normal): (&Point3<f64>, &Vector3<f64>),
        step_s: f64,
    ) {
        let place = body.pose * point.center;
        let mut moved = place - self.before;
        (self.earlier, self.before) = (self.before, place);
        self.depth_m = point.radius_m - (place - origin).dot(normal);
        if self.depth_m <= 0.0 {
            (self.touching, self.force, self.bristle) = (false, Vector3::zeros(), Vector3::zeros());
            return;
        }
        self.at = place - normal * point.radius_m;
        // The root was where the point first touched; the point has moved since by what it travelled.
        if self.touching {
            if point.radius_m > 0.0 {
                moved += body.twist.angular.cross(&(self.at - place)) * step_s;
            }
            self.bristle += moved - normal * moved.dot(normal);
        }
        self.touching = true;
    }
}
