//! The answer beside a user's verdict, as text.

use super::answer::Answer;
use super::located::{Located, MissingSignal, located};
use super::score::{Score, is_said_of_the_log, score};
use crate::diagnosis::text::figures;
use crate::{Diagnosis, Error, Result};
use serde::Deserialize;
use std::fmt::Write;

/// Significant digits of a parameter.
const DIGITS: usize = 6;

/// What `sealegs reveal` reads of `diagnose --json`; other keys are left alone.
#[derive(Debug, Clone, Deserialize)]
pub struct Verdict {
    /// The campaign's name.
    pub campaign: String,
    /// `adequate`, `missing-effect`, `partly-explained` or `unexplained`.
    pub verdict: String,
    /// What it names.
    pub effects: Vec<String>,
    /// What it cannot tell from that.
    #[serde(default)]
    pub indistinguishable: Vec<Vec<String>>,
    /// What is missing, port by port, the most important first.
    #[serde(default)]
    pub missing_signals: Vec<MissingSignal>,
    /// What was found wrong with the log itself.
    #[serde(default)]
    pub sanity: Vec<Wrong>,
    /// The base model.
    pub base: Side,
    /// The model with the effects.
    pub after: Option<Side>,
}

/// A finding about the log.
#[derive(Debug, Clone, Deserialize)]
pub struct Wrong {
    /// What it is, by its id.
    pub problem: String,
}

/// A fitted model.
#[derive(Debug, Clone, Deserialize)]
pub struct Side {
    /// On the holdout runs, noise units.
    pub holdout_error: f64,
    /// Its parameters.
    pub parameters: Vec<Fitted>,
    /// Its sensors.
    #[serde(default)]
    pub sensors: Vec<FittedSensor>,
}

/// A fitted parameter.
#[derive(Debug, Clone, Deserialize)]
pub struct Fitted {
    /// Its name; an effect's as `<id>.<symbol>`.
    pub name: String,
    /// SI.
    pub value: f64,
    /// One standard error.
    #[serde(default)]
    pub std: Option<f64>,
}

/// A fitted sensor.
#[derive(Debug, Clone, Deserialize)]
pub struct FittedSensor {
    /// The column.
    pub channel: String,
    /// Measured per true.
    pub gain: f64,
    /// In the column's unit.
    pub bias: f64,
}

/// A list of ids as a person reads it.
fn list(ids: &[String]) -> String {
    if ids.is_empty() { "nothing".to_owned() } else { ids.join(" + ") }
}

impl Verdict {
    /// That of a diagnosis, as its JSON says it.
    ///
    /// # Errors
    ///
    /// Those of [`Diagnosis::to_json`].
    pub fn of(diagnosis: &Diagnosis) -> Result<Self> {
        serde_json::from_str(&diagnosis.to_json()?)
            .map_err(|e| Error::Unwritable { what: "the verdict", problem: e.to_string() })
    }

    /// How it stands against the answer.
    #[must_use]
    pub fn score(&self, answer: &Answer) -> Score {
        let hidden: Vec<String> = answer.effects.iter().map(|e| e.id.clone()).collect();
        let known = answer.effects.iter().all(|e| e.known);
        let sanity = self.sanity.iter().map(|w| w.problem.as_str());
        if is_said_of_the_log(&hidden, &self.verdict, sanity) {
            return Score::Right;
        }
        score(&hidden, known, &self.verdict, &self.effects, &self.indistinguishable)
    }

    /// How the first of its missing signals stands against what is hidden, where that is in no catalogue.
    #[must_use]
    pub fn located(&self, answer: &Answer) -> Option<Located> {
        let hidden = answer.effects.iter().find(|e| !e.known)?;
        Some(located(hidden.port.as_deref()?, &hidden.depends_on, &self.missing_signals))
    }
}

