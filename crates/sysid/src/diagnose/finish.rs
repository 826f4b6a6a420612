//! What leads a race is fitted to the end: further steps, other starts where it came to rest on its way, and at last
//! the model itself in the place of the search's coarser one.

use super::candidate::{Effort, symbol};
use super::known_base::{is_driven, with_nominal_base};
use super::left::FAR_ABOVE;
use super::screen::{LISTED, PHASE, is_amplitude};
use super::search::Search;
use super::{Candidate, rugged, with_effects};
use crate::data::Data;
use crate::fit::{self, FitOptions};
use rayon::prelude::*;
use sealegs_model::{Model, Scale};
use std::f64::consts::{PI, TAU};

/// Ratios by which a parameter of an effect is moved to look for a better valley.
const SHAKES: [f64; 18] =
    [0.6, 0.7, 0.78, 0.84, 0.89, 0.93, 0.96, 0.98, 0.99, 1.01, 1.02, 1.04, 1.07, 1.12, 1.18, 1.27, 1.4, 1.6];

/// Most steps with the model itself where derivatives are dear: by then they gain less than a parameter's error.
const DEAR_STEPS: usize = 8;

/// Times that a better valley is looked for.
const VALLEYS: usize = 3;

/// Steps in which the other parameters follow one that was moved.
const FOLLOWING_STEPS: usize = 3;

/// Times that a lower place is looked for on the slope of a strength.
const DESCENTS: usize = 8;

/// How far it is looked for, as logarithms of ratios, and points to each side.
const SLOPES: [f64; 3] = [0.7, 0.12, 0.02];
/// See [`SLOPES`].
const SLOPE_POINTS: i32 = 12;

/// Ratios by which a strength is moved where the others must follow it to a lower place.
const NUDGES: [f64; 8] = [0.95, 0.98, 0.992, 0.997, 1.003, 1.008, 1.02, 1.05];

/// Distance from a whole number, as a ratio, beyond which a fit has come to rest between two.
const WHOLE: f64 = 3e-4;

/// Phases that are tried at a whole number.
const QUARTERS: u32 = 4;

/// Share of the cost that another valley must gain at once where a fit is dear.
const BETTER: f64 = 0.02;

