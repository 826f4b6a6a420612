//! One actuator of the leg: spring, rotor and sprung mass between two links.

use super::links::{KnownLinks, Links};
use super::path::{Path, Reach};
use super::rotor::{Rotor, RotorStep};
use super::screw_end::{ScrewEnd, ScrewEndStep};
use crate::dynamics::engine::Engine;
use nalgebra::{Point3, Vector3};
use sealegs_actuator::plant::{Laws, Pull, SeriesCompliance};
use sealegs_actuator::{Coefficients, Configuration};

/// One actuator in the leg. See the [module](super) for the equations.
#[derive(Debug)]
pub(crate) struct Actuator {
    /// Its numbers.
    pub coefficients: Coefficients,
    /// What acts beside the linear parts.
    pub laws: Laws,
    pub(super) path: Path,
    /// Length at which the spring is unloaded with the screw at `y = 0`, m.
    pub(super) rest_length_m: f64,
    pub(super) rotor: Rotor,
    /// The screw's end, where it is no rigid part of link 2.
    pub(super) screw_end: Option<ScrewEnd>,
    /// Lumped model only: spring deflection and its speed half a step before, m and m/s.
    pub(super) lumped: (f64, f64),
    /// Force of the slipping element beside the spring, N.
    pub(super) spring_slip_n: f64,
    /// Deflection one step ago, m.
    pub(super) deflection_before_m: f64,
    /// Inertial acceleration of the sprung mass' attachment one step ago, m/s^2.
    pub(super) acceleration: Vector3<f64>,
    /// Where the attachment was one step ago, and is now, m.
    pub(super) attachment: [Point3<f64>; 2],
    /// Length one step ago and now, m.
    pub(super) lengths_m: [f64; 2],
    /// Second derivative of the length one step ago, m/s^2 (for a linkage).
    pub(super) length_acceleration: f64,
    pub(super) reach: Reach,
    /// Direction one step ago.
    pub(super) direction_before: Vector3<f64>,
    /// Force in the screw at the last step, N.
    pub(super) load_n: f64,
    /// What pulls the rotor to a measured motion, and the force of it over the last step, N.
    pub(super) pull: Option<(Pull, f64)>,
    /// What was applied in this step, until it is completed after it.
    pub(super) applied: Applied,
}

/// What an actuator did in one step, before the links' motion is known.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Applied {
    pub motor_n: f64,
    pub spring_n: f64,
    pub deflection_m: f64,
    pub y_m: f64,
    pub rotor: RotorStep,
}

/// An actuator at one instant, everything at the time of the poses.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ActuatorInstant {
    /// Commanded motor current, before what the drive makes of it, A.
    pub current_a: f64,
    /// Motor force on the screw `F_m`, N.
    pub motor_force_n: f64,
    /// Force of the spring `F_k`, positive in compression, N.
    pub spring_force_n: f64,
    /// Force on link 1 (spring side) as a load cell there reads it, N, positive in compression.
    pub force_1_n: f64,
    /// Force on link 2 (screw side), N, positive in compression.
    pub force_2_n: f64,
    /// Deflection of the spring, m, positive in compression.
    pub deflection_m: f64,
    /// Extension of the screw `y = r theta` since the start, m.
    pub extension_m: f64,
    /// Rotor angle `theta`, rad.
    pub rotor_angle_rad: f64,
    /// Rotor speed, rad/s.
    pub rotor_speed_rad_s: f64,
    /// Distance of the attachments (for a linkage, spring to tracer), m.
    pub length_m: f64,
    /// Attachment on link 1, world, m.
    pub end_1_m: [f64; 3],
    /// Attachment on link 2, world, m.
    pub end_2_m: [f64; 3],
}

/// Rates of work of an actuator at one instant, W (positive puts energy into the leg), and its energies.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ActuatorPower {
    /// Of the motor.
    pub motor: f64,
    /// Of rotor damping and friction (not positive).
    pub rotor_losses: f64,
    /// Of what acts beside the linear spring.
    pub spring_losses: f64,
    /// Of gravity and of the turning axis on the sprung mass relative to its attachment: see the ledger.
    pub sprung_mass: f64,
    /// Not a power: kinetic energy of rotor and sprung mass beside what the engine counts, J.
    pub kinetic_j: f64,
    /// Not a power: energy in the linear spring and in a series compliance, J.
    pub spring_j: f64,
}

