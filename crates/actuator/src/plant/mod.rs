//! One actuator between two links as a mechanical plant, its effects in place, and its integration in time.
//!
//! Generalised coordinates: the screw's extension `y = r theta`, the position `x_1` of link 1 (spring
//! side) and `x_2` of link 2 (screw side) where they move, the screw's end `x_s` where a series compliance
//! lies between screw and link 2, and the displacement `w` of a wobbling mass. The sprung mass is at
//! `x_p = x_s - y`, the spring's deflection is `delta = x_1 - x_p` (positive in compression), so that
//!
//! ```text
//! T = 1/2 m_J y'^2 + 1/2 m_s x_p'^2 + 1/2 m_1 x_1'^2 + 1/2 m_2 x_2'^2
//! V = 1/2 k delta^2 + gravity
//! ```
//!
//! which is equations 4-2 to 4-13 of the dissertation in one sign convention. The sprung ball nut is the
//! same plant seen from its spring side with another sprung mass; the conventional lumped model is the
//! limit `m_s = m_T`, `m_J = 0`. For a rotary actuator N, kg and m stand for N m, kg m^2 and rad at the
//! output.
//!
//! A drive without a spring ([`Plant::rigid`]) has one coordinate, its output's: the rotor turns its load directly, and
//! [`Plant::servo`] may close a position loop around it. Where its [`Transmission`] yields or has play, rotor and load are the
//! two ends of a spring as above, without a sprung mass.

mod command;
mod energy;
mod friction;
mod integrate;
mod laws;
mod linear;
mod linearised;
mod observer;
mod ports;
mod servo;
mod trace;
mod transmission;

pub(crate) use command::after;
pub use command::{Grid, at_step_starts, mean_per_step};
pub use energy::EnergyLedger;
pub use friction::Sliding;
pub use laws::{Laws, MOST_PRESLIDING, SpringStep};
pub use linear::Coordinates;
pub use linearised::Linearised;
pub use observer::{Observer, Pull, ReferenceMotion, observer_rate, pull_at, rigid_observer_rate, smoothed};
pub use ports::{
    CommandStage, DriveLimit, DryFriction, ElastoSlip, Onset, REFERENCE_TEMPERATURE_C, RotorForce,
    SensorStage, Slip, SpringForce, SpringPath,
};
pub use servo::{Feed, Loop, Past, Servo, Told, Winding};
pub use trace::{Trace, sample};
pub(crate) use transmission::DeadZone;
pub use transmission::{TRANSMISSION_DAMPING_RATIO, Transmission};

/// Gravitational acceleration, m/s^2.
pub const GRAVITY_M_S2: f64 = 9.81;

/// What an end of the actuator is attached to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Link {
    /// Bolted to the world.
    Fixed,
    /// A free mass along the axis, kg.
    Mass(f64),
    /// A mass that a spring and a damper tie to the world: a rig that yields.
    Mounted {
        /// kg.
        mass_kg: f64,
        /// N/m.
        stiffness_n_m: f64,
        /// N s/m.
        damping_n_s_m: f64,
    },
    /// A pendulum on a lever of constant arm: the end moves by `x = arm * angle`, the angle from hanging.
    Pendulum {
        /// Moment of inertia about the joint, kg m^2.
        inertia_kg_m2: f64,
        /// Mass times distance of the mass centre from the joint times gravity, N m.
        gravity_torque_nm: f64,
        /// Lever arm, m.
        arm_m: f64,
    },
}

impl Link {
    /// The inertia that the actuator feels along its axis, kg; infinite if fixed.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        match *self {
            Self::Fixed => f64::INFINITY,
            Self::Mass(mass) | Self::Mounted { mass_kg: mass, .. } => mass,
            Self::Pendulum { inertia_kg_m2, arm_m, .. } => inertia_kg_m2 / (arm_m * arm_m),
        }
    }

    /// The stiffness that the actuator feels along its axis, N/m: of gravity about hanging, or of the mounting.
    #[must_use]
    pub fn stiffness_n_m(&self) -> f64 {
        match *self {
            Self::Pendulum { gravity_torque_nm, arm_m, .. } => gravity_torque_nm / (arm_m * arm_m),
            Self::Mounted { stiffness_n_m, .. } => stiffness_n_m,
            _ => 0.0,
        }
    }

    /// The damping that the actuator feels along its axis, N s/m.
    #[must_use]
    pub fn damping_n_s_m(&self) -> f64 {
        if let Self::Mounted { damping_n_s_m, .. } = *self { damping_n_s_m } else { 0.0 }
    }
}

/// A spring between screw and link 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeriesCompliance {
    /// N/m.
    pub stiffness: f64,
    /// The unsprung mass that it carries, kg.
    pub mass: f64,
}

/// A point mass that is held by a spring and a damper at a radius of the output link (a pendulum).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WobblingMass {
    /// kg.
    pub mass: f64,
    /// Distance from the joint, m.
    pub radius: f64,
    /// Natural angular frequency on a fixed link, rad/s.
    pub angular_frequency: f64,
    /// Damping ratio on a fixed link.
    pub damping_ratio: f64,
}

