//! The picture of a missing force over what it depends on, with the law that was found.

use super::units::{HALF_95, capital, multiple};
use crate::diagnosis::outcome::{ForceSaid, percent};
use crate::diagnosis::text::figures;
use sealegs_recorder::chart::{Axis, Chart, Dash, Hue, Marker};

/// Bins from which a constant is told from a law that is wrong somewhere.
const FEWEST_BINS: usize = 4;

/// Departure of a bin's gap from the mean one, as a share of that, up to which the gap is a constant: beyond a quarter the two
/// curves have visibly another shape.
const ALIKE: f64 = 0.25;

/// What the missing signal of a port is called.
fn kind(force: &ForceSaid) -> &'static str {
    match force.port.contains("sensor/") {
        true => "residual",
        false if force.unit.starts_with("N m") => "missing torque",
        false => "missing force",
    }
}

/// The chart.
pub(crate) fn chart(force: &ForceSaid) -> Chart {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0f64, |m, v| m.max(v.abs()));
    let bins = || force.branches.iter();
    let (x_scale, x_unit) =
        multiple(largest(&mut bins().flat_map(|b| b.x.iter().copied())), &force.over_unit);
    let (y_scale, y_unit) = multiple(largest(&mut bins().flat_map(|b| b.y.iter().copied())), &force.unit);
    let along = match force.divided_by.as_str() {
        "1" => "",
        "direction" => " along the motion",
        "deflection" => " per deflection",
        _ => " per command",
    };
    let name = format!("{}{along}", kind(force));
    let title = format!("{} at {} over {}", capital(&name), force.port, force.over);
    let mut chart = Chart::new(&title, Axis::new(&force.over, x_unit), Axis::new(&name, y_unit));
    let ends = || {
        let all = || bins().flat_map(|b| b.x.iter().map(|x| x / x_scale));
        [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
    };
    if matches!(force.divided_by.as_str(), "1" | "direction") {
        let noise = force.noise / y_scale;
        chart = chart.band("noise of one sample", Hue::Grey, ends().map(|x| (x, -noise, noise)).to_vec());
    }
    for (i, branch) in force.branches.iter().enumerate() {
        let (hue, marker) = [(Hue::Ink, Marker::Circle), (Hue::Purple, Marker::Square)][i % 2];
        let at = |values: &[f64]| -> Vec<(f64, f64)> {
            branch.x.iter().zip(values).map(|(x, y)| (x / x_scale, y / y_scale)).collect()
        };
        let half = |k: usize| HALF_95 * branch.std[k] / y_scale;
        let points = at(&branch.y);
        let band = points.iter().enumerate().map(|(k, (x, y))| (*x, y - half(k), y + half(k))).collect();
        let label = |words: &str| {
            if branch.label.is_empty() { words.to_owned() } else { format!("{words}, {}", branch.label) }
        };
        chart = chart.band(if i == 0 { "95 % interval" } else { "" }, hue, band);
        if let Some(law) = &branch.law {
            let dash = if i == 0 { Dash::Solid } else { Dash::Dashed };
            chart = chart.line(&label("law found"), Hue::Blue, dash, at(law));
        }
        chart = chart.scatter(&label("estimate"), hue, marker, points);
    }
    chart
}

/// What the picture shows, in words; `effects` are the named ones.
pub(crate) fn caption(force: &ForceSaid, effects: &[String]) -> String {
    let what = if force.port.contains("sensor/") {
        format!("What {} shows beyond a model that follows the measured motion", force.port)
    } else {
        format!("What the model lacks at {} to follow the measured motion of the fit runs", force.port)
    };
    let named = if effects.is_empty() { "the curve".to_owned() } else { effects.join(" + ") };
    let law = match force.explained_by_law {
        Some(share) if share > 0.0 => {
            format!(" Blue: {named} at the same instants; it explains {} of the mean square.", percent(share))
        }
        Some(_) => format!(" Blue: {named} at the same instants."),
        None if effects.is_empty() => " No law is drawn: none is named.".to_owned(),
        None => format!(" No law is drawn: {named} is not a function of {} at this port.", force.over),
    };
    let constant = constant(force).map_or_else(String::new, |gap| {
        let (scale, unit) = multiple(gap, &force.unit);
        let side = if gap > 0.0 { "below" } else { "above" };
        format!(
            " The law lies {} {unit} {side} the estimates throughout: what is constant the fit with the law may put \
             elsewhere, as into a sensor's bias.",
            figures(gap.abs() / scale, 2)
        )
    });
    let on = match force.depends_on == force.over || !effects.is_empty() {
        true => String::new(),
        false => format!(" (it depends on: {})", force.depends_on),
    };
    format!("{what}, averaged in bins of {}{on}.{law}{constant}", force.over)
}

/// Estimate minus law where that is the same in all bins and clear of their intervals; positive where the law lies below.
fn constant(force: &ForceSaid) -> Option<f64> {
    if force.divided_by != "1" {
        return None;
    }
    let gaps = || {
        force.branches.iter().filter_map(|b| Some((b, b.law.as_ref()?))).flat_map(|(b, law)| {
            b.y.iter().zip(law).zip(&b.std).map(|((y, law), std)| (y - law, HALF_95 * std))
        })
    };
    let count = gaps().count();
    if count < FEWEST_BINS {
        return None;
    }
    let mean = gaps().map(|(gap, _)| gap).sum::<f64>() / count as f64;
    let clear = gaps().filter(|(gap, half)| gap.abs() > *half).count();
    let alike = gaps().all(|(gap, half)| (gap - mean).abs() <= (ALIKE * mean.abs()).max(half));
    (2 * clear > count && alike).then_some(mean)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnosis::outcome::BranchSaid;

    fn caption_of(gap: [f64; 4], divided_by: &str) -> String {
        let (y, std) = (vec![0.1, 0.4, -0.2, 0.6], vec![0.01; 4]);
        let law = y.iter().zip(gap).map(|(y, gap)| y - gap).collect();
        let bins = BranchSaid { label: String::new(), x: vec![0.0, 1.0, 2.0, 3.0], y, std, law: Some(law) };
        let force = ForceSaid {
            port: "rotor".to_owned(),
            unit: "N m".to_owned(),
            depends_on: "command".to_owned(),
            over: "command".to_owned(),
            over_unit: "A".to_owned(),
            divided_by: divided_by.to_owned(),
            noise: 0.01,
            explained_by_law: Some(0.5),
            branches: vec![bins],
        };
        caption(&force, &[])
    }

    #[test]
    fn a_constant_between_law_and_estimates_is_told_and_a_wrong_law_is_not_called_one() {
        assert!(caption_of([0.18, 0.19, 0.18, 0.17], "1").contains("0.18 N m below the estimates"));
        assert!(caption_of([-0.18; 4], "1").contains("0.18 N m above the estimates"));
        for (gap, divided_by) in [
            ([0.18, -0.18, 0.18, 0.18], "1"),
            ([0.01; 4], "1"),
            ([0.1, 0.2, 0.3, 0.4], "1"),
            ([0.18; 4], "command"),
        ] {
            assert!(!caption_of(gap, divided_by).contains("throughout"), "{gap:?} {divided_by}");
        }
    }
}
