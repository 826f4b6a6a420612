//! The whole walk on a model in closed form, whose force sensor has a law that the base model lacks.

use super::{Diagnosis, VerdictKind, diagnose};
use crate::Role;
use crate::campaign::Campaign;
use crate::toy::{LAWS, Toy, campaign, distorted};

const NOISE: (f64, f64) = (0.1, 1e-4);

/// Two runs to fit and two held out, of a sensor that shows something else than the force.
pub(super) fn runs(shows: impl Fn(f64, f64) -> f64) -> Campaign {
    let roles = [Role::Fit, Role::Fit, Role::Holdout, Role::Holdout];
    let record = |seed: u64| distorted(&[1.05, 3.8, 410.0], 800, seed, NOISE, (1.0, 0.0), 1.0, &shows);
    let runs = roles.into_iter().zip(1..).map(|(role, seed)| (role, record(seed)));
    campaign(runs.collect(), NOISE)
}

/// The toy with all its laws.
pub(super) fn toy() -> Toy {
    let mut toy = Toy::new();
    toy.laws = &LAWS;
    toy
}

fn of(shows: impl Fn(f64, f64) -> f64) -> Diagnosis {
    diagnose(&runs(shows), &toy(), &|_, _| ()).expect("a diagnosis")
}

#[test]
fn nothing_is_named_where_nothing_is_missing() {
    let verdict = of(|_, f| f).verdict;
    assert_eq!((verdict.kind, verdict.effects.len()), (VerdictKind::Adequate, 0));
    assert!((verdict.base.holdout_error - 1.0).abs() < 0.05, "{}", verdict.base.holdout_error);
}

#[test]
fn what_is_missing_is_named_with_its_value_and_a_ladder_that_falls() {
    let diagnosis = of(|_, f| f + 1e-3 * f.powi(3) + 0.02 * f * f);
    let verdict = &diagnosis.verdict;
    assert_eq!(verdict.kind, VerdictKind::MissingEffect);
    assert_eq!(verdict.effects, ["cubic-sensor", "even-sensor"]);
    let errors: Vec<f64> = verdict.ladder.iter().map(|rung| rung.holdout_error).collect();
    assert!(errors.len() == 3 && errors.is_sorted_by(|a, b| a > b), "{errors:?}");
    assert!(errors[2] < 1.05, "{errors:?}");
    let fit = &diagnosis.found.tried[verdict.after.index].fit;
    for (name, truth) in [("cubic-sensor.a", 1e-3), ("even-sensor.a", 0.02)] {
        let p = fit.parameters.iter().find(|p| p.name == name).expect("a parameter of a named effect");
        assert!((p.value - truth).abs() < 3.0 * p.std, "{name}: {} +- {}", p.value, p.std);
        assert!(p.std < 0.1 * truth, "{name}: {} +- {}", p.value, p.std);
    }
}

#[test]
fn what_takes_next_to_nothing_beside_another_effect_is_a_trace() {
    // A law with a free exponent would take the trace, too.
    let mut toy = Toy::new();
    toy.laws = &LAWS[..3];
    let campaign = runs(|_, f| f + 5e-3 * f.powi(3) + 1e-3 * f * f);
    let verdict = diagnose(&campaign, &toy, &|_, _| ()).expect("a diagnosis").verdict;
    assert_eq!(verdict.kind, VerdictKind::MissingEffect);
    assert_eq!((verdict.effects, verdict.traces), (vec!["cubic-sensor".into()], vec!["even-sensor".into()]));
}

#[test]
fn what_no_law_says_is_not_explained_by_one() {
    let verdict = of(|t, f| f + 2.0 * (3.0 * t).sin()).verdict;
    assert_eq!((verdict.kind, verdict.effects.len()), (VerdictKind::Unexplained, 0));
    assert!(verdict.base.holdout_error > 5.0, "{}", verdict.base.holdout_error);
}

#[test]
fn held_out_runs_change_nothing_of_what_is_chosen() {
    let mut campaign = runs(|_, f| f + 1e-3 * f.powi(3));
    let chosen = |campaign: &Campaign| {
        let found = diagnose(campaign, &toy(), &|_, _| ()).expect("a diagnosis").found;
        let chosen = &found.tried[found.chosen];
        (chosen.effects.clone(), chosen.fit.values.clone())
    };
    let before = chosen(&campaign);
    for run in campaign.runs.iter_mut().filter(|run| run.role == Role::Holdout) {
        let mut noise = crate::toy::Noise::new(7);
        run.record.outputs.iter_mut().for_each(|s| s.values.iter_mut().for_each(|v| *v = noise.normal()));
    }
    assert_eq!(before.0, ["cubic-sensor"]);
    assert_eq!(before, chosen(&campaign));
}
