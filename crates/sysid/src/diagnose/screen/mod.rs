//! Screening: what every effect, alone and in pairs, would gain beside a fitted model, by linear regression.
//!
//! An effect at one of its starting values changes the prediction: its signature. What the base parameters and the
//! sensors can do in its place is projected out, and the residual is regressed on what is left. Under an observer the
//! motion is the measured one, so that a signature is the effect's own force and not what a whole run makes of it.
//! Signatures of several effects are regressed together: effects that explain something only together show there.

pub(super) mod counting;
pub(super) mod periods;

use crate::data::Data;
use crate::diagnose::Candidate;
use crate::diagnose::candidate::{Known, is_amplitude};
use crate::diagnose::policy::{
    ANYHOW, FARTHEST, HALF_AS_STRONG, LOOKED_AT_AGAIN, LOOKS, LOOKS_ALIKE, NEAREST, PAIR_WORTH, PAIRED,
    PROMISE_HELD, PROMISE_KEPT, PROMISES_LITTLE, SCREEN_STEPS_PER_SAMPLE, SHORTLIST, SHORTLIST_PAIRS,
};
use crate::diagnose::refine::count;
use crate::fit::Signatures;
use rayon::prelude::*;
use sealegs_model::{EffectCard, Excitation, Model, Parameter, Prediction, Scale};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Signatures that are taken together in the first look: bounds the memory that they need.
const TOGETHER: usize = 8;

/// Starting values of each effect that are looked at again, together with those of all others.
const KEPT: usize = 2;

/// The parameter that makes an effect periodic.
pub(crate) const PHASE: &str = EffectCard::PHASE;

/// An effect at starting values, with the fall of the cost that it promises.
#[derive(Debug, Clone, PartialEq)]
pub struct Promise {
    /// The effect's id.
    pub effect: String,
    /// Predicted fall of the cost.
    pub drop: f64,
    /// Starting values of the effect's parameters.
    pub start: Known,
}

/// Effects to be fitted together, and from where.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// What is added, one effect or two.
    pub added: Vec<String>,
    /// Predicted fall of the cost.
    pub drop: f64,
    /// Starting values of all their parameters.
    pub start: Known,
}

/// What screening found beside a candidate.
#[derive(Debug, Clone, Default)]
pub struct Screened {
    /// Each effect at its best starting values, the most promising first.
    pub promises: Vec<Promise>,
    /// The most promising pairs.
    pub pairs: Vec<Plan>,
}

impl Screened {
    /// What is fitted: the most promising effects alone, then pairs that promise clearly more than either half. Of a set that
    /// has effects already, `grows`, what promises next to nothing in comparison is left out.
    #[must_use]
    pub fn plans(&self, left: f64, grows: bool) -> Vec<Plan> {
        let best = self.promises.first().map_or(0.0, |p| p.drop);
        let least =
            |place: usize| if grows && place >= ANYHOW as usize { PROMISES_LITTLE * best } else { 0.0 };
        let alone = self.promises.iter().enumerate().filter(|(place, p)| p.drop > least(*place));
        let alone = alone.take(SHORTLIST as usize).map(|(_, p)| Plan {
            added: vec![p.effect.clone()],
            drop: p.drop,
            start: p.start.clone(),
        });
        let worth = (PAIR_WORTH * (left - best)).max(0.0);
        let pairs = self.pairs.iter().filter(|p| p.drop > best + worth).take(SHORTLIST_PAIRS as usize);
        alone.chain(pairs.cloned()).collect()
    }
}

/// One look at an effect from starting values.
#[derive(Debug, Clone)]
pub(crate) struct Look {
    /// The effect, by its place among the cards.
    pub card: usize,
    /// Values of its parameters, as strong as they help most.
    pub start: Vec<f64>,
    /// Predicted fall of the cost.
    pub drop: f64,
    /// Fall of the cost as it was simulated.
    pub simulated: f64,
}

