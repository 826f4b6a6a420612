//! Fits along changes of the units of force and length: directions in which data are all but flat by dimensional analysis.
//!
//! A machine whose forces are all so much greater, and its masses with them, moves the same, and sensors of force show it up
//! to their gain only; a length along a screw that is measured as an angle is no better known. Along these two directions
//! little but what is known beforehand tells, while the cost beside them is steep, and rough where friction sticks: a search
//! that follows derivatives stops anywhere along them. In powers of a ratio they are straight, and where what is known fits
//! best is known without a simulation.

use super::Fit;
use crate::data::Data;
use sealegs_model::Model;

/// Greatest change of a unit at once, as a logarithm: many times the tolerance of a load cell or a screw.
const FURTHEST: f64 = 0.2;

/// Times that a change is tried, and halved where it does not lower the cost.
const TRIES: usize = 6;

/// Gain of the cost that is worth a fit: one standard error of a parameter, as for [`super::FitOptions::tolerance`].
const ENOUGH: f64 = 0.5;

/// Powers of force and of length.
type Powers = [f64; 2];

/// Those in a unit such as `N s/m` or `kg m^2`, where a kilogram is `N s^2/m`.
fn powers(unit: &str) -> Powers {
    let mut sums = [0.0, 0.0];
    for (place, part) in unit.split('/').enumerate() {
        for factor in part.split_whitespace() {
            let (symbol, exponent) = factor.split_once('^').unwrap_or((factor, "1"));
            let exponent = exponent.parse().unwrap_or(0.0) * if place == 0 { 1.0 } else { -1.0 };
            let own = match symbol {
                "N" => [1.0, 0.0],
                "kg" => [1.0, -1.0],
                "m" => [0.0, 1.0],
                _ => [0.0, 0.0],
            };
            sums = [sums[0] + exponent * own[0], sums[1] + exponent * own[1]];
        }
    }
    sums
}

/// Those of a channel, by the end of its name.
fn powers_of_channel(name: &str) -> Powers {
    let ends = [("_nm", "N m"), ("_n", "N"), ("_m", "m"), ("_m_s", "m/s")];
    ends.iter().find(|(end, _)| name.ends_with(end)).map_or([0.0, 0.0], |(_, unit)| powers(unit))
}

/// A value with what is known of it: half the square of `(value - nominal) / std` is what it costs.
struct Known {
    value: f64,
    nominal: f64,
    std: f64,
    powers: Powers,
}

fn changed(value: f64, powers: Powers, change: [f64; 2]) -> f64 {
    value * (powers[0] * change[0] + powers[1] * change[1]).exp()
}

fn cost(known: &[Known], change: [f64; 2]) -> f64 {
    let one = |k: &Known| 0.5 * ((changed(k.value, k.powers, change) - k.nominal) / k.std).powi(2);
    known.iter().map(one).sum()
}

/// The change, as logarithms of the ratios, under which what is known costs least: one unit after the other, by halves.
fn best_change(known: &[Known]) -> [f64; 2] {
    let mut change = [0.0, 0.0];
    let mut step = FURTHEST;
    while step > 1e-5 {
        let mut moved = false;
        for which in 0..2 {
            for sign in [1.0, -1.0] {
                let mut there = change;
                there[which] += sign * step;
                if there[which].abs() <= FURTHEST && cost(known, there) < cost(known, change) {
                    (change, moved) = (there, true);
                }
            }
        }
        if !moved {
            step /= 2.0;
        }
    }
    change
}

/// What is known of a fit's values and sensors that changes with a unit. A gain is measured per true, so that it changes
/// the other way.
fn known(data: &Data, fit: &Fit, held: &[String]) -> Vec<Known> {
    let free = fit.parameters.iter().filter(|p| !p.fixed && !held.contains(&p.name));
    let of_values = free.filter_map(|p| {
        Some(Known { value: p.value, nominal: p.nominal, std: p.prior_std?, powers: powers(&p.unit) })
    });
    let sensors = data.channels.iter().zip(fit.sensors()).filter(|(channel, _)| channel.prior.gain_std > 0.0);
    let of_sensors = sensors.map(|(channel, sensor)| Known {
        value: sensor.gain,
        nominal: 1.0,
        std: channel.prior.gain_std,
        powers: powers_of_channel(&channel.name).map(|power| -power),
    });
    of_values.chain(of_sensors).filter(|k| k.powers != [0.0, 0.0]).collect()
}

/// A fit followed along changes of the units to where its cost is least. `refit` fits from values near a fit; parameters of
/// the names `held` stay.
pub(crate) fn along_units(
    data: &Data,
    model: &dyn Model,
    fit: Fit,
    held: &[String],
    refit: impl Fn(&Fit, Vec<f64>) -> Option<Fit>,
) -> Fit {
    let mut best = fit;
    let mut part = 1.0;
    for _ in 0..TRIES {
        let known = known(data, &best, held);
        let change = best_change(&known).map(|change| part * change);
        if cost(&known, [0.0, 0.0]) - cost(&known, change) < ENOUGH {
            break;
        }
        let moved = model.parameters().iter().zip(&best.values).map(|(p, value)| {
            let stays = p.fixed || held.contains(&p.name);
            if stays { *value } else { changed(*value, powers(&p.unit), change).clamp(p.min, p.max) }
        });
        match refit(&best, moved.collect()).filter(|other| other.cost < best.cost) {
            Some(lower) => best = lower,
            None => part *= 0.5,
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_force_and_length_in_a_unit() {
        assert_eq!(powers("N/m"), [1.0, -1.0]);
        assert_eq!(powers("kg"), [1.0, -1.0]);
        assert_eq!(powers("kg m^2"), [1.0, 1.0]);
        assert_eq!(powers("N m s/rad"), [1.0, 1.0]);
        assert_eq!(powers("N s/m"), [1.0, -1.0]);
        assert_eq!(powers("N/m^3"), [1.0, -3.0]);
        assert_eq!(powers("m/rad"), [0.0, 1.0]);
        assert_eq!(powers("N/A"), [1.0, 0.0]);
        assert_eq!(powers("Hz"), [0.0, 0.0]);
        assert_eq!(powers(""), [0.0, 0.0]);
        assert_eq!(powers_of_channel("output_torque_nm"), [1.0, 1.0]);
        assert_eq!(powers_of_channel("force_1_n"), [1.0, 0.0]);
        assert_eq!(powers_of_channel("motor_angle_rad"), [0.0, 0.0]);
    }

    #[test]
    fn a_change_of_units_goes_to_where_what_is_known_fits_best() {
        let known = |value, nominal, std, unit| Known { value, nominal, std, powers: powers(unit) };
        // A travel of 1.02 in place of 1 known to 0.1 %, and a force of 2 in place of 2.1, both exactly mended.
        let of = [known(1.02, 1.0, 0.001, "m/rad"), known(2.0, 2.1, 0.1, "N/A")];
        let change = best_change(&of);
        assert!((change[0] - (2.1_f64 / 2.0).ln()).abs() < 1e-4, "{change:?}");
        assert!((change[1] + 1.02_f64.ln()).abs() < 1e-4, "{change:?}");
        assert!(cost(&of, change) < 1e-2 && cost(&of, [0.0, 0.0]) > 200.0);
    }
}
