//! A comparison for a terminal.

use super::{Compared, Summary, strongest, worst_of_response};
use crate::diagnosis::bounds;
use crate::diagnosis::outcome::parameters;
use crate::diagnosis::text::{again_below, figures, parameter_lines};
use crate::report::units::with_interval;
use sealegs_model::Unit;
use sealegs_sysid::nuisance::Sensor;
use sealegs_sysid::units::channel_of;
use sealegs_sysid::{Role, residual};
use std::fmt::Write;
use std::time::Duration;

/// Ports that are listed.
const PORTS: usize = 8;

/// Runs and channels that are listed: a leg has more than a hundred.
const ERRORS: usize = 32;

/// The whole text.
#[must_use]
pub fn of(compared: &Compared, summary: &Summary, took: Duration) -> String {
    let mut out = String::new();
    let campaign = compared.campaign;
    let count = |role| campaign.runs_of(role).count();
    let _ = writeln!(
        out,
        "{}: {}, {} fit and {} holdout runs\n{}\n",
        campaign.name,
        compared.model,
        count(Role::Fit),
        count(Role::Holdout),
        compared.sentence()
    );
    let lines = bounds::lines(&summary.base.parameters);
    if !lines.is_empty() {
        let _ = writeln!(out, "{lines}");
    }
    let sanity = crate::sanity::text(&compared.sanity);
    if !sanity.is_empty() {
        let _ = writeln!(out, "{}", sanity.trim_start_matches('\n'));
    }
    let _ = writeln!(out, "Error, rms of residual over noise     as given   refitted");
    for part in &compared.parts {
        let after = part.after.as_ref().map_or_else(|| "-".to_owned(), |e| figures(e.rms, 4));
        let _ = writeln!(out, "  {:<34} {:>9}  {after:>9}", part.role.as_str(), figures(part.before.rms, 4));
    }
    if let Some(fit) = &compared.fit {
        let _ = write!(out, "\nParameters\n{}", parameter_lines(&parameters(fit)));
        for c in fit.correlations(0.95) {
            let (a, b) = (&fit.parameters[c.first].name, &fit.parameters[c.second].name);
            let _ = writeln!(out, "  {a} and {b} are hardly distinguishable (correlation {:.3})", c.value);
        }
        if fit.std_inflation > 1.5 {
            let _ = writeln!(
                out,
                "  The residual is not white: the intervals above are {} times those of white noise.",
                figures(fit.std_inflation, 2)
            );
        }
        let _ = writeln!(out, "\nSensors");
        let sensors = fit.sensors();
        let name = |s: &Sensor| channel_of(&s.channel, s.unit.as_deref()).into_owned();
        let widest = sensors.iter().map(|s| name(s).len()).max().unwrap_or(0);
        for s in sensors {
            let limit = if s.gain_at_limit { ", at its limit" } else { "" };
            let _ = writeln!(
                out,
                "  {:<widest$} gain {:.4}{limit}, bias {} {} (runs scatter by {})",
                name(s),
                s.gain,
                figures(s.bias, 3),
                Unit::symbol_of(&s.channel),
                figures(s.bias_spread, 2)
            );
        }
    }
    if let Some(units) = &summary.units {
        out.push_str(&units.text("as given", compared.fit.as_ref().map(|_| "refitted")));
    }
    if !summary.missing_signals.is_empty() {
        let _ = writeln!(out, "\nMissing at each port, rms            missing      noise  depends on");
        for m in summary.missing_signals.iter().take(PORTS) {
            let on = m.depends_on.first().map_or(String::new(), |on| {
                format!("{on} ({} of it)", crate::diagnosis::outcome::percent(m.explained))
            });
            let _ = writeln!(
                out,
                "  {:<30} {:>12} {:>10}  {on}",
                m.port,
                with_interval(m.rms, None, &m.unit),
                with_interval(m.uncertainty, None, &m.unit)
            );
        }
    }
    let mut lines: Vec<_> = compared.parts.iter().flat_map(|p| residual::table(&p.data, p.shown())).collect();
    let others = lines.len().saturating_sub(ERRORS);
    if others > 0 {
        lines.sort_by(|a, b| b.error.total_cmp(&a.error));
        lines.truncate(ERRORS);
    }
    let widest = lines.iter().map(|l| l.run.len()).max().unwrap_or(0).max(3);
    let channel = lines.iter().map(|l| l.channel.len()).max().unwrap_or(0).max(7);
    let _ = writeln!(
        out,
        "\n{:<widest$}  {:<8} {:<channel$} {:>9} {:>8}  rms",
        "Run", "role", "channel", "error", "%"
    );
    for l in lines {
        let _ = writeln!(
            out,
            "{:<widest$}  {:<8} {:<channel$} {:>9} {:>8.2}  {} {}",
            l.run,
            l.role.as_str(),
            l.channel,
            figures(l.error, 4),
            l.percent,
            figures(l.rms, 3),
            Unit::symbol_of(&l.channel)
        );
    }
    if others > 0 {
        let _ = writeln!(out, "These are the worst; {others} more are in --report and --json.");
    }
    let worst = compared.location.worst(5);
    let _ = writeln!(out, "\nWhere the residual is");
    if worst.is_empty() {
        let _ = writeln!(out, "  Spread evenly.");
    }
    for region in worst {
        let _ = writeln!(out, "  {}", region.sentence());
    }
    let found = strongest(&compared.tests);
    let _ = writeln!(out, "\nWhat it depends on");
    if found.is_empty() {
        let _ = writeln!(out, "  Nothing: it is white and independent of input, direction, angle and time.");
    }
    for t in found {
        let detail = t.detail.as_ref().map_or_else(String::new, |d| format!(", {d}"));
        let _ = writeln!(
            out,
            "  {} ({:.0} % of the squared residual{detail}): {}",
            t.on,
            100.0 * t.explained,
            t.suggests
        );
    }
    let mut first = true;
    // Of a model at the noise floor a line departs by what is noise, however coherent.
    for r in compared.responses.iter().filter(|_| !compared.is_at_floor()) {
        let Some((hz, db)) = worst_of_response(r).filter(|w| w.1.abs() > 0.2) else { continue };
        if first {
            let _ = writeln!(out, "\nIn frequency (H1, coherence above 0.8)");
            first = false;
        }
        let _ = writeln!(
            out,
            "  {} per {}: measured {db:+.1} dB from the model at {} Hz",
            r.channel,
            r.input,
            figures(hz, 3)
        );
    }
    let _ = writeln!(
        out,
        "\n{} simulations, {:.0} s of experiment in {:.2} s",
        compared.work.0,
        compared.work.1,
        took.as_secs_f64()
    );
    again_below(&mut out, &campaign.name, &compared.sentence());
    out
}
