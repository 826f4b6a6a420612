//! What a set leaves of a fit run when it is fitted to the others, of a single run of a part of it: where something stays that no
//! set explains, a law that only takes what is peculiar to one run leaves again.

use super::Search;
use super::nested::simpler_id;
use crate::diagnose::Candidate;
use crate::diagnose::candidate::{Known, all_but, compare::clearly_better, is_amplitude, symbol};
use crate::diagnose::policy::{EXPLAINED, KNOWN_FROM_ZERO, NAMED_SHARE, TIED_COST};
use crate::diagnose::refine::folds::folds;
use crate::fit::FittedParameter;
use rayon::prelude::*;

impl Search<'_> {
    /// The chosen set, or a simpler one that does no worse on fit runs that it is not fitted to: without a member, with a
    /// simpler law in the place of one, or with an effect at the same port that has fewer parameters. What it leaves of them
    /// counts as much as what it leaves of stretches of the runs that it is fitted to: a few whole runs in open loop are a
    /// judge with a wide spread. Asked only where the chosen one leaves something: what explains everything needs no other
    /// judge. Not on a leg, where a simulation is dear.
    pub(crate) fn holding_up(&mut self, mut chosen: usize, tied: &mut Vec<usize>) -> usize {
        let folds = folds(self.models.data);
        if self.models.dear || !self.leaves_something(chosen) {
            return chosen;
        }
        let left = |search: &Self, i: usize| {
            let set = &search.tried[i];
            search.models.left_of_others(set, &folds) * set.validation.mean_square()
        };
        let mut least = left(self, chosen);
        loop {
            let simpler = self.simpler_sets(chosen);
            let of_set = |&i: &usize| (i, left(self, i));
            let mut judged: Vec<(usize, f64)> = simpler.par_iter().map(of_set).collect();
            judged.sort_by(|a, b| a.1.total_cmp(&b.1));
            match judged.first() {
                Some(&(next, of_next)) if of_next <= TIED_COST * least => {
                    (chosen, least) = (next, least.min(of_next));
                    tied.clear();
                }
                _ => return chosen,
            }
        }
    }

    /// Whether effects are chosen and leave something.
    pub(crate) fn leaves_something(&self, chosen: usize) -> bool {
        let set = &self.tried[chosen];
        let error = set.fit.error();
        !set.effects.is_empty() && error > EXPLAINED * self.models.data.floor && !self.is_explained(chosen)
    }

    /// Fits sets to the end that are not yet.
    pub(crate) fn finish(&mut self, sets: &[usize]) {
        for &i in sets {
            if !self.tried[i].exact {
                self.tried[i] = self.models.polished(&self.tried[i]);
            }
        }
    }

    /// The base model where, fitted to the end, it leaves nothing to explain: what was chosen beside its search's fit is not missing.
    pub(crate) fn base_or(&self, chosen: usize, tied: &mut Vec<usize>) -> usize {
        if !self.at_floor(0) {
            return chosen;
        }
        tied.clear();
        0
    }

    /// The chosen set without members that are nothing to speak of. One that may be nothing at all leaves, as no amplitude of
    /// it is known from zero, given what it is in the sets that fit as well: where the set leaves something in any case, else
    /// where the rest is not clearly worse. So does one that takes no more than a trace of the fit runs, once both are fitted to
    /// the end: a last fit frees what the search holds (see [`sealegs_model::Parameter::freed_at_last`]), and until then a
    /// further effect may stand in for it. What a trace leaves is fitted to the end in any case: it is the set that is named.
    pub(crate) fn without_idle(&mut self, mut chosen: usize, tied: &mut Vec<usize>) -> usize {
        let floor = self.models.data.floor;
        'smaller: loop {
            let (set, something) = (&self.tried[chosen], self.leaves_something(chosen));
            let (effects, exact) = (set.effects.clone(), set.exact);
            for leaving in &effects {
                let ties: Vec<&Candidate> = tied.iter().map(|&i| &self.tried[i]).collect();
                // Of an error that adds up in open loop a last fit has few independent samples.
                let doubtful =
                    !(exact && self.models.windowed) && is_doubtful(&self.tried[chosen], &ties, leaving);
                let rest = all_but(&effects, leaving);
                let known = || self.tried.iter().position(|t| t.effects == rest);
                let rest = if doubtful {
                    self.rest_of(&rest, chosen)
                } else {
                    known().filter(|&rest| self.is_trace(chosen, rest))
                };
                let Some(rest) = rest else { continue };
                if exact {
                    self.finish(&[rest]);
                }
                let idle = doubtful && something;
                if idle || !clearly_better(&self.tried[rest], &self.tried[chosen], floor) {
                    let members = effects.len() - 1;
                    tied.retain(|&i| {
                        let tie = &self.tried[i].effects;
                        i != rest && tie.len() <= members && !tie.contains(leaving)
                    });
                    chosen = rest;
                    continue 'smaller;
                }
            }
            return chosen;
        }
    }

    /// Whether a set that was fitted to the end takes no more than a trace beyond a part of it that is not empty. What a fit in
    /// windows leaves says nothing beside one in open loop.
    fn is_trace(&self, set: usize, part: usize) -> bool {
        let error = |i: usize| self.tried[i].fit.error();
        let least = NAMED_SHARE * (error(0) - self.models.data.floor).max(0.0);
        let comparable = self.tried[part].exact || !self.models.windowed;
        self.tried[set].exact && part > 0 && comparable && error(part) - error(set) < least
    }

    /// Where the chosen set leaves something, those without one of its members: what a member takes is judged on holdout runs,
    /// between fits that are equally good.
    pub(crate) fn compared_with(&self, chosen: usize) -> Vec<usize> {
        let effects = &self.tried[chosen].effects;
        let asked = self.leaves_something(chosen) && !self.models.dear && effects.len() > 1;
        let rest = |leaving: &String| {
            let rest = all_but(effects, leaving);
            self.tried.iter().position(|t| t.effects == rest)
        };
        effects.iter().filter(|_| asked).filter_map(rest).collect()
    }

    /// Whether a set predicts fit runs better that it is not fitted to than one with fewer effects does; also where that cannot
    /// be told, or need not.
    pub(crate) fn holds_up_across(&self, more: usize, fewer: usize) -> bool {
        if self.models.dear || self.is_explained(more) {
            return true;
        }
        let folds = folds(self.models.data);
        let left = |i: usize| self.models.left_of_others(&self.tried[i], &folds);
        left(more) < left(fewer)
    }

    /// Sets like one with fewer effects or fewer parameters, fitted now if they were not.
    fn simpler_sets(&mut self, of: usize) -> Vec<usize> {
        let set = self.tried[of].clone();
        let cards = self.models.exact.effects(&self.models.seen);
        let card = |id: &String| cards.iter().find(|c| c.id == *id);
        let mut sets: Vec<(Vec<String>, Known)> = Vec::new();
        for leaving in &set.effects {
            let rest = Candidate { effects: all_but(&set.effects, leaving), ..set.clone() };
            sets.push((rest.effects.clone(), set.known()));
            let Some(own) = card(leaving) else { continue };
            let simpler = own.becomes.as_ref().map(|law| simpler_id(own, law));
            let at_port = self.promises.iter().filter(|p| {
                let other = card(&p.effect);
                other.is_some_and(|c| c.acts_on == own.acts_on && c.parameters.len() < own.parameters.len())
            });
            let starts = at_port.map(|p| (p.effect.clone(), p.start.clone()));
            for (id, start) in starts.chain(simpler.into_iter().map(|id| (id, Known::new()))) {
                let with = self.set_with(&rest, std::slice::from_ref(&id));
                if self.admitted.contains(&id) && with.len() == set.effects.len() {
                    sets.push((with, set.known().into_iter().chain(start).collect()));
                }
            }
        }
        sets.sort_by(|a, b| a.0.cmp(&b.0));
        sets.dedup_by(|a, b| a.0 == b.0);
        let (known, new): (Vec<_>, Vec<_>) =
            sets.into_iter().partition(|(set, _)| self.tried.iter().any(|t| t.effects == *set));
        self.say_fitted(new.iter().map(|(set, _)| set.clone()).collect());
        let models = &self.models;
        let fit = |(effects, known): &(Vec<String>, Known)| models.fitted(&set, effects, known, None);
        let mut fitted: Vec<Candidate> = new.par_iter().filter_map(fit).collect();
        self.no_worse_than_parts(&mut fitted);
        let first = self.tried.len();
        self.tried.extend(fitted);
        let index = |(set, _): (Vec<String>, Known)| self.tried.iter().position(|t| t.effects == set);
        known.into_iter().filter_map(index).chain(first..self.tried.len()).collect()
    }
}

