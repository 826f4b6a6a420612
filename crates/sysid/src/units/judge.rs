//! What became of each unit: its own error before and after, and where its values differ from the others'.

use super::{of_campaign, split};
use crate::data::Evaluation;
use crate::fit::Fit;
use crate::{Campaign, Role, residual};

/// Combined standard errors from which on two units differ.
const DIFFERENT: f64 = 3.0;

/// What two models leave of a unit's own runs.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitError {
    /// The unit.
    pub unit: String,
    /// Root mean square residual of the first model on them, in noise units.
    pub before: f64,
    /// The same of the second.
    pub after: f64,
}

/// What each unit's own runs of a role are left with by two models; empty where there are fewer than two units.
#[must_use]
pub fn errors(campaign: &Campaign, role: Role, before: &Evaluation, after: &Evaluation) -> Vec<UnitError> {
    let of = |unit: String| {
        let before = error_of(campaign, role, before, &unit)?;
        let after = error_of(campaign, role, after, &unit)?;
        Some(UnitError { unit, before, after })
    };
    of_campaign(campaign).into_iter().filter_map(of).collect()
}

/// The error of an evaluation on one unit's runs of the role, in noise units; none where it has none.
#[must_use]
pub fn error_of(campaign: &Campaign, role: Role, at: &Evaluation, unit: &str) -> Option<f64> {
    let of_unit: Vec<bool> = campaign.runs_of(role).map(|run| run.unit.as_deref() == Some(unit)).collect();
    residual::of_runs(at, |run| of_unit.get(run) == Some(&true))
}

/// A unit's value of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitValue {
    /// The unit.
    pub unit: String,
    /// The fitted value.
    pub value: f64,
    /// One standard error.
    pub std: f64,
}

/// A parameter in which units differ by more than their combined uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// The parameter, without a unit: `stiffness`.
    pub parameter: String,
    /// The unit of its values.
    pub symbol: String,
    /// What each unit has, in the order of the campaign.
    pub values: Vec<UnitValue>,
    /// The greatest difference of two of them, in its own standard errors.
    pub standard_errors: f64,
}

/// Parameters in which two units differ by more than three standard errors of their difference, the clearest first.
///
/// The errors of two units are correlated through the effects that they share; the standard error of a difference counts
/// that. Values at a bound, and those that the data say nothing about, are compared with nothing.
#[must_use]
pub fn differences(fit: &Fit) -> Vec<Difference> {
    let mut names: Vec<&str> = Vec::new();
    for parameter in &fit.parameters {
        if let (name, Some(_)) = split(&parameter.name)
            && !names.contains(&name)
        {
            names.push(name);
        }
    }
    let mut found: Vec<Difference> = names.into_iter().filter_map(|name| difference(fit, name)).collect();
    found.sort_by(|a, b| b.standard_errors.total_cmp(&a.standard_errors));
    found
}

fn difference(fit: &Fit, name: &str) -> Option<Difference> {
    // Its place among the free ones, the symbol of its unit, and the value.
    let known: Vec<(usize, &str, UnitValue)> = fit
        .parameters
        .iter()
        .enumerate()
        .filter(|(_, p)| !p.fixed && p.felt && p.at_bound.is_none() && p.std.is_finite())
        .filter_map(|(i, p)| {
            let (own, unit) = split(&p.name);
            let unit = unit.filter(|_| own == name)?.to_owned();
            let place = fit.free.iter().position(|&free| free == i)?;
            Some((place, p.unit.as_str(), UnitValue { unit, value: p.value, std: p.std }))
        })
        .collect();
    let symbol = known.first()?.1.to_owned();
    let mut standard_errors = 0.0f64;
    for (i, (a, _, x)) in known.iter().enumerate() {
        for (b, _, y) in &known[i + 1..] {
            let shared = 2.0 * fit.correlation(*a, *b) * x.std * y.std;
            let variance = x.std * x.std + y.std * y.std - shared;
            if variance > 0.0 {
                standard_errors = standard_errors.max((x.value - y.value).abs() / variance.sqrt());
            }
        }
    }
    (standard_errors > DIFFERENT).then(|| Difference {
        parameter: name.to_owned(),
        symbol,
        values: known.into_iter().map(|(.., value)| value).collect(),
        standard_errors,
    })
}

#[cfg(test)]
mod tests {
    use super::super::per_unit;
    use super::*;
    use crate::data::Data;
    use crate::fit::{FitOptions, fit};
    use crate::toy::{Toy, campaign, run};

    const NOISE: (f64, f64) = (0.2, 0.001);

    /// Two units of one mass, with springs and dampers of their own.
    fn two() -> Campaign {
        let springs = [("left", 4.0, 380.0), ("right", 4.0, 430.0)];
        let mut runs = Vec::new();
        for (i, (_, damping, stiffness)) in springs.iter().enumerate() {
            for role in [Role::Fit, Role::Holdout] {
                let seed = 10 * i as u64 + u64::from(role == Role::Fit);
                runs.push((role, run(&[1.1, *damping, *stiffness], 800, seed, NOISE, (1.0, 0.0), 1.0)));
            }
        }
        let mut campaign = campaign(runs, NOISE);
        for (run, unit) in campaign.runs.iter_mut().zip(["left", "left", "right", "right"]) {
            run.unit = Some(unit.to_owned());
        }
        campaign
    }

    #[test]
    fn units_have_values_of_their_own_and_errors_of_their_own() {
        let campaign = two();
        let one = fit(
            &Data::new(&campaign, Some(Role::Fit), &Toy::new()).unwrap(),
            &Toy::new(),
            &FitOptions::default(),
        )
        .unwrap();
        let model = per_unit(&campaign, &Toy::new()).unwrap();
        let data = Data::new(&campaign, Some(Role::Fit), model.as_ref()).unwrap();
        let each = fit(&data, model.as_ref(), &FitOptions::default()).unwrap();
        let found = differences(&each);
        assert_eq!(found.len(), 1, "{found:?}");
        let spring = &found[0];
        assert_eq!((spring.parameter.as_str(), spring.symbol.as_str()), ("stiffness", "N/m"));
        assert!(spring.standard_errors > 5.0, "{spring:?}");
        for (value, truth) in spring.values.iter().zip([("left", 380.0), ("right", 430.0)]) {
            assert_eq!(value.unit, truth.0);
            // Five standard errors, and the two sensors of each unit leave a gain open.
            assert!((value.value / truth.1 - 1.0).abs() < 0.03, "{value:?}");
        }
        // One spring for both misses each; a spring for each misses neither.
        let errors = errors(&campaign, Role::Fit, &one.evaluation, &each.evaluation);
        assert_eq!(errors.iter().map(|e| e.unit.as_str()).collect::<Vec<_>>(), ["left", "right"]);
        for e in &errors {
            assert!(e.before > 1.5 && e.after < 1.1, "{e:?}");
        }
        assert!(differences(&one).is_empty());
    }

    #[test]
    fn a_name_that_cannot_be_a_unit_s_is_refused() {
        let mut campaign = two();
        campaign.runs[0].unit = Some("a/b".to_owned());
        let refused = per_unit(&campaign, &Toy::new()).unwrap_err().to_string();
        assert!(refused.contains("'a/b' must be a name"), "{refused}");
        campaign.runs[0].unit = None;
        let refused = per_unit(&campaign, &Toy::new()).unwrap_err().to_string();
        assert!(refused.contains("has none, and others have 'left', 'right'"), "{refused}");
    }
}
