//! Dry friction of all joints' rotors over a step, each found with the others acting.

use super::simulate::{Machine, State};
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

impl Machine {
    /// Finds the frictions of all joints' rotors over a step, and leaves as `load` what then passes to the links.
    pub(super) fn rub(&self, now: &mut State, h: f64) {
        now.friction.fill(0.0);
        self.transmit(now);
        for _ in 0..MOST_SWEEPS {
            let mut change = 0.0_f64;
            for (i, plant) in self.drives.iter().enumerate() {
                if plant.laws.rotor_friction.is_empty() && plant.laws.rotor_presliding.is_empty() {
                    continue;
                }
                let before = now.friction[i];
                let after = self.rubbing(now, i, h);
                change = change.max((after - before).abs() / (after.abs() + before.abs()).max(1e-12));
                now.friction[i] = after;
            }
            if change > 0.0 {
                self.transmit(now);
            }
            if change < 1e-12 {
                break;
            }
        }
    }

    /// The friction of a joint's rotor over a step, N m, with those of the others as they are.
    fn rubbing(&self, now: &mut State, i: usize, h: f64) -> f64 {
        let (c, laws) = (self.rotor[i], &self.drives[i].laws);
        let (mobility, v) = (h * now.matrix[(c, c)], now.v[c]);
        let beside = self.rotor.iter().zip(&now.friction).filter(|(other, _)| **other != c);
        let others: f64 = beside.map(|(other, friction)| now.matrix[(c, *other)] * friction).sum();
        let after_free = v + h * (now.free[c] + others);
        let (position, load, warmer_k) = (now.mid_q[c], now.load[i], now.warmer_k[i]);
        let of = &mut now.rubbed[i];
        for (k, element) in laws.rotor_presliding.iter().enumerate() {
            let beside = of.dry + of.elastic() - of.elastic[k];
            let travel = 0.5 * h * (v + after_free + mobility * beside);
            of.elastic[k] = -element.mean_force(of.presliding[k], travel, 0.5 * h * mobility);
        }
        if !laws.rotor_friction.is_empty() {
            let sliding = Sliding { before: v, after_free: after_free + mobility * of.elastic(), mobility };
            let heat = of.heat;
            of.dry = sliding.mean_force(|speed, direction| {
                laws.rotor_friction_bound(&Slip { position, speed, direction, load, heat, warmer_k })
            });
        }
        of.dry + of.elastic()
    }

    /// Writes the accelerations under the frictions as they are, rad/s^2, and what passes from each drive to the links, N m.
    fn transmit(&self, now: &mut State) {
        for i in 0..now.q.len() {
            let pushed =
                self.rotor.iter().zip(&now.friction).map(|(c, friction)| now.matrix[(i, *c)] * friction);
            now.accelerated[i] = now.free[i] + pushed.sum::<f64>();
        }
        let (by, mass) = (&now.accelerated, &now.equations.mass);
        for (i, c) in self.rotor.iter().enumerate() {
            now.load[i] = if *c == i {
                now.equations.bias[i] + (0..self.drives.len()).map(|j| mass[(i, j)] * by[j]).sum::<f64>()
            } else {
                now.passed[i].explicit + now.passed[i].implicit * (by[*c] - by[i])
            };
        }
    }
}
