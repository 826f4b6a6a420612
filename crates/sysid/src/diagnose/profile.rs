//! How far a fitted parameter can go before the error rises, with the others following: where the error has many valleys,
//! derivatives see the walls of one and promise more than the data.

use super::candidate::{Candidate, Effort};
use super::finish::{following, moved};
use super::search::Search;
use crate::fit::EQUAL_COST;
use rayon::prelude::*;
use sealegs_model::Scale;

/// Ratios by which a parameter of an effect is moved.
const RATIOS: [f64; 6] = [0.8, 0.93, 0.98, 1.02, 1.07, 1.25];

/// Steps in which the others follow.
const STEPS: usize = 3;

/// Share of what the effects explain that a place may lose: a resonance that has left its peak loses all, and no more
/// however far it goes.
const LOST: f64 = 0.01;

/// Times that a lower valley is gone to.
const VALLEYS: usize = 2;

/// Values in some distance from the fit's, and the cost there.
pub(super) type Place = (Vec<f64>, f64);

impl Search<'_> {
    /// The candidate in the lowest valley that is found beside it, and how far each of its values could be without a higher
    /// cost than noise makes. Where simulations are cheap, and along parameters of unknown order of magnitude: a
    /// frequency, a stiffness.
    pub(super) fn profiled(&self, mut candidate: Candidate) -> (Candidate, Vec<f64>) {
        if self.options.secants {
            let none = vec![0.0; candidate.fit.values.len()];
            return (candidate, none);
        }
        let mut places = self.places(&candidate);
        for _ in 0..VALLEYS {
            let lowest = places.iter().min_by(|a, b| a.1.total_cmp(&b.1));
            let lower = lowest
                .filter(|(_, cost)| cost + EQUAL_COST < candidate.fit.cost)
                .and_then(|(start, _)| {
                    self.fitted_near(&candidate, &candidate.effects, &candidate.named(start))
                })
                .filter(|lower| lower.fit.cost + EQUAL_COST < candidate.fit.cost);
            let Some(lower) = lower else { break };
            candidate = lower;
            places = self.places(&candidate);
        }
        let explained = self.tried[0].fit.cost - candidate.fit.cost;
        places.retain(|(_, cost)| cost - candidate.fit.cost <= LOST * explained);
        let room = room(&candidate, &places);
        (candidate, room)
    }

    /// Places to which the others followed a parameter that was moved.
    fn places(&self, candidate: &Candidate) -> Vec<Place> {
        let (fit, model) = (&candidate.fit, candidate.model.as_ref());
        let parameters = model.parameters();
        let of_unknown_order =
            |i: &usize| *i >= self.base.parameters().len() && parameters[*i].scale == Scale::Logarithmic;
        let mut moved = moved(candidate, &fit.values, of_unknown_order, &RATIOS);
        moved.retain(|(i, values)| values[*i] != fit.values[*i]);
        let effort = Effort { last: true, ..Effort::steps(STEPS) };
        let follow = |(i, start)| following(self.data, model, start, i, &effort);
        moved.into_par_iter().filter_map(follow).collect()
    }
}

/// The greatest `|x - x_0| / sqrt(2 (cost - cost_0))` of each value: a place is as many standard errors away as noise would
/// make its cost of, and for a fit that is linear in its parameters this is no more than the standard error.
pub(super) fn room(candidate: &Candidate, places: &[Place]) -> Vec<f64> {
    let (left, cost) = (candidate.fit.error().max(1.0), candidate.fit.cost);
    let mut room = vec![0.0_f64; candidate.fit.values.len()];
    for (values, there) in places {
        let away = (2.0 * (there - cost).max(0.0) / left.powi(2)).sqrt().max(1.0);
        for (room, (value, fitted)) in room.iter_mut().zip(values.iter().zip(&candidate.fit.values)) {
            *room = room.max((value - fitted).abs() / away);
        }
    }
    room
}

/// Raises the stated standard errors to what was found to be the room of each value.
pub(super) fn widen(candidate: &mut Candidate, room: &[f64]) {
    for (p, room) in candidate.fit.parameters.iter_mut().zip(room).filter(|(p, _)| !p.fixed) {
        p.std = p.std.max(*room);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Candidate;
    use super::super::candidate::Effort;
    use super::{Place, room, widen};
    use crate::data::Data;
    use crate::fit::{self, Difference, FitOptions};
    use crate::toy::{Toy, campaign, run};
    use crate::{Campaign, Role};

    const NOISE: (f64, f64) = (0.2, 0.001);

    fn noisy() -> Campaign {
        let runs = (0..2).map(|seed| (Role::Fit, run(&[1.1, 5.0, 380.0], 800, seed, NOISE, (1.0, 0.0), 1.0)));
        campaign(runs.collect(), NOISE)
    }

    fn fitted(campaign: &Campaign) -> (Candidate, Data<'_>) {
        let data = Data::new(campaign, Some(Role::Fit), &Toy::new()).unwrap();
        let (seen, effort) = (sealegs_model::Excitation::default(), Effort::steps(20));
        (Candidate::fitted(&data, &Toy::new(), &[], &seen, &[], &effort).unwrap(), data)
    }

    #[test]
    fn room_is_the_standard_error_where_the_error_has_one_valley() {
        let campaign = noisy();
        let (candidate, data) = fitted(&campaign);
        for &i in &candidate.fit.free {
            let std = candidate.fit.parameters[i].std;
            let place = |deviations: f64| -> Place {
                let mut start = candidate.fit.values.clone();
                start[i] += deviations * std;
                let options = FitOptions {
                    start: Some(start),
                    starts: 1,
                    difference: Difference::Central,
                    held: vec![candidate.fit.parameters[i].name.clone()],
                    ..FitOptions::default()
                };
                let fit = fit::fit(&data, candidate.model.as_ref(), &options).unwrap();
                (fit.values, fit.cost)
            };
            let found = room(&candidate, &[place(-3.0), place(3.0)])[i] / std;
            assert!((found - 1.0).abs() < 0.1, "{}: {found}", candidate.fit.parameters[i].name);
        }
    }

    #[test]
    fn a_valley_that_is_nearly_as_low_widens_what_is_stated() {
        let campaign = noisy();
        let (mut candidate, _) = fitted(&campaign);
        let i = candidate.fit.free[0];
        let (value, std) = (candidate.fit.values[i], candidate.fit.parameters[i].std);
        let mut far = candidate.fit.values.clone();
        far[i] = value + 100.0 * std;
        let room = room(&candidate, &[(far, candidate.fit.cost + 0.5 * 5.0_f64.powi(2))]);
        widen(&mut candidate, &room);
        let stated = candidate.fit.parameters[i].std;
        assert!((stated - 20.0 * std).abs() < 0.5 * std, "{stated} {std}");
    }
}
