//! A comparison as one self-contained page.

use super::overlay::{self, Look, worst_run};
use super::{Compared, Summary, strongest};
use crate::diagnosis::bounds;
use crate::diagnosis::headline::{campaign_of, model_of};
use crate::diagnosis::outcome::{MissingSignal, parameters, percent};
use crate::diagnosis::text::{digits_for, figures};
use crate::notes::together;
use crate::report::units::{capital, error, with_interval};
use crate::report::{WIDE_RATIO, fails, force};
use sealegs_model::Unit;
use sealegs_recorder::chart::{Axis, Bar, BarChart, Dash, Hue, Picture};
use sealegs_recorder::report::{self, Answer, Report, Table, Tone};
use sealegs_sysid::frequency::ChannelResponse;
use sealegs_sysid::locate::Region;
use sealegs_sysid::units::channel_of;
use sealegs_sysid::{Role, residual};

/// How the two states of the model are drawn, and the one that is shown.
const AS_GIVEN: Look = ("as given", Hue::Vermillion, Dash::Dashed);
const REFITTED: Look = ("refitted", Hue::Blue, Dash::Solid);
const MODEL: Look = ("model", Hue::Blue, Dash::Solid);

/// The page: where the model fails and what is missing there first, everything else folded.
#[must_use]
pub fn of(compared: &Compared, summary: &Summary, command: &str) -> String {
    let provenance = &summary.provenance;
    let mut page = Report::new(&format!("{}: where the model fails", compared.campaign.name));
    page.wide().subtitle(&compared.model);
    screen(&mut page, compared, summary, command);
    crate::sanity::section(&mut page, &compared.sanity);
    if let Some(units) = &summary.units {
        units.section(&mut page, "as given", compared.fit.as_ref().map(|_| "refitted"));
    }
    page.section("Where the model fails");
    let models = fails::Models { before: AS_GIVEN, after: REFITTED };
    fails::map(&mut page, &compared.parts, &models);
    fails::multiples(&mut page, &compared.parts, &models);
    page.section("Details");
    if !summary.missing_signals.is_empty() {
        page.details("Missing signals at every port", |page| {
            page.table(
                &ports(&summary.missing_signals, |_| None),
                "What an observer needs at each port to follow the measured motion, and what each sensor shows beyond it, root \
                 mean square over the fit runs; the noise is what the sensors' noise alone would leave. The \
                 share is predicted on left-out blocks.",
            );
        });
    }
    place(&mut page, compared);
    depends(&mut page, compared);
    motion(&mut page, compared);
    responses(&mut page, &compared.responses);
    values(&mut page, compared);
    errors(&mut page, compared);
    remarks(&mut page, &compared.campaign.notes);
    let provenance = report::Provenance {
        command: command.to_owned(),
        versions: vec![("sealegs".to_owned(), provenance.version.to_owned())],
        inputs: provenance.inputs.iter().map(|i| (i.file.clone(), format!("sha256:{}", i.sha256))).collect(),
        seed: None,
        notes: vec![("Model".to_owned(), provenance.model.clone())],
    };
    page.details("Provenance", |page| {
        page.provenance_list(&provenance);
    });
    page.to_html()
}

/// Error over the noise floor up to which a model is at it; the sentence of a comparison draws the same line.
const AT_FLOOR: f64 = 1.1;

/// Sentences of a card.
const SENTENCES: usize = 3;

