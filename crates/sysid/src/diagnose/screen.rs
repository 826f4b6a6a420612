//! Screening: what every effect would gain beside a fitted model, from a few simulations each.
//!
//! An effect at one of its starting values makes a difference to the prediction, its signature. What the
//! base parameters and the sensors can do in its place is projected out, and the residual is regressed on
//! what is left: the fall of the cost that the best amplitude would bring. This is a first opinion that
//! decides what is fitted, nothing more.

use super::Candidate;
use super::candidate::symbol;
use super::rugged;
use crate::data::Data;
use crate::fit::{Difference, FitOptions, Signatures, fit};
use rayon::prelude::*;
use sealegs_model::{EffectCard, Excitation, Model, Parameter, Prediction, Scale};

/// Integration steps per sampling period: enough to tell what is promising.
const STEPS_PER_SAMPLE: f64 = 2.0;

/// Signatures that are taken together: bounds the memory that they need.
const TOGETHER: usize = 8;

/// How far an amplitude is trusted beyond the value that was simulated.
const FARTHEST: f64 = 3.0;

/// The parameter that makes an effect periodic.
pub(super) const PHASE: &str = EffectCard::PHASE;

/// What screening found of one effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Promise {
    /// The effect's id.
    pub effect: String,
    /// Predicted fall of the cost.
    pub drop: f64,
    /// Starting values of the effect's parameters, by full name, with the fall of the cost that each
    /// promises, best first.
    pub starts: Vec<(f64, Vec<(String, f64)>)>,
}

impl Promise {
    /// Adds further starts.
    fn take_in(&mut self, starts: Vec<(f64, Vec<(String, f64)>)>) {
        self.starts.extend(starts);
        self.starts.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.drop = self.starts.first().map_or(0.0, |s| s.0);
    }
}

/// How many starting values of each effect are simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Starts {
    /// At most.
    pub most: usize,
    /// At first; only the most promising effects then get all of them.
    pub first: usize,
}

/// Starting values from which on a rugged parameter is looked for in an excerpt, too.
const DENSE: usize = 200;

/// Effects that get all their starting values where each gets few at first.
const LEADERS: usize = 24;

/// Periodic effects that get all their periods then.
const PERIODIC_LEADERS: usize = 3;

/// Screens effects beside a candidate.
///
/// The result is in the order of `cards`; an effect that cannot be simulated promises nothing.
pub fn screen(
    data: &Data,
    beside: &Candidate,
    seen: &Excitation,
    cards: &[EffectCard],
    starts: Starts,
) -> Vec<Promise> {
    let all: Vec<Vec<Vec<f64>>> =
        cards.iter().map(|card| combinations(&card.parameters, starts.most)).collect();
    let mut screened: Vec<Vec<Vec<f64>>> = all.iter().map(|s| spread(s, starts.first)).collect();
    let mut promises = screen_starts(data, beside, seen, cards, screened.clone());
    let best_first = |promises: &[Promise]| {
        let mut order: Vec<usize> = (0..cards.len()).collect();
        order.sort_by(|&a, &b| promises[b].drop.total_cmp(&promises[a].drop));
        order
    };
    // Starts of some effects that were not screened yet.
    let mut go_on = |promises: &mut [Promise], chosen: &[usize], every: &dyn Fn(usize) -> Vec<Vec<f64>>| {
        let mut more: Vec<Vec<Vec<f64>>> = vec![Vec::new(); cards.len()];
        for &i in chosen {
            more[i] = every(i);
            more[i].retain(|start| !screened[i].contains(start));
            screened[i].extend(more[i].iter().cloned());
        }
        for (promise, found) in promises.iter_mut().zip(screen_starts(data, beside, seen, cards, more)) {
            promise.take_in(found.starts);
        }
    };
    if all.iter().any(|s| s.len() > starts.first) {
        let leaders: Vec<usize> = best_first(&promises).into_iter().take(LEADERS).collect();
        go_on(&mut promises, &leaders, &|i| all[i].clone());
        // From one period no search finds its way to the next: where most effects get few starting values, those
        // that repeat and promise most get all periods.
        let periodic = best_first(&promises).into_iter().filter(|&i| cards[i].is_periodic());
        let periodic: Vec<usize> = periodic.take(PERIODIC_LEADERS).collect();
        go_on(&mut promises, &periodic, &|i| combinations(&cards[i].parameters, usize::MAX));
    }
    for (card, promise) in cards.iter().zip(&mut promises) {
        let starts = if starts.most >= DENSE { rugged::starts(data, beside, seen, card) } else { Vec::new() };
        for found in screen_starts(data, beside, seen, std::slice::from_ref(card), vec![starts]) {
            promise.take_in(found.starts);
        }
    }
    promises
}

/// Starts of a periodic or rugged parameter that are listed one by one.
pub(super) const LISTED: usize = 24;

/// A start whose signature is larger than the residual by the inverse of that is tried again, weaker: so far from
/// what is looked for, a signature says nothing where the effect is not linear (a rotor that sticks in its ripple).
const TOO_STRONG: f64 = 0.2;

