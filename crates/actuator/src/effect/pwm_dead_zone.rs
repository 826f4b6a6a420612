//! PWM dead zone: a bridge gives no voltage below some duty, and that much less above it.

use super::Effect;
use super::setting::{Setting, with_starts};
use crate::plant::{DriveLimit, Plant, Winding};
use sealegs_model::{EffectCard, Parameter};

/// The bridge gives no voltage below some duty.
#[derive(Debug)]
pub struct PwmDeadZone;

impl Effect for PwmDeadZone {
    fn card(&self, _setting: &Setting) -> EffectCard {
        let duty = Parameter {
            neutral: Some(0.0),
            typical: 0.01,
            ..Parameter::new("dead_duty", "", 0.02, 0.0, 0.5)
        };
        EffectCard {
            id: "pwm-dead-zone".to_owned(),
            summary: "The bridge gives no voltage below some duty, and that much less above it.".to_owned(),
            acts_on: "drive".to_owned(),
            equation: "d - clamp(d, -d_0, d_0), d the voltage over the nominal supply".to_owned(),
            validity: "The dead time of the bridge's switches, averaged over a period of the PWM.".to_owned(),
            reference: "S.-G. Jeong, M.-H. Park 1991, IEEE Trans. Industrial Electronics 38(2): dead-time effects in PWM \
                        inverters"
                .to_owned(),
            parameters: vec![with_starts(duty, [0.005, 0.08])],
            symbols: "d: duty; d_0: dead_duty".to_owned(),
            told_apart: "It takes the same share of the voltage at every command, whichever way the motor turns. \
                         Coulomb friction acts against the motion: let the load drive the motor, and the two differ \
                         in sign.".to_owned(),
            cure: "Add the dead duty to the command by its sign: the dead-time compensation of many drives.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        let Some(winding) = plant.winding.filter(|_| values[0] > 0.0) else { return };
        let volts = values[0] * winding.supply_v;
        plant.laws.drive_limits.push(Box::new(DeadZone { winding, volts }));
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.has_bridge()
    }
}

#[derive(Debug)]
struct DeadZone {
    winding: Winding,
    volts: f64,
}

impl DriveLimit for DeadZone {
    fn limit(&self, commanded: f64, y_dot: f64) -> f64 {
        let asked = self.winding.volts(commanded, y_dot);
        // Not `clamp` alone: a state that runs away must stay no number.
        self.winding.force(asked - asked.max(-self.volts).min(self.volts), y_dot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_small_voltages_leave_the_brake_of_the_back_emf() {
        let winding = Winding { force_per_current: 0.3, resistance_ohm: 2.0, supply_v: 10.0 };
        let law = DeadZone { winding, volts: 0.5 };
        let force = |volts: f64| law.limit(winding.force(volts, 4.0), 4.0);
        assert!((force(0.4) - winding.force(0.0, 4.0)).abs() < 1e-12);
        assert!((force(-2.0) - winding.force(-1.5, 4.0)).abs() < 1e-12);
    }
}
