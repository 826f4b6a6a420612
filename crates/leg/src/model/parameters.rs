//! The base parameters of a leg: of every actuator and of the sole's contact, by place.

use super::Case;
use crate::LegError;
use crate::effect::FOOT;
use crate::robot::Robot;
use crate::scenario::Scenario;
use crate::simulation::{actuator_coefficients, actuator_spec};
use sealegs_actuator::Coefficients;
use sealegs_actuator::spec::EffectValue;
use sealegs_model::Parameter;

/// What may be fitted of each actuator.
const OF_ACTUATOR: [&str; 4] = ["stiffness", "reflected_inertia", "damping", "force_constant"];

/// A part further from nominal than this many standard deviations is no individual of its kind: that is an effect.
const FARTHEST_STDS: f64 = 5.0;

/// Name, unit, and standard deviation as a ratio of what is known of the contact's numbers: estimates. What is
/// further off is the effect `contact-compliance`.
const OF_CONTACT: [(&str, &str, f64); 2] =
    [("contact_stiffness", "N/m^n", 0.06), ("contact_damping", "s/m", 0.1)];

/// The base parameters of a scenario's leg, called `<actuator>/stiffness` and so on.
pub(super) fn of(scenario: &Scenario, robot: &Robot) -> Result<Vec<Parameter>, LegError> {
    let mut all = Vec::new();
    for placement in &robot.actuators {
        let Some(own) = &placement.spec else { continue };
        let spec = actuator_spec(scenario, &placement.name, own)?;
        let c = actuator_coefficients(scenario, &placement.name, &spec)?;
        let said = scenario.actuator.get(&placement.name);
        for p in spec.base_parameters() {
            if !OF_ACTUATOR.contains(&p.name.as_str()) {
                continue;
            }
            let given = said.and_then(|o| o.parameters.get(&p.name));
            let value = coefficient(&c, &p.name);
            let p = within_its_kind(p);
            all.push(Parameter {
                name: format!("{}/{}", placement.name, p.name),
                value,
                min: p.min.min(value),
                max: p.max.max(value),
                prior_std: given.and_then(|g| g.std).or(p.prior_std),
                ..p
            });
        }
    }
    if let Some(ground) = &scenario.ground {
        let nominal = [ground.stiffness_n_m_n, ground.damping_s_m];
        for ((name, unit, ratio), value) in OF_CONTACT.into_iter().zip(nominal) {
            let std = ratio * value;
            let name = format!("{FOOT}/{name}");
            let low = (value - FARTHEST_STDS * std).max(0.0);
            let p = Parameter::new(name, unit, value, low, value + FARTHEST_STDS * std);
            // Without damping there is nothing to take a ratio of, and no parameter.
            if value > 0.0 {
                all.push(Parameter { prior_std: Some(std), ..p });
            }
        }
    }
    Ok(all)
}

/// The parameter with bounds no further than what an individual of its kind has.
fn within_its_kind(p: Parameter) -> Parameter {
    let Some(std) = p.prior_std else { return p };
    let reach = FARTHEST_STDS * std;
    Parameter { min: p.min.max(p.value - reach), max: p.max.min(p.value + reach), ..p }
}

fn coefficient(c: &Coefficients, name: &str) -> f64 {
    match name {
        "stiffness" => c.stiffness,
        "reflected_inertia" => c.reflected_inertia,
        "damping" => c.damping,
        _ => c.force_constant,
    }
}

/// What the base parameters are in another scenario; NaN where it has no such part.
pub(super) fn nominal(
    parameters: &[Parameter],
    scenario: &Scenario,
    robot: &Robot,
) -> Result<Vec<f64>, LegError> {
    let own = of(scenario, robot)?;
    let value = |p: &Parameter| own.iter().find(|o| o.name == p.name).map_or(f64::NAN, |o| o.value);
    Ok(parameters.iter().map(value).collect())
}

/// A case's scenario with parameter values in it. `std` is noted beside each by its index, where it is known.
pub(super) fn applied(
    case: &Case,
    parameters: &[Parameter],
    reference: &[f64],
    values: &[f64],
    std: &dyn Fn(usize) -> Option<f64>,
) -> Scenario {
    let mut scenario = case.scenario.clone();
    for (i, p) in parameters.iter().take(case.nominal.len()).enumerate() {
        let (own, nominal) = (case.nominal[i], reference[i]);
        let Some((place, name)) = p.name.split_once('/').filter(|_| !own.is_nan()) else { continue };
        let own_is_fitted = case.record.is_none();
        let value = if own_is_fitted || own == nominal || nominal.is_nan() || nominal <= 0.0 {
            values[i]
        } else {
            own * (values[i] / nominal)
        };
        if place == FOOT {
            if let Some(ground) = &mut scenario.ground {
                match name {
                    "contact_stiffness" => ground.stiffness_n_m_n = value,
                    _ => ground.damping_s_m = value,
                }
            }
            continue;
        }
        let parameters = &mut scenario.actuator.entry(place.to_owned()).or_default().parameters;
        parameters.insert(name.to_owned(), EffectValue { value, std: std(i) });
        // The nominal value has these in it already.
        parameters.remove("motor_gain");
        parameters.remove("stiffness_ratio");
    }
    scenario
}
