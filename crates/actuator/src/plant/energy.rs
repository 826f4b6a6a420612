//! Where the energy of a motion is, and what the motor put in: a check on everything that only takes energy out.

use super::integrate::{State, Stepper, dot};
use super::linear::{LinearPart, MOST};
use super::{GRAVITY_M_S2, Grid, Link, Plant};
use sealegs_model::ModelError;

/// Energies at the points of a grid, J.
#[derive(Debug, Clone, Default)]
pub struct EnergyLedger {
    /// Of motion.
    pub kinetic: Vec<f64>,
    /// In springs, elastic elements and height.
    pub stored: Vec<f64>,
    /// What the motor has put in since the start, after the drive's limits.
    pub motor_work: Vec<f64>,
}

impl Plant {
    /// The energies of the motion that [`Plant::simulate`] gives. Passive effects keep `kinetic + stored` at or
    /// below `motor_work`, up to the integrator's error.
    ///
    /// The energy of a spring that is not linear is the integral of its force without damping over deflection, by
    /// Simpson's rule in 256 parts.
    ///
    /// # Errors
    ///
    /// As [`Plant::simulate`].
    pub fn energy(&self, grid: Grid, commands: &[f64]) -> Result<EnergyLedger, ModelError> {
        let linear = LinearPart::of(self);
        match linear.coordinates.count {
            1 => self.ledger::<1>(&linear, grid, commands),
            2 => self.ledger::<2>(&linear, grid, commands),
            3 => self.ledger::<3>(&linear, grid, commands),
            4 => self.ledger::<4>(&linear, grid, commands),
            _ => self.ledger::<MOST>(&linear, grid, commands),
        }
    }

    fn ledger<const N: usize>(
        &self,
        linear: &LinearPart,
        grid: Grid,
        commands: &[f64],
    ) -> Result<EnergyLedger, ModelError> {
        let stepper = Stepper::<N>::new(self, linear, grid)?;
        let mut ledger = EnergyLedger::default();
        let mut state = stepper.rest();
        let mut work = 0.0;
        for n in 0..=grid.steps {
            let (kinetic, stored) = self.energies(linear, &state);
            ledger.kinetic.push(kinetic);
            ledger.stored.push(stored);
            ledger.motor_work.push(work);
            if n < grid.steps {
                let next = stepper.step(&state, commands.get(n).copied().unwrap_or(0.0), n);
                stepper.check(&next, n)?;
                work += next.motor * (next.motion.position[0] - state.motion.position[0]);
                state = next;
            }
        }
        Ok(ledger)
    }

    fn energies<const N: usize>(&self, linear: &LinearPart, state: &State<N>) -> (f64, f64) {
        let (q, v) = (&state.motion.position, &state.motion.velocity);
        let (mut kinetic, mut stored) = (0.0, 0.0);
        for i in 0..N {
            for j in 0..N {
                kinetic += 0.5 * v[i] * linear.mass[i][j] * v[j];
                stored += 0.5 * q[i] * linear.stiffness[i][j] * q[j];
            }
        }
        stored += self.laws.rotor_forces.iter().map(|f| f.stored(q[0])).sum::<f64>();
        if let Some(i) = linear.coordinates.link_2.or(self.rigid.map(|_| 0)) {
            stored += self.output_forces.iter().map(|f| f.stored(q[i])).sum::<f64>();
        }
        let row: [f64; N] = std::array::from_fn(|i| linear.deflection[i]);
        let delta = dot(&row, q);
        if !(self.laws.spring_path.is_empty() && self.laws.spring_forces.is_empty()) {
            stored += self.spring_energy(delta, state.time_s) - 0.5 * self.stiffness * delta * delta;
        }
        let elastic = self.laws.rotor_presliding.iter().zip(state.presliding);
        for (element, force) in elastic.chain(self.laws.spring_slip.iter().map(|e| (e, state.spring_slip))) {
            stored += 0.5 * force * force / element.stiffness;
        }
        if let (Link::Pendulum { gravity_torque_nm, arm_m, .. }, Some(i)) =
            (self.rigid.unwrap_or(self.link_2), linear.coordinates.link_2.or(self.rigid.map(|_| 0)))
        {
            let angle = q[i] / arm_m;
            // What the linear stiffness has too much: 1 - cos against half the square.
            let beyond = 1.0 - angle.cos() - 0.5 * angle * angle;
            stored += gravity_torque_nm * beyond;
            if let (Some(wobbling), Some(w)) = (self.wobbling, linear.coordinates.wobbling) {
                let weight = wobbling.mass * GRAVITY_M_S2;
                stored += weight * (wobbling.radius * beyond + q[w] * (angle.sin() - angle));
            }
        }
        (kinetic, stored)
    }

    fn spring_energy(&self, delta: f64, t: f64) -> f64 {
        const PARTS: usize = 256;
        let width = delta / PARTS as f64;
        let weight = |i: usize| match i {
            0 | PARTS => 1.0,
            i if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        (0..=PARTS).map(|i| weight(i) * self.spring_force(width * i as f64, 0.0, t)).sum::<f64>() * width
            / 3.0
    }
}
