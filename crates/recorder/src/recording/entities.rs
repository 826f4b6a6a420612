//! What of a scene is logged once: shapes, styles, the ground, documents.

use super::paths::{self, DOCUMENTS, TIMELINE, WORLD};
use super::rerun::{self, AsComponents, EntityPath};
use super::stream::Stream;
use super::{Color, Document, Geometry, Ground, Scene, SeriesGroup, Shape};
use crate::RecorderError;

/// Colours of the series of one plot, in order; beyond the eighth they repeat.
const SERIES_COLORS: [Color; 8] = [
    Color::SKY_BLUE,
    Color::ORANGE,
    Color::GREEN,
    Color::VERMILLION,
    Color::PURPLE,
    Color::YELLOW,
    Color::BLUE,
    Color::LIGHT_GREY,
];

impl From<Color> for rerun::Color {
    fn from(c: Color) -> Self {
        Self::from_rgb(c.red, c.green, c.blue)
    }
}

fn rgba(c: Color) -> rerun::Rgba32 {
    rerun::Rgba32::from_rgb(c.red, c.green, c.blue)
}

/// Any refusal of the recorder as ours.
pub(super) fn refused(error: impl std::fmt::Display) -> RecorderError {
    RecorderError::Recorder { what: error.to_string() }
}

fn log_static(stream: &mut Stream, path: EntityPath, what: &impl AsComponents) -> Result<(), RecorderError> {
    stream.log_static(path, what)
}

/// Logs everything of the scene that does not change.
pub(super) fn log_scene(stream: &mut Stream, scene: &Scene) -> Result<(), RecorderError> {
    log_static(stream, paths::path([WORLD]), &rerun::ViewCoordinates::RIGHT_HAND_Z_UP())?;
    for body in &scene.bodies {
        for (i, shape) in body.shapes.iter().enumerate() {
            let path = paths::path([WORLD, "bodies", &body.name, &format!("shape_{i}")]);
            log_shape(stream, path, shape)?;
        }
    }
    for rod in &scene.rods {
        let path = paths::path([WORLD, "actuators", &rod.name]);
        let style = rerun::LineStrips3D::update_fields().with_radii([rod.radius_m as f32]);
        log_static(stream, path, &style)?;
    }
    for arrow in &scene.arrows {
        let path = paths::path([WORLD, "forces", &arrow.name]);
        let style = rerun::Arrows3D::update_fields()
            .with_colors([rerun::Color::from(arrow.color)])
            .with_radii([0.006_f32]);
        log_static(stream, path, &style)?;
    }
    if let Some(ground) = &scene.ground {
        log_static(stream, paths::path([WORLD, "ground"]), &ground_mesh(ground))?;
        log_static(stream, paths::path([WORLD, "ground", "grid"]), &ground_grid(ground))?;
    }
    for group in &scene.series {
        log_series_style(stream, group)?;
    }
    for document in &scene.documents {
        log_document(stream, document)?;
    }
    Ok(())
}