/// Screens effects beside a candidate, each from so many starting values at most.
///
/// An effect that cannot be simulated promises nothing.
#[must_use]
pub fn screen(
    data: &Data,
    beside: &Candidate,
    seen: &Excitation,
    cards: &[EffectCard],
    starts: usize,
) -> Screened {
    let cards: Vec<EffectCard> =
        cards.par_iter().map(|card| periods::with_periods(data, beside, card)).collect();
    let dear = beside.model.is_dear();
    let mut jobs: Vec<(usize, Vec<f64>)> = Vec::new();
    for (c, card) in cards.iter().enumerate() {
        // A periodic effect's starts are its periods, a resonance's where something is loud: none of them leads to another.
        let resonates = card.parameters.iter().any(|p| p.name == periods::RESONANCE);
        let most = if card.is_periodic() || (resonates && !dear) { usize::MAX } else { starts };
        jobs.extend(combinations(&card.parameters, most).into_iter().map(|s| (c, s)));
        jobs.extend(counting::starts(data, beside, seen, card).into_iter().map(|s| (c, s)));
    }
    let looks = looks(data, beside, seen, &cards, &jobs);
    together(data, beside, seen, &cards, looks)
}

/// Predictions of all runs with one more effect at starting values.
fn changed(
    data: &Data,
    (coarse, values): (&dyn Model, &[f64]),
    seen: &Excitation,
    card: &EffectCard,
    start: &[f64],
) -> Option<Vec<Prediction>> {
    let model = coarse.with_effect(&card.id, seen).ok()?;
    let values: Vec<f64> = values.iter().chain(start).copied().collect();
    data.predict_outputs(model.as_ref(), &values).ok()
}

/// What effects (by their places among the cards) promise from starting values, the most promising first.
pub(crate) fn looks(
    data: &Data,
    beside: &Candidate,
    seen: &Excitation,
    cards: &[EffectCard],
    jobs: &[(usize, Vec<f64>)],
) -> Vec<Look> {
    let coarse = beside.model.coarser(SCREEN_STEPS_PER_SAMPLE);
    let base = (coarse.as_ref(), &beside.fit.values[..]);
    let Ok(unchanged) = data.predict_outputs(base.0, base.1) else { return Vec::new() };
    let mut looks: Vec<Look> = Vec::new();
    for chunk in jobs.chunks(TOGETHER) {
        // A wave is looked at in both of its phases: alone neither tells much of a wave between them.
        let starts: Vec<(usize, Vec<f64>)> = chunk
            .iter()
            .enumerate()
            .flat_map(|(job, (c, start))| {
                let quarter = quarter_later(&cards[*c].parameters, start);
                std::iter::once(start.clone()).chain(quarter).map(move |start| (job, start))
            })
            .collect();
        let predicted: Vec<_> = starts
            .par_iter()
            .map(|(job, start)| changed(data, base, seen, &cards[chunk[*job].0], start))
            .collect();
        let there: Vec<usize> = (0..starts.len()).filter(|&i| predicted[i].is_some()).collect();
        let columns: Vec<&[Prediction]> = predicted.iter().flatten().map(Vec::as_slice).collect();
        if columns.is_empty() {
            continue;
        }
        let signatures = Signatures::new(data, &beside.fit, &unchanged, &columns);
        for (job, (card, start)) in chunk.iter().enumerate() {
            let own: Vec<usize> = (0..there.len()).filter(|&c| starts[there[c]].0 == job).collect();
            let p = &cards[*card].parameters;
            let found = match own[..] {
                [even, odd] => {
                    wave(p, &signatures, (even, odd), start).map(|(start, drop)| (start, drop, drop))
                }
                [column] => best_amplitude(p, &signatures, column).map(|(amplitude, drop)| {
                    (scaled(p, start, amplitude, 0.0), drop, fall(&signatures, column, 1.0))
                }),
                _ => None,
            };
            looks.extend(found.map(|(start, drop, simulated)| Look { card: *card, start, drop, simulated }));
        }
    }
    looks.sort_by(|a, b| b.drop.total_cmp(&a.drop));
    looks
}

/// A start of an effect with a phase a quarter of a turn later; `None` of any other effect.
fn quarter_later(parameters: &[Parameter], start: &[f64]) -> Option<Vec<f64>> {
    let phase = parameters.iter().position(|p| p.name == PHASE && !p.fixed)?;
    let mut later = start.to_vec();
    later[phase] += FRAC_PI_2;
    Some(later)
}