/// The first screen: the worst channel and run, what is missing where, and over what.
fn screen(page: &mut Report, compared: &Compared, summary: &Summary, command: &str) {
    let last = compared.parts.last();
    let rms = last.map_or(0.0, |p| p.shown().rms);
    let fits = rms <= AT_FLOOR * compared.floor.max(1.0);
    let lines = last.map_or_else(Vec::new, |p| residual::table(&p.data, p.shown()));
    let worst = lines.iter().max_by(|a, b| a.error.total_cmp(&b.error));
    let headline = match worst {
        Some(w) if !fits => {
            format!("The model fails most in {}, run {}: {} noise units", w.channel, w.run, error(w.error))
        }
        _ => "The model is at the noise floor".to_owned(),
    };
    let mut values: Vec<(String, String, String)> = Vec::new();
    for part in &compared.parts {
        let runs = if part.role == Role::Holdout { "held-out runs" } else { "fit runs" };
        let given = match &part.after {
            Some(_) => format!("noise units; {} as given", error(part.before.rms)),
            None => "noise units, as given".to_owned(),
        };
        values.push((runs.to_owned(), error(part.shown().rms), given));
    }
    values.push(("noise floor".to_owned(), error(compared.floor), "noise units".to_owned()));
    let felt = summary.missing_signals.iter().filter(|m| m.felt);
    let mut reasons: Vec<String> = felt.take(2).map(missing_sentence).collect();
    if reasons.is_empty() {
        reasons.push(compared.sentence());
    }
    let off = compared.fit.as_ref().map_or_else(Vec::new, parameters);
    let off: Vec<String> = off
        .iter()
        .filter(|p| p.at_bound || p.is_far())
        .take(2)
        .map(|p| format!("{}: {}.", p.name, p.remark()))
        .collect();
    let (tone, certainty) = match (fits, off.is_empty()) {
        (true, true) => (Tone::Good, "Nothing to explain"),
        (true, false) => (Tone::Caution, "At the noise floor, with odd values"),
        (false, _) => (Tone::Bad, "Something is missing"),
    };
    reasons.extend(off);
    reasons.splice(0..0, bounds::reason(&summary.base.parameters));
    let answer = Answer { headline: &headline, values: &values, certainty, reasons: &reasons };
    let bars = bars(&summary.missing_signals);
    let models = fails::Models { before: AS_GIVEN, after: REFITTED };
    // Of a model that fits nothing is missing, whatever its noise follows.
    let force = summary.missing_force.as_ref().filter(|_| !fits);
    let furthest = last.filter(|_| force.is_none()).and_then(|part| fails::worst(part, &models));
    page.first_screen(|page| {
        page.answer(tone, &answer);
        let over_noise = "Root mean square of what is missing at each port, from the observer, over what the sensors' noise alone \
                          would leave there; beside each bar its size.";
        match force {
            Some(missing) => {
                let (chart, caption) = (force::chart(missing), force::caption(missing, &[]));
                page.side_by_side(&[(&chart, &caption), (&bars, over_noise)]);
            }
            None if !bars.bars.is_empty() => {
                let measured = "Measured and the model in the channel and run where it is furthest off; above it its error in noise units.";
                let mut pictures: Vec<(&dyn Picture, &str)> = vec![(&bars, over_noise)];
                pictures.extend(furthest.as_ref().map(|chart| (chart as &dyn Picture, measured)));
                page.side_by_side(&pictures);
            }
            None => {
                page.remark("No missing force is drawn: the runs measure no motion that an observer could follow, or what is missing depends on \
                     none of the signals that were tried.");
            }
        }
        let located: Vec<String> = compared.location.worst(SENTENCES).iter().map(|r| r.sentence()).collect();
        let follows: Vec<String> = strongest(&compared.tests)
            .into_iter()
            .take(SENTENCES)
            .map(|t| format!("{} ({} of the squared residual): {}.", capital(t.on), percent(t.explained), t.suggests))
            .collect();
        let mut next = Vec::new();
        if !fits {
            next.push("Find the effect that is missing:".to_owned());
            next.push(format!("$ {}", command_of_diagnosis(command)));
        }
        let mut cards = vec![("Where the residual is", located), ("What it depends on", follows)];
        cards.push(("What to do next", next));
        cards.retain(|(_, lines)| !lines.is_empty());
        page.cards(&cards);
    });
}

/// Ports that are drawn.
const PORTS: usize = 10;

/// What is missing at each port over what noise alone would show there.
fn bars(missing: &[MissingSignal]) -> BarChart {
    let seen = missing.iter().filter(|m| m.uncertainty > 0.0).take(PORTS);
    let bars: Vec<Bar> = seen
        .map(|m| Bar {
            label: m.port.clone(),
            values: vec![m.rms / m.uncertainty],
            text: with_interval(m.rms, None, &m.unit),
        })
        .collect();
    let ratios = || bars.iter().flat_map(|b| &b.values).copied().chain([1.0]);
    let (least, most) = (ratios().fold(f64::INFINITY, f64::min), ratios().fold(0.0, f64::max));
    // A bar is as long as its value wherever a reader can still see the shortest.
    let axis = if most > WIDE_RATIO * least {
        Axis::new("missing over noise, logarithmic", "").log()
    } else {
        Axis::new("missing over noise", "")
    };
    BarChart {
        title: "Missing at each port, over what noise alone would show".to_owned(),
        axis,
        series: vec![(String::new(), Hue::Vermillion)],
        bars,
        marks: vec![(1.0, "noise".to_owned())],
        row_height: None,
    }
}

