//! Torque ripple: a motor force that repeats with the rotor angle (cogging).

use super::Effect;
use super::setting::{Quantity, Setting, with_starts};
use crate::plant::{Plant, RotorForce};
use sealegs_model::{EffectCard, Parameter};

/// Cogging of the motor: a force that repeats with the rotor angle.
#[derive(Debug)]
pub struct TorqueRipple;

impl Effect for TorqueRipple {
    fn card(&self, setting: &Setting) -> EffectCard {
        let force = setting.force();
        // A part of a wave is an offset with a slope.
        let fewest = setting.turns().map_or(FEWEST, |turns| (1.0 / turns).clamp(FEWEST, MOST));
        let guess = fewest.max(7.0);
        let parameters = vec![
            setting.amount("amplitude", Quantity::Force, 0.05 * force, force),
            with_starts(
                Parameter { typical: 0.02, ..Parameter::new("cycles_per_rev", "", guess, fewest, MOST) },
                (1..=48).map(f64::from),
            ),
            Parameter { typical: 0.3, ..Parameter::new("phase_rad", "rad", 0.0, -TURN, TURN) },
        ];
        EffectCard {
            id: "torque-ripple".to_owned(),
            summary: "Cogging of the motor: a force that repeats with the rotor angle.".to_owned(),
            acts_on: "rotor".to_owned(),
            equation: "F_m + A sin(N theta + phase)".to_owned(),
            validity: "Positive lengthens the screw; N whole cycles per turn of the rotor.".to_owned(),
            reference: "D. Hanselman, Brushless Permanent-Magnet Motor Design, chapter on cogging".to_owned(),
            parameters,
            symbols: "A: amplitude; N: cycles_per_rev; theta: rotor angle; F_m: motor force".to_owned(),
            told_apart: "The residual repeats with the rotor's angle; that of a structural mode repeats with time, at \
                         one frequency whatever the speed. Slow, even motion over several turns tells them apart.".to_owned(),
            cure: "A table of the force over the rotor angle in the feedforward, better commutation in the \
                   current loop, or a motor with skewed magnets.".to_owned(),
            passive: false,
            becomes: None,
        }
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.turns().is_none_or(|turns| turns * MOST > 1.0)
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.laws.rotor_forces.push(Box::new(Ripple {
            amplitude: values[0],
            per_extension: values[1] / plant.travel_per_rad,
            phase: values[2],
        }));
    }
}

/// Fewest cycles per turn of the rotor that are tried, where that turns often enough to show them.
const FEWEST: f64 = 0.5;

/// Most of them.
const MOST: f64 = 100.0;

/// Twice the range that a phase needs, so that a search does not end at a bound on its way around.
const TURN: f64 = std::f64::consts::TAU;

#[derive(Debug)]
struct Ripple {
    amplitude: f64,
    per_extension: f64,
    phase: f64,
}

impl RotorForce for Ripple {
    fn force(&self, y: f64, _y_dot: f64, _load: f64, _t: f64) -> f64 {
        self.amplitude * (self.per_extension * y + self.phase).sin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sealegs_model::{SignalRange, internal};
    use std::f64::consts::TAU;

    #[test]
    fn analytic_a_wave_of_which_less_than_one_was_travelled_is_not_looked_for() {
        let turned = |max: f64| {
            let name = internal::ROTOR_ANGLE.to_owned();
            let mut setting = Setting::unknown();
            setting.seen.ranges = vec![SignalRange { name, min: 0.0, max, rms: max }];
            (TorqueRipple.card(&setting).parameters.swap_remove(1), TorqueRipple.applies(&setting))
        };
        let (cycles, applies) = turned(3.0 * TAU);
        assert_eq!((cycles.min, cycles.starts.len(), applies), (0.5, 48, true));
        let (cycles, applies) = turned(0.1 * TAU);
        assert!((cycles.min - 10.0).abs() < 1e-9 && cycles.starts[0] >= cycles.min && applies);
        assert_eq!(cycles.value, cycles.min);
        assert!(!turned(0.005 * TAU).1);
    }

    #[test]
    fn analytic_repeats_with_the_rotor() {
        let law = Ripple { amplitude: 5.0, per_extension: 7.0 / 1e-4, phase: 0.4 };
        let turn = std::f64::consts::TAU * 1e-4;
        let f = |y: f64| law.force(y, 0.0, 0.0, 0.0);
        assert!((f(0.3e-3) - f(0.3e-3 + turn / 7.0)).abs() < 1e-9);
        assert!((f(0.0) - 5.0 * 0.4_f64.sin()).abs() < 1e-12);
    }
}
