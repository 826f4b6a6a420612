//! An actuator on a bench as numbers and terms, from which every writer writes.

use crate::ExportError;
use crate::term::{Included, Term, parameters_of};
use sealegs_actuator::bench::{Bench, BenchModel, OUTPUTS};
use sealegs_actuator::plant::{GRAVITY_M_S2, Plant};
use sealegs_actuator::{Kind, spec::SensorSpec};
use sealegs_model::Model;
use std::collections::BTreeMap;

/// What the screw's end is attached to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Output {
    /// The world.
    Held,
    /// A point mass on a lever, in gravity.
    Pendulum {
        mass_kg: f64,
        length_m: f64,
        /// Screw travel per angle of the lever, m/rad.
        arm_m: f64,
    },
}

/// An actuator on a bench. SI, at the screw or at the output of a rotary actuator.
#[derive(Debug, Clone)]
pub struct BenchDescription {
    pub name: String,
    pub kind: Kind,
    /// The command's channel.
    pub input: String,
    /// Reflected rotor inertia.
    pub inertia: f64,
    pub sprung_mass: f64,
    pub damping: f64,
    pub stiffness: f64,
    /// Stiffness by which a logger turns a deflection into a torque.
    pub nominal_stiffness: f64,
    pub travel_per_rad: f64,
    /// Motor force per command.
    pub gain: f64,
    /// Constant motor force beside the command's.
    pub offset_force: f64,
    pub gravity_m_s2: f64,
    pub output: Output,
    /// What the bench's sensors show.
    pub channels: Vec<&'static str>,
    pub effects: Vec<Included>,
    /// What is known of the sensors' gain and bias.
    pub sensors: BTreeMap<String, SensorSpec>,
    /// Whether a logger's row tells the command of the period before it, and by how much of a period it is late.
    pub logger: (bool, f64),
}

impl BenchDescription {
    /// The numbers of a model's file.
    ///
    /// # Errors
    ///
    /// [`ExportError::Bench`] or [`ExportError::Model`].
    pub fn of(model: &BenchModel, input: &str) -> Result<Self, ExportError> {
        let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
        let plant = model.plant(&values, input)?;
        let output = match model.bench() {
            Bench::Locked => Output::Held,
            Bench::Pendulum(rig) if rig.rod_mass_kg == 0.0 => {
                // Of a point mass weight and inertia, as effects have changed them, tell mass and place.
                let (is, stated) = (plant.link_2, rig.link());
                let inertia = is.mass_kg() / stated.mass_kg();
                let weight = is.stiffness_n_m() / stated.stiffness_n_m();
                Output::Pendulum {
                    mass_kg: rig.mass_kg * weight * weight / inertia,
                    length_m: rig.length_m * inertia / weight,
                    arm_m: rig.arm_m,
                }
            }
            // Benches to come are refused rather than written wrongly.
            _ => return Err(ExportError::Bench { model: model.name() }),
        };
        Ok(Self::of_plant(model, &values, &plant, input, output))
    }

    /// The numbers of a drive at parameter `values`, of which `plant` was made.
    pub fn of_plant(model: &BenchModel, values: &[f64], plant: &Plant, input: &str, output: Output) -> Self {
        let included = |effect: sealegs_actuator::spec::EffectSpec| {
            let parameters = parameters_of(&effect.id, model.parameters(), values);
            let term = Term::of(&effect.id, &parameters, effect.definition.as_ref());
            Included { id: effect.id, term }
        };
        let value =
            |name: &str| model.parameters().iter().position(|p| p.name == name).map_or(0.0, |i| values[i]);
        Self {
            name: model.name(),
            kind: model.spec().kind,
            input: input.to_owned(),
            inertia: plant.reflected_inertia,
            sprung_mass: plant.sprung_mass,
            damping: plant.damping,
            stiffness: plant.stiffness,
            nominal_stiffness: model.spec().spring.stiffness(),
            travel_per_rad: plant.travel_per_rad,
            gain: plant.force_per_command,
            offset_force: plant.force_per_command * plant.command_offset,
            gravity_m_s2: GRAVITY_M_S2,
            output,
            channels: OUTPUTS.into_iter().filter(|c| model.predicts(c)).collect(),
            effects: model.effect_specs(values, &[]).into_iter().map(included).collect(),
            sensors: model.spec().sensors.clone(),
            logger: (value("command_lead") > 0.5, value("clock_skew")),
        }
    }

    /// The terms with their ids.
    pub fn terms(&self) -> impl Iterator<Item = (&str, &Term)> {
        self.effects.iter().map(|e| (e.id.as_str(), &e.term))
    }

    /// The sum of what a term contributes.
    pub fn sum(&self, of: impl Fn(&Term) -> Option<f64>) -> f64 {
        self.effects.iter().filter_map(|e| of(&e.term)).sum()
    }

    /// The first term of a kind.
    pub fn find<T>(&self, of: impl Fn(&Term) -> Option<T>) -> Option<T> {
        self.effects.iter().find_map(|e| of(&e.term))
    }

    /// Cubic stiffness of the spring.
    pub fn cubic(&self) -> f64 {
        self.sum(|t| if let Term::Hardening { cubic } = t { Some(*cubic) } else { None })
    }

    /// Viscous damping beside the spring.
    pub fn spring_damping(&self) -> f64 {
        self.sum(|t| if let Term::SpringDamping { damping } = t { Some(*damping) } else { None })
    }

    /// Width of the play in the spring's path.
    pub fn gap(&self) -> f64 {
        self.sum(|t| if let Term::Backlash { gap } = t { Some(*gap) } else { None })
    }

    /// Dry friction of the output's joint, N m.
    pub fn output_friction(&self) -> f64 {
        self.sum(|t| if let Term::OutputFriction { torque } = t { Some(*torque) } else { None })
    }

    /// The series compliance: stiffness and the mass that it carries.
    pub fn series(&self) -> Option<(f64, f64)> {
        self.find(|t| match *t {
            Term::Series { stiffness, mass } if stiffness.is_finite() => Some((stiffness, mass)),
            _ => None,
        })
    }

    /// The greatest command that the drive follows, in the command's unit.
    pub fn command_limit(&self) -> Option<f64> {
        let limits = self.effects.iter().filter_map(|e| match e.term {
            Term::CommandLimit { limit } if limit.is_finite() => Some(limit),
            _ => None,
        });
        limits.reduce(f64::min)
    }

    /// How late a command acts, s.
    pub fn delay_s(&self) -> f64 {
        self.sum(|t| if let Term::Delay { delay_s } = t { Some(*delay_s) } else { None })
    }
}
