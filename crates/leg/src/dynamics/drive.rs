//! A rigid position drive: a joint that follows its command by a stiff servo.
//!
//! No spring and no rotor: the joint feels `kp (q_ref - q) - kd q'`, a PD servo at the joint itself, not a
//! prescribed motion, so that the drive's torque can be read and limited. Its stiffness is that of a geared
//! position servo, an estimate, and far above that of the compliant joints.

use super::engine::Engine;

/// The servo's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoLaw {
    /// Stiffness, N m/rad.
    pub stiffness_nm_rad: f64,
    /// Damping, N m s/rad.
    pub damping_nm_s_rad: f64,
}

impl Default for ServoLaw {
    /// An estimate: 2 N m give 1 mrad.
    fn default() -> Self {
        Self { stiffness_nm_rad: 2000.0, damping_nm_s_rad: 10.0 }
    }
}

/// One rigid position drive.
#[derive(Debug, Clone)]
pub(crate) struct Servo {
    pub name: String,
    pub body: usize,
    pub parent: usize,
    pub slides: bool,
    pub dof: usize,
    pub law: ServoLaw,
    /// Commanded position, rad.
    pub target_rad: f64,
    /// Greatest torque, N m.
    pub limit_nm: f64,
    pub torque_nm: f64,
    pub before: [f64; 2],
}

impl Servo {
    /// Puts the torque on the bodies.
    pub fn apply(&mut self, engine: &mut Engine) {
        let q = engine.q[self.dof];
        self.before = [self.before[1], q];
        let wanted = self.law.stiffness_nm_rad * (self.target_rad - q)
            - self.law.damping_nm_s_rad * engine.joint_velocity(self.dof);
        self.torque_nm = wanted.clamp(-self.limit_nm, self.limit_nm);
        engine.add_joint_effort(self.body, self.parent, self.slides, self.torque_nm);
    }

    /// Power, W, once the step that the torque was applied in is done.
    pub fn power(&self, engine: &Engine, step_s: f64) -> f64 {
        self.torque_nm * (engine.q[self.dof] - self.before[0]) / (2.0 * step_s)
    }
}
