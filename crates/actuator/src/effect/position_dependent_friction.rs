//! Position-dependent friction: dry friction whose level repeats along the screw.

use super::Effect;
use super::setting::{Quantity, Setting, with_starts};
use crate::plant::{DryFriction, Plant, Slip};
use sealegs_model::{EffectCard, Parameter, SimplerAt, SimplerLaw};
use std::f64::consts::TAU;

/// Shortest period that is tried, in turns of the screw, and the ratio of each to the one before.
const SHORTEST: f64 = 0.2;
/// See [`SHORTEST`].
const APART: f64 = 1.15;

/// Dry friction that rises and falls along the screw.
#[derive(Debug)]
pub struct PositionDependentFriction;

impl Effect for PositionDependentFriction {
    fn card(&self, setting: &Setting) -> EffectCard {
        let (force, travel) = (setting.force(), setting.travel());
        let turn = TAU * setting.travel_per_rad;
        let variation = Parameter { typical: 0.2, ..Parameter::new("variation", "", 0.8, 0.0, 1.0) };
        let place = setting.amount("place", Quantity::Length, 0.05 * turn, 2.0 * travel.max(turn));
        // A ball that comes round, a turn of the screw, the whole travel. Between two periods that differ by more than half a
        // wave along the travel nothing leads from one to the other.
        let longest = 4.0 * travel.max(turn);
        let periods = std::iter::successors(Some(SHORTEST * turn), |p| Some(APART * p));
        let periods = periods.take_while(move |p| *p < longest);
        let parameters = vec![
            setting.amount("force", Quantity::Force, 0.03 * force, 2.0 * force),
            variation,
            with_starts(setting.magnitude("period", Quantity::Length, turn, 0.02 * turn, longest), periods),
            Parameter {
                neutral: None,
                min: -place.max,
                ..with_starts(place, [0.3 * turn, 0.55 * turn, 0.8 * turn])
            },
        ];
        EffectCard {
            id: "position-dependent-friction".to_owned(),
            summary: "Dry friction that rises and falls along the screw.".to_owned(),
            acts_on: "rotor".to_owned(),
            equation: "F_c (1 + a cos(2 pi (y - y_0) / L)) sign(y'); at rest it balances the applied force up to that"
                .to_owned(),
            validity: "Opposes the screw's motion; holds without creep. One wave along the screw, a between 0 and 1; y is \
                       counted from where the run begins."
                .to_owned(),
            reference: "B. Armstrong-Helouvry 1991, Control of Machines with Friction, chapter 5: position-dependent \
                        friction of gears and screws"
                .to_owned(),
            parameters,
            symbols: "F_c: force; a: variation; L: period; y_0: place of the greatest friction; y: extension of the \
                      screw; y': its speed"
                .to_owned(),
            told_apart: "Torque ripple pushes the same way in both directions of motion, this one turns round with it. \
                         Coulomb friction is the same all along. Slow motion to and fro over the same way tells them \
                         apart."
                .to_owned(),
            cure: "A table of the friction over the screw's position in the feedforward; straighten or align the \
                   screw, clean and re-preload its nut."
                .to_owned(),
            passive: true,
            becomes: Some(SimplerLaw { id: "coulomb-friction", departure: 1, at: SimplerAt::Zero, beside: None }),
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        let [force, variation, period, place] = [values[0], values[1], values[2], values[3]];
        plant.laws.rotor_friction.push(Box::new(AlongScrew { force, variation, period, place }));
    }

    fn friction_bound(&self, values: &[f64]) -> Option<String> {
        let [force, variation, period, place] = [values[0], values[1], values[2], values[3]];
        Some(format!("{force:?} * (1 + {variation:?} * cos(2 * pi * (y - ({place:?})) / {period:?}))"))
    }
}

#[derive(Debug)]
struct AlongScrew {
    force: f64,
    variation: f64,
    period: f64,
    place: f64,
}

impl DryFriction for AlongScrew {
    fn bound(&self, slip: &Slip) -> f64 {
        let wave = (TAU * (slip.position - self.place) / self.period).cos();
        self.force * (1.0 + self.variation * wave)
    }

    fn feels_speed(&self) -> bool {
        false
    }

    fn feels_load(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{Grid, Link};

    #[test]
    fn analytic_a_mass_that_slides_has_lost_the_integral_along_its_way() {
        let (mass, speed, values) = (2.0, 0.4, [1.5, 0.6, 0.03, 0.011]);
        let mut plant = Plant::new(mass, 0.0, 0.0, 0.0);
        plant.rigid = Some(Link::Mass(0.0));
        plant.start = (0.0, speed);
        PositionDependentFriction.install(&values, None, &mut plant);
        let grid = Grid { start_s: 0.0, step_s: 1e-4, steps: 8000 };
        let trace = plant.simulate(grid, &[0.0; 8000]).expect("finite");
        let [force, variation, period, place] = values;
        let along = |y: f64| period / TAU * (TAU * (y - place) / period).sin();
        let lost = |y: f64| force * (y + variation * (along(y) - along(0.0)));
        let end = trace.screw_position[8000];
        assert_eq!(trace.screw_speed[8000], 0.0);
        assert!((lost(end) / (0.5 * mass * speed * speed) - 1.0).abs() < 1e-4, "{end} {}", lost(end));
    }
}
