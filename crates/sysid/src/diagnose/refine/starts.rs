//! Values that fits start from: with what is new weaker, with those of another fit place by place, with the base model's own
//! nominal ones.

use crate::diagnose::Candidate;
use crate::diagnose::candidate::{Known, is_amplitude, symbol};
use crate::diagnose::policy::{SLIGHTLY_WEAKER, WEAKENINGS, WEAKENINGS_OBSERVED};
use rayon::prelude::*;
use sealegs_model::{Model, Parameter};
use std::collections::BTreeSet;

/// Ratios to its fitted value from which a parameter that is free at last starts again: its prior is 50 %.
const FREED: [f64; 2] = [0.6, 1.4];

/// Values with the amplitudes of what a model has beyond a candidate's effects a part as strong.
pub(crate) fn weakened(model: &dyn Model, values: &[f64], near: &Candidate, part: f64) -> Vec<f64> {
    let added = |p: &Parameter| {
        let of_near = |effect: &String| symbol(&p.name, effect).is_some();
        is_amplitude(p) && p.name.contains('.') && !near.effects.iter().any(of_near)
    };
    let weaker = |(p, v): (&Parameter, &f64)| if added(p) { part * v } else { *v };
    model.parameters().iter().zip(values).map(weaker).collect()
}

/// The least cost of values with the amplitudes of what a model has beyond a candidate's effects ever weaker, and the values
/// that have it: a gap that is wide open lets nothing through, and no derivative says so.
pub(crate) fn weakest(
    model: &dyn Model,
    values: &[f64],
    near: &Candidate,
    cost: &(dyn Fn(&Vec<f64>) -> f64 + Sync),
) -> (f64, Vec<f64>) {
    let parts: Vec<f64> = (1..=WEAKENINGS_OBSERVED as i32).map(|n| SLIGHTLY_WEAKER.powi(n)).collect();
    let weaker = |part: &f64| {
        let values = weakened(model, values, near, *part);
        (cost(&values), values)
    };
    let all: Vec<(f64, Vec<f64>)> = parts.par_iter().map(weaker).collect();
    all.into_iter().reduce(|a, b| if b.0 < a.0 { b } else { a }).unwrap_or((f64::INFINITY, values.to_vec()))
}

/// Values with those of other ones taken over place by place (an actuator's base parameters) where that lowers the cost, and
/// with what was added weaker where that does. Beside a missing effect a fit in open loop drives the base parameters of the
/// place away that the effect is at, and those of its neighbours; under an observer those of the others are less well known.
pub(crate) fn mixed_by_place(
    model: &dyn Model,
    (mut values, mut least): (Vec<f64>, f64),
    other: &[f64],
    near: &Candidate,
    cost: &dyn Fn(&Vec<f64>) -> f64,
) -> Vec<f64> {
    let place = |p: &Parameter| match p.name.contains('.') {
        true => None,
        false => p.name.split_once('/').map(|(place, _)| place.to_owned()),
    };
    let places: Vec<Option<String>> = model.parameters().iter().map(place).collect();
    let distinct: BTreeSet<&String> = places.iter().flatten().collect();
    for place in distinct {
        let at = |i: usize| if places[i].as_ref() == Some(place) { other[i] } else { values[i] };
        let taken: Vec<f64> = (0..values.len()).map(at).collect();
        let cost = cost(&taken);
        if cost < least {
            (least, values) = (cost, taken);
        }
    }
    for _ in 0..WEAKENINGS as usize {
        let weaker = weakened(model, &values, near, SLIGHTLY_WEAKER);
        let cost = cost(&weaker);
        if weaker == values || cost >= least {
            break;
        }
        (least, values) = (cost, weaker);
    }
    values
}

/// Values with other starts of what a last fit frees: with it the search stayed in the minimum of the value that it held,
/// and another one may be lower.
pub(crate) fn freed(model: &dyn Model, values: &[f64]) -> Vec<Vec<f64>> {
    let parameters = model.parameters().iter().enumerate().filter(|(_, p)| p.freed_at_last);
    let starts =
        parameters.flat_map(|(i, p)| FREED.map(|ratio| (i, (ratio * values[i]).clamp(p.min, p.max))));
    starts
        .map(|(i, value)| {
            let mut start = values.to_vec();
            start[i] = value;
            start
        })
        .collect()
}

/// The same values with the nominal ones of the base model's free parameters: beside a missing effect a fit drives them
/// away, and under an observer the way from what the maker states is short.
pub(crate) fn with_nominal_base(base: &dyn Model, known: &Known) -> Known {
    let nominal = |name: &str| base.parameters().iter().find(|p| p.name == name && !p.fixed).map(|p| p.value);
    known.iter().map(|(name, value)| (name.clone(), nominal(name).unwrap_or(*value))).collect()
}