/// A start of an effect with a phase, as strong and in the phase that helps most, given the signatures of it and of it a quarter
/// of a turn later; with the predicted fall of the cost.
fn wave(
    parameters: &[Parameter],
    signatures: &Signatures,
    (even, odd): (usize, usize),
    start: &[f64],
) -> Option<(Vec<f64>, f64)> {
    let (drop, best, turn) = signatures.wave(even, odd);
    // What a part of the best amplitude gains is a parabola.
    let amplitude = best.min(range(parameters).1);
    let part = amplitude / best;
    let drop = drop * part * (2.0 - part);
    (drop.is_finite() && amplitude > 0.0).then(|| {
        let mut best = scaled(parameters, start, amplitude, 0.0);
        for (value, p) in best.iter_mut().zip(parameters).filter(|(_, p)| p.name == PHASE) {
            let turned = *value + turn;
            *value = turned - TAU * ((turned - p.min) / TAU).floor();
        }
        (best, drop)
    })
}

/// Looks at the best starts again, as strong as they promised to be, and regresses them together. An effect that promises next
/// to nothing beside the best one keeps its first promise.
fn together(
    data: &Data,
    beside: &Candidate,
    seen: &Excitation,
    cards: &[EffectCard],
    looks: Vec<Look>,
) -> Screened {
    let coarse = beside.model.coarser(SCREEN_STEPS_PER_SAMPLE);
    let base = (coarse.as_ref(), &beside.fit.values[..]);
    let Ok(unchanged) = data.predict_outputs(base.0, base.1) else { return Screened::default() };
    let least = looks.first().map_or(0.0, |best| LOOKED_AT_AGAIN * best.drop);
    let mut kept: Vec<Look> = Vec::new();
    let mut others: Vec<Look> = Vec::new();
    for look in looks {
        let same = kept.iter().filter(|k| k.card == look.card);
        let alike = |k: &Look| (k.simulated - look.simulated).abs() <= LOOKS_ALIKE * look.simulated.abs();
        if look.drop < least && kept.len() >= KEPT * PAIRED as usize {
            others.push(look);
        } else if same.clone().count() < KEPT && !same.into_iter().any(alike) {
            kept.push(look);
        }
    }
    let signature = |look: &Look| changed(data, base, seen, &cards[look.card], &look.start);
    let (kept, columns) = simulated(data, beside, &unchanged, cards, kept, &signature);
    if kept.is_empty() {
        return Screened::default();
    }
    let columns: Vec<&[Prediction]> = columns.iter().map(Vec::as_slice).collect();
    let signatures = Signatures::new(data, &beside.fit, &unchanged, &columns);
    let named = |look: &Look, amplitude: f64| -> Known {
        let card = &cards[look.card];
        let values = scaled(&card.parameters, &look.start, amplitude, NEAREST);
        card.parameters.iter().zip(values).map(|(p, v)| (format!("{}.{}", card.id, p.name), v)).collect()
    };
    let mut order: Vec<usize> = (0..kept.len()).collect();
    order.sort_by(|&a, &b| kept[b].simulated.total_cmp(&kept[a].simulated));
    let mut promises: Vec<Promise> = Vec::new();
    let mut best: Vec<usize> = Vec::new();
    for i in order {
        let effect = &cards[kept[i].card].id;
        if promises.iter().all(|p| p.effect != *effect) {
            let start = named(&kept[i], 1.0);
            promises.push(Promise { effect: effect.clone(), drop: kept[i].simulated, start });
            best.push(i);
        }
    }
    for look in others {
        let effect = &cards[look.card].id;
        if promises.iter().all(|p| p.effect != *effect) {
            let drop = look.drop.min(look.simulated);
            promises.push(Promise { effect: effect.clone(), drop, start: named(&look, 1.0) });
        }
    }
    promises.sort_by(|a, b| b.drop.total_cmp(&a.drop));
    best.truncate(PAIRED as usize);
    let mut pairs: Vec<Plan> = Vec::new();
    for (n, &i) in best.iter().enumerate() {
        for &j in &best[n + 1..] {
            let (drop, amplitudes) = signatures.drop(&[i, j]);
            let admitted = |look: usize, amplitude: f64| {
                let (least, most) = range(&cards[kept[look].card].parameters);
                (least..=most).contains(&amplitude) && amplitude != 0.0
            };
            if drop.is_finite() && admitted(i, amplitudes[0]) && admitted(j, amplitudes[1]) {
                let mut start = named(&kept[i], amplitudes[0]);
                start.extend(named(&kept[j], amplitudes[1]));
                let added = [i, j].map(|k| cards[kept[k].card].id.clone()).to_vec();
                pairs.push(Plan { added, drop, start });
            }
        }
    }
    pairs.sort_by(|a, b| b.drop.total_cmp(&a.drop));
    Screened { promises, pairs }
}

