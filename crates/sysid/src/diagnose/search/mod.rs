//! The search for the smallest set of effects that explains the fit runs: sets grow by screening, the promising ones are
//! fitted, members leave again, and rivals of each member are tried.

pub(super) mod across;
pub(super) mod along;
pub(super) mod exchange;
pub(super) mod fits;
pub(super) mod grow;
pub(super) mod nested;
pub(super) mod rivals;
pub(super) mod scatter;

use crate::diagnose::candidate::compare::{clearly_better, excess, is_beyond_chance};
use crate::diagnose::policy::{
    AT_FLOOR, DRIFTS, EXCHANGES, EXPLAINED, LEFT_SHARE, LONG_SEARCH, MOST_EFFECTS, NEAR_FLOOR, OPEN_LOOP,
    OPEN_LOOP_WORTH, PAIR, PROMISES_MOST, SCATTERED, SEEN_TOGETHER, STARTS, STARTS_DEAR, STEP_SHARE,
    WORTH_NAMING,
};
use crate::diagnose::refine::Models;
use crate::diagnose::refine::Seen;
use crate::diagnose::refine::starts::with_nominal_base;
use crate::diagnose::screen::{Plan, Promise, Screened, addable, screen};
use crate::diagnose::{Candidate, Port, Progress, Tell, free_form};
use fits::{has_limit, has_two_magnitudes};
use rayon::prelude::*;
use sealegs_model::{EffectCard, internal};

/// Why a set grows no further.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ended {
    /// It leaves so little that the last effect was looked at once.
    AtLast,
    /// It has as many members as were asked for.
    AtMost,
    /// No further one is clearly better.
    NoBetter,
    /// A curve at a port explains everything, and far more than the set.
    Curve,
}

/// A set as it was fitted under the observer.
pub(crate) struct Observed {
    pub effects: Vec<String>,
    /// The set that it was grown from.
    pub from: Vec<String>,
    pub seen: Seen,
    /// Whether it gains more than chance gives, over what it was grown from.
    pub gains: bool,
}

/// The search's state.
pub(crate) struct Search<'a> {
    pub models: Models<'a>,
    /// Effects to choose from, in the catalogue's order.
    pub admitted: Vec<String>,
    /// Everything that was fitted, the base model first.
    pub tried: Vec<Candidate>,
    /// What screening promised of each effect beside the base model.
    pub promises: Vec<Promise>,
    /// Every set that was fitted under the observer.
    pub observed: Vec<Observed>,
    /// Sets whose last member was fitted beside the others from every start.
    pub fitted_anew: Vec<Vec<String>>,
    /// What was screened beside which sets.
    pub screened: Vec<(Vec<String>, Screened)>,
    /// What is missing at the ports of the base model.
    pub ports: Vec<Port>,
    /// The curve at one of them that leaves least beside the base model, once it was looked for.
    pub curve: Option<Option<free_form::Fitted>>,
    pub tell: &'a Tell<'a>,
}

impl<'a> Search<'a> {
    /// A search from a fitted base model, of which the ports show what is missing.
    pub fn new(models: Models<'a>, base: Candidate, ports: Vec<Port>, tell: &'a Tell<'a>) -> Self {
        Self {
            admitted: models.exact.effects(&models.seen).into_iter().map(|c| c.id).collect(),
            models,
            tried: vec![base],
            promises: Vec::new(),
            observed: Vec::new(),
            fitted_anew: Vec::new(),
            screened: Vec::new(),
            ports,
            curve: None,
            tell,
        }
    }
}

