//! A diagnosis as one self-contained page: the answer first, then where the model fails, then everything else, folded.

use super::outcome::{Outcome, OutcomeKind};
use super::story::Story;
use super::text::{digits_for, evidence, figures as number};
use super::{figures, friction, headline};
use crate::comparison::page::{depends, place, remarks};
use crate::report::fails;
use sealegs_model::Unit;
use sealegs_recorder::chart::{Axis, Bar, BarChart, Chart, Dash, Hue};
use sealegs_recorder::report::{self, Report, Table};
use sealegs_sysid::diagnose::Play;
use sealegs_sysid::residual;
use sealegs_sysid::units::channel_of;

/// Sets that the page shows of a ranking.
const RANKED: usize = 12;

/// The page.
#[must_use]
pub fn of(story: &Story) -> String {
    let outcome = story.outcome;
    let what =
        if outcome.verdict == OutcomeKind::Added { "a better model" } else { "which effect is missing" };
    let mut page = Report::new(&format!("{}: {what}", outcome.campaign));
    page.wide().subtitle(&outcome.provenance.model);
    let models = fails::Models { before: figures::BEFORE, after: figures::AFTER };
    let parts = &story.compared.parts;
    // Where the missing force is drawn, that is the picture; a channel says less.
    let draws_channel = outcome.after.is_some() && outcome.missing_force.is_none();
    let foremost = draws_channel.then(|| fails::foremost(parts, &models, &outcome.effects)).flatten();
    headline::screen(&mut page, outcome, &story.command, foremost.as_ref());
    crate::sanity::section(&mut page, &outcome.sanity);
    if let Some(units) = &outcome.units {
        units.section(&mut page, "before", outcome.after.as_ref().map(|_| "after"));
    }
    page.section("Where the model fails");
    fails::map(&mut page, parts, &models);
    fails::multiples(&mut page, parts, &models);
    page.section("Details");
    parameters(&mut page, outcome);
    ranking(&mut page, outcome);
    ports(&mut page, outcome);
    errors(&mut page, story);
    place(&mut page, &story.compared);
    depends(&mut page, &story.compared);
    figures::motion(&mut page, story);
    figures::responses(&mut page, story);
    figures::maps(&mut page, story);
    friction::curve(&mut page, story);
    figures::law(&mut page, story);
    proposed(&mut page, story);
    remarks(&mut page, &outcome.notes);
    let inputs = outcome.provenance.inputs.iter();
    let provenance = report::Provenance {
        command: story.command.clone(),
        versions: vec![("sealegs".to_owned(), outcome.provenance.version.to_owned())],
        inputs: inputs.map(|i| (i.file.clone(), format!("sha256:{}", i.sha256))).collect(),
        seed: None,
        notes: vec![
            ("Model".to_owned(), outcome.provenance.model.clone()),
            (
                "Work".to_owned(),
                format!(
                    "{} simulations of {:.0} s of experiment in all; nothing in it is random",
                    outcome.work.simulations, outcome.work.simulated_s
                ),
            ),
        ],
    };
    page.details("Provenance", |page| {
        page.provenance_list(&provenance);
    });
    page.to_html()
}

/// Errors of every run and channel, before and after.
fn errors(page: &mut Report, story: &Story) {
    let with_after = story.outcome.after.is_some();
    // The errors come first: a narrow window shows them without scrolling.
    let mut table = Table::new().words("channel").numbers("before", "noise units");
    if with_after {
        table = table.numbers("after", "noise units");
    }
    table = table.words("run").words("role");
    table = table.numbers(if with_after { "after" } else { "before" }, "% of signal");
    for part in &story.compared.parts {
        let before = residual::table(&part.data, &part.before);
        let after = part.after.as_ref().map(|a| residual::table(&part.data, a));
        for (i, line) in before.iter().enumerate() {
            let mut cells = vec![line.channel.clone(), number(line.error, 4)];
            let last = after.as_ref().map_or(line, |a| &a[i]);
            if with_after {
                cells.push(number(last.error, 4));
            }
            cells.extend([line.run.clone(), line.role.as_str().to_owned(), number(last.percent, 3)]);
            table.row(cells);
        }
    }
    page.details("Errors of every run and channel", |page| {
        page.table(
            &table,
            "Root mean square residual of every run and channel, divided by the channel's noise. Before: the base model \
             with its own parameters and the sensors refitted.",
        );
    });
}