/// Looks as strong as they help most, with what is simulated there. What an effect promises is linear in its strength, which
/// a gap that is wide open or a limit that is reached is not: each is simulated again at the strength that it promised to
/// help most with until that holds. Where the promise is broken it is weakened as long as it helps no less, as nothing leads
/// away from where an effect is at its end.
fn simulated(
    data: &Data,
    beside: &Candidate,
    unchanged: &[Prediction],
    cards: &[EffectCard],
    looks: Vec<Look>,
    signature: &(dyn Fn(&Look) -> Option<Vec<Prediction>> + Sync),
) -> (Vec<Look>, Vec<Vec<Prediction>>) {
    let mut there: Vec<Option<(Look, Vec<Prediction>)>> = vec![None; looks.len()];
    let mut pending: Vec<(usize, Look)> = looks.into_iter().enumerate().collect();
    for _ in 0..LOOKS as usize {
        let predicted: Vec<_> = pending.par_iter().map(|(_, look)| signature(look)).collect();
        let (now, columns): (Vec<_>, Vec<_>) =
            pending.drain(..).zip(predicted).filter_map(|(look, p)| Some((look, p?))).unzip();
        if now.is_empty() {
            break;
        }
        let slices: Vec<&[Prediction]> = columns.iter().map(Vec::as_slice).collect();
        let signatures = Signatures::new(data, &beside.fit, unchanged, &slices);
        for (i, ((place, mut look), column)) in now.into_iter().zip(columns).enumerate() {
            let parameters = &cards[look.card].parameters;
            let Some((amplitude, drop)) = best_amplitude(parameters, &signatures, i) else { continue };
            look.simulated = fall(&signatures, i, 1.0);
            let best = there[place].as_ref().map_or(f64::NEG_INFINITY, |(best, _)| best.simulated);
            let no_less = look.simulated >= best - LOOKS_ALIKE * best.abs();
            let held = (1.0 / PROMISE_HELD..=PROMISE_HELD).contains(&amplitude);
            let next = match look.simulated < PROMISE_KEPT * look.drop {
                true if no_less => Some((HALF_AS_STRONG, look.drop)),
                false if !held && drop > best => Some((amplitude, drop)),
                _ => None,
            };
            if let Some((amplitude, drop)) = next {
                let start = scaled(parameters, &look.start, amplitude, NEAREST);
                if start != look.start {
                    pending.push((place, Look { start, drop, ..look.clone() }));
                }
            }
            if no_less {
                there[place] = Some((look, column));
            }
        }
    }
    there.into_iter().flatten().unzip()
}

/// By how much the cost falls with a signature of an amplitude.
fn fall(signatures: &Signatures, column: usize, amplitude: f64) -> f64 {
    let (stiffness, slope) = (signatures.gram[(column, column)], signatures.gradient[column]);
    -(slope * amplitude + 0.5 * stiffness * amplitude * amplitude)
}

/// The amplitude of a signature, 1 as it was simulated, that lowers the cost most, and by how much; `None` where it
/// changes nothing.
fn best_amplitude(parameters: &[Parameter], signatures: &Signatures, column: usize) -> Option<(f64, f64)> {
    let (stiffness, slope) = (signatures.gram[(column, column)], signatures.gradient[column]);
    if stiffness <= 0.0 || !stiffness.is_finite() || !slope.is_finite() {
        return None;
    }
    let (least, most) = range(parameters);
    let amplitude = if least == most { most } else { (-slope / stiffness).clamp(least, most) };
    Some((amplitude, fall(signatures, column, amplitude)))
}