/// What is missing at a port, and what it depends on.
fn missing_sentence(m: &MissingSignal) -> String {
    let size = with_interval(m.rms, None, &m.unit);
    let noise = with_interval(m.uncertainty, None, &m.unit);
    let depends = match m.depends_on.first() {
        Some(on) => format!("it depends on {on} ({} of it on left-out blocks)", percent(m.explained)),
        None => "it depends on none of the signals that were tried".to_owned(),
    };
    format!("Missing at {}: {size} root mean square (noise alone: {noise}); {depends}.", m.port)
}

/// The command that diagnoses what a command compared.
fn command_of_diagnosis(command: &str) -> String {
    let model = model_of(command).map_or(String::new(), |model| format!(" --model {model}"));
    format!("sealegs diagnose {}{model} --report diagnose.html", campaign_of(command))
}

/// The missing signals of all ports as a table; `after` finds a port's in another model.
pub(crate) fn ports<'a>(
    signals: &[MissingSignal],
    after: impl Fn(&str) -> Option<&'a MissingSignal>,
) -> Table {
    let any = signals.iter().any(|m| after(&m.port).is_some());
    let mut table = Table::new().words("port").numbers("missing", "rms");
    if any {
        table = table.numbers("after", "rms");
    }
    table = table.numbers("noise", "rms").words("depends on").numbers("share", "");
    for m in signals {
        let mut cells = vec![m.port.clone(), with_interval(m.rms, None, &m.unit)];
        if any {
            cells.push(after(&m.port).map_or_else(String::new, |a| with_interval(a.rms, None, &a.unit)));
        }
        cells.push(with_interval(m.uncertainty, None, &m.unit));
        cells.push(m.depends_on.join(", "));
        cells.push(if m.depends_on.is_empty() { String::new() } else { percent(m.explained) });
        if m.felt {
            table.strong_row(cells)
        } else {
            table.row(cells)
        };
    }
    table
}

/// What a person should know of the files.
pub(crate) fn remarks(page: &mut Report, notes: &[String]) {
    if notes.is_empty() {
        return;
    }
    let notes = &together(notes);
    page.details(&format!("Remarks on the files ({})", notes.len()), |page| {
        page.list(notes);
    });
}

/// The regions in which the residual sits.
pub(crate) fn place(page: &mut Report, compared: &Compared) {
    let worst = compared.location.worst(5);
    let mut axes: Vec<String> = compared.location.regions.iter().map(Region::subject).collect();
    axes.dedup();
    page.details("Where the residual is", |page| {
        if worst.is_empty() {
            page.paragraph("The residual is spread evenly.");
        } else {
            page.list(&worst.iter().map(|r| r.sentence()).collect::<Vec<_>>());
        }
        for axis in axes {
            let bars = compared.location.regions.iter().filter(|r| r.subject() == axis);
            let chart = BarChart {
                title: format!("By {axis}"),
                axis: Axis::new("share", "%"),
                series: vec![
                    ("of the squared error".to_owned(), Hue::Vermillion),
                    (
                        if axis == "frequency" { "of the bandwidth" } else { "of the samples" }.to_owned(),
                        Hue::Grey,
                    ),
                ],
                bars: bars
                    .map(|r| Bar {
                        label: r.label.clone(),
                        values: vec![100.0 * r.error_share, 100.0 * r.sample_share],
                        text: format!("{} noise units", figures(r.error, 3)),
                    })
                    .collect(),
                ..BarChart::default()
            };
            page.figure(&chart, &format!("Share of the squared error and of the samples by {axis}."));
        }
    });
}

