//! Where the physics of an actuator can be more than linear: one seam for each place, all empty by default.

use sealegs_actuator::plant::{DriveLimit, DryFriction, ElastoSlip, RotorForce, SpringForce, SpringPath};

/// What acts in one actuator beside the linear spring, the viscous damping and the ideal drive. The laws are
/// those of `sealegs_actuator::plant`: what is written for a bench acts on the leg unchanged.
#[derive(Debug, Default)]
pub struct Laws {
    /// Limits of the drive that depend on speed: they change the motor force.
    pub drive_limits: Vec<Box<dyn DriveLimit>>,
    /// Dry friction of the rotor; the bounds add up. At rest it holds exactly, without creep.
    pub rotor_friction: Vec<Box<dyn DryFriction>>,
    /// Elastic presliding friction of the rotor.
    pub rotor_presliding: Option<ElastoSlip>,
    /// Smooth forces on the rotor.
    pub rotor_forces: Vec<Box<dyn RotorForce>>,
    /// In line with the spring (play).
    pub spring_path: Vec<Box<dyn SpringPath>>,
    /// Beside the linear spring.
    pub spring_forces: Vec<Box<dyn SpringForce>>,
    /// A slipping element beside the spring.
    pub spring_slip: Option<ElastoSlip>,
    /// Damping parallel to the spring, N s/m.
    pub spring_damping_n_s_m: f64,
}

impl Laws {
    /// The spring's force, N, without its slipping element, at a deflection (m) and its rate (m/s), positive
    /// in compression.
    pub(super) fn spring_force(&self, stiffness: f64, deflection: f64, rate: f64) -> f64 {
        let left = self.spring_path.iter().fold(deflection, |d, path| path.left(d));
        if left == 0.0 && !self.spring_path.is_empty() {
            return 0.0;
        }
        let beside: f64 = self.spring_forces.iter().map(|f| f.force(left, rate)).sum();
        stiffness * left + self.spring_damping_n_s_m * rate + beside
    }

    /// The motor's force, N, that the drive leaves of the commanded one at a screw speed, m/s.
    pub(super) fn motor_force(&self, commanded: f64, speed: f64) -> f64 {
        self.drive_limits.iter().fold(commanded, |force, limit| limit.limit(force, speed))
    }

    /// Smooth forces on the rotor, N.
    pub(super) fn on_rotor(&self, y: f64, speed: f64, load: f64, time_s: f64) -> f64 {
        self.rotor_forces.iter().map(|f| f.force(y, speed, load, time_s)).sum()
    }

    /// The bound of the rotor's dry friction, N.
    pub(super) fn friction_bound(&self, speed: f64, direction: f64, load: f64) -> f64 {
        self.rotor_friction.iter().map(|f| f.bound(speed, direction, load)).sum()
    }
}
