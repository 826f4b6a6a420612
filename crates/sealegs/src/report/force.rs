//! The picture of a missing force over what it depends on, with the law that was found.

use super::units::{HALF_95, capital, multiple};
use crate::diagnosis::outcome::{ForceSaid, percent};
use sealegs_recorder::chart::{Axis, Chart, Dash, Hue, Marker};

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
            format!(" Blue: {named} at the same instants, {} of the mean square.", percent(share))
        }
        Some(_) => format!(" Blue: {named} at the same instants."),
        None => " No law is drawn: none is named.".to_owned(),
    };
    format!("{what}, averaged in bins of {} (it depends on: {}).{law}", force.over, force.depends_on)
}
