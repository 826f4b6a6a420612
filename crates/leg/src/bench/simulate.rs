//! The motion of a robot's joints under their drives, step by step.
//!
//! A step takes mass matrix and bias at the middle of the predicted motion, viscous damping implicitly and dry friction
//! joint after joint until none changes what the others see: of second order where nothing slips or sticks.

use super::observed::Pulls;
use super::tree::{Equations, Tree};
use nalgebra::{DMatrix, DVector};
use sealegs_actuator::plant::{Grid, MOST_PRESLIDING, Plant, Sliding, Slip};
use sealegs_model::ModelError;

/// A robot and its drives with their values in place.
pub(super) struct Machine {
    pub tree: Tree,
    /// Joint by joint.
    pub drives: Vec<Plant>,
}

/// Motion and torques of one joint at the points of a grid.
#[derive(Debug, Clone, Default)]
pub(super) struct JointTrace {
    pub position: Vec<f64>,
    pub speed: Vec<f64>,
    /// Motor torque over the step that ends at the point, N m.
    pub motor: Vec<f64>,
    /// Torque that passes from the drive to the links, N m.
    pub load: Vec<f64>,
    /// Torque of the observer's pull over the step that ends at the point, N m; 0 without an observer.
    pub pulled: Vec<f64>,
}

/// Sweeps over the joints' frictions; two joints need about ten.
const MOST_SWEEPS: usize = 60;

/// What friction remembers of a joint.
#[derive(Debug, Clone, Copy, Default)]
struct Rubbed {
    dry: f64,
    presliding: [f64; MOST_PRESLIDING],
    elastic: [f64; MOST_PRESLIDING],
    heat: f64,
}

impl Rubbed {
    /// Of all elastic elements, N m.
    fn elastic(&self) -> f64 {
        self.elastic.iter().sum()
    }
}

impl Machine {
    /// The motion from `start` (position and speed by joint) under the mean `commands` over each step, joint by joint;
    /// with `pulls` each joint is pulled to its measured motion.
    ///
    /// # Errors
    ///
    /// [`ModelError::NotFinite`] when a joint runs away, [`ModelError::BadParameter`] for a mass matrix that has no
    /// inverse.
    pub fn run(
        &self,
        start: &[(f64, f64)],
        commands: &[Vec<f64>],
        pulls: Option<&Pulls>,
        grid: Grid,
        names: &[String],
    ) -> Result<Vec<JointTrace>, ModelError> {
        let (n, h) = (self.drives.len(), grid.step_s);
        let mut q: Vec<f64> = start.iter().map(|s| s.0).collect();
        let mut v: Vec<f64> = start.iter().map(|s| s.1).collect();
        let mut a = vec![0.0; n];
        let mut rubbed = vec![Rubbed::default(); n];
        let mut equations = self.tree.equations();
        let mut traces = vec![JointTrace::default(); n];
        let mut load = vec![0.0; n];
        let mut motor = vec![0.0; n];
        let mut pulled = vec![0.0; n];
        let (mut mid_q, mut mid_v) = (vec![0.0; n], vec![0.0; n]);
        for step in 0..=grid.steps {
            for (i, trace) in traces.iter_mut().enumerate() {
                trace.position.push(q[i]);
                trace.speed.push(v[i]);
                trace.motor.push(motor[i]);
                trace.load.push(load[i]);
                trace.pulled.push(pulled[i]);
            }
            if step == grid.steps {
                break;
            }
            if let Some(i) = (0..n).find(|&i| !(q[i].is_finite() && v[i].is_finite())) {
                let what = format!("the position of joint {}", names[i]);
                return Err(ModelError::NotFinite { time_s: grid.time(step), what });
            }
            for i in 0..n {
                mid_q[i] = q[i] + 0.5 * h * v[i] + 0.125 * h * h * a[i];
                mid_v[i] = v[i] + 0.5 * h * a[i];
            }
            self.tree.at(&mid_q, &mid_v, &mut equations);
            let t = grid.time(step) + 0.5 * h;
            let mut matrix: DMatrix<f64> = equations.mass.clone();
            let mut force = DVector::zeros(n);
            for (i, plant) in self.drives.iter().enumerate() {
                matrix[(i, i)] += plant.reflected_inertia + 0.5 * h * plant.damping;
                motor[i] = plant.motor_force(commands[i].get(step).copied().unwrap_or(0.0), mid_v[i]);
                let outside: f64 =
                    plant.output_forces.iter().map(|f| f.force(mid_q[i], mid_v[i], load[i], t)).sum();
                force[i] = motor[i] + plant.laws.rotor_force(mid_q[i], mid_v[i], load[i], t) + outside
                    - equations.bias[i]
                    - plant.damping * v[i];
            }
            if let Some(pulls) = pulls {
                pulls.torques(step, (&mid_q, &mid_v), |i, j| self.inertia(&equations, i, j), &mut pulled);
                force.iter_mut().zip(&pulled).for_each(|(force, pull)| *force += pull);
            }
            let Some(inverse) = matrix.try_inverse() else {
                let admitted = "such that every joint moves some mass";
                return Err(ModelError::BadParameter {
                    name: "mass matrix".to_owned(),
                    value: 0.0,
                    admitted,
                });
            };
            let free = &inverse * force;
            let friction = self.rub(
                &Rub { q: &mid_q, v: &v, free: &free, inverse: &inverse, h },
                &equations.mass,
                &equations.bias,
                &mut load,
                &mut rubbed,
            );
            for i in 0..n {
                let gained: f64 = (0..n).map(|j| inverse[(i, j)] * friction[j]).sum();
                let size = v[i].abs() + h * (free[i].abs() + gained.abs());
                let mut after = v[i] + h * (free[i] + gained);
                // What rounding leaves of a speed that friction has just stopped is not a motion.
                if friction[i] != 0.0 && after.abs() <= 1e-11 * size {
                    after = 0.0;
                }
                let travel = if v[i] == 0.0 && after == 0.0 { 0.0 } else { 0.5 * h * (v[i] + after) };
                for (force, element) in
                    rubbed[i].presliding.iter_mut().zip(&self.drives[i].laws.rotor_presliding)
                {
                    *force = element.advance(*force, travel);
                }
                rubbed[i].heat -= rubbed[i].dry * travel;
                a[i] = (after - v[i]) / h;
                q[i] += travel;
                v[i] = after;
            }
        }
        Ok(traces)
    }