/// An actuator between two links with everything that acts in it.
#[derive(Debug)]
pub struct Plant {
    /// Reflected rotor inertia `m_J = J / r^2`, kg.
    pub reflected_inertia: f64,
    /// Sprung mass `m_s`, kg.
    pub sprung_mass: f64,
    /// Reflected viscous damping `b = b_r / r^2`, N s/m.
    pub damping: f64,
    /// Stiffness of the spring, N/m.
    pub stiffness: f64,
    /// Screw travel per rotor angle `r`, m/rad.
    pub travel_per_rad: f64,
    /// Spring side.
    pub link_1: Link,
    /// Screw side.
    pub link_2: Link,
    /// The load of a drive without a spring, which moves with the rotor; links, spring and sprung mass are then none.
    pub rigid: Option<Link>,
    /// What lies between rotor and load of a drive without a spring.
    pub transmission: Transmission,
    /// Position (m) and speed (m/s) of the output at the start; only a drive without a spring may start in motion.
    pub start: (f64, f64),
    /// The winding, where the command is a voltage or a servo makes one.
    pub winding: Option<Winding>,
    /// A position loop, whose goal the command then is.
    pub servo: Option<Servo>,
    /// Compliance between screw and link 2.
    pub series: Option<SeriesCompliance>,
    /// A mass that wobbles on link 2.
    pub wobbling: Option<WobblingMass>,
    /// Motor force per unit of command: N/A for a current, 1 for a force, N/V for a voltage.
    pub force_per_command: f64,
    /// A constant that is added to the command, in the command's unit.
    pub command_offset: f64,
    /// Smooth forces on link 2 along the axis, of its position and speed, positive where `x_2` is.
    pub output_forces: Vec<Box<dyn RotorForce>>,
    /// Coulomb friction at the output joint, referred to the axis, N.
    pub output_friction: f64,
    /// What acts in the actuator beside its linear parts.
    pub laws: Laws,
}

impl Plant {
    /// An actuator without effects between two fixed links.
    #[must_use]
    pub fn new(reflected_inertia: f64, sprung_mass: f64, damping: f64, stiffness: f64) -> Self {
        Self {
            reflected_inertia,
            sprung_mass,
            damping,
            stiffness,
            travel_per_rad: 1.0,
            link_1: Link::Fixed,
            link_2: Link::Fixed,
            rigid: None,
            transmission: Transmission::RIGID,
            start: (0.0, 0.0),
            winding: None,
            servo: None,
            series: None,
            wobbling: None,
            force_per_command: 1.0,
            command_offset: 0.0,
            output_forces: Vec::new(),
            output_friction: 0.0,
            laws: Laws::default(),
        }
    }

    /// Lets a voltage drive the motor: the command is one, or the servo makes one.
    pub fn drive_by(&mut self, winding: Winding) {
        self.winding = Some(winding);
        self.force_per_command = winding.force_per_current / winding.resistance_ohm;
        // First of all, so that every other limit sees the force that is left beside the back-EMF.
        self.laws.drive_limits.insert(0, Box::new(BackEmf(winding)));
    }

    /// The force that passes from the drive to its load at a position (m) and acceleration (m/s^2), N; 0 where
    /// there is a spring.
    #[must_use]
    #[inline]
    pub fn transmitted_force(&self, position: f64, acceleration: f64) -> f64 {
        match self.rigid {
            Some(Link::Pendulum { inertia_kg_m2, gravity_torque_nm, arm_m }) => {
                let torque =
                    inertia_kg_m2 * acceleration / arm_m + gravity_torque_nm * (position / arm_m).sin();
                torque / arm_m
            }
            Some(Link::Mass(mass)) => mass * acceleration,
            _ => 0.0,
        }
    }

    /// The motor force in N for a command (in its unit) at screw speed `y_dot` (m/s).
    #[must_use]
    pub fn motor_force(&self, command: f64, y_dot: f64) -> f64 {
        self.laws.limited_force(self.commanded_force(command), y_dot)
    }

    /// The motor force in N that a command (in its unit) asks for.
    #[inline]
    fn commanded_force(&self, command: f64) -> f64 {
        self.force_per_command * (command + self.command_offset)
    }

    /// The force of the spring without its slipping element, N; see [`Laws::spring_force`].
    #[must_use]
    #[inline]
    pub fn spring_force(&self, delta: f64, delta_dot: f64, t: f64) -> f64 {
        self.laws.spring_force(self.stiffness, delta, delta_dot, t)
    }

    /// The motion and forces from rest under the mean `commands` (one per step of `grid`, in the
    /// command's unit).
    ///
    /// # Errors
    ///
    /// [`sealegs_model::ModelError::NotFinite`] when a state runs away.
    pub fn simulate(&self, grid: Grid, commands: &[f64]) -> Result<Trace, sealegs_model::ModelError> {
        self.simulate_fed(grid, Feed { commands, ..Feed::default() })
    }

    /// As [`Plant::simulate`], with what else a drive is told and fed with. A servo reads the supply and both read
    /// the enable signal.
    ///
    /// # Errors
    ///
    /// As [`Plant::simulate`].
    pub fn simulate_fed(&self, grid: Grid, feed: Feed) -> Result<Trace, sealegs_model::ModelError> {
        integrate::simulate(self, grid, feed, None)
    }

    /// As [`Plant::simulate_fed`], while an observer pulls the rotor and link 2 to a measured motion.
    ///
    /// # Errors
    ///
    /// As [`Plant::simulate`].
    pub fn observe(
        &self,
        grid: Grid,
        feed: Feed,
        observer: &Observer,
    ) -> Result<Trace, sealegs_model::ModelError> {
        integrate::simulate(self, grid, feed, Some(observer))
    }
}

/// What the back-EMF takes from the force that a voltage would make at standstill.
#[derive(Debug)]
struct BackEmf(Winding);

impl DriveLimit for BackEmf {
    fn limit(&self, commanded: f64, y_dot: f64) -> f64 {
        commanded + self.0.force(0.0, y_dot)
    }
}
