//! The triangles of a COLLADA (DAE) file, version 1.4: geometries at the places that the scene gives them.
//!
//! `roxmltree` reads the XML, the meshes are read here: of the libraries that read COLLADA, `mesh-loader` 0.1
//! reserves as much memory as a file claims to need and panics on an index that is out of range, and `dae-parser`
//! 0.11 refuses whatever the schema does not allow. Lengths are brought to metres by `<unit>`; `<up_axis>` is left
//! alone, as RViz does: URDFs are written for it.

use nalgebra::{Matrix4, Point3, Rotation3, Unit, Vector3, Vector4};
use roxmltree::{Document, Node};
use std::collections::HashMap;

use super::mesh::{Triangles, append};
use super::xml;

/// Most nodes of a scene, with those that are instances of others: more is a file that names itself.
const MOST_NODES: usize = 100_000;

/// Most triangles, and most vertices, of what the scene shows.
const MOST_SHOWN: usize = 5_000_000;

/// Most nodes inside each other.
const DEEPEST: usize = 64;

/// Reads the bytes of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Triangles, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "not a text in UTF-8".to_owned())?;
    let document = xml::parse(text.trim_start_matches('\u{feff}'), "COLLADA").map_err(|e| e.to_string())?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(format!("the outermost element is <{}>, not <COLLADA>", root.tag_name().name()));
    }
    let metres = child(root, "asset")
        .and_then(|a| child(a, "unit"))
        .and_then(|u| u.attribute("meter"))
        .map_or(Ok(1.0), |m| m.trim().parse::<f64>().map_err(|_| format!("unit meter '{m}' is no number")))?;
    let mut scene = Scene {
        by_id: ids(&document),
        vertices: Vec::new(),
        triangles: Vec::new(),
        geometries: HashMap::new(),
        nodes: 0,
    };
    let world = Matrix4::new_scaling(metres);
    let shown = child(root, "scene")
        .and_then(|s| child(s, "instance_visual_scene"))
        .and_then(|i| scene.target(i, "url"))
        .or_else(|| child(root, "library_visual_scenes").and_then(|l| child(l, "visual_scene")));
    match shown {
        Some(shown) => children(shown, "node").try_for_each(|n| scene.node(n, &world, 0))?,
        // No scene at all: the geometries as they are.
        None => {
            let library = children(root, "library_geometries").flat_map(|l| children(l, "geometry"));
            for geometry in library {
                scene.geometry(geometry, &world)?;
            }
        }
    }
    Ok((scene.vertices, scene.triangles))
}

/// The elements that others may name.
fn ids<'a, 'input>(document: &'a Document<'input>) -> HashMap<&'a str, Node<'a, 'input>> {
    document.descendants().filter_map(|n| n.attribute("id").map(|id| (id, n))).collect()
}

fn children<'a, 'input>(node: Node<'a, 'input>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |c| c.is_element() && c.tag_name().name() == tag)
}

fn child<'a, 'input>(node: Node<'a, 'input>, tag: &'static str) -> Option<Node<'a, 'input>> {
    children(node, tag).next()
}

/// The numbers in an element's text.
fn numbers<T: std::str::FromStr>(node: Node) -> Result<Vec<T>, String> {
    let tag = node.tag_name().name();
    let parts = node.children().filter_map(|c| c.text());
    parts
        .flat_map(str::split_whitespace)
        .map(|w| w.parse().map_err(|_| format!("'{w}' in <{tag}> is no number")))
        .collect()
}

struct Scene<'a, 'input> {
    by_id: HashMap<&'a str, Node<'a, 'input>>,
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    /// Geometries that have been read, by id.
    geometries: HashMap<&'a str, Triangles>,
    /// Nodes visited so far.
    nodes: usize,
}

impl<'a, 'input> Scene<'a, 'input> {
    /// The element that an attribute `#id` names.
    fn target(&self, node: Node<'a, 'input>, attribute: &str) -> Option<Node<'a, 'input>> {
        self.by_id.get(node.attribute(attribute)?.strip_prefix('#')?).copied()
    }

