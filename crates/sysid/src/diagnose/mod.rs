//! Which physical effect is missing: screen every effect, fit the promising sets, select by
//! cross-validation inside the fit runs, judge once on the holdout runs.
//!
//! The walk: the base model is refitted first ([`crate::fit`]), so that a wrong value is never taken for a
//! missing effect. Effects are screened beside it ([`screen`]), the promising ones fitted together with
//! the base parameters ([`Candidate`]), sets grown, pruned and compared ([`Found`]); the verdict follows
//! from the holdout runs ([`Verdict`]). Nothing before it looks at them, except where the fit runs leave several sets open or
//! promise little: then the holdout runs decide.

mod adapt;
mod candidate;
mod compare;
mod conventions;
mod decide;
mod excitations;
mod experiment;
mod finish;
mod known_base;
mod left;
mod nested;
mod profile;
mod rig;
mod rivals;
mod rugged;
mod scatter;
mod screen;
mod search;
mod validation;
mod verdict;

pub use candidate::{Candidate, Effort, values_by_name, with_effects};
pub use compare::clearly_better;
pub use conventions::OpenChoice;
pub use experiment::{Experiment, Limits, Play, next_experiment};
pub use known_base::reconciled;
pub use nested::DEPARTURE;
pub use rugged::{fit_holding, tuned};
pub use screen::{Promise, Starts, race_periodic, screen};
pub use search::Found;
pub use validation::Validation;
pub use verdict::{Judged, Verdict, VerdictKind};

use crate::data::Data;
use crate::fit::FitOptions;
use crate::{Campaign, Error, Role, fit};
use sealegs_model::{Excitation, Model};

/// How thorough a diagnosis is.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Largest set of effects.
    pub most_effects: usize,
    /// Simulations after which sets of three effects and more are not begun: what is explained by few is found long
    /// before, and where none fits, every further effect takes some of the remainder.
    pub growing_simulations: u64,
    /// Starting values of each effect that are simulated beside the base model.
    pub starts: usize,
    /// The same beside a model with effects.
    pub starts_later: usize,
    /// Starting values that every effect gets at first, the most promising ones all of them.
    pub starts_first: usize,
    /// Periodic effects, the most promising ones, that are fitted for a few steps before they are ranked.
    pub periodic_raced: usize,
    /// Starting values of each that are.
    pub periods_raced: usize,
    /// Starting values of a set that are fitted.
    pub starts_fitted: usize,
    /// Single effects that are fitted.
    pub shortlist: usize,
    /// Sets that are fitted at every further size.
    pub shortlist_later: usize,
    /// Steps that every fit of a shortlist gets before the leaders go on.
    pub race_steps: usize,
    /// Whether fits make do with derivatives that are known nearby as far as they go (see [`FitOptions::secants`]).
    pub secants: bool,
    /// Error as a ratio of the floor up to which a better valley is looked for around the leader of a shortlist. On a
    /// bench starts are cheap, and there are many instead: what fits best far from the floor is not what foresees best,
    /// and one valley too many has led astray there.
    pub shaken_below: f64,
    /// Valleys that are fitted then.
    pub shakes_fitted: usize,
    /// Fits of a shortlist that go on to the end.
    pub finishers: usize,
    /// Single effects that pairs grow from.
    pub beam_first: usize,
    /// Sets that further sizes grow from.
    pub beam: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            most_effects: 6,
            growing_simulations: 30_000,
            starts: 200,
            starts_later: 60,
            starts_first: usize::MAX,
            periodic_raced: usize::MAX,
            periods_raced: usize::MAX,
            starts_fitted: 2,
            shortlist: 12,
            shortlist_later: 8,
            race_steps: 4,
            secants: false,
            shaken_below: 1.2,
            shakes_fitted: 3,
            finishers: 5,
            beam_first: 4,
            beam: 2,
        }
    }
}

