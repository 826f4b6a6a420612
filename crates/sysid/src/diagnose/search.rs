//! The search for the smallest set of effects that explains the fit runs: sets grow by screening, the promising ones are
//! fitted, members leave again, and rivals of each member are tried.

use super::compare::{clearly_better, excess, is_beyond_chance};
use super::fits::has_two_magnitudes;
use super::policy::{
    ALIKE_COST, AT_FLOOR, DRIFTS, EXPLAINED, LEFT_SHARE, LONG_SEARCH_S, MOST_EFFECTS, MOST_OF_IT, NEAR_FLOOR,
    NEEDED_COST, OPEN_LOOP_WORTH, PROMISES_MOST, RIVAL_COST, SCATTERED, STARTS, STARTS_DEAR, STEP_SHARE,
    WORTH_NAMING,
};
use super::refine::Models;
use super::screen::{Known, Plan, Promise, Screened, addable, screen};
use super::starts::with_nominal_base;
use super::{Candidate, Port, Progress, free_form};
use rayon::prelude::*;
use sealegs_model::{EffectCard, internal};

/// Times that members are exchanged and taken out in turn.
const ROUNDS: usize = 2;

/// Rivals of a member that are fitted.
const RIVALS: usize = 3;

/// Effects of the screening in open loop that are fitted.
const OPEN_LOOP: usize = 4;

/// Members of a set beyond which what is screened badly is fitted alone first.
const PAIR: usize = 2;

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
pub(super) struct Observed {
    pub effects: Vec<String>,
    /// The set that it was grown from.
    pub from: Vec<String>,
    /// What it left.
    pub cost: f64,
    pub known: Known,
    /// Whether it gains more than chance gives, over what it was grown from.
    pub gains: bool,
}

/// The search's state.
pub(super) struct Search<'a> {
    pub models: Models<'a>,
    /// Effects to choose from, in the catalogue's order.
    pub admitted: Vec<String>,
    /// Everything that was fitted, the base model first.
    pub tried: Vec<Candidate>,
    /// What screening promised of each effect beside the base model.
    pub promises: Vec<Promise>,
    /// Every set that was fitted under the observer.
    pub observed: Vec<Observed>,
    /// What is missing at the ports of the base model.
    pub ports: Vec<Port>,
    /// The curve at one of them that leaves least beside the base model, once it was looked for.
    pub curve: Option<Option<free_form::Fitted>>,
    pub progress: &'a (dyn Fn(Progress) + Sync),
}