/// Whether an effect of a fitted set has amplitudes, and the confidence interval of each holds zero: where other sets that fit
/// as well have it, too, an amplitude is known no better than they agree.
fn is_doubtful(set: &Candidate, ties: &[&Candidate], effect: &str) -> bool {
    let is_nothing = |p: &FittedParameter| {
        let elsewhere = ties.iter().flat_map(|tie| &tie.fit.parameters).filter(|other| other.name == p.name);
        let std = elsewhere.map(|other| (other.value - p.value).abs()).fold(p.std, f64::max);
        p.value.abs() <= KNOWN_FROM_ZERO * std
    };
    let own = set.model.parameters().iter().zip(&set.fit.parameters);
    let mut amplitudes = own.filter(|(p, _)| symbol(&p.name, effect).is_some() && is_amplitude(p)).peekable();
    amplitudes.peek().is_some() && amplitudes.all(|(_, p)| is_nothing(p))
}

#[cfg(test)]
mod tests {
    use super::is_doubtful;
    use crate::data::Data;
    use crate::diagnose::refine::Models;
    use crate::diagnose::refine::folds::folds;
    use crate::fit::{FitOptions, fit};
    use crate::toy::{Toy, campaign, run};
    use crate::{Role, diagnose::Candidate, diagnose::with_effects};

