//! What acts in an actuator beside its linear spring, viscous damping and ideal drive: one list for each place.

use super::ports::{
    CommandStage, DriveLimit, DryFriction, ElastoSlip, RotorForce, SensorStage, SpringForce, SpringPath,
};

/// The laws of one actuator, all places empty by default. A bench's [`super::Plant`] and an actuator of a leg hold
/// the same, so that what is written for the one acts in the other unchanged.
#[derive(Debug, Default)]
pub struct Laws {
    /// On the way of the command, in order.
    pub command_stages: Vec<Box<dyn CommandStage>>,
    /// Limits of the drive that depend on speed.
    pub drive_limits: Vec<Box<dyn DriveLimit>>,
    /// Dry friction of the rotor; the bounds add up. At rest it holds exactly, without creep.
    pub rotor_friction: Vec<Box<dyn DryFriction>>,
    /// Elastic presliding friction of the rotor.
    pub rotor_presliding: Option<ElastoSlip>,
    /// Smooth forces on the rotor.
    pub rotor_forces: Vec<Box<dyn RotorForce>>,
    /// In line with the spring.
    pub spring_path: Vec<Box<dyn SpringPath>>,
    /// Beside the linear spring.
    pub spring_forces: Vec<Box<dyn SpringForce>>,
    /// A slipping element beside the spring.
    pub spring_slip: Option<ElastoSlip>,
    /// Damping parallel to the spring, N s/m.
    pub spring_damping: f64,
    /// In front of or inside the sensors.
    pub sensor_stages: Vec<Box<dyn SensorStage>>,
}

impl Laws {
    /// The bound of the rotor's dry friction in N; see [`DryFriction::bound`].
    #[must_use]
    #[inline]
    pub fn rotor_friction_bound(&self, speed: f64, direction: f64, load: f64) -> f64 {
        self.rotor_friction.iter().map(|f| f.bound(speed, direction, load)).sum()
    }

    /// The sum of the smooth forces on the rotor in N; see [`RotorForce::force`].
    #[must_use]
    #[inline]
    pub fn rotor_force(&self, y: f64, y_dot: f64, load: f64, t: f64) -> f64 {
        self.rotor_forces.iter().map(|f| f.force(y, y_dot, load, t)).sum()
    }

    /// What the drive leaves of a motor force in N at screw speed `y_dot` (m/s).
    #[must_use]
    #[inline]
    pub fn limited_force(&self, force: f64, y_dot: f64) -> f64 {
        self.drive_limits.iter().fold(force, |force, limit| limit.limit(force, y_dot))
    }

    /// The force of a spring of `stiffness` (N/m) without its slipping element, N, at deflection `delta` (m) and
    /// its rate (m/s), positive in compression. Within play there is none, damping included: the damper works
    /// where the spring does.
    #[must_use]
    #[inline]
    pub fn spring_force(&self, stiffness: f64, delta: f64, delta_dot: f64) -> f64 {
        let left = self.spring_left(delta);
        if left == 0.0 && !self.spring_path.is_empty() {
            return 0.0;
        }
        let beside: f64 = self.spring_forces.iter().map(|f| f.force(left, delta_dot)).sum();
        stiffness * left + self.spring_damping * delta_dot + beside
    }

    /// [`Laws::spring_force`] beyond the linear law, without the damper's share.
    #[inline]
    pub(super) fn spring_force_beside(&self, stiffness: f64, delta: f64, delta_dot: f64) -> f64 {
        let left = self.spring_left(delta);
        if left == 0.0 && !self.spring_path.is_empty() {
            return -stiffness * delta;
        }
        let beside: f64 = self.spring_forces.iter().map(|f| f.force(left, delta_dot)).sum();
        stiffness * (left - delta) + beside
    }

    /// The deflection that is left for the spring out of the total one, m.
    #[inline]
    pub(super) fn spring_left(&self, delta: f64) -> f64 {
        self.spring_path.iter().fold(delta, |d, path| path.left(d))
    }

    /// Whether the spring is a linear spring and damper and nothing else.
    #[must_use]
    pub fn spring_is_linear(&self) -> bool {
        self.spring_path.is_empty() && self.spring_forces.is_empty() && self.spring_slip.is_none()
    }
}
