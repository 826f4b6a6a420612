//! The error along a parameter, all others following: where it is lowest, and how far it stays as low.
//!
//! A joint that hardly moves rings for tens of periods after every impulse. How fast, its springs tell together: the sum of two
//! springs of an ankle is known to a thousandth, and each of them to some per cent. The values that ring alike lie on a
//! curve. A straight step along it leaves it at once, so that a fit rests where it came upon the curve, and the curvature of
//! the error there says nothing of how far along it the error stays as low. A mass on a thigh that hardly moves, and where
//! on it that is, are such values, too.

use super::Models;
use super::count::is_count;
use crate::diagnose::Candidate;
use crate::diagnose::candidate::Known;
use crate::diagnose::policy::{
    EFFECT_STATED, FOLLOWED, HARDLY_KNOWN, KNOWN_FROM_ZERO, NOTHING_MORE, PROFILE_HEIGHT, PROFILE_PLACES,
    PROFILE_ROUNDS, PROFILE_STEP, PROFILE_TO, PROFILE_TOLERANCE, PROFILE_WIDEST, STEPS,
};
use crate::fit::{self, Difference, FitOptions, KnownColumns};
use std::sync::Arc;

/// A set's values at a place of a profile, and their cost.
struct Place {
    cost: f64,
    values: Vec<f64>,
}

impl Models<'_> {
    /// A set fitted again from the lowest places of its profiles along the parameters that it hardly knows, as long as that
    /// leaves less, `None` where nothing does; and by the names of its parameters the standard errors that the profiles tell: of
    /// an interval that holds all values beside which the error is hardly higher than where it is lowest.
    pub(crate) fn along_profiles(&self, set: &Candidate) -> (Option<Candidate>, Known) {
        let (mut best, mut reaches) = (None, Known::new());
        for _ in 0..PROFILE_ROUNDS as usize {
            let now: &Candidate = best.as_ref().unwrap_or(set);
            let mut places = self.profiles(now);
            places.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            let Some(lowest) = places.first() else { break };
            reaches = now.named(&reaches_of(&places));
            if lowest.cost > now.fit.cost - NOTHING_MORE {
                break;
            }
            let Some(lower) = self.finished_from(now, lowest.values.clone()) else { break };
            best = Some(lower);
        }
        (best, reaches)
    }

    /// The places of a set's profiles along the parameters that it hardly knows, its own values among them; none where it
    /// knows all. What another one's profile led far away has none of its own.
    fn profiles(&self, set: &Candidate) -> Vec<Place> {
        let mut places: Vec<Place> = Vec::new();
        for index in hardly_known(set) {
            let std = set.fit.parameters[index].std;
            let far = |place: &Place| (place.values[index] - set.fit.values[index]).abs() > FOLLOWED * std;
            if !places.iter().any(far) {
                let sides = rayon::join(|| self.profile(set, index, -1.0), || self.profile(set, index, 1.0));
                places.extend(sides.0.into_iter().chain(sides.1));
            }
        }
        if !places.is_empty() {
            places.push(Place { cost: set.fit.cost, values: set.fit.values.clone() });
        }
        places
    }

    /// A set's profile along a parameter to one side: as far as that was stated, within its bounds, so many places, and until the
    /// cost is too high to fall again.
    fn profile(&self, set: &Candidate, index: usize, side: f64) -> Vec<Place> {
        let p = &set.model.parameters()[index];
        let (from, own) = (set.fit.values[index], &set.fit.parameters[index]);
        let known = p.prior_std.unwrap_or(f64::INFINITY);
        let step = side * (PROFILE_STEP * own.std).min(PROFILE_WIDEST * known);
        let values = (1..=PROFILE_PLACES as u32).map(|n| from + step * f64::from(n));
        let admitted = |v: &f64| side * (v - p.value) <= PROFILE_TO * known && (p.min..=p.max).contains(v);
        let mut places: Vec<Place> = Vec::new();
        let mut lowest = set.fit.cost;
        let (mut near, mut start) = (KnownColumns::of(&set.fit), set.fit.values.clone());
        for value in values.take_while(admitted) {
            start[index] = value;
            let mut options = self.options(set.model.as_ref(), start.clone(), set);
            options.held.push(p.name.clone());
            let options = FitOptions {
                max_steps: STEPS as usize,
                tolerance: PROFILE_TOLERANCE,
                difference: Difference::Secant,
                secants: true,
                compares: false,
                columns: Some(Arc::new(near)),
                ..options
            };
            let Ok(fit) = fit::fit(self.data, set.model.as_ref(), &options) else { break };
            near = KnownColumns::of(&fit);
            start.clone_from(&fit.values);
            let cost = fit.cost;
            places.push(Place { cost, values: fit.values });
            lowest = lowest.min(cost);
            if cost > lowest + PROFILE_HEIGHT {
                break;
            }
        }
        places
    }
}

/// The parameters that a set hardly knows better than they were stated, those first of which it knows least.
fn hardly_known(set: &Candidate) -> Vec<usize> {
    let share = |&i: &usize| {
        let p = &set.fit.parameters[i];
        let of_effect = p.name.contains('.');
        let stated = if of_effect { EFFECT_STATED * p.value.abs() } else { p.prior_std? };
        let moves = p.std > 0.0 && p.at_bound.is_none() && !is_count(&set.model.parameters()[i]);
        (moves && p.std > HARDLY_KNOWN * stated).then_some((i, p.std / stated))
    };
    let mut all: Vec<(usize, f64)> = set.fit.free.iter().filter_map(share).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all.into_iter().map(|(i, _)| i).collect()
}