impl Search<'_> {
    /// A candidate whose fit has converged, if it can.
    pub(super) fn finished(&self, candidate: Candidate) -> Candidate {
        // With secants alone an end is only a guess.
        if candidate.fit.converged && !self.options.secants {
            return self.tuned(candidate);
        }
        let fitted = self
            .fitted_near(&candidate, &candidate.effects, &candidate.known())
            .filter(|f| f.fit.cost <= candidate.fit.cost);
        self.tuned(fitted.unwrap_or(candidate))
    }

    /// The candidate with its rugged parameters looked for again, where simulations are cheap.
    fn tuned(&self, candidate: Candidate) -> Candidate {
        if self.options.secants {
            return candidate;
        }
        rugged::tuned(self.data, candidate, |near, known| self.fitted_near(near, &near.effects, known))
    }

    /// The candidate, or its fit from the base parameters' nominal values if that is better: without an effect a wrong
    /// model may have driven them so far that a search from there comes to rest half way back.
    pub(super) fn returned(&self, candidate: Candidate) -> Candidate {
        if !is_driven(self.base, &candidate) || self.is_settled(&candidate) {
            return candidate;
        }
        let known = with_nominal_base(self.base, candidate.known());
        self.fitted_near(&candidate, &candidate.effects, &known)
            .filter(|f| f.fit.cost < candidate.fit.cost)
            .unwrap_or(candidate)
    }

    /// The candidate, or its fit from a better valley nearby: where contact is made and broken, a rotor sticks or a part
    /// rings for long, the error has many along a parameter of the effect, and steps down a slope lead to the nearest
    /// one.
    pub(super) fn shaken(&self, mut candidate: Candidate) -> Candidate {
        for _ in 0..VALLEYS {
            let far = candidate.fit.error() > self.options.shaken_below * self.data.floor;
            if far || self.is_settled(&candidate) {
                break;
            }
            let (moved, costs): (Vec<Vec<f64>>, Vec<f64>) = self.shakes(&candidate).into_iter().unzip();
            let mut order: Vec<usize> = (0..moved.len()).collect();
            order.sort_by(|&a, &b| costs[a].total_cmp(&costs[b]));
            order.truncate(self.options.shakes_fitted);
            let at_once = |i: usize| costs[i] <= (1.0 - BETTER) * candidate.fit.cost;
            order.retain(|&i| costs[i].is_finite() && (!self.options.secants || at_once(i)));
            let fitted: Vec<Option<Candidate>> = order
                .par_iter()
                .map(|&i| self.fitted_near(&candidate, &candidate.effects, &candidate.named(&moved[i])))
                .collect();
            let best =
                fitted.into_iter().flatten().reduce(|a, b| if b.fit.cost < a.fit.cost { b } else { a });
            match best {
                Some(best) if best.fit.cost < candidate.fit.cost => candidate = best,
                _ => break,
            }
        }
        candidate
    }

    /// The candidate, or its fit from the nearest whole number of periods if that is better: with a number that is a
    /// little off, the wave fits a part of the motion only, and steps down the slope do not cross to the next part.
    pub(super) fn whole(&self, candidate: Candidate) -> Candidate {
        if self.is_settled(&candidate) {
            return candidate;
        }
        let (fit, model) = (&candidate.fit, candidate.model.as_ref());
        let near = |i: usize| {
            let p = &model.parameters()[i];
            let listed = (p.starts.len() >= LISTED && p.scale == Scale::Linear).then_some(&p.starts)?;
            let distance = |s: f64| (s - fit.values[i]).abs();
            let nearest = listed.iter().copied().min_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
            (distance(nearest) > WHOLE * nearest.abs()).then_some(nearest)
        };
        let Some((i, number)) = fit.free.iter().find_map(|&i| near(i).map(|n| (i, n))) else {
            return candidate;
        };
        let name = model.parameters()[i].name.clone();
        let effect = name.rsplit_once('.').map_or("", |(effect, _)| effect);
        let phase = model.parameters().iter().position(|p| symbol(&p.name, effect) == Some(PHASE));
        let turned: Vec<Vec<f64>> = (0..QUARTERS)
            .map(|quarter| {
                let mut values = fit.values.clone();
                values[i] = number;
                if let Some(phase) = phase {
                    let turn = f64::from(quarter) * TAU / f64::from(QUARTERS);
                    values[phase] = (values[phase] + turn + PI).rem_euclid(TAU) - PI;
                }
                values
            })
            .collect();
        let followed: Vec<(Vec<f64>, f64)> = turned
            .into_par_iter()
            .filter_map(|start| {
                following(self.data, model, start, i, &Effort::steps(self.options.race_steps))
            })
            .collect();
        let best = followed.into_iter().reduce(|a, b| if b.1 < a.1 { b } else { a });
        best.and_then(|(values, _)| {
            self.fitted_near(&candidate, &candidate.effects, &candidate.named(&values))
        })
        .filter(|f| f.fit.cost < candidate.fit.cost)
        .unwrap_or(candidate)
    }

    /// The candidate, or its fit from a lower place along the strength of an effect: beside a play or a dry friction the
    /// error has many valleys on the slope to the lowest one, and steps by derivatives end in the first. Where
    /// simulations are cheap, and much is left.
    pub(super) fn descended(&self, mut candidate: Candidate) -> Candidate {
        for _ in 0..DESCENTS {
            if self.options.secants || candidate.fit.error() <= FAR_ABOVE * self.data.floor {
                break;
            }
            let (fit, model) = (&candidate.fit, candidate.model.as_ref());
            let strength =
                |i: &usize| *i >= self.base.parameters().len() && is_amplitude(&model.parameters()[*i]);
            let moved: Vec<Vec<f64>> = fit
                .free
                .iter()
                .copied()
                .filter(strength)
                .flat_map(|i| {
                    let p = &model.parameters()[i];
                    let ratios = SLOPES.iter().flat_map(|width| {
                        (-SLOPE_POINTS..=SLOPE_POINTS)
                            .filter(|k| *k != 0)
                            .map(move |k| (f64::from(k) * width / f64::from(SLOPE_POINTS)).exp())
                    });
                    ratios.map(move |ratio| {
                        let mut values = fit.values.clone();
                        values[i] = (values[i] * ratio).clamp(p.min, p.max);
                        values
                    })
                })
                .collect();
            let costs: Vec<f64> = moved
                .par_iter()
                .map(|values| self.data.evaluate(model, values).map_or(f64::INFINITY, |e| e.cost))
                .collect();
            let lowest = (0..costs.len()).reduce(|a, b| if costs[b] < costs[a] { b } else { a });
            let straight = lowest.filter(|&i| costs[i] < fit.cost).map(|i| moved[i].clone());
            let Some(start) = straight.or_else(|| self.followed(&candidate, strength)) else { break };
            match self.fitted_near(&candidate, &candidate.effects, &candidate.named(&start)) {
                Some(lower) if lower.fit.cost < (1.0 - BETTER) * candidate.fit.cost => candidate = lower,
                _ => break,
            }
        }
        candidate
    }

    /// A lower place near the candidate, where each strength was moved a little and all others followed it.
    fn followed(&self, candidate: &Candidate, strength: impl Fn(&usize) -> bool) -> Option<Vec<f64>> {
        let model = candidate.model.as_ref();
        let places: Vec<(Vec<f64>, f64)> = moved(candidate, &candidate.fit.values, strength, &NUDGES)
            .into_par_iter()
            .filter_map(|(i, start)| following(self.data, model, start, i, &Effort::steps(FOLLOWING_STEPS)))
            .collect();
        let lowest = places.into_iter().reduce(|a, b| if b.1 < a.1 { b } else { a });
        lowest.filter(|(_, cost)| *cost < candidate.fit.cost).map(|(values, _)| values)
    }

    /// Values with each parameter of the effects moved by some ratios, and their costs; on a bench the others follow
    /// for a few steps.
    fn shakes(&self, candidate: &Candidate) -> Vec<(Vec<f64>, f64)> {
        let (fit, model) = (&candidate.fit, candidate.model.as_ref());
        // Where fits are cheap, those are shaken whose order of magnitude was unknown: a frequency, a stiffness.
        let rugged = |i: usize| self.options.secants || model.parameters()[i].scale == Scale::Logarithmic;
        let own = |i: &usize| *i >= self.base.parameters().len() && rugged(*i);
        let mut moved = moved(candidate, &fit.values, own, &SHAKES);
        moved.retain(|(i, values)| values[*i] != fit.values[*i]);
        let looked_at = |(i, moved): (usize, Vec<f64>)| {
            if self.options.secants {
                let cost = self.data.evaluate(model, &moved).map_or(f64::INFINITY, |e| e.cost);
                return (moved, cost);
            }
            following(self.data, model, moved.clone(), i, &Effort::steps(FOLLOWING_STEPS))
                .unwrap_or((moved, f64::INFINITY))
        };
        moved.into_par_iter().map(looked_at).collect()
    }

    /// The candidate fitted to the end with the model itself, and derivatives good enough for standard errors.
    pub(super) fn polished(&self, candidate: &Candidate) -> Candidate {
        let options = FitOptions {
            max_steps: if self.options.secants { DEAR_STEPS } else { FitOptions::default().max_steps },
            last: true,
            ..candidate.onward(self.exact, candidate.fit.values.clone())
        };
        with_effects(self.exact, &candidate.effects, self.seen)
            .and_then(|model| {
                rugged::fit_holding(self.data, model.as_ref(), &options).map(|fit| (model, fit))
            })
            .map_or_else(
                |_| candidate.clone(),
                |(model, fit)| Candidate::exactly(self.data, candidate.effects.clone(), model, fit),
            )
    }
}

