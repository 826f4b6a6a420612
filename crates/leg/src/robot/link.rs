//! Links: mass properties and shapes.

use nalgebra::{Isometry3, Matrix3, Point3};

/// A rigid body of the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Unique name.
    pub name: String,
    /// Mass properties; `None` if the link is massless (a pure frame, as the world or a tool centre).
    pub inertial: Option<Inertial>,
    /// What a viewer shows.
    pub visuals: Vec<Shape>,
    /// What touches the ground.
    pub collisions: Vec<Shape>,
}

/// Mass, centre of mass and inertia of a link.
///
/// What moves as one, a link with everything that is fixed to it, is a body that can be
/// ([`Inertial::is_physical`]) in every robot that was loaded. A single link need not be: a point mass, or an inertia without mass, may be fixed
/// to another link.
#[derive(Debug, Clone, PartialEq)]
pub struct Inertial {
    /// Mass, kg, positive or zero.
    pub mass_kg: f64,
    /// Centre of mass in the link's frame, m.
    pub com: Point3<f64>,
    /// Inertia about the centre of mass along the link's axes, kg m^2: the URDF's inertial `rpy` has been
    /// applied.
    pub inertia: Matrix3<f64>,
}

impl Inertial {
    /// Principal moments may break the triangle inequality by this ratio: URDFs print few digits, and a thin
    /// plate obeys it as an equality.
    pub(super) const TRIANGLE_TOLERANCE: f64 = 1e-3;

    /// These mass properties with a point mass added at `point` (link frame, m), or taken out where
    /// `mass_kg` is negative. The result is not checked: see [`Inertial::is_physical`].
    #[must_use]
    pub fn with_point_mass(&self, mass_kg: f64, point: &Point3<f64>) -> Self {
        self.joined_with(&Self { mass_kg, com: *point, inertia: Matrix3::zeros() })
    }

    /// Two bodies as one, both in the same frame.
    #[must_use]
    pub fn joined_with(&self, other: &Self) -> Self {
        let total = self.mass_kg + other.mass_kg;
        let d = other.com - self.com;
        // The two-body form of the parallel axis theorem: reduced mass times squared distance. Without any mass
        // there is no centre of it to move, and nothing to add to the inertias.
        let (part, reduced) = match total {
            0.0 => (0.0, 0.0),
            _ => (other.mass_kg / total, self.mass_kg * other.mass_kg / total),
        };
        Self {
            mass_kg: total,
            com: self.com + d * part,
            inertia: self.inertia
                + other.inertia
                + (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * reduced,
        }
    }

    /// The same mass properties seen from another frame.
    #[must_use]
    pub fn seen_from(&self, to_from: &Isometry3<f64>) -> Self {
        let r = to_from.rotation.to_rotation_matrix();
        Self { mass_kg: self.mass_kg, com: to_from * self.com, inertia: r * self.inertia * r.transpose() }
    }

    /// Whether a body can have these mass properties: positive mass, positive definite inertia, and
    /// principal moments that obey the triangle inequality.
    #[must_use]
    pub fn is_physical(&self) -> bool {
        let finite = self.mass_kg.is_finite() && self.inertia.iter().all(|v| v.is_finite());
        if !finite || self.mass_kg <= 0.0 {
            return false;
        }
        let mut m = self.inertia.symmetric_eigenvalues();
        m.as_mut_slice().sort_by(f64::total_cmp);
        m[0] > 0.0 && m[2] <= (m[0] + m[1]) * (1.0 + Self::TRIANGLE_TOLERANCE)
    }
}

/// A shape fixed to a link.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// The URDF's name of it, or empty.
    pub name: String,
    /// `link_from_shape`.
    pub origin: Isometry3<f64>,
    /// The body itself.
    pub geometry: Geometry,
    /// Red, green, blue, opacity in 0..1; `None` where the URDF gives none.
    pub color: Option<[f64; 4]>,
}

/// The form of a shape; cylinders and capsules lie along z, all are centred on their origin.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// A box with these half extents, m.
    Box {
        /// Half extents along x, y, z, m.
        half: [f64; 3],
    },
    /// A cylinder along z.
    Cylinder {
        /// Radius, m.
        radius_m: f64,
        /// Whole length, m.
        length_m: f64,
    },
    /// A cylinder along z with half spheres at its ends.
    Capsule {
        /// Radius, m.
        radius_m: f64,
        /// Length of the cylindrical part, m.
        length_m: f64,
    },
    /// A sphere.
    Sphere {
        /// Radius, m.
        radius_m: f64,
    },
    /// Triangles.
    Mesh(Mesh),
}

/// A triangle mesh, already scaled to metres.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// The file that it came from.
    pub file: String,
    /// Corners in the shape's frame, m.
    pub vertices: Vec<[f64; 3]>,
    /// Triangles as indices into `vertices`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn analytic_two_spheres_on_a_rod() {
        let sphere = |x: f64| Inertial {
            mass_kg: 2.0,
            com: Point3::new(x, 0.0, 0.0),
            inertia: Matrix3::identity() * 0.1,
        };
        let both = sphere(-0.5).joined_with(&sphere(0.5));
        assert!((both.mass_kg - 4.0).abs() < 1e-15 && both.com.coords.norm() < 1e-15);
        // Steiner: 2 * 0.1 + 2 * 2 * 0.5^2 across, 2 * 0.1 along.
        assert!((both.inertia[(1, 1)] - 1.2).abs() < 1e-15 && (both.inertia[(0, 0)] - 0.2).abs() < 1e-15);
    }

    #[test]
    fn analytic_what_has_no_mass_adds_its_inertia_and_moves_nothing() {
        let frame = |x: f64, i: f64| Inertial {
            mass_kg: 0.0,
            com: Point3::new(x, 0.0, 0.0),
            inertia: Matrix3::identity() * i,
        };
        let both = frame(0.5, 0.1).joined_with(&frame(2.0, 0.2));
        assert_eq!((both.mass_kg, both.com.x), (0.0, 0.5));
        assert!((both.inertia[(2, 2)] - 0.3).abs() < 1e-15);
    }

    #[test]
    fn analytic_turning_the_frame_turns_the_inertia() {
        let rod = Inertial {
            mass_kg: 1.0,
            com: Point3::new(0.0, 0.0, 1.0),
            inertia: Matrix3::from_diagonal(&Vector3::new(3.0, 2.0, 1.0)),
        };
        let quarter = Isometry3::rotation(Vector3::y() * std::f64::consts::FRAC_PI_2);
        let seen = rod.seen_from(&quarter);
        assert!((seen.com - Point3::new(1.0, 0.0, 0.0)).norm() < 1e-15);
        assert!((seen.inertia - Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 3.0))).norm() < 1e-14);
    }
}