/// Standard errors of all values by the places of profiles, the lowest one first: 95 % of a normal distribution lie as far from its
/// middle as the places reach that cost no more than its values there do.
fn reaches_of(places: &[Place]) -> Vec<f64> {
    let lowest = &places[0];
    let most = lowest.cost + 0.5 * KNOWN_FROM_ZERO.powi(2);
    let as_low = || places.iter().take_while(|place| place.cost <= most);
    let reach = |i: usize| {
        let off = as_low().map(|place| (place.values[i] - lowest.values[i]).abs());
        off.fold(0.0, f64::max) / KNOWN_FROM_ZERO
    };
    (0..lowest.values.len()).map(reach).collect()
}

#[cfg(test)]
mod tests {
    use super::{Place, reaches_of};
    use crate::Role;
    use crate::data::Data;
    use crate::diagnose::{Candidate, Models};
    use crate::fit::{Difference, at_values};
    use crate::toy::{Toy, campaign, run};
    use sealegs_model::{EffectCard, Excitation, Model, ModelError, Parameter, Prediction, Record};

    /// The toy with two springs whose product alone tells how it rings.
    #[derive(Debug, Clone)]
    struct TwoSprings {
        toy: Toy,
        parameters: Vec<Parameter>,
    }

    impl TwoSprings {
        fn new(known: f64) -> Self {
            let toy = Toy::new();
            let mut parameters = toy.parameters.clone();
            let spring = Parameter { prior_std: Some(known), ..toy.parameters[2].clone() };
            parameters[2] = Parameter { name: "spring".to_owned(), ..spring.clone() };
            parameters.push(Parameter { name: "other-spring".to_owned(), ..spring });
            Self { toy, parameters }
        }
    }

    impl Model for TwoSprings {
        fn name(&self) -> String {
            "two springs".into()
        }
        fn parameters(&self) -> &[Parameter] {
            &self.parameters
        }
        fn inputs(&self) -> &[&'static str] {
            self.toy.inputs()
        }
        fn predicts(&self, channel: &str) -> bool {
            self.toy.predicts(channel)
        }
        fn included(&self) -> Vec<String> {
            Vec::new()
        }
        fn effects(&self, _: &Excitation) -> Vec<EffectCard> {
            Vec::new()
        }
        fn with_effect(&self, id: &str, _: &Excitation) -> Result<Box<dyn Model>, ModelError> {
            Err(ModelError::UnknownEffect { id: id.into(), suggestion: None })
        }
        fn predict(&self, v: &[f64], of: &Record, channels: &[String]) -> Result<Prediction, ModelError> {
            self.toy.predict(&[v[0], v[1], v[2] * v[3] / 400.0], of, channels)
        }
        fn clone_box(&self) -> Box<dyn Model> {
            Box::new(self.clone())
        }
    }

    #[test]
    fn a_fit_that_rests_beside_the_minimum_is_led_along_the_curve_and_its_interval_reaches_as_far() {
        let noise = (0.2, 0.001);
        let known = 100.0;
        let model = TwoSprings::new(known);
        let campaign =
            campaign(vec![(Role::Fit, run(&[1.0, 4.0, 400.0], 800, 3, noise, (1.0, 0.0), 1.0))], noise);
        let data = Data::new(&campaign, Some(Role::Fit), &model).expect("a fit run");
        let models = Models::new(&data, &model);
        let at = |spring: f64| {
            let values = [1.0, 4.0, spring, 160_000.0 / spring];
            let fit = at_values(&data, &model, &values, Difference::Central).expect("a simulation");
            Candidate::exactly(&data, Vec::new(), model.clone_box(), fit)
        };
        let off = at(560.0);
        let (found, reaches) = models.along_profiles(&off);
        let found = found.expect("a lower place");
        // What is stated of the springs alone tells them apart.
        assert!((found.fit.values[2] - 400.0).abs() < 0.25 * known, "{}", found.fit.values[2]);
        assert!(off.fit.cost - found.fit.cost > 1.5, "{} {}", off.fit.cost, found.fit.cost);
        // Two equal statements of one number halve its variance; the places are half of one of them apart.
        for name in ["spring", "other-spring"] {
            let (_, reach) = reaches.iter().find(|(n, _)| n == name).expect("a reach");
            assert!((0.5..1.2).contains(&(reach / known)), "{name} {reach}");
        }
    }

    #[test]
    fn a_reach_holds_what_is_as_low_and_nothing_beyond() {
        let place = |cost: f64, values: [f64; 2]| Place { cost, values: values.to_vec() };
        let places = [
            place(100.0, [1.0, 5.0]),
            place(101.0, [0.02, 5.49]),
            place(101.9, [2.96, 5.0]),
            place(102.0, [9.0, 9.0]),
        ];
        let reaches = reaches_of(&places);
        assert!((reaches[0] - 1.0).abs() < 1e-12 && (reaches[1] - 0.25).abs() < 1e-12, "{reaches:?}");
    }
}
