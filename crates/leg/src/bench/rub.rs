//! Dry friction of all joints' rotors over a step, each found with the others acting.

use super::simulate::{Machine, Passed};
use super::tree::Equations;
use nalgebra::{DMatrix, DVector};
use sealegs_actuator::plant::{Laws, MOST_PRESLIDING, Sliding, Slip};

/// Sweeps over the joints' frictions; two joints need about ten.
const MOST_SWEEPS: usize = 60;

/// What friction remembers of a joint.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rubbed {
    dry: f64,
    presliding: [f64; MOST_PRESLIDING],
    elastic: [f64; MOST_PRESLIDING],
    heat: f64,
}

impl Rubbed {
    /// Of all elastic elements, N.
    fn elastic(&self) -> f64 {
        self.elastic.iter().sum()
    }

    /// After the rotor has travelled so far, rad.
    pub fn advance(&mut self, laws: &Laws, travel: f64) {
        for (force, element) in self.presliding.iter_mut().zip(&laws.rotor_presliding) {
            *force = element.advance(*force, travel);
        }
        self.heat -= self.dry * travel;
    }
}

/// What the frictions of a step see.
pub(super) struct Rub<'a> {
    /// Mean positions over the step.
    pub q: &'a [f64],
    /// Speeds at its start.
    pub v: &'a [f64],
    /// Accelerations without friction.
    pub free: &'a DVector<f64>,
    pub inverse: &'a DMatrix<f64>,
    /// Through the transmissions that yield, joint by joint.
    pub passed: &'a [Passed],
    pub warmer_k: &'a [f64],
    pub h: f64,
}

impl Machine {
    /// The frictions of all joints' rotors over a step, N m. `load` is left as what passes to the links.
    pub(super) fn rub(
        &self,
        at: &Rub,
        equations: &Equations,
        load: &mut [f64],
        rubbed: &mut [Rubbed],
    ) -> Vec<f64> {
        let n = self.drives.len();
        let mut friction = vec![0.0; n];
        self.transmitted(at, equations, &friction, load);
        for _ in 0..MOST_SWEEPS {
            let mut change = 0.0_f64;
            for (i, plant) in self.drives.iter().enumerate() {
                let laws = &plant.laws;
                if laws.rotor_friction.is_empty() && laws.rotor_presliding.is_empty() {
                    continue;
                }
                let c = self.rotor[i];
                let mobility = at.h * at.inverse[(c, c)];
                let beside = (0..n).filter(|j| *j != i);
                let others: f64 = beside.map(|j| at.inverse[(c, self.rotor[j])] * friction[j]).sum();
                let after_free = at.v[c] + at.h * (at.free[c] + others);
                let of = &mut rubbed[i];
                for (k, element) in laws.rotor_presliding.iter().enumerate() {
                    let beside = of.dry + of.elastic() - of.elastic[k];
                    let travel = 0.5 * at.h * (at.v[c] + after_free + mobility * beside);
                    of.elastic[k] = -element.mean_force(of.presliding[k], travel, 0.5 * at.h * mobility);
                }
                if !laws.rotor_friction.is_empty() {
                    let sliding = Sliding {
                        before: at.v[c],
                        after_free: after_free + mobility * of.elastic(),
                        mobility,
                    };
                    let (position, load, heat, warmer_k) = (at.q[c], load[i], of.heat, at.warmer_k[i]);
                    of.dry = sliding.mean_force(|speed, direction| {
                        laws.rotor_friction_bound(&Slip { position, speed, direction, load, heat, warmer_k })
                    });
                }
                let now = of.dry + of.elastic();
                change = change.max((now - friction[i]).abs() / (now.abs() + friction[i].abs()).max(1e-12));
                friction[i] = now;
            }
            self.transmitted(at, equations, &friction, load);
            if change < 1e-12 {
                break;
            }
        }
        friction
    }

    /// What passes from each drive to the links under such frictions, N m.
    fn transmitted(&self, at: &Rub, equations: &Equations, friction: &[f64], load: &mut [f64]) {
        let n = self.drives.len();
        let gained: Vec<f64> = (0..at.free.len())
            .map(|i| {
                let rubbed: f64 = (0..n).map(|k| at.inverse[(i, self.rotor[k])] * friction[k]).sum();
                at.free[i] + rubbed
            })
            .collect();
        for i in 0..n {
            let c = self.rotor[i];
            load[i] = if c == i {
                equations.bias[i] + (0..n).map(|j| equations.mass[(i, j)] * gained[j]).sum::<f64>()
            } else {
                at.passed[i].explicit + at.passed[i].implicit * (gained[c] - gained[i])
            };
        }
    }
}
