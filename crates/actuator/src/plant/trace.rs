//! What a simulation leaves behind: motion and forces at every point of the grid.

use super::{Grid, Plant};

/// Motion and forces at the points of a grid.
///
/// Signals that follow from others are computed when asked for. For a rotary actuator N and m stand for
/// N m and rad at the output.
#[derive(Debug, Clone)]
pub struct Trace {
    /// The grid.
    pub grid: Grid,
    /// Extension of the screw `y`, m.
    pub screw_position: Vec<f64>,
    /// Its rate, m/s.
    pub screw_speed: Vec<f64>,
    /// Force on link 1 by the spring `F_k`, N, positive in compression.
    pub force_1: Vec<f64>,
    /// Force on link 2, N, positive in compression.
    pub force_2: Vec<f64>,
    /// Motor force over the step that ends at the point, N.
    pub motor_force: Vec<f64>,
    /// Deflection of the spring, m, positive in compression; empty where it equals the screw's extension
    /// (both links fixed, no series compliance).
    pub deflection: Vec<f64>,
    /// Position of link 2 along the axis, m; empty if it is fixed.
    pub link_2_position: Vec<f64>,
    /// Its rate, m/s, where it is the load of a drive without a spring; empty otherwise.
    pub link_2_speed: Vec<f64>,
    /// Position of link 1 along the axis, m; empty if it is fixed.
    pub link_1_position: Vec<f64>,
    /// Force of an [`super::Observer`] on the rotor over the step that ends at the point, N; empty without one.
    pub rotor_pull: Vec<f64>,
    /// The same on link 2.
    pub output_pull: Vec<f64>,
}

impl Trace {
    pub(super) fn with_room(plant: &Plant, grid: Grid) -> Self {
        let points = grid.steps + 1;
        let at = super::Coordinates::of(plant);
        let room = |wanted: bool| Vec::with_capacity(if wanted { points } else { 0 });
        Self {
            grid,
            screw_position: room(true),
            screw_speed: room(true),
            force_1: room(true),
            force_2: room(true),
            motor_force: room(true),
            deflection: room(at.count > 1),
            link_2_position: room(at.link_2.is_some()),
            link_2_speed: room(plant.is_parted()),
            link_1_position: room(at.link_1.is_some()),
            rotor_pull: Vec::new(),
            output_pull: Vec::new(),
        }
    }

    /// Position (m) and speed (m/s) of the output of a drive without a spring, at every point.
    #[must_use]
    pub fn output(&self) -> (&[f64], &[f64]) {
        match self.link_2_speed.is_empty() {
            true => (&self.screw_position, &self.screw_speed),
            false => (&self.link_2_position, &self.link_2_speed),
        }
    }

    /// The spring's deflection, m, at every point.
    #[must_use]
    pub fn spring_deflection(&self) -> &[f64] {
        if self.deflection.is_empty() { &self.screw_position } else { &self.deflection }
    }
}

/// Values at arbitrary times from values at the points of a grid, by straight lines.
///
/// `shift_s` is added to the times; before the first and after the last point the end's value is taken.
#[must_use]
pub fn sample(values: &[f64], grid: &Grid, time_s: &[f64], shift_s: f64) -> Vec<f64> {
    let last = values.len() - 1;
    time_s
        .iter()
        .map(|t| {
            let position = (t + shift_s - grid.start_s) / grid.step_s;
            if position <= 0.0 {
                return values[0];
            }
            let point = position as usize;
            if point >= last {
                return values[last];
            }
            let along = position - point as f64;
            values[point] + along * (values[point + 1] - values[point])
        })
        .collect()
}
