//! How the recording of a run opens: the scene on the left, plots, texts and events on the right.

use super::entities::rotate;
use super::layout::{Part, View};
use super::paths::{self, DOCUMENTS, EVENTS, WORLD};
use super::rerun::blueprint::archetypes::{
    Background, EyeControls3D, LineGrid3D, PlotLegend, TextLogColumns, TimeAxis,
};
use super::rerun::blueprint::components::{BackgroundKind, Corner2D, Eye3DKind, LinkAxis, TextLogColumn};
use super::rerun::blueprint::datatypes::{TextLogColumn as ColumnOf, TextLogColumnKind};
use super::{Geometry, Poses, Scene, rerun};

/// The whole layout. The eye is placed by the first poses, if there are any yet.
pub(super) fn layout(scene: &Scene, poses: &[Poses]) -> Part {
    let mut right = Vec::new();
    let mut tabs: Vec<(String, Vec<(f32, Part)>)> = Vec::new();
    for group in scene.series.iter().filter(|g| !g.members.is_empty()) {
        let title = if group.unit.is_empty() {
            group.title.clone()
        } else {
            format!("{} [{}]", group.title, group.unit)
        };
        let plot = (1.0, Part::View(plot(title, [paths::group(&group.name)])));
        match tabs.iter_mut().find(|(name, _)| *name == group.tab) {
            Some((_, plots)) => plots.push(plot),
            None => tabs.push((group.tab.clone(), vec![plot])),
        }
    }
    let mut pages: Vec<(String, Part)> =
        tabs.into_iter().map(|(name, plots)| (name, Part::Column(plots))).collect();
    for document in &scene.documents {
        let path = paths::path([DOCUMENTS, &document.name]);
        let view = View::new("TextDocument", document.name.clone(), path.clone()).showing([path]);
        pages.push((document.name.clone(), Part::View(view)));
    }
    if !pages.is_empty() {
        right.push((4.0, Part::Tabs(pages)));
    }
    right.push((1.0, Part::View(events())));

    if scene.bodies.is_empty() && scene.rods.is_empty() && scene.arrows.is_empty() {
        return Part::Column(right);
    }
    Part::Row(vec![(0.85, Part::View(space(scene, poses))), (1.15, Part::Column(right))])
}

/// A plot of the given series, on a time axis that all plots share.
pub(super) fn plot(title: String, entities: impl IntoIterator<Item = rerun::EntityPath>) -> View {
    View::new("TimeSeries", title, rerun::EntityPath::root())
        .showing(entities)
        .with("PlotLegend", &PlotLegend::new().with_corner(Corner2D::RightTop))
        .with("TimeAxis", &TimeAxis::new().with_link(LinkAxis::LinkToGlobal))
}

/// The text log without the column of its path, which is always the same.
fn events() -> View {
    let column = |kind| TextLogColumn(ColumnOf { visible: true.into(), kind });
    let columns = TextLogColumns::new()
        .with_text_log_columns([column(TextLogColumnKind::LogLevel), column(TextLogColumnKind::Body)]);
    View::new("TextLog", "Events", paths::path([EVENTS])).with("TextLogColumns", &columns)
}

fn space(scene: &Scene, poses: &[Poses]) -> View {
    let (center, radius) = extent(scene, poses);
    // From the front left and a little above: a leg swings in x and z, and its hip moves in y.
    let direction = [0.62, -0.74, 0.26];
    let distance = 2.5 * radius;
    let eye = EyeControls3D::new()
        .with_kind(Eye3DKind::Orbital)
        .with_position(std::array::from_fn::<f32, 3, _>(|i| (center[i] + distance * direction[i]) as f32))
        .with_look_target(center.map(|v| v as f32))
        .with_eye_up([0.0_f32, 0.0, 1.0]);
    // One calm colour: the viewer's gradient is as colourful as the forces.
    let background =
        Background::new(BackgroundKind::SolidColor).with_color(rerun::Color::from_rgb(0x16, 0x1A, 0x20));
    View::new("3D", format!("{} (metres, z up)", scene.name), paths::path([WORLD]))
        .with("EyeControls3D", &eye)
        .with("Background", &background)
        // Our own ground shows where the ground is; the viewer's grid would lie at z = 0 whatever the slope.
        .with("LineGrid3D", &LineGrid3D::new().with_visible(scene.ground.is_none()))
}

/// Centre and radius of what is to be seen: all bodies in all given poses, and the ground's middle.
fn extent(scene: &Scene, poses: &[Poses]) -> ([f64; 3], f64) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let mut include = |point: [f64; 3], around: f64| {
        for i in 0..3 {
            low[i] = low[i].min(point[i] - around);
            high[i] = high[i].max(point[i] + around);
        }
    };
    for at in poses {
        for (body, pose) in scene.bodies.iter().zip(&at.bodies) {
            for shape in &body.shapes {
                let offset = rotate(pose.orientation, shape.position_m);
                let centre = std::array::from_fn(|i| pose.position_m[i] + offset[i]);
                include(centre, size(&shape.geometry));
            }
        }
        for rod in &at.rods {
            include(rod.from_m, 0.0);
            include(rod.to_m, 0.0);
        }
    }
    if let Some(ground) = &scene.ground {
        include(ground.point_m, 0.0);
    }
    if (0..3).any(|i| !low[i].is_finite() || !high[i].is_finite()) {
        return ([0.0; 3], 1.0);
    }
    let center = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
    let radius = 0.5 * (0..3).map(|i| (high[i] - low[i]).powi(2)).sum::<f64>().sqrt();
    (center, radius.max(0.05))
}

/// Half the largest extension of a geometry, m.
fn size(geometry: &Geometry) -> f64 {
    match geometry {
        Geometry::Box { size_m } => 0.5 * size_m.iter().copied().fold(0.0, f64::max),
        Geometry::Cylinder { length_m, radius_m } => (0.5 * length_m).max(*radius_m),
        Geometry::Capsule { length_m, radius_m } => 0.5 * length_m + radius_m,
        Geometry::Sphere { radius_m } => *radius_m,
        Geometry::Mesh { vertices_m, .. } => vertices_m.iter().flatten().map(|v| v.abs()).fold(0.0, f64::max),
    }
}