/// The answer, the score of a verdict if there is one, and the true parameters beside the fitted ones.
#[must_use]
pub fn page(answer: &Answer, verdict: Option<&Verdict>) -> String {
    let hidden: Vec<String> = answer.effects.iter().map(|e| e.id.clone()).collect();
    let mut out = format!("{} ({} bench, seed {})\n", answer.campaign, answer.bench, answer.seed);
    let _ = writeln!(out, "Hidden: {}.", list(&hidden));
    if answer.effects.iter().any(|e| !e.known) {
        out.push_str("It is in no catalogue: the right answer is that no known effect explains it.\n");
    }
    for effect in &answer.effects {
        if let Some(port) = &effect.port {
            let _ = writeln!(
                out,
                "{} acts at {port} and depends on {}.",
                effect.id,
                effect.depends_on.join(" and ")
            );
        }
    }
    if !answer.rough.is_empty() {
        let _ = writeln!(out, "The log is rough: {}.", answer.rough.join(", "));
    }
    let _ = match (answer.base_error_is_estimate, answer.effects.is_empty()) {
        // Nothing was estimated of nothing.
        (true, true) => Ok(()),
        (true, false) => writeln!(
            out,
            "Without it a refitted model would miss the runs by about {:.1} noise units, estimated to first order.",
            answer.base_error
        ),
        (false, _) => writeln!(
            out,
            "Without it the refitted model misses the held-out runs by {:.2} noise units.",
            answer.base_error
        ),
    };
    if let Some(v) = verdict {
        let score = v.score(answer);
        let _ = writeln!(out, "The verdict said: {}, {}.", v.verdict, list(&v.effects));
        if !v.indistinguishable.is_empty() {
            let tied: Vec<String> = v.indistinguishable.iter().map(|t| list(t)).collect();
            let _ = writeln!(out, "It could not be told from: {}.", tied.join("; "));
        }
        let _ = writeln!(out, "Score: {score}: {}.", meaning(score, answer));
        if let Some(located) = v.located(answer) {
            let said = v.missing_signals.first().map_or_else(
                || "nothing".to_owned(),
                |s| format!("something at {}, by {}", s.port, s.depends_on.join(" and ")),
            );
            let verdict = match (located.port, located.dependence) {
                (true, true) => "port and dependence right",
                (true, false) => "port right, dependence wrong",
                _ => "wrong",
            };
            let _ = writeln!(out, "It locates {said}: {verdict}.");
        }
    }
    let side = verdict.map(|v| v.after.as_ref().unwrap_or(&v.base));
    let fitted = |name: &str| side?.parameters.iter().find(|p| p.name == name);
    let _ = write!(out, "\n{:<42} {:>14}", "parameter", "true");
    out.push_str(if side.is_some() { "         fitted          std  off by\n" } else { "\n" });
    let base = answer.parameters.iter().map(|p| (p.name.clone(), p.value));
    let of_effects = answer
        .effects
        .iter()
        .flat_map(|e| e.parameters.iter().map(move |p| (format!("{}.{}", e.id, p.name), p.value)));
    for (name, truth) in base.chain(of_effects) {
        let _ = write!(out, "{name:<42} {:>14}", figures(truth, DIGITS));
        match fitted(&name) {
            Some(p) => {
                let std = p.std.map_or("-".to_owned(), |s| figures(s, 2));
                let _ = write!(out, " {:>14} {std:>12}", figures(p.value, DIGITS));
                let off = 100.0 * (p.value / truth - 1.0);
                // There is no share of nothing.
                let _ =
                    if truth == 0.0 { writeln!(out, "       -") } else { writeln!(out, " {off:>+6.1} %") };
            }
            None if side.is_some() => out.push_str("              -            -       -\n"),
            None => out.push('\n'),
        }
    }
    for sensor in &answer.sensors {
        let found = side.and_then(|s| s.sensors.iter().find(|f| f.channel == sensor.channel));
        for (name, truth, value) in
            [("gain", sensor.gain, found.map(|f| f.gain)), ("bias", sensor.bias, found.map(|f| f.bias))]
        {
            let label = format!("{} {name}", sensor.channel);
            let _ = write!(out, "{label:<42} {:>14}", figures(truth, DIGITS));
            match value {
                Some(v) => {
                    let _ = writeln!(out, " {:>14}", figures(v, DIGITS));
                }
                None => out.push('\n'),
            }
        }
    }
    let _ =
        writeln!(out, "A row is stamped at the {} of the period in which its command acts.", answer.stamp);
    out
}

/// A score in a sentence.
fn meaning(score: Score, answer: &Answer) -> &'static str {
    let known = answer.effects.iter().all(|e| e.known);
    match (score, known) {
        (Score::Right, true) if answer.effects.is_empty() => "nothing is hidden, and nothing was named",
        (Score::Right, true) => "exactly what is hidden",
        (Score::Right, false) => "nothing known explains it",
        (Score::Tied, _) => "what is hidden is among those that the data could not tell apart",
        (Score::Part, true) => "some of what is hidden, not all",
        (Score::Part, false) => "what was named helps, and that something else remains was said",
        (Score::Wrong, _) => "something else was named",
        (Score::Missed, _) => "something is missing, and was not seen",
        (Score::FalseAlarm, _) => "nothing is hidden",
    }
}
