//! Choices of the base model that these data leave open, such as which end of a period a logger's rows are stamped at,
//! and what the fitted values are under the other one.

use super::Models;
use crate::diagnose::Candidate;
use crate::diagnose::candidate::{Known, values_by_name};
use crate::fit::{self, EQUAL_COST};

/// The unit of a choice of where a row's command acts from.
const SAMPLES: &str = "samples";

/// Standard errors by which a value must differ under another choice to be said.
const DIFFERS: f64 = 3.0;

/// A discrete choice that explains the fit runs as well as the one that was made.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenChoice {
    /// The choices, by the parameters' names.
    pub choices: Vec<(String, f64)>,
    /// Values that differ by more than three standard errors then, by the parameters' names.
    pub values: Vec<(String, f64)>,
}

impl Models<'_> {
    /// The candidate under the first of the choices that fit equally well, and the other ones.
    pub(crate) fn settled(&self, candidate: Candidate) -> (Candidate, Vec<Candidate>) {
        let mut all = self.under_every_choice(&candidate);
        let costs: Vec<f64> = all.iter().map(|c| c.fit.cost).collect();
        let Some(first) = fit::first_of_the_best(&costs, EQUAL_COST) else { return (candidate, Vec::new()) };
        let chosen = all.swap_remove(first);
        all.retain(|c| (c.fit.cost - chosen.fit.cost).abs() <= EQUAL_COST);
        (chosen, all)
    }

    /// Fits under every discrete choice of the base model, in their order; empty where it has none. Rough fits would tell the
    /// choices apart by where they stopped.
    fn under_every_choice(&self, candidate: &Candidate) -> Vec<Candidate> {
        let discrete = self.discrete();
        if discrete.is_empty() {
            return Vec::new();
        }
        let mut all: Vec<Candidate> = Vec::new();
        for choice in fit::choices(self.exact) {
            let mut known = candidate.known();
            let mut moved_samples = 0.0;
            for &i in &discrete {
                let p = &self.exact.parameters()[i];
                let Some(entry) = known.iter_mut().find(|(n, _)| *n == p.name) else { continue };
                if p.unit == SAMPLES {
                    moved_samples += choice[i] - entry.1;
                }
                entry.1 = choice[i];
            }
            let under = if known == candidate.known() {
                Some(candidate.clone())
            } else {
                let start = self.with_delays_moved(candidate, known, moved_samples);
                self.fitted_near(candidate, &candidate.effects, &start)
            };
            all.extend(under.map(|under| self.finished(under)));
        }
        all
    }

    /// Values by name, or those with each delay later by so many samples where that leaves less: where a command acts from is
    /// a delay of it, and no fit finds its way over a whole sample.
    fn with_delays_moved(&self, candidate: &Candidate, known: Known, samples: f64) -> Known {
        let parameters = candidate.model.parameters();
        let period_s = self.data.runs.first().map_or(0.0, |run| run.record.mean_period_s());
        let mut moved = known.clone();
        for (name, value) in &mut moved {
            let delay = parameters.iter().find(|p| p.name == *name && p.unit == "s" && !p.fixed);
            if let Some(p) = delay {
                *value = (*value + samples * period_s).clamp(p.min, p.max);
            }
        }
        let cost = |known: &Known| {
            let values = values_by_name(candidate.model.as_ref(), known);
            self.data.evaluate(candidate.model.as_ref(), &values).map_or(f64::INFINITY, |e| e.cost)
        };
        if moved != known && cost(&moved) < cost(&known) { moved } else { known }
    }

    /// Which parameters of the base model are discrete choices.
    fn discrete(&self) -> Vec<usize> {
        let parameters = self.exact.parameters();
        (0..parameters.len()).filter(|&i| parameters[i].fixed && !parameters[i].starts.is_empty()).collect()
    }

    /// What the final candidate's values are under the other choices, as far as they differ. Those are fitted to the end, too:
    /// the search is content with values a part of a standard error off.
    pub(crate) fn open_choices(&self, others: &[Candidate], last: &Candidate) -> Vec<OpenChoice> {
        let discrete = self.discrete();
        let name = |i: usize| last.fit.parameters[i].name.clone();
        others
            .iter()
            .map(|other| {
                let values = self.polished(other).fit.values;
                let differs = |i: &usize| {
                    (values[*i] - last.fit.values[*i]).abs() > DIFFERS * last.fit.parameters[*i].std
                };
                let differing = last.fit.free.iter().copied().filter(differs);
                OpenChoice {
                    choices: discrete.iter().map(|&i| (name(i), values[i])).collect(),
                    values: differing.map(|i| (name(i), values[i])).collect(),
                }
            })
            .filter(|open| !open.values.is_empty())
            .collect()
    }
}
