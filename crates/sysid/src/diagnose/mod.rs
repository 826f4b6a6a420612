//! Which physical effect is missing: see what is missing in the log, then name it.
//!
//! The walk, a stage a file; none looks back. The base model is refitted first (`refine`), so that a wrong value is never
//! taken for a missing effect. An observer shows what is missing at each port (`missing`) and what that depends on
//! (`dependence`). Effects are regressed on it ([`screen`]()) and fitted ([`Models`]). Where none explains what is missing,
//! curves at the ports are screened (`curves`) and fitted as any effect (`free_form`): one that explains nearly everything ends
//! the search, else sets grow, are compared and exchanged on stretches of the fit runs (`search`). What the data do not tell
//! from the best set is found (`rivals`), and what does not hold up across the fit runs leaves again (`across`). Then, and only
//! then, the holdout runs are read, and judge once (`judge`).

mod candidate;
mod experiment;
mod free_form;
mod judge;
mod missing;
mod policy;
mod refine;
mod screen;
mod search;
#[cfg(test)]
mod tests;

pub use candidate::compare::clearly_better;
pub use candidate::validation::Validation;
pub use candidate::{Candidate, Known, in_words, values_by_name, with_effects};
pub use experiment::{Experiment, Limits, Play, next_experiment};
pub use free_form::FreeForm;
pub use judge::{Judged, LawJudged, Rung, Verdict, VerdictKind};
pub use missing::dependence::{Curve, Dependence};
pub use missing::picture::{Bin, Branch, MissingForce, missing_force};
pub use missing::{Missing, Port};
pub use policy::policy;
pub use refine::Models;
pub use refine::conventions::OpenChoice;
pub use refine::count::fit_holding;
pub use refine::windows::Memory;
pub use screen::{Plan, Promise, Screened, screen};
pub use search::nested::DEPARTURE;

use crate::data::Data;
use crate::fit::{self, Difference, Fit};
use crate::{Campaign, Error, Role};
use rayon::prelude::*;
use sealegs_model::{Excitation, Model};

/// What a diagnosis is doing, for a progress bar.
#[derive(Debug, Clone, PartialEq)]
pub enum Progress {
    /// The base model's own parameters are refitted.
    Base,
    /// What is missing at each port is estimated.
    Looking,
    /// Every effect is simulated beside a set.
    Screening {
        /// The set.
        beside: Vec<String>,
    },
    /// Sets are fitted.
    Fitting {
        /// The sets.
        sets: Vec<Vec<String>>,
    },
    /// A set explains the fit runs better than all before it.
    Better {
        /// The set.
        set: Vec<String>,
        /// What the base model leaves of them, in noise units.
        base: f64,
        /// What the set leaves.
        error: f64,
    },
    /// The search is over: what follows judges the set that it chose.
    Searched,
    /// Curves are fitted at the ports where something is missing.
    Curves,
    /// The holdout runs judge.
    Judging,
}

/// What the search leaves: the chosen set and everything that was fitted on the way.
#[derive(Debug)]
pub struct Found {
    /// Everything that was fitted, the base model first.
    pub tried: Vec<Candidate>,
    /// Index of the chosen one in `tried`.
    pub chosen: usize,
    /// Indices of sets of no more effects that these data do not tell from the chosen one.
    pub tied: Vec<usize>,
    /// Indices of sets that are the chosen one by another name: richer laws from whose simple form nothing departs.
    pub same: Vec<usize>,
    /// Choices of the base model that explain the fit runs as well, with other values.
    pub open: Vec<OpenChoice>,
    /// What screening promised of each effect beside the base model.
    pub promises: Vec<Promise>,
    /// Curves at a port that take what no known effect takes, where something is left: beside the chosen set, or alone.
    pub laws: Vec<FreeForm>,
    /// Parameters of the chosen set's effects along which the error is rugged: their intervals are wide.
    pub rugged: Vec<String>,
    /// How the base model predicts what was left out, as exactly as the search was: what the sets that were not
    /// fitted again compare with.
    pub base_as_searched: Validation,
}

