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
#[derive(Debug, Clone, PartialEq)]
pub struct Inertial {
    /// Mass, kg, positive.
    pub mass_kg: f64,
    /// Centre of mass in the link's frame, m.
    pub com: Point3<f64>,
    /// Inertia about the centre of mass along the link's axes, kg m^2: the URDF's inertial `rpy` has been
    /// applied. Positive definite, and no principal moment exceeds the sum of the other two.
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
        let total = self.mass_kg + mass_kg;
        let d = point - self.com;
        // The two-body form of the parallel axis theorem: reduced mass times squared distance.
        let reduced = self.mass_kg * mass_kg / total;
        Self {
            mass_kg: total,
            com: self.com + d * (mass_kg / total),
            inertia: self.inertia + (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * reduced,
        }
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
