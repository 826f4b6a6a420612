//! A bench linearised about an operating point, as state-space matrices from the command to every channel.

use super::{BenchModel, OUTPUTS};
use num_complex::Complex64;
use sealegs_model::{Model, ModelError};

/// `x' = A x + b u`, `channel = c x + d u` for small departures from an equilibrium. The state is the generalised
/// coordinates (the screw's extension first) and then their rates.
#[derive(Debug, Clone)]
pub struct StateSpace {
    /// `A`, by rows.
    pub a: Vec<Vec<f64>>,
    /// `b`, per unit of the input channel.
    pub b: Vec<f64>,
    /// The channels with their `c` and `d`.
    pub outputs: Vec<(String, Vec<f64>, f64)>,
    /// The coordinates at the equilibrium, m.
    pub at: Vec<f64>,
}

impl BenchModel {
    /// The bench with parameter `values` (in the order of the model's parameters) linearised about where it rests
    /// under a constant `command` on the channel `input`, before the sensors.
    ///
    /// # Errors
    ///
    /// Those of [`crate::plant::Plant::linearised`].
    pub fn linearised(&self, values: &[f64], input: &str, command: f64) -> Result<StateSpace, ModelError> {
        let plant = self.plant(values, input)?;
        let linear = plant.linearised(command)?;
        let n = linear.count;
        let mut a = vec![vec![0.0; 2 * n]; 2 * n];
        let mut b = vec![0.0; 2 * n];
        for i in 0..n {
            a[i][n + i] = 1.0;
            a[n + i][..n].copy_from_slice(&linear.by_position[i]);
            a[n + i][n..].copy_from_slice(&linear.by_velocity[i]);
            b[n + i] = linear.by_command[i];
        }
        let arm_m = self.bench.arm_m();
        let unit = |i: usize, scale: f64| {
            let mut row = vec![0.0; 2 * n];
            row[i] = scale;
            row
        };
        let join = |p: &[f64], v: &[f64]| -> Vec<f64> { p.iter().chain(v).copied().collect() };
        let still = vec![0.0; n];
        let stiffness = self.spec.coefficients().stiffness;
        let output = linear.link_2.or(self.spec.is_rigid().then_some(0));
        let row = |channel: &str| match channel {
            // The inertia force and weight of the load, which nothing but the drive and forces on the output move.
            "force_2_n" | "output_torque_nm" if self.spec.is_rigid() => {
                let mass = self.bench.links().1.mass_kg();
                let weight = plant.transmitted_force(linear.at[0] + 1e-6, 0.0)
                    - plant.transmitted_force(linear.at[0] - 1e-6, 0.0);
                let mut c = join(&linear.by_position[0], &linear.by_velocity[0]);
                c.iter_mut().for_each(|c| *c *= mass);
                c[0] += weight / 2e-6;
                (c, mass * linear.by_command[0])
            }
            "position_m" => (output.map_or(vec![0.0; 2 * n], |i| unit(i, 1.0)), 0.0),
            "speed_m_s" | "speed_rad_s" => (unit(n, 1.0 / arm_m), 0.0),
            "force_1_n" | "output_torque_nm" => (join(&linear.force_1.0, &linear.force_1.1), 0.0),
            "force_2_n" => (join(&linear.force_2.0, &linear.force_2.1), linear.force_2.2),
            "motor_angle_rad" => (unit(0, 1.0 / plant.travel_per_rad), 0.0),
            "joint_angle_rad" => (output.map_or(vec![0.0; 2 * n], |i| unit(i, 1.0 / arm_m)), 0.0),
            "spring_torque_nm" => {
                let scaled: Vec<f64> = linear.deflection.iter().map(|d| stiffness * d).collect();
                (join(&scaled, &still), 0.0)
            }
            _ => (join(&linear.deflection, &still), 0.0),
        };
        let outputs = OUTPUTS
            .iter()
            .filter(|channel| self.predicts(channel))
            .map(|channel| {
                let (c, d) = row(channel);
                ((*channel).to_owned(), c, d)
            })
            .collect();
        Ok(StateSpace { a, b, outputs, at: linear.at })
    }
}

