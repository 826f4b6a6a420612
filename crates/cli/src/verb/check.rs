//! `sealegs check`: what a campaign holds and what it can identify, before any fit.

use crate::failure::OrBadInput;
use crate::kind;
use crate::output::Destination;
use crate::progress;
use clap::Args;
use sealegs::campaign_model;
use sealegs::diagnosis::text::figures;
use sealegs::model::Unit;
use sealegs::sysid::Campaign;
use sealegs::sysid::campaign::NoiseOrigin;
use sealegs::sysid::check::{self, Check, EffectCheck};
use sealegs::sysid::sanity::{self, Finding};
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

/// What ends a channel's name that is at no limit where it stays at its extreme: what changes slowly, a goal that pauses, a switch.
const SLOW_OR_GOALS: [&str; 4] = ["temperature_c", "supply_v", "position_rad", "enable"];

/// Check a campaign: signs, units and columns, clocks, gaps, saturation, noise, excitation, and what it can identify
#[derive(Args)]
pub struct CheckArguments {
    /// The campaign's folder, or its campaign.toml
    campaign: PathBuf,
    /// An actuator file in place of the campaign's own actuator, or a scenario file for a leg
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// Write the result as JSON (`-` for standard output)
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
}

/// Runs the verb.
///
/// # Errors
///
/// Bad input for a campaign or model file with an error in it; otherwise if the model cannot be simulated.
pub fn run(arguments: &CheckArguments) -> anyhow::Result<u8> {
    let mut campaign = kind::campaign(&arguments.campaign)?;
    let model = campaign_model::of_campaign(&mut campaign, arguments.model.as_deref())?;
    campaign.notes.extend(campaign.check_against(model.as_ref()).or_bad_input()?);
    let json = Destination::optional(arguments.json.as_ref())?;
    let wrong = sanity::look(&campaign, model.as_ref());
    campaign.notes.extend(sealegs::sanity::drift_advice(&campaign, model.as_ref()));
    let shown = arguments.json.as_deref() != Some(Path::new("-"));
    if shown {
        // What is wrong with the log comes before the long work.
        let mut out = std::io::stdout().lock();
        write!(out, "{}", head(&campaign, &model.name(), &wrong))?;
        out.flush()?;
    }
    let bar = progress::spinner();
    let found = check::check_telling(&campaign, model.as_ref(), &progress::on(&bar));
    bar.finish();
    let found = found?;
    if let Some(destination) = json {
        let value = to_json(&campaign, &model.name(), &found, &wrong);
        destination.write((serde_json::to_string_pretty(&value)? + "\n").as_bytes())?;
    }
    if shown {
        let rotary = model.rotary_places().iter().any(String::is_empty);
        write!(std::io::stdout().lock(), "{}", text(&campaign, rotary, &found, &wrong))?;
    }
    Ok(0)
}

fn origin(origin: NoiseOrigin) -> &'static str {
    match origin {
        NoiseOrigin::Stated => "stated",
        NoiseOrigin::Differences => "estimated from differences of neighbouring samples",
        NoiseOrigin::Quantum => "estimated from the sensor's quantum",
    }
}

/// The strength at which an effect was tried: `force_n = 30.0 N`.
fn strength(effect: &EffectCheck) -> String {
    let said = |(name, value, unit): &(String, f64, String)| {
        format!("{name} = {} {unit}", figures(*value, 3)).trim_end().to_owned()
    };
    effect.at.iter().map(said).collect::<Vec<_>>().join(", ")
}

/// What is wrong with the log, before anything is judged.
fn head(campaign: &Campaign, model: &str, wrong: &[Finding]) -> String {
    let wrong = sealegs::sanity::text(wrong);
    format!("{}: {model}, {} runs\n{wrong}", campaign.name, campaign.runs.len())
}