impl Search<'_> {
    /// Grows, exchanges and prunes from the base model (`tried[0]`); the index of the best set. Before a pair grows further, or
    /// a curve has the last word, what is screened badly is fitted alone: it may explain what three others do not.
    pub fn run(&mut self) -> usize {
        let (mut best, mut ended) = self.grown_from(0, 1);
        let something = !self.at_floor(best) && !self.is_explained(best);
        let chain = if something && ended != Ended::Curve { self.grown_under_observer() } else { None };
        if let Some(explained) = chain {
            (best, ended) = self.grown_from(explained, MOST_EFFECTS as usize);
        } else if ended == Ended::AtMost {
            (best, ended) = self.grown_from(best, PAIR);
        }
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
            return self.pruned(best);
        }
        for _ in 0..ROUNDS {
            let before = best;
            best = self.exchanged(best);
            best = self.pruned(best);
            if best == before {
                break;
            }
        }
        best
    }

    /// Whether so much was simulated that sets only grow from now on: where nothing explains the runs, every further look costs
    /// as much as all that is known cost so far.
    pub fn is_long(&self) -> bool {
        self.models.data.work().1 > LONG_SEARCH_S
    }

    /// Adds effects to a set as long as that is clearly better, up to so many; the index of the last set, and why it grows no
    /// further.
    fn grown_from(&mut self, mut best: usize, most: usize) -> (usize, Ended) {
        while !self.at_floor(best) {
            if self.tried[best].effects.len() >= most {
                return (best, Ended::AtMost);
            }
            // What is less than the contract's share of the base model's error is a trace: it is looked at once.
            let last = self.is_explained(best);
            if last && self.tried[best].fit.error() <= EXPLAINED * self.models.data.floor {
                break;
            }
            let Some(fitted) = self.grown(best) else { return (best, Ended::Curve) };
            let better = self.best_of(&fitted, best);
            if self.curve_explains(better) {
                return (better, Ended::Curve);
            }
            if better == best || self.is_too_little(better, best) {
                break;
            }
            self.fit_from_every_start(better, best);
            let before = std::mem::replace(&mut best, better);
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
    /// two magnitudes that was not fitted alone. The index of the best one if it is clearly better than the best set.
    fn screened_badly(&mut self, best: usize) -> usize {
        let base = &self.tried[0];
        if self.models.dear || self.is_long() || self.models.is_settled(&self.tried[best], base) {
            return best;
        }
        let mut cards = addable(base.model.as_ref(), &self.models.seen, &self.admitted);
        let mut indices = self.repeating(best, &cards);
        if !indices.iter().any(|&i| self.models.is_settled(&self.tried[i], &self.tried[0])) {
            let alone = |id: &String| self.tried.iter().any(|t| t.effects == std::slice::from_ref(id));
            cards.retain(|c| has_two_magnitudes(&c.parameters) && !alone(&c.id));
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

    /// Says which sets are fitted, if any are.
    pub(super) fn say_fitted(&self, sets: Vec<Vec<String>>) {
        if !sets.is_empty() {
            (self.progress)(Progress::Fitting { sets });
        }
    }

    /// Fits what screening promises beside a set; the indices. `None` where no plan promises to explain what the set leaves, and
    /// a curve at a port does.
    fn grown(&mut self, from: usize) -> Option<Vec<usize>> {
        let (screened, beside) = self.screened(from);
        if from == 0 {
            self.promises.clone_from(&screened.promises);
        }
        let noise = 0.5 * self.models.data.floor.powi(2) * self.tried[from].validation.residuals as f64;
        let left = (self.tried[from].fit.cost - noise).max(0.0);
        let near = self.tried[from].clone();
        let plans = screened.plans(left, from > 0);
        let seen = beside.as_ref().map_or(left, |beside| beside.fit.cost - noise);
        if from > 0 && plans.iter().all(|plan| plan.drop < PROMISES_MOST * seen) {
            self.look_for_curve(from);
            if self.curve_explains(from) {
                return None;
            }
        }
        let mut fitted = self.fit_all(&near, beside.as_ref(), plans, None);
        let floor = self.models.data.floor;
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
        if from == 0 && self.models.is_worth_scattering(&self.tried[least]) {
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

    /// What screening finds beside a set as it is under the observer, and that set; in open loop where there is no observer.
    fn screened(&self, from: usize) -> (Screened, Option<Candidate>) {
        let (models, candidate) = (&self.models, &self.tried[from]);
        (self.progress)(Progress::Screening { beside: candidate.effects.clone() });
        let beside = self.observing(candidate);
        let cards = addable(candidate.model.as_ref(), &models.seen, &self.admitted);
        (self.at(beside.as_ref().unwrap_or(candidate), &cards), beside)
    }

    /// The most promising effects in open loop: a sensor that the observer follows hides its own fault, and a slow law (a
    /// clamp that slips) shows over seconds. On a leg, where a simulation in open loop is dear, only what the observer
    /// cannot see is looked at: what changes nothing there, and what acts where it shows no missing signal, as on a link that
    /// moves as it was measured.
    fn in_open_loop(&self, from: usize, beside: &Candidate, observed: &Screened) -> Vec<Plan> {
        let (models, candidate) = (&self.models, &self.tried[from]);
        (self.progress)(Progress::Screening { beside: candidate.effects.clone() });
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
        promises.take(OPEN_LOOP).map(alone).collect()
    }

    /// A set as it is under the observer: from its values in open loop, or from where it was fitted there before. Play that
    /// rattles differs much between the two.
    pub fn observing(&self, set: &Candidate) -> Option<Candidate> {
        let before = self.observed.iter().filter(|o| o.effects == set.effects);
        let before = before.reduce(|a, b| if b.cost < a.cost { b } else { a });
        let open = self.models.observing(set, &with_nominal_base(self.models.exact, &set.known()));
        let again = before.and_then(|o| self.models.observing(set, &o.known));
        open.into_iter().chain(again).reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a })
    }

    pub(super) fn at(&self, beside: &Candidate, cards: &[EffectCard]) -> Screened {
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

    fn mean_square(&self, index: usize) -> f64 {
        self.tried[index].validation.mean_square()
    }

    /// The best of some sets if it is clearly better than another one, else that. What is better by chance in open loop
    /// alone does not count; nor what the observer could have seen and has not, where a simulation is dear or drifts: a leg
    /// with play that rattles, or a foot that strikes, amplifies any change, and any force at all bends a drift.
    fn best_of(&self, indices: &[usize], than: usize) -> usize {
        let (floor, worse) = (self.models.data.floor, &self.tried[than]);
        let real = |set: &Candidate| {
            let mut observed = self.observed.iter().filter(|o| o.effects == set.effects).peekable();
            let drifts = |o: &Observed| set.fit.cost > DRIFTS * o.cost;
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

    /// Index of a set without one of its members. A fit of it from elsewhere may have ended where nothing leads on: it says
    /// that the member is needed only if one from the whole set's values does.
    pub(super) fn rest_of(&mut self, rest: &[String], whole: usize) -> Option<usize> {
        let index = self.index_of(rest, whole)?;
        let (whole, floor) = (&self.tried[whole], self.models.data.floor);
        if rest.is_empty() || !clearly_better(&self.tried[index], whole, floor) {
            return Some(index);
        }
        let again = self.models.fitted(whole, rest, &whole.known(), None);
        Some(again.map_or(index, |again| self.kept(again)))
    }

    /// Lets members leave, the least useful first, as long as the rest is not clearly worse.
    pub fn pruned(&mut self, mut best: usize) -> usize {
        loop {
            let effects = self.tried[best].effects.clone();
            let own = self.observed_where_settled(best, &effects).map(|own| own.fit.cost);
            let without: Vec<usize> = effects
                .iter()
                .filter_map(|leaving| {
                    let rest = all_but(&effects, leaving);
                    let needed = own.is_some_and(|own| {
                        let left = self.observed_where_settled(best, &rest);
                        left.is_some_and(|left| left.fit.cost > NEEDED_COST * own)
                    });
                    if needed { None } else { self.rest_of(&rest, best) }
                })
                .collect();
            let floor = self.models.data.floor;
            let as_good =
                without.into_iter().filter(|&i| !clearly_better(&self.tried[i], &self.tried[best], floor));
            match as_good.reduce(|a, b| if self.mean_square(b) < self.mean_square(a) { b } else { a }) {
                Some(i) => best = i,
                None => return best,
            }
        }
    }

    /// Tries rivals in the place of each member of a set of several, as they promised to be beside the base model: effects at
    /// the same port, and those that alone leave as little as the member does.
    fn exchanged(&mut self, best: usize) -> usize {
        let effects = self.tried[best].effects.clone();
        if effects.len() < 2 {
            return best;
        }
        let cards = self.models.exact.effects(&self.models.seen);
        let port = |id: &str| cards.iter().find(|c| c.id == id).map(|c| c.acts_on.as_str());
        let mut fitted = Vec::new();
        let own = self.observed_where_settled(best, &effects).map(|own| own.fit.cost);
        for leaving in &effects {
            let rest = all_but(&effects, leaving);
            let promised = || self.promises.iter().filter(|p| !effects.contains(&p.effect) && p.drop > 0.0);
            let at_port = |p: &&Promise| port(&p.effect) == port(leaving);
            let alike = |p: &&Promise| !at_port(p) && self.leaves_as_little(&p.effect, leaving);
            let rivals = promised().filter(at_port).take(RIVALS).chain(promised().filter(alike).take(RIVALS));
            let mut plans: Vec<Plan> = rivals
                .map(|p| Plan { added: vec![p.effect.clone()], drop: p.drop, start: p.start.clone() })
                .collect();
            if let Some(own) = own {
                let near = Candidate { effects: rest.clone(), ..self.tried[best].clone() };
                plans.retain(|p| !self.is_beaten(&self.set_with(&near, &p.added), own));
                if plans.is_empty() {
                    continue;
                }
                let beside = self.observed_where_settled(best, &rest);
                fitted.extend(self.fit_all(&near, beside.as_ref(), plans, Some(own)));
            } else if let Some(without) = self.index_of(&rest, best) {
                let near = self.tried[without].clone();
                let beside = self.observing(&near);
                fitted.extend(self.fit_all(&near, beside.as_ref(), plans, None));
            }
        }
        let mean = |i: usize| self.mean_square(i);
        let rival = fitted.into_iter().filter(|&i| self.tried[i].effects.len() <= effects.len());
        rival.fold(best, |a, b| if mean(b) < mean(a) { b } else { a })
    }

    /// Whether an effect alone leaves hardly more than another one, which takes most of what the base model leaves.
    fn leaves_as_little(&self, effect: &String, other: &String) -> bool {
        let alone = |id: &String| self.tried.iter().find(|t| t.effects == std::slice::from_ref(id));
        let (Some(own), Some(other)) = (alone(effect), alone(other)) else { return false };
        let takes_most = other.fit.cost < (1.0 - MOST_OF_IT) * self.tried[0].fit.cost;
        takes_most && own.fit.cost <= ALIKE_COST * other.fit.cost
    }

    /// Whether a set was fitted under the observer before, and left too much there to be a rival of one of this cost.
    fn is_beaten(&self, effects: &[String], own: f64) -> bool {
        let costs = self.observed.iter().filter(|o| o.effects == effects).map(|o| o.cost);
        costs.reduce(f64::min).is_some_and(|least| least > RIVAL_COST * own)
    }

    /// Some members of a set that explains everything, fitted under the observer: what they leave there tells what is worth a
    /// fit in open loop. `None` if the set leaves something, where what else is missing hides that.
    fn observed_where_settled(&self, best: usize, effects: &[String]) -> Option<Candidate> {
        let set = &self.tried[best];
        if !self.models.is_settled(set, &self.tried[0]) {
            return None;
        }
        self.observing(&Candidate { effects: effects.to_vec(), ..set.clone() })
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

/// A set without one of its members.
pub(super) fn all_but(effects: &[String], leaving: &str) -> Vec<String> {
    effects.iter().filter(|e| *e != leaving).cloned().collect()
}
