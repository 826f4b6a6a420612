//! Output offset: a constant force or torque on the output.

use super::Effect;
use super::setting::{Setting, with_starts};
use crate::plant::{Link, Plant, RotorForce};
use sealegs_model::{EffectCard, Parameter};

/// A constant force or torque on the output.
#[derive(Debug)]
pub struct OutputOffset;

/// Name, unit and size of a force on the output: of a joint a torque, of what slides a force.
pub(super) fn on_output(setting: &Setting) -> (&'static str, &'static str, f64) {
    use super::ActuatorKind::{Linear, Rotary};
    match (setting.output_arm_m, setting.kind) {
        (Some(arm), _) => ("torque_nm", "N m", setting.force() * arm),
        (None, Rotary) => ("torque_nm", "N m", setting.force()),
        (None, Linear) => ("force_n", "N", setting.force()),
    }
}

/// The arm by which a force or torque on the output is referred to the axis, m; 1 without a lever.
pub(super) fn arm_of(plant: &Plant) -> f64 {
    let link = plant.rigid.unwrap_or(plant.link_2);
    if let Link::Pendulum { arm_m, .. } = link { arm_m } else { 1.0 }
}

impl Effect for OutputOffset {
    fn card(&self, setting: &Setting) -> EffectCard {
        let (name, unit, size) = on_output(setting);
        let parameters = vec![with_starts(
            Parameter {
                neutral: Some(0.0),
                typical: 0.02 * size,
                ..Parameter::new(name, unit, 0.02 * size, -2.0 * size, 2.0 * size)
            },
            [-0.02 * size, 0.15 * size, -0.15 * size],
        )];
        EffectCard {
            id: "output-offset".to_owned(),
            summary: "A constant force or torque on the output.".to_owned(),
            acts_on: "output joint".to_owned(),
            equation: "+ F_0 on the output".to_owned(),
            validity: "Positive where the output's position grows. A rig that is not level, a cable that pulls, or an \
                       offset of the drive; not told from an offset of the command where nothing limits that."
                .to_owned(),
            reference: "M. Gautier, W. Khalil 1988, Proc. IEEE CDC: the offset of identified joint models".to_owned(),
            parameters,
            symbols: "F_0: torque or force on the output".to_owned(),
            told_apart: "It has one sign and one size in both directions and at rest. Friction changes its sign with \
                         the direction, the pull of a cable changes with the position.".to_owned(),
            cure: "Level the rig, remove what pulls, set the sensor to zero; otherwise subtract the constant.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.output_forces.push(Box::new(Constant { force: values[0] / arm_of(plant) }));
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.output_moves
    }
}

#[derive(Debug)]
struct Constant {
    force: f64,
}

impl RotorForce for Constant {
    fn force(&self, _y: f64, _y_dot: f64, _load: f64, _t: f64) -> f64 {
        self.force
    }

    fn stored(&self, y: f64) -> f64 {
        -self.force * y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::Grid;

    #[test]
    fn analytic_a_free_mass_falls_by_it() {
        let mut plant = Plant::new(1.0, 0.0, 0.0, 0.0);
        plant.rigid = Some(Link::Mass(3.0));
        OutputOffset.install(&[-2.0], None, &mut plant);
        let grid = Grid { start_s: 0.0, step_s: 1e-3, steps: 1000 };
        let trace = plant.simulate(grid, &[0.0; 1000]).expect("finite");
        // x = F t^2 / (2 m).
        assert!((trace.screw_position[1000] + 0.25).abs() < 1e-12, "{}", trace.screw_position[1000]);
    }

    #[test]
    fn analytic_a_torque_is_referred_to_the_axis_by_the_arm() {
        let mut plant = Plant::new(1.0, 0.1, 0.0, 1e3);
        plant.link_2 = Link::Pendulum { inertia_kg_m2: 1.0, gravity_torque_nm: 1.0, arm_m: 0.1 };
        OutputOffset.install(&[0.5], None, &mut plant);
        assert_eq!(plant.output_forces[0].force(0.0, 0.0, 0.0, 0.0), 5.0);
    }
}
