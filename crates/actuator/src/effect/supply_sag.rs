//! Supply sag: the supply's own resistance lowers its voltage under load.

use super::Effect;
use super::setting::{Setting, magnitude, with_neutral, with_starts};
use crate::plant::{DriveLimit, Plant, Winding};
use sealegs_model::EffectCard;

/// The supply's own resistance lowers its voltage under load.
#[derive(Debug)]
pub struct SupplySag;

impl Effect for SupplySag {
    fn card(&self, setting: &Setting) -> EffectCard {
        let winding = setting.winding.map_or(1.0, |w| w.resistance_ohm);
        let resistance = magnitude("resistance_ohm", "ohm", 0.1 * winding, 1e-4 * winding, 5.0 * winding);
        EffectCard {
            id: "supply-sag".to_owned(),
            summary: "The supply's own resistance lowers its voltage under load.".to_owned(),
            acts_on: "drive".to_owned(),
            equation: "V = d (V_0 - R_s d I) with I = (V - K_tau theta') / R, d the duty".to_owned(),
            validity: "The bridge draws the duty's share of the motor's current. Not beside a logged supply, which sags \
                       by itself."
                .to_owned(),
            reference: "R. W. Erickson, D. Maksimovic, Fundamentals of Power Electronics: the averaged bridge as a \
                        transformer of ratio d"
                .to_owned(),
            parameters: vec![with_neutral(with_starts(resistance, [0.02 * winding, 0.5 * winding]), 0.0)],
            symbols: "V: voltage at the motor; V_0: nominal supply; R_s: resistance; I: current; R: winding; K_tau \
                      theta': back-EMF".to_owned(),
            told_apart: "A wrong winding resistance takes in proportion to the current, this one to the current and \
                         the duty squared. Record high current at low and at high speed, or log supply_v: then it is \
                         no longer needed.".to_owned(),
            cure: "Shorter and thicker leads, a stiffer supply, capacitors at the drive, or a drive that \
                   compensates the measured supply.".to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        let Some(winding) = plant.winding.filter(|_| values[0] > 0.0) else { return };
        plant.laws.drive_limits.push(Box::new(Sag { winding, resistance: values[0] }));
    }

    fn applies(&self, setting: &Setting) -> bool {
        setting.has_bridge()
    }
}

#[derive(Debug)]
struct Sag {
    winding: Winding,
    resistance: f64,
}

impl DriveLimit for Sag {
    fn limit(&self, commanded: f64, y_dot: f64) -> f64 {
        let Winding { force_per_current, resistance_ohm, supply_v } = self.winding;
        let asked = self.winding.volts(commanded, y_dot);
        let duty = asked / supply_v;
        let share = self.resistance * duty * duty / resistance_ohm;
        let volts = (asked + share * force_per_current * y_dot) / (1.0 + share);
        self.winding.force(volts, y_dot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_full_duty_puts_both_resistances_in_series() {
        let winding = Winding { force_per_current: 0.3, resistance_ohm: 2.0, supply_v: 10.0 };
        let law = Sag { winding, resistance: 0.5 };
        let both = Winding { resistance_ohm: 2.5, ..winding };
        for speed in [0.0, 7.0] {
            let force = law.limit(winding.force(10.0, speed), speed);
            assert!((force - both.force(10.0, speed)).abs() < 1e-12);
        }
        // At half the duty the supply carries half the current: a quarter of its resistance.
        let quarter = Winding { resistance_ohm: 2.125, ..winding };
        assert!((law.limit(winding.force(5.0, 0.0), 0.0) - quarter.force(5.0, 0.0)).abs() < 1e-12);
    }
}