    /// What `of` says of the base model, and of it with the toy's cubic sensor, fitted to two runs whose force is so distorted.
    fn fitted<T>(cubic: [f64; 2], of: impl Fn(&Models, &Candidate) -> T) -> [T; 2] {
        let toy = Toy::new();
        let records = cubic.iter().enumerate().map(|(i, a)| {
            let mut record = run(&[1.0, 4.0, 400.0], 400, i as u64 + 1, (0.1, 1e-4), (1.0, 0.0), 1.0);
            let force = record.outputs.iter_mut().find(|s| s.channel == "force_1_n").expect("a force");
            force.values.iter_mut().for_each(|f| *f += a * f.powi(3));
            (Role::Fit, record)
        });
        let campaign = campaign(records.collect(), (0.1, 1e-4));
        let data = Data::new(&campaign, Some(Role::Fit), &toy).expect("fit runs");
        let models = Models::new(&data, &toy);
        [&[][..], &["cubic-sensor".to_owned()]].map(|effects| {
            let model = with_effects(&toy, effects, &models.seen).expect("a model");
            let at = fit(&data, model.as_ref(), &FitOptions::default()).expect("a fit");
            of(&models, &Candidate::exactly(&data, effects.to_vec(), model, at))
        })
    }

    /// What they leave of the runs, each predicted from the other.
    fn left(cubic: [f64; 2]) -> [f64; 2] {
        fitted(cubic, |models, set| {
            let folds = folds(models.data);
            assert_eq!(folds.len(), 2);
            models.left_of_others(set, &folds)
        })
    }

    #[test]
    fn an_amplitude_is_known_no_better_than_sets_that_fit_as_well_agree() {
        let doubtful = |factor: f64| {
            let of = |_: &Models, set: &Candidate| {
                let mut tie = set.clone();
                tie.fit.parameters.iter_mut().for_each(|p| p.value *= factor);
                is_doubtful(set, &[&tie], "cubic-sensor")
            };
            fitted([1e-3, 1e-3], of)[1]
        };
        assert_eq!([1.0, 1.4, 1.6, -1.0].map(doubtful), [false, false, true, true]);
    }

    #[test]
    fn a_single_run_is_left_out_in_parts_that_make_it_up() {
        let record = run(&[1.0, 4.0, 400.0], 400, 1, (0.1, 1e-4), (1.0, 0.0), 1.0);
        let campaign = campaign(vec![(Role::Fit, record)], (0.1, 1e-4));
        let data = Data::new(&campaign, Some(Role::Fit), &Toy::new()).expect("a fit run");
        let folds = folds(&data);
        let rows = |data: &Data| -> Vec<usize> { data.runs[0].rows().collect() };
        let left_out: Vec<usize> = folds.iter().flat_map(|fold| rows(&fold.left_out)).collect();
        assert_eq!((folds.len(), left_out), (3, rows(&data)));
        assert!(
            folds.iter().all(|fold| rows(&fold.rest).len() + rows(&fold.left_out).len() == rows(&data).len())
        );
        assert_eq!(folds[1].rest.runs[0].scored.len(), 2);
    }

    #[test]
    fn a_law_of_all_runs_predicts_the_one_left_out_and_one_of_a_single_run_does_not() {
        let [without, with] = left([1e-3, 1e-3]);
        assert!(with < 0.5 * without, "{with} {without}");
        let [without, with] = left([1e-3, -1e-3]);
        assert!(with > without, "{with} {without}");
    }
}
