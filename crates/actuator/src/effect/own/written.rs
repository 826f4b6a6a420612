//! A law that is an expression: checked to be finite and to vanish somewhere, and put at its place.

use super::Expression;
use super::file::{ParameterFile, Place};
use super::laws::{BesideSpring, InDrive, OnOutput, OnRotor};
use crate::ActuatorError;
use crate::plant::{Link, Plant};
use sealegs_model::Parameter;
use std::collections::BTreeMap;

/// An expression at its place.
#[derive(Debug, Clone)]
pub(super) struct Written {
    pub place: Place,
    pub text: String,
    pub expression: Expression,
}

impl Written {
    /// Signs and sizes of the variables at which a law must be finite: rest, and ordinary and small motion.
    fn probes(&self) -> Vec<Vec<f64>> {
        let count = self.place.variables().len();
        let mut probes = vec![vec![0.0; count]];
        for (i, size) in [1.0, 1e-3, 30.0].into_iter().enumerate() {
            for signs in 0..(1 << count) {
                let value = |k: usize| {
                    let sign = if signs >> k & 1 == 1 { -1.0 } else { 1.0 };
                    // No two variables of the same size, so that nothing cancels by chance.
                    sign * size * (1.0 + 0.37 * (k + i) as f64)
                };
                probes.push((0..count).map(value).collect());
            }
        }
        probes
    }

    pub fn check_finite(&self, parameters: &[Parameter]) -> Result<(), ActuatorError> {
        let guess: Vec<f64> = parameters.iter().map(|p| p.value).collect();
        let mut sets = vec![guess.clone()];
        for (i, p) in parameters.iter().enumerate().filter(|(_, p)| !p.fixed) {
            for bound in [p.min, p.max] {
                let mut values = guess.clone();
                values[i] = bound;
                sets.push(values);
            }
        }
        for set in &sets {
            for probe in self.probes() {
                let all: Vec<f64> = probe.iter().chain(set).copied().collect();
                if let Err(fault) = self.expression.checked(&all) {
                    let names = self.place.variables().iter().copied();
                    let names = names.chain(parameters.iter().map(|p| p.name.as_str()));
                    let at: Vec<String> = names.zip(&all).map(|(n, v)| format!("{n} = {v}")).collect();
                    let admitted = format!(
                        "finite wherever it may be asked; at character {}: {}, with {}",
                        fault.character,
                        fault.message,
                        at.join(", ")
                    );
                    return Err(ActuatorError::value("law", format!("\"{}\"", self.text), admitted));
                }
            }
        }
        Ok(())
    }

    /// Finds where the effect vanishes: what the file says, else all parameters zero that may be zero.
    pub fn find_neutral(
        &self,
        said: &BTreeMap<String, ParameterFile>,
        parameters: &mut [Parameter],
    ) -> Result<(), ActuatorError> {
        let told = said.values().any(|p| p.neutral.is_some());
        let neutral: Vec<Option<f64>> = parameters
            .iter()
            .map(|p| match said.get(&p.name).and_then(|s| s.neutral) {
                Some(neutral) => Some(neutral),
                None if told || p.fixed || p.min > 0.0 || p.max < 0.0 => None,
                None => Some(0.0),
            })
            .collect();
        let at: Vec<f64> = parameters.iter().zip(&neutral).map(|(p, n)| n.unwrap_or(p.value)).collect();
        let law = self.expression.bind(self.place.variables().len(), &at);
        for probe in self.probes() {
            // A drive leaves the command as it is, everything else gives no force.
            let without = if self.place == Place::Drive { probe[0] } else { 0.0 };
            if law.value(&probe) != without {
                let admitted = if self.place == Place::Drive { "'u'" } else { "zero" };
                return Err(ActuatorError::value(
                    "law",
                    format!("\"{}\"", self.text),
                    format!(
                        "{admitted} where its parameters are neutral: let those that switch it off reach 0 \
                         within min and max, or give them 'neutral'"
                    ),
                ));
            }
        }
        for (parameter, neutral) in parameters.iter_mut().zip(neutral) {
            parameter.neutral = neutral;
        }
        Ok(())
    }

    pub fn install(&self, values: &[f64], plant: &mut Plant) {
        let law = self.expression.bind(self.place.variables().len(), values);
        let per_travel = 1.0 / plant.travel_per_rad;
        match self.place {
            Place::Rotor => plant.laws.rotor_forces.push(Box::new(OnRotor { law, per_travel })),
            Place::Drive => {
                let force_per_command = plant.force_per_command;
                plant.laws.drive_limits.push(Box::new(InDrive { law, per_travel, force_per_command }));
            }
            Place::Spring => {
                plant.laws.spring_forces.push(Box::new(BesideSpring { law, stiffness: plant.stiffness }));
            }
            Place::Output => {
                let link = plant.rigid.unwrap_or(plant.link_2);
                let arm = if let Link::Pendulum { arm_m, .. } = link { arm_m } else { 1.0 };
                plant.output_forces.push(Box::new(OnOutput { law, arm }));
            }
        }
    }
}