impl Found {
    /// Index of a set, if it was fitted.
    #[must_use]
    pub fn index_of(&self, effects: &[String]) -> Option<usize> {
        self.tried.iter().position(|t| t.effects == effects)
    }
}

/// The outcome of a diagnosis.
#[derive(Debug)]
pub struct Diagnosis {
    /// The verdict with its numbers.
    pub verdict: Verdict,
    /// Everything that was fitted.
    pub found: Found,
    /// What is missing at each port of the base model, before anything was searched.
    pub ports: Vec<Port>,
    /// The same beside the chosen set, where that leaves something.
    pub ports_after: Vec<Port>,
    /// What is missing without the chosen set and what it gives, at the port where it acts; none where nothing was chosen,
    /// or the runs measure no motion to follow.
    pub force: Option<MissingForce>,
    /// What the fit runs measured and how hard they drove the model.
    pub seen: Excitation,
    /// Simulations done.
    pub simulations: u64,
    /// Seconds of experiment that they covered.
    pub simulated_s: f64,
    /// Integration steps of the search and all that follows, without the held-out runs.
    pub steps: u64,
}

/// Who is told what a diagnosis does, and which share of a longest search ([`policy`]'s `LONG_SEARCH`) is spent.
pub type Tell<'a> = dyn Fn(Progress, f64) + Sync + 'a;

/// Diagnoses a campaign with a base model.
///
/// From [`Progress::Looking`] to [`Progress::Searched`] a model may refuse to be simulated: then the best set so far is judged.
///
/// # Errors
///
/// [`Error::NoRun`] if fit or holdout runs are missing, or what the base model's fit returns.
pub fn diagnose(campaign: &Campaign, base: &dyn Model, tell: &Tell) -> Result<Diagnosis, Error> {
    campaign.require(Role::Holdout)?;
    let data = Data::new(campaign, Some(Role::Fit), base)?;
    tell(Progress::Base, 0.0);
    let mut models = Models::new(&data, base);
    let mut first = models.base()?;
    if models.refine_where_steps_show(&first) {
        first = models.base()?;
    }
    tell(Progress::Looking, 0.0);
    let ports = missing::look(&models, &first);
    let (mut found, curve, mut ports, models) = search(models, first, ports, tell);
    let chosen = &found.tried[found.chosen];
    let mut ports_after = if chosen.fit.error() > policy::NEAR_FLOOR * data.floor {
        missing::look(&models, chosen)
    } else {
        Vec::new()
    };
    tell(Progress::Curves, 1.0);
    found.laws = free_form::look(&models, &mut found, curve, (&ports, &ports_after));
    for law in &found.laws {
        let ports = if law.beside == 0 { &mut ports } else { &mut ports_after };
        free_form::put_first(law, &found.tried[law.beside], data.floor, ports);
    }
    let chosen = &found.tried[found.chosen];
    // The set that is named may lack a trace of the chosen one: that is not seen at a port.
    let force = match found.laws.first() {
        Some(law) if chosen.effects.is_empty() => law.force.clone(),
        _ if chosen.effects.is_empty() => None,
        _ => missing_force(&models, chosen, &ports),
    };
    // The base model shows what it can in open loop.
    let best_base = Models { last: Memory::OpenLoop, ..models.clone() };
    if models.last != best_base.last {
        let fit = best_base.polished(&found.tried[0]).fit;
        found.tried[0].fit = fit;
    }
    found.tried = found.tried.into_par_iter().map(|c| models.in_open_loop(c)).collect();
    let (fit, rugged) = refine::rugged::widened(&data, &found.tried[found.chosen]);
    (found.tried[found.chosen].fit, found.rugged) = (fit, rugged);
    let seen = models.seen;
    tell(Progress::Judging, 1.0);
    let holdout = Data::new(campaign, Some(Role::Holdout), base)?;
    let verdict = judge::judge(&data, &holdout, &found)?;
    let (a, b) = (data.work(), holdout.work());
    Ok(Diagnosis {
        verdict,
        found,
        ports,
        ports_after,
        force,
        seen,
        simulations: a.0 + b.0,
        simulated_s: a.1 + b.1,
        steps: data.steps(),
    })
}

