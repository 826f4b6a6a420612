//! What is in a recording before time begins: shapes, rods, arrows, the ground and the names of the series.

use super::Color;

/// Everything of a recording that does not change with time.
///
/// Lengths in metres, in a right-handed world with z up. A quaternion is written `[x, y, z, w]`.
/// The order of bodies, rods, arrows and series is the order in which each frame gives them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scene {
    /// The recording's name, for example `thor-drop`.
    pub name: String,
    /// Moving bodies.
    pub bodies: Vec<Body>,
    /// Actuators, drawn as rods between their attachment points and coloured by force.
    pub rods: Vec<Rod>,
    /// Force arrows.
    pub arrows: Vec<Arrow>,
    /// The ground, if there is one.
    pub ground: Option<Ground>,
    /// Groups of time series, one plot each.
    pub series: Vec<SeriesGroup>,
    /// Texts to read beside the pictures: the scenario itself, notes on estimates.
    pub documents: Vec<Document>,
}

impl Scene {
    /// Number of scalars of one frame: the members of all series groups.
    #[must_use]
    pub fn scalar_count(&self) -> usize {
        self.series.iter().map(|g| g.members.len()).sum()
    }
}

/// A moving body: shapes in its own frame, and in each frame a pose in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Unique name, for example `shank`.
    pub name: String,
    /// Its shapes.
    pub shapes: Vec<Shape>,
}

/// One shape of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// What it is.
    pub geometry: Geometry,
    /// Position of the shape's centre in the body's frame, m.
    pub position_m: [f64; 3],
    /// Orientation in the body's frame, quaternion `[x, y, z, w]`.
    pub orientation: [f64; 4],
    /// Its colour.
    pub color: Color,
}

impl Shape {
    /// A shape at the body's origin.
    #[must_use]
    pub fn new(geometry: Geometry, color: Color) -> Self {
        Self { geometry, position_m: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0], color }
    }

    /// The same shape elsewhere in the body's frame.
    #[must_use]
    pub fn at(mut self, position_m: [f64; 3], orientation: [f64; 4]) -> Self {
        self.position_m = position_m;
        self.orientation = orientation;
        self
    }
}

/// The geometry of a shape, about its centre; axes of cylinders and capsules along z, as in URDF.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Geometry {
    /// A box.
    Box {
        /// Full edge lengths, m.
        size_m: [f64; 3],
    },
    /// A cylinder along z.
    Cylinder {
        /// Full length, m.
        length_m: f64,
        /// Radius, m.
        radius_m: f64,
    },
    /// A capsule along z.
    Capsule {
        /// Length of the cylindrical part, without the caps, m.
        length_m: f64,
        /// Radius, m.
        radius_m: f64,
    },
    /// A sphere.
    Sphere {
        /// Radius, m.
        radius_m: f64,
    },
    /// A triangle mesh.
    Mesh {
        /// Corners, m.
        vertices_m: Vec<[f64; 3]>,
        /// Indices into the corners, counter-clockwise from outside.
        triangles: Vec<[u32; 3]>,
    },
}

/// An actuator between two attachment points.
#[derive(Debug, Clone, PartialEq)]
pub struct Rod {
    /// Unique name, for example `knee`.
    pub name: String,
    /// Radius as drawn, m.
    pub radius_m: f64,
    /// The force at which the colour reaches its end, N: the rated force.
    pub full_scale_n: f64,
}

/// A force, drawn as an arrow from where it acts.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrow {
    /// Unique name, for example `knee_force_1` or `ground_force`.
    pub name: String,
    /// Colour.
    pub color: Color,
    /// Length as drawn per force, m/N; 0.0002 draws 1 kN as 0.2 m.
    pub length_m_per_n: f64,
}

/// A ground plane, possibly on a slope.
#[derive(Debug, Clone, PartialEq)]
pub struct Ground {
    /// A point of the plane, m; the drawn square is centred on it.
    pub point_m: [f64; 3],
    /// The plane's upward normal, any length.
    pub normal: [f64; 3],
    /// Edge of the drawn square, m.
    pub size_m: f64,
}

/// A few scalars of the same unit that are looked at together: one entity, one plot.
#[derive(Debug, Clone, PartialEq)]
pub struct SeriesGroup {
    /// Entity name, for example `forces/spring`; unique in the scene.
    pub name: String,
    /// Title of the plot, for example `Spring force`.
    pub title: String,
    /// Unit as printed, for example `N`.
    pub unit: String,
    /// The tab on which the plot is shown; groups of one tab are stacked in the given order.
    pub tab: String,
    /// Names of the scalars with unit suffix, for example `knee_spring_force_n`.
    pub members: Vec<String>,
}

/// A text shown beside the pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct Document {
    /// Name of its tab, for example `Scenario`.
    pub name: String,
    /// The text.
    pub text: String,
    /// Whether the text is Markdown; otherwise it is shown as it is.
    pub markdown: bool,
}