/// Everything else.
fn text(campaign: &Campaign, rotary: bool, found: &Check, wrong: &[Finding]) -> String {
    let mut out = String::new();
    let widest = campaign.runs.iter().map(|r| r.record.name.len()).max().unwrap_or(0).max(3);
    let _ = writeln!(
        out,
        "\n{:<widest$}  {:<8} {:>7} {:>8} {:>9} {:>8} {:>5} {:>15} {:>9} {:>9} {:>7} {:>6}",
        "Run",
        "role",
        "rows",
        "time, s",
        "rate, Hz",
        "jitter",
        "gaps",
        "band, Hz",
        "speed",
        "load",
        "turns",
        "revers"
    );
    for (run, e) in campaign.runs.iter().zip(&found.excited) {
        let band =
            e.band_hz.map_or_else(|| "-".into(), |(a, b)| format!("{} - {}", figures(a, 2), figures(b, 2)));
        let number = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| figures(v, 3));
        let _ = writeln!(
            out,
            "{:<widest$}  {:<8} {:>7} {:>8.2} {:>9.2} {:>6.1} % {:>5} {band:>15} {:>9} {:>9} {:>7} {:>6}",
            run.record.name,
            run.role.as_str(),
            run.record.len(),
            run.clock.duration_s,
            run.clock.rate_hz(),
            100.0 * run.clock.jitter_s / run.clock.period_s,
            run.clock.gaps.len(),
            number(e.speed_peak),
            number(e.load_peak),
            number(e.rotor_turns),
            e.reversals
        );
    }
    // A robot has a speed and a load at every joint, and none of its own.
    let of = match (found.excited.iter().any(|e| e.speed_peak.is_some()), rotary) {
        (false, _) => "The",
        (true, true) => "Speed and load are the nominal model's, in rad/s and N m; the",
        (true, false) => "Speed and load are the nominal model's, in m/s and N; the",
    };
    let _ = writeln!(out, "{of} band holds the middle 90 % of the input's power.");
    let _ = writeln!(out, "\nNoise, one standard deviation");
    for n in &campaign.noise {
        let unit = Unit::symbol_of(&n.channel);
        let quantum = n.quantum.map_or_else(String::new, |q| format!(", quantum {} {unit}", figures(q, 3)));
        let seen = if n.origin == NoiseOrigin::Stated {
            format!("; {} {unit} seen in neighbouring samples", figures(n.from_differences, 2))
        } else {
            String::new()
        };
        let _ = writeln!(
            out,
            "  {:<22} {} {unit}, {}{seen}{quantum}",
            n.channel,
            figures(n.std, 3),
            origin(n.origin)
        );
    }
    if !campaign.repeats.is_empty() {
        let _ = writeln!(out, "\nRepeats: what runs with the same input leave between them");
        for r in &campaign.repeats {
            let noise = campaign.noise_std(&r.channel).map_or(1.0, |n| n.std);
            let _ = writeln!(
                out,
                "  {} and {}, {}: {} {} each ({} noise units), offset {}",
                campaign.runs[r.runs.0].record.name,
                campaign.runs[r.runs.1].record.name,
                r.channel,
                figures(r.deviation, 2),
                Unit::symbol_of(&r.channel),
                figures(r.deviation / noise, 2),
                figures(r.offset, 2)
            );
        }
    }
    // A goal that pauses at its extreme, or what changes slowly, is at no limit.
    let has_limit = |channel: &str| !SLOW_OR_GOALS.iter().any(|of| channel.ends_with(of));
    let saturated: Vec<_> =
        found.columns.iter().filter(|c| c.saturated_share > 0.01 && has_limit(&c.channel)).collect();
    if !saturated.is_empty() {
        let _ = writeln!(out, "\nAt a limit, perhaps (stretches of equal samples on the extreme value)");
        for c in saturated {
            let _ = writeln!(
                out,
                "  {}: {} for {:.1} % of the samples, between {} and {} {}",
                c.run,
                c.channel,
                100.0 * c.saturated_share,
                figures(c.range.0, 4),
                figures(c.range.1, 4),
                Unit::symbol_of(&c.channel)
            );
        }
    }
    if let Some(seconds) = found.judged_on_first_s {
        let _ = writeln!(
            out,
            "\nThis model is expensive to simulate: parameters and effects are judged on the first {seconds:.0} s of each fit run. \
             What they show is there; the rest of the runs may show more."
        );
    }
    let _ = writeln!(out, "\nParameters: standard error that the fit runs allow, if the model were right");
    for p in &found.parameters {
        let prior = p.prior_std.map_or_else(|| "unknown".to_owned(), |s| figures(s, 2));
        let _ = writeln!(
            out,
            "  {:<22} {:>12} ± {:<10} {:<8} prior: {prior}{}",
            p.name,
            figures(p.value, 5),
            figures(p.std, 2),
            p.unit,
            if p.identifiable { "" } else { "  (these runs add nothing)" }
        );
    }
    for (a, b, value) in &found.correlated {
        let _ = writeln!(out, "  {a} and {b} would hardly be distinguishable (correlation {value:.3})");
    }
    let _ = writeln!(
        out,
        "\nEffects: how visible each would be at the strength given, beyond what parameters imitate"
    );
    for e in &found.effects {
        let visible = e
            .visible
            .map_or_else(|| "cannot be simulated".to_owned(), |v| format!("{} noise units", figures(v, 3)));
        let judgement = if e.identifiable() { "" } else { "  not identifiable" };
        let alike = if e.alike.is_empty() {
            String::new()
        } else {
            format!("  indistinguishable from {}", e.alike.join(", "))
        };
        let _ = writeln!(out, "  {:<34} {visible:>24}{judgement}{alike}  ({})", e.id, strength(e));
    }
    if !campaign.notes.is_empty() {
        let _ = writeln!(out, "\nRemarks");
        for note in sealegs::notes::together(&campaign.notes) {
            let _ = writeln!(out, "  {note}");
        }
    }
    let _ = writeln!(out, "\n{}", answer(campaign, found, wrong));
    out
}

