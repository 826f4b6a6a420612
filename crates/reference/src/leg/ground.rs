//! The sole on the ground: Hunt and Crossley's normal force and friction by bristles at each corner.

use super::bodies::{Body, Moving};
use nalgebra::{Isometry3, Point3, Vector3};
use sealegs_leg::scenario;

/// Corners of a sole.
pub(super) const CORNERS: usize = 4;

/// Deflection of each corner's bristle along x and y, m.
pub(super) type Bristles = [[f64; 2]; CORNERS];

/// A level ground and the corners that touch it.
#[derive(Debug, Clone)]
pub(super) struct Ground {
    pub law: scenario::Ground,
    /// The link with the sole, by index.
    pub link: usize,
    /// In the link's frame, m.
    pub corners: [Point3<f64>; CORNERS],
}

/// What a corner feels, and how fast its bristle is drawn, m/s.
pub(super) struct Touch {
    pub corner: usize,
    pub point: Moving,
    pub normal: f64,
    pub tangential: Vector3<f64>,
    /// The bristle that the bound leaves, m.
    held: [f64; 2],
}

impl Touch {
    /// How fast the bristle is drawn, m/s.
    pub fn drawing(&self) -> [f64; 2] {
        [self.point.velocity.x, self.point.velocity.y]
    }

    /// The force on the sole, N.
    pub fn force(&self) -> Vector3<f64> {
        self.tangential + Vector3::z() * self.normal
    }
}

impl Ground {
    /// The corners that are below the ground.
    pub fn touches(&self, poses: &[Isometry3<f64>], bodies: &[Body], bristles: &Bristles) -> Vec<Touch> {
        let g = &self.law;
        let mut all = Vec::new();
        for (corner, local) in self.corners.iter().enumerate() {
            let p = poses[self.link] * local;
            let depth = g.height_m - p.z;
            if depth <= 0.0 {
                continue;
            }
            let point = bodies[self.link].at(&p);
            let stiffness = g.stiffness_n_m_n * depth.powf(g.exponent);
            let normal = (stiffness * (1.0 - g.damping_s_m * point.velocity.z)).max(0.0);
            let [x, y] = bristles[corner];
            let slide = Vector3::new(point.velocity.x, point.velocity.y, 0.0) * g.bristle_damping_n_s_m;
            let wanted = -Vector3::new(x, y, 0.0) * g.bristle_stiffness_n_m - slide;
            let bound = g.friction * normal;
            let (tangential, held) = if wanted.norm() > bound {
                let most = wanted * (bound / wanted.norm());
                let bristle = -(most + slide) / g.bristle_stiffness_n_m;
                (most, [bristle.x, bristle.y])
            } else {
                (wanted, [x, y])
            };
            all.push(Touch { corner, point, normal, tangential, held });
        }
        all
    }

    /// Lets go what has slipped beyond its bound, and relaxes what does not touch.
    pub fn settle(&self, poses: &[Isometry3<f64>], bodies: &[Body], bristles: &mut Bristles) {
        let mut next = [[0.0; 2]; CORNERS];
        for touch in self.touches(poses, bodies, bristles) {
            next[touch.corner] = touch.held;
        }
        *bristles = next;
    }
}
