//! Measured and predicted in one figure: in time, with the residuals below, and in frequency, with the coherence below.

use super::Part;
use sealegs_model::Unit;
use sealegs_recorder::chart::{Axis, Chart, Dash, Hue, Marker};
use sealegs_recorder::report::Report;
use sealegs_sysid::Evaluation;
use sealegs_sysid::frequency::ChannelResponse;
use sealegs_sysid::frf::FrequencyResponse;

/// Least coherence at which a line of a frequency response is drawn.
const COHERENT: f64 = 0.5;

/// Fewest such lines that make a picture.
const FEWEST_LINES: usize = 3;

/// How far beyond the last such line the coherence is drawn, as a ratio.
const BEYOND: f64 = 2.0;

/// A model's name in the legend, and how it is drawn.
pub(crate) type Look = (&'static str, Hue, Dash);

/// What a model says a sensor shows, at all time stamps of a run.
pub(crate) fn shown(part: &Part, at: &Evaluation, run: usize, slot: usize) -> Option<Vec<f64>> {
    let r = &part.data.runs[run];
    let sensor = &at.sensors[r.channels[slot]];
    let bias = sensor.bias_of(run);
    Some(at.predictions[run].output(&r.names[slot])?.iter().map(|p| sensor.gain * p + bias).collect())
}

/// The run of a part on which a model fails most.
pub(crate) fn worst_run(part: &Part, at: &Evaluation) -> usize {
    let squares = |run: usize| -> f64 {
        at.blocks.iter().filter(|b| b.run == run).flat_map(|b| &b.residual).map(|r| r * r).sum()
    };
    (0..part.data.runs.len()).reduce(|a, b| if squares(b) > squares(a) { b } else { a }).unwrap_or(0)
}

/// Every channel of a run in time, and the residuals of the models below.
pub(crate) fn in_time(page: &mut Report, part: &Part, run: usize, models: &[(Look, &Evaluation)]) {
    let r = &part.data.runs[run];
    let role = r.role.as_str();
    for slot in 0..r.names.len() {
        let (name, unit) = (&r.names[slot], Unit::symbol_of(&r.names[slot]));
        let points = |v: &[f64]| r.record.time_s.iter().copied().zip(v.iter().copied()).collect::<Vec<_>>();
        let measured = r.measured[slot];
        let mut above = Chart::new(
            &format!("{name} in {} ({role})", r.record.name),
            Axis::new("time", "s"),
            Axis::new(name, unit),
        )
        .line("measured", Hue::Ink, Dash::Solid, points(measured));
        let mut below = Chart::new(
            "Residual, measured minus predicted",
            Axis::new("time", "s"),
            Axis::new("residual", unit),
        );
        for ((label, hue, dash), at) in models {
            let Some(predicted) = shown(part, at, run, slot) else { continue };
            let residual: Vec<f64> = measured.iter().zip(&predicted).map(|(m, p)| m - p).collect();
            above = above.line(label, *hue, *dash, points(&predicted));
            below = below.line(label, *hue, Dash::Solid, points(&residual));
        }
        let group = format!("{role}-{run}");
        let caption = format!(
            "{name}, measured and predicted, and what is left, in the {role} run with the greatest error."
        );
        page.figure_of(&[&above.zoomable(&group), &below.zoomable(&group).tall(200.0)], &caption);
    }
}

/// Lines of a frequency response at which it is coherent.
fn coherent(measured: &FrequencyResponse) -> Vec<usize> {
    let (hz, coherence) = (&measured.frequency_hz, &measured.coherence);
    (0..hz.len()).filter(|&i| hz[i] > 0.0 && coherence[i] > COHERENT).collect()
}

/// Whether a frequency response is coherent at enough lines to be drawn.
pub(crate) fn is_drawn(response: &ChannelResponse) -> bool {
    coherent(&response.measured).len() >= FEWEST_LINES
}

/// A channel's frequency response, where it is coherent, against those of the models.
pub(crate) fn in_frequency(
    page: &mut Report,
    response: &ChannelResponse,
    models: &[(Look, &FrequencyResponse)],
) {
    let m = &response.measured;
    let hz = &m.frequency_hz;
    let coherent = coherent(m);
    let &[first, .., last] = coherent.as_slice() else { return };
    let all: Vec<usize> =
        (0..hz.len()).filter(|&i| hz[i] >= hz[first] && hz[i] <= BEYOND * hz[last]).collect();
    let at = |lines: &[usize], v: &[f64]| lines.iter().map(|&i| (hz[i], v[i])).collect::<Vec<_>>();
    let degrees = |f: &FrequencyResponse| f.phase_rad().iter().map(|v| v.to_degrees()).collect::<Vec<_>>();
    let bounds = m.bounds_db(2.0);
    let frequency = || {
        let highest = all.last().map_or(hz[last], |&i| hz[i]);
        Axis::new("frequency", "Hz").log().range(hz[first], highest)
    };
    let title = format!("{} per {}", response.channel, response.input);
    let mut magnitude = Chart::new(&title, frequency(), Axis::new("magnitude", "dB"))
        .band(
            "95 % confidence",
            Hue::Grey,
            coherent.iter().map(|&i| (hz[i], bounds[i].0, bounds[i].1)).collect(),
        )
        .scatter("measured", Hue::Ink, Marker::Dot, at(&coherent, &m.magnitude_db()));
    let mut phase = Chart::new("Phase", frequency(), Axis::new("phase", "degrees"))
        .scatter("", Hue::Ink, Marker::Dot, at(&coherent, &degrees(m)))
        .tall(220.0);
    for ((label, hue, dash), model) in models {
        magnitude = magnitude.line(label, *hue, *dash, at(&coherent, &model.magnitude_db()));
        phase = phase.line("", *hue, *dash, at(&coherent, &degrees(model)));
    }
    let coherence = Chart::new("Coherence", frequency(), Axis::new("coherence", "").range(0.0, 1.05))
        .line("", Hue::Ink, Dash::Solid, at(&all, &m.coherence))
        .tall(170.0);
    let caption = format!(
        "{}: H1 estimates over all runs, measurement and models alike, where the coherence is above {COHERENT}.",
        response.channel
    );
    page.figure_of(&[&magnitude, &phase, &coherence], &caption);
}
