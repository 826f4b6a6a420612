//! Mysteries made, diagnosed and revealed in one go: how often a diagnosis is right.

use super::{Located, Mystery, Verdict};
use crate::{Error, Options, Result, diagnose};
use schemars::JsonSchema;
use sealegs_sysid::Campaign;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// A mystery beside the verdict on it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Judged {
    /// The campaign's name.
    pub campaign: String,
    /// The seed that made it.
    pub seed: u64,
    /// What is hidden; empty where nothing is.
    pub hidden: Vec<String>,
    /// `right`, `tied`, `part`, `wrong`, `missed` or `false alarm`.
    pub score: String,
    /// The verdict in the data contract's words.
    pub verdict: String,
    /// What was named.
    pub effects: Vec<String>,
    /// What could not be told from it.
    pub indistinguishable: Vec<Vec<String>>,
    /// Error of the refitted base model on the holdout runs, noise units.
    pub base_error: f64,
    /// The same with what was named, where something was.
    pub after_error: Option<f64>,
    /// Whether port and dependence of what is in no catalogue were said; none where nothing of the kind is hidden.
    pub located: Option<Located>,
    /// Simulations that it took.
    pub simulations: u64,
}

/// Mysteries of one kind, judged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Judgement {
    /// `locked`, `pendulum` or `leg`.
    pub bench: String,
    /// `easy`, `hard` or `rough`.
    pub level: String,
    /// Duration of a run, s; none on a leg, whose runs have their own.
    pub duration_s: Option<f64>,
    /// How many have each score.
    pub scores: BTreeMap<String, usize>,
    /// The mysteries in the order of their seeds as they were asked for.
    pub mysteries: Vec<Judged>,
}

/// Diagnoses a mystery as `sealegs diagnose --force` does, from files as they would lie in its folder, and judges the
/// verdict by the answer.
///
/// # Errors
///
/// Those of [`diagnose`], and of a temporary folder.
pub fn judge(mystery: &Mystery, options: impl Into<Options>) -> Result<Judged> {
    let folder = tempfile::tempdir().map_err(|e| Error::io(&std::env::temp_dir(), e))?;
    for (name, text) in &mystery.files {
        let file = folder.path().join(name);
        std::fs::write(&file, text).map_err(|e| Error::io(&file, e))?;
    }
    let campaign = Campaign::read(folder.path())?;
    let diagnosis = diagnose(&campaign, options.into().force(true))?;
    let said = Verdict::of(&diagnosis)?;
    let answer = &mystery.answer;
    let outcome = diagnosis.outcome();
    Ok(Judged {
        campaign: answer.campaign.clone(),
        seed: answer.seed,
        hidden: answer.effects.iter().map(|e| e.id.clone()).collect(),
        score: said.score(answer).to_string(),
        located: said.located(answer),
        verdict: said.verdict,
        effects: said.effects,
        indistinguishable: said.indistinguishable,
        base_error: outcome.base.holdout_error,
        after_error: outcome.after.as_ref().map(|after| after.holdout_error),
        simulations: outcome.work.simulations,
    })
}

impl Judgement {
    /// The scores of some mysteries counted.
    #[must_use]
    pub fn new(bench: &str, level: &str, duration_s: Option<f64>, mysteries: Vec<Judged>) -> Self {
        let mut scores = BTreeMap::new();
        for judged in &mysteries {
            *scores.entry(judged.score.clone()).or_default() += 1;
        }
        Self { bench: bench.to_owned(), level: level.to_owned(), duration_s, scores, mysteries }
    }

    /// A line for each mystery, and the scores.
    #[must_use]
    pub fn text(&self) -> String {
        let list = |ids: &[String]| if ids.is_empty() { "nothing".to_owned() } else { ids.join(" + ") };
        let lines: Vec<[String; 4]> = self
            .mysteries
            .iter()
            .map(|m| [m.campaign.clone(), m.score.clone(), list(&m.hidden), list(&m.effects)])
            .collect();
        let heads = ["mystery", "score", "hidden", "named"];
        let width =
            |i: usize| lines.iter().map(|l| l[i].chars().count()).max().unwrap_or(0).max(heads[i].len());
        let (a, b, c) = (width(0), width(1), width(2));
        let mut out = String::new();
        for [name, score, hidden, named] in std::iter::once(heads.map(str::to_owned)).chain(lines.clone()) {
            let _ = writeln!(out, "{name:<a$}  {score:<b$}  {hidden:<c$}  {named}");
        }
        let counts: Vec<String> = self.scores.iter().map(|(score, n)| format!("{n} {score}")).collect();
        let _ = writeln!(out, "{} mysteries: {}", self.mysteries.len(), counts.join(", "));
        out
    }
}