/// What is missing at each port of a model on the runs of `data`, before anything is searched, the most important port
/// first: the first half of a diagnosis. `fit` is the model's own fit to them, if there is one.
///
/// Empty where the runs measure no motion that could be followed.
///
/// # Errors
///
/// If the model cannot be simulated.
pub fn missing_signals(data: &Data, model: &dyn Model, fit: Option<&Fit>) -> Result<Vec<Port>, Error> {
    let mut models = Models::new(data, model);
    if models.observed.is_none() {
        return Ok(Vec::new());
    }
    let nominal: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
    let fit = match fit {
        Some(fit) => fit.clone(),
        None => fit::at_values(data, model, &nominal, Difference::Forward)?,
    };
    models.seen = data.excitation(&fit.evaluation.predictions);
    let base = Candidate::of_base(data, models.coarse.as_ref(), fit);
    models.refine_where_steps_show(&base);
    Ok(missing::look(&models, &base))
}

/// The search on the fit runs alone, from the fitted base model.
fn search<'a>(
    models: Models<'a>,
    first: Candidate,
    ports: Vec<Port>,
    tell: &'a Tell<'a>,
) -> (Found, Option<free_form::Fitted>, Vec<Port>, Models<'a>) {
    let mut search = search::Search::new(models, first, ports, tell);
    let best = search.run();
    let base_as_searched = search.tried[0].validation.clone();
    let best = search.without_contained(best);
    search.confirm_rivals(best);
    let (simplest, _) = search.ties(best);
    let simplest = search.without_contained(simplest);
    if simplest != best {
        search.confirm_rivals(simplest);
    }
    let best =
        if search.tried[simplest].effects.len() < search.tried[best].effects.len() { simplest } else { best };
    let (chosen, mut tied) = search.ties(best);
    let chosen = search.holding_up(chosen, &mut tied);
    let chosen = search.without_idle(chosen, &mut tied);
    let chosen = search.simplified(chosen, &mut tied);
    let chosen = search.in_parts(chosen, &mut tied);
    search.say(Progress::Searched);
    if search.leaves_something(chosen) {
        search.models.last = search.models.last_memory(&search.tried[chosen]);
    }
    let same = search.models.by_another_name(&search.tried, chosen);
    tied.retain(|i| !same.contains(i));
    let (settled, others) = search.models.settled(search.tried[chosen].clone());
    search.tried[chosen] = settled;
    let (base, _) = search.models.settled(search.tried[0].clone());
    if base.fit.cost < search.tried[0].fit.cost - fit::EQUAL_COST {
        search.tried[0] = base;
    }
    search.finish(&[0, chosen]);
    let chosen = search.base_or(chosen, &mut tied);
    let open = search.models.open_choices(&others, &search.tried[chosen]);
    let chosen = if search.leaves_something(chosen) { search.simplified(chosen, &mut tied) } else { chosen };
    let chosen = search.without_idle(chosen, &mut tied);
    // A simpler set that took the place of the one that was fitted to the end is not fitted to the end itself.
    search.finish(&[chosen]);
    search.finish(&search.compared_with(chosen));
    let search::Search { models, tried, promises, ports, curve, .. } = search;
    let found = Found {
        tried,
        chosen,
        tied,
        same,
        open,
        promises,
        laws: Vec::new(),
        rugged: Vec::new(),
        base_as_searched,
    };
    // One that was not found before the search was ended is looked for again.
    (found, curve.flatten(), ports, models)
}
