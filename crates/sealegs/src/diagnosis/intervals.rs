//! Intervals that are as sure as they sound: where something stays that the named model does not explain, the intervals of a
//! fit say how far the values vary under that model, not how far they are from the true ones.

use super::outcome::{Outcome, ParameterValue};

/// Held-out error over that of the named set up to which a set that holds it gives values that may as well be right: that of
/// a tie.
const AS_GOOD: f64 = 1.1;

/// Widens intervals to cover the values under conventions of the log that these runs leave open, and those of a verdict that
/// something speaks against to cover the values of other sets that hold the named effects and predict as well; withholds
/// those of the effects where a parameter of the base model ended where it should not: what drove it there has driven them.
pub(super) fn make_honest(o: &mut Outcome) {
    let stays = o.stays();
    if let Some(after) = o.after.as_mut() {
        for (name, value) in o.equally_good_choices.iter().flat_map(|other| &other.parameters) {
            widen(&mut after.parameters, name, *value);
        }
    }
    let Some(after) = o.after.as_mut().filter(|_| o.confidence.intervals_conditional) else { return };
    let own = o.ranking.iter().find(|r| r.effects == o.effects).map_or(f64::NEG_INFINITY, |r| r.evidence);
    let holds = |set: &[String]| o.effects.iter().all(|effect| set.contains(effect)) && set != o.effects;
    let as_good = o
        .ranking
        .iter()
        .filter(|r| r.holdout_error <= AS_GOOD * after.holdout_error)
        // A law beside a named one that predicts no better may only have taken a part of it.
        .filter(|r| (holds(&r.effects) && r.evidence > own) || o.indistinguishable.contains(&r.effects));
    for other in as_good.flat_map(|r| &r.parameters) {
        widen(&mut after.parameters, &other.name, other.value);
    }
    if !stays {
        return;
    }
    let of_base = |p: &ParameterValue| !p.name.contains('.');
    if after.parameters.iter().any(|p| of_base(p) && !p.fixed && (p.at_bound || p.is_far())) {
        let own = after.parameters.iter_mut().filter(|p| !p.fixed && (!of_base(p) || p.is_far()));
        own.for_each(|p| p.std = None);
    }
}

/// Makes the standard error of a parameter no less than its distance from another value; one that is withheld stays so.
fn widen(parameters: &mut [ParameterValue], name: &str, other: f64) {
    let same = parameters.iter_mut().find(|p| p.name == name && !p.fixed);
    if let Some((own, std)) = same.and_then(|own| own.std.map(|std| (own, std))) {
        own.std = Some(std.max((other - own.value).abs()));
    }
}

#[cfg(test)]
mod tests {
    use super::super::confidence::Confidence;
    use super::super::headline::set_with_values;
    use super::super::outcome::Ranked;
    use super::super::toy::{html, parameter, toy};
    use super::*;

    #[test]
    fn intervals_cover_what_as_good_sets_say_and_are_withheld_beside_a_base_model_that_went_astray() {
        let gap = |o: &Outcome| o.after.as_ref().unwrap().parameters[1].std;
        let changed = |change: &dyn Fn(&mut Outcome)| {
            let mut o = toy();
            o.ranking[0].effects.extend(o.effects.clone());
            o.ranking[0].parameters = vec![parameter("knee/backlash.gap_m", 74.96e-6, 0.2e-6, "m")];
            change(&mut o);
            o.confidence = Confidence::of(&o);
            make_honest(&mut o);
            o
        };
        let error = |o: &mut Outcome, error: f64| o.after.as_mut().unwrap().holdout_error = error;
        let at_floor = changed(&|o| o.ranking[0].holdout_error = 1.01);
        assert_eq!(gap(&at_floor), Some(0.2e-6));
        let stays = |o: &mut Outcome| {
            error(o, 1.2);
            o.ranking[0].holdout_error = 1.25;
        };
        assert!((gap(&changed(&stays)).unwrap() - 5e-6).abs() < 1e-12);
        // Beside another law that gains nothing on left-out stretches a named one may only have lost a part.
        let no_gain = changed(&|o| {
            stays(o);
            let own = Ranked { effects: o.effects.clone(), evidence: 13.0, ..o.ranking[0].clone() };
            o.ranking.push(own);
        });
        assert_eq!(gap(&no_gain), Some(0.2e-6));
        let worse = changed(&|o| {
            error(o, 1.2);
            o.ranking[0].holdout_error = 1.4;
        });
        assert_eq!(gap(&worse), Some(0.2e-6));
        let astray = changed(&|o| {
            stays(o);
            o.after.as_mut().unwrap().parameters[0].from_nominal = Some(-4.3);
        });
        assert_eq!(gap(&astray), None);
        assert!(html(&astray).contains("no interval") && set_with_values(&astray).contains("gap 80"));
    }
}