    /// Adds what a node shows and what is in it.
    fn node(&mut self, node: Node<'a, 'input>, parent: &Matrix4<f64>, depth: usize) -> Result<(), String> {
        self.nodes += 1;
        if self.nodes > MOST_NODES || depth > DEEPEST {
            return Err("the nodes of its scene have no end".to_owned());
        }
        let world = parent * transform(node)?;
        for inside in node.children().filter(Node::is_element) {
            match inside.tag_name().name() {
                "node" => self.node(inside, &world, depth + 1)?,
                "instance_node" => {
                    if let Some(other) = self.target(inside, "url") {
                        self.node(other, &world, depth + 1)?;
                    }
                }
                "instance_geometry" => {
                    if let Some(geometry) = self.target(inside, "url") {
                        self.geometry(geometry, &world)?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Adds a geometry at its place.
    fn geometry(&mut self, geometry: Node<'a, 'input>, world: &Matrix4<f64>) -> Result<(), String> {
        let id = geometry.attribute("id").unwrap_or_default();
        if !self.geometries.contains_key(id) {
            let read = self.mesh(geometry)?;
            self.geometries.insert(id, read);
        }
        let (corners, faces) = &self.geometries[id];
        if (self.vertices.len() + corners.len()).max(self.triangles.len() + faces.len()) > MOST_SHOWN {
            return Err(format!("more than {MOST_SHOWN} vertices or triangles"));
        }
        let mut faces = faces.clone();
        let placed = corners.iter().map(|c| world.transform_point(&Point3::from(*c)).into()).collect();
        if world.fixed_view::<3, 3>(0, 0).determinant() < 0.0 {
            faces.iter_mut().for_each(|t| t.swap(1, 2));
        }
        append(&mut self.vertices, &mut self.triangles, (placed, faces))
    }

    /// The polygons of a geometry, cut into triangles.
    fn mesh(&self, geometry: Node<'a, 'input>) -> Result<Triangles, String> {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        let Some(mesh) = child(geometry, "mesh") else { return Ok((vertices, triangles)) };
        for part in mesh.children().filter(Node::is_element) {
            let kind = part.tag_name().name();
            if !matches!(kind, "triangles" | "polylist" | "polygons" | "tristrips" | "trifans") {
                continue;
            }
            let input = children(part, "input").find(|i| i.attribute("semantic") == Some("VERTEX"));
            let Some(input) = input else { continue };
            let offset =
                |i: Node| i.attribute("offset").and_then(|o| o.trim().parse().ok()).unwrap_or(0_usize);
            let stride = children(part, "input").map(offset).max().unwrap_or(0).saturating_add(1);
            let corners = self.positions(input).ok_or("no positions to a <vertices>")??;
            let mut faces = Vec::new();
            let mut fan = |polygon: &[u32]| {
                faces.extend(polygon.windows(2).skip(1).map(|c| [polygon[0], c[0], c[1]]));
            };
            let counts: Vec<usize> = child(part, "vcount").map_or(Ok(Vec::new()), numbers)?;
            for list in children(part, "p") {
                let all: Vec<u32> = numbers(list)?;
                let own: Vec<u32> =
                    all.chunks_exact(stride).filter_map(|c| c.get(offset(input)).copied()).collect();
                match kind {
                    "triangles" => own.chunks_exact(3).for_each(&mut fan),
                    "tristrips" => own.windows(3).enumerate().for_each(|(i, c)| match i % 2 {
                        0 => fan(c),
                        _ => fan(&[c[1], c[0], c[2]]),
                    }),
                    "polylist" => {
                        let mut rest = own.as_slice();
                        for count in &counts {
                            let (polygon, after) =
                                rest.split_at_checked(*count).ok_or("a <vcount> beyond its <p>")?;
                            fan(polygon);
                            rest = after;
                        }
                    }
                    _ => fan(&own),
                }
            }
            append(&mut vertices, &mut triangles, (corners, faces))?;
        }
        Ok((vertices, triangles))
    }

    /// The positions behind an `<input semantic="VERTEX">`.
    fn positions(&self, input: Node<'a, 'input>) -> Option<Result<Vec<[f64; 3]>, String>> {
        let vertices = self.target(input, "source")?;
        let position = children(vertices, "input").find(|i| i.attribute("semantic") == Some("POSITION"))?;
        let source = self.target(position, "source")?;
        let accessor = child(child(source, "technique_common")?, "accessor")?;
        let whole = |attribute: &str, otherwise: usize| {
            accessor.attribute(attribute).and_then(|v| v.trim().parse().ok()).unwrap_or(otherwise)
        };
        let (stride, offset) = (whole("stride", 3).max(3), whole("offset", 0));
        let array = self.target(accessor, "source").or_else(|| child(source, "float_array"))?;
        Some(numbers::<f64>(array).map(|values| {
            values
                .get(offset..)
                .unwrap_or_default()
                .chunks_exact(stride)
                .map(|c| [c[0], c[1], c[2]])
                .collect()
        }))
    }
}

/// `parent_from_node`: the node's transformations in the order in which they stand.
fn transform(node: Node) -> Result<Matrix4<f64>, String> {
    let mut all = Matrix4::identity();
    for part in node.children().filter(Node::is_element) {
        let tag = part.tag_name().name();
        if !matches!(tag, "matrix" | "translate" | "rotate" | "scale") {
            continue;
        }
        let values: Vec<f64> = numbers(part)?;
        all *= match (tag, values.as_slice()) {
            ("matrix", v) if v.len() == 16 => Matrix4::from_row_slice(v),
            ("translate", &[x, y, z]) => Matrix4::new_translation(&Vector3::new(x, y, z)),
            ("scale", &[x, y, z]) => Matrix4::from_diagonal(&Vector4::new(x, y, z, 1.0)),
            ("rotate", &[x, y, z, degrees]) => Unit::try_new(Vector3::new(x, y, z), 1e-12)
                .map_or_else(Matrix4::identity, |axis| {
                    Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous()
                }),
            _ => return Err(format!("<{tag}> with {} numbers", values.len())),
        };
    }
    Ok(all)
}
