//! Base motion: the rig's mounting yields and has a mode of its own.

use super::Effect;
use super::setting::{Quantity, Setting, magnitude, with_neutral, with_starts};
use crate::plant::{Link, Plant};
use sealegs_model::EffectCard;
use std::f64::consts::TAU;

/// The mounting of the spring side as a mass on a spring and a damper.
#[derive(Debug)]
pub struct BaseMotion;

impl Effect for BaseMotion {
    fn card(&self, setting: &Setting) -> EffectCard {
        let (mass, natural_hz) = (setting.total_mass, setting.natural_hz());
        let frequency =
            magnitude("frequency_hz", "Hz", 3.0 * natural_hz, 0.2 * natural_hz, setting.nyquist_hz());
        let parameters = vec![
            with_neutral(
                with_starts(frequency, [0.8, 1.5, 6.0, 12.0].map(|ratio| ratio * natural_hz)),
                f64::INFINITY,
            ),
            with_starts(
                setting.magnitude("base", Quantity::Inertia, 0.3 * mass, 1e-3 * mass, 1e2 * mass),
                [0.03 * mass, 3.0 * mass],
            ),
            magnitude("damping_ratio", "", 0.05, 1e-3, 1.0),
        ];
        EffectCard {
            id: "base-motion".to_owned(),
            summary: "The rig's mounting yields: its frame moves as a mass on a spring and a damper.".to_owned(),
            acts_on: "mounting of link 1".to_owned(),
            equation: "m_b x_1'' + 2 zeta w m_b x_1' + w^2 m_b x_1 = -F_1, w = 2 pi frequency".to_owned(),
            validity: "One mode along the axis at the spring side, which is otherwise held; the pivot of a pendulum stays \
                       where it is. Sensors are fixed to the frame."
                .to_owned(),
            reference: "J. P. Den Hartog, Mechanical Vibrations, section 3: two degrees of freedom".to_owned(),
            parameters,
            symbols: "m_b: base; w: angular frequency; zeta: damping_ratio; x_1: position of link 1; F_1: force of \
                      the spring on link 1, positive in compression".to_owned(),
            told_apart: "Far below its frequency it is a softer spring, and a compliance in series on the screw side looks \
                         alike. Excite it around its frequency, or put an accelerometer or a dial gauge on the \
                         frame: it must stand still."
                .to_owned(),
            cure: "Bolt the rig to more mass, stiffen the frame and its feet, or measure the frame's motion and take \
                   it into the model."
                .to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        let (w, mass_kg) = (TAU * values[0], values[1]);
        if w.is_finite() && plant.link_1 == Link::Fixed && plant.rigid.is_none() {
            let damping_n_s_m = 2.0 * values[2] * w * mass_kg;
            plant.link_1 = Link::Mounted { mass_kg, stiffness_n_m: w * w * mass_kg, damping_n_s_m };
        }
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.has_spring && setting.base_is_held
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{Grid, sample};

    #[test]
    fn analytic_a_slow_push_moves_the_frame_by_its_stiffness() {
        // 12 N on the spring of 1000 N/m and the mounting of (2 pi 5)^2 3 = 2960.9 N/m in series.
        let mut plant = Plant::new(0.5, 0.1, 40.0, 1000.0);
        BaseMotion.install(&[5.0, 3.0, 0.4], None, &mut plant);
        let grid = Grid { start_s: 0.0, step_s: 1e-3, steps: 6000 };
        let trace = plant.simulate(grid, &[12.0; 6000]).expect("finite");
        let mounting = (TAU * 5.0).powi(2) * 3.0;
        let at_end = |values: &[f64]| sample(values, &grid, &[6.0], 0.0)[0];
        assert!((at_end(&trace.screw_position) / (12.0 / 1000.0 + 12.0 / mounting) - 1.0).abs() < 1e-6);
        assert!((at_end(&trace.deflection) / 0.012 - 1.0).abs() < 1e-6);
        assert!((at_end(&trace.link_1_position) / (-12.0 / mounting) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn analytic_a_step_of_the_motor_rings_in_both_modes() {
        // Without damping: a y'' = 20 N - k (x_1 + y), m_b x_1'' = -k (x_1 + y) - k_b x_1, a = m_J + m_s.
        let (a, k, base, push) = (5.0, 4000.0, 2.0, 20.0);
        let mounting = (TAU * 8.0).powi(2) * base;
        let mut plant = Plant::new(4.6, 0.4, 0.0, k);
        BaseMotion.install(&[8.0, base, 0.0], None, &mut plant);
        let grid = Grid { start_s: 0.0, step_s: 1e-3, steps: 2000 };
        let trace = plant.simulate(grid, &[push; 2000]).expect("finite");
        // The squared frequencies are the roots of a m_b l^2 - (a (k + k_b) + m_b k) l + k k_b.
        let half = 0.5 * (a * (k + mounting) + base * k);
        let root = (half * half - a * base * k * mounting).sqrt();
        let truth = |t: f64| -> f64 {
            let mode = |square: f64| {
                // Of the mode's shape (1, r), r = (a l - k) / k.
                let r = (a * square - k) / k;
                r * push / (a + base * r * r) * (1.0 - (square.sqrt() * t).cos()) / square
            };
            mode((half - root) / (a * base)) + mode((half + root) / (a * base))
        };
        let size = trace.link_1_position.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for (n, x) in trace.link_1_position.iter().enumerate() {
            let wanted = truth(grid.time(n));
            assert!((x - wanted).abs() < 1e-8 * size, "{n}: {x} {wanted}");
        }
    }
}