impl Actuator {
    pub(super) fn new(coefficients: Coefficients, path: Path, engine: &Engine) -> Self {
        let reach = path.reach(engine);
        Self {
            coefficients,
            laws: Laws::default(),
            path,
            rest_length_m: reach.length_m,
            rotor: Rotor::default(),
            screw_end: None,
            lumped: (0.0, 0.0),
            spring_slip_n: 0.0,
            deflection_before_m: 0.0,
            acceleration: Vector3::zeros(),
            attachment: [Point3::origin(); 2],
            lengths_m: [reach.length_m; 2],
            length_acceleration: 0.0,
            direction_before: reach.direction,
            reach,
            load_n: 0.0,
            pull: None,
            applied: Applied::default(),
        }
    }

    /// Deflection at which the spring carries a force, m: its law grows with deflection, and is halved to it.
    fn deflection_under(&self, spring_n: f64) -> f64 {
        let stiffness = self.coefficients.stiffness;
        let linear = spring_n / stiffness;
        let force = |deflection: f64| self.laws.spring_force(stiffness, deflection, 0.0, 0.0);
        if self.laws.spring_is_linear() || spring_n == 0.0 {
            return linear;
        }
        let (mut low, mut high) = (0.0, linear);
        // Play and softening springs need more than the linear deflection; nothing needs a thousand times that.
        for _ in 0..10 {
            if (force(high) - spring_n) * spring_n >= 0.0 {
                break;
            }
            (low, high) = (high, 2.0 * high);
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if (force(middle) - spring_n) * spring_n >= 0.0 { high = middle } else { low = middle }
        }
        high
    }

    fn is_lumped(&self) -> bool {
        self.coefficients.configuration == Configuration::Lumped
    }

    /// The link's point whose acceleration the sprung mass feels: link 2 for a sprung motor housing on a
    /// rod, link 1 for a sprung ball nut, and always link 1 for a linkage.
    fn attachment_at(&self, reach: &Reach) -> Point3<f64> {
        match (&self.path, self.coefficients.configuration) {
            (Path::Rod { .. }, Configuration::SprungMotorHousing) => reach.ends[1],
            _ => reach.ends[0],
        }
    }

    /// Takes up the pose at the start: the spring carries `spring_n` and everything is at rest with the
    /// given initial accelerations (zero on the first, trial, start).
    pub fn start(&mut self, engine: &Engine, spring_n: f64, start: &ActuatorStart, step_s: f64) {
        self.reach = self.path.reach(engine);
        let deflection = self.deflection_under(spring_n);
        self.rest_length_m = self.reach.length_m + deflection;
        if let Some(end) = &mut self.screw_end {
            end.start(&start.screw_end);
            self.rest_length_m += end.compressed_m;
        }
        let back = |acceleration: f64, half_steps: f64| -0.5 * half_steps * step_s * acceleration;
        let rotor_rate = self.reach.rate_m_s;
        self.rotor = Rotor {
            y_m: 0.0,
            // The screw starts at the rate of the length: a joint that starts in motion has moved its motor.
            speed_m_s: rotor_rate + back(start.rotor, 1.0),
            previous_m_s: rotor_rate + back(start.rotor, 3.0),
            ..Rotor::default()
        };
        self.lumped = (deflection, back(start.rotor, 1.0));
        self.spring_slip_n = 0.0;
        self.deflection_before_m = deflection;
        self.acceleration = start.attachment;
        self.length_acceleration = start.length;
        self.load_n = spring_n;
        self.direction_before = self.reach.direction;
        let now = self.attachment_at(&self.reach);
        let body = match (&self.path, self.coefficients.configuration) {
            (Path::Rod { end_2, .. }, Configuration::SprungMotorHousing) => end_2.0,
            (Path::Rod { end_1, .. }, _) => end_1.0,
            (Path::Crank { mount, .. }, _) => mount.0,
        };
        let velocity = engine.states[body].velocity_at(&now);
        // One step earlier, by the accelerations at the start.
        let then = now - velocity * step_s + start.attachment * (0.5 * step_s * step_s);
        self.attachment = [then, now];
        let length = self.reach.length_m;
        self.lengths_m =
            [length - self.reach.rate_m_s * step_s + 0.5 * start.length * step_s * step_s, length];
    }