    /// An entry of the mass matrix with the drives' reflected inertia, kg m^2.
    fn inertia(&self, equations: &Equations, i: usize, j: usize) -> f64 {
        equations.mass[(i, j)] + if i == j { self.drives[i].reflected_inertia } else { 0.0 }
    }

    /// The frictions of all joints over a step, N m. `load` is left as what passes to the links.
    fn rub(
        &self,
        at: &Rub,
        mass: &DMatrix<f64>,
        bias: &[f64],
        load: &mut [f64],
        rubbed: &mut [Rubbed],
    ) -> Vec<f64> {
        let n = self.drives.len();
        let mut friction = vec![0.0; n];
        let transmitted = |friction: &[f64], load: &mut [f64]| {
            for i in 0..n {
                load[i] = bias[i];
                for j in 0..n {
                    let gained: f64 = (0..n).map(|k| at.inverse[(j, k)] * friction[k]).sum();
                    load[i] += mass[(i, j)] * (at.free[j] + gained);
                }
            }
        };
        transmitted(&friction, load);
        for _ in 0..MOST_SWEEPS {
            let mut change = 0.0_f64;
            for (i, plant) in self.drives.iter().enumerate() {
                let laws = &plant.laws;
                if laws.rotor_friction.is_empty() && laws.rotor_presliding.is_empty() {
                    continue;
                }
                let mobility = at.h * at.inverse[(i, i)];
                let others: f64 = (0..n).filter(|j| *j != i).map(|j| at.inverse[(i, j)] * friction[j]).sum();
                let after_free = at.v[i] + at.h * (at.free[i] + others);
                let of = &mut rubbed[i];
                for (k, element) in laws.rotor_presliding.iter().enumerate() {
                    let beside = of.dry + of.elastic() - of.elastic[k];
                    let travel = 0.5 * at.h * (at.v[i] + after_free + mobility * beside);
                    of.elastic[k] = -element.mean_force(of.presliding[k], travel, 0.5 * at.h * mobility);
                }
                if !laws.rotor_friction.is_empty() {
                    let sliding = Sliding {
                        before: at.v[i],
                        after_free: after_free + mobility * of.elastic(),
                        mobility,
                    };
                    let (position, load, heat) = (at.q[i], load[i], of.heat);
                    of.dry = sliding.mean_force(|speed, direction| {
                        laws.rotor_friction_bound(&Slip {
                            position,
                            speed,
                            direction,
                            load,
                            heat,
                            ..Slip::default()
                        })
                    });
                }
                let now = of.dry + of.elastic();
                change = change.max((now - friction[i]).abs() / (now.abs() + friction[i].abs()).max(1e-12));
                friction[i] = now;
            }
            transmitted(&friction, load);
            if change < 1e-12 {
                break;
            }
        }
        friction
    }
}

/// What the frictions of a step see.
struct Rub<'a> {
    q: &'a [f64],
    v: &'a [f64],
    /// Accelerations without friction.
    free: &'a DVector<f64>,
    inverse: &'a DMatrix<f64>,
    h: f64,
}