/// What all of it comes to, in two sentences at most: it stands below a long list.
fn answer(campaign: &Campaign, found: &Check, wrong: &[Finding]) -> String {
    let faults = match (wrong.len(), wrong.iter().filter(|f| f.stops()).count()) {
        (0, _) => "no fault found in the log".to_owned(),
        (all, 0) => format!("{all} remark(s) on the log, above"),
        (all, stops) => format!("{all} fault(s) found in the log, above; {stops} stop a diagnosis"),
    };
    let hidden: Vec<&str> =
        found.effects.iter().filter(|e| !e.identifiable()).map(|e| e.id.as_str()).collect();
    let seen = match hidden.len() {
        0 => "Every effect would show at the strength given.".to_owned(),
        _ => format!("These runs would not show {}.", hidden.join(", ")),
    };
    format!("{}: {faults}. {seen}", campaign.name)
}

fn to_json(campaign: &Campaign, model: &str, found: &Check, wrong: &[Finding]) -> serde_json::Value {
    use serde_json::json;
    let runs: Vec<_> = campaign
        .runs
        .iter()
        .zip(&found.excited)
        .map(|(run, e)| {
            json!({
                "file": run.record.name, "role": run.role.as_str(), "rows": run.record.len(),
                "scored_rows": run.counted().iter().map(std::ops::Range::len).sum::<usize>(),
                "clock": {
                    "duration_s": run.clock.duration_s, "period_s": run.clock.period_s,
                    "jitter_s": run.clock.jitter_s, "longest_s": run.clock.longest_s,
                    "rate_deviation": run.clock.rate_deviation,
                    "gaps": run.clock.gaps.iter()
                        .map(|g| json!({ "from_s": g.from_s, "length_s": g.length_s })).collect::<Vec<_>>(),
                },
                "unknown_columns": run.unknown.iter().map(|s| s.channel.clone()).collect::<Vec<_>>(),
                "excited": {
                    "input": e.input, "input_peak": e.input_peak, "input_rms": e.input_rms,
                    "band_hz": e.band_hz, "speed_peak": e.speed_peak, "standing_share": e.standing_share,
                    "load_peak": e.load_peak, "reversals": e.reversals, "rotor_turns": e.rotor_turns,
                    "quiet_rows": e.quiet_rows,
                },
            })
        })
        .collect();
    let name = |i: usize| campaign.runs[i].record.name.clone();
    json!({
        "campaign": campaign.name,
        "model": model,
        "sanity": wrong,
        "runs": runs,
        "columns": found.columns.iter().map(|c| json!({
            "run": c.run, "channel": c.channel, "min": c.range.0, "max": c.range.1, "rms": c.rms,
            "quantum": c.quantum, "saturated_share": c.saturated_share,
        })).collect::<Vec<_>>(),
        "noise": campaign.noise.iter().map(|n| json!({
            "channel": n.channel, "std": n.std, "origin": origin(n.origin),
            "from_differences": n.from_differences, "quantum": n.quantum,
        })).collect::<Vec<_>>(),
        "repeats": campaign.repeats.iter().map(|r| json!({
            "runs": [name(r.runs.0), name(r.runs.1)], "channel": r.channel, "deviation": r.deviation,
            "offset": r.offset,
        })).collect::<Vec<_>>(),
        "parameters": found.parameters.iter().map(|p| json!({
            "name": p.name, "value": p.value, "std": p.std, "unit": p.unit, "prior_std": p.prior_std,
            "identifiable": p.identifiable,
        })).collect::<Vec<_>>(),
        "judged_on_first_s": found.judged_on_first_s,
        "correlated": found.correlated,
        "effects": found.effects.iter().map(|e| json!({
            "id": e.id, "at": strength(e), "visible": e.visible, "imitated_share": e.imitated_share,
            "identifiable": e.identifiable(), "alike": e.alike,
        })).collect::<Vec<_>>(),
        "notes": campaign.notes,
    })
}