    /// Puts the actuator's forces on the bodies and advances its rotor by a step.
    pub fn apply<L: Links>(
        &mut self,
        links: &mut L,
        current_a: f64,
        gravity: &Vector3<f64>,
        time_s: f64,
        step_s: f64,
    ) {
        let c = self.coefficients;
        let rate = self.reach.rate_m_s;
        let speed = if self.is_lumped() { self.lumped.1 + rate } else { self.rotor.speed_now() };
        let deflection = if self.is_lumped() {
            self.lumped.0
        } else {
            self.rotor.y_m - (self.reach.length_m - self.rest_length_m)
        };
        let end = self.screw_end.as_ref().map_or((0.0, 0.0), |end| (end.compressed_m, end.speed_now()));
        let deflection = deflection - end.0;
        let deflecting = speed - rate - end.1;
        let mut spring =
            self.laws.spring_force_over(c.stiffness, deflection, (deflecting, deflecting * step_s), time_s);
        if let Some(element) = self.laws.spring_slip {
            self.spring_slip_n = element.advance(self.spring_slip_n, deflection - self.deflection_before_m);
            spring += self.spring_slip_n;
        }
        self.deflection_before_m = deflection;
        let motor = self.laws.limited_force(c.force_constant * current_a, speed);
        let mut push = motor + self.laws.rotor_force(self.rotor.y_m, speed, self.load_n, time_s);
        if let Some((pull, force)) = &mut self.pull {
            *force = pull.force((time_s / step_s).round() as usize, (self.rotor.y_m, speed));
            push += *force;
        }
        let felt = self.reach.direction.dot(&(self.acceleration - gravity));
        let y_m = self.rotor.y_m;
        let (on_1, on_2, rotor) = match (self.screw_end.take(), c.configuration, &self.path) {
            (Some(end), ..) => self.apply_with_screw_end(end, links, push, spring, felt, step_s),
            (None, Configuration::Lumped, _) => self.apply_lumped(push, spring, speed, step_s),
            (None, Configuration::SprungMotorHousing, Path::Rod { .. }) => {
                let force = push - spring + c.sprung_mass * felt;
                let step = self.advance_rotor(force, step_s);
                (spring, spring + c.sprung_mass * step.acceleration, step)
            }
            (None, Configuration::SprungBallNut, _) => {
                let force = push - spring - c.sprung_mass * felt;
                let step = self.advance_rotor(force, step_s);
                (spring + c.sprung_mass * step.acceleration, spring, step)
            }
            (None, Configuration::SprungMotorHousing, Path::Crank { dof, .. }) => {
                let joint_speed = links.joint_velocity(*dof);
                let turning = self.reach.arm.arm_slope_m * joint_speed * joint_speed;
                links.set_armature(*dof, c.sprung_mass * self.reach.arm.arm_m.powi(2));
                let force = push - spring + c.sprung_mass * (self.length_acceleration + felt);
                let step = self.advance_rotor(force, step_s);
                // The joint's own acceleration times the arm is in the armature.
                let on_2 = spring + c.sprung_mass * (step.acceleration - turning - felt);
                let relative = c.sprung_mass * (step.acceleration - self.length_acceleration);
                (on_2 - relative, on_2, step)
            }
        };
        self.applied = Applied { motor_n: motor, spring_n: spring, deflection_m: deflection, y_m, rotor };
        links.push(&self.path, &self.reach, on_1, on_2);
    }

    /// Goes on along links whose motion is known, from the state in which it is: their pose may differ a little from that
    /// in which the actuator was started. A pull moves the rotor to a measured motion.
    pub fn follow(&mut self, links: &KnownLinks, pull: Option<Pull>) {
        let [now, next] = [links.path.reaches[0], links.path.reaches[1]];
        let (at, then) = (self.attachment_at(&now), self.attachment_at(&next));
        self.attachment = [at - (then - at), at];
        self.lengths_m = [2.0 * now.length_m - next.length_m, now.length_m];
        (self.reach, self.direction_before) = (now, now.direction);
        self.pull = pull.map(|pull| (pull, 0.0));
    }