/// Amplitudes that are admitted: an effect without a strength is what it is at its start, or a part of that; one that is
/// found by counting is it or another one, never a part.
fn range(parameters: &[Parameter]) -> (f64, f64) {
    if parameters.iter().any(count::is_count) {
        return (1.0, 1.0);
    }
    let both_ways =
        parameters.iter().any(|p| (is_amplitude(p) && p.min < 0.0) || is_ratio(p) || p.name == PHASE);
    let scales = parameters.iter().any(|p| is_amplitude(p) || is_ratio(p));
    (if both_ways { -FARTHEST } else { 0.0 }, if scales { FARTHEST } else { 1.0 })
}

/// Whether the effect vanishes where this parameter is a certain ratio between its bounds.
fn is_ratio(p: &Parameter) -> bool {
    let inside = p.neutral.is_some_and(|n| p.min < n && n < p.max);
    inside && !p.fixed && p.scale == Scale::Logarithmic
}

/// A start moved along its amplitude, but not closer to nothing than a share.
fn scaled(parameters: &[Parameter], start: &[f64], amplitude: f64, nearest: f64) -> Vec<f64> {
    // The first look scales by any factor but zero; nothing is left of a start at zero.
    let least = nearest.max(1e-3);
    let factor = if amplitude.abs() < least { least.copysign(amplitude) } else { amplitude };
    let periodic = parameters.iter().any(|p| p.name == PHASE);
    parameters
        .iter()
        .zip(start)
        .map(|(p, v)| match () {
            () if is_amplitude(p) && periodic => (v * factor.abs()).clamp(p.min, p.max),
            () if is_amplitude(p) => (v * factor).clamp(p.min, p.max),
            () if is_ratio(p) => {
                let neutral = p.neutral.unwrap_or(1.0);
                (neutral * (v / neutral).powf(factor)).clamp(p.min, p.max)
            }
            () if p.name == PHASE && factor < 0.0 => v - std::f64::consts::PI,
            () => *v,
        })
        .collect()
}

/// Every combination of guess and starts of each free parameter, the guesses first, `most` at most.
pub(crate) fn combinations(parameters: &[Parameter], most: usize) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = vec![Vec::new()];
    for p in parameters {
        let mut options = vec![p.value];
        // What is listed in full is a count, which has a search of its own.
        if !p.fixed && !count::is_count(p) {
            options.extend(p.starts.iter().filter(|s| **s != p.value));
        }
        all = options
            .iter()
            .flat_map(|&o| all.iter().map(move |before| before.iter().copied().chain([o]).collect()))
            .collect();
    }
    if all.len() <= most {
        return all;
    }
    // Evenly over what there is, so that no parameter's starts are cut off.
    let step = all.len() as f64 / most as f64;
    (0..most).map(|i| all[(i as f64 * step) as usize].clone()).collect()
}

/// The effects that a model could still be given, out of those admitted.
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

    #[test]
    fn a_pair_is_planned_only_where_it_promises_more_than_its_better_half() {
        let promise = |effect: &str, drop: f64| Promise { effect: effect.into(), drop, start: Vec::new() };
        let pair = |drop: f64| Plan { added: vec!["a".into(), "b".into()], drop, start: Vec::new() };
        let screened = |drop: f64| Screened {
            promises: vec![promise("a", 60.0), promise("b", 5.0)],
            pairs: vec![pair(drop)],
        };
        assert_eq!(screened(62.0).plans(100.0, false).len(), 2);
        assert_eq!(screened(90.0).plans(100.0, false).len(), 3);
    }

    #[test]
    fn beside_effects_what_promises_next_to_nothing_is_not_planned() {
        let promise = |drop: f64| Promise { effect: format!("{drop}"), drop, start: Vec::new() };
        let promises = [60.0, 20.0, 0.9, 0.8, 0.7].map(promise).to_vec();
        let screened = Screened { promises, pairs: Vec::new() };
        assert_eq!(screened.plans(100.0, false).len(), 5);
        assert_eq!(screened.plans(100.0, true).len(), 3);
    }
}
