//! What a recording says of one instant.

/// One instant of a run.
///
/// Scalars belong in a recording at about 1 kHz and poses at about 100 Hz, so either part may be left out:
/// [`RecordingWriter::due`](super::RecordingWriter::due) says what is wanted when.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Frame {
    /// Time, s; greater than that of the frame before.
    pub time_s: f64,
    /// All scalars, group after group in the scene's order; or empty to give none at this time.
    pub scalars: Vec<f64>,
    /// Where everything is; or `None` to give no poses at this time.
    pub poses: Option<Poses>,
}

/// Where bodies, rods and arrows are, each list in the scene's order.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Poses {
    /// Poses of the bodies in the world.
    pub bodies: Vec<Pose>,
    /// Ends and forces of the rods.
    pub rods: Vec<RodState>,
    /// Origins and forces of the arrows.
    pub arrows: Vec<ArrowState>,
}

/// A body's frame in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Position of the body's origin, m.
    pub position_m: [f64; 3],
    /// Orientation, quaternion `[x, y, z, w]`.
    pub orientation: [f64; 4],
}

impl Default for Pose {
    fn default() -> Self {
        Self { position_m: [0.0; 3], orientation: [0.0, 0.0, 0.0, 1.0] }
    }
}

/// An actuator at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RodState {
    /// Attachment on link 1 (the spring side), world, m.
    pub from_m: [f64; 3],
    /// Attachment on link 2 (the screw side), world, m.
    pub to_m: [f64; 3],
    /// Force, compression positive, N: it chooses the colour.
    pub force_n: f64,
}

/// A force at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ArrowState {
    /// Where it acts, world, m.
    pub origin_m: [f64; 3],
    /// The force, world, N.
    pub force_n: [f64; 3],
}

/// How much an event matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Level {
    /// Good to know: touch-down, lift-off.
    Info,
    /// The model or the machine is at a limit: saturation, a joint stop.
    Warning,
    /// Past what is allowed or known: a beam past yield, a force past its rating, a state that is not finite.
    Error,
}