    /// Force of the pull over the last step, N.
    pub fn pulled_n(&self) -> f64 {
        self.pull.as_ref().map_or(0.0, |(_, force)| *force)
    }

    /// The path at the engine's present pose, the velocity of the joint that a linkage turns, rad/s, and where the sprung
    /// mass is attached.
    pub fn reach_of(&self, engine: &Engine) -> (Reach, f64, Point3<f64>) {
        let speed = match &self.path {
            Path::Crank { dof, .. } => engine.joint_velocity(*dof),
            Path::Rod { .. } => 0.0,
        };
        let reach = self.path.reach(engine);
        (reach, speed, self.attachment_at(&reach))
    }

    fn advance_rotor(&mut self, force: f64, step_s: f64) -> RotorStep {
        self.advance_rotor_of(
            self.coefficients.reflected_inertia + self.coefficients.sprung_mass,
            force,
            step_s,
        )
    }

    pub(super) fn advance_rotor_of(&mut self, mass: f64, force: f64, step_s: f64) -> RotorStep {
        self.rotor.advance(mass, self.coefficients.damping, force, self.load_n, &self.laws, step_s)
    }

    /// The conventional model: all of `m_T` moves with the spring, relative to link 1.
    fn apply_lumped(&mut self, push: f64, spring: f64, speed: f64, step_s: f64) -> (f64, f64, RotorStep) {
        let c = self.coefficients;
        let on_2 = push - c.damping * speed;
        let acceleration = (on_2 - spring) / c.total_mass();
        let before = self.lumped.1;
        self.lumped.1 += step_s * acceleration;
        self.lumped.0 += step_s * self.lumped.1;
        self.rotor.previous_m_s = self.rotor.speed_m_s;
        (spring, on_2, RotorStep { acceleration, speed: 0.5 * (before + self.lumped.1), friction_n: 0.0 })
    }