/// As [`screen`], from these starts of each effect.
pub(super) fn screen_starts(
    data: &Data,
    beside: &Candidate,
    seen: &Excitation,
    cards: &[EffectCard],
    starts: Vec<Vec<Vec<f64>>>,
) -> Vec<Promise> {
    let mut found: Vec<Vec<(f64, Vec<f64>)>> = vec![Vec::new(); cards.len()];
    let jobs: Vec<(usize, Vec<f64>)> =
        starts.into_iter().enumerate().flat_map(|(c, all)| all.into_iter().map(move |s| (c, s))).collect();
    let weaker = promised(data, beside, seen, cards, jobs, &mut found);
    promised(data, beside, seen, cards, weaker, &mut found);
    cards
        .iter()
        .zip(found)
        .map(|(card, mut tried)| {
            tried.sort_by(|a, b| b.0.total_cmp(&a.0));
            let name = |p: &Parameter| format!("{}.{}", card.id, p.name);
            Promise {
                effect: card.id.clone(),
                drop: tried.first().map_or(0.0, |t| t.0),
                starts: tried
                    .into_iter()
                    .map(|(drop, s)| {
                        (drop, card.parameters.iter().zip(s).map(|(p, v)| (name(p), v)).collect())
                    })
                    .collect(),
            }
        })
        .collect()
}

/// Adds the predicted falls of the cost from starting values of effects, by their index, with the values at the
/// best amplitude; returns the starts that were too strong to tell, weaker.
fn promised(
    data: &Data,
    beside: &Candidate,
    seen: &Excitation,
    cards: &[EffectCard],
    jobs: Vec<(usize, Vec<f64>)>,
    found: &mut [Vec<(f64, Vec<f64>)>],
) -> Vec<(usize, Vec<f64>)> {
    let mut weaker = Vec::new();
    let coarse = beside.model.coarser(STEPS_PER_SAMPLE);
    // What cannot be simulated coarsely promises nothing.
    let unchanged = data.predict(coarse.as_ref(), &beside.fit.values).unwrap_or_default();
    let jobs = if unchanged.is_empty() { Vec::new() } else { jobs };
    for chunk in jobs.chunks(TOGETHER) {
        let predicted: Vec<Option<Vec<Prediction>>> = chunk
            .par_iter()
            .map(|(c, start)| {
                let model = coarse.with_effect(&cards[*c].id, seen).ok()?;
                let mut values = beside.fit.values.clone();
                values.extend_from_slice(start);
                data.predict(model.as_ref(), &values).ok()
            })
            .collect();
        let there: Vec<usize> = (0..chunk.len()).filter(|&i| predicted[i].is_some()).collect();
        let columns: Vec<&[Prediction]> = predicted.iter().flatten().map(Vec::as_slice).collect();
        if columns.is_empty() {
            continue;
        }
        let signatures = Signatures::new(data, &beside.fit, &unchanged, &columns);
        for (column, &job) in there.iter().enumerate() {
            let (c, start) = &chunk[job];
            let parameters = &cards[*c].parameters;
            let (stiffness, slope) = (signatures.gram[(column, column)], signatures.gradient[column]);
            if stiffness <= 0.0 || !stiffness.is_finite() {
                continue;
            }
            let both_ways = parameters.iter().any(|p| (is_amplitude(p) && p.min < 0.0) || p.name == PHASE);
            let least = if both_ways { -FARTHEST } else { 0.0 };
            // What cannot be scaled may still be too strong here, and right when it is weaker.
            let scales = parameters.iter().any(is_amplitude);
            let most = if scales { FARTHEST } else { 1.0 };
            let fits = (2.0 * beside.fit.cost / stiffness).sqrt();
            if scales && fits < TOO_STRONG {
                let scale = |(p, v): (&Parameter, &f64)| if is_amplitude(p) { v * fits } else { *v };
                weaker.push((*c, parameters.iter().zip(start).map(scale).collect()));
            }
            // A rugged effect is what it is or another one, never a part of it.
            let whole = parameters.iter().any(rugged::is_rugged);
            let amplitude = if whole { 1.0 } else { (-slope / stiffness).clamp(least, most) };
            let drop = -(slope * amplitude + 0.5 * stiffness * amplitude * amplitude);
            found[*c].push((drop, scaled(parameters, start, amplitude)));
        }
    }
    weaker
}

/// Whether the effect vanishes in proportion to this parameter.
pub(super) fn is_amplitude(p: &Parameter) -> bool {
    p.neutral == Some(0.0) && !p.fixed && p.scale == Scale::Linear
}

/// A start moved along its amplitude, but not so close to nothing that a search would not leave it.
fn scaled(parameters: &[Parameter], start: &[f64], amplitude: f64) -> Vec<f64> {
    let factor = if amplitude.abs() < 0.2 { 0.2_f64.copysign(amplitude) } else { amplitude };
    let periodic = parameters.iter().any(|p| p.name == PHASE);
    parameters
        .iter()
        .zip(start)
        .map(|(p, v)| match () {
            () if is_amplitude(p) && periodic => (v * factor.abs()).clamp(p.min, p.max),
            () if is_amplitude(p) => (v * factor).clamp(p.min, p.max),
            () if p.name == PHASE && factor < 0.0 => v - std::f64::consts::PI,
            () => *v,
        })
        .collect()
}

