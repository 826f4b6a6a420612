//! A diagnosis as one self-contained page, from the verdict down to where everything came from.

use super::outcome::{Outcome, percent};
use super::story::Story;
use super::text::{another_name, digits_for, evidence, figures as number, other_conventions};
use super::{figures, friction};
use crate::comparison::page::{depends, place, remarks};
use sealegs_recorder::chart::{Axis, Bar, BarChart, Chart, Dash, Hue};
use sealegs_recorder::report::{self, Report, Table, Tone};
use sealegs_sysid::diagnose::Play;
use sealegs_sysid::residual;

/// Sets that the page shows of a ranking.
const RANKED: usize = 12;

/// The page.
#[must_use]
pub fn of(story: &Story) -> String {
    let outcome = story.outcome;
    let what = if outcome.verdict == "added" { "a better model" } else { "which effect is missing" };
    let mut page = Report::new(&format!("{}: {what}", outcome.campaign));
    page.subtitle(&outcome.provenance.model);
    verdict(&mut page, outcome);
    crate::sanity::section(&mut page, &outcome.sanity);
    errors(&mut page, story);
    place(&mut page, &story.compared);
    depends(&mut page, &story.compared);
    ranking(&mut page, outcome);
    parameters(&mut page, outcome);
    figures::motion(&mut page, story);
    figures::responses(&mut page, story);
    figures::maps(&mut page, story);
    friction::curve(&mut page, story);
    figures::law(&mut page, story);
    if outcome.verdict != "added" {
        ambiguity(&mut page, outcome);
    }
    next(&mut page, story);
    remarks(&mut page, &outcome.notes);
    let inputs = outcome.provenance.inputs.iter();
    page.provenance(&report::Provenance {
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
    });
    page.to_html()
}

fn verdict(page: &mut Report, o: &Outcome) {
    let tone = match o.verdict {
        "adequate" => Tone::Good,
        "missing-effect" if o.indistinguishable.is_empty() => Tone::Good,
        "missing-effect" | "partly-explained" => Tone::Caution,
        "unexplained" => Tone::Bad,
        _ => Tone::Neutral,
    };
    let mut support = o.remainder.clone();
    if !o.indistinguishable.is_empty() {
        let sets: Vec<String> = o.indistinguishable.iter().map(|s| s.join(" + ")).collect();
        support.push(format!("These data cannot tell it from {}.", sets.join(", nor from ")));
    }
    page.verdict(tone, &o.sentence, &support.join(" "));
}

fn errors(page: &mut Report, story: &Story) {
    let o = story.outcome;
    page.section("Error before and after");
    let before = number(o.base.holdout_error, 3);
    let after = o.after.as_ref().map_or("-".to_owned(), |a| number(a.holdout_error, 3));
    let left = percent(o.unexplained_share).replace("less than", "<");
    let floor = number(o.noise_floor, 3);
    let mut boxes = vec![("before, held-out runs", before.as_str(), "noise units")];
    if o.after.is_some() {
        boxes.push(("after, held-out runs", &after, "noise units"));
        boxes.push(("left of the energy above the floor", &left, "on held-out runs"));
    }
    boxes.push(("noise floor", &floor, "noise units"));
    page.numbers(&boxes);
    let with_after = o.after.is_some();
    let mut table = Table::new().words("run").words("role").words("channel").numbers("before", "noise units");
    if with_after {
        table = table.numbers("after", "noise units");
    }
    table = table.numbers(if with_after { "after" } else { "before" }, "% of signal");
    for part in &story.compared.parts {
        let before = residual::table(&part.data, &part.before);
        let after = part.after.as_ref().map(|a| residual::table(&part.data, a));
        for (i, line) in before.iter().enumerate() {
            let mut cells = vec![
                line.run.clone(),
                line.role.as_str().to_owned(),
                line.channel.clone(),
                number(line.error, 4),
            ];
            let last = after.as_ref().map_or(line, |a| &a[i]);
            if with_after {
                cells.push(number(last.error, 4));
            }
            cells.push(number(last.percent, 3));
            table.row(cells);
        }
    }
    page.table(
        &table,
        "Root mean square residual of every run and channel, divided by the channel's noise. Before: the base model with \
         its own parameters and the sensors refitted.",
    );
}

fn ranking(page: &mut Report, o: &Outcome) {
    if o.ranking.is_empty() {
        return;
    }
    page.section("Ranking of effects");
    let shown = || o.ranking.iter().take(RANKED);
    let chart = BarChart {
        title: "Error on the held-out runs with each set of effects".to_owned(),
        axis: Axis::new("error", "noise units"),
        series: vec![(String::new(), Hue::Blue)],
        bars: std::iter::once(Bar {
            label: "base model".to_owned(),
            values: vec![o.base.holdout_error],
            text: number(o.base.holdout_error, 3),
        })
        .chain(shown().map(|r| Bar {
            label: r.effects.join(" + "),
            // A set that makes it much worse would squeeze all others.
            values: vec![r.holdout_error.min(1.5 * o.base.holdout_error)],
            text: number(r.holdout_error, 3),
        }))
        .collect(),
    };
    page.figure(&chart, "Sets in the order of how they predict left-out stretches of the fit runs.");
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
    page.table(
        &table,
        "Evidence is the log-likelihood gained over the base model on stretches of the fit runs that were left out of \
         the fit; 10 is already decisive. The held-out runs took no part in the order.",
    );
}

fn parameters(page: &mut Report, o: &Outcome) {
    page.section("Parameters");
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
    page.table(
        &table,
        "Fitted values; those of effects stand out. The standard error is that of the last value.",
    );
    let mut table = Table::new().words("sensor").numbers("gain", "").numbers("bias", "").words("unit");
    for s in &last.sensors {
        let unit = crate::comparison::text::unit(&s.channel).to_owned();
        table.row([s.channel.clone(), format!("{:.4}", s.gain), number(s.bias, 3), unit]);
    }
    page.table(&table, "Sensors, measured = gain x true + bias.");
}

fn ambiguity(page: &mut Report, o: &Outcome) {
    page.section("Ambiguity");
    if o.effects.is_empty() {
        page.paragraph("No effect is named, so that there is nothing to confuse it with.");
    } else if o.indistinguishable.is_empty() {
        page.paragraph("These data tell what is named from every other set of no more effects.");
    } else {
        page.paragraph("On these data the following sets predict as well as the one that is named:");
        page.list(&o.indistinguishable.iter().map(|s| s.join(" + ")).collect::<Vec<_>>());
    }
    for sentence in another_name(o).into_iter().chain(other_conventions(o)) {
        page.paragraph(&sentence);
    }
}

fn next(page: &mut Report, story: &Story) {
    if story.outcome.next_experiment.is_empty() {
        return;
    }
    page.section("Next experiment");
    page.paragraph(&story.outcome.next_experiment);
    if let Some(Play::Input { channel, time_s, values }) = story.experiment.map(|e| &e.play) {
        let unit = crate::comparison::text::unit(channel);
        let points = time_s.iter().copied().zip(values.iter().copied()).collect();
        let chart = Chart::new("Proposed input", Axis::new("time", "s"), Axis::new(channel, unit))
            .line("", Hue::Blue, Dash::Solid, points)
            .zoomable("plan")
            .tall(220.0);
        page.figure(&chart, "The input that was chosen; --plan writes it as a file that can be played.");
    }
}
