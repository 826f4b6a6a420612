//! The elements of a URDF as plain values, read from XML that [`super::xml`] has looked over.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use roxmltree::Node;

/// Everything that is read of a `<robot>`.
pub(super) struct Elements {
    /// The robot's name; empty where the file gives none.
    pub name: String,
    pub links: Vec<LinkElement>,
    pub joints: Vec<JointElement>,
    /// Colours of the materials that are defined outside of links, by name.
    pub materials: Vec<MaterialElement>,
}

/// A `<link>`.
pub(super) struct LinkElement {
    pub name: String,
    pub inertial: Option<InertialElement>,
    pub visuals: Vec<ShapeElement>,
    pub collisions: Vec<ShapeElement>,
}

/// An `<inertial>`.
pub(super) struct InertialElement {
    pub origin: Isometry3<f64>,
    pub mass_kg: f64,
    /// `ixx`, `ixy`, `ixz`, `iyy`, `iyz`, `izz` along the axes of `origin`, kg m^2.
    pub inertia: [f64; 6],
}

/// A `<visual>` or a `<collision>`.
pub(super) struct ShapeElement {
    pub name: String,
    pub origin: Isometry3<f64>,
    /// `None` if it is of a kind that is not read.
    pub geometry: Option<GeometryElement>,
    pub material: Option<MaterialElement>,
}

/// What is inside a `<geometry>`, lengths in m.
pub(super) enum GeometryElement {
    Box([f64; 3]),
    Cylinder { radius: f64, length: f64 },
    Capsule { radius: f64, length: f64 },
    Sphere(f64),
    Mesh { file: String, scale: [f64; 3] },
}

/// A `<material>`.
pub(super) struct MaterialElement {
    pub name: String,
    pub color: Option<[f64; 4]>,
}

/// A `<joint>`.
pub(super) struct JointElement {
    pub name: String,
    pub kind: String,
    pub parent: String,
    pub child: String,
    pub origin: Isometry3<f64>,
    pub axis: [f64; 3],
    pub limit: Option<LimitElement>,
    pub damping: f64,
    pub friction: f64,
    /// The joint that this one is to follow.
    pub mimic: Option<String>,
}

/// A `<limit>`; `None` where the attribute is not there.
#[derive(Clone, Copy)]
pub(super) struct LimitElement {
    pub lower: Option<f64>,
    pub upper: Option<f64>,
    pub effort: Option<f64>,
    pub velocity: Option<f64>,
}

/// Reads the elements below `<robot>`. Numbers have been looked over: one that cannot be read counts as absent.
pub(super) fn read(robot: Node) -> Elements {
    Elements {
        name: text(robot, "name"),
        links: children(robot, "link").map(link).collect(),
        joints: children(robot, "joint").map(joint).collect(),
        materials: children(robot, "material").map(material).collect(),
    }
}

fn children<'a, 'input>(node: Node<'a, 'input>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |c| c.is_element() && c.tag_name().name() == tag)
}

fn child<'a, 'input>(node: Node<'a, 'input>, tag: &'static str) -> Option<Node<'a, 'input>> {
    children(node, tag).next()
}

fn text(node: Node, attribute: &str) -> String {
    node.attribute(attribute).unwrap_or_default().to_owned()
}

fn numbers<const N: usize>(node: Node, attribute: &str) -> Option<[f64; N]> {
    let words: Vec<f64> =
        node.attribute(attribute)?.split_whitespace().map(str::parse).collect::<Result<_, _>>().ok()?;
    words.try_into().ok()
}

fn number(node: Node, attribute: &str) -> Option<f64> {
    numbers::<1>(node, attribute).map(|[value]| value)
}

/// URDF's `rpy` turns about the fixed axes x, then y, then z.
fn pose(node: Node) -> Isometry3<f64> {
    let of = |attribute| child(node, "origin").and_then(|o| numbers(o, attribute)).unwrap_or_default();
    let ([x, y, z], [roll, pitch, yaw]) = (of("xyz"), of("rpy"));
    Isometry3::from_parts(
        Translation3::from(Vector3::new(x, y, z)),
        UnitQuaternion::from_euler_angles(roll, pitch, yaw),
    )
}

fn link(node: Node) -> LinkElement {
    LinkElement {
        name: text(node, "name"),
        inertial: child(node, "inertial").map(|i| InertialElement {
            origin: pose(i),
            mass_kg: child(i, "mass").and_then(|m| number(m, "value")).unwrap_or_default(),
            inertia: ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]
                .map(|a| child(i, "inertia").and_then(|m| number(m, a)).unwrap_or_default()),
        }),
        visuals: children(node, "visual").map(shape).collect(),
        collisions: children(node, "collision").map(shape).collect(),
    }
}

fn shape(node: Node) -> ShapeElement {
    let geometry =
        child(node, "geometry").and_then(|g| g.children().filter(Node::is_element).find_map(geometry));
    ShapeElement {
        name: text(node, "name"),
        origin: pose(node),
        geometry,
        material: child(node, "material").map(material),
    }
}

fn geometry(node: Node) -> Option<GeometryElement> {
    let of = |attribute| number(node, attribute).unwrap_or_default();
    Some(match node.tag_name().name() {
        "box" => GeometryElement::Box(numbers(node, "size").unwrap_or_default()),
        "cylinder" => GeometryElement::Cylinder { radius: of("radius"), length: of("length") },
        "capsule" => GeometryElement::Capsule { radius: of("radius"), length: of("length") },
        "sphere" => GeometryElement::Sphere(of("radius")),
        "mesh" => GeometryElement::Mesh {
            file: text(node, "filename"),
            scale: numbers(node, "scale").unwrap_or([1.0; 3]),
        },
        _ => return None,
    })
}

fn material(node: Node) -> MaterialElement {
    MaterialElement { name: text(node, "name"), color: child(node, "color").and_then(|c| numbers(c, "rgba")) }
}

fn joint(node: Node) -> JointElement {
    let link = |tag| child(node, tag).map(|l| text(l, "link")).unwrap_or_default();
    let dynamics = |attribute| child(node, "dynamics").and_then(|d| number(d, attribute)).unwrap_or_default();
    JointElement {
        name: text(node, "name"),
        kind: text(node, "type"),
        parent: link("parent"),
        child: link("child"),
        origin: pose(node),
        // The default of the URDF specification.
        axis: child(node, "axis").and_then(|a| numbers(a, "xyz")).unwrap_or([1.0, 0.0, 0.0]),
        limit: child(node, "limit").map(|l| LimitElement {
            lower: number(l, "lower"),
            upper: number(l, "upper"),
            effort: number(l, "effort"),
            velocity: number(l, "velocity"),
        }),
        damping: dynamics("damping"),
        friction: dynamics("friction"),
        mimic: child(node, "mimic").map(|m| text(m, "joint")),
    }
}
