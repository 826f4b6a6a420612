//! An actuator with everything that may act in it, and its run under a held command.

use crate::beyond::Beyond;
use crate::effect::{FrictionLaw, Known};
use crate::machine::{Machine, State};
use crate::sensor::Chain;
pub use crate::sensor::SensorErrors;
use sealegs_actuator::bench::Bench;
use sealegs_actuator::{ActuatorSpec, Configuration};

/// What an end of the actuator is attached to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// The world.
    Held,
    /// A free mass, kg.
    Mass(f64),
    /// A mass (kg) on a spring (N/m) and a damper (N s/m).
    Mounted([f64; 3]),
    /// A point mass (kg) at a distance (m) that a lever (m) turns, in gravity.
    Pendulum {
        /// kg.
        mass_kg: f64,
        /// Distance of the mass from the joint, m.
        length_m: f64,
        /// m.
        arm_m: f64,
    },
}

/// An actuator with everything that may act in it; what is zero or `None` is absent. SI, at the screw or, for
/// a rotary actuator, at the output.
#[derive(Debug, Clone)]
pub struct Reference {
    /// Reflected rotor inertia.
    pub rotor: f64,
    /// Sprung mass.
    pub sprung: f64,
    /// Viscous damping of the rotor.
    pub damping: f64,
    /// Spring stiffness.
    pub stiffness: f64,
    /// Screw travel per rotor angle.
    pub travel_per_rad: f64,
    /// Motor force per command.
    pub force_per_command: f64,
    /// Spring side.
    pub link_1: End,
    /// Screw side.
    pub link_2: End,
    /// Coulomb friction of the rotor: force.
    pub coulomb: f64,
    /// Elastic presliding friction: force, stiffness.
    pub presliding: Option<[f64; 2]>,
    /// Dahl friction: force, stiffness.
    pub dahl: Option<[f64; 2]>,
    /// By how much the drive warms, from the temperature at which its friction is stated, K/s.
    pub warms_k_s: f64,
    /// Further laws of the rotor's dry friction, whose bounds add up.
    pub rotor_friction: Vec<FrictionLaw>,
    /// Quadratic drag: coefficient.
    pub drag: f64,
    /// Torque ripple: amplitude, cycles per turn, phase.
    pub ripple: [f64; 3],
    /// Limit of the command.
    pub command_limit: f64,
    /// Voltage saturation: bus, resistance.
    pub voltage: Option<[f64; 2]>,
    /// Lateness of the command, s.
    pub command_delay_s: f64,
    /// Command quantisation: count, rounding (0 truncates, 1 rounds).
    pub count: Option<[f64; 2]>,
    /// Cubic stiffness.
    pub cubic: f64,
    /// Damping parallel to the spring.
    pub spring_damping: f64,
    /// Slipping element beside the spring: stiffness, force.
    pub spring_slip: Option<[f64; 2]>,
    /// Width of the dead zone.
    pub gap: f64,
    /// Spring between screw and link 2, and the unsprung mass that it carries.
    pub series: Option<[f64; 2]>,
    /// Dry friction at the output, referred to the axis.
    pub output_friction: f64,
    /// Wobbling mass: mass, radius, frequency in Hz, damping ratio.
    pub wobbling: Option<[f64; 4]>,
    /// Errors of the sensors.
    pub sensors: SensorErrors,
    /// Something that is in no catalogue.
    pub beyond: Option<Beyond>,
}

/// Signals at the time stamps of the command.
#[derive(Debug, Clone, Default)]
pub struct Outputs {
    /// Force on link 1.
    pub force_1: Vec<f64>,
    /// Force on link 2.
    pub force_2: Vec<f64>,
    /// Extension of the screw.
    pub extension: Vec<f64>,
    /// Deflection of the spring.
    pub deflection: Vec<f64>,
    /// Position of link 2 along the axis.
    pub link_2: Vec<f64>,
}

impl Reference {
    /// An actuator without effects between held ends, command in force.
    #[must_use]
    pub fn new(rotor: f64, sprung: f64, damping: f64, stiffness: f64) -> Self {
        Self {
            rotor,
            sprung,
            damping,
            stiffness,
            travel_per_rad: 1.0,
            force_per_command: 1.0,
            link_1: End::Held,
            link_2: End::Held,
            coulomb: 0.0,
            presliding: None,
            dahl: None,
            warms_k_s: 0.0,
            rotor_friction: Vec::new(),
            drag: 0.0,
            ripple: [0.0; 3],
            command_limit: f64::INFINITY,
            voltage: None,
            command_delay_s: 0.0,
            count: None,
            cubic: 0.0,
            spring_damping: 0.0,
            spring_slip: None,
            gap: 0.0,
            series: None,
            output_friction: 0.0,
            wobbling: None,
            sensors: SensorErrors::default(),
            beyond: None,
        }
    }

