//! Cable stiffness: cables and hoses across the output joint pull it back towards where they are slack.

use super::Effect;
use super::output_offset::{arm_of, on_output};
use super::setting::{ActuatorKind, Quantity, Setting, with_starts};
use crate::plant::{Plant, RotorForce};
use sealegs_model::{EffectCard, Parameter};

/// Cables and hoses across the output joint, as a spring beside it.
#[derive(Debug)]
pub struct CableStiffness;

impl Effect for CableStiffness {
    fn card(&self, setting: &Setting) -> EffectCard {
        let turns = setting.output_arm_m.is_some() || setting.kind == ActuatorKind::Rotary;
        // In the joint's own units where there is a joint.
        let at_joint = Setting {
            kind: if turns { ActuatorKind::Rotary } else { ActuatorKind::Linear },
            ..setting.clone()
        };
        let (_, _, size) = on_output(setting);
        let travel = setting.travel() / setting.output_arm_m.unwrap_or(1.0);
        let k = size / travel;
        let rest = at_joint.amount("rest", Quantity::Length, 0.25 * travel, 2.0 * travel);
        let parameters = vec![
            with_starts(
                at_joint.amount("stiffness", Quantity::Stiffness, 0.02 * k, 5.0 * k),
                [0.1 * k, 0.5 * k],
            ),
            with_starts(
                Parameter { value: 0.0, min: -2.0 * travel, neutral: None, ..rest },
                [0.5 * travel, -0.5 * travel],
            ),
        ];
        EffectCard {
            id: "cable-stiffness".to_owned(),
            summary: "Cables and hoses across the output joint, as a spring beside it.".to_owned(),
            acts_on: "output joint".to_owned(),
            equation: "- k_c (x - x_0) on the output".to_owned(),
            validity: "x_0 is where they are slack. Without hysteresis; a constant pull alone is output-offset.".to_owned(),
            reference: "Robot dress packs as a joint stiffness: W. Khalil, E. Dombre 2002, Modeling, Identification and \
                        Control of Robots, chapter 12"
                .to_owned(),
            parameters,
            symbols: "k_c: stiffness; x_0: rest; x: position of the output".to_owned(),
            told_apart: "It grows in proportion to the position. Output-offset does not change with it, and the \
                         torque of gravity follows the sine of the angle. Slow motion over the whole range tells them \
                         apart.".to_owned(),
            cure: "Lead cables and hoses through the joint's axis, with slack. Otherwise feed the pull forward \
                   over the angle.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        let arm = arm_of(plant);
        plant
            .output_forces
            .push(Box::new(Cable { stiffness: values[0] / (arm * arm), rest: values[1] * arm }));
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.output_moves
    }
}

#[derive(Debug)]
struct Cable {
    stiffness: f64,
    rest: f64,
}

impl RotorForce for Cable {
    fn force(&self, y: f64, _y_dot: f64, _load: f64, _t: f64) -> f64 {
        self.stiffness * (self.rest - y)
    }

    fn stored(&self, y: f64) -> f64 {
        0.5 * self.stiffness * (y - self.rest).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{Grid, Link};

    #[test]
    fn analytic_swings_about_where_it_is_slack() {
        let mut plant = Plant::new(1.0, 0.0, 0.0, 0.0);
        plant.rigid = Some(Link::Mass(3.0));
        CableStiffness.install(&[16.0, 0.5], None, &mut plant);
        let grid = Grid { start_s: 0.0, step_s: 1e-3, steps: 4000 };
        let trace = plant.simulate(grid, &[0.0; 4000]).expect("finite");
        for (n, x) in trace.screw_position.iter().enumerate() {
            let truth = 0.5 * (1.0 - (2.0 * n as f64 * 1e-3).cos());
            // The scheme's second order at a step of 1/3000 of the period.
            assert!((x - truth).abs() < 1e-5, "{n}: {x} {truth}");
        }
    }
}
