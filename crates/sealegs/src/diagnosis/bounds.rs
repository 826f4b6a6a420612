//! Parameters of the base model that ended at a bound which no file states: what is said of them, and what to state.
//!
//! A file that states a value and nothing else is taken at its word within 50 %. Where a fit ends there, the bound and not the
//! rig has decided, and the next effect that can do the parameter's work is named in its place.

use super::outcome::ParameterValue;
use super::text::figures;
use std::fmt::Write as _;

/// Parameters that are spelt out.
const MOST: usize = 3;

fn of(parameters: &[ParameterValue]) -> impl Iterator<Item = (&ParameterValue, f64)> {
    parameters.iter().filter_map(|p| Some((p, p.assumed_about?)))
}

/// The name in an actuator's file: without its joint and its unit of the rig.
fn in_file(name: &str) -> &str {
    let name = name.rsplit_once('/').map_or(name, |(_, own)| own);
    name.split_once('@').map_or(name, |(own, _)| own)
}

/// A number as a file states it, with so many significant digits: what is computed from others has sixteen.
fn stated(value: f64, digits: usize) -> String {
    let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    format!("{rounded:?}")
}

/// The nominal value and the widest bounds that are proposed about it.
fn about(nominal: f64) -> [String; 3] {
    [stated(nominal, 6), stated(0.01 * nominal, 3), stated(100.0 * nominal, 3)]
}

/// What must be said first; `None` where every bound was stated.
#[must_use]
pub fn sentence(parameters: &[ParameterValue]) -> Option<String> {
    let said: Vec<String> = of(parameters)
        .take(MOST)
        .map(|(p, nominal)| {
            let value = |v: f64| format!("{} {}", figures(v, 3), p.unit).trim_end().to_owned();
            format!("{} at {} ({} in the file)", p.name, value(p.value), value(nominal))
        })
        .collect();
    let more = of(parameters).count().saturating_sub(MOST);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    (!said.is_empty()).then(|| {
        format!(
            "First state what you know of the base model. Its refit ended at a bound that no file states: {}{more}.",
            said.join(", ")
        )
    })
}

/// What to put into the actuator file, in a sentence.
fn advice(parameters: &[ParameterValue]) -> Option<String> {
    let (p, nominal) = of(parameters).next()?;
    let [value, min, max] = about(nominal);
    Some(format!(
        "In the actuator file, under [parameters.{}]: value = {value} and tolerance = 0.1 (one standard deviation, as a ratio) \
         with a wider min and max, or min = {min}, max = {max}, scale = \"logarithmic\" where only its size is known.",
        in_file(&p.name),
    ))
}

/// Both in one: a reason not to be sure.
#[must_use]
pub fn reason(parameters: &[ParameterValue]) -> Option<String> {
    Some(format!("{} {}", sentence(parameters)?, advice(parameters)?))
}

/// The lines to add to the actuator file.
#[must_use]
pub fn lines(parameters: &[ParameterValue]) -> String {
    let mut out = String::new();
    let mut done: Vec<&str> = Vec::new();
    for (p, nominal) in of(parameters) {
        let name = in_file(&p.name);
        if done.contains(&name) || done.len() == MOST {
            continue;
        }
        done.push(name);
        let [value, min, max] = about(nominal);
        let _ = write!(
            out,
            "    [parameters.{name}]\n    value = {value}\n    tolerance = 1.0          # one standard deviation of that, as a ratio\n    \
             min = {min}\n    max = {max}\n    scale = \"logarithmic\"    # a size that is known to a power of ten\n",
        );
    }
    if out.is_empty() { out } else { format!("  To be added to the actuator file:\n{out}") }
}

#[cfg(test)]
mod tests {
    use super::super::outcome::Outcome;
    use super::super::toy::{parameter, toy};
    use super::*;
    use sealegs_actuator::ActuatorSpec;
    use sealegs_model::Scale;

    const DRIVE: &str = "id = \"d\"\nkind = \"rotary\"\nspring = \"none\"\n[motor]\ntorque_constant_nm_a = 0.1\n\
                         rotor_inertia_kg_m2 = 1e-4\nrotor_damping_nm_s = 1e-3\n[transmission]\ntype = \"direct\"\n";

    #[test]
    fn a_bound_of_the_base_model_is_said_unless_the_named_effects_lead_to_the_noise_floor() {
        let mut o = toy();
        let mut assumed = parameter("knee/damping", 1.5e-3, 1e-6, "N m s/rad");
        (assumed.at_bound, assumed.assumed_about) = (true, Some(1e-3));
        o.base.parameters.push(assumed.clone());
        let said = |o: &Outcome| sentence(o.bounded()).is_some();
        assert!(!said(&o));
        o.after.as_mut().unwrap().holdout_error = 4.0;
        assert!(said(&o));
        o.base.holdout_error = 200.0;
        assert!(!said(&o));
        o.after.as_mut().unwrap().holdout_error = 1.0;
        o.after.as_mut().unwrap().parameters.push(assumed);
        assert!(said(&o));
    }

    #[test]
    fn a_bound_that_nobody_stated_is_said_with_lines_that_a_file_takes() {
        let stated = parameter("arm/reflected_inertia", 2e-4, 1e-6, "kg m^2");
        assert_eq!(sentence(std::slice::from_ref(&stated)), None);
        assert_eq!(lines(std::slice::from_ref(&stated)), "");
        let mut assumed = parameter("arm/damping", 1.5e-3, 1e-6, "N m s/rad");
        (assumed.at_bound, assumed.assumed_about) = (true, Some(1e-3));
        let all = [stated, assumed];
        let said = sentence(&all).unwrap();
        assert!(said.contains("arm/damping at 0.00150 N m s/rad (0.00100 N m s/rad in the file)"), "{said}");
        assert!(advice(&all).unwrap().contains("[parameters.damping]"));
        assert_eq!(about(0.020_157_750_000_000_002), ["0.0201578", "0.000202", "2.02"]);
        // Before: half to one and a half of the value. With the lines: from a hundredth to a hundred times.
        let of = |text: &str| {
            let spec = ActuatorSpec::from_toml(text, "d.toml").unwrap();
            spec.base_parameters().into_iter().find(|p| p.name == "damping").unwrap()
        };
        let before = of(DRIVE);
        assert!((before.min / before.value, before.max / before.value) == (0.5, 1.5), "{before:?}");
        let lines = lines(&all);
        let toml = lines.split_once('\n').unwrap().1;
        let after = of(&(DRIVE.to_owned() + toml));
        assert_eq!((after.min, after.value, after.max, after.scale), (1e-5, 1e-3, 0.1, Scale::Logarithmic));
        assert_eq!(after.prior_std, Some(1e-3));
    }
}