impl Search<'_> {
    /// Grows, exchanges and prunes from the base model (`tried[0]`); the index of the best set. Before a pair grows further, or
    /// a curve has the last word, what is screened badly is fitted alone: it may explain what three others do not.
    pub fn run(&mut self) -> usize {
        let (mut best, mut ended) = self.grown_from_base();
        self.look_for_curve(best);
        let by_curve = ended == Ended::Curve || self.curve_beats(best);
        if by_curve || ended != Ended::AtLast {
            let other = self.screened_badly(best);
            if other != best {
                self.fit_from_every_start(other, 0);
            }
            if self.curve_beats(other) {
                return 0;
            }
            if other != best || ended == Ended::AtMost {
                // Another law of the same kind is a simpler explanation than a third effect.
                let alone = other == best && !self.models.dear;
                let rival = if alone { self.exchanged(best) } else { other };
                (best, ended) = self.grown_from(rival, MOST_EFFECTS as usize);
            }
        }
        if self.is_long() || (ended == Ended::AtLast && self.models.dear) {
            return best;
        }
        if ended == Ended::AtLast {
            best = self.pruned(best);
            if !self.may_rest(best) {
                return best;
            }
        }
        for _ in 0..EXCHANGES as usize {
            let before = best;
            best = self.exchanged(best);
            best = self.pruned(best);
            if best == before {
                break;
            }
        }
        best
    }

    /// Grows the base model: from what explains everything under the observer, or up to pairs.
    fn grown_from_base(&mut self) -> (usize, Ended) {
        match self.grown_under_observer() {
            Some(explained) => self.grown_from(explained, MOST_EFFECTS as usize),
            None => self.grown_from(0, PAIR as usize),
        }
    }

    /// Whether so much was simulated that sets only grow from now on, up to pairs: where nothing explains the runs, every further
    /// look costs as much as all that is known cost so far.
    pub fn is_long(&self) -> bool {
        self.models.data.steps() as f64 > LONG_SEARCH
    }

    /// Adds effects to a set as long as that is clearly better, up to so many; the index of the last set, and why it grows no
    /// further.
    fn grown_from(&mut self, mut best: usize, most: usize) -> (usize, Ended) {
        while !self.at_floor(best) {
            let size = self.tried[best].effects.len();
            if size >= most {
                return (best, Ended::AtMost);
            }
            if size >= SEEN_TOGETHER as usize && self.is_long() {
                break;
            }
            // What is less than the contract's share of the base model's error is a trace: it is looked at once.
            let last = self.is_explained(best);
            if last && self.tried[best].fit.error() <= EXPLAINED * self.models.data.floor {
                break;
            }
            let Some(fitted) = self.grown(best) else { return (best, Ended::Curve) };
            let better = self.best_of(&fitted, best);
            // A law and a simpler one that it contains are the one law.
            let once = self.without_contained(better);
            if once != better {
                if self.tried[once].fit.cost >= self.tried[best].fit.cost {
                    break;
                }
                best = once;
                continue;
            }
            if self.curve_explains(better) {
                return (better, Ended::Curve);
            }
            if better == best || self.is_too_little(better, best) {
                break;
            }
            self.fit_from_every_start(better, best);
            let before = std::mem::replace(&mut best, better);
            self.say_better(best);
            let rugged = self.refine_steps(best);
            if last {
                return (best, Ended::AtLast);
            }
            // What is right about one run only is no ground for more.
            let alone = self.tried[before].effects.is_empty();
            if rugged || !(alone || self.holds_up_across(best, before)) {
                break;
            }
        }
        (best, Ended::NoBetter)
    }

    /// Whether a third or a fourth effect takes so little of what two leave, and leaves so much, that it would not be named:
    /// flexible laws take as much of anything.
    fn is_too_little(&self, more: usize, than: usize) -> bool {
        let left = |i: usize| excess(self.tried[i].fit.error(), self.models.data.floor);
        let (before, after) = (left(than), left(more));
        self.tried[than].effects.len() >= 2
            && !self.is_explained(more)
            && after > (1.0 - WORTH_NAMING) * before
    }

    /// Where the best set leaves something, fits what is screened badly: laws that repeat along the screw, and each effect of
    /// two magnitudes or with a limit that was not fitted alone. The index of the best one if it is clearly better than the best set.
    fn screened_badly(&mut self, best: usize) -> usize {
        let base = &self.tried[0];
        if self.models.dear || self.is_long() || self.models.is_settled(&self.tried[best], base) {
            return best;
        }
        let mut cards = addable(base.model.as_ref(), &self.models.seen, &self.admitted);
        let mut indices = self.repeating(best, &cards);
        if !indices.iter().any(|&i| self.models.is_settled(&self.tried[i], &self.tried[0])) {
            let alone = |id: &String| self.tried.iter().any(|t| t.effects == std::slice::from_ref(id));
            cards
                .retain(|c| (has_two_magnitudes(&c.parameters) || has_limit(&c.parameters)) && !alone(&c.id));
            self.say_fitted(cards.iter().map(|c| vec![c.id.clone()]).collect());
            let (models, base) = (&self.models, &self.tried[0]);
            let fit = |c: &EffectCard| models.with_one_more(base, &c.id);
            let fitted: Vec<Candidate> = cards.par_iter().filter_map(fit).collect();
            indices.extend(fitted.into_iter().map(|fitted| self.kept(fitted)));
        }
        self.best_of(&indices, best)
    }

    /// Fits laws that repeat along the screw in the place of the simpler ones that they become: of the best set, and of each
    /// one alone that takes a good part of what that, or the best one alone, takes; the indices.
    fn repeating(&mut self, best: usize, cards: &[EffectCard]) -> Vec<usize> {
        let takes = |i: usize| self.tried[0].fit.cost - self.tried[i].fit.cost;
        let alone = |i: &usize| self.tried[*i].effects.len() == 1;
        let most = (1..self.tried.len()).filter(alone).map(takes).fold(takes(best), f64::max);
        let leads = |i: usize| i == best || (alone(&i) && takes(i) > SCATTERED * most);
        let leaders: Vec<usize> = (1..self.tried.len()).filter(|&i| leads(i)).collect();
        let with = |card: &EffectCard, near: &Candidate| {
            let fitted = self.models.repeating(near, card)?;
            let none = Candidate { effects: Vec::new(), ..near.clone() };
            let effects = self.set_with(&none, &fitted.effects);
            Some(self.models.reordered(fitted, &effects))
        };
        let all = leaders.iter().flat_map(|&i| cards.iter().map(move |card| (i, card)));
        let fitted: Vec<Candidate> = all.filter_map(|(i, card)| with(card, &self.tried[i])).collect();
        fitted.into_iter().map(|fitted| self.kept(fitted)).collect()
    }

    /// Says what is being done, and which share of a longest search is spent.
    pub(crate) fn say(&self, what: Progress) {
        (self.tell)(what, (self.models.data.steps() as f64 / LONG_SEARCH).min(1.0));
    }

    /// Says which sets are fitted, if any are.
    pub(crate) fn say_fitted(&self, sets: Vec<Vec<String>>) {
        if !sets.is_empty() {
            self.say(Progress::Fitting { sets });
        }
    }

    /// Says what is the best set so far: whoever waits sees it, and who stops the search has seen it.
    fn say_better(&self, index: usize) {
        let error = |i: usize| self.tried[i].fit.error();
        let set = self.tried[index].effects.clone();
        self.say(Progress::Better { set, base: error(0), error: error(index) });
    }

    /// Fits what screening promises beside a set; the indices. `None` where no plan promises to explain what the set leaves, and
    /// a curve at a port does.
    fn grown(&mut self, from: usize) -> Option<Vec<usize>> {
        let near = self.tried[from].clone();
        let beside = self.observing(&near);
        let screened = self.screened_beside(beside.as_ref().unwrap_or(&near));
        let floor = self.models.data.floor;
        let left = near.cost_above(floor);
        let plans = screened.plans(left, from > 0);
        let seen = beside.as_ref().map_or(left, |beside| beside.cost_above(floor));
        if from > 0 && plans.iter().all(|plan| plan.drop < PROMISES_MOST * seen) {
            self.look_for_curve(from);
            if self.curve_explains(from) {
                return None;
            }
        }
        let mut fitted = self.fit_all(&near, beside.as_ref(), plans, None);
        let much = OPEN_LOOP_WORTH * excess(self.tried[from].fit.error(), floor);
        let better = self.best_of(&fitted, from);
        let error = self.tried[better].fit.error();
        let unexplained = error > NEAR_FLOOR * floor && excess(error, floor) >= much;
        if let Some(beside) = beside.as_ref().filter(|_| unexplained && !self.is_long()) {
            let plans = self.in_open_loop(from, beside, &screened);
            fitted.extend(self.fit_all(&near, None, plans, None));
        }
        let least = fitted
            .iter()
            .copied()
            .reduce(|a, b| if self.tried[b].fit.cost < self.tried[a].fit.cost { b } else { a });
        let least = least.unwrap_or(from);
        if from == 0 && !self.is_long() && self.models.is_worth_scattering(&self.tried[least]) {
            self.look_for_curve(least);
            if !self.curve_explains(least) {
                fitted.extend(self.scattered(from, &fitted));
            }
        }
        Some(fitted)
    }

    /// A candidate's effects with others, in the catalogue's order.
    pub fn set_with(&self, near: &Candidate, added: &[String]) -> Vec<String> {
        let chosen = |id: &String| near.effects.contains(id) || added.contains(id);
        self.admitted.iter().filter(|id| chosen(id)).cloned().collect()
    }

    /// What screening finds beside a set as it is under the observer, or in open loop where there is none; as it was found
    /// before, where the same set was screened beside.
    pub(crate) fn screened_beside(&mut self, beside: &Candidate) -> Screened {
        if let Some((_, before)) = self.screened.iter().find(|(set, _)| *set == beside.effects) {
            return before.clone();
        }
        self.say(Progress::Screening { beside: beside.effects.clone() });
        let cards = addable(beside.model.as_ref(), &self.models.seen, &self.admitted);
        let screened = self.at(beside, &cards);
        if beside.effects.is_empty() {
            self.promises.clone_from(&screened.promises);
        }
        self.screened.push((beside.effects.clone(), screened.clone()));
        screened
    }

    /// The most promising effects in open loop: a sensor that the observer follows hides its own fault, and a slow law (a
    /// clamp that slips) shows over seconds. On a leg, where a simulation in open loop is dear, only what the observer
    /// cannot see is looked at: what changes nothing there, and what acts where it shows no missing signal, as on a link that
    /// moves as it was measured.
    fn in_open_loop(&self, from: usize, beside: &Candidate, observed: &Screened) -> Vec<Plan> {
        let (models, candidate) = (&self.models, &self.tried[from]);
        self.say(Progress::Screening { beside: candidate.effects.clone() });
        let internals = || beside.fit.evaluation.predictions.iter().flat_map(|p| &p.internals);
        let shows = |place: &str| {
            let missing = format!("{place}.{}", internal::MISSING);
            internals().any(|signal| signal.channel.starts_with(&missing))
        };
        let felt = |c: &EffectCard| {
            observed.promises.iter().any(|p| p.effect == c.id)
                && c.id.split_once('/').is_none_or(|(place, _)| shows(place))
        };
        let mut cards = addable(candidate.model.as_ref(), &models.seen, &self.admitted);
        cards.retain(|c| !models.dear || !felt(c));
        let promises = self.at(candidate, &cards).promises.into_iter().filter(|p| p.drop > 0.0);
        let alone = |p: Promise| Plan { added: vec![p.effect], drop: p.drop, start: p.start };
        promises.take(OPEN_LOOP as usize).map(alone).collect()
    }

    /// A set as it is under the observer: from its values in open loop, or from where it was fitted there before. Play that
    /// rattles differs much between the two.
    pub fn observing(&self, set: &Candidate) -> Option<Candidate> {
        let before = self.least_observed(|o| o.effects == set.effects);
        let open = self.models.observing(set, &with_nominal_base(self.models.exact, &set.known()));
        let again = before.and_then(|o| self.models.observing(set, &o.seen.known));
        open.into_iter().chain(again).reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a })
    }

    fn at(&self, beside: &Candidate, cards: &[EffectCard]) -> Screened {
        let starts = if self.models.dear { STARTS_DEAR } else { STARTS } as usize;
        screen(self.models.data, beside, &self.models.seen, cards, starts)
    }

    /// Goes on with the model's own steps where the search's make a good part of what a set leaves: further effects would
    /// explain the error of the steps. Returns whether the set grows no further for them: where a simulation is dear, the
    /// model's own steps are left to the last fit.
    fn refine_steps(&mut self, index: usize) -> bool {
        let (set, floor) = (&self.tried[index], self.models.data.floor);
        let left = excess(set.fit.error(), floor);
        if self.at_floor(index) || self.models.step_error(set) < STEP_SHARE * left {
            return false;
        }
        if self.models.dear {
            return true;
        }
        self.models.refine();
        let (effects, known) = (set.effects.clone(), set.known());
        if let Some(again) = self.models.fitted(&self.tried[index], &effects, &known, None) {
            self.tried[index] = again;
        }
        false
    }

    /// Whether a set leaves less of the fit runs than the share of the base model's error that an effect must take.
    pub fn is_explained(&self, index: usize) -> bool {
        let floor = self.models.data.floor;
        let above = |i: usize| (self.tried[i].fit.error() - floor).max(0.0);
        index > 0 && above(index) < LEFT_SHARE * above(0)
    }

    /// Whether nothing is left to explain.
    pub fn at_floor(&self, index: usize) -> bool {
        let floor = self.models.data.floor;
        self.tried[index].fit.error() <= AT_FLOOR * floor
            && self.mean_square(index).sqrt() <= NEAR_FLOOR * floor
    }

    pub(crate) fn mean_square(&self, index: usize) -> f64 {
        self.tried[index].validation.mean_square()
    }

    /// The best of some sets if it is clearly better than another one, else that. What is better by chance in open loop
    /// alone does not count; nor what the observer could have seen and has not, where a simulation is dear or drifts: a leg
    /// with play that rattles, or a foot that strikes, amplifies any change, and any force at all bends a drift.
    fn best_of(&self, indices: &[usize], than: usize) -> usize {
        let (floor, worse) = (self.models.data.floor, &self.tried[than]);
        let real = |set: &Candidate| {
            let mut observed = self.observed.iter().filter(|o| o.effects == set.effects).peekable();
            let drifts = |o: &Observed| set.fit.cost > DRIFTS * o.seen.cost;
            let unseen = observed.peek().is_some_and(|o| self.models.dear || drifts(o));
            observed.any(|o| o.gains) || (!unseen && is_beyond_chance(worse, set))
        };
        let better = |set: &Candidate| clearly_better(worse, set, floor) && real(set);
        let better = indices.iter().copied().filter(|&i| better(&self.tried[i]));
        better.reduce(|a, b| if self.mean_square(b) < self.mean_square(a) { b } else { a }).unwrap_or(than)
    }

    /// Index of a set, fitted now if it was not, from another candidate's values.
    pub fn index_of(&mut self, effects: &[String], near: usize) -> Option<usize> {
        if let Some(i) = self.tried.iter().position(|t| t.effects == effects) {
            return Some(i);
        }
        let near = &self.tried[near];
        let fitted = self.models.fitted(near, effects, &near.known(), None)?;
        self.tried.push(fitted);
        Some(self.tried.len() - 1)
    }

    /// Of the sets like this that were fitted under the observer the one that leaves least.
    pub(crate) fn least_observed(&self, like: impl Fn(&Observed) -> bool) -> Option<&Observed> {
        let all = self.observed.iter().filter(|o| like(o));
        all.reduce(|a, b| if b.seen.cost < a.seen.cost { b } else { a })
    }

    /// A set as it was fitted under the observer from another one.
    pub(crate) fn observed_from(&self, from: &[String], effects: &[String]) -> Option<&Observed> {
        self.observed.iter().find(|o| o.from == from && o.effects == effects)
    }

    /// The index of a fitted set: among those tried, where the better of two fits of one set stays, or one to the end.
    pub fn kept(&mut self, fitted: Candidate) -> usize {
        match self.tried.iter().position(|t| t.effects == fitted.effects) {
            Some(index) => {
                if fitted.exact || fitted.fit.cost < self.tried[index].fit.cost {
                    self.tried[index] = fitted;
                }
                index
            }
            None => {
                self.tried.push(fitted);
                self.tried.len() - 1
            }
        }
    }
}