fn log_shape(stream: &mut Stream, path: EntityPath, shape: &Shape) -> Result<(), RecorderError> {
    let center = shape.position_m.map(|v| v as f32);
    let rotation = rerun::Quaternion::from_xyzw(shape.orientation.map(|v| v as f32));
    let color = rerun::Color::from(shape.color);
    let solid = rerun::FillMode::Solid;
    match &shape.geometry {
        Geometry::Box { size_m } => {
            let half = size_m.map(|v| 0.5 * v as f32);
            let boxes = rerun::Boxes3D::from_centers_and_half_sizes([center], [half]);
            log_static(
                stream,
                path,
                &boxes.with_quaternions([rotation]).with_colors([color]).with_fill_mode(solid),
            )
        }
        Geometry::Cylinder { length_m, radius_m } => {
            let cylinder = rerun::Cylinders3D::from_lengths_and_radii([*length_m as f32], [*radius_m as f32])
                .with_centers([center])
                .with_quaternions([rotation])
                .with_colors([color])
                .with_fill_mode(solid);
            log_static(stream, path, &cylinder)
        }
        Geometry::Capsule { length_m, radius_m } => {
            // The recorder's capsule begins at its origin; ours is centred on it.
            let down = rotate(shape.orientation, [0.0, 0.0, -0.5 * length_m]);
            let begin: [f32; 3] = std::array::from_fn(|i| (shape.position_m[i] + down[i]) as f32);
            let capsule = rerun::Capsules3D::from_lengths_and_radii([*length_m as f32], [*radius_m as f32])
                .with_translations([begin])
                .with_quaternions([rotation])
                .with_colors([color])
                .with_fill_mode(solid);
            log_static(stream, path, &capsule)
        }
        Geometry::Sphere { radius_m } => {
            let sphere = rerun::Ellipsoids3D::from_centers_and_half_sizes([center], [[*radius_m as f32; 3]])
                .with_colors([color])
                .with_fill_mode(solid);
            log_static(stream, path, &sphere)
        }
        Geometry::Mesh { vertices_m, triangles } => {
            let vertices: Vec<[f32; 3]> = vertices_m
                .iter()
                .map(|v| {
                    let turned = rotate(shape.orientation, *v);
                    std::array::from_fn(|i| (turned[i] + shape.position_m[i]) as f32)
                })
                .collect();
            let mesh = flat_shaded(&vertices, triangles).with_albedo_factor(rgba(shape.color));
            log_static(stream, path, &mesh)
        }
    }
}

/// A mesh in which each triangle has its own corners and normal, so that edges show under the viewer's light.
fn flat_shaded(vertices: &[[f32; 3]], triangles: &[[u32; 3]]) -> rerun::Mesh3D {
    let mut corners = Vec::with_capacity(3 * triangles.len());
    let mut normals = Vec::with_capacity(3 * triangles.len());
    for triangle in triangles {
        let [Some(&a), Some(&b), Some(&c)] = triangle.map(|i| vertices.get(i as usize)) else {
            continue;
        };
        let (u, v): ([f32; 3], [f32; 3]) =
            (std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| c[i] - a[i]));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        let normal = if length > 0.0 { n.map(|x| x / length) } else { [0.0, 0.0, 1.0] };
        corners.extend([a, b, c]);
        normals.extend([normal; 3]);
    }
    rerun::Mesh3D::new(corners).with_vertex_normals(normals)
}

/// Two unit vectors that span the ground, and its unit normal.
fn ground_axes(ground: &Ground) -> [[f64; 3]; 3] {
    let length = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let unit = |v: [f64; 3]| v.map(|x| x / length(v));
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let n = if length(ground.normal) > 0.0 { unit(ground.normal) } else { [0.0, 0.0, 1.0] };
    // y crossed with n points along x on level ground; the other choice only for a vertical wall.
    let along =
        if n[1].abs() < 0.9 { unit(cross([0.0, 1.0, 0.0], n)) } else { unit(cross([0.0, 0.0, 1.0], n)) };
    [along, cross(n, along), n]
}

fn ground_point(ground: &Ground, axes: &[[f64; 3]; 3], a: f64, b: f64, above: f64) -> [f32; 3] {
    std::array::from_fn(|i| (ground.point_m[i] + a * axes[0][i] + b * axes[1][i] + above * axes[2][i]) as f32)
}

fn ground_mesh(ground: &Ground) -> rerun::Mesh3D {
    let axes = ground_axes(ground);
    let h = 0.5 * ground.size_m;
    let corners = [(-h, -h), (h, -h), (h, h), (-h, h)].map(|(a, b)| ground_point(ground, &axes, a, b, 0.0));
    rerun::Mesh3D::new(corners)
        .with_triangle_indices([[0, 1, 2], [0, 2, 3]])
        .with_vertex_normals([axes[2].map(|v| v as f32); 4])
        .with_albedo_factor(rgba(Color::new(0x6B, 0x70, 0x78)))
}

