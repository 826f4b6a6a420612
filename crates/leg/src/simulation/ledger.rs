//! Samples and the energy balance: where energy is, and what has brought or taken it.

use super::Simulation;
use crate::dynamics::coupling::ActuatorPower;
use nalgebra::DVector;

/// Height, m, over which the weight of all bodies does as much work as the energy in motion is taken to be at least: where
/// nothing moves, as a hand that hangs straight down, a residual is rounding and compares with nothing.
const AT_REST_M: f64 = 1e-6;

impl Simulation {
    /// What of a sample is known before the step: poses and positions.
    pub(super) fn begin_sample(&mut self, time_s: f64) -> (DVector<f64>, nalgebra::DMatrix<f64>, f64) {
        let s = &mut self.sample;
        s.time_s = time_s;
        s.joint_angles_rad.clone_from(&self.engine.q);
        s.world_from_link.clear();
        let states = &self.engine.states;
        s.world_from_link.extend(self.tree.links.iter().map(|(b, from_link)| states[*b].pose * from_link));
        (self.engine.velocity().clone(), self.engine.mass_matrix(), self.engine.potential_energy())
    }

    /// The rest of the sample, with the velocity in the middle.
    pub(super) fn end_sample(&mut self, velocity: &DVector<f64>, bodies_j: f64, potential_j: f64) {
        let e = &mut self.energy;
        e.kinetic_j = bodies_j + self.powers.iter().map(|p| p.kinetic_j).sum::<f64>();
        e.potential_j = potential_j;
        e.spring_j = self.powers.iter().map(|p| p.spring_j).sum();
        let total = e.kinetic_j + e.potential_j + e.spring_j;
        if self.steps == 0 {
            e.initial_j = total;
            self.initial_potential_j = potential_j;
            e.turnover_j = AT_REST_M * self.engine.weight();
        }
        e.residual_j = total - e.initial_j - e.work_j();
        let moving = e.kinetic_j + e.spring_j + (self.initial_potential_j - potential_j).abs();
        e.turnover_j = e.turnover_j.max(moving);
        let s = &mut self.sample;
        s.energy = *e;
        s.joint_speeds_rad_s.clear();
        s.joint_speeds_rad_s.extend((0..self.engine.q.len()).map(|dof| velocity[self.engine.column(dof)]));
        s.actuators.clone_from(&self.instants);
        s.stresses_pa.clear();
        s.stresses_pa.extend(
            self.leg.actuators.iter().zip(&self.instants).map(|(m, a)| m.limits.stress_pa(a.spring_force_n)),
        );
        s.drive_torques_nm.clear();
        s.drive_torques_nm.extend(self.servos.iter().map(|d| d.torque_nm));
        s.ground = self.ground;
    }

    /// Adds the works since the instant before, by the mean of both ends.
    pub(super) fn account(&mut self) {
        let sum = |f: &dyn Fn(&ActuatorPower) -> f64| self.powers.iter().map(f).sum::<f64>();
        let now = [
            sum(&|p| p.motor),
            sum(&|p| p.rotor_losses),
            sum(&|p| p.spring_losses),
            self.contact.as_ref().map_or(0.0, |c| c.power(&self.engine, self.step_s)),
            self.stops.power(&self.engine, self.step_s),
            self.servos.iter().map(|s| s.power(&self.engine, self.step_s)).sum(),
            sum(&|p| p.sprung_mass),
        ];
        if self.steps > 0 {
            let e = &mut self.energy;
            let works = [
                &mut e.motor_work_j,
                &mut e.rotor_loss_j,
                &mut e.spring_loss_j,
                &mut e.ground_work_j,
                &mut e.joint_work_j,
                &mut e.drive_work_j,
                &mut e.sprung_mass_work_j,
            ];
            for ((work, now), before) in works.into_iter().zip(&now).zip(&self.power_before) {
                *work += 0.5 * self.step_s * (now + before);
            }
        }
        self.power_before = now;
    }
}