/// Values with one parameter held where it starts, while the others follow for a few steps, with the cost.
pub(super) fn following(
    data: &Data,
    model: &dyn Model,
    start: Vec<f64>,
    held: usize,
    effort: &Effort,
) -> Option<(Vec<f64>, f64)> {
    let options = FitOptions {
        start: Some(start),
        starts: 1,
        max_steps: effort.steps,
        difference: effort.difference,
        last: effort.last,
        held: vec![model.parameters()[held].name.clone()],
        ..FitOptions::default()
    };
    fit::fit(data, model, &options).ok().map(|f| (f.values, f.cost))
}

/// Values with each of some of a candidate's free parameters moved by each ratio, as far as its bounds admit.
pub(super) fn moved(
    candidate: &Candidate,
    values: &[f64],
    which: impl Fn(&usize) -> bool,
    ratios: &[f64],
) -> Vec<(usize, Vec<f64>)> {
    let parameters = candidate.model.parameters();
    let by = |i: usize, ratio: f64| {
        let mut moved = values.to_vec();
        moved[i] = (values[i] * ratio).clamp(parameters[i].min, parameters[i].max);
        (i, moved)
    };
    let own = candidate.fit.free.iter().copied().filter(which);
    own.flat_map(|i| ratios.iter().map(move |ratio| (i, *ratio))).map(|(i, ratio)| by(i, ratio)).collect()
}
