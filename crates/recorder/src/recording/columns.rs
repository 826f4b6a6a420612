//! About a second of frames in columns, which is how a recording stays small and quick to write.

use super::entities::{refused, time_column};
use super::paths::{self, EVENTS, WORLD};
use super::rerun;
use super::stream::Stream;
use super::{Level, Poses, Scene, force_color};
use crate::RecorderError;

/// Frames that are not yet written.
#[derive(Debug, Default)]
pub(super) struct Columns {
    scalar_time_s: Vec<f64>,
    /// One flat column per group, row after row.
    scalars: Vec<Vec<f64>>,
    pose_time_s: Vec<f64>,
    poses: Vec<Poses>,
    event_time_s: Vec<f64>,
    events: Vec<(Level, String)>,
}

impl Columns {
    pub(super) fn new(scene: &Scene) -> Self {
        Self { scalars: vec![Vec::new(); scene.series.len()], ..Self::default() }
    }

    /// Adds one row of scalars, which are as many as the scene says.
    pub(super) fn push_scalars(&mut self, scene: &Scene, time_s: f64, scalars: &[f64]) {
        self.scalar_time_s.push(time_s);
        let mut rest = scalars;
        for (column, group) in self.scalars.iter_mut().zip(&scene.series) {
            let (own, others) = rest.split_at(group.members.len());
            column.extend_from_slice(own);
            rest = others;
        }
    }

    pub(super) fn push_poses(&mut self, time_s: f64, poses: Poses) {
        self.pose_time_s.push(time_s);
        self.poses.push(poses);
    }

    pub(super) fn push_event(&mut self, time_s: f64, level: Level, text: String) {
        self.event_time_s.push(time_s);
        self.events.push((level, text));
    }

    /// The first time that is held, if any.
    pub(super) fn first_time_s(&self) -> Option<f64> {
        [&self.scalar_time_s, &self.pose_time_s, &self.event_time_s]
            .iter()
            .filter_map(|t| t.first().copied())
            .min_by(f64::total_cmp)
    }

    pub(super) fn poses(&self) -> &[Poses] {
        &self.poses
    }

    /// Sends what is held and forgets it.
    pub(super) fn send(&mut self, stream: &mut Stream, scene: &Scene) -> Result<(), RecorderError> {
        self.send_scalars(stream, scene)?;
        self.send_poses(stream, scene)?;
        self.send_events(stream)
    }

    fn send_scalars(&mut self, stream: &mut Stream, scene: &Scene) -> Result<(), RecorderError> {
        let rows = self.scalar_time_s.len();
        if rows > 0 {
            for (column, group) in self.scalars.iter_mut().zip(&scene.series) {
                let values = std::mem::take(column);
                if group.members.is_empty() {
                    continue;
                }
                let columns = rerun::Scalars::new(values)
                    .columns(std::iter::repeat_n(group.members.len(), rows))
                    .map_err(refused)?;
                let time = time_column(&self.scalar_time_s);
                stream.send_columns(paths::group(&group.name), time, columns)?;
            }
        }
        self.scalar_time_s.clear();
        Ok(())
    }

    fn send_poses(&mut self, stream: &mut Stream, scene: &Scene) -> Result<(), RecorderError> {
        let time = time_column(&self.pose_time_s);
        let poses = std::mem::take(&mut self.poses);
        self.pose_time_s.clear();
        if poses.is_empty() {
            return Ok(());
        }
        let mut send = |path, columns: Vec<rerun::SerializedComponentColumn>| {
            stream.send_columns(path, time.clone(), columns)
        };
        for (i, body) in scene.bodies.iter().enumerate() {
            let columns = rerun::Transform3D::update_fields()
                .with_many_translation(poses.iter().map(|p| p.bodies[i].position_m.map(|v| v as f32)))
                .with_many_quaternion(
                    poses
                        .iter()
                        .map(|p| rerun::Quaternion::from_xyzw(p.bodies[i].orientation.map(|v| v as f32))),
                )
                .columns_of_unit_batches()
                .map_err(refused)?;
            send(paths::path([WORLD, "bodies", &body.name]), columns.collect())?;
        }
        for (i, rod) in scene.rods.iter().enumerate() {
            let columns = rerun::LineStrips3D::update_fields()
                .with_strips(
                    poses
                        .iter()
                        .map(|p| [p.rods[i].from_m.map(|v| v as f32), p.rods[i].to_m.map(|v| v as f32)]),
                )
                .with_colors(
                    poses
                        .iter()
                        .map(|p| rerun::Color::from(force_color(p.rods[i].force_n, rod.full_scale_n))),
                )
                .columns_of_unit_batches()
                .map_err(refused)?;
            send(paths::path([WORLD, "actuators", &rod.name]), columns.collect())?;
        }
        for (i, arrow) in scene.arrows.iter().enumerate() {
            let columns = rerun::Arrows3D::update_fields()
                .with_origins(poses.iter().map(|p| p.arrows[i].origin_m.map(|v| v as f32)))
                .with_vectors(
                    poses.iter().map(|p| p.arrows[i].force_n.map(|v| (v * arrow.length_m_per_n) as f32)),
                )
                .columns_of_unit_batches()
                .map_err(refused)?;
            send(paths::path([WORLD, "forces", &arrow.name]), columns.collect())?;
        }
        Ok(())
    }

    fn send_events(&mut self, stream: &mut Stream) -> Result<(), RecorderError> {
        if !self.events.is_empty() {
            let level = |l: Level| match l {
                Level::Info => rerun::TextLogLevel::INFO,
                Level::Warning => rerun::TextLogLevel::WARN,
                Level::Error => rerun::TextLogLevel::ERROR,
            };
            let columns = rerun::TextLog::update_fields()
                .with_many_text(self.events.iter().map(|(_, text)| text.as_str()))
                .with_many_level(self.events.iter().map(|(l, _)| level(*l)))
                .columns_of_unit_batches()
                .map_err(refused)?;
            stream.send_columns(paths::path([EVENTS]), time_column(&self.event_time_s), columns)?;
        }
        self.event_time_s.clear();
        self.events.clear();
        Ok(())
    }
}