/// Every combination of guess and starts of each free parameter, the guesses first, `most` at most.
pub(super) fn combinations(parameters: &[Parameter], most: usize) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = vec![Vec::new()];
    for p in parameters {
        let mut options = vec![p.value];
        if !p.fixed {
            options.extend(p.starts.iter().filter(|s| **s != p.value));
        }
        all = options
            .iter()
            .flat_map(|&o| all.iter().map(move |before| before.iter().copied().chain([o]).collect()))
            .collect();
    }
    spread(&all, most)
}

/// So many of them at most, evenly over what there is, so that no parameter's starts are cut off.
fn spread(all: &[Vec<f64>], most: usize) -> Vec<Vec<f64>> {
    if all.len() <= most {
        return all.to_vec();
    }
    let step = all.len() as f64 / most as f64;
    (0..most).map(|i| all[(i as f64 * step) as usize].clone()).collect()
}

/// Ratio of amplitudes from which starts of one period are raced apart.
const ANOTHER_SIZE: f64 = 4.0;

/// Steps that every start of a periodic effect gets.
const RACE_STEPS: usize = 2;

/// A second opinion on a periodic effect, whose promise at a wrong amplitude says little where the rotor sticks
/// and slips: every period is fitted for a few steps with all else held, and the starts are ranked by that.
/// Of the periods at most `most`, those that promise most.
pub fn race_periodic(
    data: &Data,
    beside: &Candidate,
    seen: &Excitation,
    promise: Promise,
    most: usize,
) -> Promise {
    let is_phase = |name: &str| symbol(name, &promise.effect) == Some(PHASE);
    let Some((_, first)) = promise.starts.first() else { return promise };
    if !first.iter().any(|(name, _)| is_phase(name)) {
        return promise;
    }
    let Ok(model) = beside.model.with_effect(&promise.effect, seen) else { return promise };
    // The phases are found by the fit: of each period the more promising start goes on, and the next whose amplitude
    // is of another size, for a promise from too strong a ripple is none.
    let alike = |a: &[(String, f64)], b: &[(String, f64)]| {
        a[0].1.abs().max(b[0].1.abs()) < ANOTHER_SIZE * a[0].1.abs().min(b[0].1.abs())
    };
    let period = |start: &[(String, f64)]| -> Vec<u64> {
        start[1..].iter().filter(|(name, _)| !is_phase(name)).map(|(_, v)| v.to_bits()).collect()
    };
    let mut entered: Vec<&(f64, Vec<(String, f64)>)> = Vec::new();
    for start in &promise.starts {
        let same = || entered.iter().filter(|e| period(&e.1) == period(&start.1));
        if same().count() < 2 && same().all(|e| !alike(&e.1, &start.1)) {
            entered.push(start);
        }
    }
    entered.truncate(most);
    let mut raced: Vec<(f64, Vec<(String, f64)>)> = entered
        .par_iter()
        .map(|(drop, start)| {
            let mut values = beside.fit.values.clone();
            values.extend(start.iter().map(|(_, v)| *v));
            let options = FitOptions {
                start: Some(values),
                starts: 1,
                max_steps: RACE_STEPS,
                difference: Difference::Forward,
                only: Some(format!("{}.", promise.effect)),
                ..FitOptions::default()
            };
            match fit(data, model.as_ref(), &options) {
                Ok(fit) => {
                    let reached = fit.values[beside.fit.values.len()..].iter();
                    let start = start.iter().zip(reached).map(|((n, _), v)| (n.clone(), *v)).collect();
                    (beside.fit.cost - fit.cost, start)
                }
                Err(_) => (*drop, start.clone()),
            }
        })
        .collect();
    raced.sort_by(|a, b| b.0.total_cmp(&a.0));
    Promise { drop: raced[0].0.max(promise.drop), starts: raced, ..promise }
}

/// The effects that a candidate could still be given.
#[must_use]
pub fn addable(model: &dyn Model, seen: &Excitation, admitted: &[String]) -> Vec<EffectCard> {
    model.effects(seen).into_iter().filter(|c| admitted.contains(&c.id)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn combinations_cover_every_start_with_every_other() {
        let mut a = Parameter::new("a", "", 1.0, 0.0, 9.0);
        a.starts = vec![2.0, 3.0];
        let mut b = Parameter::new("b", "", 10.0, 0.0, 99.0);
        b.starts = vec![20.0];
        let all = combinations(&[a.clone(), b.clone()], 100);
        assert_eq!(all.len(), 6);
        assert_eq!(all[0], [1.0, 10.0]);
        assert!(all.contains(&vec![3.0, 20.0]));
        b.fixed = true;
        assert_eq!(combinations(&[a, b], 100).len(), 3);
    }
}