fn ranking(page: &mut Report, o: &Outcome) {
    if o.ranking.is_empty() {
        return;
    }
    let shown = || o.ranking.iter().take(RANKED);
    let errors = || shown().map(|r| r.holdout_error).chain([o.base.holdout_error, o.noise_floor]);
    let (least, most) = (errors().fold(f64::INFINITY, f64::min), errors().fold(0.0, f64::max));
    let bar = |label: String, error: f64| Bar { label, values: vec![error], text: number(error, 3) };
    let chart = BarChart {
        title: "Error on the held-out runs with each set of effects".to_owned(),
        axis: Axis::new("error, logarithmic", "noise units").log().range(0.7 * least, 1.1 * most),
        series: vec![(String::new(), Hue::Blue)],
        bars: std::iter::once(bar("base model".to_owned(), o.base.holdout_error))
            .chain(shown().map(|r| bar(r.effects.join(" + "), r.holdout_error)))
            .collect(),
        marks: vec![(o.noise_floor, "noise floor".to_owned())],
        row_height: None,
    };
    let mut table =
        Table::new().words("effects").numbers("held-out error", "noise units").numbers("evidence", "");
    for r in shown() {
        let cells = [r.effects.join(" + "), number(r.holdout_error, 4), evidence(r.evidence)];
        if r.effects == o.effects {
            table.strong_row(cells)
        } else {
            table.row(cells)
        };
    }
    page.details("Ranking of effects", |page| {
        page.figure(&chart, "Sets of effects in the order of cross-validation on the fit runs.");
        page.table(
            &table,
            "Evidence is the log-likelihood gained over the base model on stretches of the fit runs that were \
             left out of the fit (cross-validation); 10 is already decisive. The held-out runs took no part in the order.",
        );
    });
}

fn parameters(page: &mut Report, o: &Outcome) {
    let last = o.after.as_ref().unwrap_or(&o.base);
    let mut table = Table::new().words("parameter").numbers("before", "");
    if o.after.is_some() {
        table = table.numbers("after", "");
    }
    table = table.numbers("standard error", "").words("unit").words("remark");
    for p in last.parameters.iter().filter(|p| !p.fixed) {
        let before = o.base.parameters.iter().find(|b| b.name == p.name);
        let mut cells = vec![
            p.name.clone(),
            before.map_or("-".to_owned(), |b| number(b.value, digits_for(b.value, b.std.unwrap_or(0.0)))),
        ];
        if o.after.is_some() {
            cells.push(number(p.value, digits_for(p.value, p.std.unwrap_or(0.0))));
        }
        cells.push(p.std.map_or("?".to_owned(), |s| number(s, 2)));
        cells.push(p.unit.clone());
        cells.push(p.remark());
        if p.name.contains('.') {
            table.strong_row(cells)
        } else {
            table.row(cells)
        };
    }
    let mut sensors = Table::new().words("sensor").numbers("gain", "").numbers("bias", "").words("unit");
    for s in &last.sensors {
        let unit = Unit::symbol_of(&s.channel).to_owned();
        let channel = channel_of(&s.channel, s.of_unit.as_deref()).into_owned();
        sensors.row([channel, format!("{:.4}", s.gain), number(s.bias, 3), unit]);
    }
    page.details("Parameters and sensors", |page| {
        page.table(
            &table,
            "Fitted values in SI units; those of effects stand out. The standard error is that of the last value.",
        );
        page.table(&sensors, "Sensors, measured = gain x true + bias.");
    });
}

/// The missing signals of all ports.
fn ports(page: &mut Report, o: &Outcome) {
    if o.missing_signals.is_empty() {
        return;
    }
    let after = |port: &str| o.missing_after.iter().find(|m| m.port == port);
    page.details("Missing signals at every port", |page| {
        page.table(
            &crate::comparison::page::ports(&o.missing_signals, after),
            "What an observer needs at each port to follow the measured motion, and what each sensor shows beyond it, root mean \
             square over the fit runs; the noise is what the sensors' noise alone would leave. The share is \
             predicted on left-out blocks.",
        );
    });
}

fn proposed(page: &mut Report, story: &Story) {
    let Some(Play::Input { channel, time_s, values }) = story.experiment.map(|e| &e.play) else { return };
    let unit = Unit::symbol_of(channel);
    let points = time_s.iter().copied().zip(values.iter().copied()).collect();
    let chart = Chart::new("Proposed input", Axis::new("time", "s"), Axis::new(channel, unit))
        .line("", Hue::Blue, Dash::Solid, points)
        .zoomable("plan")
        .tall(220.0);
    page.details("The proposed experiment's input", |page| {
        page.figure(&chart, "The input that was chosen; --plan writes it as a file that can be played.");
    });
}