impl StateSpace {
    /// The frequency response of a channel per unit of command, or `None` if there is no such channel or the
    /// frequency is that of an undamped mode.
    #[must_use]
    pub fn response(&self, channel: &str, frequency_hz: f64) -> Option<Complex64> {
        let (_, c, d) = self.outputs.iter().find(|(name, ..)| name == channel)?;
        let s = Complex64::new(0.0, std::f64::consts::TAU * frequency_hz);
        let n = self.b.len();
        // (s I - A) x = b by elimination with partial pivoting.
        let mut rows: Vec<Vec<Complex64>> = (0..n)
            .map(|i| {
                let cell = |j: usize| if i == j { s } else { Complex64::ZERO } - self.a[i][j];
                (0..n).map(cell).chain([Complex64::from(self.b[i])]).collect()
            })
            .collect();
        for column in 0..n {
            let pivot =
                (column..n).max_by(|&i, &j| rows[i][column].norm().total_cmp(&rows[j][column].norm()))?;
            if rows[pivot][column].norm() == 0.0 {
                return None;
            }
            rows.swap(column, pivot);
            let (above, below) = rows.split_at_mut(column + 1);
            for row in below {
                let factor = row[column] / above[column][column];
                for j in column..=n {
                    row[j] -= factor * above[column][j];
                }
            }
        }
        let mut x = vec![Complex64::ZERO; n];
        for i in (0..n).rev() {
            let known: Complex64 = (i + 1..n).map(|j| rows[i][j] * x[j]).sum();
            x[i] = (rows[i][n] - known) / rows[i][i];
        }
        Some(c.iter().zip(&x).map(|(c, x)| x * c).sum::<Complex64>() + d)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{Bench, PendulumRig};
    use crate::plant::GRAVITY_M_S2;
    use crate::response::{ForceResponse, Link};
    use crate::{ActuatorSpec, Configuration};
    use sealegs_model::Excitation;

    fn model(configuration: Configuration, bench: Bench) -> (BenchModel, Vec<f64>) {
        let mut spec = ActuatorSpec::preset("thor-linear").expect("preset");
        spec.configuration = configuration;
        let model = BenchModel::new(spec, bench).expect("good");
        let values = model.parameters().iter().map(|p| p.value).collect();
        (model, values)
    }

    #[test]
    fn analytic_agrees_with_the_closed_forms() {
        let rig = PendulumRig::default();
        let pendulum = Link::pendulum(rig.arm_m, rig.length_m, rig.mass_kg, GRAVITY_M_S2);
        let masses = Bench::Masses { link_1_kg: 20.0, link_2_kg: 68.0 };
        let cases = [
            (Bench::Locked, Link::Fixed, Link::Fixed),
            (Bench::Pendulum(rig), Link::Fixed, pendulum),
            (masses, Link::free(20.0), Link::free(68.0)),
        ];
        for configuration in
            [Configuration::SprungMotorHousing, Configuration::SprungBallNut, Configuration::Lumped]
        {
            for (bench, spring_side, screw_side) in cases {
                let (model, values) = model(configuration, bench);
                let c = model.spec().coefficients();
                let closed = ForceResponse::new(&c, spring_side, screw_side);
                let space = model.linearised(&values, "current_a", 0.0).expect("rests");
                for i in 0..60 {
                    let hz = 0.1 * 1.15_f64.powi(i);
                    let truth = [closed.sprung.at_hz(hz), closed.unsprung.at_hz(hz)];
                    for (channel, truth) in ["force_1_n", "force_2_n"].into_iter().zip(truth) {
                        let got = space.response(channel, hz).expect("a channel") / c.force_constant;
                        let error = (got - truth).norm() / truth.norm();
                        assert!(error < 1e-9, "{configuration:?} {bench:?} {channel} {hz} Hz: {error}");
                    }
                }
            }
        }
    }

    #[test]
    fn analytic_hardening_spring_and_swung_pendulum() {
        let (base, _) = model(Configuration::SprungMotorHousing, Bench::Locked);
        let hard = base.with_effect("hardening-spring", &Excitation::default()).expect("an effect");
        let values: Vec<f64> = hard.parameters().iter().map(|p| p.value).collect();
        let mut spec = base.spec().clone();
        spec.effects = vec![crate::spec::EffectSpec {
            id: "hardening-spring".to_owned(),
            parameters: std::collections::BTreeMap::new(),
            definition: None,
        }];
        let hard = BenchModel::new(spec, Bench::Locked).expect("good");
        let mut values = values;
        *values.last_mut().expect("cubic") = 5e10;
        let space = hard.linearised(&values, "current_a", 4.0).expect("rests");
        let (k, y) = (655e3, space.at[0]);
        let force = base.spec().coefficients().force_constant * 4.0;
        assert!((k * y + 5e10 * y.powi(3) - force).abs() < 1e-8 * force);
        let total = base.spec().coefficients().total_mass();
        assert!((space.a[1][0] * total / (k + 1.5e11 * y * y) + 1.0).abs() < 1e-6);

        // A push of 240 N on 0.0725 m against 11.772 N m: the gravity's stiffness falls with the cosine.
        let (swung, values) =
            model(Configuration::SprungMotorHousing, Bench::Pendulum(PendulumRig::default()));
        let space = swung.linearised(&values, "current_a", 0.3).expect("rests");
        let angle: f64 = space.at[1] / 0.0725;
        let torque = swung.spec().coefficients().force_constant * 0.3 * 0.0725;
        assert!((4.0 * 9.81 * 0.3 * angle.sin() - torque).abs() < 1e-7, "{angle}");
        assert!(swung.linearised(&values, "current_a", 4.0).is_err(), "it turns over");
    }

    #[test]
    fn a_free_mass_under_a_push_has_no_equilibrium() {
        let bench = Bench::Masses { link_1_kg: f64::INFINITY, link_2_kg: 68.0 };
        let (model, values) = model(Configuration::SprungMotorHousing, bench);
        assert!(model.linearised(&values, "current_a", 1.0).is_err());
        assert!(model.linearised(&values, "current_a", 0.0).is_ok());
    }
}