/// What the residual depends on.
pub(crate) fn depends(page: &mut Report, compared: &Compared) {
    let mut table = Table::new()
        .words("residual against")
        .numbers("explains", "%")
        .numbers("by chance", "%")
        .words("suggests");
    for t in &compared.tests {
        let on = t.detail.as_ref().map_or_else(|| t.on.to_owned(), |d| format!("{} ({d})", t.on));
        // As many meaningless signals could explain everything: such a test says nothing.
        let silent = t.by_chance >= 1.0;
        let cells = [
            on,
            figures(100.0 * t.explained.min(1.0), 2),
            if silent { "-".to_owned() } else { figures(100.0 * t.by_chance, 2) },
            match (silent, t.depends()) {
                (true, _) => "too few independent samples to tell".to_owned(),
                (_, true) => t.suggests.to_owned(),
                _ => "nothing".to_owned(),
            },
        ];
        if t.depends() && !silent {
            table.strong_row(cells)
        } else {
            table.row(cells)
        };
    }
    page.details("What the residual depends on", |page| {
        page.table(
            &table,
            "Share of the squared residual that each dependence explains, and the share that as many meaningless signals \
             would explain.",
        );
    });
}

/// Measured and predicted in time, with the residual below, for the worst run of each role.
fn motion(page: &mut Report, compared: &Compared) {
    page.details("All channels in time, in the worst run of each role", |page| {
        for part in &compared.parts {
            let mut models = vec![(AS_GIVEN, &part.before)];
            models.extend(part.after.as_ref().map(|after| (REFITTED, after)));
            overlay::in_time(page, part, worst_run(part, part.shown()), &models);
        }
    });
}

fn responses(page: &mut Report, responses: &[ChannelResponse]) {
    let drawn: Vec<_> = responses.iter().filter(|r| overlay::is_drawn(r)).collect();
    if drawn.is_empty() {
        return;
    }
    page.details("Frequency responses", |page| {
        for r in drawn {
            overlay::in_frequency(page, r, &[(MODEL, &r.predicted)]);
        }
    });
}

fn values(page: &mut Report, compared: &Compared) {
    let Some(fit) = &compared.fit else { return };
    let mut table = Table::new()
        .words("parameter")
        .numbers("value", "")
        .numbers("standard error", "")
        .words("unit")
        .numbers("nominal", "")
        .words("remark");
    for (p, v) in fit.parameters.iter().zip(parameters(fit)).filter(|(p, _)| !p.fixed) {
        table.row([
            p.name.clone(),
            figures(v.value, digits_for(v.value, p.std)),
            figures(p.std, 2),
            p.unit.clone(),
            figures(p.nominal, 6),
            v.remark(),
        ]);
    }
    let mut sensors = Table::new()
        .words("sensor")
        .numbers("gain", "")
        .numbers("bias", "")
        .words("unit")
        .numbers("runs scatter by", "");
    for s in fit.sensors() {
        let gain = if s.gain_at_limit { format!("{:.4} (limit)", s.gain) } else { format!("{:.4}", s.gain) };
        sensors.row([
            channel_of(&s.channel, s.unit.as_deref()).into_owned(),
            gain,
            figures(s.bias, 3),
            Unit::symbol_of(&s.channel).to_owned(),
            figures(s.bias_spread, 2),
        ]);
    }
    page.details("Parameters and sensors", |page| {
        page.table(&table, "The model's own parameters after the refit, SI units.");
        if fit.std_inflation > 1.5 {
            page.remark(
                "The residual is not noise. Standard errors follow from how far stretches of the runs disagree; they \
                 say how far the values would vary under the same wrong model, not how far they are from the true ones.",
            );
        }
        page.table(&sensors, "Sensors: measured = gain x true + bias.");
    });
}

fn errors(page: &mut Report, compared: &Compared) {
    // The errors come first: a narrow window shows them without scrolling.
    let mut table = Table::new()
        .words("channel")
        .numbers("error", "noise units")
        .numbers("of signal", "%")
        .numbers("rms", "")
        .words("unit")
        .words("run")
        .words("role");
    for l in compared.parts.iter().flat_map(|p| residual::table(&p.data, p.shown())) {
        table.row([
            l.channel.clone(),
            figures(l.error, 4),
            figures(l.percent, 3),
            figures(l.rms, 3),
            Unit::symbol_of(&l.channel).to_owned(),
            l.run,
            l.role.as_str().to_owned(),
        ]);
    }
    page.details("Errors of every run and channel", |page| {
        page.table(&table, "Errors of every run and channel.");
    });
}