    /// A preset's or a file's actuator on a bench, without effects; `input` is the command's column, which says
    /// whether the force constant is felt.
    #[must_use]
    pub fn of(spec: &ActuatorSpec, bench: Bench, input: &str) -> Self {
        let c = spec.coefficients();
        let (rotor, sprung) = match c.configuration {
            Configuration::Lumped => (0.0, c.total_mass()),
            _ => (c.reflected_inertia, c.sprung_mass),
        };
        let mass = |m: f64| if m.is_finite() { End::Mass(m) } else { End::Held };
        let (link_1, link_2) = match bench {
            Bench::Locked => (End::Held, End::Held),
            Bench::Pendulum(rig) => {
                (End::Held, End::Pendulum { mass_kg: rig.mass_kg, length_m: rig.length_m, arm_m: rig.arm_m })
            }
            Bench::Free { load } => (End::Held, End::Mass(load)),
            Bench::Masses { link_1_kg, link_2_kg } => (mass(link_1_kg), mass(link_2_kg)),
        };
        Self {
            travel_per_rad: spec.ratio(),
            force_per_command: if input == "current_a" { c.force_constant } else { 1.0 },
            link_1,
            link_2,
            ..Self::new(rotor, sprung, c.damping, c.stiffness)
        }
    }

    /// The same with an effect of the catalogue, by its id and its values in the order of its card.
    ///
    /// # Panics
    ///
    /// For an id that it does not know: a mistake in a program, not in an input.
    #[must_use]
    pub fn with(mut self, id: &str, values: &[f64]) -> Self {
        let Some(known) = Known::of(id) else { panic!("the reference integrator does not know '{id}'") };
        (known.put)(&mut self, values, id.split_once('@').map(|(_, channel)| channel));
        self
    }

    /// The signals at the times `n * period_s` under a command that is held from each sample to the next, with
    /// `substeps` steps of the integrator in a period. A sample shows the state just before its command acts.
    /// A command that acts later does so at its own instant, not at the next step.
    #[must_use]
    pub fn run(&self, period_s: f64, command: &[f64], substeps: usize) -> Outputs {
        let mut machine = Machine::new(self);
        let step = period_s / substeps as f64;
        let mut state = State::REST;
        let mut chain = Chain::new(&self.sensors, step);
        let mut out = Outputs::default();
        for n in 0..command.len() {
            if n > 0 {
                for sub in 0..substeps {
                    let from = (n as f64 - 1.0 + sub as f64 / substeps as f64) * period_s;
                    machine.spring_left = self.spring_left(from);
                    machine.warmer_k = self.warms_k_s * from;
                    // The number of the command that is in force; a billionth of a period is rounding.
                    let late = (from - self.command_delay_s) / period_s;
                    let at = (late + 1e-9).floor();
                    let until = ((at + 1.0 - late) * period_s).min(step);
                    let force = |index: f64| self.commanded(command[index.max(0.0) as usize], from);
                    let mut acceleration = machine.advance(&mut state, force(at), until);
                    if until < step * (1.0 - 1e-6) {
                        acceleration = machine.advance(&mut state, force(at + 1.0), step - until);
                    }
                    chain.pass(machine.measure(&state, &acceleration));
                }
            } else {
                chain.begin();
            }
            let [force_1, force_2, extension, deflection, link_2] = chain.show();
            out.force_1.push(force_1);
            out.force_2.push(force_2);
            out.extension.push(extension);
            out.deflection.push(deflection);
            out.link_2.push(link_2);
        }
        out
    }

    /// The motor's force for a command at a time.
    fn commanded(&self, command: f64, time_s: f64) -> f64 {
        let drawn = self.drive(command);
        let factor = match self.beyond {
            Some(Beyond::HotMotor { fall, time_constant_s }) => {
                1.0 + fall * (-time_s / time_constant_s).exp_m1()
            }
            Some(Beyond::DirectedGain { ratio }) => 1.0 + ratio * drawn.signum(),
            _ => 1.0,
        };
        factor * self.force_per_command * drawn
    }

    /// What the drive makes of a command.
    fn drive(&self, command: f64) -> f64 {
        let limited = command.clamp(-self.command_limit, self.command_limit);
        match self.count {
            // As in the product, a whole number of counts is one whatever its last digit's rounding.
            Some([count, rounding]) => {
                limited.signum() * count * (limited.abs() / count + 0.5 * rounding + 1e-9).floor()
            }
            None => limited,
        }
    }
}
