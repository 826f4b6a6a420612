//! Voltage saturation: the bus voltage less the back-EMF limits the motor current.

use super::Effect;
use super::setting::{CommandKind, Setting, magnitude, with_neutral, with_starts};
use crate::plant::{DriveLimit, Plant};
use sealegs_model::EffectCard;

/// The bus voltage minus the back-EMF limits the current.
#[derive(Debug)]
pub struct VoltageSaturation;

impl Effect for VoltageSaturation {
    fn card(&self, setting: &Setting) -> EffectCard {
        // K_tau / r is the force per current, so that K_tau theta' = (K_tau / r) y'.
        let back_emf = setting.force_per_command * setting.speed();
        let peak = setting.command();
        let bus = 48.0_f64.max(back_emf);
        let resistance = bus / (1.5 * peak);
        let parameters = vec![
            with_neutral(
                with_starts(magnitude("bus_v", "V", bus, 0.05 * bus, 20.0 * bus), [0.5 * bus, 0.25 * bus]),
                f64::INFINITY,
            ),
            with_starts(
                magnitude("resistance_ohm", "ohm", resistance, 0.02 * resistance, 50.0 * resistance),
                // The current at standstill, bus over resistance, from a little above the greatest command down,
                // for each start of the bus.
                [1.0, 0.5, 0.25]
                    .into_iter()
                    .flat_map(|bus| [0.8, 0.95, 1.1, 1.3, 1.6, 2.2].map(|over| bus * over))
                    .map(|ratio| 1.5 * ratio * resistance),
            ),
        ];
        EffectCard {
            id: "voltage-saturation".to_owned(),
            summary: "The bus voltage minus the back-EMF limits the current.".to_owned(),
            acts_on: "drive".to_owned(),
            equation: "I clipped to (+-V_bus - K_tau theta') / R".to_owned(),
            validity: "Matters at high speed and current; the winding's inductance is left out.".to_owned(),
            reference: "D. Hanselman, Brushless Permanent-Magnet Motor Design; dissertation section 4-7"
                .to_owned(),
            parameters,
            symbols: "I: current; V_bus: bus; R: resistance; K_tau theta': back-EMF".to_owned(),
            told_apart:
                "It cuts only where the motion is fast. Current saturation does not depend on the speed: \
                         record the same command at standstill and in fast motion."
                    .to_owned(),
            cure: "A higher bus voltage, a winding with fewer turns or slower motion. Anti-windup in the \
                   controller."
                .to_owned(),
            passive: true,
            becomes: None,
        }
    }

    fn install(&self, values: &[f64], _channel: Option<&str>, plant: &mut Plant) {
        plant.laws.drive_limits.push(Box::new(Voltage {
            bus: values[0],
            resistance: values[1],
            force_per_current: plant.force_per_command,
        }));
    }

    /// The back-EMF of a drive that takes a force or torque command cannot be told in volts, and that of one that takes
    /// a voltage is in the base model.
    fn applies(&self, setting: &Setting) -> bool {
        matches!(setting.command, CommandKind::Current | CommandKind::Unknown)
            && setting.force_per_command != 1.0
    }
}

#[derive(Debug)]
struct Voltage {
    bus: f64,
    resistance: f64,
    force_per_current: f64,
}

impl DriveLimit for Voltage {
    fn limit(&self, commanded: f64, y_dot: f64) -> f64 {
        if !self.bus.is_finite() {
            return commanded;
        }
        let back_emf = self.force_per_current * y_dot;
        let current = |volts: f64| self.force_per_current * (volts - back_emf) / self.resistance;
        // Not `clamp`, which refuses bounds that are no numbers: a simulation that diverges ends with an error of its own.
        commanded.max(current(-self.bus)).min(current(self.bus))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_back_emf_leaves_less_one_way() {
        let law = Voltage { bus: 48.0, resistance: 2.0, force_per_current: 240.0 };
        // 0.1 m/s is 24 V of back-EMF: between -36 A and 12 A are left.
        assert_eq!(law.limit(20.0 * 240.0, 0.1), 12.0 * 240.0);
        assert_eq!(law.limit(-20.0 * 240.0, 0.1), -20.0 * 240.0);
    }

    #[test]
    fn a_winding_without_resistance_holds_the_rotor() {
        let spec = crate::ActuatorSpec::preset("thor-linear").unwrap();
        let bench = crate::bench::BenchModel::new(spec, crate::bench::Bench::Locked).unwrap();
        let seen = sealegs_model::Excitation::default();
        let mut model = sealegs_model::Model::with_effect(&bench, "voltage-saturation", &seen).unwrap();
        let time_s: Vec<f64> = (0..4000).map(|n| f64::from(n) * 1e-3).collect();
        let values = time_s.iter().map(|t| (60.0 * t).sin()).collect();
        let record = sealegs_model::Record {
            cut: false,
            name: "swing".to_owned(),
            time_s,
            hold: sealegs_model::InputHold::ZeroOrder,
            inputs: vec![sealegs_model::Signal { channel: "current_a".to_owned(), values }],
            outputs: Vec::new(),
        };
        // No winding has so little resistance: in one step its back-EMF brakes the rotor many times over.
        let values: Vec<f64> = model
            .parameters()
            .iter()
            .map(|p| match p.name.as_str() {
                "voltage-saturation.resistance_ohm" => 1e-6,
                "voltage-saturation.bus_v" => 1e-3,
                _ => p.value,
            })
            .collect();
        model = model.coarser(4.0);
        let force = model.predict(&values, &record, &["force_1_n".to_owned()]).unwrap();
        let most = force.outputs[0].values.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        assert!(most < 1.0, "{most}");
    }
}
