//! A verdict for tests.

use super::confidence::Confidence;
use super::headline::screen;
use super::outcome::{
    BranchSaid, ForceSaid, Outcome, OutcomeKind, ParameterValue, Ranked, RungSaid, Side, Work,
};
use super::provenance::Provenance;
use sealegs_recorder::report::Report;

pub(super) fn parameter(name: &str, value: f64, std: f64, unit: &str) -> ParameterValue {
    ParameterValue {
        name: name.to_owned(),
        value,
        std: Some(std),
        unit: unit.to_owned(),
        fixed: false,
        at_bound: false,
        assumed_about: None,
        felt: true,
        from_nominal: None,
    }
}

fn side(error: f64, parameters: Vec<ParameterValue>) -> Side {
    Side { holdout_error: error, fit_error: error, parameters, sensors: Vec::new(), channels: Vec::new() }
}

/// A verdict on a toy: 80 um of play and some friction take the error from 40 to the noise floor.
pub(super) fn toy() -> Outcome {
    let effects: Vec<String> = ["knee/backlash", "knee/coulomb-friction"].map(String::from).into();
    let rung = |n: usize, error: f64| RungSaid {
        effects: effects[..n].to_vec(),
        holdout_error: error,
        fit_error: error,
    };
    let stiffness = || parameter("knee/stiffness", 375e3, 90.0, "N/m");
    let branch = BranchSaid {
        label: String::new(),
        x: vec![-0.02, -0.01, 0.01, 0.02],
        y: vec![-42.0, -41.5, 41.8, 42.1],
        std: vec![0.5; 4],
        law: Some(vec![-42.0, -42.0, 42.0, 42.0]),
    };
    let mut outcome = Outcome {
        campaign: "toy".to_owned(),
        noise_floor: 1.0,
        base: side(40.0, vec![stiffness()]),
        verdict: OutcomeKind::MissingEffect,
        effects: effects.clone(),
        indistinguishable: Vec::new(),
        same_by_another_name: Vec::new(),
        equally_good_choices: Vec::new(),
        after: Some(side(
            1.01,
            vec![
                stiffness(),
                parameter("knee/backlash.gap_m", 79.96e-6, 0.2e-6, "m"),
                parameter("knee/coulomb-friction.force_n", 42.06, 0.31, "N"),
            ],
        )),
        unexplained_share: 0.0004,
        ladder: vec![rung(0, 40.0), rung(1, 5.2), rung(2, 1.01)],
        traces: Vec::new(),
        missing_signals: Vec::new(),
        missing_after: Vec::new(),
        missing_force: Some(ForceSaid {
            port: "knee/rotor".to_owned(),
            unit: "N".to_owned(),
            depends_on: "direction of motion".to_owned(),
            over: "speed".to_owned(),
            over_unit: "m/s".to_owned(),
            divided_by: "1".to_owned(),
            noise: 8.0,
            explained_by_law: Some(0.97),
            branches: vec![branch],
        }),
        law: None,
        ranking: vec![Ranked {
            effects: vec!["knee/torque-ripple".to_owned()],
            holdout_error: 6.3,
            evidence: 12.0,
            parameters: Vec::new(),
        }],
        units: None,
        splits: None,
        next_experiment: "Repeat the drop from 5 cm.".to_owned(),
        sentence: String::new(),
        confidence: Confidence::default(),
        remainder: Vec::new(),
        sanity: Vec::new(),
        notes: Vec::new(),
        work: Work { simulations: 1, simulated_s: 1.0, steps: 1000, ended_early: false },
        provenance: Provenance { version: "0", model: "toy".to_owned(), inputs: Vec::new() },
    };
    outcome.confidence = Confidence::of(&outcome);
    outcome
}

/// The first screen of its report.
pub(super) fn html(o: &Outcome) -> String {
    let mut page = Report::new("toy");
    screen(&mut page, o, "sealegs diagnose data/toy --report r.html", None);
    page.to_html()
}