    /// Completes the step with the links' motion, which the engine has found by now: load cells and work.
    pub fn complete<L: Links>(
        &mut self,
        links: &L,
        current_a: f64,
        gravity: &Vector3<f64>,
        step_s: f64,
        travel_per_rad: f64,
    ) -> (ActuatorInstant, ActuatorPower) {
        let c = self.coefficients;
        let was = self.reach;
        let Applied { motor_n, spring_n, deflection_m, y_m, rotor } = self.applied;
        self.reach = links.reach(&self.path);
        let [before, now] = self.attachment;
        let next = self.attachment_at(&self.reach);
        self.acceleration = ((next - now) - (now - before)) / (step_s * step_s);
        let velocity = (next - before) / (2.0 * step_s);
        self.attachment = [now, next];
        let [before, now] = self.lengths_m;
        let next = self.reach.length_m;
        self.length_acceleration = ((next - now) - (now - before)) / (step_s * step_s);
        let length_rate = (next - before) / (2.0 * step_s);
        self.lengths_m = [now, next];
        if let Some(known) = links.known_accelerations() {
            (self.acceleration, self.length_acceleration) = known;
        }

        let lumped = self.is_lumped();
        let end = self.screw_end.as_ref().map(|end| end.step).unwrap_or_default();
        let screw_speed = if lumped { rotor.speed + length_rate } else { rotor.speed };
        if lumped {
            self.rotor.y_m = self.lumped.0 + self.reach.length_m - self.rest_length_m;
            self.rotor.speed_m_s = self.lumped.1 + self.reach.rate_m_s;
        }
        let felt = was.direction.dot(&(self.acceleration - gravity));
        let (force_1, force_2) = match (c.configuration, &self.path) {
            (Configuration::Lumped, _) => (spring_n, spring_n + c.total_mass() * rotor.acceleration),
            (Configuration::SprungMotorHousing, _) if self.screw_end.is_some() => (spring_n, end.force_n),
            (Configuration::SprungMotorHousing, Path::Rod { .. }) => {
                (spring_n, spring_n + c.sprung_mass * (rotor.acceleration - felt))
            }
            (Configuration::SprungMotorHousing, Path::Crank { .. }) => {
                let relative = rotor.acceleration - self.length_acceleration;
                (spring_n, spring_n + c.sprung_mass * (relative - felt))
            }
            (Configuration::SprungBallNut, _) => {
                (spring_n + c.sprung_mass * (rotor.acceleration + felt), spring_n)
            }
        };
        self.load_n = if c.configuration == Configuration::SprungBallNut { force_1 } else { force_2 };
        let turning = (self.reach.direction - self.direction_before) / (2.0 * step_s);
        self.direction_before = was.direction;
        let along = was.direction.dot(&velocity);
        // Speed of the sprung mass relative to the attachment with which the engine moves it.
        let relative = match (c.configuration, &self.path) {
            (Configuration::SprungMotorHousing, Path::Rod { .. }) => end.speed - screw_speed,
            (Configuration::SprungMotorHousing, Path::Crank { .. }) => length_rate + end.speed - screw_speed,
            (Configuration::SprungBallNut, _) => screw_speed,
            (Configuration::Lumped, _) => screw_speed - length_rate,
        };
        let m = c.sprung_mass;
        let (sprung_mass, kinetic_j) = if lumped {
            // The lumped mass is accelerated against link 1 but pushes on nothing: the model's own flaw.
            let work = c.total_mass() * rotor.acceleration * along;
            (work, 0.5 * c.total_mass() * relative * relative)
        } else {
            let work = m * relative * (was.direction.dot(gravity) + turning.dot(&velocity));
            let rotor = 0.5 * c.reflected_inertia * screw_speed * screw_speed;
            (work, rotor + m * relative * (0.5 * relative + along))
        };
        // The unsprung mass is a part of link 2, and what it has beyond link 2's own motion is counted here.
        let (unsprung, series_j) = self.screw_end.as_ref().map_or((0.0, 0.0), |end| {
            let SeriesCompliance { stiffness, mass } = end.compliance;
            (mass, 0.5 * end.step.force_n * end.step.force_n / stiffness)
        });
        let carried = match &self.path {
            Path::Rod { .. } => along,
            Path::Crank { .. } => along + length_rate,
        };
        let sprung_mass =
            sprung_mass + unsprung * end.speed * (was.direction.dot(gravity) + turning.dot(&velocity));
        let kinetic_j = kinetic_j + unsprung * end.speed * (0.5 * end.speed + carried);
        let power = ActuatorPower {
            motor: motor_n * screw_speed,
            rotor_losses: (rotor.friction_n - c.damping * screw_speed) * screw_speed,
            spring_losses: -(spring_n - c.stiffness * deflection_m) * (screw_speed - length_rate - end.speed),
            sprung_mass,
            kinetic_j,
            spring_j: 0.5 * c.stiffness * deflection_m * deflection_m + series_j,
        };
        let instant = ActuatorInstant {
            current_a,
            motor_force_n: motor_n,
            spring_force_n: spring_n,
            force_1_n: force_1,
            force_2_n: force_2,
            deflection_m,
            extension_m: if lumped { deflection_m + was.length_m - self.rest_length_m } else { y_m },
            rotor_angle_rad: 0.0,
            rotor_speed_rad_s: screw_speed / travel_per_rad,
            length_m: was.length_m,
            end_1_m: was.ends[0].coords.into(),
            end_2_m: was.ends[1].coords.into(),
        };
        (ActuatorInstant { rotor_angle_rad: instant.extension_m / travel_per_rad, ..instant }, power)
    }

    /// Accelerations of the step that was completed last: those at the start, after a trial step.
    pub fn accelerations(&self) -> ActuatorStart {
        ActuatorStart {
            rotor: self.applied.rotor.acceleration,
            length: self.length_acceleration,
            attachment: self.acceleration,
            screw_end: self.screw_end.as_ref().map(|end| end.step).unwrap_or_default(),
        }
    }
}

/// Accelerations at the start, which place the half-step velocities; found by a trial step.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ActuatorStart {
    /// `y''`, m/s^2.
    pub rotor: f64,
    /// Second derivative of the length, m/s^2.
    pub length: f64,
    /// Of the sprung mass' attachment, m/s^2.
    pub attachment: Vector3<f64>,
    /// What a screw's end on a compliance did.
    pub screw_end: ScrewEndStep,
}
