//! The effects that an actuator's file states, put into the model.

use super::{BenchModel, OUTPUTS};
use crate::ActuatorError;
use crate::spec::EffectSpec;
use sealegs_model::{Excitation, Model, ModelError, SignalRange};
use std::sync::Arc;

impl BenchModel {
    /// Puts the effects of the file with their values into the model, in its order.
    ///
    /// # Errors
    ///
    /// [`ActuatorError::Value`] for an effect that is not known or a parameter that the effect does not have.
    pub(super) fn take_stated(&mut self) -> Result<(), ActuatorError> {
        let spec = Arc::clone(&self.spec);
        for effect in &spec.effects {
            let unknown = |field: String, value: &str, admitted: String| {
                ActuatorError::value(format!("effect.{field}"), value.to_owned(), admitted)
            };
            let before = self.parameters.len();
            *self = self.including_stated(effect).map_err(|e| {
                unknown("id".to_owned(), &effect.id, format!("an effect of the catalogue: {e}"))
            })?;
            effect.state_all(&mut self.parameters[before..]).map_err(|(name, all)| {
                unknown(format!("{}.{name}", effect.id), name, format!("a parameter of this effect: {all}"))
            })?;
        }
        Ok(())
    }

    /// The model with an effect. What a command counts in names some parameters (`count_a` of a current, `count_v` of a voltage),
    /// and a file does not say what its drive is commanded by: it is the first input under which the effect has all the
    /// parameters that are stated.
    fn including_stated(&self, effect: &EffectSpec) -> Result<Self, ModelError> {
        let has_all = |model: &Self| {
            let has =
                |name: &String| model.parameters.iter().any(|p| p.name == format!("{}.{name}", effect.id));
            effect.parameters.keys().all(has)
        };
        let usual = self.including(&effect.id, &commanded_by(None));
        if usual.as_ref().is_ok_and(has_all) {
            return usual;
        }
        let others = self
            .inputs()
            .iter()
            .filter_map(|input| self.including(&effect.id, &commanded_by(Some(input))).ok());
        others.into_iter().find(has_all).map_or(usual, Ok)
    }
}

/// Runs of which no more is known than their command, if that is.
fn commanded_by(input: Option<&str>) -> Excitation {
    let command = input.map(|name| SignalRange { name: name.to_owned(), min: -1.0, max: 1.0, rms: 1.0 });
    let measured = OUTPUTS.map(str::to_owned).to_vec();
    Excitation { measured, ranges: command.into_iter().collect(), ..Excitation::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ActuatorSpec;
    use crate::bench::{Bench, PendulumRig};
    use crate::spec::EffectValue;

    /// Whatever a drive is commanded by, `add` writes a file that `compare` reads.
    #[test]
    fn every_effect_that_a_bench_can_have_is_read_as_it_is_written() {
        let rigs = [
            ("thor-linear", Bench::Locked),
            ("thor-linear", Bench::Pendulum(PendulumRig::default())),
            ("rmd-x8-rotary-sea", Bench::Locked),
            ("rigid-linear", Bench::Free { load: 10.0 }),
            ("hobby-servo", Bench::Free { load: 0.01 }),
        ];
        for (preset, bench) in rigs {
            let spec = ActuatorSpec::preset(preset).expect("a preset");
            let model = BenchModel::new(spec.clone(), bench).expect("a model");
            for input in model.inputs() {
                let seen = commanded_by(Some(input));
                for card in model.effects(&seen) {
                    let what = format!("{preset}, {input}, {}", card.id);
                    let with = model.including(&card.id, &seen).unwrap_or_else(|e| panic!("{what}: {e}"));
                    let values: Vec<f64> = with.parameters.iter().map(|p| p.value).collect();
                    let effects = with.effect_specs(&values, &[]);
                    let written = BenchModel::new(ActuatorSpec { effects, ..spec.clone() }, bench);
                    let written = written.unwrap_or_else(|e| panic!("{what}: {e}"));
                    let names = |model: &BenchModel| -> Vec<String> {
                        model.parameters.iter().map(|p| p.name.clone()).collect()
                    };
                    assert_eq!(names(&written), names(&with), "{what}");
                }
            }
        }
    }

    #[test]
    fn a_count_is_one_of_what_the_drive_is_commanded_by() {
        let stated = |preset: &str, bench, name: &str| {
            let spec = ActuatorSpec::preset(preset).expect("a preset");
            let parameters = [(name.to_owned(), EffectValue { value: 0.02, std: None })].into();
            let effects =
                vec![EffectSpec { id: "command-quantisation".to_owned(), parameters, definition: None }];
            BenchModel::new(ActuatorSpec { effects, ..spec }, bench)
        };
        let sprung = ("thor-linear", Bench::Locked);
        let servo = ("hobby-servo", Bench::Free { load: 0.01 });
        for ((preset, bench), name) in [(sprung, "count"), (sprung, "count_a"), (servo, "count_v")] {
            let model = stated(preset, bench, name).unwrap_or_else(|e| panic!("{name}: {e}"));
            let full = format!("command-quantisation.{name}");
            assert!(model.parameters.iter().any(|p| p.name == full && p.value == 0.02), "{name}");
        }
        let refused =
            stated("thor-linear", Bench::Locked, "counts").expect_err("no such parameter").to_string();
        let says = "counts: must be a parameter of this effect: count_a, rounding";
        assert!(refused.ends_with(says), "{refused}");
    }
}