impl Options {
    /// What suits a model: of one with many parameters and places only the most promising sets are fitted.
    #[must_use]
    pub fn of(model: &dyn Model) -> Self {
        let usual = Self::default();
        if !fit::has_many_parameters(model) {
            return usual;
        }
        Self {
            growing_simulations: 8_000,
            starts: 12,
            starts_later: 6,
            starts_first: 2,
            periodic_raced: 3,
            periods_raced: 4,
            starts_fitted: 1,
            // Steps are cheap, derivatives are not.
            race_steps: 8,
            secants: true,
            shaken_below: f64::INFINITY,
            shakes_fitted: 1,
            shortlist: 6,
            shortlist_later: 3,
            // A law that contains the right one fits as well: the simpler must be fitted to the end, too.
            finishers: 4,
            beam_first: 1,
            beam: 1,
            ..usual
        }
    }

    /// The work of a fit of a search that begins near a candidate.
    #[must_use]
    pub fn effort(&self, near: &Candidate, steps: usize) -> Effort {
        Effort { columns: self.secants.then(|| near.columns()), ..Effort::steps(steps) }
    }
}

/// What a diagnosis is doing, for a progress bar.
#[derive(Debug, Clone, PartialEq)]
pub enum Progress {
    /// The base model's own parameters are refitted.
    Base,
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
    /// The holdout runs judge.
    Judging,
}

/// The outcome of a diagnosis.
#[derive(Debug)]
pub struct Diagnosis {
    /// The verdict with its numbers.
    pub verdict: Verdict,
    /// Everything that was fitted.
    pub found: Found,
    /// What the fit runs measured and how hard they drove the model.
    pub seen: Excitation,
    /// Simulations done.
    pub simulations: u64,
    /// Seconds of experiment that they covered.
    pub simulated_s: f64,
}

/// Error as a ratio of the floor beyond which a base model with many parameters, or with some of which nothing is known,
/// is suspected to have been bent by the fit as far as it goes, and effects are screened beside its nominal values, too.
const BENT: f64 = 3.0;

/// Integration steps per sampling period in the search; what it finds is fitted again with the model itself.
const STEPS_PER_SAMPLE: f64 = 4.0;

/// Diagnoses a campaign with a base model.
///
/// # Errors
///
/// [`Error::NoRun`] if fit or holdout runs are missing, or what the base model's fit returns.
pub fn diagnose(
    campaign: &Campaign,
    base: &dyn Model,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Diagnosis, Error> {
    let data = Data::new(campaign, Some(Role::Fit), base)?;
    let holdout = Data::new(campaign, Some(Role::Holdout), base)?;
    progress(Progress::Base);
    let coarse = base.coarser(STEPS_PER_SAMPLE);
    let base_fit = fit_holding(&data, coarse.as_ref(), &FitOptions::of(base))?;
    let seen = data.excitation(&base_fit.evaluation.predictions);
    let admitted: Vec<String> = base.effects(&seen).into_iter().map(|c| c.id).collect();
    let mut first = Candidate::of_base(&data, coarse.as_ref(), base_fit);
    // Where the search's steps are the model's own there is nothing to polish.
    first.exact = data.predict(base, &first.fit.values).is_ok_and(|p| p == first.fit.evaluation.predictions);
    let nominal: Vec<f64> = base.parameters().iter().map(|p| p.value).collect();
    let at_nominal = || fit::at_values(&data, coarse.as_ref(), &nominal, fit::Difference::Forward).ok();
    let far = first.fit.error() > BENT * data.floor;
    let bent = far && !options.secants && base.parameters().iter().any(known_base::is_unknown);
    let nominal = (far && (options.secants || bent)).then(at_nominal).flatten();
    let search = search::Search {
        data: &data,
        base: coarse.as_ref(),
        exact: base,
        refined: false,
        nominal: nominal.map(|fit| Candidate::of_base(&data, coarse.as_ref(), fit)),
        bent,
        seen: &seen,
        admitted,
        options,
        tried: vec![first],
        screened: Vec::new(),
        scattered: 0,
        progress,
    };
    let found = search.run(&holdout);
    progress(Progress::Judging);
    let verdict = verdict::judge(&holdout, &found)?;
    let (a, b) = (data.work(), holdout.work());
    Ok(Diagnosis { verdict, found, seen, simulations: a.0 + b.0, simulated_s: a.1 + b.1 })
}