fn ground_grid(ground: &Ground) -> rerun::LineStrips3D {
    let axes = ground_axes(ground);
    let h = 0.5 * ground.size_m;
    // Ten squares to an edge; a hair above the plane, so that the lines are not swallowed by it.
    let above = 5e-4 * ground.size_m;
    let lines = (0..=10).flat_map(|i| {
        let s = -h + 0.2 * h * f64::from(i);
        [
            [ground_point(ground, &axes, s, -h, above), ground_point(ground, &axes, s, h, above)],
            [ground_point(ground, &axes, -h, s, above), ground_point(ground, &axes, h, s, above)],
        ]
    });
    rerun::LineStrips3D::new(lines)
        .with_colors([rerun::Color::from_rgb(0x9A, 0xA0, 0xA8)])
        .with_radii([rerun::components::Radius::new_ui_points(0.5)])
}

fn log_series_style(stream: &mut Stream, group: &SeriesGroup) -> Result<(), RecorderError> {
    let colors = (0..group.members.len()).map(|i| rerun::Color::from(SERIES_COLORS[i % SERIES_COLORS.len()]));
    let style = rerun::SeriesLines::new()
        .with_names(group.members.iter().map(String::as_str))
        .with_colors(colors)
        .with_widths(group.members.iter().map(|_| 1.5_f32));
    log_static(stream, paths::group(&group.name), &style)
}

fn log_document(stream: &mut Stream, document: &Document) -> Result<(), RecorderError> {
    let text = rerun::TextDocument::new(document.text.as_str());
    let media = if document.markdown { rerun::MediaType::markdown() } else { rerun::MediaType::plain_text() };
    log_static(stream, paths::path([DOCUMENTS, &document.name]), &text.with_media_type(media))
}

/// A vector turned by a quaternion `[x, y, z, w]`.
pub(super) fn rotate(q: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let [x, y, z, w] = q;
    let t = [2.0 * (y * v[2] - z * v[1]), 2.0 * (z * v[0] - x * v[2]), 2.0 * (x * v[1] - y * v[0])];
    [
        v[0] + w * t[0] + y * t[2] - z * t[1],
        v[1] + w * t[1] + z * t[0] - x * t[2],
        v[2] + w * t[2] + x * t[1] - y * t[0],
    ]
}

/// The timeline of seconds for a column of times.
pub(super) fn time_column(time_s: &[f64]) -> rerun::TimeColumn {
    rerun::TimeColumn::new_duration_secs(TIMELINE, time_s.iter().copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_quarter_turn_about_z_takes_x_to_y() {
        let h = std::f64::consts::FRAC_1_SQRT_2;
        let turned = rotate([0.0, 0.0, h, h], [1.0, 0.0, 0.0]);
        assert!((turned[0]).abs() < 1e-15 && (turned[1] - 1.0).abs() < 1e-15 && turned[2].abs() < 1e-15);
    }

    #[test]
    fn analytic_the_ground_lies_in_its_plane_whatever_its_slope() {
        for normal in [[0.0, 0.0, 1.0], [0.3, 0.0, 0.9], [0.0, 2.0, 0.1], [-0.2, 0.4, 3.0]] {
            let ground = Ground { point_m: [0.1, -0.2, 0.05], normal, size_m: 2.0 };
            let axes = ground_axes(&ground);
            for (a, b) in [(1.0, 0.0), (0.0, 1.0), (-0.7, 0.4)] {
                let p = ground_point(&ground, &axes, a, b, 0.0);
                let off: f64 = (0..3).map(|i| (f64::from(p[i]) - ground.point_m[i]) * normal[i]).sum();
                assert!(off.abs() < 1e-6, "{normal:?} {off}");
                let far: f64 =
                    (0..3).map(|i| (f64::from(p[i]) - ground.point_m[i]).powi(2)).sum::<f64>().sqrt();
                assert!((far - f64::hypot(a, b)).abs() < 1e-6);
            }
        }
    }
}
